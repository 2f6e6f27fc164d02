"""Compilation of surfaces and declared contacts of a spatial scene: nodes, features, and the passes between them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from lcpflex.bodies.spatial.surface import CODES, SpatialKind, SpatialSurface
from lcpflex.contact.spatial.kinds import PLANE, POINT
from lcpflex.jit.kernel import FloatArray

__all__ = ["Feature", "bounds_of", "deflections", "features_of", "nodes_of"]

PLANAR, SPHERICAL = (SpatialKind.PLANE,), (SpatialKind.SPHERE, SpatialKind.HOLE)
CARRIERS = tuple(kind for kind in SpatialKind if kind not in (*PLANAR, SpatialKind.HOLE))


class Feature(NamedTuple):
    """What others may touch: material points by their indices, radius and depth [m], and neighbours."""

    kind: int
    points: tuple[int, int, int]
    radius: float = 0.0
    depth: float = math.inf
    neighbour: tuple[int, int, int] = (-1, -1, -1)


def nodes_of(surface: SpatialSurface, indices: Sequence[int]) -> list[tuple[int, float]]:
    """(point, radius) of what may touch others."""
    return [(index, surface.radius) for index in indices] if surface.kind in CARRIERS else []


def features_of(surface: SpatialSurface, indices: Sequence[int]) -> list[Feature]:
    """What others may touch."""
    if surface.kind in PLANAR:
        return [Feature(PLANE, (indices[0], indices[1], indices[2]))]
    if surface.kind in SPHERICAL:
        inside = surface.kind is SpatialKind.HOLE
        return [Feature(POINT, (indices[0],) * 3, -surface.radius if inside else surface.radius)]
    return []


def bounds_of(surface: SpatialSurface) -> tuple[float, float, float, float]:
    """Sphere (x, y, z, radius), undeformed, that holds the surface and all nodes that belong to it."""
    places = np.array([point.place for point in surface.points])
    if surface.kind in PLANAR:
        return (*places[0], math.inf)
    if surface.kind is SpatialKind.HOLE:  # any depth behind its wall belongs to it
        return (*places[0], math.inf)
    x, y, z = 0.5 * (places.min(axis=0) + places.max(axis=0))
    reach = float(np.linalg.norm(places - np.array([x, y, z]), axis=1).max())
    return float(x), float(y), float(z), reach + surface.radius


def deflections(surfaces: Sequence[SpatialSurface]) -> FloatArray:
    """(surfaces, most modes) greatest displacement that a unit of each mode gives to a point of the surface."""
    modes = max((len(point.phi) for surface in surfaces for point in surface.points), default=0)
    found = np.zeros((len(surfaces), max(modes, 1)))
    for row, surface in zip(found, surfaces, strict=True):
        for point in surface.points:
            row[: len(point.phi)] = np.maximum(row[: len(point.phi)], np.linalg.norm(point.phi, axis=1))
    return found


def code_of(surface: SpatialSurface) -> int:
    """The number by which kernels know its kind."""
    return CODES[surface.kind]
