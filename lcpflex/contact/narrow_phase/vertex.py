"""A vertex: where two segments of a chain meet in a bulge, or one or an arc ends: an arc of radius 0 bound by them."""

from __future__ import annotations

import math

from lcpflex.contact.narrow_phase.limits import COINCIDENT, NOWHERE, WIDEN
from lcpflex.contact.narrow_phase.segment import foot
from lcpflex.contact.table import ContactTable
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.kinematics.points import local_place, point_position
from lcpflex.model.arrays import Model

__all__ = ["over_vertex", "vertex_margin"]


@kernel
def beyond_arc(vx: float, vy: float, ox: float, oy: float, x: float, y: float, ends: bool) -> float:
    """Sine of the angle about o by which (x, y) is beyond the end v of an arc, or before its beginning."""
    ex = vx - ox
    ey = vy - oy
    dx = x - ox
    dy = y - oy
    turn = ex * dy - ey * dx
    reach = math.hypot(ex, ey) * math.hypot(dx, dy)
    return (turn if ends else -turn) / max(reach, COINCIDENT * COINCIDENT)


@kernel
def in_wedge(model: Model, q: FloatArray, f: int, x: float, y: float) -> bool:
    """Whether a node at (x, y), in the frame of its body, lies beyond both segments that meet in the vertex f."""
    c = model.contacts
    before = c.feature_neighbour[f, 0]
    after = c.feature_neighbour[f, 1]
    vx, vy = local_place(model.bodies, model.points, q, c.feature_point[f, 0])
    nx = 0.0
    ny = 0.0
    arc = max(before, after)
    if arc >= 0 and c.feature_radius[arc] != 0.0:  # segments have none
        ox, oy = local_place(model.bodies, model.points, q, c.feature_point[arc, 0])
        return beyond_arc(vx, vy, ox, oy, x, y, before >= 0) > WIDEN
    if before >= 0:
        ax, ay = local_place(model.bodies, model.points, q, c.feature_point[before, 0])
        s, _, nx, ny = foot(ax, ay, vx, vy, x, y)
        if s <= 1.0 + WIDEN:
            return False
    if after >= 0:
        bx, by = local_place(model.bodies, model.points, q, c.feature_point[after, 1])
        s, _, mx, my = foot(vx, vy, bx, by, x, y)
        if s >= -WIDEN:
            return False
        if before >= 0 and nx * my - ny * mx <= 0.0 and nx * mx + ny * my > -1.0 + WIDEN:
            return False  # bent to a hollow: what is beyond both is below
    return True


@kernel
def over_vertex(
    model: Model, q: FloatArray, f: int, x: float, y: float, highest: float
) -> tuple[bool, float, float, float, float, float]:
    """As :func:`lcpflex.contact.narrow_phase.feature.over`; a node at the very vertex is left to its segments."""
    ax, ay = local_place(model.bodies, model.points, q, model.contacts.feature_point[f, 0])
    dx = x - ax
    dy = y - ay
    D = math.hypot(dx, dy)
    if highest < D:
        return NOWHERE
    if D < COINCIDENT:
        return False, 0.0, D, 0.0, 1.0, D
    return in_wedge(model, q, f, x, y), 0.0, D, dx / D, dy / D, D


@kernel
def vertex_margin(model: Model, q: FloatArray, table: ContactTable, k: int) -> float:
    """How far the node of entry k is inside the wedge of its vertex, in lengths of the segments that meet there.

    At the end of an arc, in the sine of the angle beyond it.
    """
    px, py = point_position(model.bodies, model.points, q, table.node[k])
    x, y = point_position(model.bodies, model.points, q, table.a[k])
    margin = math.inf
    f = table.key[k] % len(model.contacts.feature_kind)
    for side in range(2):
        neighbour = model.contacts.feature_neighbour[f, side]
        if neighbour >= 0 and model.contacts.feature_radius[neighbour] != 0.0:
            ox, oy = point_position(model.bodies, model.points, q, model.contacts.feature_point[neighbour, 0])
            return beyond_arc(x, y, ox, oy, px, py, side == 0)
        if neighbour >= 0:
            far = model.contacts.feature_point[neighbour, side]
            ax, ay = point_position(model.bodies, model.points, q, far)
            margin = min(margin, ((px - x) * (x - ax) + (py - y) * (y - ay)) / ((x - ax) ** 2 + (y - ay) ** 2))
    return margin
