"""The kinds of relative coordinates, and the one place that chooses among them.

Scenes name them by ``KINDS``; kernels know them by the place in that table. Each has a value c(r, alpha_P, alpha_Q) and

    cdot = g.v + g_P alphadot_P + g_Q alphadot_Q,   cddot = J udot + bias,

the gradient (g, g_P, g_Q) of which makes the row J, and the generalised force of a force along c.
"""

from __future__ import annotations

from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.kinematics.points import add_point_row, add_rotation_row
from lcpflex.kinematics.relative.along import along_gradient, along_value
from lcpflex.kinematics.relative.angle import angle_gradient, angle_value
from lcpflex.kinematics.relative.apart import Apart, Motion
from lcpflex.kinematics.relative.component import component_gradient, component_value
from lcpflex.kinematics.relative.distance import distance_gradient, distance_value
from lcpflex.model.arrays import Bodies, Points

__all__ = [
    "ALONG",
    "ANGLE",
    "COMPONENT",
    "DISTANCE",
    "KINDS",
    "UNITS",
    "add_gradient",
    "coordinate_gradient",
    "coordinate_value",
]

KINDS = ("component", "along", "angle", "distance")
UNITS = ("m", "m", "rad", "m")
COMPONENT, ALONG, ANGLE, DISTANCE = range(len(KINDS))


@kernel
def coordinate_value(kind: int, at: Apart, ax: float, ay: float) -> float:
    """c [m] or [rad]; (ax, ay): the direction that the coordinate has, if it has one."""
    if kind == COMPONENT:
        return component_value(at, ax, ay)
    if kind == ALONG:
        return along_value(at, ax, ay)
    if kind == ANGLE:
        return angle_value(at)
    return distance_value(at)


@kernel
def coordinate_gradient(
    kind: int, at: Apart, motion: Motion, ax: float, ay: float
) -> tuple[float, float, float, float, float]:
    """g_x, g_y, g_P, g_Q and the bias of a coordinate."""
    if kind == COMPONENT:
        return component_gradient(at, motion, ax, ay)
    if kind == ALONG:
        return along_gradient(at, motion, ax, ay)
    if kind == ANGLE:
        return angle_gradient()
    return distance_gradient(at, motion)


@kernel
def add_gradient(
    bodies: Bodies,
    points: Points,
    q: FloatArray,
    ends: tuple[int, int],
    gradient: tuple[float, float, float, float, float],
    scale: float,
    on_p: FloatArray,
    on_q: FloatArray,
) -> None:
    """Add ``scale`` times the gradient, as generalised forces, to the blocks of the bodies of P and Q = ``ends``."""
    gx, gy, turn_p, turn_q, _ = gradient
    if gx != 0.0 or gy != 0.0:
        add_point_row(bodies, points, q, ends[0], scale * gx, scale * gy, on_p)
        add_point_row(bodies, points, q, ends[1], -scale * gx, -scale * gy, on_q)
    if turn_p != 0.0:
        add_rotation_row(bodies, points, ends[0], scale * turn_p, on_p)
    if turn_q != 0.0:
        add_rotation_row(bodies, points, ends[1], scale * turn_q, on_q)
