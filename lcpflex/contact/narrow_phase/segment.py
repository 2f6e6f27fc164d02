"""A segment from material point a to b: solid on its left, its outward normal on its right. Half-planes are some.

With Q = r_a + s e, e = r_b - r_a, the gap is n.(r_P - Q) less the radius of the node; Q slides along e.
"""

from __future__ import annotations

import math

from lcpflex.contact.narrow_phase.limits import NOWHERE, WIDEN
from lcpflex.contact.table import ContactTable
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.kinematics.points import add_point_rows, local_place, motion_between, point_motion, point_position
from lcpflex.model.arrays import Model

__all__ = [
    "foot",
    "near_segment",
    "over_segment",
    "refresh_segment",
    "segment_bias",
    "segment_rows",
    "segment_velocity",
]


@kernel
def foot(ax: float, ay: float, bx: float, by: float, px: float, py: float) -> tuple[float, float, float, float]:
    """Of the point p over the segment a-b: place s of its foot, signed distance, outward normal."""
    ex = bx - ax
    ey = by - ay
    l2 = ex * ex + ey * ey
    length = math.sqrt(l2)
    dx = px - ax
    dy = py - ay
    return (ex * dx + ey * dy) / l2, (ey * dx - ex * dy) / length, ey / length, -ex / length


@kernel
def deep(model: Model, f: int, s: float) -> float:
    """How deep below s on the segment f a node still belongs to it [m]."""
    reach = model.contacts.feature_depth
    end = reach[f, 0] if s < 0.5 else reach[f, 2]
    middle = reach[f, 1]
    if end == middle:
        return middle
    part = min(abs(2.0 * s - 1.0), 1.0)
    return (1.0 - part) * middle + part * end


@kernel
def near_segment(model: Model, f: int, x: float, y: float, reach: float, deflection: float) -> bool:
    """Whether a node at (x, y), in the frame of segment f, is within ``reach`` of it, undeformed, or below it.

    ``deflection``, the deformation of the feature's surface, bounds nothing on a half-plane, which goes on for ever.
    """
    c = model.contacts
    place = model.points.place
    a = c.feature_point[f, 0]
    dx = x - place[a, 0]
    dy = y - place[a, 1]
    b = c.feature_point[f, 1]
    ex = place[b, 0] - place[a, 0]
    ey = place[b, 1] - place[a, 1]
    l2 = ex * ex + ey * ey
    along = ex * dx + ey * dy
    across = ey * dx - ex * dy
    if across < 0.0:
        reach += max(c.feature_depth[f, 0], c.feature_depth[f, 1], c.feature_depth[f, 2])
    unbounded = c.feature_neighbour[f, 0] < 0 and c.feature_span[f, 1] == math.inf
    if unbounded and deflection > 0.0:
        return True
    if across * across > reach * reach * l2:
        return False
    if unbounded:
        return True
    beyond = max(-along, along - l2)
    return beyond <= 0.0 or beyond * beyond <= reach * reach * l2


@kernel
def held(model: Model, q: FloatArray, f: int, side: int, x: float, y: float, nx: float, ny: float) -> bool:
    """Whether a node beyond the end ``side`` of segment f may belong to it because of the next segment.

    At a hollow corner, a node that is over neither segment is in the solid: only both together lead it out, by the
    corner. One that is over the next segment, and below it, belongs to f as well if its foot is on f after it has been
    lifted out of the next one. Either way only where nothing else is nearer, which the table of candidates tells.
    """
    c = model.contacts
    g = c.feature_neighbour[f, side]
    if g < 0:
        return c.feature_span[f, side] != float(side)  # a half-plane has no end
    ax, ay = local_place(model.bodies, model.points, q, c.feature_point[g, 0])
    bx, by = local_place(model.bodies, model.points, q, c.feature_point[g, 1])
    r, d, mx, my = foot(ax, ay, bx, by, x, y)
    turn = nx * my - ny * mx
    if (turn if side == 1 else -turn) >= 0.0:
        return False
    if side == 0:
        r = 1.0 - r
    if r <= 0.0:
        return True
    if d >= 0.0 or r > 1.0 + WIDEN:
        return False
    vx = bx if side == 0 else ax
    vy = by if side == 0 else ay
    # lifted by -d along (mx, my); the direction of f is (-ny, nx)
    along = -ny * (x - d * mx - vx) + nx * (y - d * my - vy)
    slack = WIDEN * math.hypot(bx - ax, by - ay)
    return along <= slack if side == 1 else along >= -slack


