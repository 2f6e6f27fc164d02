"""Whether a slave is near one feature, seen from the frame of the feature's body."""

from __future__ import annotations

import math

from lcpflex.bodies.floating_frame import local_place
from lcpflex.compiled import FloatArray, kernel
from lcpflex.model import Model

__all__ = ["ARC", "COINCIDENT", "SEGMENT", "foot", "may_touch", "touches"]

SEGMENT = 0
ARC = 1
WIDEN = 1e-9  # relative, at the ends of segments and arcs: no slave falls between two
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
def may_touch(model: Model, f: int, x: float, y: float, reach: float, sway: float) -> bool:
    """Whether a slave at (x, y), in the frame of feature f, is within ``reach`` of its undeformed shape or below it.

    ``sway``, the deformation of the feature's surface, bounds nothing on a half-plane, which goes on for ever.
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
    if across < 0.0:  # below the surface, which may be solid deep down
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
def touches(
    model: Model, q: FloatArray, f: int, x: float, y: float, radius: float, margin: float
) -> tuple[bool, float, float]:
    """Whether a slave at (x, y), in the frame of the body of f, is near and over f; and the normal in that frame."""
    c = model.contacts
    ax, ay = local_place(model.bodies, model.points, q, c.feature_point[f, 0])
    if c.feature_kind[f] == SEGMENT:
        bx, by = local_place(model.bodies, model.points, q, c.feature_point[f, 1])
        s, d, nx, ny = foot(ax, ay, bx, by, x, y)
        over = c.feature_span[f, 0] - WIDEN <= s <= c.feature_span[f, 1] + WIDEN
        return over and -c.feature_reach[f] < d <= margin + radius, nx, ny
    R = c.feature_radius[f]
    sense = c.feature_sense[f]
    dx = x - ax
    dy = y - ay
    D = math.hypot(dx, dy)
    if not -c.feature_reach[f] < sense * D - R <= margin + radius:
        return False, 0.0, 0.0
    if D < COINCIDENT:  # no direction: any will do, but a vertex leaves the slave to its segments
        return R != 0.0, 0.0, 1.0
    if R == 0.0:
        return in_wedge(model, q, f, x, y), dx / D, dy / D
    extent = c.feature_span[f, 1] + 2.0 * WIDEN
    if extent < 2.0 * math.pi:
        angle = math.atan2(dy, dx) - c.feature_span[f, 0] + WIDEN
        p = c.feature_point[f, 0]
        body = model.points.body[p]
        start = model.points.start[p]
        for k in range(model.points.start[p + 1] - start):  # turned with the material at its centre
            angle -= model.points.psi[start + k] * q[model.bodies.dof[body] + 3 + k]
        if angle - 2.0 * math.pi * math.floor(angle / (2.0 * math.pi)) > extent:
            return False, 0.0, 0.0
    return True, sense * dx / D, sense * dy / D
