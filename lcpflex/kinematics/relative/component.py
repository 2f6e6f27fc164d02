"""Component c = d.r of the way from Q to P along a direction d that is fixed in the world."""

from __future__ import annotations

from lcpflex.jit.kernel import kernel
from lcpflex.kinematics.relative.apart import Apart, Motion

__all__ = ["component_gradient", "component_value"]


@kernel
def component_value(at: Apart, dx: float, dy: float) -> float:
    """c [m]."""
    return dx * at.x + dy * at.y


@kernel
def component_gradient(at: Apart, motion: Motion, dx: float, dy: float) -> tuple[float, float, float, float, float]:
    """Gradient of c, and its bias d.b."""
    return dx, dy, 0.0, 0.0, dx * motion.bx + dy * motion.by