@kernel
def over_segment(
    model: Model, q: FloatArray, f: int, x: float, y: float, highest: float
) -> tuple[bool, float, float, float, float, float]:
    """As :func:`lcpflex.contact.narrow_phase.feature.over`: beyond an end, the node is as far as it is from that."""
    c = model.contacts
    ax, ay = local_place(model.bodies, model.points, q, c.feature_point[f, 0])
    bx, by = local_place(model.bodies, model.points, q, c.feature_point[f, 1])
    s, d, nx, ny = foot(ax, ay, bx, by, x, y)
    if d > highest or d < -deep(model, f, s):
        return NOWHERE
    if -WIDEN <= s <= 1.0 + WIDEN:
        return True, s, d, nx, ny, abs(d)
    side = 0 if s < 0.0 else 1
    away = abs(d)
    if c.feature_neighbour[f, side] >= 0:
        away = math.hypot(x - ax, y - ay) if side == 0 else math.hypot(x - bx, y - by)
    return held(model, q, f, side, x, y, nx, ny), s, d, nx, ny, away


@kernel
def refresh_segment(model: Model, q: FloatArray, table: ContactTable, k: int) -> None:
    """Gap, normal and foot of entry k at q; the foot may leave the segment."""
    px, py = point_position(model.bodies, model.points, q, table.node[k])
    ax, ay = point_position(model.bodies, model.points, q, table.a[k])
    bx, by = point_position(model.bodies, model.points, q, table.b[k])
    s, d, nx, ny = foot(ax, ay, bx, by, px, py)
    table.s[k] = s
    table.normal[k, 0] = nx
    table.normal[k, 1] = ny
    table.gap[k] = d - table.node_radius[k]


@kernel
def segment_rows(
    model: Model, q: FloatArray, table: ContactTable, k: int, normal_row: FloatArray, tangent_row: FloatArray
) -> None:
    """Blocks of the body of the feature in the rows of entry k."""
    s = table.s[k]
    nx = table.normal[k, 0]
    ny = table.normal[k, 1]
    a = table.a[k]
    b = table.b[k]
    add_point_rows(model.bodies, model.points, q, a, -(1.0 - s) * nx, -(1.0 - s) * ny, normal_row, tangent_row)
    add_point_rows(model.bodies, model.points, q, b, -s * nx, -s * ny, normal_row, tangent_row)


@kernel
def segment_velocity(model: Model, q: FloatArray, u: FloatArray, table: ContactTable, k: int) -> tuple[float, float]:
    """Velocity of the foot on the material [m/s]."""
    _, _, wx, wy, _, _ = point_motion(model.bodies, model.points, q, u, table.a[k])
    _, _, ex, ey, _, _ = point_motion(model.bodies, model.points, q, u, table.b[k])
    return wx + table.s[k] * (ex - wx), wy + table.s[k] * (ey - wy)


@kernel
def segment_bias(model: Model, q: FloatArray, u: FloatArray, table: ContactTable, k: int) -> tuple[float, float]:
    """w_N and w_T [m/s^2] of entry k."""
    nx = table.normal[k, 0]
    ny = table.normal[k, 1]
    tx = ny
    ty = -nx
    dx, dy, wx, wy, rx, ry = motion_between(model.bodies, model.points, q, u, table.node[k], table.a[k])
    ex, ey, fx, fy, bx, by = motion_between(model.bodies, model.points, q, u, table.b[k], table.a[k])
    l2 = ex * ex + ey * ey
    s = table.s[k]
    turn = (ex * fy - ey * fx) / l2
    slide = (fx * dx + fy * dy + ex * wx + ey * wy - 2.0 * s * (ex * fx + ey * fy)) / l2
    rx -= s * bx
    ry -= s * by
    wx -= s * fx
    wy -= s * fy
    # ndot = turn J n, tdot = turn J t
    w_n = nx * rx + ny * ry + turn * (-ny * wx + nx * wy) - slide * (nx * fx + ny * fy)
    w_t = tx * rx + ty * ry + turn * (-ty * wx + tx * wy) - slide * (tx * fx + ty * fy)
    return w_n, w_t
