"""Component c = d.r of the way from Q to P along a direction d that is fixed in the material at Q.

With alpha the angle there, ddot = alphadot J d, J = [[0, -1], [1, 0]]:

    cdot = d.v + alphadot (J d).r,   bias = d.b + 2 alphadot (J d).v - alphadot^2 d.r
"""

from __future__ import annotations

import math

from lcpflex.jit.kernel import kernel
from lcpflex.kinematics.relative.apart import Apart, Motion

__all__ = ["along_gradient", "along_value"]


@kernel
def along_value(at: Apart, ax: float, ay: float) -> float:
    """c [m]; (ax, ay): the direction as the material at Q has it at angle 0."""
    dx = math.cos(at.angle_q) * ax - math.sin(at.angle_q) * ay
    dy = math.sin(at.angle_q) * ax + math.cos(at.angle_q) * ay
    return dx * at.x + dy * at.y


@kernel
def along_gradient(at: Apart, motion: Motion, ax: float, ay: float) -> tuple[float, float, float, float, float]:
    """Gradient and bias of c."""
    dx = math.cos(at.angle_q) * ax - math.sin(at.angle_q) * ay
    dy = math.sin(at.angle_q) * ax + math.cos(at.angle_q) * ay
    x, y, spin = at.x, at.y, motion.spin_q
    bias = dx * motion.bx + dy * motion.by + 2.0 * spin * (dx * motion.vy - dy * motion.vx)
    return dx, dy, 0.0, dx * y - dy * x, bias - spin * spin * (dx * x + dy * y)
