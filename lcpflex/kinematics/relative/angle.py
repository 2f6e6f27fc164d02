"""Angle alpha_P - alpha_Q between the material at P and that at Q."""

from __future__ import annotations

from lcpflex.jit.kernel import kernel
from lcpflex.kinematics.relative.apart import Apart

__all__ = ["angle_gradient", "angle_value"]


@kernel
def angle_value(at: Apart) -> float:
    """alpha_P - alpha_Q [rad]."""
    return at.angle_p - at.angle_q


@kernel
def angle_gradient() -> tuple[float, float, float, float, float]:
    """It is linear: no bias."""
    return 0.0, 0.0, 1.0, -1.0, 0.0
