"""The one decorator under which every numerical kernel is compiled.

A kernel is a function of arrays and scalars in the subset of Python that numba compiles. It is
compiled at its first call and kept on disk (:mod:`lcpflex.jit.cache`). The cache of numba is keyed by the source
file of the function alone, so a change in another file that a kernel calls would go unseen; here the key is
the content of that file and of all that it imports from the package, and an upgrade never runs stale code.
"""

from __future__ import annotations

import hashlib
import re
import types
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, TypeVar, cast

import numpy as np
import numpy.typing as npt

__all__ = ["FloatArray", "IntArray", "interpreted", "kernel"]

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]
F = TypeVar("F", bound=Callable[..., Any])

ROOT = Path(__file__).resolve().parents[1]  # the package


@cache
def _imports(path: Path) -> tuple[Path, ...]:
    """The source files of the package that the one at ``path`` names in its imports."""
    names = re.findall(r"^\s*from (lcpflex[\w.]*) import", path.read_text(encoding="utf-8"), re.MULTILINE)
    files = (ROOT.joinpath(*name.split(".")[1:]).with_suffix(".py") for name in names)
    return tuple(file for file in files if file.is_file())


@cache
def _stamp(path: Path) -> str:
    """Hash of all the sources that a kernel in the file at ``path`` can depend on."""
    sources, waiting = set(), [path]
    while waiting:
        source = waiting.pop()
        if source not in sources:
            sources.add(source)
            waiting.extend(_imports(source))
    digest = hashlib.sha256()
    for source in sorted(sources):
        digest.update(source.read_bytes())
    return digest.hexdigest()


def _source_of(function: Callable[..., Any]) -> Path | None:
    """The file of a function's module, found by its name: ``lcpflex/solvers`` is a link. None for a user's kernel."""
    package, *names = function.__module__.split(".")
    source = ROOT.joinpath(*names).with_suffix(".py")
    return source if package == ROOT.name and names and source.is_file() else None


def kernel(function: F) -> F:
    """Compile ``function`` with numba at its first call (``nopython``, cached on disk, no fastmath).

    Numbers divided by zero are inf or NaN, as in numpy: a branch for each division would keep loops from being
    vectorised, and what is not finite is judged once, where a result is. The plain Python source stays reachable as
    ``function.py_func``.
    """
    import numba

    dispatcher = numba.njit(_nrt=False, error_model="numpy", no_cfunc_wrapper=True)(function)
    source = _source_of(function)
    if source is not None and not numba.config.DISABLE_JIT:
        try:
            import lcpflex.jit.cache  # so written, it is not among the sources that kernels depend on

            lcpflex.jit.cache.attach(dispatcher, function, lambda: _stamp(source))
        except (ImportError, AttributeError):  # another numba inside
            pass
    return cast(F, dispatcher)


def interpreted(compiled: F, **replacements: Any) -> F:
    """The same function as plain Python with a scope of its own, some of the functions it calls replaced.

    A driver is written once: compiled, it runs whole chunks of steps without Python; interpreted,
    its loop is Python and any function it calls (a solver, a callback, the mechanics of a
    user's own system) can be any Python callable.
    """
    source = getattr(compiled, "py_func", compiled)  # the function itself where numba is told not to compile
    scope = {**source.__globals__, **replacements}
    clone = types.FunctionType(source.__code__, scope, source.__name__, source.__defaults__, source.__closure__)
    clone.__kwdefaults__ = source.__kwdefaults__
    return cast(F, clone)
