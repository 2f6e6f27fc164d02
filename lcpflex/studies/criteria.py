"""Where a result ceases to be sound."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

from lcpflex.errors import in_range

__all__ = ["Criteria"]


@dataclass(frozen=True, slots=True)
class Criteria:
    """Where a result ceases to be sound, or without trouble.

    Attributes
    ----------
    drift
        Largest penetration and joint drift, as a share of the largest extent of a body. The indentation under a law of
        the scene is none, that under a law of the method is. Not compared where bodies have no extent, as those of a
        :class:`UserSystem`, unless ``length`` is given.
    length
        Length [m] that penetration and joint drift are compared with instead.
    growth
        Energy gained without work of loads, as a share of the largest stored energy.
    divergence
        Energy gained without work of loads, in multiples of the energy that was there or was put in by loads, from
        which on the motion counts as diverged.
    remainder
        Unexplained energy, as a share of the largest stored energy.
    residual
        Natural-map residual of a contact problem.
    error
        Largest error, of the ``check`` of :func:`stability` and relative to its truth, of an answer that counts as
        right.
    """

    drift: float = 1e-3
    length: float | None = None
    growth: float = 1e-2
    divergence: float = 10.0
    remainder: float = 0.05
    residual: float = 1e-6
    error: float = 1e-2

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if value is not None or field.name != "length":
                in_range(f"criteria.{field.name}", value, 0.0, math.inf, open_ends=True)
