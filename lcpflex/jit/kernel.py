"""The one decorator under which every numerical kernel is compiled.

A kernel is a function of arrays and scalars in the subset of Python that numba compiles. It is
compiled at its first call and kept on disk (:mod:`lcpflex.jit.cache`) under a key that holds its code and that of all
kernels it reaches (:mod:`lcpflex.jit.keys`), so that an upgrade never runs stale code. Large kernels are
called by others, not copied into them (:mod:`lcpflex.jit.thin`).
"""

from __future__ import annotations

import os
import types
from collections.abc import Callable
from functools import cache, update_wrapper
from threading import RLock
from typing import Any, TypeVar, cast, overload

import numpy as np
import numpy.typing as npt

__all__ = ["FloatArray", "IntArray", "Kernel", "interpreted", "kernel", "late_kernel"]

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]
F = TypeVar("F", bound=Callable[..., Any])

OPTIONS = {"_nrt": False, "error_model": "numpy", "no_cfunc_wrapper": True, "nogil": True}


@overload
def kernel(function: F) -> F: ...


@overload
def kernel(*, inline: bool) -> Callable[[F], F]: ...


def kernel(function: F | None = None, *, inline: bool = False) -> F | Callable[[F], F]:
    """Compile ``function`` with numba at its first call (``nopython``, cached on disk, no fastmath).

    ``@kernel(inline=True)``: its code is copied into each caller, however large it is and however many callers it has.
    For small functions in the innermost loops: LLVM calls a function of two callers, which costs such a loop up to
    half of its speed.

    Numbers divided by zero are inf or NaN, as in numpy: a branch for each division would keep loops from being
    vectorised, and what is not finite is judged once, where a result is. The plain Python source stays reachable as
    ``function.py_func``.
    """
    if function is None:
        return lambda decorated: _kernel(decorated, inline)
    return _kernel(function, inline)


def _kernel(function: F, inline: bool) -> F:
    return function if _only_python() else cast(F, Kernel(function, late=False, inline=inline))


def late_kernel(function: F) -> F:
    """A kernel that is not compiled before it is called, by a kernel as well (:mod:`lcpflex.jit.late`).

    For what many runs do not need. Its annotation tells what it returns: None, bool, int, float or a tuple. Calls of
    it are never compiled into their callers.
    """
    return function if _only_python() else cast(F, Kernel(function, late=True))


def _only_python() -> bool:
    """Whether numba is told by its environment not to compile; it need not be loaded to know."""
    try:
        return bool(int(os.environ.get("NUMBA_DISABLE_JIT") or "0"))
    except ValueError:  # as numba, which warns
        return False


class Kernel:
    """A function and, from its first use on, numba's dispatcher of it.

    A program loads a thousand kernels and uses some hundred: to make a dispatcher takes longer than to read the source
    of its function.

    Attributes
    ----------
    py_func
        The plain Python function.
    late
        Whether compiled code calls it without having it compiled; see :func:`late_kernel`.
    inline
        Whether its code is copied into each caller.
    made
        The dispatcher. All that a kernel has no attribute for is asked of it.
    """

    def __init__(self, function: Callable[..., Any], late: bool, inline: bool = False) -> None:
        update_wrapper(self, function)
        self.py_func = function
        self.late = late
        self.inline = inline
        self._made: Any = None

    def __call__(self, *args: Any, **kwargs: Any) -> Any:
        """What the compiled function returns."""
        return (self._made or self.made)(*args, **kwargs)

    @property
    def made(self) -> Any:
        """The dispatcher: one only, for threads that ask at the same time as well."""
        if self._made is None:
            with _making:
                if self._made is None:
                    try:
                        self._made = _dispatcher(self.py_func, self.late, self.inline)
                    except AttributeError as error:  # which Python would take for the lack of ``made``
                        raise ImportError(f"numba cannot be used with what is installed: {error}") from error
        return self._made

    @property
    def _numba_type_(self) -> Any:
        """What numba asks of a value that a function names: its type is that of the dispatcher."""
        return self.made._numba_type_

    def __getattr__(self, name: str) -> Any:
        """What dispatchers have; Python's own questions (``__path__`` and others) make none."""
        if name.startswith("__"):
            raise AttributeError(name)
        return getattr(self.made, name)

    def __repr__(self) -> str:
        """Its name."""
        return f"<kernel {self.py_func.__module__}.{self.py_func.__qualname__}>"

    def __reduce__(self) -> str:
        """Pickled by its name."""
        return self.py_func.__qualname__


_making = RLock()


def _dispatcher(function: Callable[..., Any], late: bool, inline: bool) -> Any:
    """What compiles ``function``; the function itself where numba is told by its file of settings not to compile."""
    if _disabled():
        return function
    from lcpflex.jit.private import why_not_thin

    if reason := why_not_thin():
        return _linked_by_numba(function, reason)
    from lcpflex.jit.late import LateDispatcher
    from lcpflex.jit.thin_dispatcher import ThinDispatcher

    options = {"nopython": True, "boundscheck": None, **OPTIONS}
    return LateDispatcher(function, options) if late else ThinDispatcher(function, options, inline)


@cache
def _disabled() -> bool:
    """Whether numba's own file of settings tells it not to compile: once for all kernels, which call each other."""
    import numba

    return bool(numba.config.DISABLE_JIT)


def _linked_by_numba(function: Callable[..., Any], reason: str) -> Any:
    """For other versions of numba: compiling takes twice as long, and files are ten times as large."""
    import numba

    from lcpflex.jit.literals import without_literals

    dispatcher = numba.njit(**OPTIONS)(function)
    call = dispatcher.get_call_template
    dispatcher.get_call_template = lambda args, kws: call(*without_literals(args, kws))
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
