"""Gaps, normals, rows W and biases w of contact pairs in space: gdot = W^T u, gddot = W^T udot + w.

Whatever touches, each side is a mean of material points of one body and a lever from there to the place of contact,

    v_rel = (v_i + Omega_i x l_i) - (v_j + Omega_j x l_j),   gdot_d = d.v_rel for d = n, t1, t2 = n x t1,

with the points and the levers l of :mod:`lcpflex.contact.spatial.levers`. With b_rel the rate of v_rel at udot = 0, the
sliding of both feet being in it,

    w_d = d.b_rel + ddot.v_rel,   t1dot = -(t1.ndot) n + sigma t2,   t2dot = -(t2.ndot) n - sigma t1.

How ndot, sigma and the sliding follow from a kind of pair is in :mod:`lcpflex.contact.spatial.narrow_phase`. Sources:
Ericson 2005 (closest features); Pfeiffer & Glocker 1996 (the plane); the equations were checked against differences.
"""

from __future__ import annotations

from lcpflex.contact.spatial.levers import lever_on_i, lever_on_j, mean_on_i, mean_on_j, radius_of_j
from lcpflex.contact.spatial.narrow_phase.crossing import crossing_turning, refresh_crossing
from lcpflex.contact.spatial.narrow_phase.cylinder import (
    cylinder_lever,
    cylinder_lever_rate,
    cylinder_turning,
    refresh_cylinder,
    start_of,
)
from lcpflex.contact.spatial.narrow_phase.cylinder_edges import edge_by_cylinder_turning, refresh_edge_by_cylinder
from lcpflex.contact.spatial.narrow_phase.edge import edge_turning, refresh_edge
from lcpflex.contact.spatial.narrow_phase.edges import edges_turning, refresh_edges
from lcpflex.contact.spatial.narrow_phase.facet import plane_slip, plane_turn, refresh_facet, refresh_over_ground
from lcpflex.contact.spatial.narrow_phase.margins import margin_on_i, margin_on_j
from lcpflex.contact.spatial.narrow_phase.point import point_turning, refresh_point
from lcpflex.contact.spatial.narrow_phase.rim import place_on_rim, refresh_rim, rim_axis, rim_rate
from lcpflex.contact.spatial.narrow_phase.rims import refresh_rims, rims_motion
from lcpflex.contact.spatial.narrow_phase.side_rows import lay_side
from lcpflex.contact.spatial.narrow_phase.sides import (
    AT_REST,
    Frame,
    Motion,
    frame_motion,
    frame_of,
    is_rigid,
    line_between,
    mean_motion,
    mean_place,
    mean_spin,
    mean_velocity,
    point_spin,
    rigid_bias,
    world_place,
)
from lcpflex.contact.spatial.narrow_phase.turning import NO_TURN, Turning
from lcpflex.contact.spatial.table import (
    EDGE_EDGE,
    EDGE_FACET,
    NODE_EDGE,
    NODE_FACET,
    NODE_POINT,
    RIM_FACET,
    RIM_RIM,
    SpatialContactTable,
    by_cylinder,
    points_of,
    with_edge,
)
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.kinematics.spatial.rotations import Vector, cross
from lcpflex.kinematics.spatial.vectors import added, apart_from, dot, row_vector, scaled, turned
from lcpflex.model.spatial import SpatialModel, SpatialPoints

__all__ = [
    "contact_bias",
    "contact_point",
    "contact_rows",
    "foot_margin",
    "gap_rate",
    "locate",
    "node_margin",
    "normal_rate",
    "refresh",
]


FOCUS = 0.1  # of what the way of a foot is divided by: deeper in a hollow than its radius there is none


@kernel
def refresh(model: SpatialModel, q: FloatArray, table: SpatialContactTable, k: int) -> None:
    """Gap, normal, tangent and foot of entry k at q, with its features kept."""
    if table.kind[k] == NODE_FACET and table.body[k, 1] < 0:
        refresh_over_ground(points_of(model, table, k), q, frame_of(model.bodies, q, table.body[k, 0]), table, k)
    else:
        locate(model, q, table, k)


@kernel
def locate(model: SpatialModel, q: FloatArray, table: SpatialContactTable, k: int) -> None:
    """The same of an entry that detection has just made: planes of the ground have no normal yet."""
    points = points_of(model, table, k)
    kind = table.kind[k]
    i = frame_of(model.bodies, q, table.body[k, 0])
    j = frame_of(model.bodies, q, table.body[k, 1])
    if kind == NODE_FACET:
        refresh_facet(points, q, i, j, table, k)
    elif kind == NODE_EDGE:
        refresh_edge(points, q, i, j, table, k)
    elif kind == NODE_POINT:
        refresh_point(points, q, i, j, table, k)
    elif kind == EDGE_EDGE:
        refresh_edges(points, q, i, j, table, k)
    elif kind == EDGE_FACET:
        refresh_crossing(points, q, i, j, table, k)
    elif kind == RIM_FACET:
        refresh_rim(points, q, i, j, table, k)
    elif kind == RIM_RIM:
        refresh_rims(points, q, i, j, table, k)
    elif with_edge(table, k):
        refresh_edge_by_cylinder(points, q, i, j, table, k)
    else:
        refresh_cylinder(points, q, i, j, table, k)


