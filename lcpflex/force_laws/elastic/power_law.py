"""The generic law K delta^n."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

from lcpflex.basics.arguments import flag
from lcpflex.errors import in_range
from lcpflex.force_laws.elastic.law import ElasticFace

__all__ = ["PowerLaw"]


@dataclass(frozen=True, slots=True, init=False, repr=False)
class PowerLaw(ElasticFace):
    """F = K delta^n, energy K delta^(n+1) / (n + 1), at any indentation.

    Parameters
    ----------
    stiffness
        K > 0 [N/m^n]; kept as ``constant``, because ``stiffness(delta)`` is the slope of every elastic law.
    exponent
        n >= 1: 1 a linear spring, 3/2 Hertz's contact of curved bodies.
    lenient
        Of no effect here: the law has no range of validity to leave.

    Raises
    ------
    ModelError
        For a number out of its range.
    """

    kind: ClassVar[str] = "power"
    constant: float
    exponent: float
    lenient: bool

    def __init__(self, stiffness: float, exponent: float = 1.5, *, lenient: bool = False) -> None:
        object.__setattr__(self, "constant", in_range("stiffness", stiffness, 0.0, math.inf, open_ends=True))
        object.__setattr__(self, "exponent", in_range("exponent", exponent, 1.0, math.inf))
        object.__setattr__(self, "lenient", flag("lenient", lenient))

    def __repr__(self) -> str:
        return f"PowerLaw({self.constant!r}, exponent={self.exponent!r}, lenient={self.lenient!r})"

    @property
    def parameters(self) -> tuple[float, ...]:
        """K, n."""
        return self.constant, self.exponent
