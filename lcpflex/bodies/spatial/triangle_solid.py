"""Solids between triangles: vertices merged, shells and cavities told apart, mass properties."""

from __future__ import annotations

import math
import warnings
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from lcpflex.basics import libs
from lcpflex.bodies.spatial.closed_surface import FLAT, SIDES, check_closed, check_turned, is_closed, passed_edges
from lcpflex.bodies.spatial.hull import Hull, convex_hull, moments_of
from lcpflex.errors import ModelError, ModelWarning, in_range
from lcpflex.jit.kernel import FloatArray, IntArray

__all__ = ["TriangleSolid", "triangle_solid", "triangle_surface"]

EXTENTS = (1e-12, 1e9)  # [m] of solids: whatever the unit was, beyond it numbers are broken
MERGED = 1e-6  # of the extent, to which files of single precision write places
NEIGHBOURS = 50  # of a vertex, on the mean, that are merged: as many triangles may meet at one
SHELLS = 1000  # so many are sorted out within a minute, whatever their triangles
WINDINGS = 4 * 10**6  # triangles that are looked at from places of shells: half a second
AMID, CORNERS = np.full((1, 3), 1.0 / 3.0), 0.05 + 0.85 * np.eye(3)  # places of a triangle, by its corners
PAIRS, ROWS = 10**8, 1000  # of vertices and triangles: more are not compared, and not more vertices at once

BoolArray: TypeAlias = np.ndarray[Any, np.dtype[np.bool_]]


class TriangleSolid(NamedTuple):
    """A solid between triangles, its frame at its centre of volume."""

    vertices: FloatArray  # (N, 3) from the centre
    triangles: IntArray  # (T, 3) of the vertices, counter-clockwise seen from outside
    centre: FloatArray  # (3,) in the frame of the triangles
    volume: float
    area: float
    second: FloatArray  # (3, 3) integral of x x^T dV about the centre
    extent: float
    convex: bool  # vertices and triangles are then those of its hull


def triangle_solid(source: str, corners: FloatArray) -> TriangleSolid:
    """The solid between triangles with corners (T, 3, 3) that are finite, in one shell or several.

    Vertices that are equal are merged; if the surface is open then, those that are within 1e-6 of its extent, if that
    closes it, which is told. Triangles on fewer than three vertices are left out, which is told. Shells inside of
    others that are seen from inside are cavities.

    Raises
    ------
    ModelError
        For a surface that is open, with the hole; edges of more than two triangles; triangles that are turned around
        or have no area; shells that are turned around, lie in each other or enclose nothing.
    """
    with np.errstate(over="ignore"):
        extent = float(np.ptp(corners.reshape(-1, 3), axis=0).max())
    in_range(f"{source}: extent [m]", extent, *EXTENTS)
    vertices, triangles = _merged(source, corners, extent)
    check_closed(source, vertices, triangles)
    middle = vertices.mean(axis=0)
    scaled = (vertices - middle) / extent
    a, b, c = np.moveaxis(scaled[triangles], 1, 0)
    parts = np.einsum("ti,ti->t", a, np.cross(b, c)) / 6.0
    shells = _shells(triangles)
    if shells.max() > 0:
        _check_shells(source, vertices[triangles], shells)
    volume = float(parts.sum())
    if not volume > FLAT:
        raise ModelError(
            f"{source}: it encloses {volume:.3g} of the volume of a cube of its size, expected a solid with a volume"
        )
    centre, second = moments_of(a, b, c, parts)
    hull = None if shells.max() > 0 else _hull_if_convex(scaled, triangles)
    if hull is not None:
        scaled, triangles = scaled[hull.corners], hull.triangles
    return TriangleSolid(
        vertices=extent * (scaled - centre),
        triangles=triangles,
        centre=middle + extent * centre,
        volume=volume * extent**3,
        area=0.5 * float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()) * extent**2,
        second=second * extent**5,
        extent=extent,
        convex=hull is not None,
    )


def triangle_surface(source: str, corners: FloatArray, may_be_open: bool) -> tuple[FloatArray, IntArray, bool]:
    """Vertices (N, 3), triangles (T, 3), and whether they are a convex solid, of triangles with corners (T, 3, 3).

    Vertices are merged, and surfaces refused, as by :func:`triangle_solid`; open ones where they may not be.
    """
    with np.errstate(over="ignore"):
        extent = float(np.ptp(corners.reshape(-1, 3), axis=0).max())
    in_range(f"{source}: extent [m]", extent, *EXTENTS)
    vertices, triangles = _merged(source, corners, extent)
    check_turned(source, vertices, triangles)
    if not is_closed(triangles):
        if may_be_open:
            return vertices, triangles, False
        try:
            check_closed(source, vertices, triangles)
        except ModelError as error:
            raise ModelError(f"{error}; is_open=True takes one with a border") from None
    check_closed(source, vertices, triangles)
    shells = _shells(triangles)
    if shells.max() > 0:
        _check_shells(source, vertices[triangles], shells)
        return vertices, triangles, False
    hull = _hull_if_convex((vertices - vertices.mean(axis=0)) / extent, triangles)
    return (vertices, triangles, False) if hull is None else (vertices[hull.corners], hull.triangles, True)


