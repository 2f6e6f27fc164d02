"""Separating axes of two convex polyhedra: over which face, or across which two edges, they are farthest apart.

The separation over a face is the height of the deepest vertex of the other body; across two edges e and f it is that
along n = e x f, where n is a normal of both: between those of the faces beside each edge (their arcs on the sphere of
normals cross). Separations are below 0 where bodies are inside each other.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from lcpflex.contact.spatial.narrow_phase.edges import edges_cross
from lcpflex.contact.spatial.narrow_phase.sides import Frame, seen_from
from lcpflex.jit.kernel import kernel
from lcpflex.kinematics.spatial.rotations import Matrix, Vector, cross, product
from lcpflex.kinematics.spatial.vectors import added, apart_from, dot, norm, row_vector, scaled, turned, turned_back
from lcpflex.model.spatial import SpatialModel

__all__ = ["ONE_FACE", "FaceAxis", "Pose", "Ridges", "back", "beyond_edge", "incident_face", "node_place",
           "polygon_normal", "ridges", "seen", "widest_face"]  # fmt: skip

ONE_FACE = 0.995  # cosine of .1 rad: faces that make less of an edge are one, made of points that are not in one plane


class Pose(NamedTuple):
    """Of one frame in another one: what is at x in it is at A x + d there."""

    A: Matrix
    d: Vector  # [m]


class FaceAxis(NamedTuple):
    """The face that the other body is farthest above."""

    separation: float  # [m]
    polygon: int
    node: int  # the deepest one of the other body


class Ridges(NamedTuple):
    """The two edges across which two bodies are farthest apart; -inf and -1: there are none."""

    separation: float  # [m]
    first: int  # feature, of the one
    second: int  # of the other
    normal: Vector  # out of the other into the one, in the frame of the other


@kernel
def seen(of: Frame, frame: Frame) -> Pose:
    """The pose of one frame in another."""
    A = frame.A
    return Pose(product((A[0], A[3], A[6], A[1], A[4], A[7], A[2], A[5], A[8]), of.A), seen_from(frame, of.origin))


@kernel
def back(pose: Pose) -> Pose:
    """The pose of the other frame in this one."""
    A = pose.A
    d = turned_back(A, pose.d)
    return Pose((A[0], A[3], A[6], A[1], A[4], A[7], A[2], A[5], A[8]), scaled(-1.0, d))


@kernel
def node_place(model: SpatialModel, node: int) -> Vector:
    """Of a vertex in the frame of its body, which is rigid [m]."""
    return row_vector(model.points.place, model.contacts.node_point[node])


@kernel
def polygon_normal(model: SpatialModel, p: int) -> Vector:
    """Outward, in the frame of its body."""
    plane = model.contacts.polygon_plane
    return plane[p, 0], plane[p, 1], plane[p, 2]


@kernel
def widest_face(model: SpatialModel, s: int, other: int, pose: Pose, margin: float) -> FaceAxis:
    """Of surface s, over whose faces the ``other``, whose pose in the frame of s is given, lies.

    The first face that it is more than ``margin`` above ends the search.
    """
    c = model.contacts
    place, point = model.points.place, c.node_point
    best = FaceAxis(-math.inf, -1, -1)
    for p in range(c.polygon_start[s], c.polygon_start[s + 1]):
        n = polygon_normal(model, p)
        x, y, z = turned_back(pose.A, n)
        lowest, node = math.inf, -1
        for k in range(c.node_start[other], c.node_start[other + 1]):
            at = point[k]
            height = x * place[at, 0] + y * place[at, 1] + z * place[at, 2]
            if height < lowest:
                lowest, node = height, k
        separation = lowest + dot(n, pose.d) - c.polygon_plane[p, 3]
        if separation > best.separation:
            best = FaceAxis(separation, p, node)
            if separation > margin:
                break
    return best


@kernel
def beyond_edge(model: SpatialModel, s: int, other: int, pose: Pose, first: int, band: float) -> bool:
    """Whether the ``other`` body is beyond a second face of s, too, to rounding: at an edge, where no face is nearer.

    first: the face that it is beyond; band: what stands for rounding [m].
    """
    c = model.contacts
    place, point = model.points.place, c.node_point
    m = polygon_normal(model, first)
    for p in range(c.polygon_start[s], c.polygon_start[s + 1]):
        n = polygon_normal(model, p)
        if dot(n, m) > ONE_FACE:
            continue
        x, y, z = turned_back(pose.A, n)
        least = c.polygon_plane[p, 3] - dot(n, pose.d) - band
        beyond = True
        for k in range(c.node_start[other], c.node_start[other + 1]):
            at = point[k]
            if x * place[at, 0] + y * place[at, 1] + z * place[at, 2] < least:
                beyond = False
                break
        if beyond:
            return True
    return False


@kernel
def incident_face(model: SpatialModel, node: int, n: Vector) -> tuple[int, float]:
    """Of the faces about a vertex the one most against n, in their frame; and the cosine between both, reversed.

    Over all faces of the body it could be one that is far from where they touch.
    """
    c = model.contacts
    best, cosine = -1, -2.0
    for k in range(c.corner_start[node], c.corner_start[node + 1]):
        against = -dot(n, polygon_normal(model, c.corner_polygon[k]))
        if against > cosine:
            best, cosine = c.corner_polygon[k], against
    return best, cosine


@kernel
def ends_of(model: SpatialModel, f: int) -> tuple[Vector, Vector]:
    """Where an edge begins [m], and its line, in the frame of its body."""
    point = model.contacts.feature_point
    start = row_vector(model.points.place, point[f, 0])
    return start, apart_from(row_vector(model.points.place, point[f, 1]), start)


@kernel
def ridges(model: SpatialModel, a: int, b: int, pose: Pose) -> Ridges:
    """Of surface a, whose pose in the frame of b is given, and surface b."""
    c = model.contacts
    best = Ridges(-math.inf, -1, -1, (0.0, 0.0, 0.0))
    for i in range(c.ridge_start[a], c.ridge_start[a + 1]):
        n1 = turned(pose.A, polygon_normal(model, c.ridge_polygon[i, 0]))
        n2 = turned(pose.A, polygon_normal(model, c.ridge_polygon[i, 1]))
        start, line = ends_of(model, c.ridge_edge[i])
        start, e = added(turned(pose.A, start), pose.d), turned(pose.A, line)
        for j in range(c.ridge_start[b], c.ridge_start[b + 1]):
            m1, m2 = polygon_normal(model, c.ridge_polygon[j, 0]), polygon_normal(model, c.ridge_polygon[j, 1])
            if dot(m1, e) * dot(m2, e) >= 0.0:
                continue
            origin, f = ends_of(model, c.ridge_edge[j])
            if dot(n1, f) * dot(n2, f) >= 0.0 or not edges_cross(e, f):
                continue
            n = cross(e, f)
            n = scaled((1.0 if dot(n, added(m1, m2)) > 0.0 else -1.0) / norm(n), n)
            if dot(n, added(n1, n2)) >= 0.0:
                continue
            separation = dot(n, apart_from(start, origin))
            if separation > best.separation:
                best = Ridges(separation, c.ridge_edge[i], c.ridge_edge[j], n)
    return best
