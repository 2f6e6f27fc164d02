"""What a face of a solid touches with: its nodes, or areas about them.

A face is split into linear parts (four of a face of six or nine nodes, else itself), and the hat phi_a, linear or
bilinear on these and 1 at node a, makes one contact of all samples s around a, the points of quadrature of the parts,

    c_as = w_s phi_a(s),   A_a = sum_s c_as,   r_a = sum_s c_as r(s) / A_a

with the shape functions of the face for r(s). On planes, spheres and cylinders this is one material point. Over a
sphere of radius R its gap is less than the mean of the gaps of the samples by about <rho^2>/2R, rho being their
distance from it (see :mod:`lcpflex.contact.spatial.faces.round_means`). Faces of eight nodes have no linear parts with
positive shares: the hats of their corners serve. The positive hats make pressures lambda_a/A_a that cannot pull (see
:mod:`lcpflex.contact.spatial.faces.means`).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import NamedTuple

import numpy as np

from lcpflex.basics import libs
from lcpflex.bodies.fem.faces import HAT_PARTS
from lcpflex.bodies.spatial.body import SpatialPoint
from lcpflex.bodies.spatial.surface import SpatialSurface
from lcpflex.contact.spatial.faces.shapes import lay_shapes
from lcpflex.jit.kernel import FloatArray, IntArray

__all__ = ["AREAS", "LINEAR", "NODES", "FaceParts", "face_parts"]

NODES, AREAS = "nodes", "areas"
# of quadrature in a part, 7 points of a triangle, 25 of a quadrilateral: stress beside a face is right to .6 %; 16 miss
# 1.4 % where meshes are nearly equal, as faces of the master end within a part
ORDER = {3: 5, 4: 9}
LINEAR = (3, 4)  # nodes of faces on which the force on a node is shared out over the hat about it
CORNERS = {3: [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)], 4: [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]}


class Reference(NamedTuple):
    """Samples of a face of k nodes: shape functions, their derivatives, weights, and hats of its nodes."""

    shape: FloatArray  # (s, k, 3)
    weight: FloatArray  # (s,) in the reference face
    hat: FloatArray  # (s, k)


@dataclass(frozen=True, slots=True, eq=False)
class FaceParts:
    """What a face touches with, k nodes or areas, and the samples that they are means of.

    Attributes
    ----------
    points : (k,) material points
    pressed : (k,) [m^2] area that the force of each is a pressure on; 0 where it is none
    spread : (k, 6) [m^2] mean products of the distances of its samples from it: xx, yy, zz, yz, xz, xy
    normals : (k, 3) outward, undeformed
    samples : of each, their numbers
    shares : of each, its part of each of them [m^2]
    nodes : of each sample, which of the points of the surface
    weights : of each sample, theirs
    outward : (s, 3) normal at each sample
    """

    points: tuple[SpatialPoint, ...]
    pressed: FloatArray
    spread: FloatArray
    normals: FloatArray
    samples: list[IntArray]
    shares: list[FloatArray]
    nodes: list[IntArray]
    weights: list[FloatArray]
    outward: FloatArray


def _shapes(nodes: int, x: float, y: float) -> FloatArray:
    """(k, 3) N, dN/dx, dN/dy of a face of k nodes."""
    shape = np.zeros((9, 3))
    lay_shapes(nodes, x, y, shape)
    return shape[:nodes]


@cache
def _places(nodes: int) -> FloatArray:
    """(k, 2) coordinates of the nodes of the reference face."""
    corners = np.array(CORNERS[3 if nodes in (3, 6) else 4])
    sides = 0.5 * (corners + np.roll(corners, -1, axis=0))
    return np.vstack([corners, sides, [corners.mean(axis=0)]])[:nodes]


@cache
def _reference(nodes: int) -> Reference:
    """The samples of a face of so many nodes."""
    places = _places(nodes)
    found = []
    for part in HAT_PARTS[nodes]:
        corners = len(part)
        element = libs.skfem.MeshTri if corners == 3 else libs.skfem.MeshQuad
        at, weights = libs.skfem.quadrature.get_quadrature(element.elem, ORDER[corners])
        ways = at.T if corners == 3 else 2.0 * at.T - 1.0
        scale = 1.0 if corners == 3 else 4.0
        for way, weight in zip(ways, weights, strict=True):
            local = _shapes(corners, *way.tolist())
            x, y = places[part].T @ local[:, 0]
            jacobian = abs(float(np.linalg.det(places[part].T @ local[:, 1:])))
            hat = np.zeros(nodes)
            hat[part] = local[:, 0]
            found.append((_shapes(nodes, float(x), float(y)), scale * weight * jacobian, hat))
    shape, weight, hat = (np.array(column) for column in zip(*found, strict=True))
    return Reference(shape, weight, hat)


def _surface_of(places: FloatArray, shape: FloatArray) -> tuple[FloatArray, FloatArray]:
    """(s,) area by that of the reference face and (s, 3) unit normals of a face of nodes at ``places`` (k, 3)."""
    along = np.einsum("ska,kc->sac", shape[:, :, 1:], places)
    normal = np.cross(along[:, 0], along[:, 1])
    size = np.linalg.norm(normal, axis=1)
    return size, normal / size[:, None]


def face_parts(surface: SpatialSurface, by: str) -> FaceParts:
    """What a face touches with, ``by`` NODES or AREAS."""
    return _areas(surface) if by == AREAS else _nodes(surface)


class _Samples(NamedTuple):
    """Of all faces, s of them."""

    nodes: list[IntArray]
    weights: list[FloatArray]
    hats: list[FloatArray]
    area: FloatArray  # (s,)
    places: FloatArray  # (s, 3)
    outward: FloatArray  # (s, 3)


def _samples(surface: SpatialSurface) -> _Samples:
    places = np.array([point.place for point in surface.points])
    nodes, weights, hats, areas, where, outward = [], [], [], [], [], []
    for cell in surface.cells:
        reference = _reference(len(cell))
        size, normal = _surface_of(places[cell], reference.shape)
        nodes += [cell] * len(size)
        weights += list(reference.shape[:, :, 0])
        hats += list(reference.hat)
        areas.append(reference.weight * size)
        where.append(reference.shape[:, :, 0] @ places[cell])
        outward.append(normal)
    return _Samples(nodes, weights, hats, np.concatenate(areas), np.concatenate(where), np.concatenate(outward))


def _areas(surface: SpatialSurface) -> FaceParts:
    found = _samples(surface)
    own: list[dict[int, float]] = [{} for _ in surface.points]
    for s, (nodes, hats) in enumerate(zip(found.nodes, found.hats, strict=True)):
        for node, hat in zip(nodes.tolist(), hats.tolist(), strict=True):
            if hat > 0.0:
                own[node][s] = hat * float(found.area[s])
    own = [shares for shares in own if shares]
    samples = [np.array(list(shares), dtype=np.int64) for shares in own]
    shares = [np.array(list(one.values())) for one in own]
    points = tuple(_mean(surface, found, s, c) for s, c in zip(samples, shares, strict=True))
    normals = np.array([_unit(c @ found.outward[s]) for s, c in zip(samples, shares, strict=True)])
    spread = np.array([
        _spread(found.places[s] - point.place, c) for s, c, point in zip(samples, shares, points, strict=True)
    ])  # fmt: skip
    pressed = np.array([sum(c.tolist()) for c in shares])  # one after the other, as what is common is: all of it is all
    return FaceParts(points, pressed, spread, normals, samples, shares, found.nodes, found.weights, found.outward)


def _mean(surface: SpatialSurface, found: _Samples, samples: IntArray, shares: FloatArray) -> SpatialPoint:
    """The material point that is the mean of samples."""
    weight = np.zeros(len(surface.points))
    for s, share in zip(samples.tolist(), (shares / shares.sum()).tolist(), strict=True):
        weight[found.nodes[s]] += share * found.weights[s]
    some = np.flatnonzero(weight)
    place = sum(weight[k] * surface.points[k].place for k in some)
    phi = sum(weight[k] * surface.points[k].phi for k in some)
    return SpatialPoint(np.asarray(place), np.asarray(phi), np.zeros_like(phi), False)


def _unit(vector: FloatArray) -> FloatArray:
    return np.asarray(vector / np.linalg.norm(vector))


def _spread(away: FloatArray, shares: FloatArray) -> FloatArray:
    mean = np.einsum("s,si,sj->ij", shares / shares.sum(), away, away)
    return np.asarray(mean[[0, 1, 2, 1, 0, 0], [0, 1, 2, 2, 2, 1]])


def _nodes(surface: SpatialSurface) -> FaceParts:
    """The nodes of the corners and sides, each the only sample of its own."""
    found = _samples(surface)
    count = len(surface.points)
    hat, outward, used = np.zeros(count), np.zeros((count, 3)), np.zeros(count, dtype=bool)
    for s, (nodes, hats) in enumerate(zip(found.nodes, found.hats, strict=True)):
        hat[nodes] += hats * found.area[s]
        outward[nodes] += found.area[s] * found.outward[s]
        used[nodes] = True
    linear = all(len(cell) in LINEAR for cell in surface.cells)
    own = np.flatnonzero(used)
    normals = np.array([_unit(outward[k]) for k in own])
    share = np.where(hat[own] > 0.0, hat[own], hat[own].max() if len(own) else 1.0)
    one = np.ones(1)
    return FaceParts(
        tuple(surface.points[k] for k in own),
        hat[own] if linear else np.zeros(len(own)),
        np.zeros((len(own), 6)),
        normals,
        [np.array([k], dtype=np.int64) for k in range(len(own))],
        [np.array([size]) for size in share],
        [np.array([k], dtype=np.int64) for k in own],
        [one] * len(own),
        normals,
    )
