"""Faces of convex polyhedra as polygons: triangles that lie in one plane are one, with its sides and their edges.

What touches another convex body is a polygon, not a triangle: a face clipped against half a face is half a patch.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from lcpflex.bodies.spatial.surface import SpatialSurface
from lcpflex.compile.spatial.features import Feature
from lcpflex.compile.spatial.mesh_features import STRAIGHT, facet_normals, sides_of
from lcpflex.contact.spatial.kinds import EDGE, FACET, POLYGON
from lcpflex.jit.kernel import FloatArray, IntArray

__all__ = ["Polygon", "polygons_of"]

ONE_PLANE = 1e-6  # of the size of a body: triangles whose corners are so near one plane are one face


class Polygon(NamedTuple):
    """A face: its feature, its plane n.x = c in the frame of the body, and its sides, counter-clockwise."""

    feature: int
    plane: tuple[float, float, float, float]  # n, c [m]
    corners: tuple[int, ...]  # of the points of the surface, where each side begins
    edges: tuple[int, ...]  # features of the sides
    across: tuple[int, ...]  # material points of it that are farthest from each side


def polygons_of(
    surface: SpatialSurface, indices: Sequence[int], features: Sequence[Feature], first: int, before: int
) -> tuple[list[Feature], list[Polygon]]:
    """Features to be added to those of the triangles, which begin at ``first``, and the polygons.

    before: how many polygons other surfaces have.
    """
    places = np.array([point.place for point in surface.points])
    triangles = surface.triangles
    normals = facet_normals(places, triangles)
    edges = {tuple(sorted(f.points[:2])): first + k for k, f in enumerate(features) if f.kind == EDGE}
    added: list[Feature] = []
    found: list[Polygon] = []
    for seed, group in _faces(places, triangles, normals):
        corners = _outline(triangles, group)
        sides = []
        for a, b in zip(corners, corners[1:] + corners[:1], strict=True):
            pair = tuple(sorted((indices[a], indices[b])))
            if pair not in edges:  # so flat that nothing else touches it as an edge
                edges[pair] = first + len(features) + len(added)
                added.append(Feature(EDGE, (pair[0], pair[1], pair[0]), depth=features[seed].depth))
            sides.append(edges[pair])
        depth = max(features[k].depth for k in group if features[k].kind == FACET)
        a, b, c = (indices[int(v)] for v in triangles[seed])
        n = normals[seed]
        plane = (float(n[0]), float(n[1]), float(n[2]), float(n @ places[triangles[seed, 0]]))
        far = _across(places, corners, indices)
        neighbour = (before + len(found), -1, -1)
        found.append(Polygon(first + len(features) + len(added), plane, tuple(corners), tuple(sides), far))
        added.append(Feature(POLYGON, (a, b, c), depth=depth, neighbour=neighbour))
    return added, found


def _across(places: FloatArray, corners: Sequence[int], indices: Sequence[int]) -> tuple[int, ...]:
    """Of each side of a polygon, the material point of its corners that is farthest from it."""
    at = places[list(corners)]
    e = np.roll(at, -1, axis=0) - at
    far = np.linalg.norm(np.cross(e[:, None, :], at[None, :, :] - at[:, None, :]), axis=2).argmax(axis=1)
    return tuple(indices[corners[k]] for k in far.tolist())


def _faces(places: FloatArray, triangles: IntArray, normals: FloatArray) -> list[tuple[int, list[int]]]:
    """Largest triangle, and all triangles, of each face; largest faces first."""
    size = float(np.linalg.norm(np.ptp(places, axis=0)))
    a, b, c = np.moveaxis(places[triangles], 1, 0)
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    across = _neighbours(triangles)
    left = set(range(len(triangles)))
    found = []
    for seed in np.argsort(-areas, kind="stable").tolist():
        if seed not in left:
            continue
        group: list[int] = [seed]
        for tolerance in (ONE_PLANE * size, STRAIGHT * size, 0.0):
            group = _grown(seed, places, triangles, normals, across, left, tolerance)
            if _is_convex(places, _outline(triangles, group), normals[seed], tolerance):
                break
            group = [seed]
        left -= set(group)
        found.append((seed, sorted(group)))
    return found


def _neighbours(triangles: IntArray) -> Mapping[int, list[int]]:
    """Triangles at the sides of each."""
    across: dict[int, list[int]] = {f: [] for f in range(len(triangles))}
    for sides in sides_of(triangles).values():
        for f, _ in sides:
            across[f] += [g for g, _ in sides if g != f]
    return across


def _grown(
    seed: int, places: FloatArray, triangles: IntArray, normals: FloatArray, across: Mapping[int, list[int]],
    left: set[int], tolerance: float,
) -> list[int]:  # fmt: skip
    """The triangles about one of them whose corners lie in its plane, to ``tolerance`` [m]."""
    n, start = normals[seed], places[triangles[seed, 0]]
    group, front = {seed}, [seed]
    while front:
        for g in across[front.pop()]:
            near = np.abs((places[triangles[g]] - start) @ n).max() <= tolerance and normals[g] @ n > 0.0
            if near and g in left and g not in group:
                group.add(g)
                front.append(g)
    return sorted(group)


def _outline(triangles: IntArray, group: Sequence[int]) -> list[int]:
    """Vertices around a group of triangles, counter-clockwise; none where that is no single loop."""
    sides = {(int(t[k]), int(t[(k + 1) % 3])) for t in triangles[list(group)] for k in range(3)}
    behind = {a: b for a, b in sides if (b, a) not in sides}
    count = sum((b, a) not in sides for a, b in sides)
    corners = [min(behind)] if behind else []
    while corners and behind[corners[-1]] != corners[0] and len(corners) <= count:
        corners.append(behind[corners[-1]])
    return corners if len(corners) == count else []


def _is_convex(places: FloatArray, corners: Sequence[int], n: FloatArray, tolerance: float) -> bool:
    """Whether all corners are behind all sides, to ``tolerance`` [m]."""
    if not corners:
        return False
    at = places[list(corners)]
    e = np.roll(at, -1, axis=0) - at
    out = np.cross(e, n)
    out /= np.linalg.norm(out, axis=1)[:, None]
    beyond = np.einsum("ki,kji->kj", out, at[None, :, :] - at[:, None, :])
    rounding = 1e-12 * float(np.abs(at).max())
    return bool(beyond.max() <= max(tolerance, rounding))
