"""How far convex bodies are apart, or how deep in each other, by brute force over all faces and all pairs of edges.

Shares no code with the package: numpy, and the hull of scipy.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

__all__ = ["Polytope", "between", "distance", "polytope", "separation", "shadows_overlap"]

Array = npt.NDArray[np.float64]


class Polytope(NamedTuple):
    """The convex hull of points: n.x <= offset of each face, and the edges between faces that are not in one plane."""

    vertices: Array  # (n, 3)
    normals: Array  # (f, 3)
    offsets: Array  # (f,)
    edges: Any  # (e, 2) of which vertices

    def moved(self, turn: Rotation, shift: Any) -> Polytope:
        normals = turn.apply(self.normals)
        return Polytope(turn.apply(self.vertices) + shift, normals, self.offsets + normals @ shift, self.edges)


def polytope(points: npt.ArrayLike) -> Polytope:
    """Of the points that are corners."""
    hull = ConvexHull(np.asarray(points, dtype=float))
    equations: list[Array] = []
    face: list[int] = []  # of each triangle
    for equation in hull.equations:
        same = [k for k, other in enumerate(equations) if np.abs(other - equation).max() < 1e-9]
        face.append(same[0] if same else len(equations))
        if not same:
            equations.append(equation)
    number = {int(old): new for new, old in enumerate(hull.vertices)}
    sides: dict[tuple[int, ...], set[int]] = {}
    for k, triangle in enumerate(hull.simplices):
        for side in pairwise([*triangle, triangle[0]]):
            sides.setdefault(tuple(sorted(number[int(v)] for v in side)), set()).add(face[k])
    edges = np.array([side for side, faces in sides.items() if len(faces) == 2])
    planes = np.array(equations)
    return Polytope(hull.points[hull.vertices], planes[:, :3], -planes[:, 3], edges)


def separation(a: Polytope, b: Polytope) -> float:
    """The largest over all axes: how far apart along one, where it is positive; less what moves b out of a."""
    e, f = (p.vertices[p.edges[:, 1]] - p.vertices[p.edges[:, 0]] for p in (a, b))
    crossed = np.cross(e[:, None], f[None]).reshape(-1, 3)
    length = np.linalg.norm(crossed, axis=1)
    crossed = crossed[length > 0.0] / length[length > 0.0, None]  # a unit vector of rounding is an axis like any other
    axes = np.concatenate([a.normals, -b.normals, crossed, -crossed])
    return float(((b.vertices @ axes.T).min(axis=0) - (a.vertices @ axes.T).max(axis=0)).max())


def distance(a: Polytope, b: Polytope) -> float:
    """Of disjoint ones: between edges, or from a vertex to its foot in a face."""
    found = [_between_edges(a, b)]
    for one, two in ((a, b), (b, a)):
        height = two.vertices @ one.normals.T - one.offsets  # (n, f)
        feet = two.vertices[:, None] - height[..., None] * one.normals
        inside = ((feet @ one.normals.T - one.offsets) <= 1e-12).all(axis=-1)
        found.append(float(height[inside & (height >= 0.0)].min(initial=np.inf)))
    return min(found)


def _between_edges(a: Polytope, b: Polytope) -> float:
    """The least distance of a segment of a and one of b: inside of both, or at an end of one."""
    p, q = (s.vertices[s.edges[:, 0]] for s in (a, b))
    e, f = (s.vertices[s.edges[:, 1]] - start for s, start in ((a, p), (b, q)))
    n = np.cross(e[:, None], f[None])
    nn, y = (n * n).sum(-1), q[None] - p[:, None]
    safe = np.where(nn > 0.0, nn, 1.0)
    s, t = ((np.cross(y, d) * n).sum(-1) / safe for d in (f[None], e[:, None]))
    inside = (nn > 0.0) & (s >= 0.0) & (s <= 1.0) & (t >= 0.0) & (t <= 1.0)
    least = float((np.abs((y * n).sum(-1)) / np.sqrt(safe))[inside].min(initial=np.inf))
    for starts, ways, others in ((p, e, b.vertices), (q, f, a.vertices)):
        y = others[:, None] - starts
        share = np.clip((y * ways).sum(-1) / (ways * ways).sum(-1), 0.0, 1.0)
        least = min(least, float(np.linalg.norm(y - share[..., None] * ways, axis=-1).min()))
    return least


def between(a: Polytope, b: Polytope) -> tuple[float, float]:
    """Bounds of the least gap: the depth of what overlaps; else what the best axis tells, and the distance."""
    apart = separation(a, b)
    return (apart, max(apart, distance(a, b))) if apart > 0.0 else (apart, apart)


def shadows_overlap(a: Polytope, b: Polytope) -> float:
    """By how far the shadows on a horizontal plane overlap; negative: how far they are apart along an axis."""
    ways = [(p.vertices[p.edges[:, 1]] - p.vertices[p.edges[:, 0]])[:, :2] for p in (a, b)]
    axes = np.concatenate([np.stack([-w[:, 1], w[:, 0]], axis=-1) for w in ways])
    length = np.linalg.norm(axes, axis=1)
    axes = axes[length > 0.0] / length[length > 0.0, None]
    axes = np.concatenate([axes, -axes])
    return -float(((b.vertices[:, :2] @ axes.T).min(axis=0) - (a.vertices[:, :2] @ axes.T).max(axis=0)).max())
