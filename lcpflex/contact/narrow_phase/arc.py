"""A piece of a circle about a material point o, of signed radius R: > 0 solid inside, < 0 a hole.

With n = sense (r_P - r_o) / |.|, the gap is sense |r_P - r_o| - R less the radius of the node.
"""

from __future__ import annotations

import math

from lcpflex.contact.narrow_phase.limits import COINCIDENT, NOWHERE, SPAN_TOLERANCE, WIDEN
from lcpflex.contact.table import ContactTable
from lcpflex.jit.kernel import FloatArray, kernel, late_kernel
from lcpflex.kinematics.points import (
    add_point_rows,
    add_rotation_row,
    local_place,
    motion_between,
    point_angle,
    point_motion,
    point_position,
)
from lcpflex.model.arrays import Model
from lcpflex.model.planar import N_RIGID

__all__ = [
    "arc_bias",
    "arc_margin",
    "arc_rows",
    "arc_velocity",
    "in_arc",
    "near_arc",
    "over_arc",
    "refresh_arc",
    "within_arc",
]


@kernel
def in_arc(model: Model, q: FloatArray, p: int, angle: float, start: float, extent: float) -> bool:
    """Whether ``angle``, in the frame of the body of p, is in an arc that turns with the material at p."""
    extent += 2.0 * WIDEN
    if extent >= 2.0 * math.pi:
        return True
    angle -= start - WIDEN
    body = model.points.body[p]
    first = model.points.start[p]
    for k in range(model.points.start[p + 1] - first):
        angle -= model.points.psi[first + k] * q[model.bodies.dof[body] + N_RIGID + k]
    return angle - 2.0 * math.pi * math.floor(angle / (2.0 * math.pi)) <= extent


@kernel
def near_arc(model: Model, f: int, x: float, y: float, reach: float) -> bool:
    """Whether a node at (x, y), in the frame of arc f, is within ``reach`` of it, undeformed, or inside the solid."""
    c = model.contacts
    a = c.feature_point[f, 0]
    dx = x - model.points.place[a, 0]
    dy = y - model.points.place[a, 1]
    R = c.feature_radius[f]
    if R >= 0.0:
        return dx * dx + dy * dy <= (R + reach) * (R + reach)
    depth = math.hypot(dx, dy) + R  # behind the wall of a hole
    return -reach <= depth <= reach + c.feature_depth[f, 1]


@late_kernel
def over_arc(
    model: Model, q: FloatArray, f: int, x: float, y: float, highest: float
) -> tuple[bool, float, float, float, float, float]:
    """As :func:`lcpflex.contact.narrow_phase.feature.over`."""
    c = model.contacts
    ax, ay = local_place(model.bodies, model.points, q, c.feature_point[f, 0])
    R = c.feature_radius[f]
    sense = c.feature_sense[f]
    dx = x - ax
    dy = y - ay
    D = math.hypot(dx, dy)
    d = sense * D - R
    if d > highest or d < -c.feature_depth[f, 1]:
        return NOWHERE
    if D < COINCIDENT:  # no direction: any will do
        return True, 0.0, d, 0.0, 1.0, abs(d)
    p = c.feature_point[f, 0]
    inside = in_arc(model, q, p, math.atan2(dy, dx), c.feature_span[f, 0], c.feature_span[f, 1])
    return inside, 0.0, d, sense * dx / D, sense * dy / D, abs(d)


@kernel
def refresh_arc(model: Model, q: FloatArray, table: ContactTable, k: int) -> None:
    """Gap and normal of entry k at q. At the very centre there is no direction: the normal stays what it was."""
    px, py = point_position(model.bodies, model.points, q, table.node[k])
    ax, ay = point_position(model.bodies, model.points, q, table.a[k])
    D = math.hypot(px - ax, py - ay)
    sense = table.sense[k]
    if D >= COINCIDENT:
        table.normal[k, 0] = sense * (px - ax) / D
        table.normal[k, 1] = sense * (py - ay) / D
    table.gap[k] = sense * D - table.radius[k] - table.node_radius[k]


@kernel
def within_arc(angle: float, start: float, extent: float) -> float:
    """How far an angle is inside an arc [rad]."""
    if extent >= 2.0 * math.pi - SPAN_TOLERANCE:
        return math.inf
    angle -= start + 0.5 * extent
    return 0.5 * extent - abs(angle - 2.0 * math.pi * math.floor(angle / (2.0 * math.pi) + 0.5))


@kernel
def arc_margin(model: Model, q: FloatArray, table: ContactTable, k: int) -> float:
    """How far the node of entry k is over its arc [rad]."""
    px, py = point_position(model.bodies, model.points, q, table.node[k])
    x, y = point_position(model.bodies, model.points, q, table.a[k])
    angle = math.atan2(py - y, px - x) - point_angle(model.bodies, model.points, q, table.a[k])
    return within_arc(angle, table.span[k, 0], table.span[k, 1])


@late_kernel
def arc_rows(
    model: Model, q: FloatArray, table: ContactTable, k: int, normal_row: FloatArray, tangent_row: FloatArray
) -> None:
    """Blocks of the body of the feature in the rows of entry k."""
    a = table.a[k]
    nx = table.normal[k, 0]
    ny = table.normal[k, 1]
    add_point_rows(model.bodies, model.points, q, a, -nx, -ny, normal_row, tangent_row)
    if table.radius[k] != 0.0:
        add_rotation_row(model.points, a, table.radius[k], tangent_row)


@kernel
def arc_velocity(model: Model, q: FloatArray, u: FloatArray, table: ContactTable, k: int) -> tuple[float, float]:
    """Velocity of the centre [m/s]."""
    _, _, wx, wy, _, _ = point_motion(model.bodies, model.points, q, u, table.a[k])
    return wx, wy


@late_kernel
def arc_bias(model: Model, q: FloatArray, u: FloatArray, table: ContactTable, k: int) -> tuple[float, float]:
    """w_N and w_T [m/s^2] of entry k."""
    nx = table.normal[k, 0]
    ny = table.normal[k, 1]
    tx = ny
    ty = -nx
    dx, dy, wx, wy, rx, ry = motion_between(model.bodies, model.points, q, u, table.node[k], table.a[k])
    distance = max(math.hypot(dx, dy), COINCIDENT)
    turn = table.sense[k] * (-ny * wx + nx * wy) / distance
    return nx * rx + ny * ry + turn * (-ny * wx + nx * wy), tx * rx + ty * ry + turn * (-ty * wx + tx * wy)
