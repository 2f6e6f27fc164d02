"""Whether a slave is near one feature and over it, seen from the frame of the feature's body."""

from __future__ import annotations

import math

from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.kinematics.points import local_place
from lcpflex.model.arrays import Model
from lcpflex.model.planar import N_RIGID

__all__ = ["ARC", "COINCIDENT", "SEGMENT", "WIDEN", "foot", "in_arc", "may_touch", "near_block", "over"]

SEGMENT = 0
ARC = 1
WIDEN = 1e-9  # relative, at the ends of segments and arcs: no slave falls between two
COINCIDENT = 1e-12  # [m] two points so close have no direction from one to the other
ASIDE = 1.75  # more than tan 60 degrees
NOWHERE = (False, 0.0, 0.0, 0.0, 0.0, 0.0)


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
    """How deep below s on the segment f, or behind the wall of the arc f, a slave still belongs to it [m]."""
    reach = model.contacts.feature_reach
    end = reach[f, 0] if s < 0.5 else reach[f, 2]
    middle = reach[f, 1]
    if end == middle:
        return middle
    part = min(abs(2.0 * s - 1.0), 1.0)
    return (1.0 - part) * middle + part * end


@kernel
def near_block(model: Model, block: int, x: float, y: float, reach: float) -> bool:
    """Whether a slave at (x, y), in the frame of the features, may be within ``reach`` of a block of them, or below it.

    Normals of a block with a height deviate from their mean n by less than 60 degrees, so that what is h lower than
    its top is farther aside than its points by no more than h tan 60 degrees.
    """
    circle = model.contacts.block_circle
    height = model.contacts.block_height
    dx = x - circle[block, 0]
    dy = y - circle[block, 1]
    d2 = dx * dx + dy * dy
    if d2 <= (reach + circle[block, 2]) ** 2:
        return True
    if d2 > (reach + circle[block, 3]) ** 2:
        return False
    nx = height[block, 0]
    ny = height[block, 1]
    if nx == 0.0 and ny == 0.0:
        return True
    low = height[block, 2] + reach - nx * x - ny * y
    return low >= 0.0 and abs(nx * dy - ny * dx) <= circle[block, 2] + reach + ASIDE * low


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
        depth = math.hypot(dx, dy) + R  # behind the wall of a hole
        return -reach <= depth <= reach + c.feature_reach[f, 1]
    b = c.feature_point[f, 1]
    ex = place[b, 0] - place[a, 0]
    ey = place[b, 1] - place[a, 1]
    l2 = ex * ex + ey * ey
    along = ex * dx + ey * dy
    across = ey * dx - ex * dy
    if across < 0.0:
        reach += max(c.feature_reach[f, 0], c.feature_reach[f, 1], c.feature_reach[f, 2])
    unbounded = c.feature_neighbour[f, 0] < 0 and c.feature_span[f, 1] == math.inf
    if unbounded and sway > 0.0:
        return True
    if across * across > reach * reach * l2:
        return False
    if unbounded:
        return True
    beyond = max(-along, along - l2)
    return beyond <= 0.0 or beyond * beyond <= reach * reach * l2


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
def held(model: Model, q: FloatArray, f: int, side: int, x: float, y: float, nx: float, ny: float) -> bool:
    """Whether a slave beyond the end ``side`` of segment f may belong to it because of the next segment.

    At a hollow corner, a slave that is over neither segment is in the solid: only both together lead it out, by the
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
        if before >= 0 and nx * my - ny * mx <= 0.0 and nx * mx + ny * my > -1.0 + WIDEN:
            return False  # bent to a hollow: what is beyond both is below
    return True


@kernel
def over(
    model: Model, q: FloatArray, f: int, x: float, y: float, highest: float
) -> tuple[bool, float, float, float, float, float]:
    """Whether a slave at (x, y), in the frame of the body of f, is over f, at most ``highest`` above and not too deep.

    Further s, the signed distance without radius of the slave from the line or circle of f, the normal, and how far
    the slave is from f itself: beyond the end of a segment from that end, not from its line.
    """
    c = model.contacts
    ax, ay = local_place(model.bodies, model.points, q, c.feature_point[f, 0])
    if c.feature_kind[f] == SEGMENT:
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
    R = c.feature_radius[f]
    sense = c.feature_sense[f]
    dx = x - ax
    dy = y - ay
    D = math.hypot(dx, dy)
    d = sense * D - R
    if d > highest or d < -c.feature_reach[f, 1]:
        return NOWHERE
    if D < COINCIDENT:  # no direction: any will do, but a vertex leaves the slave to its segments
        return R != 0.0, 0.0, d, 0.0, 1.0, abs(d)
    if R == 0.0:
        return in_wedge(model, q, f, x, y), 0.0, d, dx / D, dy / D, D
    p = c.feature_point[f, 0]
    inside = in_arc(model, q, p, math.atan2(dy, dx), c.feature_span[f, 0], c.feature_span[f, 1])
    return inside, 0.0, d, sense * dx / D, sense * dy / D, abs(d)
