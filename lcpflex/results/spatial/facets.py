"""Surfaces of spatial bodies as triangles to be drawn, with normals for their light and the lines that are drawn."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from lcpflex.basics import libs
from lcpflex.bodies.spatial.shapes import CapsuleShape, CylinderShape, Shape, SphereShape, SurfaceShape
from lcpflex.jit.kernel import FloatArray, IntArray

__all__ = ["Facets", "ellipsoid", "facets_with_edges", "facets_of", "sides_of"]

SHARP = math.radians(40.0)  # between two triangles, from which on their edge is drawn and their light differs
ROUND = 48  # sides of a circle; half as many where there are many bodies


class Facets(NamedTuple):
    """Triangles of a surface in the frame of its body; it moves as r = R + A (vertices + Phi eta)."""

    vertices: FloatArray  # (N, 3) undeformed [m]
    phi: FloatArray  # (N, n, 3) mode shapes; n = 0 of what does not deform
    triangles: IntArray  # (T, 3) counter-clockwise seen from outside
    edges: IntArray  # (E, 2) vertices between which a line is drawn
    closed: bool  # whether triangles that show their inside are hidden by others
    smooth: libs.sparse.csr_matrix  # (3 T, T) the triangles whose normals are those of a corner, summed

    def normals(self, places: FloatArray) -> FloatArray:
        """(T, 3, 3) outward unit normals at the corners of all triangles, the vertices being at (N, 3).

        Of a smooth surface the mean over the triangles that meet there, weighted by their areas.
        """
        a, b, c = np.moveaxis(places[self.triangles], 1, 0)
        sums = self.smooth @ np.cross(b - a, c - a)
        lengths = np.linalg.norm(sums, axis=1, keepdims=True)
        return np.asarray(sums / np.where(lengths > 0.0, lengths, 1.0)).reshape(-1, 3, 3)


def facets_of(shape: Shape, coarse: bool = False) -> Facets | None:
    """The surface of a shape; None for one of which the vertices alone are known."""
    sides = sides_of(coarse)
    if isinstance(shape, SurfaceShape):
        if not len(shape.triangles):
            return None
        return facets_with_edges(shape.vertices, shape.triangles, shape.phi, np.zeros((0, 2), np.int64))
    if isinstance(shape, SphereShape):
        return _turned(*_half_circle(shape.radius, 0.0, sides), sides, ring=sides // 4)
    if isinstance(shape, CapsuleShape):
        return _turned(*_half_circle(shape.radius, shape.length, sides), sides)
    assert isinstance(shape, CylinderShape)
    r, z = shape.radius, 0.5 * shape.length
    return _turned(np.array([0.0, r, r, 0.0]), np.array([-z, -z, z, z]), sides)


def sides_of(coarse: bool) -> int:
    """How many sides a circle has."""
    return ROUND // 2 if coarse else ROUND


def ellipsoid(centre: FloatArray, axes: FloatArray, semiaxes: FloatArray, coarse: bool = False) -> Facets:
    """An ellipsoid about ``centre`` (3,): ``axes`` (3, 3) its directions as columns, ``semiaxes`` (3,) [m]."""
    ball = facets_of(SphereShape(1.0), coarse)
    assert ball is not None
    turn = axes if np.linalg.det(axes) > 0.0 else -axes
    return ball._replace(vertices=centre + (ball.vertices * semiaxes) @ turn.T)


def _half_circle(radius: float, length: float, sides: int) -> tuple[FloatArray, FloatArray]:
    """Distances from the axis and heights of a meridian, from the lower pole to the upper one."""
    angle = np.linspace(-0.5 * np.pi, 0.5 * np.pi, sides // 2 + 1)
    r, z = radius * np.cos(angle), radius * np.sin(angle)
    r[[0, -1]] = 0.0
    if length > 0.0:
        middle = sides // 4
        r, z = np.insert(r, middle, radius), np.insert(z, middle, 0.0)
        z[: middle + 1] -= 0.5 * length
        z[middle + 1 :] += 0.5 * length
    return r, z


def _turned(r: FloatArray, z: FloatArray, sides: int, ring: int | None = None) -> Facets:
    """The surface of revolution of a meridian that begins and ends on the z axis.

    One meridian is drawn as a line, and the circle number ``ring``: without them no rotation would be seen.
    """
    angle = 2.0 * np.pi * np.arange(sides) / sides
    rings = zip(r[1:-1].tolist(), z[1:-1].tolist(), strict=True)
    circles = [np.column_stack([a * np.cos(angle), a * np.sin(angle), np.full(sides, h)]) for a, h in rings]
    vertices = np.concatenate([[[0.0, 0.0, z[0]]], *circles, [[0.0, 0.0, z[-1]]]])
    k, following = np.arange(sides), (np.arange(sides) + 1) % sides
    last = len(vertices) - 1
    parts = [np.column_stack([np.zeros(sides, np.int64), 1 + following, 1 + k])]
    for circle in range(len(circles) - 1):
        low, high = 1 + circle * sides, 1 + (circle + 1) * sides
        parts += [np.column_stack([low + k, low + following, high + following])]
        parts += [np.column_stack([low + k, high + following, high + k])]
    top = 1 + (len(circles) - 1) * sides
    parts += [np.column_stack([top + k, top + following, np.full(sides, last)])]
    meridian = np.array([0, *(1 + sides * np.arange(len(circles))), last])
    lines = [np.column_stack([meridian[:-1], meridian[1:]])]
    if ring is not None:
        start = 1 + (ring - 1) * sides
        lines.append(np.column_stack([start + k, start + following]))
    return facets_with_edges(vertices, np.concatenate(parts), np.zeros((len(vertices), 0, 3)), np.concatenate(lines))


def facets_with_edges(vertices: FloatArray, triangles: IntArray, phi: FloatArray, lines: IntArray) -> Facets:
    """With the edges at which two triangles meet at an angle, or one ends."""
    unit = _unit_normals(vertices, triangles)
    pairs = np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
    owner = np.tile(np.arange(len(triangles)), 3)
    edges, number, count = np.unique(pairs, axis=0, return_inverse=True, return_counts=True)
    by_edge = owner[np.argsort(number.ravel(), kind="stable")]
    first = np.cumsum(count) - count
    twice = count == 2
    sharp = ~twice
    sharp[twice] = np.sum(unit[by_edge[first[twice]]] * unit[by_edge[first[twice] + 1]], axis=1) < math.cos(SHARP)
    drawn = np.concatenate([edges[sharp], lines]).astype(np.int64)
    return Facets(vertices, phi, triangles, drawn, bool(twice.all()), _smoothing(len(vertices), triangles, unit))


def _smoothing(n: int, triangles: IntArray, unit: FloatArray) -> libs.sparse.csr_matrix:
    """Of each corner, the triangles at its vertex that make no sharp angle with its own one."""
    corners = triangles.ravel()
    ones, number = np.ones(len(corners)), np.arange(len(corners))
    at = libs.sparse.csr_matrix((ones, (number, corners)), shape=(len(corners), n))
    of = libs.sparse.csr_matrix((ones, (corners, number // 3)), shape=(n, len(triangles)))
    pairs = (at @ of).tocoo()
    near = np.sum(unit[pairs.row // 3] * unit[pairs.col], axis=1) >= math.cos(SHARP)
    near |= pairs.row // 3 == pairs.col  # of a triangle without an area, too
    return libs.sparse.csr_matrix((np.ones(int(near.sum())), (pairs.row[near], pairs.col[near])), shape=pairs.shape)


def _unit_normals(places: FloatArray, triangles: IntArray) -> FloatArray:
    a, b, c = np.moveaxis(places[triangles], 1, 0)
    across = np.cross(b - a, c - a)
    lengths = np.linalg.norm(across, axis=1, keepdims=True)
    return np.asarray(across / np.where(lengths > 0.0, lengths, 1.0))
