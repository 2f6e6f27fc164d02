"""Where the edges of two meshes cross: corners of the patch in which their faces touch, and edges that meet.

As :mod:`lcpflex.contact.spatial.edge_pass` has it, with two differences. Of faces that lie on each other, crossings of
their outlines are corners of the patch, however near an end they are: there the vertex is beside the face. And where
one of both deforms, every edge is one that might bulge: of two that cross, one must be sharp. Where only one is, it
must meet the other surface as an edge: nodes hold a face beside it.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from lcpflex.contact.spatial.bounds import is_beside_box
from lcpflex.contact.spatial.edge_pass import Wedge, in_wedge, out_by_its_end, seen_in, sense_of, wedge_of
from lcpflex.contact.spatial.entries import load_edges
from lcpflex.contact.spatial.kinds import EDGE
from lcpflex.contact.spatial.mesh_pairs import DEEP, band_between, deforms
from lcpflex.contact.spatial.narrow_phase.edges import END, TILT, crossing_of
from lcpflex.contact.spatial.narrow_phase.sides import Frame, frame_of, place_in, seen_from, world_place
from lcpflex.contact.spatial.pairs import locate
from lcpflex.contact.spatial.table import SpatialContactTable
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.kinematics.spatial.rotations import Vector, cross
from lcpflex.kinematics.spatial.vectors import NOTHING, added, apart_from, dot, norm, scaled
from lcpflex.model.spatial import SpatialModel

__all__ = ["crossings_of_meshes"]

ALONG = 5e-5  # sine of the angle below which edges cross nowhere for certain: over a band their ends are as near
FLAT = math.cos(2.0 * TILT)
LYING = math.cos(0.3)  # [rad] a face that is less off a surface that deforms has its nodes: see TURNED


class Sharp(NamedTuple):
    """Whether two edges turn by more than deformation bends flat ones."""

    e: bool
    f: bool


@kernel
def along_facet(wedge: Wedge, n: Vector) -> float:
    """The cosine between n and the normal of that facet beside an edge which is less off it."""
    return max(dot(n, wedge.n1), dot(n, wedge.n2))


@kernel
def is_told_by_nodes(e: Wedge, f: Wedge, n: Vector, sharp: Sharp) -> bool:
    """Whether nodes hold two edges that cross with the normal n, one of them belonging to a surface that deforms."""
    if sharp.e and sharp.f:
        return False
    return along_facet(e, scaled(-1.0, n)) > LYING if sharp.e else along_facet(f, n) > LYING


@kernel
def leads_out(wedge: Wedge, n: Vector) -> bool:
    """Whether n leads out of the wedge between the normals of its facets; of a flat one also not into the solid."""
    return dot(n, wedge.n1) + dot(n, wedge.n2) >= 0.0 and in_wedge(wedge, n)


@kernel
def touch(
    e: Wedge, f: Wedge, n: Vector, s: float, t: float, height: float, margin: float, deep: float, soft: bool,
    sharp: Sharp,
) -> float:  # fmt: skip
    """The sense of n as the normal of two edges that cross at s and t, if they have a contact; else 0.

    deep: depth down to which faces that lie on each other have corners. soft: one of the surfaces deforms.
    """
    sense = sense_of(e, f, n, height)
    if sense * height > margin:
        return 0.0
    out, back = scaled(sense, n), scaled(-sense, n)
    if not leads_out(f, out) or not leads_out(e, back) or (soft and is_told_by_nodes(e, f, out, sharp)):
        return 0.0
    depth = -sense * height
    if depth <= deep and along_facet(f, out) > FLAT and along_facet(e, back) > FLAT:
        return sense
    return 0.0 if out_by_its_end(depth, s, e.e) or out_by_its_end(depth, t, f.e) else sense


@kernel
def crossings_of_edge(
    model: SpatialModel, q: FloatArray, margin: float, table: SpatialContactTable, own: Frame, frame: Frame, e: int,
    start: Vector, line: Vector, b: int, law: int, n: int, band: float, soft: bool,
) -> int:  # fmt: skip
    """Contacts of edge e, from ``start`` along ``line`` in the frame of surface b, with the edges of b."""
    c = model.contacts
    near = margin + table.bound[b, 3] + band
    end = added(start, line)
    known = False
    wedge = Wedge(start, line, NOTHING, NOTHING, NOTHING, NOTHING)
    box = c.box_start[b]
    while box < c.box_start[b + 1]:
        if is_beside_box(model, box, start, end, near):
            box = c.box_skip[box]
            continue
        for at in range(c.box_leaf[box, 0], c.box_leaf[box, 1]):
            f = c.box_feature[at]
            if c.feature_kind[f] != EDGE:
                continue
            sharp = Sharp(c.feature_neighbour[e, 2] >= 0, c.feature_neighbour[f, 2] >= 0)
            if soft and not sharp.e and not sharp.f:
                continue
            head = place_in(model.points, q, frame, c.feature_point[f, 0])
            other = apart_from(place_in(model.points, q, frame, c.feature_point[f, 1]), head)
            if not norm(cross(line, other)) > ALONG * norm(line) * norm(other):
                continue
            y = apart_from(start, head)
            normal, s, t = crossing_of(y, line, other)
            height = dot(normal, y)
            if s <= END or s >= 1.0 - END or t <= END or t >= 1.0 - END:
                continue
            if abs(height) > max(margin, min(c.feature_depth[e], c.feature_depth[f])):
                continue
            if not known:
                known = True
                wedge = seen_in(own, frame, wedge_of(model, q, own, e))
            sense = touch(wedge, wedge_of(model, q, frame, f), normal, s, t, height, margin, DEEP * band, soft, sharp)
            if sense != 0.0:
                if n < len(table.key):
                    load_edges(model, table, n, law, e, f, sense)
                    locate(model, q, table, n)
                n += 1
        box += 1
    return n


@kernel
def crossings_of_meshes(
    model: SpatialModel, q: FloatArray, margin: float, table: SpatialContactTable, a: int, b: int, law: int, n: int
) -> int:
    """Contacts of the edges of surface a with those of b, from entry n on; returns the new count."""
    c = model.contacts
    own = frame_of(model.bodies, q, c.surface_body[a])
    frame = frame_of(model.bodies, q, c.surface_body[b])
    band = band_between(model, a, b)
    soft = deforms(model, a) or deforms(model, b)
    center = (c.surface_center[b, 0], c.surface_center[b, 1], c.surface_center[b, 2])
    reach = c.surface_extent[b] + margin + table.bound[b, 3] + band
    for e in range(c.feature_start[a], c.feature_start[a + 1]):
        if c.feature_kind[e] != EDGE:
            continue
        start = seen_from(frame, world_place(own, place_in(model.points, q, own, c.feature_point[e, 0])))
        end = seen_from(frame, world_place(own, place_in(model.points, q, own, c.feature_point[e, 1])))
        line = apart_from(end, start)
        if norm(apart_from(start, center)) <= reach + norm(line):
            n = crossings_of_edge(model, q, margin, table, own, frame, e, start, line, b, law, n, band, soft)
    return n
