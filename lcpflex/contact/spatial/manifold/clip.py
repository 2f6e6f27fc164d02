"""The patch of two faces: the one, clipped by the sides of the other along its normal, and what made each corner.

Corners are where a vertex of the clipped face is, where one of its edges crosses a side, and where a vertex of the
other face is under it. Between two corners runs an edge of the one or a side of the other.
"""

from __future__ import annotations

from lcpflex.contact.spatial.manifold.axes import Pose, node_place, polygon_normal
from lcpflex.jit.kernel import FloatArray, IntArray, kernel
from lcpflex.kinematics.spatial.rotations import Vector, cross
from lcpflex.kinematics.spatial.vectors import added, apart_from, dot, norm, row_vector, scaled, turned
from lcpflex.model.spatial import SpatialModel

__all__ = ["CROSSING", "INCIDENT", "REFERENCE", "beyond_side", "clip_face"]

# what makes a corner: a vertex of the clipped face, a crossing, a vertex of the other face
INCIDENT, CROSSING, REFERENCE = range(3)
MADE, FIRST, SECOND, CARRIER = range(4)  # columns of ``trace``


@kernel
def side_of_polygon(model: SpatialModel, k: int, end: int, n: Vector) -> tuple[Vector, Vector]:
    """Where side k begins [m], and the unit vector across it out of its face with normal n, in the frame of its body.

    end: the side behind it.
    """
    node = model.contacts.side_node
    start = node_place(model, node[k])
    out = cross(apart_from(node_place(model, node[end]), start), n)
    return start, scaled(1.0 / norm(out), out)


@kernel
def next_side(model: SpatialModel, p: int, k: int) -> int:
    """The side of polygon p behind side k."""
    start = model.contacts.side_start
    return k + 1 if k + 1 < start[p + 1] else start[p]


@kernel
def beyond_side(model: SpatialModel, p: int, place: Vector) -> float:
    """How far a place is beyond the sides of polygon p, in its frame, at most; below 0 over the polygon [m]."""
    n = polygon_normal(model, p)
    start = model.contacts.side_start
    most = -1e300
    for k in range(start[p], start[p + 1]):
        at, out = side_of_polygon(model, k, next_side(model, p, k), n)
        most = max(most, dot(out, apart_from(place, at)))
    return most


@kernel
def lay_corner(at: FloatArray, trace: IntArray, j: int, place: Vector, made: int, first: int, second: int) -> None:
    """Corner j of the polygon that is being made."""
    at[j, 0], at[j, 1], at[j, 2] = place
    trace[j, MADE], trace[j, FIRST], trace[j, SECOND] = made, first, second


@kernel
def lay_crossing(
    at: FloatArray, trace: IntArray, j: int, old: FloatArray, of: IntArray, i: int, after: int, side: int
) -> None:
    """Corner j, where what runs from corner i to the one behind it crosses a side."""
    low, high = old[i, 3], old[after, 3]
    share = min(max(low / (low - high), 0.0), 1.0)
    start = row_vector(old, i)
    place = added(start, scaled(share, apart_from(row_vector(old, after), start)))
    carrier = of[i, CARRIER]
    if carrier >= 0:
        lay_corner(at, trace, j, place, CROSSING, carrier, side)
    else:
        lay_corner(at, trace, j, place, REFERENCE, -1 - carrier, side)


@kernel
def clip_by_side(
    old: FloatArray, of: IntArray, m: int, start: Vector, out: Vector, side: int, thin: float, at: FloatArray,
    trace: IntArray,
) -> int:  # fmt: skip
    """What of m corners is not beyond a side, by more than ``thin`` [m]; their new count."""
    for i in range(m):
        old[i, 3] = dot(out, apart_from(row_vector(old, i), start))
    n = 0
    for i in range(m):
        after = i + 1 if i + 1 < m else 0
        inside, stays = old[i, 3] <= thin, old[after, 3] <= thin
        if inside:
            lay_corner(at, trace, n, row_vector(old, i), of[i, MADE], of[i, FIRST], of[i, SECOND])
            trace[n, CARRIER] = of[i, CARRIER]
            n += 1
        if inside != stays:
            lay_crossing(at, trace, n, old, of, i, after, side)
            trace[n, CARRIER] = -1 - side if inside else of[i, CARRIER]
            n += 1
    return n


@kernel
def clip_face(
    model: SpatialModel, p: int, g: int, pose: Pose, thin: float, at: FloatArray, trace: IntArray
) -> tuple[int, int]:
    """Clip polygon g, whose pose in the frame of polygon p is given, by the sides of p.

    at (2, corners, 4): places [m], in the frame of p, and work; trace (2, corners, 4): what made each, by sides of g
    and p, and what runs from it to the next one: a side of g, or -1 less a side of p. Returns how many corners there
    are, and in which of both halves.
    """
    c = model.contacts
    m, now = 0, 0
    for k in range(c.side_start[g], c.side_start[g + 1]):
        place = added(turned(pose.A, node_place(model, c.side_node[k])), pose.d)
        lay_corner(at[0], trace[0], m, place, INCIDENT, k, k)
        trace[0, m, CARRIER] = k
        m += 1
    n = polygon_normal(model, p)
    for k in range(c.side_start[p], c.side_start[p + 1]):
        start, out = side_of_polygon(model, k, next_side(model, p, k), n)
        m = clip_by_side(at[now], trace[now], m, start, out, k, thin, at[1 - now], trace[1 - now])
        now = 1 - now
        if m == 0:
            break
    return m, now