@kernel
def clear_block(row: FloatArray) -> None:
    """Set a block to 0."""
    for c in range(len(row)):
        row[c] = 0.0


@kernel
def contact_rows(
    model: SpatialModel,
    q: FloatArray,
    table: SpatialContactTable,
    k: int,
    normal: FloatArray,
    tangents: FloatArray,
) -> None:
    """Rows of entry k, ``normal`` (2, width) and ``tangents`` (2, 2, width), along t1 and t2, or (0, 2, width): none.

    Blocks for body i and body j; a block on the ground is 0.
    """
    points, rough = points_of(model, table, k), len(tangents) > 0
    first, second = (tangents[0], tangents[1]) if rough else (normal, normal)
    n, t = row_vector(table.normal, k), row_vector(table.tangent, k)
    for side in range(2):
        b = table.body[k, side]
        if b < 0:
            clear_block(normal[side])
            if rough:
                clear_block(first[side])
                clear_block(second[side])
            continue
        frame = frame_of(model.bodies, q, b)
        if side == 0:
            mean = mean_on_i(table, k)
            lever = lever_on_i(points, q, frame, table, k, n)
            lay_side(points, q, frame, mean, lever, 1.0, n, t, rough, normal[0], first[0], second[0])
        else:
            mean = mean_on_j(table, k)
            lever = lever_on_j(model, q, frame, table, k, n)
            lay_side(points, q, frame, mean, lever, -1.0, n, t, rough, normal[1], first[1], second[1])


@kernel
def curved_turning(table: SpatialContactTable, k: int, n: Vector, t: Vector, dv: Vector, turning: Turning) -> Turning:
    """Of means that slide over curved faces: the foot goes (1 - D n.r'')^-1 dv, and n' = -(n.r'') along its way."""
    w = cross(n, t)
    x, y = dot(t, dv), dot(w, dv)
    tt, tw, ww = table.curvature[k, 0], table.curvature[k, 1], table.curvature[k, 2]
    D = table.gap[k] + table.radius[k, 0]
    a, b, c = 1.0 - D * tt, -D * tw, 1.0 - D * ww
    det = a * c - b * b
    if det > FOCUS:
        x, y = (c * x - b * y) / det, (a * y - b * x) / det
    along_t, along_w = tt * x + tw * y, tw * x + ww * y
    ndot = apart_from(turning.ndot, added(scaled(along_t, t), scaled(along_w, w)))
    return Turning(ndot, turning.spin, turning.slip, turning.slide_i, turning.slide_j)


@kernel
def turning_of(
    points: SpatialPoints, q: FloatArray, u: FloatArray, frames: tuple[Frame, Frame], motions: tuple[Motion, Motion],
    table: SpatialContactTable, k: int, n: Vector, t: Vector, dv: Vector,
) -> Turning:  # fmt: skip
    """Of entry k, whose feet move past each other with dv, but for those of rims."""
    kind = table.kind[k]
    point = table.point
    if kind == NODE_FACET:
        if table.body[k, 1] < 0:
            return NO_TURN
        turn = plane_turn(points, q, u, frames[1], motions[1], point[k, 1], point[k, 2], point[k, 3], n, t)
        turning = plane_slip(turn, dv, table.gap[k] + table.radius[k, 0])
        return curved_turning(table, k, n, t, dv, turning) if table.averaged[k] == 1 else turning
    if kind == NODE_EDGE:
        return edge_turning(points, q, u, frames[1], motions[1], table, k, n, t, dv)
    if kind == NODE_POINT:
        return point_turning(frames[1], motions[1], table, k, n, t, dv)
    if kind == EDGE_FACET:
        return crossing_turning(points, motions, frames, table, k, n, t, dv)
    if by_cylinder(table, k):
        if with_edge(table, k):
            return edge_by_cylinder_turning(points, q, u, frames, motions, table, k, n, t, dv)
        return cylinder_turning(points, q, u, frames, motions, table, k, n, t, dv)
    return edges_turning(points, q, u, frames, motions, table, k, n, t, dv)


@kernel
def lever_motion(spin: Vector, turn: Vector, lever: Vector, rate: Vector) -> tuple[Vector, Vector]:
    """Omega x l, and its rate at udot = 0."""
    return cross(spin, lever), added(cross(turn, lever), cross(spin, rate))


