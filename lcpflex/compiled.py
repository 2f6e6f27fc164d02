"""The one decorator under which every numerical kernel is compiled.

A kernel is a function of arrays and scalars in the subset of Python that numba compiles. It is
compiled at its first call and kept in a cache on disk. The cache of numba is keyed by the source file
of the function alone, so a change in another file that a kernel calls would go unseen; here the key is
the content of that file and of all that it imports from the package, and an upgrade never runs stale code.
"""

from __future__ import annotations

import hashlib
import re
import sys
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

ROOT = Path(__file__).resolve().parent

_announced = False


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


def _announce() -> None:
    """Say once per process what the first call waits for."""
    global _announced
    if not _announced:
        _announced = True
        print(
            "lcpflex: compiling its kernels for this machine (once; some tens of seconds, "
            "`lcpflex warmup` does all of them ahead of time) ...",
            file=sys.stderr,
            flush=True,
        )


def _source_of(function: Callable[..., Any]) -> Path:
    """The file of a function's module, found by its name: ``lcpflex/solvers`` is a link."""
    return ROOT.joinpath(*function.__module__.split(".")[1:]).with_suffix(".py")


def _package_cache(function: Callable[..., Any]) -> Any:
    """Numba's on-disk cache of one function, stamped with all the sources it depends on."""
    from numba.core.caching import FunctionCache

    class PackageCache(FunctionCache):  # type: ignore[misc]
        def __init__(self, py_func: Callable[..., Any]) -> None:
            super().__init__(py_func)
            self._cache_file._source_stamp = _stamp(_source_of(py_func))

        def load_overload(self, sig: Any, target_context: Any) -> Any:
            try:
                loaded = super().load_overload(sig, target_context)
            except Exception:  # an index that names types of a module gone since, or is damaged: start it anew
                self._cache_file.flush()
                loaded = None
            if loaded is None:
                _announce()
            return loaded

    return PackageCache(function)


def kernel(function: F) -> F:
    """Compile ``function`` with numba at its first call (``nopython``, cached on disk, no fastmath).

    Numbers divided by zero are inf or NaN, as in numpy: a branch for each division would keep loops from being
    vectorised, and what is not finite is judged once, where a result is. The plain Python source stays reachable as
    ``function.py_func``.
    """
    import numba

    dispatcher = numba.njit(_nrt=False, error_model="numpy", no_cfunc_wrapper=True)(function)
    try:
        dispatcher._cache = _package_cache(function)
    except (
        AttributeError,
        OSError,
        RuntimeError,
    ):  # other numba internals, no folder for a cache, a kernel of a user's
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
