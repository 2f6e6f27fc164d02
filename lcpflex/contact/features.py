"""Whether a slave is near one feature, seen from the frame of the feature's body."""

from __future__ import annotations

import math

from lcpflex.bodies.floating_frame import local_place
from lcpflex.compiled import FloatArray, kernel
from lcpflex.model import Model

__all__ = ["ARC", "COINCIDENT", "FACING", "SEGMENT", "foot", "may_touch", "shadows", "touches"]

SEGMENT = 0
ARC = 1
WIDEN = 1e-9  # relative, at the ends of segments and arcs: no slave falls between two
FACING = -1e-9  # a node whose own outward normal has a larger component along the other's cannot touch it
COINCIDENT = 1e-12  # [m] two points so close have no direction from one to the other


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
def may_touch(model: Model, f: int, x: float, y: float, reach: float, sway: float, below: bool) -> bool:
    """Whether a slave at (x, y), in the frame of feature f, is within ``reach`` of its undeformed shape.

    ``below``: or under it. ``sway``, the deformation of the feature's surface, bounds nothing on a half-plane, which
    goes on for ever.
    """
    c = model.contacts
    place = model.points.place
    a = c.feature_point[f, 0]
    dx = x - place[a, 0]
    dy = y - place[a, 1]
    if c.feature_kind[f] == ARC:
        R = c.feature_radius[f]
        if R >= 0.0:
            return dx * dx + dy * dy <= (R + reach) * (R + reach)
        depth = math.hypot(dx, dy) + R  # below the wall of a hole
        return -reach <= depth <= reach + c.feature_reach[f]
    b = c.feature_point[f, 1]
    ex = place[b, 0] - place[a, 0]
    ey = place[b, 1] - place[a, 1]
    l2 = ex * ex + ey * ey
    along = ex * dx + ey * dy
    across = ey * dx - ex * dy
    if below and across < 0.0:  # the surface may be solid deep down
        reach += c.feature_reach[f]
    unbounded = c.feature_span[f, 1] == math.inf
    if unbounded and sway > 0.0:
        return True
    if across * across > reach * reach * l2:
        return False
    if unbounded:
        return True
    beyond = max(-along, along - l2)
    return beyond <= 0.0 or beyond * beyond <= reach * reach * l2


@kernel
def in_wedge(model: Model, q: FloatArray, f: int, x: float, y: float) -> bool:
    """Whether a slave at (x, y), in the frame of its body, lies beyond both segments that meet in the vertex f."""
    c = model.contacts
    before = c.feature_neighbour[f, 0]
    after = c.feature_neighbour[f, 1]
    vx, vy = local_place(model.bodies, model.points, q, c.feature_point[f, 0])
    nx = 0.0
    ny = 0.0
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
        if before >= 0 and nx * my - ny * mx <= 0.0:
            return False  # bent to a hollow: what is beyond both is below
    return True


@kernel
def under_hollow(model: Model, q: FloatArray, f: int, after: bool, x: float, y: float, nx: float, ny: float) -> bool:
    """Whether a slave, below f and beyond its end (``after``) or start, is beyond the next one, too: at a hollow."""
    c = model.contacts
    g = c.feature_neighbour[f, 1 if after else 0]
    if g < 0:
        return False
    ax, ay = local_place(model.bodies, model.points, q, c.feature_point[g, 0])
    bx, by = local_place(model.bodies, model.points, q, c.feature_point[g, 1])
    s, _, gx, gy = foot(ax, ay, bx, by, x, y)
    turn = nx * gy - ny * gx
    if after:
        return turn < 0.0 and s < -WIDEN
    return turn > 0.0 and s > 1.0 + WIDEN


@kernel
def touches(
    model: Model, q: FloatArray, f: int, x: float, y: float, radius: float, margin: float
) -> tuple[bool, float, float, float]:
    """Whether a slave at (x, y), in the frame of the body of f, is near and over f; depth of its centre, and normal.

    The depth counts below segments and is 0 for arcs.
    """
    c = model.contacts
    ax, ay = local_place(model.bodies, model.points, q, c.feature_point[f, 0])
    if c.feature_kind[f] == SEGMENT:
        bx, by = local_place(model.bodies, model.points, q, c.feature_point[f, 1])
        s, d, nx, ny = foot(ax, ay, bx, by, x, y)
        over = -c.feature_reach[f] < d <= margin + radius
        beyond = max(c.feature_span[f, 0] - s, s - c.feature_span[f, 1])
        if beyond <= WIDEN or not over:
            return over, max(-d, 0.0), nx, ny
        depth = math.hypot(d, beyond * math.hypot(bx - ax, by - ay))
        return d < 0.0 and under_hollow(model, q, f, s > 0.5, x, y, nx, ny), depth, nx, ny
    R = c.feature_radius[f]
    sense = c.feature_sense[f]
    dx = x - ax
    dy = y - ay
    D = math.hypot(dx, dy)
    if not -c.feature_reach[f] < sense * D - R <= margin + radius:
        return False, 0.0, 0.0, 0.0
    if D < COINCIDENT:  # no direction: any will do, but a vertex leaves the slave to its segments
        return R != 0.0, 0.0, 0.0, 1.0
    if R == 0.0:
        return in_wedge(model, q, f, x, y), 0.0, dx / D, dy / D
    extent = c.feature_span[f, 1] + 2.0 * WIDEN
    if extent < 2.0 * math.pi:
        angle = math.atan2(dy, dx) - c.feature_span[f, 0] + WIDEN
        p = c.feature_point[f, 0]
        body = model.points.body[p]
        start = model.points.start[p]
        for k in range(model.points.start[p + 1] - start):  # turned with the material at its centre
            angle -= model.points.psi[start + k] * q[model.bodies.dof[body] + 3 + k]
        if angle - 2.0 * math.pi * math.floor(angle / (2.0 * math.pi)) > extent:
            return False, 0.0, 0.0, 0.0
    return True, 0.0, sense * dx / D, sense * dy / D


@kernel
def shadows(
    model: Model,
    q: FloatArray,
    g: int,
    f: int,
    x: float,
    y: float,
    depth: float,
    nx: float,
    ny: float,
    mx: float,
    my: float,
) -> bool:
    """Whether a slave, ``depth`` from segment f with normal (nx, ny) and below it, is nearer to g of the same chain.

    It is then outside, beyond g, or in the solid with a nearer way out. It is neither if f and g make a hollow corner,
    or if g looks the way of (mx, my), the slave's own outward normal, and so cannot be where it came in.
    """
    c = model.contacts
    ga = c.feature_point[g, 0]
    gb = c.feature_point[g, 1]
    ax, ay = local_place(model.bodies, model.points, q, ga)
    bx, by = local_place(model.bodies, model.points, q, gb)
    s, d, gx, gy = foot(ax, ay, bx, by, x, y)
    turn = gx * ny - gy * nx
    if (gb == c.feature_point[f, 0] and turn < 0.0) or (ga == c.feature_point[f, 1] and turn > 0.0):
        return False
    length = math.hypot(bx - ax, by - ay)
    if d <= WIDEN * length and mx * gx + my * gy > -FACING:
        return False
    beyond = max(-s, s - 1.0, 0.0) * length
    return math.hypot(d, beyond) < depth * (1.0 - WIDEN)