@kernel
def rim_motion(
    points: SpatialPoints, q: FloatArray, u: FloatArray, frames: tuple[Frame, Frame], motions: tuple[Motion, Motion],
    table: SpatialContactTable, k: int, n: Vector, t: Vector, dv: Vector,
) -> tuple[Vector, Vector, Turning]:  # fmt: skip
    """What the lever R c of a rim adds to v_rel and b_rel, and the turning of entry k; dv: of its centre."""
    point = table.point
    plane = plane_turn(points, q, u, frames[1], motions[1], point[k, 2], point[k, 3], point[k, 4], n, t)
    spin, turn = point_spin(points, q, u, frames[0], motions[0], point[k, 0])
    R = table.radius[k, 2]
    c, tilt = place_on_rim(points, q, frames[0], table, k, n)
    c, rate = rim_rate(rim_axis(points, q, frames[0], point[k, 0], point[k, 1]), n, c, tilt, spin, plane.ndot)
    v, b = lever_motion(spin, turn, scaled(R, c), scaled(R, rate))
    lowest = added(dv, scaled(R, rate))
    return v, b, plane_slip(plane, lowest, table.gap[k] + table.radius[k, 0])


@kernel
def cylinder_motion(
    points: SpatialPoints, q: FloatArray, u: FloatArray, frames: tuple[Frame, Frame], motions: tuple[Motion, Motion],
    table: SpatialContactTable, k: int, n: Vector, turning: Turning, dv: Vector,
) -> tuple[Vector, Vector]:  # fmt: skip
    """What the lever on a cylinder adds to v and b of body j in entry k; dv: of body i from where that begins."""
    spin, turn = point_spin(points, q, u, frames[1], motions[1], start_of(table, k))
    lever = cylinder_lever(points, q, frames, table, k, n)
    if with_edge(table, k):
        line = line_between(points, q, frames[0], table.point[k, 0], table.point[k, 1])
        dv = added(dv, turned(frames[0].A, scaled(turning.slide_i, line)))
    return lever_motion(spin, turn, lever, cylinder_lever_rate(table, k, n, turning.ndot, dv, spin, lever))


@kernel
def along_axes(n: Vector, t: Vector, turning: Turning, v: Vector, b: Vector) -> tuple[float, float, float]:
    """w along n, t1 and t2 of v_rel = v and b_rel = b."""
    w = cross(n, t)
    along_n, along_t, along_w = dot(n, v), dot(t, v), dot(w, v)
    ndot = turning.ndot
    return (
        dot(n, b) + dot(ndot, v),
        dot(t, b) - dot(t, ndot) * along_n + turning.spin * along_w,
        dot(w, b) - dot(w, ndot) * along_n - turning.spin * along_t,
    )


@kernel
def contact_bias(
    model: SpatialModel, q: FloatArray, u: FloatArray, table: SpatialContactTable, k: int
) -> tuple[float, float, float]:
    """w_N and w_T along both tangents of entry k [m/s^2].

    Over a plane of the ground nothing turns but a rigid body with its lever, whose rate has no part at udot = 0: the
    most frequent pair, and the cheapest.
    """
    bodies, points = model.bodies, points_of(model, table, k)
    n, t = row_vector(table.normal, k), row_vector(table.tangent, k)
    i, j = table.body[k, 0], table.body[k, 1]
    if table.kind[k] == NODE_FACET and j < 0 and i >= 0 and is_rigid(points, table.point[k, 0]):
        b = rigid_bias(frame_of(bodies, q, i), frame_motion(bodies, u, i), row_vector(points.place, table.point[k, 0]))
        return dot(n, b), dot(t, b), dot(cross(n, t), b)
    frames = (frame_of(bodies, q, i), frame_of(bodies, q, j))
    motions = (frame_motion(bodies, u, i), frame_motion(bodies, u, j))
    on_i, on_j = mean_on_i(table, k), mean_on_j(table, k)
    of_i = mean_motion(points, q, u, frames[0], motions[0], on_i) if i >= 0 else AT_REST
    of_j = mean_motion(points, q, u, frames[1], motions[1], on_j) if j >= 0 else AT_REST
    v, b = apart_from(of_i.v, of_j.v), apart_from(of_i.b, of_j.b)
    dv = v
    if table.kind[k] == RIM_FACET:
        more, bias, turning = rim_motion(points, q, u, frames, motions, table, k, n, t, v)
        v, b = added(v, more), added(b, bias)
    elif table.kind[k] == RIM_RIM:
        more, bias, turning = rims_motion(points, q, u, frames, motions, table, k, n, v)
        v, b = added(v, more), added(b, bias)
    else:
        turning = turning_of(points, q, u, frames, motions, table, k, n, t, v)
    b = added(b, turning.slip)
    radius = table.radius[k, 0]
    if radius != 0.0 and i >= 0:
        spin, turn = mean_spin(points, q, u, frames[0], motions[0], on_i, turning.slide_i)
        more, bias = lever_motion(spin, turn, scaled(-radius, n), scaled(-radius, turning.ndot))
        v, b = added(v, more), added(b, bias)
    if by_cylinder(table, k):
        more, bias = cylinder_motion(points, q, u, frames, motions, table, k, n, turning, dv)
        v, b = apart_from(v, more), apart_from(b, bias)
    radius = radius_of_j(table, k)
    if radius != 0.0 and j >= 0:
        spin, turn = mean_spin(points, q, u, frames[1], motions[1], on_j, turning.slide_j)
        more, bias = lever_motion(spin, turn, scaled(radius, n), scaled(radius, turning.ndot))
        v, b = apart_from(v, more), apart_from(b, bias)
    return along_axes(n, t, turning, v, b)