def _merged(source: str, corners: FloatArray, extent: float) -> tuple[FloatArray, IntArray]:
    """Vertices (N, 3) in the order in which they come, and triangles (T, 3) on them."""
    places = corners.reshape(-1, 3) + 0.0  # -0.0 and 0.0 are one place
    number = _numbers(places)
    if not _is_whole(number):
        near = _joined(places, number, MERGED * extent)
        if _is_whole(near):
            warnings.warn(
                f"{source}: it is closed with vertices merged that are up to {MERGED * extent:.3g} m apart, "
                f"{MERGED:g} of its extent",
                ModelWarning,
                stacklevel=4,
            )
            number = near
    triangles = number.reshape(-1, 3)
    kept = _spanned(triangles)
    if not kept.any():
        raise ModelError(f"{source}: none of its triangles has three corners, expected a closed surface")
    if not kept.all():
        warnings.warn(
            f"{source}: {(~kept).sum()} triangles with two corners at one place left out, of which the first is "
            f"triangle {kept.argmin()}",
            ModelWarning,
            stacklevel=4,
        )
    used, first, again = np.unique(triangles[kept], return_index=True, return_inverse=True)
    order = np.argsort(first)
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    _, start = np.unique(number, return_index=True)
    return places[start][used[order]], rank[again].reshape(-1, 3)


def _numbers(places: FloatArray) -> IntArray:
    """(k,) the number of each place (k, 3): the same of equal ones."""
    order = np.lexsort(places.T)
    new = np.concatenate([[False], (np.diff(places[order], axis=0) != 0.0).any(axis=1)])
    number = np.empty(len(places), dtype=np.int64)
    number[order] = np.cumsum(new)
    return number


def _joined(places: FloatArray, number: IntArray, distance: float) -> IntArray:
    """Numbers (k,) in which places are the same that are within a distance, if need be over others.

    Where crowds are that close, nothing is merged: a whole part would become a point.
    """
    _, first = np.unique(number, return_index=True)
    tree = libs.cKDTree(places[first])
    if tree.count_neighbors(tree, distance) > NEIGHBOURS * len(first):
        return number
    pairs = tree.query_pairs(distance, output_type="ndarray")
    graph = libs.sparse.coo_matrix((np.ones(len(pairs)), tuple(pairs.T)), shape=(len(first), len(first)))
    _, group = libs.csgraph.connected_components(graph, directed=False)
    return np.asarray(group[number], dtype=np.int64)


def _spanned(triangles: IntArray) -> BoolArray:
    """(T,) whether the corners are three."""
    return np.asarray((triangles != np.roll(triangles, 1, axis=1)).all(axis=1))


def _is_whole(number: IntArray) -> bool:
    triangles = number.reshape(-1, 3)
    kept = triangles[_spanned(triangles)]
    return len(kept) > 0 and is_closed(kept)


def _shells(triangles: IntArray) -> IntArray:
    """(T,) which of the pieces that hang together at edges each triangle belongs to."""
    twin = _twins(triangles)
    count = len(triangles)
    links = (np.ones(len(twin)), (np.arange(len(twin)) % count, twin % count))
    graph = libs.sparse.coo_matrix(links, shape=(count, count))
    return np.asarray(libs.csgraph.connected_components(graph, directed=False)[1], dtype=np.int64)


def _twins(triangles: IntArray) -> IntArray:
    """(3 T,) the edge that passes each edge the other way: edge k is side k // T of triangle k % T."""
    _, there, back = passed_edges(triangles)
    order = np.argsort(there)
    return np.asarray(order[np.searchsorted(there[order], back)])


