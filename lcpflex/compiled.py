"""The one decorator under which every numerical kernel is compiled.

A kernel is a function of arrays and scalars in the subset of Python that numba compiles. It is
compiled at its first call and kept in a cache on disk. The cache of numba is keyed by the source file
of the function alone, so a change in another file that a kernel calls would go unseen; here the
key is the content of the whole package, and an upgrade never runs stale code.
"""

from __future__ import annotations

import hashlib
import sys
import types
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import Any, TypeVar, cast

import numpy as np
import numpy.typing as npt

__all__ = ["FloatArray", "IntArray", "interpreted", "kernel"]

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]
F = TypeVar("F", bound=Callable[..., Any])

_announced = False


@lru_cache(maxsize=1)
def _package_digest() -> str:
    """Hash of every source file of the package (1 ms): the stamp of all its compiled kernels."""
    digest = hashlib.sha256()
    root = Path(__file__).resolve().parent
    for folder in (root, (root / "solvers").resolve()):
        for path in sorted(folder.rglob("*.py")):
            digest.update(path.name.encode())
            digest.update(path.read_bytes())
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


def _package_cache(function: Callable[..., Any]) -> Any:
    """Numba's on-disk cache of one function, stamped with the content of the whole package."""
    from numba.core.caching import FunctionCache

    class PackageCache(FunctionCache):  # type: ignore[misc]
        def __init__(self, py_func: Callable[..., Any]) -> None:
            super().__init__(py_func)
            self._cache_file._source_stamp = _package_digest()

        def load_overload(self, sig: Any, target_context: Any) -> Any:
            loaded = super().load_overload(sig, target_context)
            if loaded is None:
                _announce()
            return loaded

    return PackageCache(function)


def kernel(function: F) -> F:
    """Compile ``function`` with numba at its first call (``nopython``, cached on disk, no fastmath).

    The plain Python source stays reachable as ``function.py_func``.
    """
    import numba

    dispatcher = numba.njit(function)
    try:
        dispatcher._cache = _package_cache(function)
    except (AttributeError, RuntimeError):  # other numba internals, or no writable folder for a cache
        pass
    return cast(F, dispatcher)


def interpreted(compiled: F, **replacements: Any) -> F:
    """The same driver as plain Python, with some of the functions it calls replaced.

    A driver is written once: compiled, it runs whole chunks of steps without Python; interpreted,
    its loop is Python and any function it calls (a solver, a callback, the mechanics of a
    user's own system) can be any Python callable.
    """
    source = cast(Any, compiled).py_func
    scope = {**source.__globals__, **replacements}
    clone = types.FunctionType(source.__code__, scope, source.__name__, source.__defaults__)
    return cast(F, clone)
