"""Compilation of surfaces and declared contacts of a spatial scene: nodes, features, and the passes between them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from lcpflex.bodies.fem.faces import flat_facets
from lcpflex.bodies.spatial.surface import RIM_POINTS, RIMMED, SpatialKind, SpatialSurface
from lcpflex.compile.spatial.features import Feature
from lcpflex.compile.spatial.mesh_features import mesh_features
from lcpflex.contact.spatial.faces.feet import ROUND
from lcpflex.contact.spatial.kinds import CAP, EDGE, FACET, PLANE, POINT, RIM, SIDE
from lcpflex.jit.kernel import FloatArray

__all__ = ["bounds_of", "boxes_of", "deflections", "features_of", "nodes_of"]

PLANAR, SPHERICAL = (SpatialKind.PLANE,), (SpatialKind.SPHERE, SpatialKind.HOLE)
TUBES = (SpatialKind.PIN, SpatialKind.BORE)
MESHES = (SpatialKind.POLYHEDRON, SpatialKind.MESH)
CARRIERS = tuple(kind for kind in SpatialKind if kind not in (*PLANAR, SpatialKind.HOLE))


def nodes_of(surface: SpatialSurface, indices: Sequence[int]) -> list[tuple[int, float]]:
    """(point, radius) of what may touch others."""
    if surface.kind in RIMMED:
        ends = [(index, surface.radius) for index in indices[:2]] if surface.kind is SpatialKind.CYLINDER else []
        return [*((index, 0.0) for index in indices[2:]), *ends]
    radius = -surface.radius if surface.kind is SpatialKind.BORE else surface.radius
    return [(index, radius) for index in indices] if surface.kind in CARRIERS else []


def features_of(surface: SpatialSurface, indices: Sequence[int], first: int) -> list[Feature]:
    """What others may touch; ``first``: index that the first feature gets."""
    kind, radius = surface.kind, surface.radius
    if kind in PLANAR:
        return [Feature(PLANE, (indices[0], indices[1], indices[2]))]
    if kind in SPHERICAL:
        return [Feature(POINT, (indices[0],) * 3, -radius if kind is SpatialKind.HOLE else radius)]
    if kind is SpatialKind.CAPSULE:
        a, b = indices
        ends = [Feature(POINT, (p,) * 3, radius, fan=(q,)) for p, q in ((a, b), (b, a))]
        return [Feature(EDGE, (a, b, a), radius), *ends]
    if kind in TUBES:
        return [Feature(EDGE, (indices[0], indices[1], indices[0]), -radius if kind is SpatialKind.BORE else radius)]
    if kind is SpatialKind.RIM:
        return [Feature(RIM, (indices[0], indices[1], indices[0]), radius)]
    if kind is SpatialKind.CYLINDER:
        low, high = indices[:2]
        rims = [Feature(RIM, (p, q, p), radius) for p, q in ((low, high), (high, low))]
        half = 0.5 * float(np.linalg.norm(surface.points[1].place - surface.points[0].place))
        around = [_around(indices, end) for end in range(2)]
        quarter = RIM_POINTS // 2  # seen from outside, the points of the lower rim come clockwise
        flats = [(low, around[0][quarter], around[0][0]), (high, around[1][0], around[1][quarter])]
        ends = [Feature(CAP, flat, radius, depth=half) for flat in flats]
        chords = [Feature(EDGE, (a, b, a)) for ring in around for a, b in zip(ring, ring[1:] + ring[:1], strict=True)]
        return [*rims, Feature(SIDE, (low, high, low), radius, depth=radius), *ends, *chords]
    if kind is SpatialKind.FACE:
        return _face_features(surface, indices)
    return mesh_features(surface, indices, first) if kind in MESHES else []


def _face_features(surface: SpatialSurface, indices: Sequence[int]) -> list[Feature]:
    """Plane parts of the faces of elements, which belong to it as deep as half of its size."""
    places = np.array([point.place for point in surface.points])
    depth = 0.5 * float(np.linalg.norm(np.ptp(places, axis=0)))
    found = []
    for number, cell in enumerate(surface.cells):
        for corners in flat_facets(np.asarray(cell)[None]).tolist():
            a, b, c = (indices[k] for k in corners)
            found.append(Feature(FACET, (a, b, c), depth=depth, cell=number))
    return found


def _around(indices: Sequence[int], end: int) -> list[int]:
    """The material points of a rim of a cylinder, in their order along it."""
    first, between = (indices[2 + k * RIM_POINTS : 2 + (k + 1) * RIM_POINTS] for k in (end, 2 + end))
    return [point for pair in zip(first, between, strict=True) for point in pair]


def boxes_of(features: Sequence[Feature], places: Mapping[int, FloatArray]) -> tuple[FloatArray, FloatArray]:
    """(k, 3) lower and upper corners of boxes that hold all nodes with a gap of 0 or less, undeformed [m].

    places: of the material points, by their indices.
    """
    lower, upper = np.zeros((2, len(features), 3))
    for k, f in enumerate(features):
        corners = np.array([places[p] for p in f.points])
        if f.kind == FACET and math.isfinite(f.depth):
            n = np.cross(corners[1] - corners[0], corners[2] - corners[0])
            corners = np.vstack([corners, corners - f.depth * n / np.linalg.norm(n)])
        beside = math.inf if f.radius < 0.0 or f.kind == PLANE else f.radius
        if f.cell >= 0:
            beside = ROUND * float(np.ptp(corners[:3], axis=0).max())
        lower[k], upper[k] = corners.min(axis=0) - beside, corners.max(axis=0) + beside
    return lower, upper


def bounds_of(surface: SpatialSurface) -> tuple[float, float, float, float]:
    """Sphere (x, y, z, radius), undeformed, that holds the surface and all nodes that belong to it."""
    points = surface.points[: 2 + 2 * RIM_POINTS] if surface.kind is SpatialKind.CYLINDER else surface.points
    places = np.array([point.place for point in points])
    if surface.kind in PLANAR:
        return (*places[0], math.inf)
    if surface.kind is SpatialKind.HOLE:  # any depth behind its wall belongs to it
        return (*places[0], math.inf)
    x, y, z = 0.5 * (places.min(axis=0) + places.max(axis=0))
    reach = float(np.linalg.norm(places - np.array([x, y, z]), axis=1).max())
    beside = 0.0 if surface.kind in RIMMED else surface.radius
    return float(x), float(y), float(z), reach + beside


def deflections(surfaces: Sequence[SpatialSurface]) -> FloatArray:
    """(surfaces, most modes) greatest displacement that a unit of each mode gives to a point of the surface."""
    modes = max((len(point.phi) for surface in surfaces for point in surface.points), default=0)
    found = np.zeros((len(surfaces), max(modes, 1)))
    for row, surface in zip(found, surfaces, strict=True):
        for point in surface.points:
            row[: len(point.phi)] = np.maximum(row[: len(point.phi)], np.linalg.norm(point.phi, axis=1))
        if surface.kind is SpatialKind.CYLINDER:  # it turns with the material where it begins, and has other points
            start, end = surface.points[:2]
            reach = math.hypot(float(np.linalg.norm(end.place - start.place)), surface.radius)
            turned = np.linalg.norm(start.phi, axis=1) + reach * np.linalg.norm(start.psi, axis=1)
            row[: len(turned)] = np.maximum(row[: len(turned)], turned)
    return found
