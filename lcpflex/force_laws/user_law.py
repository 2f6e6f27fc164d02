"""A user's law of the normal force: one function."""

from __future__ import annotations

import math
import numbers
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np

from lcpflex.basics.arguments import flag, sequence_of
from lcpflex.errors import ModelError, in_range, shown
from lcpflex.force_laws.arguments import finite_numbers, numbers_of
from lcpflex.force_laws.elastic.kernels import FORCE, INDENTATION
from lcpflex.force_laws.elastic.law import ElasticFace
from lcpflex.force_laws.user_call import own_forces
from lcpflex.jit.callback import OwnFunction
from lcpflex.jit.kernel import FloatArray

__all__ = ["UserLaw"]

TRIAL = (1e-6, 0.0, 1.0)  # indentation [m], rate and impact speed [m/s]
REACHED = 1e-6  # relative: an inverse is one if the force comes out again


@dataclass(frozen=True, slots=True, init=False)
class UserLaw(ElasticFace):
    """Normal force by a function of the user's: lambda_N = max(0, F(delta, deltadot, v_0)).

    ``function(indentation, rate, impact_speed, parameters) -> float``, in SI units: delta > 0 [m], deltadot [m/s]
    positive while it grows, the speed v_0 >= ``guard_speed`` at the touch [m/s], and an array of floats. Friction and a
    damping of the library go with it as with any elastic law, as ``ContactLaw(UserLaw(f), friction=LuGre())``; under a
    ``PermanentIndentation`` only its elastic part counts.

    The function is compiled with numba where that is possible, or has been by the user (``numba.njit``): then the run
    is about as fast as with a law of the library. Globals and variables around it are taken as they are when it is
    compiled first. What cannot be compiled is called as Python, some microsecond a call: see ``is_compiled``.

    For the energy audit F(delta, 0, 1 m/s) counts as elastic: what it stores is its integral, by a quadrature that is
    good to rounding for powers and to 1e-7 for other smooth laws. Across kinks it is not: 1e-3 off with one halfway,
    1e-1 where a law begins at 0.99 of the indentation, and then the result may have a remainder of energy (its motion
    does not care). The rest of F is damping. A law that gives back more than it took makes the result warn that the
    energy grew. F should be 0 at the touch for rate 0: error control shortens steps at jumps, and their energy is not
    seen.

    What the function raises ends the run, and is the cause of its StepError; so does a number that is not finite.

    Parameters
    ----------
    function
        As above. It must not keep or change ``parameters``.
    parameters
        Numbers handed to the function, any number of them; kept as ``values``.
    guard_speed
        Least v_0 that the function is told [m/s], > 0: many laws divide by it.
    compiled
        False: call the function as Python, even if it could be compiled.

    Raises
    ------
    ModelError
        For what is not callable with such arguments or does not return a finite number, found by a trial call with
        delta = 1e-6 m, rate 0 and v_0 = 1 m/s; for parameters that are no numbers.
    """

    kind: ClassVar[str] = "own"
    function: Callable[..., float]
    values: tuple[float, ...]
    guard_speed: float
    compiled: bool
    own: OwnFunction = field(repr=False, compare=False)

    def __init__(
        self,
        function: Callable[..., float],
        parameters: Sequence[float] = (),
        *,
        guard_speed: float = 1e-4,
        compiled: bool = True,
    ) -> None:
        given = sequence_of("parameters", parameters, "a sequence of numbers")
        values = tuple(in_range(f"parameters[{i}]", x, -math.inf, math.inf) for i, x in enumerate(given))
        _try(function, values)
        object.__setattr__(self, "function", function)
        object.__setattr__(self, "values", values)
        object.__setattr__(self, "guard_speed", in_range("guard_speed", guard_speed, 0.0, math.inf, open_ends=True))
        object.__setattr__(self, "compiled", flag("compiled", compiled))
        object.__setattr__(self, "own", OwnFunction(function, values, self.compiled))

    def __reduce__(self) -> tuple[Any, ...]:
        return _again, (self.function, self.values, self.guard_speed, self.compiled)

    @property
    def parameters(self) -> tuple[float, ...]:
        """What kernels must know beside the function: the least v_0."""
        return (self.guard_speed,)

    @property
    def is_compiled(self) -> bool:
        """Whether the function runs compiled."""
        return self.own.compiled

    @property
    def address(self) -> int:
        """Where kernels find the function."""
        return self.own.address

    @property
    def lenient(self) -> bool:  # type: ignore[override]
        """Its range of validity is not known."""
        return False

    def force(self, delta: Any, rate: Any = 0.0, impact_speed: Any = 1.0) -> Any:
        """lambda_N [N] at indentations >= 0 [m] growing with ``rate`` [m/s] after a touch at ``impact_speed`` [m/s].

        Numbers or arrays, which are broadcast.

        delta: indentation [m].

        Raises
        ------
        ModelError
            For negative indentations and impact speeds, and where the function returns no finite number. What it raises
            comes out.
        """
        self._check("delta", numbers_of("delta", delta), math.inf, math.inf)
        given = (delta, finite_numbers("rate", rate, -math.inf), finite_numbers("impact_speed", impact_speed, 0.0))
        shape = np.broadcast_shapes(*map(np.shape, given))
        depth, rates, speed = (np.broadcast_to(np.asarray(x, dtype=float), shape).ravel() for x in given)
        out = np.empty(depth.size)
        self.own.begin()
        own_forces(self.address, depth, rates, np.maximum(speed, self.guard_speed), out)
        self._complain()
        return out.reshape(shape) if shape else float(out[0])

    def _values(self, quantity: int, given: FloatArray) -> FloatArray:
        """A quantity at each of ``given`` (n,), of the elastic part. What the function raises comes out."""
        self.own.begin()
        out = ElasticFace._values(self, quantity, given)
        if quantity != INDENTATION:
            self._complain()
            return out
        self.own.complaint()  # numbers that are none, on the way to an indentation, do not matter: it is checked here
        found = ElasticFace._values(self, FORCE, out)
        wrong = given[~(abs(found - given) <= REACHED * given)]
        if wrong.size > 0:
            raise ModelError(
                f"force: {float(wrong[0])!r} N was given, expected one that the law has at some indentation"
            )
        return out

    def _complain(self) -> None:
        """Raise what the function raised, and ModelError where it returned no finite number."""
        words = self.own.complaint()
        if words:
            raise ModelError(f"function: {shown(self.function)} was given, {words}")


def _again(function: Callable[..., float], values: tuple[float, ...], guard_speed: float, compiled: bool) -> UserLaw:
    return UserLaw(function, values, guard_speed=guard_speed, compiled=compiled)


def _try(function: Any, parameters: tuple[float, ...]) -> None:
    """Raise ModelError where ``function`` cannot be called as a law, or returns no finite number."""
    expected = "expected a function (indentation, rate, impact_speed, parameters) -> float"
    if not callable(function):
        raise ModelError(f"function: {shown(function)} was given, {expected}")
    try:
        force = function(*TRIAL, np.array(parameters))
    except Exception as error:
        called = f"called with indentation 1e-6 m, rate 0, impact speed 1 m/s it raised {type(error).__name__}: {error}"
        raise ModelError(f"function: {shown(function)} was given, {expected}; {called}") from error
    if isinstance(force, bool) or not isinstance(force, numbers.Real) or not math.isfinite(force):
        raise ModelError(
            f"function: {shown(function)} was given, which returned {shown(force)}, {expected} that is finite"
        )
