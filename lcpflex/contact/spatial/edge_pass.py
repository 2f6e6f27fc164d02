"""What the bulging edges of one surface have with those of another.

Two edges touch where they cross, and where the normal of both, e x f, is one that both wedges have: between the normals
of the facets beside the edge of body j, and opposite to one between those of body i. Of two bodies that touch with
faces which are nearly parallel the crossings of their outlines are corners of the patch: therefore normals may be off
a wedge by a small angle. Edges that cross at their ends touch with the vertices there, and parallel ones with these.
Round edges, the axes of capsules, have all normals.
"""

from __future__ import annotations

from typing import NamedTuple

from lcpflex.contact.spatial.bounds import is_beside_box
from lcpflex.contact.spatial.entries import load_edges
from lcpflex.contact.spatial.kinds import EDGE
from lcpflex.contact.spatial.narrow_phase.edges import END, TILT, crossing_of, edges_cross
from lcpflex.contact.spatial.narrow_phase.sides import Frame, frame_of, place_in, seen_from, world_place
from lcpflex.contact.spatial.node_pass import THIN
from lcpflex.contact.spatial.ownership import corners_of, facet_normal
from lcpflex.contact.spatial.pairs import locate
from lcpflex.contact.spatial.table import SpatialContactTable
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.kinematics.spatial.rotations import Vector, cross
from lcpflex.kinematics.spatial.vectors import (
    NOTHING,
    added,
    apart_from,
    dot,
    norm,
    scaled,
    turned,
    turned_back,
)
from lcpflex.model.spatial import SpatialModel

__all__ = ["Wedge", "edges_on_edges", "in_wedge", "out_by_its_end", "seen_in", "sense_of", "wedge_of"]


class Wedge(NamedTuple):
    """An edge, the normals of its facets, and the directions in these that lead beyond the edge; 0: no facet."""

    start: Vector  # [m]
    e: Vector
    n1: Vector
    n2: Vector
    out1: Vector
    out2: Vector


@kernel
def out_of_facet(
    model: SpatialModel, q: FloatArray, frame: Frame, f: int, facet: int, start: Vector, e: Vector
) -> tuple[Vector, Vector]:
    """Normal of a facet beside edge f, and the unit vector across the edge that leads out of the facet."""
    if facet < 0:
        return NOTHING, NOTHING
    at = corners_of(model, q, frame, facet)
    n = facet_normal(at)
    out = cross(e, n)
    middle = scaled(1.0 / 3.0, added(added(at.a, at.b), at.c))
    length = norm(out)
    return n, scaled(1.0 / length if dot(out, apart_from(middle, start)) <= 0.0 else -1.0 / length, out)


@kernel
def wedge_of(model: SpatialModel, q: FloatArray, frame: Frame, f: int) -> Wedge:
    """Of edge f, in the frame of its body."""
    c = model.contacts
    start = place_in(model.points, q, frame, c.feature_point[f, 0])
    e = apart_from(place_in(model.points, q, frame, c.feature_point[f, 1]), start)
    n1, out1 = out_of_facet(model, q, frame, f, c.feature_neighbour[f, 0], start, e)
    n2, out2 = out_of_facet(model, q, frame, f, c.feature_neighbour[f, 1], start, e)
    return Wedge(start, e, n1, n2, out1, out2)


@kernel
def seen_in(of: Frame, frame: Frame, wedge: Wedge) -> Wedge:
    """A wedge of one body in the frame of another."""
    return Wedge(
        seen_from(frame, world_place(of, wedge.start)),
        turned_back(frame.A, turned(of.A, wedge.e)),
        turned_back(frame.A, turned(of.A, wedge.n1)),
        turned_back(frame.A, turned(of.A, wedge.n2)),
        turned_back(frame.A, turned(of.A, wedge.out1)),
        turned_back(frame.A, turned(of.A, wedge.out2)),
    )


@kernel
def in_wedge(wedge: Wedge, n: Vector) -> bool:
    """Whether n, of length 1, leads out of the wedge between the normals of its facets."""
    return dot(n, wedge.out1) >= -TILT and dot(n, wedge.out2) >= -TILT