@kernel
def normal_rate(model: SpatialModel, q: FloatArray, u: FloatArray, table: SpatialContactTable, k: int) -> Vector:
    """ndot of entry k [1/s], world axes."""
    bodies, points = model.bodies, points_of(model, table, k)
    n, t = row_vector(table.normal, k), row_vector(table.tangent, k)
    i, j = table.body[k, 0], table.body[k, 1]
    frames = (frame_of(bodies, q, i), frame_of(bodies, q, j))
    motions = (frame_motion(bodies, u, i), frame_motion(bodies, u, j))
    of_i = mean_motion(points, q, u, frames[0], motions[0], mean_on_i(table, k)) if i >= 0 else AT_REST
    of_j = mean_motion(points, q, u, frames[1], motions[1], mean_on_j(table, k)) if j >= 0 else AT_REST
    v = apart_from(of_i.v, of_j.v)
    if table.kind[k] == RIM_FACET:
        return rim_motion(points, q, u, frames, motions, table, k, n, t, v)[2].ndot
    if table.kind[k] == RIM_RIM:
        return rims_motion(points, q, u, frames, motions, table, k, n, v)[2].ndot
    return turning_of(points, q, u, frames, motions, table, k, n, t, v).ndot


@kernel
def gap_rate(model: SpatialModel, q: FloatArray, u: FloatArray, table: SpatialContactTable, k: int) -> float:
    """Rate of the gap of entry k [m/s]."""
    bodies, points = model.bodies, points_of(model, table, k)
    n = row_vector(table.normal, k)
    rate = 0.0
    i, j = table.body[k, 0], table.body[k, 1]
    if i >= 0:
        frame, motion = frame_of(bodies, q, i), frame_motion(bodies, u, i)
        rate = dot(n, mean_velocity(points, q, u, frame, motion, mean_on_i(table, k)))
        if table.kind[k] in (RIM_FACET, RIM_RIM):
            spin, _ = point_spin(points, q, u, frame, motion, table.point[k, 0])
            rate += dot(n, cross(spin, lever_on_i(points, q, frame, table, k, n)))
    if j >= 0:
        frame, motion = frame_of(bodies, q, j), frame_motion(bodies, u, j)
        rate -= dot(n, mean_velocity(points, q, u, frame, motion, mean_on_j(table, k)))
        if by_cylinder(table, k) or table.kind[k] == RIM_RIM:
            spin, _ = point_spin(points, q, u, frame, motion, mean_on_j(table, k).a)
            rate -= dot(n, cross(spin, lever_on_j(model, q, frame, table, k, n)))
    return rate


@kernel
def contact_point(model: SpatialModel, q: FloatArray, table: SpatialContactTable, k: int) -> Vector:
    """Where entry k touches [m], world axes: the point of body i nearest to the feature of body j."""
    frame = frame_of(model.bodies, q, table.body[k, 0])
    points = points_of(model, table, k)
    place = world_place(frame, mean_place(points, q, frame, mean_on_i(table, k)))
    return added(place, lever_on_i(points, q, frame, table, k, row_vector(table.normal, k)))


@kernel
def foot_margin(model: SpatialModel, q: FloatArray, table: SpatialContactTable, k: int) -> float:
    """How far the foot of entry k is inside its feature: see :mod:`lcpflex.contact.spatial.narrow_phase.margins`."""
    i = frame_of(model.bodies, q, table.body[k, 0])
    return margin_on_j(model, q, i, frame_of(model.bodies, q, table.body[k, 1]), table, k)


@kernel
def node_margin(model: SpatialModel, q: FloatArray, table: SpatialContactTable, k: int) -> float:
    """How far the contact of entry k is inside what its node, edge or rim is; infinite of round nodes."""
    return margin_on_i(model, q, frame_of(model.bodies, q, table.body[k, 0]), table, k)