def _check_shells(source: str, corners: FloatArray, shells: IntArray) -> None:
    """Solids must be outside of all others, cavities inside of one, by winding numbers about places within them."""
    count = int(shells.max()) + 1
    if count > SHELLS:
        raise ModelError(f"{source}: its triangles make {count} separate shells, expected at most {SHELLS}")
    order = np.argsort(shells, kind="stable")
    pieces = np.split(corners[order], np.cumsum(np.bincount(shells))[:-1])
    low, high = (np.array([end(piece, axis=(0, 1)) for piece in pieces]) for end in (np.min, np.max))
    slack = MERGED * float((high.max(axis=0) - low.min(axis=0)).max())
    most = max(1, WINDINGS // (count * len(corners)))
    for k, piece in enumerate(pieces):
        size = float((high[k] - low[k]).max())
        volume = float(np.linalg.det(piece - piece[0].mean(axis=0)).sum()) / 6.0
        places = _places_within(piece, math.copysign(min(slack, 1e-3 * size), volume))
        near = [o for o in range(count) if o != k and (low[o] < high[k]).all() and (low[k] < high[o]).all()]
        boxed = np.zeros(len(places), dtype=np.bool_)
        for o in near:
            boxed |= ((low[o] <= places) & (places <= high[o])).all(axis=1)
        chosen = np.concatenate([places[~boxed][:1], places[boxed]])  # the others of those are outside, too
        chosen = chosen[:: -(-len(chosen) // most)]
        inside = np.array([sum(_winding(pieces[o], place) for o in near) > 0.5 for place in chosen])
        what = ""
        if abs(volume) <= FLAT * size**3:
            what = "encloses nothing, expected a solid or a cavity"
        elif inside.any() and not inside.all():
            what = "crosses another one, expected solids apart, whose volumes add, or one shell around both"
        elif volume > 0.0 and inside.all():
            what = "lies within another one, expected it outside, or seen from inside if it is a cavity"
        elif volume < 0.0 and not inside.any():
            what = "is turned inside out, expected triangles that are counter-clockwise seen from outside"
        if what:
            x, y, z = piece[0].mean(axis=0)
            raise ModelError(f"{source}: a shell of {len(piece)} triangles at ({x:.4g}, {y:.4g}, {z:.4g}) {what}")


def _places_within(corners: FloatArray, depth: float) -> FloatArray:
    """(4 T, 3) places amid triangles (T, 3, 3) and near their corners, moved against their normals by a depth."""
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    on = np.einsum("pv,tvi->tpi", np.vstack([AMID, CORNERS]), corners)
    return np.asarray((on - depth * normal[:, None]).reshape(-1, 3))


def _winding(corners: FloatArray, place: FloatArray) -> float:
    """How often triangles (T, 3, 3) go around a place: 1 inside, 0 outside (van Oosterom and Strackee 1983)."""
    a, b, c = np.moveaxis(corners - place, 1, 0)
    r, s, t = (np.linalg.norm(arm, axis=1) for arm in (a, b, c))
    above = np.einsum("ti,ti->t", a, np.cross(b, c))
    dots = [np.einsum("ti,ti->t", *pair) for pair in ((a, b), (b, c), (c, a))]
    return float(np.arctan2(above, r * s * t + dots[0] * t + dots[1] * r + dots[2] * s).sum()) / (2.0 * math.pi)


def _corners(vertices: FloatArray, triangles: IntArray, normals: FloatArray) -> IntArray:
    """Vertices that are not within faces or straight edges: hulls of those have slivers, by rounding.

    About a corner, normals (T, 3) span three directions. Where the last is so weak that, over the longest edge there,
    it comes to a tenth of MERGED, the corner is none.
    """
    spread, size = np.zeros((len(vertices), 3, 3)), np.zeros(len(vertices))
    for k in range(3):
        np.add.at(spread, triangles[:, k], normals[:, :, None] * normals[:, None])
        for other in (k - 1, k - 2):
            arms = np.linalg.norm(vertices[triangles[:, k]] - vertices[triangles[:, other]], axis=1)
            np.maximum.at(size, triangles[:, k], arms)
    least = np.sqrt(np.maximum(np.linalg.eigvalsh(spread)[:, 0], 0.0))
    return np.flatnonzero(least * size > 0.1 * MERGED)


def _hull_if_convex(vertices: FloatArray, triangles: IntArray) -> Hull | None:
    """The hull of one shell whose extent is 1, if that is the shell to single precision."""
    corners, T = vertices[triangles], len(triangles)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    opposite = np.concatenate([triangles[:, (first + 2) % 3] for first, _ in SIDES])[_twins(triangles)]
    above = np.einsum("ti,ti->t", np.tile(normals, (3, 1)), vertices[opposite] - np.tile(corners[:, 0], (3, 1)))
    if above.max() > MERGED or len(vertices) * T > PAIRS:
        return None
    sharp = _corners(vertices, triangles, normals)
    if len(sharp) < 4:
        return None
    hull = convex_hull(vertices[sharp])
    hull = hull._replace(corners=sharp[hull.corners])
    faces = vertices[hull.corners][hull.triangles]
    normals = np.cross(faces[:, 1] - faces[:, 0], faces[:, 2] - faces[:, 0])
    sizes = np.linalg.norm(normals, axis=1, keepdims=True)
    if not sizes.min() > FLAT:
        return None
    normals /= sizes
    offsets = np.einsum("ti,ti->t", normals, faces[:, 0])
    for start in range(0, len(vertices), ROWS):
        deep = (vertices[start : start + ROWS] @ normals.T - offsets).max(axis=1)
        if deep.min() < -MERGED:
            return None
    return hull
