"""The one decorator under which every numerical kernel is compiled.

A kernel is a function of arrays and scalars in the subset of Python that numba compiles. It is
compiled at its first call and kept on disk (:mod:`lcpflex.jit.cache`) under a key that holds its code and that of all
kernels it reaches (:mod:`lcpflex.jit.keys`), so that an upgrade never runs stale code. Large kernels are
called by others, not copied into them (:mod:`lcpflex.jit.thin`).
"""

from __future__ import annotations

import types
from collections.abc import Callable
from typing import Any, TypeVar, cast

import numpy as np
import numpy.typing as npt

__all__ = ["FloatArray", "IntArray", "interpreted", "kernel", "late_kernel"]

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]
F = TypeVar("F", bound=Callable[..., Any])

OPTIONS = {"_nrt": False, "error_model": "numpy", "no_cfunc_wrapper": True, "nogil": True}


def kernel(function: F) -> F:
    """Compile ``function`` with numba at its first call (``nopython``, cached on disk, no fastmath).

    Numbers divided by zero are inf or NaN, as in numpy: a branch for each division would keep loops from being
    vectorised, and what is not finite is judged once, where a result is. The plain Python source stays reachable as
    ``function.py_func``.
    """
    return _compiled(function, late=False)


def late_kernel(function: F) -> F:
    """A kernel that is not compiled before it is called, by a kernel as well (:mod:`lcpflex.jit.late`).

    For what many runs do not need. Its annotation tells what it returns: None, bool, int, float or a tuple. Calls of
    it are never compiled into their callers.
    """
    return _compiled(function, late=True)


def _compiled(function: F, late: bool) -> F:
    import numba

    if numba.config.DISABLE_JIT:
        return function
    from lcpflex.jit.private import why_not_thin

    if reason := why_not_thin():
        return cast(F, _linked_by_numba(function, reason))
    from lcpflex.jit.late import LateDispatcher
    from lcpflex.jit.thin_dispatcher import ThinDispatcher

    kind = LateDispatcher if late else ThinDispatcher
    return cast(F, kind(function, {"nopython": True, "boundscheck": None, **OPTIONS}))


def _linked_by_numba(function: Callable[..., Any], reason: str) -> Any:
    """For other versions of numba: compiling takes twice as long, and files are ten times as large."""
    import numba

    dispatcher = numba.njit(**OPTIONS)(function)
    try:
        from lcpflex.jit.plain import attach

        attach(dispatcher, function, reason)
    except (ImportError, AttributeError):  # without a cache on disk
        pass
    return dispatcher


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
