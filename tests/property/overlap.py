"""Places of bodies and how deep they lie in each other, from outlines in numpy: not by the library's own measures."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

import lcpflex as lf

Array = npt.NDArray[np.float64]

__all__ = ["Outline", "deepest", "outlines", "speeds", "tracks"]


class Outline(NamedTuple):
    """A closed polygon of material points of a body, or a disc about one."""

    offset: int  # of the body's coordinates in q
    place: Array  # (k, 2) undeformed
    shapes: Array  # (k, n, 2) of its modes
    radius: float  # of a disc; 0: polygon


def outlines(result: lf.Result) -> list[Outline]:
    """One outline a body, in their order."""
    assert result.compiled is not None
    model, layout = result.compiled.model, result.compiled.layout
    points = model.points
    found: dict[int, Outline] = {}
    rings: list[tuple[int, Any, float]] = [(body, ids, 0.0) for body, ids, _ in layout.outlines if body >= 0]
    rings += [(int(points.body[p]), np.array([p]), r) for p, r in layout.circles if points.body[p] >= 0]
    for body, ids, radius in rings:
        modes = int(model.bodies.dof[body + 1] - model.bodies.dof[body]) - 3
        phi = np.array([points.phi[points.start[p] : points.start[p + 1]].reshape(modes, 2) for p in ids])
        outline = Outline(int(model.bodies.dof[body]), points.place[ids], phi.reshape(len(ids), modes, 2), radius)
        if body not in found or len(outline.place) > len(found[body].place):  # the whole ring, not one of its sides
            found[body] = outline
    return [found[body] for body in sorted(found)]


def _turned(angle: Array, s: Array) -> Array:
    cos, sin = np.cos(angle)[:, None], np.sin(angle)[:, None]
    return np.stack([cos * s[..., 0] - sin * s[..., 1], sin * s[..., 0] + cos * s[..., 1]], axis=-1)


def _local(outline: Outline, q: Array) -> Array:
    """Deformed places (m, k, 2) in the body frame. A disc has a second one on its rim, to tell its rotation."""
    d, n = outline.offset, outline.shapes.shape[1]
    s = outline.place + np.einsum("mn,knd->mkd", q[:, d + 3 : d + 3 + n], outline.shapes)
    if outline.radius:
        s = np.concatenate([s, s + np.array([outline.radius, 0.0])], axis=1)
    return np.asarray(s)


def tracks(outline: Outline, q: Array) -> Array:
    """World places (m, k, 2) of the material points at states q (m, ndof)."""
    d = outline.offset
    return np.asarray(q[:, None, d : d + 2] + _turned(q[:, d + 2], _local(outline, q)))


def speeds(outline: Outline, q: Array, u: Array) -> Array:
    """Their velocities (m, k, 2)."""
    d, n = outline.offset, outline.shapes.shape[1]
    s = _local(outline, q)
    rate = np.einsum("mn,knd->mkd", u[:, d + 3 : d + 3 + n], outline.shapes)
    if outline.radius:
        rate = np.concatenate([rate, rate], axis=1)
    spin = u[:, d + 2][:, None]
    rate = rate + np.stack([-spin * s[..., 1], spin * s[..., 0]], axis=-1)
    return np.asarray(u[:, None, d : d + 2] + _turned(q[:, d + 2], rate))


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


def deepest(
    result: lf.Result, walls: Sequence[Any], pairs: Sequence[tuple[int, int]], rows: npt.NDArray[np.int64]
) -> Array:
    """Largest depth of any pair of bodies or of a body in a wall at chosen instants (m,) [m].

    ``walls``: ("plane", point, normal), ("disc", centre, radius) or ("ring", corners of a convex polygon).
    """
    q = result.q[rows]
    shapes = outlines(result)
    places = [tracks(shape, q) for shape in shapes]
    rigid = [shape.shapes.shape[1] == 0 for shape in shapes]
    worst = np.full(len(q), -np.inf)
    for shape, place, stiff in zip(shapes, places, rigid, strict=True):
        for kind, *numbers in walls:
            if kind == "plane":
                point, normal = (np.asarray(x) for x in numbers)
                gap = (place - point) @ normal
                depth = shape.radius - gap[:, 0] if shape.radius else -gap.min(-1)
            else:
                other = Outline(0, np.zeros((1, 2)), np.zeros((1, 0, 2)), numbers[1] if kind == "disc" else 0.0)
                at = np.asarray([numbers[0]] if kind == "disc" else numbers[0], dtype=float)
                depth = _pair(shape, place, other, np.broadcast_to(at, (len(q), *at.shape)), stiff)
            worst = np.maximum(worst, depth)
    for i, j in pairs:
        worst = np.maximum(worst, _pair(shapes[i], places[i], shapes[j], places[j], rigid[i] and rigid[j]))
    return worst
