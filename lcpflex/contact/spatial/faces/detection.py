"""What the nodes or areas of a face of a solid have with the faces of another surface."""

from __future__ import annotations

import math

from lcpflex.bodies.spatial.surface import FACE
from lcpflex.contact.spatial.bounds import plane_vector
from lcpflex.contact.spatial.entries import load_node
from lcpflex.contact.spatial.faces.feet import find_foot, place_of
from lcpflex.contact.spatial.faces.kept import is_far, is_kept, keep, still_stands
from lcpflex.contact.spatial.faces.means import Standing, common_area, lay_means, stand, weigh, weight_in
from lcpflex.contact.spatial.faces.memory import mean_of
from lcpflex.contact.spatial.kinds import PLANE, POINT, SIDE
from lcpflex.contact.spatial.narrow_phase.facet import Plane, set_over
from lcpflex.contact.spatial.narrow_phase.sides import Frame, frame_of, place_in, seen_from, world_place
from lcpflex.contact.spatial.table import NODE_FACET, SpatialContactTable
from lcpflex.jit.kernel import FloatArray, IntArray, kernel
from lcpflex.kinematics.spatial.vectors import (
    NOTHING,
    added,
    apart_from,
    dot,
    norm,
    row_vector,
    scaled,
    turned,
    turned_back,
)
from lcpflex.model.spatial import SpatialModel

__all__ = ["depth_along", "depth_below", "depth_of", "faces_touch", "weigh_entry"]

LEAST = 1e-3  # of an area that must be common: what is less hangs on a sample at its rim, and would be no mean
BESIDE = 2.0  # lengths of an area: how far above the margin one of its samples may be, if the mean is within it
ROUNDING = 1e-5  # of a surface: a node so little above a facet is not below those beside it, whose slack is less
MOST_PLACES = 64.0  # of a line that are looked at


@kernel
def find_feet(
    model: SpatialModel, q: FloatArray, margin: float, table: SpatialContactTable, i: Frame, j: Frame, b: int, node: int
) -> None:
    """Feet of the samples of a node on surface b, of those that are not known yet."""
    c, memory = model.contacts, table.faces
    for at in range(c.area_start[node], c.area_start[node + 1]):
        s = c.area_sample[at]
        if memory.tried[s] == memory.search:
            continue
        own = (0.0, 0.0, 0.0)
        for k in range(c.sample_start[s], c.sample_start[s + 1]):
            own = added(own, scaled(c.sample_weight[k], place_of(model, q, memory, i, c.sample_point[k])))
        outward = turned_back(j.A, turned(i.A, row_vector(c.sample_normal, s)))
        find_foot(model, q, margin, table, j, b, s, seen_from(j, world_place(i, own)), outward)


@kernel
def whole_area(model: SpatialModel, node: int) -> float:
    """Of all samples of a node [m^2]: what a pressure acts on; of nodes that have none, of the one sample of each."""
    c = model.contacts
    if c.node_area[node] > 0.0:
        return c.node_area[node]
    total = 0.0
    for at in range(c.area_start[node], c.area_start[node + 1]):
        total += c.area_share[at]
    return total


@kernel
def sample_reach(model: SpatialModel, a: int, margin: float) -> float:
    """How far above another surface samples of face a may be whose means are within ``margin`` [m]."""
    c = model.contacts
    largest = 0.0
    for node in range(c.node_start[a], c.node_start[a + 1]):
        largest = max(largest, whole_area(model, node))
    return margin + BESIDE * math.sqrt(largest)


@kernel
def load_means(
    model: SpatialModel, table: SpatialContactTable, k: int, law: int, node: int, b: int, listed: IntArray,
    part: FloatArray, own: int, area: float, curvature: FloatArray, over: Standing, frame: Frame,
) -> None:  # fmt: skip
    """Entry k, of a node or area with surface b: that of means of listed points; frame: of the body of b."""
    c, size = model.contacts, math.sqrt(area)
    load_node(model, table, k, law, NODE_FACET, node, c.feature_start[b])
    lay_means(model, table.faces, listed, part, own, k, (table.body[k, 0], table.body[k, 1]), size)
    table.averaged[k] = 1
    for d in range(3):
        table.curvature[k, d] = curvature[d]
    share = area / whole_area(model, node)
    table.area[k] = share * c.node_area[node]
    table.weight[k] *= share
    for v in range(4):
        table.point[k, v] = mean_of(k, v)
    table.point[k, 4] = mean_of(k, 0)
    plane = over.plane
    longer = Plane(plane.a, scaled(size, plane.e1), scaled(size, plane.e2), plane.n, size * size * plane.area)
    set_over(table, k, frame, longer, over.slave, table.radius[k, 0])


