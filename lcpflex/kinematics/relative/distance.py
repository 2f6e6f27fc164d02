"""Distance L = |r| of P and Q: with e = r / L, Ldot = e.v and bias = e.b + (v.v - (e.v)^2) / L."""

from __future__ import annotations

import math

from lcpflex.jit.kernel import kernel
from lcpflex.kinematics.relative.apart import Apart, Motion

__all__ = ["distance_gradient", "distance_value"]

SMALLEST_LENGTH = 1e-300  # [m] a shorter vector has no direction


@kernel
def distance_value(at: Apart) -> float:
    """L [m]."""
    return math.hypot(at.x, at.y)


@kernel
def distance_gradient(at: Apart, motion: Motion) -> tuple[float, float, float, float, float]:
    """Gradient and bias of L; points that coincide have no gradient."""
    length = max(math.hypot(at.x, at.y), SMALLEST_LENGTH)
    ex = at.x / length
    ey = at.y / length
    across = ex * motion.vy - ey * motion.vx
    return ex, ey, 0.0, 0.0, ex * motion.bx + ey * motion.by + across * across / length
