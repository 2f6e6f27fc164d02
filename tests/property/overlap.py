"""Places of bodies and how deep they lie in each other, from outlines in numpy: not by the library's own measures."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.optimize import nnls
from scipy.spatial.transform import Rotation

import lcpflex as lf
from tests.flush.polytopes import polytope, separation

Array = npt.NDArray[np.float64]

__all__ = ["Outline", "deepest", "outlines", "solids", "speeds", "tracks"]


class Outline(NamedTuple):
    """Material points of a body: a closed polygon, corners of a convex solid, or the middle or axis of a round one."""

    offset: int  # of the body's coordinates in q
    rate: int  # in u
    place: Array  # (k, d) undeformed
    shapes: Array  # (k, n, d) of its modes
    radius: float  # added all around; 0: polygon or polytope


def outlines(result: lf.Result) -> list[Outline]:
    """One outline a body of a planar scene, in their order, as it was compiled."""
    assert result.compiled is not None
    model, layout = result.compiled.model, result.compiled.layout
    points = model.points
    found: dict[int, Outline] = {}
    rings: list[tuple[int, Any, float]] = [(body, ids, 0.0) for body, ids, _ in layout.outlines if body >= 0]
    rings += [(int(points.body[p]), np.array([p]), r) for p, r in layout.circles if points.body[p] >= 0]
    for body, ids, radius in rings:
        offset = int(model.bodies.dof[body])
        outline = Outline(offset, offset, points.place[ids], _modes(model, body, ids), radius)
        if body not in found or len(outline.place) > len(found[body].place):  # the whole ring, not one of its sides
            found[body] = outline
    return [found[body] for body in sorted(found)]


def solids(result: lf.Result, cores: Sequence[tuple[Array, float]]) -> list[Outline]:
    """One outline a body of a scene of space, of given corners and radii; of a flexible one of its named points."""
    assert result.compiled is not None
    model, layout = result.compiled.model, result.compiled.layout
    found = []
    for b, (corners, radius) in enumerate(cores):
        offset, rate, end = int(model.bodies.place[b]), int(model.bodies.dof[b]), int(model.bodies.dof[b + 1])
        shapes = np.zeros((len(corners), 0, 3))
        if end - rate > 6:
            ids = np.array([layout.points[layout.bodies[b], name] for name in ("left", "center", "right")])
            corners, shapes = model.points.place[ids], _modes(model, b, ids)
        found.append(Outline(offset, rate, corners, shapes, radius))
    return found


def _modes(model: Any, body: int, ids: Any) -> Array:
    """Mode shapes (k, n, d) of points of a body."""
    points, d = model.points, model.points.place.shape[1]
    modes = int(model.bodies.dof[body + 1] - model.bodies.dof[body]) - (3 if d == 2 else 6)
    phi = [points.phi[points.start[p] : points.start[p + 1]].reshape(modes, d) for p in ids]
    return np.asarray(np.array(phi).reshape(len(ids), modes, d))


def axes_of(outline: Outline, q: Array) -> Array:
    """How the frame is turned (m, d, d), world from body axes."""
    o = outline.offset
    if outline.place.shape[1] == 2:
        cos, sin = np.cos(q[:, o + 2]), np.sin(q[:, o + 2])
        return np.stack([np.stack([cos, -sin], -1), np.stack([sin, cos], -1)], -2)
    return np.asarray(Rotation.from_quat(np.roll(q[:, o + 3 : o + 7], -1, axis=1)).as_matrix())


def _local(outline: Outline, q: Array) -> Array:
    """Deformed places (m, k, d) in the body frame. A round body has some more on its rim, to tell its rotation."""
    n, d = outline.shapes.shape[1:]
    first = outline.offset + (3 if d == 2 else 7)
    s = outline.place + np.einsum("mn,knd->mkd", q[:, first : first + n], outline.shapes)
    if outline.radius:
        s = np.concatenate([s, *(s + outline.radius * axis for axis in np.eye(d)[: d - 1])], axis=1)
    return np.asarray(s)


def tracks(outline: Outline, q: Array) -> Array:
    """World places (m, k, d) of the material points at states q."""
    o, d = outline.offset, outline.place.shape[1]
    return np.asarray(q[:, None, o : o + d] + np.einsum("mij,mkj->mki", axes_of(outline, q), _local(outline, q)))


def speeds(outline: Outline, q: Array, u: Array) -> Array:
    """Their velocities (m, k, d)."""
    o, (n, d) = outline.rate, outline.shapes.shape[1:]
    s, first = _local(outline, q), o + (3 if d == 2 else 6)
    rate = np.einsum("mn,knd->mkd", u[:, first : first + n], outline.shapes)
    if outline.radius:
        rate = np.concatenate([rate] * d, axis=1)
    if d == 2:
        rate = rate + u[:, o + 2][:, None, None] * np.stack([-s[..., 1], s[..., 0]], axis=-1)
    else:
        rate = rate + np.cross(u[:, None, o + 3 : o + 6], s)
    return np.asarray(u[:, None, o : o + d] + np.einsum("mij,mkj->mki", axes_of(outline, q), rate))


def _inside(points: Array, ring: Array) -> Array:
    """How deep points (m, p, 2) lie in closed polygons (m, k, 2), either sense: (m, p), <= 0 outside."""
    a, b = ring[:, None], np.roll(ring, -1, axis=1)[:, None]
    x = points[:, :, None]
    edge, to = b - a, x - a
    share = np.clip((to * edge).sum(-1) / np.maximum((edge * edge).sum(-1), 1e-300), 0.0, 1.0)
    away = np.hypot(*np.moveaxis(to - share[..., None] * edge, -1, 0)).min(-1)
    above = (a[..., 1] > x[..., 1]) != (b[..., 1] > x[..., 1])
    rise = np.where(edge[..., 1] == 0.0, 1.0, edge[..., 1])
    left = x[..., 0] < a[..., 0] + to[..., 1] / rise * edge[..., 0]
    inside = (above & left).sum(-1) % 2 == 1
    return np.asarray(np.where(inside, away, -away))


def _crossing(first: Array, second: Array) -> Array:
    """Least separating shift of two convex polygons (m, k, 2), (m,); <= 0 where an edge separates them."""
    least = np.full(len(first), np.inf)
    for ring in (first, second):
        edges = np.roll(ring, -1, axis=1) - ring
        normals = np.stack([edges[..., 1], -edges[..., 0]], axis=-1)
        normals /= np.maximum(np.hypot(normals[..., 0], normals[..., 1]), 1e-300)[..., None]
        a = np.einsum("mnd,mkd->mnk", normals, first)
        b = np.einsum("mnd,mkd->mnk", normals, second)
        depth = np.minimum(a.max(-1) - b.min(-1), b.max(-1) - a.min(-1))
        least = np.minimum(least, depth.min(-1))
    return least


def _pair(first: Outline, a: Array, second: Outline, b: Array, convex: bool) -> Array:
    """Depth of two bodies in each other (m,), <= 0 apart."""
    if a.shape[-1] == 3:
        return np.array([_in_space(first, x, second, y) for x, y in zip(a, b, strict=True)])
    if first.radius and second.radius:
        gap = a[:, 0] - b[:, 0]
        return np.asarray(first.radius + second.radius - np.hypot(gap[:, 0], gap[:, 1]))
    if first.radius:
        return np.asarray(_inside(a[:, :1], b)[:, 0] + first.radius)
    if second.radius:
        return _pair(second, b, first, a, convex)
    if convex:
        return _crossing(a, b)
    return np.asarray(np.maximum(_inside(a, b).max(-1), _inside(b, a).max(-1)))


def _in_space(first: Outline, a: Array, second: Outline, b: Array) -> float:
    """Depth of two convex bodies at one instant; of flexible ones of the balls at their points."""
    around = first.radius + second.radius
    a, b = a[: len(first.place)], b[: len(second.place)]  # without what is on their rims
    if not around:
        return -separation(polytope(a), polytope(b))
    parts = [[p] for p in a] if first.shapes.shape[1] else [a]
    others = [[p] for p in b] if second.shapes.shape[1] else [b]
    return around - min(_distance(np.array(x), np.array(y)) for x in parts for y in others)


def _distance(a: Array, b: Array) -> float:
    """Of two convex hulls of points, 0 where they overlap: least squares with shares >= 0 that sum up to one."""
    centre, size = a.mean(0), np.ptp(np.concatenate([a, b]), axis=0).max() + 1e-300
    a, b = (a - centre) / size, (b - centre) / size
    sums = 1e4 * np.array([[1.0] * len(a) + [0.0] * len(b), [0.0] * len(a) + [1.0] * len(b)])
    shares, _ = nnls(np.vstack([np.hstack([a.T, -b.T]), sums]), np.array([0.0] * a.shape[1] + [1e4, 1e4]))
    return float(np.linalg.norm(shares[: len(a)] @ a - shares[len(a) :] @ b)) * size


def deepest(
    result: lf.Result,
    walls: Sequence[Any],
    pairs: Sequence[tuple[int, int]],
    rows: npt.NDArray[np.int64],
    shapes: Sequence[Outline] | None = None,
) -> Array:
    """Largest depth of any pair of bodies or of a body in a wall at chosen instants (m,) [m].

    ``walls``: ("plane", point, normal), ("disc", centre, radius) or ("ring", corners of a convex solid).
    ``shapes``: of the bodies; as a planar scene was compiled if omitted.
    """
    q = result.q[rows]
    shapes = outlines(result) if shapes is None else shapes
    places = [tracks(shape, q) for shape in shapes]
    rigid = [shape.shapes.shape[1] == 0 for shape in shapes]
    worst = np.full(len(q), -np.inf)
    for shape, place, stiff in zip(shapes, places, rigid, strict=True):
        for kind, *numbers in walls:
            if kind == "plane":
                point, normal = (np.asarray(x) for x in numbers)
                depth = shape.radius - ((place[:, : len(shape.place)] - point) @ normal).min(-1)
            else:
                at = np.asarray([numbers[0]] if kind == "disc" else numbers[0], dtype=float)
                none = np.zeros((len(at), 0, at.shape[1]))
                other = Outline(0, 0, at, none, numbers[1] if kind == "disc" else 0.0)
                depth = _pair(shape, place, other, np.broadcast_to(at, (len(q), *at.shape)), stiff)
            worst = np.maximum(worst, depth)
    for i, j in pairs:
        worst = np.maximum(worst, _pair(shapes[i], places[i], shapes[j], places[j], rigid[i] and rigid[j]))
    return worst