@kernel
def node_touches(
    model: SpatialModel, q: FloatArray, margin: float, wide: float, table: SpatialContactTable, i: Frame, j: Frame,
    surfaces: tuple[int, int], law: int, node: int, n: int,
) -> int:  # fmt: skip
    """Entry n, where a node or area of the first surface is near the second one; the new count."""
    memory, kept, b = table.faces, table.faces.kept, surfaces[1]
    if is_kept(memory, node, b):
        row = node - kept.first
        points, weights = kept.point[row][: kept.count[row]], kept.weight[row][: kept.count[row]]
        over = stand(model, q, memory, (i, j), points, weights, kept.own[row])
        if still_stands(memory, row, over, i, j, wide):
            if over.gap > margin:
                return n
            if n < len(table.key):
                own, area, curvature = kept.own[row], kept.area[row], kept.curvature[row]
                load_means(model, table, n, law, node, b, points, weights, own, area, curvature, over, j)
            return n + 1
        kept.count[row] = 0
    if is_far(model, table, i, j, node, surfaces, wide):
        return n
    find_feet(model, q, wide, table, i, j, b, node)
    area = common_area(model, memory, node)
    if not area > LEAST * whole_area(model, node):
        return n
    own, count = weigh(model, memory, node, area)
    listed, part = memory.listed[:count], memory.part[:count]
    over = stand(model, q, memory, (i, j), listed, part, own)
    keep(model, memory, node, b, over, i, j, own, count, area, wide)
    if over.gap > margin:
        return n
    if n < len(table.key):
        load_means(model, table, n, law, node, b, listed, part, own, area, memory.curvature, over, j)
    return n + 1


@kernel
def faces_touch(
    model: SpatialModel, q: FloatArray, margin: float, table: SpatialContactTable, a: int, b: int, law: int, n: int
) -> int:
    """Contacts of the nodes or areas of face a with surface b, from entry n on; the new count."""
    c, memory = model.contacts, table.faces
    i, j = frame_of(model.bodies, q, c.surface_body[a]), frame_of(model.bodies, q, c.surface_body[b])
    memory.search += 1
    wide = sample_reach(model, a, margin)
    for node in range(c.node_start[a], c.node_start[a + 1]):
        n = node_touches(model, q, margin, wide, table, i, j, (a, b), law, node, n)
    return n


@kernel
def weigh_entry(
    model: SpatialModel, q: FloatArray, margin: float, table: SpatialContactTable, k: int, a: int, b: int,
    weights: FloatArray,
) -> int:  # fmt: skip
    """Material points of which the means of entry k, of faces a and b, are sums: how many, listed in its memory.

    Rows of ``weights`` are theirs in each of its four means. q, margin: of the table, else other samples have feet.
    """
    c, memory = model.contacts, table.faces
    node = table.key[k] // len(c.feature_kind)
    i, j = frame_of(model.bodies, q, c.surface_body[a]), frame_of(model.bodies, q, c.surface_body[b])
    memory.search += 1
    find_feet(model, q, sample_reach(model, a, margin), table, i, j, b, node)
    area = common_area(model, memory, node)
    if not area > 0.0:
        return 0
    _, count = weigh(model, memory, node, area)
    for at in range(count):
        for which in range(4):
            weights[at, which] = weight_in(memory.part[at], which, math.sqrt(area))
    return count