@kernel
def sense_of(e: Wedge, f: Wedge, n: Vector, height: float) -> float:
    """+1 or -1 so that sense n leads out of the body of f, and into that of e; by the ``height`` of e of round ones."""
    out = dot(n, f.n1) + dot(n, f.n2) - dot(n, e.n1) - dot(n, e.n2)
    if out == 0.0:
        out = height
    return 1.0 if out >= 0.0 else -1.0


@kernel
def out_by_its_end(depth: float, share: float, e: Vector) -> bool:
    """Whether an edge that is crossed at ``share`` of it, ``depth`` inside, is sooner out of the body over its end.

    Then the vertex there has the contact: the corner of a face that is 1e-7 m deep in another face would else be as
    deep as the edges beside it cross below the other body's outline, in another direction.
    """
    reach = min(share, 1.0 - share)
    return depth > 0.0 and depth * depth > reach * reach * dot(e, e)


@kernel
def meets(e: Wedge, f: Wedge, margin: float, deepest: float, radii: float) -> float:
    """The sense of e x f as the normal of two edges that have a contact with gap <= margin; 0 where they have none.

    deepest: depth down to which they belong together.
    """
    if not edges_cross(e.e, f.e):
        return 0.0
    y = apart_from(e.start, f.start)
    n, s, t = crossing_of(y, e.e, f.e)
    height = dot(n, y)
    if s <= END or s >= 1.0 - END or t <= END or t >= 1.0 - END:
        return 0.0
    sense = sense_of(e, f, n, height)
    gap = sense * height - radii
    if gap > margin or sense * height < -deepest:
        return 0.0
    if out_by_its_end(-sense * height, s, e.e) or out_by_its_end(-sense * height, t, f.e):
        return 0.0
    n = scaled(sense, n)
    if not in_wedge(f, n) or not in_wedge(e, scaled(-1.0, n)):
        return 0.0
    return sense


@kernel
def edge_on_edges(
    model: SpatialModel, q: FloatArray, margin: float, table: SpatialContactTable, frame: Frame, e: int, wedge: Wedge,
    b: int, law: int, n: int,
) -> int:  # fmt: skip
    """Contacts of edge e, a wedge in the frame of surface b, with the edges of b, from entry n on; the new count."""
    c = model.contacts
    near = margin + table.bound[b, 3] + c.feature_radius[e] + THIN * c.surface_extent[b]
    end = added(wedge.start, wedge.e)
    box = c.box_start[b]
    while box < c.box_start[b + 1]:
        if is_beside_box(model, box, wedge.start, end, near):
            box = c.box_skip[box]
            continue
        for at in range(c.box_leaf[box, 0], c.box_leaf[box, 1]):
            f = c.box_feature[at]
            if c.feature_kind[f] != EDGE:
                continue
            deepest = min(c.feature_depth[e], c.feature_depth[f])
            radii = c.feature_radius[e] + c.feature_radius[f]
            sense = meets(wedge, wedge_of(model, q, frame, f), margin, deepest, radii)
            if sense != 0.0:
                if n < len(table.key):
                    load_edges(model, table, n, law, e, f, sense)
                    locate(model, q, table, n)
                n += 1
        box += 1
    return n


@kernel
def edges_on_edges(
    model: SpatialModel, q: FloatArray, margin: float, table: SpatialContactTable, a: int, b: int, law: int, n: int
) -> int:
    """Contacts of the edges of surface a with those of b, from entry n on; returns the new count."""
    c = model.contacts
    own = frame_of(model.bodies, q, c.surface_body[a])
    frame = frame_of(model.bodies, q, c.surface_body[b])
    for e in range(c.feature_start[a], c.feature_start[a + 1]):
        if c.feature_kind[e] == EDGE:
            wedge = seen_in(own, frame, wedge_of(model, q, own, e))
            n = edge_on_edges(model, q, margin, table, frame, e, wedge, b, law, n)
    return n
