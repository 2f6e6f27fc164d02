"""The surface of a mesh in space: its boundary facets, and named parts of it.

Facets are those of the elements that only one of them has, their nodes in the order of :attr:`Kind.facets`, counter-
clockwise seen from outside.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from lcpflex.basics import libs
from lcpflex.bodies.fem.facets import outer_facets
from lcpflex.bodies.fem.mesh import FLAT, Mesh, told_place
from lcpflex.bodies.fem.user_sets import user_sets
from lcpflex.errors import ModelError, ModelWarning
from lcpflex.jit.kernel import FloatArray, IntArray

__all__ = ["HAT_PARTS", "SURFACE", "Faces", "areas_of", "even_parts", "faces_of", "flat_facets", "split_facets"]

SURFACE = "surface"  # the name of all of it
OPPOSITE = -0.999  # cosine of the normals of faces that lie on each other
IN_PLANE = 1e-6  # of the size of a face: the distance of another one that lies on it


@dataclass(frozen=True, slots=True, eq=False)
class Faces:
    """The surface of a mesh and its names.

    Attributes
    ----------
    facets : (F, k) nodes of all facets
    named : rows of the facets of each named part
    sets : named nodes
    points : named single nodes
    """

    facets: IntArray
    named: dict[str, IntArray] = field(default_factory=dict)
    sets: dict[str, IntArray] = field(default_factory=dict)
    points: dict[str, int] = field(default_factory=dict)


def faces_of(mesh: Mesh, sets: Mapping[str, Any]) -> Faces:
    """The surface of a mesh with every name: "surface", the groups that the mesh came with, and the user's sets.

    Nodes that are those of some facets are a face, too; one node is a point and a set; other nodes (inside, on a line)
    are a set alone.

    Raises
    ------
    ModelError
        As :func:`outer_facets` and :func:`user_sets`; and for a face of the mesh that is not on its surface.

    Warns
    -----
    ModelWarning
        Where nodes of the surface coincide and are not merged; and for a group "surface" that is not the whole of it.
    """
    facets = outer_facets(mesh)
    _tell_unmerged(mesh, facets)
    found = Faces(facets, {SURFACE: np.arange(len(facets))}, {SURFACE: np.unique(facets)})
    _tell_other_surface(mesh, found)
    named = dict(sets) if isinstance(sets, Mapping) else {}
    asked = {value for value in named.values() if isinstance(value, str)}
    rows = {
        name: _rows_of(mesh, facets, name, corners)
        for name, corners in mesh.faces.items()
        if name != SURFACE and (name in asked or name not in named)
    }
    nodes_of = {name: np.unique(facets[own]) for name, own in rows.items()}
    given = user_sets(replace(mesh, groups={**nodes_of, **mesh.groups}), sets, {SURFACE})
    for name in [name for name in rows if name not in given]:
        found.named[name], found.sets[name] = rows[name], nodes_of[name]
    for name, nodes in {**mesh.groups, **given}.items():
        if name == SURFACE or name in found.sets:
            continue
        found.sets[name] = np.asarray(nodes)
        if len(nodes) == 1:
            found.points[name] = int(nodes[0])
            continue
        inside = np.flatnonzero(np.isin(facets, nodes).all(axis=1))
        if len(inside) and len(np.unique(facets[inside])) == len(nodes):
            found.named[name] = inside
    return found


def _rows_of(mesh: Mesh, facets: IntArray, name: str, corners: IntArray) -> IntArray:
    """Which facets have the corners (k, 3 or 4)."""
    wide = mesh.kind.facet_corners
    if corners.ndim != 2 or corners.shape[1] != wide:
        words = {3: "triangles", 4: "quadrilaterals"}
        raise ModelError(
            f"{mesh.source}: the facets of {name!r} are {words.get(corners.shape[-1], 'of another kind')}, expected "
            f"{words[wide]}, as elements {mesh.kind.name} have"
        )
    every = np.sort(np.concatenate([facets[:, :wide], corners]), axis=1)
    _, number = np.unique(every, axis=0, return_inverse=True)
    own, wanted = np.split(number.ravel(), [len(facets)])
    rows = np.full(int(number.max()) + 1, -1)
    rows[own] = np.arange(len(facets))
    inside = np.flatnonzero(rows[wanted] < 0)
    if len(inside):
        place = mesh.places[corners[inside[0]]].mean(axis=0)
        raise ModelError(
            f"{mesh.source}: {len(inside)} facet(s) of {name!r} are no faces of the surface (the first at "
            f"{told_place(place)}), expected faces that one element has"
        )
    return np.unique(rows[wanted])


def _tell_other_surface(mesh: Mesh, found: Faces) -> None:
    """Warn of a group of the mesh whose name the whole surface takes."""
    nodes = mesh.faces.get(SURFACE, mesh.groups.get(SURFACE))
    corners = found.facets[:, : mesh.kind.facet_corners] if SURFACE in mesh.faces else found.sets[SURFACE]
    if nodes is not None and not np.array_equal(np.unique(nodes), np.unique(corners)):
        warnings.warn(
            f"{mesh.source}: its group {SURFACE!r} is left out, for the whole surface has that name: expected another",
            ModelWarning,
            stacklevel=_LEVEL,
        )


def _tell_unmerged(mesh: Mesh, facets: IntArray) -> None:
    """Warn of nodes of the surface at one place, and of faces that lie on each other: the body is cut there."""
    nodes = np.unique(facets)
    pairs = libs.cKDTree(mesh.places[nodes]).query_pairs(FLAT * mesh.size, output_type="ndarray")
    if len(pairs):
        a, b = nodes[pairs[0]]
        found, place = f"{len(pairs)} pair(s) of nodes of its surface coincide ({a} and {b})", mesh.places[a]
    else:
        on = _on_each_other(mesh, facets)
        if not len(on):
            return
        found, place = f"{len(on)} of its faces lie on others, with other nodes", on[0]
    warnings.warn(
        f"{mesh.source}: {found} at {told_place(place)}: the body is cut there. Merge nodes that coincide and let none "
        "hang on a face, unless it is a crack",
        ModelWarning,
        stacklevel=_LEVEL,
    )


def _on_each_other(mesh: Mesh, facets: IntArray) -> FloatArray:
    """(k, 3) middles of facets that lie in the plane of a larger one or of their like, which looks the other way."""
    corners = mesh.places[facets[:, : mesh.kind.facet_corners]]
    middle = corners.mean(axis=1)
    normal = np.cross(corners[:, 1] - corners[:, -1], corners[:, 2] - corners[:, 0])
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    reach = np.linalg.norm(corners - middle[:, None], axis=2).max(axis=1)
    near = libs.cKDTree(middle).query_ball_point(middle, reach * (1.0 - 1e-9))
    large = np.repeat(np.arange(len(facets)), [len(one) for one in near])
    small = np.concatenate([np.asarray(one, dtype=np.int64) for one in near])
    arm = middle[small] - middle[large]
    height = np.abs((arm * normal[large]).sum(axis=1))
    turned = (normal[small] * normal[large]).sum(axis=1)
    on = (turned < OPPOSITE) & (height < IN_PLANE * reach[large]) & (reach[small] <= reach[large] * (1.0 + 1e-9))
    return np.asarray(middle[np.unique(small[on])])


_LEVEL = 6  # of the caller of the body


def split_facets(facets: IntArray) -> IntArray:
    """(S, 3) linear triangles or (S, 4) quadrilaterals on the nodes of facets: four of each quadratic one.

    Facets of eight nodes have no middle, and are split into six triangles.
    """
    return _split(facets, _PARTS[facets.shape[1]])


def even_parts(facets: IntArray) -> IntArray:
    """(S, 3 or 4) parts among which areas are shared: those of :func:`split_facets`, however the nodes are numbered.

    Those of facets of eight nodes are cut along both diagonals of what is between their middles, and so cover it twice.
    """
    return _split(facets, _EIGHT_EVENLY if facets.shape[1] == 8 else _PARTS[facets.shape[1]])


def _split(facets: IntArray, parts: IntArray) -> IntArray:
    return np.asarray(facets[:, parts].reshape(-1, parts.shape[1]))


def flat_facets(facets: IntArray) -> IntArray:
    """(T, 3) plane triangles on the nodes of facets, counter-clockwise seen from outside: for pictures."""
    split = split_facets(facets)
    if split.shape[1] == 3:
        return split
    return np.asarray(split[:, [[0, 1, 2], [0, 2, 3]]].reshape(-1, 3))


_PARTS = {  # by the number of nodes of a facet
    3: np.array([[0, 1, 2]]),
    4: np.array([[0, 1, 2, 3]]),
    6: np.array([[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]]),
    8: np.array([[0, 4, 7], [4, 1, 5], [5, 2, 6], [6, 3, 7], [4, 5, 6], [4, 6, 7]]),
    9: np.array([[0, 4, 8, 7], [4, 1, 5, 8], [8, 5, 2, 6], [7, 8, 6, 3]]),
}
# those on which hats stand, one about each corner: a facet of eight nodes, whose parts have no positive shares, is one
HAT_PARTS = {**_PARTS, 8: np.array([[0, 1, 2, 3]])}
_EIGHT_EVENLY = np.concatenate([_PARTS[8], _PARTS[8][:4], [[5, 6, 7], [5, 7, 4]]])


def areas_of(places: FloatArray, parts: IntArray) -> FloatArray:
    """(S,) areas of triangles, or of quadrilaterals as two of them [m^2]."""
    corners = places[parts]
    first = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = 0.5 * np.linalg.norm(first, axis=1)
    if parts.shape[1] == 4:
        second = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 0])
        area += 0.5 * np.linalg.norm(second, axis=1)
    return np.asarray(area)
