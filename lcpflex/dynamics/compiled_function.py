"""A user's function of time that numba has compiled, called from kernels by its address.

As with force laws of users (:mod:`lcpflex.jit.callback`) no exception passes through a kernel: the value
is not a number from then on, and what happened comes out of :meth:`CompiledFunction.complaint`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np

from lcpflex.errors import ModelError, shown
from lcpflex.jit.callback import is_compiled
from lcpflex.jit.kernel import FloatArray
from lcpflex.scene.functions_of_time import Function, takes_state

__all__ = ["DIFFERENCE_STEP", "CompiledFunction", "called", "compiled_source"]

# a force, both components of one in the plane, a motion, that with its derivatives, three components of a force
VALUE, PAIR, MOTION, TRIPLE, VECTOR = range(5)
SHAPES = {VALUE: ((), (1,)), PAIR: ((2,),), MOTION: ((), (1,), (3,)), VECTOR: ((3,),)}
EXPECTED = {
    VALUE: "a finite number",
    PAIR: "2 finite numbers",
    VECTOR: "3 finite numbers",
    MOTION: "a finite number or three: value, rate, acceleration",
}
MISHAP, TIME = 0, 1  # entries of the data block: what went wrong first, and when
NO_NUMBER, RAISED = 1.0, 2.0
# Fourth-order differences of f(t): relative errors below (omega h)^4 / 90 in truncation and, for the second derivative,
# about 20 eps |f| / h^2 = 1e-7 |f| / s^2 in rounding.
DIFFERENCE_STEP = 2e-4  # [s]


def compiled_source(function: Any) -> Any:
    """The dispatcher of numba behind a function of time alone, ``lf.Function`` or not; None where there is none."""
    if isinstance(function, Function):
        function = function.function
    if hasattr(function, "native_name") and hasattr(function, "__wrapped__"):  # numba.cfunc
        import numba

        function = numba.njit(function.__wrapped__)
    return function if is_compiled(function) and not takes_state(function) else None


class CompiledFunction:
    """A function of time at an address; ``form``: VALUE, PAIR, VECTOR or MOTION."""

    def __init__(self, name: str, function: Callable[..., Any], form: int) -> None:
        self.name, self.function = name, function
        self._source = compiled_source(function)
        self.motion = form == MOTION
        first = called(name, form, self._source, 0.0)
        self.form = TRIPLE if form == MOTION and first.size == 3 else form
        self._data = np.zeros(2)
        self._code = _compiled(self._source, self.form)
        self._words = np.array([self._code.address, self._data.ctypes.data], dtype=np.int64)

    def __reduce__(self) -> tuple[Any, ...]:
        """What it is made of: its code is compiled, and its address found, where it is unpickled."""
        return CompiledFunction, (self.name, self.function, MOTION if self.motion else self.form)

    @property
    def address(self) -> int:
        """As :func:`lcpflex.force_laws.user_call.own_force` takes it."""
        return int(self._words.ctypes.data)

    def begin(self) -> None:
        """Forget what went wrong."""
        self._data[:] = 0.0

    def complaint(self) -> str:
        """What went wrong since ``begin``, in words; empty if nothing did."""
        mishap, time = self._data.tolist()
        if mishap == 0.0:
            return ""
        try:
            called(self.name, MOTION if self.motion else self.form, self._source, time)
        except ModelError as error:
            return str(error)
        return f"{self.name}: the function is not a finite number about t = {time:.9g} s"


def called(name: str, form: int, function: Callable[..., Any], *a: Any) -> FloatArray:
    """What a user's function returns, as finite numbers of a shape of this ``form``.

    Raises ModelError, chained to what the function raised.
    """
    try:
        returned = function(*a)
    except Exception as error:
        raise ModelError(f"{name}: the function raised {type(error).__name__} at t = {a[0]:.9g} s: {error}") from error
    try:
        values = np.asarray(returned, dtype=float)
        sound = values.shape in SHAPES[form] and bool(np.isfinite(values).all())
    except (TypeError, ValueError):
        sound = False
    if not sound:
        raise ModelError(
            f"{name}: the function returned {shown(returned)} at t = {a[0]:.9g} s, expected {EXPECTED[form]}"
        )
    return values


@lru_cache(maxsize=256)
def _compiled(source: Any, form: int) -> Any:
    """Numba's callback (time, component, unused, data block) -> float. Raises ModelError for what does not compile."""
    import numba

    ask = numba.njit({VALUE: _value, MOTION: _difference}.get(form, _component)(source))

    def call(t, component, unused, block):  # type: ignore[no-untyped-def]
        data = numba.carray(block, (2,))
        mishap = NO_NUMBER
        value = math.nan
        try:
            value = ask(t, component)
        except Exception:
            mishap = RAISED
        if not math.isfinite(value) and data[MISHAP] == 0.0:
            data[MISHAP] = mishap
            data[TIME] = t
        return value

    double = numba.types.float64
    try:
        return numba.cfunc(double(double, double, double, numba.types.CPointer(double)))(call)
    except Exception as error:
        raise ModelError(f"function: {shown(source)} was given, which does not compile: {error}") from error


def _value(function: Any) -> Callable[..., Any]:
    def ask(t, component):  # type: ignore[no-untyped-def]
        return float(function(t))

    return ask


def _component(function: Any) -> Callable[..., Any]:
    def ask(t, component):  # type: ignore[no-untyped-def]
        values = function(t)
        if component < 0.5:
            return float(values[0])
        if component < 1.5:
            return float(values[1])
        return float(values[-1])

    return ask


def _difference(function: Any) -> Callable[..., Any]:
    h = DIFFERENCE_STEP

    def ask(t, component):  # type: ignore[no-untyped-def]
        now = float(function(t))
        if component < 0.5:
            return now
        before, after = float(function(t - h)), float(function(t + h))
        far_before, far_after = float(function(t - 2.0 * h)), float(function(t + 2.0 * h))
        if component < 1.5:
            return (8.0 * (after - before) - (far_after - far_before)) / (12.0 * h)
        return (16.0 * (after + before) - (far_after + far_before) - 30.0 * now) / (12.0 * h * h)

    return ask
