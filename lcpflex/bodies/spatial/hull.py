"""Convex hulls of points in space, and integrals of x over polyhedra: exact sums over tetrahedra."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from lcpflex.basics import libs
from lcpflex.errors import ModelError
from lcpflex.jit.kernel import FloatArray, IntArray

__all__ = ["Hull", "block", "convex_hull", "moments_of"]

FLAT = 1e-12  # volume relative to the cube of the size, below which there is none


class Hull(NamedTuple):
    """A convex polyhedron, its frame at its centre of volume."""

    corners: IntArray  # (c,) which of the points that were given are its vertices, ascending
    triangles: IntArray  # (T, 3) of the corners, counter-clockwise seen from outside
    vertices: FloatArray  # (c, 3) from the centre
    centre: FloatArray  # (3,) in the frame of the points
    volume: float
    second: FloatArray  # (3, 3) integral of x x^T dV about the centre


def block() -> tuple[FloatArray, IntArray]:
    """Corners (8, 3) of a block about the origin with edges of 1 m along the axes, and its triangles (12, 3)."""
    corners = np.array([[i, j, k] for i in (0, 1) for j in (0, 1) for k in (0, 1)]) - 0.5
    quads = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
    return corners, np.array([t for p, q, r, s in quads for t in ((p, q, r), (p, r, s))], dtype=np.int64)


def convex_hull(points: FloatArray) -> Hull:
    """The convex hull of points (k, 3).

    The integrals are sums over the tetrahedra (0, a, b, c) from a point inside to the triangles, V = det(a, b, c) / 6.

    Raises
    ------
    ModelError
        For fewer than four points, and points in one plane.
    """
    if len(points) < 4:
        raise ModelError(f"points: {len(points)} were given, expected at least 4")
    inside = points.mean(axis=0)
    size = float(np.ptp(points, axis=0).max())
    scaled = (points - inside) / size if size > 0.0 else np.zeros_like(points)
    try:
        found = libs.ConvexHull(scaled)
    except (libs.QhullError, ValueError):
        raise ModelError("points: they lie in one plane, expected a hull with a volume") from None
    corners = np.sort(found.vertices).astype(np.int64)
    number = np.full(len(points), -1)
    number[corners] = np.arange(len(corners))
    triangles = number[found.simplices]
    vertices = scaled[corners] - scaled[corners].mean(axis=0)
    a, b, c = np.moveaxis(vertices[triangles], 1, 0)
    six = np.einsum("ti,ti->t", a, np.cross(b, c))
    turned = six < 0.0
    triangles[turned] = triangles[turned][:, ::-1]
    parts = np.abs(six) / 6.0
    volume = float(parts.sum())
    if not volume > FLAT:
        raise ModelError(
            f"points: their hull has {volume:.3g} of the volume of a cube of its size, expected a hull with a volume"
        )
    centre, second = moments_of(a, b, c, parts)
    return Hull(
        corners=corners,
        triangles=np.asarray(triangles, dtype=np.int64),
        vertices=size * (vertices - centre),
        centre=inside + size * (scaled[corners].mean(axis=0) + centre),
        volume=volume * size**3,
        second=second * size**5,
    )


def moments_of(a: FloatArray, b: FloatArray, c: FloatArray, parts: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The centre (3,) of tetrahedra (0, a, b, c), and the integral (3, 3) of x x^T dV about it.

    a, b, c : (T, 3) corners
    parts : (T,) volumes, negative where a, b, c are clockwise seen from outside of a body that they make up together;
        their sum is positive

    Of each, integral of x = V (a + b + c) / 4 and of x x^T = V (sum v v^T + sum v (sum v)^T) / 20.
    """
    volume, total = float(parts.sum()), a + b + c
    centre = (parts @ total) / (4.0 * volume)
    second = np.einsum("t,tvi,tvj->ij", parts, np.stack([a, b, c, total], 1), np.stack([a, b, c, total], 1)) / 20.0
    second -= volume * np.outer(centre, centre)
    return centre, np.asarray(0.5 * (second + second.T))
