"""Functions of time, for forces and torques and for what joints drive: one of

- a number: constant;
- :class:`Harmonic`;
- :class:`Table`: values at instants, constant before the first and after the last; between them straight lines for a
  force, and the cubic spline that is twice continuously differentiable for a motion;
- a Python function, as it is or as :class:`Function`, which also tells steppers where to look. A force is called as
  f(t), or as f(t, state) if it takes two arguments, with a :class:`lcpflex.dynamics.time_functions.State`. A motion is
  called as f(t), also a little before the start, and returns its value, or the triple (value, rate, acceleration);
  without these two, they are taken by central differences. The outer loop of a simulation then runs in Python, which
  costs hundreds of microseconds a step; not so with a function of the time alone that numba has compiled
  (``numba.njit``): it is called by its address.

Steps with error control end where a table bends and are at most a quarter of a period of a harmonic long. A Python
function is probed before the run, at up to a hundred thousand instants spread over the duration (fewer of one that
calls many others) and more where it bends: what it does between two of them, and hides from both, has to be told by
:class:`Function`. One that depends on the state, too, is probed at that of the start, at a thousand instants, and steps
are at most a hundredth of the duration long.

Steps of fixed length take the mean of a force over the step where a table bends or a harmonic swings within it.
"""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from lcpflex.basics import libs
from lcpflex.basics.arguments import numbers
from lcpflex.basics.options import is_number, keep_number, keep_number_or_none
from lcpflex.bodies.body import array_of
from lcpflex.errors import ModelError, in_range, shown
from lcpflex.jit.kernel import FloatArray

__all__ = ["Function", "Harmonic", "Motion", "Signal", "Table", "checked_motion", "takes_state"]

# of the largest mean rate of a table: values leave the rate at the start open to about the second, and a scene that
# starts with one so near means it
SAME_RATE, BLURRED_RATE = 1e-10, 1e-2


@dataclass(frozen=True, slots=True)
class Harmonic:
    """mean + amplitude sin(omega t + phase); omega [rad/s], phase [rad]. Raises ModelError for numbers not finite."""

    amplitude: float
    omega: float
    phase: float = 0.0
    mean: float = 0.0

    def __post_init__(self) -> None:
        for name in ("amplitude", "omega", "phase", "mean"):
            keep_number(self, name, -math.inf, math.inf, label=f"Harmonic: {name}")


@dataclass(frozen=True, slots=True, eq=False)
class Table:
    """``values`` (m,) at increasing ``times`` (m,) [s], m >= 2; constant before the first and after the last.

    A motion that begins at time 0 takes the velocity that the scene starts with where its spline comes near to that: to
    a hundredth of the largest mean velocity between two instants. One that is still moving at its last instant stops
    there at once: let the table cover the simulation, or come to rest. Raises ModelError for arrays of other shapes,
    times that do not increase, or numbers that are not finite.
    """

    times: npt.ArrayLike
    values: npt.ArrayLike

    def __post_init__(self) -> None:
        given = numbers(self.values)
        if given is not None and given.ndim > 1:
            raise ModelError(
                f"Table: values: an array of shape {given.shape} was given, expected ({np.size(self.times)},), one "
                "number for each time; each component of a vector has its own: (Table(times, x), Table(times, y))"
            )
        for name in ("times", "values"):
            object.__setattr__(self, name, array_of(f"Table: {name}", getattr(self, name), (-1,)))
        times, values = np.asarray(self.times), np.asarray(self.values)
        if times.shape != values.shape:
            raise ModelError(f"Table: values: {values.size} were given for {times.size} times, expected as many")
        if times.size < 2 or not (np.diff(times) > 0.0).all():
            raise ModelError(f"Table: times: {shown(times)} was given, expected at least two increasing instants [s]")

    def pieces(self, smooth: bool, rate: float | None = None) -> tuple[FloatArray, FloatArray]:
        """Breaks (m,) and coefficients (m, 4) for the powers 3 to 0 of (t - break); the last row is the last value.

        ``rate``: that of the spline at time 0, if the table begins there and does not say otherwise.

        smooth: whether the curve between the points is a cubic spline, and not straight lines.
        """
        times, values = np.asarray(self.times), np.asarray(self.values)
        coefficients = np.zeros((times.size, 4))
        if smooth:
            spline = libs.CubicSpline(times, values)
            if rate is not None and times[0] == 0.0 and times.size > 2:
                off = abs(float(spline(0.0, 1)) - rate)
                fastest = float(np.abs(np.diff(values) / np.diff(times)).max())
                if SAME_RATE * fastest < off <= BLURRED_RATE * fastest:
                    spline = libs.CubicSpline(times, values, bc_type=((1, np.array(rate)), "not-a-knot"))
            coefficients[:-1] = spline.c.T
        else:
            coefficients[:-1, 2] = np.diff(values) / np.diff(times)
            coefficients[:-1, 3] = values[:-1]
        coefficients[-1, 3] = values[-1]
        return times, coefficients


@dataclass(frozen=True, slots=True, eq=False)
class Function:
    """A Python function of time, with what steppers should know of it.

    Steps with error control end at each of ``breaks`` and are at most half of ``shortest`` long. Of a function alone
    they know what a probe shows: it is called at a few thousand instants before the run.

    Attributes
    ----------
    function
        As Python functions in general: f(t), or f(t, state) for a force.
    breaks
        Instants [s] where it jumps or bends.
    shortest
        Duration [s] of the shortest thing it does, as a pulse or a rise; None: whatever the probe shows.

    Raises
    ------
    ModelError
        For what is not callable, breaks that are not finite, and a duration that is not > 0.
    """

    function: Callable[..., Any]
    breaks: npt.ArrayLike = ()
    shortest: float | None = None

    def __post_init__(self) -> None:
        if not callable(self.function):
            raise ModelError(f"Function: function: {shown(self.function)} was given, expected a function of the time")
        breaks = np.sort(array_of("Function: breaks", self.breaks, (-1,)))
        breaks.setflags(write=False)
        object.__setattr__(self, "breaks", breaks)
        keep_number_or_none(self, "shortest", 0.0, math.inf, open_ends=True, label="Function: shortest")

    def __call__(self, *arguments: Any) -> Any:
        """What the function returns."""
        return self.function(*arguments)


Motion = float | Harmonic | Table | Callable[[float], Any]
Signal = float | Harmonic | Table | Callable[..., Any]


def checked_motion(name: str, value: Any) -> Any:
    """``value`` if it is a function of time, a number as a float; raises ModelError for anything else."""
    if is_number(value):
        return in_range(name, value, -math.inf, math.inf)
    if not (isinstance(value, (Harmonic, Table)) or callable(value)):
        raise ModelError(
            f"{name}: {shown(value)} was given, expected a number, Harmonic, Table or a Python function of the time"
        )
    return value


def takes_state(function: Callable[..., Any]) -> bool:
    """Whether a force function is to be called as f(t, state)."""
    if isinstance(function, Function):
        return takes_state(function.function)
    try:
        parameters = inspect.signature(function).parameters.values()
    except (TypeError, ValueError):  # some built-in functions do not tell
        return False
    kinds = (inspect.Parameter.POSITIONAL_ONLY, inspect.Parameter.POSITIONAL_OR_KEYWORD)
    required = [p for p in parameters if p.kind in kinds and p.default is p.empty]
    return len(required) >= 2 or any(p.kind is p.VAR_POSITIONAL for p in parameters)