@kernel
def depth_below(model: SpatialModel, q: FloatArray, table: SpatialContactTable, s: int, node: int, b: int) -> float:
    """How deep node ``node`` of surface b is below face s [m]; 0 where it is above it or beside."""
    c, memory = model.contacts, table.faces
    memory.search += 1
    of_node, j = frame_of(model.bodies, q, c.surface_body[b]), frame_of(model.bodies, q, c.surface_body[s])
    radius, point = c.node_radius[node], c.node_point[node]
    place = seen_from(j, world_place(of_node, place_of(model, q, memory, of_node, point)))
    outward = NOTHING
    if radius == 0.0:
        outward = turned_back(j.A, turned(of_node.A, row_vector(c.node_normal, node)))
    memory.foot_on[0] = -1  # else it would go on from that of another place
    find_foot(model, q, radius, table, j, s, 0, place, outward)
    return radius - memory.gap[0] if memory.foot_on[0] >= 0 else 0.0


@kernel
def depth_of(model: SpatialModel, q: FloatArray, table: SpatialContactTable, s: int, b: int) -> float:
    """How deep the deepest node of the elements of face s is below surface b [m], in a table of what is near; or 0.

    b: a plane, a sphere, a hole, or what has facets. What is below an open face counts where it looks at that: a slot
    around the body of it is behind it, too.
    """
    c, memory = model.contacts, table.faces
    memory.search += 1
    i, j = frame_of(model.bodies, q, c.surface_body[s]), frame_of(model.bodies, q, c.surface_body[b])
    first, is_open = c.feature_start[b], c.surface_kind[b] == FACE
    deepest = 0.0
    for sample in range(c.area_start[c.node_start[s]], c.area_start[c.node_start[s + 1]]):
        own = c.area_sample[sample]
        outward = turned_back(j.A, turned(i.A, row_vector(c.sample_normal, own))) if is_open else NOTHING
        for k in range(c.sample_start[own], c.sample_start[own + 1]):
            p = c.sample_point[k]
            if memory.known[p] == memory.search and not is_open:
                continue
            place = world_place(i, place_of(model, q, memory, i, p))
            if c.feature_kind[first] == PLANE:
                depth = dot(plane_vector(table, b, 0), apart_from(plane_vector(table, b, 3), place))
            elif c.feature_kind[first] == POINT and c.feature_start[b + 1] == first + 1:
                center = world_place(j, place_in(model.points, q, j, c.feature_point[first, 0]))
                radius, away = c.feature_radius[first], norm(apart_from(place, center))
                depth = radius - (away if radius >= 0.0 else -away)
            else:
                above = ROUNDING * c.surface_extent[b]
                memory.foot_on[0] = -1  # else it would go on from that of another place
                find_foot(model, q, above, table, j, b, 0, seen_from(j, place), outward)
                depth = -memory.gap[0] if memory.foot_on[0] >= 0 else 0.0
            deepest = max(deepest, depth)
    return deepest


@kernel
def depth_along(
    model: SpatialModel, q: FloatArray, table: SpatialContactTable, s: int, f: int, b: int, normal: FloatArray,
    apart: float,
) -> float:  # fmt: skip
    """How deep a line of surface b is below face s [m], at places so far ``apart``; or 0.

    f: an edge with the outward ``normal`` (3,) in the frame of its body, a capsule, or the side of a cylinder.
    """
    c, memory = model.contacts, table.faces
    memory.search += 1
    i, j = frame_of(model.bodies, q, c.surface_body[b]), frame_of(model.bodies, q, c.surface_body[s])
    radius = c.feature_radius[f]
    first = seen_from(j, world_place(i, place_of(model, q, memory, i, c.feature_point[f, 0])))
    last = seen_from(j, world_place(i, place_of(model, q, memory, i, c.feature_point[f, 1])))
    way = apart_from(last, first)
    length = norm(way)
    count = 1 + int(min(length / apart, MOST_PLACES))
    outward = NOTHING
    if radius == 0.0:
        outward = turned_back(j.A, turned(i.A, (normal[0], normal[1], normal[2])))
    deepest = 0.0
    for k in range(count):
        memory.foot_on[0] = -1  # else it would go on from that of another place
        find_foot(model, q, radius, table, j, s, 0, added(first, scaled((k + 0.5) / count, way)), outward)
        if memory.foot_on[0] >= 0:
            low = radius
            if c.feature_kind[f] == SIDE:
                slope = dot(row_vector(memory.normal, 0), way) / length
                low *= math.sqrt(max(0.0, 1.0 - slope * slope))
            deepest = max(deepest, low - memory.gap[0])
    return deepest
