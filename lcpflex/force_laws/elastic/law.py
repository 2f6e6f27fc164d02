"""The face that all elastic laws share: force, stiffness, energy and indentation of numbers and arrays."""

from __future__ import annotations

import math
import warnings
from typing import TYPE_CHECKING, Any, ClassVar, overload

import numpy as np
import numpy.typing as npt

from lcpflex.errors import ModelError, ModelWarning
from lcpflex.force_laws.arguments import numbers_of
from lcpflex.force_laws.elastic.kernels import ENERGY, FORCE, INDENTATION, KINDS, STIFFNESS, evaluate
from lcpflex.force_laws.layout import ELASTIC, END, LIMIT, PARAMETERS
from lcpflex.jit.kernel import FloatArray

__all__ = ["ElasticFace"]

ROUNDING = 1e-12  # relative: the indentation under the force at the limit may come out beyond the limit


class ElasticFace:
    """Elastic force F(delta) of an indentation delta >= 0, per contact.

    All methods take a number or an array of any shape and return the same. Beyond ``limit`` a law with
    ``lenient=True`` gives a ModelWarning instead of an error; beyond ``end``, where it does not exist, no law gives
    anything.

    Raises
    ------
    ModelError
        For a negative indentation or force, for what is no number, and for one beyond the range of validity.
    """

    __slots__ = ()

    if TYPE_CHECKING:
        lenient: bool

        kind: ClassVar[str]

        @property
        def parameters(self) -> tuple[float, ...]:
            """At most six."""

    @property
    def limit(self) -> float:
        """Indentation up to which the law is valid [m]; infinite where nothing is known."""
        return math.inf

    @property
    def end(self) -> float:
        """Indentation up to which the law exists [m]; infinite for most."""
        return math.inf

    @overload
    def force(self, delta: float) -> float: ...
    @overload
    def force(self, delta: npt.ArrayLike) -> FloatArray: ...
    def force(self, delta: Any) -> Any:
        """F [N] at the indentation ``delta`` >= 0 [m]."""
        return self._evaluate("delta", FORCE, delta, self.limit, self.end)

    @overload
    def stiffness(self, delta: float) -> float: ...
    @overload
    def stiffness(self, delta: npt.ArrayLike) -> FloatArray: ...
    def stiffness(self, delta: Any) -> Any:
        """dF/ddelta [N/m] at the indentation ``delta`` >= 0 [m]; at the touch the limit from above."""
        return self._evaluate("delta", STIFFNESS, delta, self.limit, self.end)

    @overload
    def energy(self, delta: float) -> float: ...
    @overload
    def energy(self, delta: npt.ArrayLike) -> FloatArray: ...
    def energy(self, delta: Any) -> Any:
        """Integral of F from 0 to ``delta`` [J]."""
        return self._evaluate("delta", ENERGY, delta, self.limit, self.end)

    @overload
    def indentation(self, force: float) -> float: ...
    @overload
    def indentation(self, force: npt.ArrayLike) -> FloatArray: ...
    def indentation(self, force: Any) -> Any:
        """Indentation [m] under ``force`` >= 0 [N]: the inverse of :meth:`force`."""
        ends = np.array([self.limit, self.end])
        known = ends < math.inf
        ends[known] = self._values(FORCE, ends[known])
        return self._evaluate("force", INDENTATION, force, float(ends[0]), float(ends[1]))

    def _row(self) -> tuple[npt.NDArray[np.int64], FloatArray]:
        """The law as kernels take it, without damping and friction."""
        p = np.zeros(PARAMETERS)
        p[ELASTIC : ELASTIC + len(self.parameters)] = self.parameters
        p[LIMIT], p[END] = self.limit, self.end
        return np.array([KINDS.index(self.kind), 0, 0, getattr(self, "address", 0)], dtype=np.int64), p

    def _evaluate(self, name: str, quantity: int, given: Any, limit: float, end: float) -> Any:
        values = numbers_of(name, given)
        self._check(name, values, limit, end)
        out = self._values(quantity, np.ascontiguousarray(values).ravel())
        return float(out[0]) if values.ndim == 0 else out.reshape(values.shape)

    def _values(self, quantity: int, given: FloatArray) -> FloatArray:
        """A quantity at each of ``given`` (n,)."""
        kinds, p = self._row()
        out = np.empty(given.size)
        evaluate(kinds, p, quantity, given, out)
        return out

    def _check(self, name: str, values: FloatArray, limit: float, end: float) -> None:
        """No number below 0, no NaN, none beyond the range."""
        if values.size == 0:
            return
        least, most = values.min(), values.max()
        if not (least >= 0.0 and most < math.inf):
            wrong = ~((values >= 0.0) & (values < math.inf))
            raise ModelError(f"{_named(name, values, wrong)}, expected a finite number >= 0")
        last = end if self.lenient else min(limit, end)
        slack = 1.0 + ROUNDING
        unit = "m" if name == "delta" else "N"
        law = type(self).__name__
        if most > last * slack:
            what = (
                f"within the range of validity of {law}, up to {last:.6g} {unit}; lenient=True gives a warning instead"
                if last < end
                else f"less than {last:.6g} {unit}, where {law} ends"
            )
            raise ModelError(f"{_named(name, values, values > last * slack)}, expected a number {what}")
        if most > limit * slack:
            text = f"{_named(name, values, values > limit * slack)}, {law} is valid up to {limit:.6g} {unit}"
            warnings.warn(text, ModelWarning, stacklevel=4)


def _named(name: str, values: FloatArray, wrong: npt.NDArray[np.bool_]) -> str:
    """The first wrong one among values, and where it stands."""
    if values.ndim == 0:
        return f"{name}: {float(values)!r} was given"
    place = tuple(int(i) for i in np.argwhere(wrong)[0])
    return f"{name}[{', '.join(map(str, place))}]: {float(values[place])!r} was given"
