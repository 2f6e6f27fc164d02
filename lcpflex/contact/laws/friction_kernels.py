"""Friction of continuous contact: the tangential force of a slip velocity, a normal force and states of its own."""

from __future__ import annotations

import math

from lcpflex.compiled import FloatArray, IntArray, kernel
from lcpflex.contact.laws.layout import FRICTION

__all__ = ["bristle_rates", "friction_force"]


@kernel
def friction_force(
    kinds: IntArray, p: FloatArray, slip: float, normal: float, mu: float, bristle: float, dwell: float
) -> float:
    """Tangential force [N] on the slave at a slip velocity [m/s] under a normal force >= 0 [N]: it opposes the slip.

    ``bristle`` [m] and ``dwell`` are the states of laws that have some.
    """
    return -mu * normal * math.tanh(slip / p[FRICTION])


@kernel
def bristle_rates(
    kinds: IntArray, p: FloatArray, slip: float, normal: float, mu: float, bristle: float, dwell: float
) -> tuple[float, float]:
    """Rates of the two states of a friction law [m/s, 1/s]; zero for laws without."""
    return 0.0, 0.0
