"""A user's function made callable from kernels, and what it raised there.

No exception passes through a kernel: it is kept here, the law is no number there, so that the run cannot go on with
that state, and what was raised comes out of :meth:`OwnFunction.complaint`.
"""

from __future__ import annotations

import ctypes
import math
from collections.abc import Callable
from functools import lru_cache
from types import FunctionType
from typing import Any

import numpy as np

from lcpflex.errors import ModelError, shown

__all__ = ["OwnFunction", "is_compiled"]

# behind the parameters: what went wrong, and the arguments it went wrong with
MISHAP, DEPTH, RATE, SPEED = range(4)
NO_NUMBER, RAISED = 1.0, 2.0

Function = Callable[..., float]


def is_compiled(function: Any) -> bool:
    """Whether numba has compiled it already."""
    return hasattr(function, "py_func") and hasattr(function, "overloads")


class OwnFunction:
    """A function of a user's and its parameters, at an address.

    With ``compiled`` the function is compiled if it can be; else it is called as Python, some microsecond a call.
    """

    def __init__(self, function: Function, parameters: tuple[float, ...], compiled: bool) -> None:
        self._function = function
        self._n = len(parameters)
        self._data = np.array([*parameters, 0.0, 0.0, 0.0, 0.0])
        self._error: BaseException | None = None
        code = None
        if is_compiled(function) or (compiled and isinstance(function, FunctionType)):  # numba takes no other callables
            code = _compiled(function, self._n)
        self.compiled = code is not None
        self._code = code or SIGNATURE(self._call)  # referred to, that it live
        place = code.address if code else ctypes.cast(self._code, ctypes.c_void_p).value
        self._words = np.array([place, self._data.ctypes.data], dtype=np.int64)

    @property
    def address(self) -> int:
        """As :func:`lcpflex.force_laws.user_call.own_force` takes it."""
        return int(self._words.ctypes.data)

    def begin(self) -> None:
        """Forget what has been raised."""
        self._error = None
        self._data[self._n :] = 0.0

    def complaint(self) -> str:
        """What the function returned that was no finite number, in words; empty if it did not.

        Raises
        ------
        BaseException
            What it raised since ``begin``.
        """
        if self._error is not None:
            raise self._error
        mishap, *state = self._data[self._n :].tolist()
        if mishap == 0.0:
            return ""
        words = "its law at indentation {:.6g} m, rate {:.6g} m/s, impact speed {:.6g} m/s".format(*state)
        if mishap == NO_NUMBER:
            return words + " is not a finite number"
        with np.errstate(all="ignore"):
            getattr(self._function, "py_func", self._function)(*state, self._data[: self._n].copy())  # raises it again
        return words + " has raised an exception in its compiled form"

    def _call(self, depth: float, rate: float, speed: float, _: Any) -> float:
        """The function as Python, called from kernels."""
        if self._error is not None and not isinstance(self._error, Exception):
            return math.nan  # interrupted: the run is to end
        try:
            force = float(self._function(depth, rate, speed, self._data[: self._n]))
        except BaseException as error:  # Ctrl-C, too: what is raised across a kernel would be lost
            if self._error is None or not isinstance(error, Exception):
                self._error = error
            return math.nan
        if not math.isfinite(force) and (self._data[self._n] == 0.0 or math.isfinite(depth + rate + speed)):
            self._data[self._n :] = NO_NUMBER, depth, rate, speed  # not of the states that are no numbers for it
        return force


SIGNATURE = ctypes.CFUNCTYPE(
    ctypes.c_double, ctypes.c_double, ctypes.c_double, ctypes.c_double, ctypes.POINTER(ctypes.c_double)
)


@lru_cache(maxsize=256)
def _compiled(function: Function, n: int) -> Any:
    """The function compiled for n parameters, as numba's callback; None for a Python function that cannot be.

    Raises
    ------
    ModelError
        For a function that is to be compiled by the user's own will, and cannot be.
    """
    import numba

    law = function if is_compiled(function) else numba.njit(function)
    size = n + 4

    def call(depth, rate, speed, block):  # type: ignore[no-untyped-def]
        data = numba.carray(block, (size,))
        mishap = NO_NUMBER
        force = math.nan
        try:
            force = float(law(depth, rate, speed, data[:n]))
        except Exception:
            mishap = RAISED
        if not math.isfinite(force) and (data[n + MISHAP] == 0.0 or math.isfinite(depth + rate + speed)):
            data[n + MISHAP] = mishap
            data[n + DEPTH] = depth
            data[n + RATE] = rate
            data[n + SPEED] = speed
        return force

    double = numba.types.float64
    signature = double(double, double, double, numba.types.CPointer(double))
    try:
        return numba.cfunc(signature)(call)
    except Exception as error:  # not those of numba alone: some Python it does not know fails deep in it
        if is_compiled(function):
            raise ModelError(f"function: {shown(function)} was given, which does not compile: {error}") from error
        return None
