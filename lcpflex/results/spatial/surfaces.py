"""Surfaces on the ground and on parts of bodies in the picture of a spatial scene, those that are no body's shape."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from lcpflex.basics import libs
from lcpflex.bodies.spatial.shapes import CapsuleShape, CylinderShape, SphereShape, SurfaceShape
from lcpflex.bodies.spatial.surface import CODES, RIM_POINTS, SpatialKind
from lcpflex.contact.spatial.kinds import FACET
from lcpflex.kinematics.places import material_shapes
from lcpflex.results.spatial.facets import Facets, facets_of, facets_with_edges, sides_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lcpflex.bodies.spatial.shapes import Shape
    from lcpflex.jit.kernel import FloatArray, IntArray
    from lcpflex.model.spatial import SpatialModel

__all__ = ["Part", "clipped", "parts_of"]

SAME = 1e-9  # of its size: a surface this near to the shape of its body is that shape
MERGED = 1e-6  # of the region: corners of cut triangles this near are one
KINDS = {code: kind for kind, code in CODES.items()}
SOLIDS = {SphereShape: "SPHERE", CapsuleShape: "CAPSULE", CylinderShape: "CYLINDER"}


class Part(NamedTuple):
    """A surface of a body, or of the ground: -1."""

    body: int
    facets: Facets


def parts_of(model: SpatialModel, shapes: Sequence[Shape | None], coarse: bool) -> list[Part]:
    """All surfaces of a model but planes, nodes, and those that are the shape of their body, or faces of its mesh.

    Each moves with the material that carries it. ``coarse``: circles have half as many sides.
    """
    c, found = model.contacts, []
    for s, (body, code) in enumerate(zip(c.surface_body.tolist(), c.surface_kind.tolist(), strict=True)):
        kind = KINDS[code]
        if kind in (SpatialKind.NODE, SpatialKind.PLANE, SpatialKind.FACE):
            continue
        if body < 0 or not _is_shape(shapes[body], kind, c.surface_center[s], float(c.surface_extent[s])):
            found.append(Part(body, _facets_of(model, s, kind, coarse)))
    return found


def _is_shape(shape: Shape | None, kind: SpatialKind, centre: FloatArray, reach: float) -> bool:
    """Whether a surface about ``centre`` (3,) is the shape of its body."""
    if isinstance(shape, SurfaceShape):
        if kind not in (SpatialKind.POLYHEDRON, SpatialKind.MESH) or not len(shape.vertices):
            return False
        middle = 0.5 * (shape.vertices.min(axis=0) + shape.vertices.max(axis=0))
        own = float(np.linalg.norm(shape.vertices - middle, axis=1).max())
    elif shape is None or SOLIDS[type(shape)] != kind.name:
        return False
    else:
        middle, half = np.zeros(3), 0.5 * getattr(shape, "length", 0.0)
        own = math.hypot(shape.radius, half) if kind is SpatialKind.CYLINDER else shape.radius + half
    return abs(own - reach) <= SAME * own and float(np.abs(middle - centre).max()) <= SAME * own


def _facets_of(model: SpatialModel, s: int, kind: SpatialKind, coarse: bool) -> Facets:
    """The surface number ``s``."""
    c = model.contacts
    features = slice(int(c.feature_start[s]), int(c.feature_start[s + 1]))
    first, radius = c.feature_point[features][0], abs(float(c.feature_radius[features][0]))
    if kind in (SpatialKind.POLYHEDRON, SpatialKind.MESH):
        corners = c.feature_point[features][c.feature_kind[features] == FACET]
        points, number = np.unique(corners, return_inverse=True)
        return _placed(_carriers(model, points), number.reshape(-1, 3), np.zeros((0, 2), np.int64))
    if kind is SpatialKind.CAPSULE:
        ends = _carriers(model, first[:2])
        along = ends[1, -1] - ends[0, -1]
        length = float(np.linalg.norm(along))
        whole = facets_of(CapsuleShape(radius, length), coarse)
        assert whole is not None
        upper = whole.vertices[:, 2] > 0.0
        around = whole.vertices - np.where(upper, 0.5, -0.5)[:, None] * [0.0, 0.0, length]
        carried = ends[upper.astype(int)]
        carried[:, -1] += around @ _axes_about(along / length)
        return _placed(carried, whole.triangles, whole.edges)
    if kind in (SpatialKind.SPHERE, SpatialKind.HOLE):
        ball = facets_of(SphereShape(radius), coarse)
        assert ball is not None
        carried = np.repeat(_carriers(model, first[:1]), len(ball.vertices), axis=0)
        carried[:, -1] += ball.vertices
        inside = kind is SpatialKind.HOLE  # its wall is seen from within
        return _placed(carried, ball.triangles[:, ::-1] if inside else ball.triangles, ball.edges)
    if kind in (SpatialKind.PIN, SpatialKind.BORE):
        return _tube(_carriers(model, first[:2]), radius, kind is SpatialKind.BORE, coarse)
    around_nodes = c.node_point[c.node_start[s] : c.node_start[s + 1]]
    if kind is SpatialKind.RIM:
        ring = _ring(model, int(first[0]), around_nodes, coarse)
        k = np.arange(len(ring))
        lines = np.column_stack([k, (k + 1) % len(ring)])
        empty = libs.sparse.csr_matrix((0, 0))
        return Facets(ring[:, -1], ring[:, :-1], np.zeros((0, 3), np.int64), lines, False, empty)
    rings = [_ring(model, int(first[k]), around_nodes[k * RIM_POINTS : (k + 1) * RIM_POINTS], coarse) for k in range(2)]
    ends = _carriers(model, first[:2])
    whole = facets_of(CylinderShape(1.0, 1.0), coarse)
    assert whole is not None
    return _placed(np.concatenate([ends[:1], *rings, ends[1:]]), whole.triangles, whole.edges)


def _tube(ends: FloatArray, radius: float, inside: bool, coarse: bool) -> Facets:
    """The wall of a pin, or of a bore, which is seen from within, between the middles of its ends (2, n + 1, 3)."""
    sides = sides_of(coarse)
    angle = 2.0 * np.pi * np.arange(sides) / sides
    along = ends[1, -1] - ends[0, -1]
    circle = np.stack([np.cos(angle), np.sin(angle), np.zeros(sides)], axis=1)
    around = radius * circle @ _axes_about(along / float(np.linalg.norm(along)))
    rings = np.repeat(ends, sides, axis=0)
    rings[:, -1] += np.tile(around, (2, 1))
    k, after = np.arange(sides), (np.arange(sides) + 1) % sides
    wall = np.concatenate([np.column_stack([k, after, sides + after]), np.column_stack([k, sides + after, sides + k])])
    return _placed(rings, wall[:, ::-1] if inside else wall, np.array([[0, sides]]))


def _carriers(model: SpatialModel, points: IntArray) -> FloatArray:
    """(k, n + 1, 3) what each mode moves material points of one body by, and last their places."""
    places = model.points.place[points]
    return np.concatenate([material_shapes(model, points), places[:, None]], axis=1)  # type: ignore[arg-type]


def _ring(model: SpatialModel, centre: int, around: IntArray, coarse: bool) -> FloatArray:
    """(sides, n + 1, 3) of a circle that the material carries rigidly, from its centre and points on it.

    Motion of a rigid circle is linear in the way from its centre: of a quarter turn both ends tell all.
    """
    middle, first, second = _carriers(model, np.array([centre, around[0], around[len(around) // 4]]))
    sides = sides_of(coarse)
    angle = 2.0 * np.pi * np.arange(sides) / sides
    turns = np.stack([np.cos(angle), np.sin(angle)])
    return np.asarray(middle + np.einsum("ak,aij->kij", turns, np.stack([first - middle, second - middle])))


def _placed(carried: FloatArray, triangles: IntArray, lines: IntArray) -> Facets:
    """Facets of vertices that material carries (k, n + 1, 3)."""
    return facets_with_edges(carried[:, -1], triangles, carried[:, :-1], lines)


def _axes_about(direction: FloatArray) -> FloatArray:
    """(3, 3) rows of a right-handed frame whose third is ``direction``."""
    across = np.cross(direction, np.eye(3)[int(np.argmin(np.abs(direction)))])
    first = across / np.linalg.norm(across)
    return np.array([first, np.cross(direction, first), direction])


def clipped(facets: Facets, low: FloatArray, high: FloatArray) -> Facets | None:
    """What of a surface that does not deform is between two corners (3,); itself if all is, None if nothing."""
    if (facets.vertices >= low).all() and (facets.vertices <= high).all():
        return facets
    planes = [
        (axis, sign, limit) for sign, ends in ((1.0, low), (-1.0, high)) for axis, limit in enumerate(sign * ends)
    ]
    corners: list[FloatArray] = []
    for triangle in facets.vertices[facets.triangles]:
        polygon = triangle
        for axis, sign, limit in planes:
            polygon = cut(polygon, sign * polygon[:, axis] - limit)
        corners += [polygon[[0, k, k + 1]] for k in range(1, len(polygon) - 1)]
    lines = []
    for line in facets.vertices[facets.edges]:
        piece = line
        for axis, sign, limit in planes:
            piece = cut(piece, sign * piece[:, axis] - limit, closed=False)
        lines += [piece] if len(piece) == 2 else []
    if not corners and not lines:
        return None
    every = np.concatenate([np.reshape(corners, (-1, 3)), np.reshape(lines, (-1, 3))])
    span = float((high - low).max())
    _, first, number = np.unique(
        np.round((every - low) / (MERGED * span)), axis=0, return_index=True, return_inverse=True
    )
    number = number.ravel()
    triangles, edges = number[: 3 * len(corners)].reshape(-1, 3), number[3 * len(corners) :].reshape(-1, 2)
    whole = (triangles != np.roll(triangles, 1, axis=1)).all(axis=1)
    vertices = every[first]
    rest = facets_with_edges(vertices, triangles[whole], np.zeros((len(vertices), 0, 3)), edges)
    return rest._replace(closed=facets.closed)  # what hid its inside is not in the picture, and what is inside no more


def cut(polygon: FloatArray, height: FloatArray, closed: bool = True) -> FloatArray:
    """The part of a convex polygon (k, 3), or of a line, whose corners have ``height`` (k,) >= 0."""
    found = []
    for k in range(len(polygon)):
        following = (k + 1) % len(polygon)
        if height[k] >= 0.0:
            found.append(polygon[k])
        if (height[k] < 0.0) != (height[following] < 0.0) and (closed or following):
            share = height[k] / (height[k] - height[following])
            found.append(polygon[k] + share * (polygon[following] - polygon[k]))
    return np.array(found).reshape(-1, 3)
