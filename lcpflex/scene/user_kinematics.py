"""How the velocities of a user's own system move its configuration: qdot = B(q) u, with nq >= nu numbers in q."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from lcpflex.basics.arguments import array_of
from lcpflex.errors import ModelError, shown
from lcpflex.jit.kernel import FloatArray

__all__ = ["UserKinematics", "call", "user_array"]

NORMAL = 1e-6  # change of the start by ``normalise``, times 1 + the largest |q|, that is no error


def user_array(name: str, value: Any, shape: tuple[int, ...]) -> FloatArray:
    """``value`` as a finite float array of ``shape`` (-1: any length), which may be written to."""
    return np.array(array_of(name, value, shape))


def call(name: str, function: Callable[..., Any], shape: tuple[int, ...], *arguments: Any) -> FloatArray:
    """What a user's function returns, checked; what it raises, named."""
    try:
        value = function(*arguments)
    except Exception as error:
        words = f"the function raised {type(error).__name__}: {shown(str(error))}, expected an array of shape {shape}"
        raise ModelError(f"{name}: {words}") from error
    return user_array(f"{name} (returned)", value, shape)


class UserKinematics:
    """B(q) and what makes q normal again; without them qdot = u."""

    def __init__(
        self,
        matrix: npt.ArrayLike | Callable[..., Any] | None,
        normalise: Callable[..., Any] | None,
        nq: int,
        nu: int,
    ) -> None:
        self._matrix, self._normalise = matrix, normalise
        self._shape = nq, nu
        self.nq = nq
        self.own = matrix is not None

    def start(self, q: FloatArray) -> FloatArray:
        """The initial configuration made normal; ModelError where it was not, or where B has no full rank."""
        normal = self.normalised(q)
        change = float(np.abs(normal - q).max())
        if not change <= NORMAL * (1.0 + float(np.abs(q).max())):
            raise ModelError(f"q: normalise changes the start by {change:.6g}, expected a normal configuration")
        if self.own:
            rank = int(np.linalg.matrix_rank(self.matrix(normal)))
            if rank < self._shape[1]:
                raise ModelError(
                    f"kinematics: a matrix of rank {rank} was given, expected B {self._shape} with qdot = B(q) u of "
                    f"the full rank {self._shape[1]}"
                )
        return normal

    def matrix(self, q: FloatArray) -> FloatArray:
        """B (nq, nu)."""
        given: Any = self._matrix
        if callable(given):
            return call("kinematics", given, self._shape, q.copy())
        return user_array("kinematics", given, self._shape)

    def normalised(self, q: FloatArray) -> FloatArray:
        """q as it is meant, without what an integrator has left beside it."""
        return q if self._normalise is None else call("normalise", self._normalise, q.shape, q.copy())

    def rate(self, q: FloatArray, u: FloatArray) -> FloatArray:
        """qdot (nq,)."""
        return self.matrix(q) @ u if self.own else u

    def moved(self, q: FloatArray, u: FloatArray, h: float) -> FloatArray:
        """Where the velocity u leads from q within h [s], by the midpoint rule."""
        if not self.own:
            return q + h * u
        middle = self.normalised(q + 0.5 * h * self.rate(q, u))
        return self.normalised(q + h * self.rate(middle, u))

    def velocity(self, q: FloatArray, change: FloatArray) -> FloatArray:
        """The velocity u with B(q) u nearest to a ``change`` (nq,)."""
        return np.asarray(np.linalg.lstsq(self.matrix(q), change, rcond=None)[0]) if self.own else change

    def difference(self, a: FloatArray, b: FloatArray) -> FloatArray:
        """The velocity that moves a to b in 1 s, to second order."""
        return self.velocity(self.normalised(0.5 * (a + b)), b - a)

    def magnitudes(self, q: FloatArray) -> FloatArray:
        """What changes of q, as velocities, are small against."""
        return np.asarray(np.abs(np.linalg.pinv(self.matrix(q))) @ np.abs(q)) if self.own else np.abs(q)
