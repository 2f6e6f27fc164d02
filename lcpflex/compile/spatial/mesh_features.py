"""Facets, edges and vertices of surfaces of triangles: which of them can be touched, and how deep the solid is below.

Flat and hollow edges carry nothing: the facets beside them own all nodes there. So do vertices without a bulging edge.
Across a hollow edge, a facet goes on below the one it meets there.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from lcpflex.bodies.spatial.surface import SpatialSurface
from lcpflex.compile.spatial.features import Feature
from lcpflex.contact.spatial.kinds import EDGE, FACET, POINT
from lcpflex.contact.spatial.mesh_pairs import BENT
from lcpflex.contact.spatial.narrow_phase.edges import TILT
from lcpflex.jit.kernel import FloatArray, IntArray, kernel

__all__ = ["mesh_features", "node_facings", "node_normals"]

STRAIGHT = 1e-9  # [rad] an edge of smaller turn is flat
ON_SIDE = 1e-9  # of the square of its length: a ray that misses the side of a facet by a smaller area meets that


def mesh_features(surface: SpatialSurface, indices: Sequence[int], first: int) -> list[Feature]:
    """What others may touch; ``first``: index that the first feature gets."""
    places = np.array([point.place for point in surface.points])
    triangles = surface.triangles
    normals = facet_normals(places, triangles)
    depths = facet_depths(places, triangles, normals)
    features = [
        Feature(FACET, _three(indices, triangle), depth=float(depth))
        for triangle, depth in zip(triangles, depths, strict=True)
    ]
    least = -BENT if any(point.phi.any() for point in surface.points) else STRAIGHT
    fans: dict[int, set[int]] = {}
    bulging: set[int] = set()
    for (a, b), sides in sides_of(triangles).items():
        fans.setdefault(a, set()).add(b)
        fans.setdefault(b, set()).add(a)
        turn = _turn(places, triangles, normals, sides)
        if turn > least:
            facets = [first + facet for facet, _ in sides]
            depth = min(float(depths[facet]) for facet, _ in sides)
            neighbour = (facets[0], facets[1] if len(facets) == 2 else -1, 1 if turn > BENT else -1)
            features.append(Feature(EDGE, (indices[a], indices[b], indices[a]), depth=depth, neighbour=neighbour))
            bulging |= {a, b}
        if turn < -STRAIGHT:
            for (facet, side), (other, _) in (sides, sides[::-1]):
                beside = list(features[facet].neighbour)
                beside[side] = first + other
                features[facet] = features[facet]._replace(neighbour=(beside[0], beside[1], beside[2]))
    for vertex in sorted(bulging):
        around = tuple(indices[w] for w in sorted(fans[vertex]))
        features.append(Feature(POINT, (indices[vertex],) * 3, fan=around))
    return features


def node_normals(surface: SpatialSurface) -> FloatArray:
    """(points, 3) mean outward normal of the facets about each vertex, by their angles there; 0 without facets."""
    places = np.array([point.place for point in surface.points])
    means = np.zeros_like(places)
    if not len(surface.triangles):
        return means
    normals = facet_normals(places, surface.triangles)
    for k in range(3):
        vertex, after, before = (surface.triangles[:, (k + step) % 3] for step in range(3))
        e, f = places[after] - places[vertex], places[before] - places[vertex]
        angle = np.arctan2(np.linalg.norm(np.cross(e, f), axis=1), np.einsum("ij,ij->i", e, f))
        np.add.at(means, vertex, angle[:, None] * normals)
    lengths = np.linalg.norm(means, axis=1)[:, None]
    return np.where(lengths > STRAIGHT, means / np.maximum(lengths, STRAIGHT), 0.0)


def node_facings(surface: SpatialSurface, means: FloatArray) -> FloatArray:
    """(points,) cosine of the angle between the mean normal of each vertex and that of any facet about it, at most.

    A little is added to that angle, as faces that are nearly parallel touch; 0 where it is a right angle, or unknown.
    """
    widest = np.where(means.any(axis=1), 0.0, 0.5 * math.pi)
    if len(surface.triangles):
        normals = facet_normals(np.array([point.place for point in surface.points]), surface.triangles)
        for k in range(3):
            vertex = surface.triangles[:, k]
            sines = np.linalg.norm(np.cross(means[vertex], normals), axis=1)
            np.maximum.at(widest, vertex, np.arctan2(sines, np.einsum("ij,ij->i", means[vertex], normals)))
    return np.asarray(np.cos(np.minimum(widest + TILT, 0.5 * math.pi)))


def facet_normals(places: FloatArray, triangles: IntArray) -> FloatArray:
    """(T, 3) outward unit normals."""
    a, b, c = np.moveaxis(places[triangles], 1, 0)
    n = np.cross(b - a, c - a)
    return np.asarray(n / np.linalg.norm(n, axis=1)[:, None])


def sides_of(triangles: IntArray) -> dict[tuple[int, int], list[tuple[int, int]]]:
    """(facet, number of the opposite corner) of the facets at each edge, by its vertices, the lower one first."""
    found: dict[tuple[int, int], list[tuple[int, int]]] = {}
    for facet, corners in enumerate(triangles.tolist()):
        for k in range(3):
            a, b = corners[(k + 1) % 3], corners[(k + 2) % 3]
            found.setdefault((min(a, b), max(a, b)), []).append((facet, k))
    return found


def _turn(places: FloatArray, triangles: IntArray, normals: FloatArray, sides: list[tuple[int, int]]) -> float:
    """Angle between the normals of two facets, > 0 where they bulge [rad]; pi at the border of an open surface."""
    if len(sides) == 1:
        return math.pi
    (f, _), (g, opposite) = sides
    across = places[triangles[g, opposite]] - places[triangles[f, 0]]
    angle = math.atan2(float(np.linalg.norm(np.cross(normals[f], normals[g]))), float(normals[f] @ normals[g]))
    return angle if normals[f] @ across <= 0.0 else -angle


def facet_depths(places: FloatArray, triangles: IntArray, normals: FloatArray) -> FloatArray:
    """(T,) half the way from the middle of each facet into the solid until it ends; the size of an open surface."""
    size = float(np.linalg.norm(np.ptp(places, axis=0)))
    corners = np.ascontiguousarray(places[triangles])
    depths = np.full(len(triangles), size)
    if len(triangles):
        inward_ways(corners, np.ascontiguousarray(normals), depths)
    return np.asarray(0.5 * depths)


@kernel
def inward_ways(corners: FloatArray, normals: FloatArray, ways: FloatArray) -> None:
    """Shorten ``ways`` (T,) to where the rays from the middles of facets against their normals leave the solid.

    By Moeller and Trumbore (1997), for each pair of facets that face away from each other.
    """
    for f in range(len(ways)):
        dx, dy, dz = -normals[f, 0], -normals[f, 1], -normals[f, 2]
        ox = (corners[f, 0, 0] + corners[f, 1, 0] + corners[f, 2, 0]) / 3.0
        oy = (corners[f, 0, 1] + corners[f, 1, 1] + corners[f, 2, 1]) / 3.0
        oz = (corners[f, 0, 2] + corners[f, 1, 2] + corners[f, 2, 2]) / 3.0
        for g in range(len(ways)):
            along = normals[g, 0] * dx + normals[g, 1] * dy + normals[g, 2] * dz
            if g == f or along <= 0.0:
                continue
            ax, ay, az = corners[g, 0, 0] - ox, corners[g, 0, 1] - oy, corners[g, 0, 2] - oz
            t = (normals[g, 0] * ax + normals[g, 1] * ay + normals[g, 2] * az) / along
            if t <= 0.0 or t >= ways[f]:
                continue
            inside = True
            for k in range(3):
                m = (k + 1) % 3
                ex = corners[g, m, 0] - corners[g, k, 0]
                ey = corners[g, m, 1] - corners[g, k, 1]
                ez = corners[g, m, 2] - corners[g, k, 2]
                px = ox + t * dx - corners[g, k, 0]
                py = oy + t * dy - corners[g, k, 1]
                pz = oz + t * dz - corners[g, k, 2]
                cx, cy, cz = ey * pz - ez * py, ez * px - ex * pz, ex * py - ey * px
                area = cx * normals[g, 0] + cy * normals[g, 1] + cz * normals[g, 2]
                if area < -ON_SIDE * (ex * ex + ey * ey + ez * ez):
                    inside = False
            if inside:
                ways[f] = t


def _three(indices: Sequence[int], triangle: IntArray) -> tuple[int, int, int]:
    a, b, c = (indices[int(vertex)] for vertex in triangle)
    return a, b, c
