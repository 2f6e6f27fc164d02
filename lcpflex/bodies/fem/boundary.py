"""Surfaces of a mesh: its boundary as ordered loops, and named nodes as points, sets and chains of it.

A boundary edge belongs to one element, which lies on its left. So the outer loop runs counter-clockwise, loops around
holes clockwise, and outward normals point to the right.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, TypeAlias

import numpy as np

from lcpflex.bodies.fem.facets import outer_facets, refuse
from lcpflex.bodies.fem.mesh import FLAT, Mesh
from lcpflex.bodies.fem.user_sets import user_sets
from lcpflex.errors import ModelWarning
from lcpflex.jit.kernel import FloatArray, IntArray

__all__ = ["Boundary", "Names", "boundary_of", "names_of"]

Chains: TypeAlias = dict[str, tuple[IntArray, bool]]


@dataclass(frozen=True, slots=True, eq=False)
class Boundary:
    """The boundary of a mesh.

    Attributes
    ----------
    loops : nodes of each loop in its order, nodes amid edges included; the outer one first
    stride : nodes an edge goes on by: 1, or 2 with a node amid it
    """

    loops: tuple[IntArray, ...]
    stride: int

    def pieces(self, places: FloatArray) -> FloatArray:
        """(k, 2, 2) both ends of the straight pieces from node to node."""
        starts = np.concatenate([places[loop] for loop in self.loops])
        ends = np.concatenate([np.roll(places[loop], -1, axis=0) for loop in self.loops])
        return np.stack([starts, ends], axis=1)


@dataclass(frozen=True, slots=True, eq=False)
class Names:
    """Named points, sets and surfaces, as :class:`FiniteElements` takes them."""

    points: dict[str, int] = field(default_factory=dict)
    sets: dict[str, IntArray] = field(default_factory=dict)
    chains: Chains = field(default_factory=dict)


def boundary_of(mesh: Mesh) -> Boundary:
    """The loops of boundary edges: the outer one, then holes in the order of their middles (x, then y).

    Each starts at its leftmost node (the lowest of them).

    Raises
    ------
    ModelError
        Where elements overlap (an edge of more than two) or touch at a corner only.
    """
    edges = outer_facets(mesh)
    loops = _linked(mesh, edges)
    areas = [_area(mesh.places[loop]) for loop in loops]
    _check_loops(mesh, loops, areas)
    outer = int(np.argmax(areas))
    holes = [loop for k, loop in enumerate(loops) if k != outer]
    holes.sort(key=lambda loop: tuple(mesh.places[loop].mean(axis=0)))
    return Boundary((loops[outer], *holes), 2 if mesh.kind.quadratic else 1)


def _check_loops(mesh: Mesh, loops: list[IntArray], areas: list[float]) -> None:
    """One loop around the mesh; slits are told, nodes that hang on edges refused."""
    around = [k for k, area in enumerate(areas) if area > FLAT * mesh.size**2]
    if len(around) > 1:
        refuse(mesh, int(loops[around[1]][0]), "a second loop runs around the mesh", "no overlap")
    for loop, area in zip(loops, areas, strict=True):
        places = mesh.places[loop]
        extent = float(np.ptp(places, axis=0).max())
        if abs(area) > FLAT * extent**2:
            continue
        ordered = places[np.lexsort(np.round(places / (FLAT * mesh.size)).T)]
        if not (np.abs(np.diff(ordered, axis=0)).max(axis=1) <= FLAT * mesh.size).any():
            refuse(mesh, int(loop[0]), "a node hangs on an edge", "elements that share whole edges")
        x, y = places[0]
        warnings.warn(
            f"{mesh.source}: it has a slit at ({x:.6g}, {y:.6g}): merge the nodes that coincide, unless it is a crack",
            ModelWarning,
            stacklevel=2,
        )


def _linked(mesh: Mesh, edges: IntArray) -> list[IntArray]:
    """The closed walks along directed edges (k, 2 or 3: from, to, amid)."""
    starts, uses = np.unique(edges[:, 0], return_counts=True)
    if uses.max() > 1:
        node = int(starts[uses.argmax()])
        fault = "parts of the mesh touch at one node only, or a node hangs on an edge,"
        refuse(mesh, node, fault, "a boundary that does not meet itself")
    row = dict(zip(edges[:, 0].tolist(), range(len(edges)), strict=True))
    x, y = mesh.places.T
    left = sorted(row, key=lambda node: (x[node], y[node]))
    loops: list[IntArray] = []
    seen: set[int] = set()
    for start in left:
        walk: list[int] = []
        node = start
        while node not in seen:
            seen.add(node)
            edge = edges[row[node]]
            walk += [node, *(int(amid) for amid in edge[2:])]
            node = int(edge[1])
        if walk:
            loops.append(np.array(walk))
    return loops


def _area(places: FloatArray) -> float:
    arms = places - places[0]
    on = np.roll(arms, -1, axis=0)
    return 0.5 * float((arms[:, 0] * on[:, 1] - on[:, 0] * arms[:, 1]).sum())


def names_of(mesh: Mesh, boundary: Boundary, sets: Mapping[str, Any], axis: bool) -> Names:
    """Every name of the mesh: its boundary, the groups it came with, and the user's sets.

    One node is a point and a set. Nodes that are those of one unbroken row of boundary edges are a surface, too: in
    the order of their loop, closed if it is the whole loop. Other nodes (an area; several rows) are a set only.

    Parameters
    ----------
    sets : name -> predicate f(x, y) -> bool on the places of nodes (arrays or numbers), node numbers, or the name of
        a group of the mesh
    axis : whether edges on y = 0 are no surface but the axis of a solid of revolution

    Raises
    ------
    ModelError
        For sets that are empty or none of these, a predicate that raises, unknown groups, and names that are taken.
    """
    found = Names()
    _name_loops(found, mesh, boundary, axis)
    taken = set(found.chains)
    given = user_sets(mesh, sets, taken)
    for name, nodes in {**mesh.groups, **given}.items():
        if name in taken:
            continue  # a group of a file that is called like a loop: the loop is what contact needs
        found.sets[name] = np.asarray(nodes)
        if len(nodes) == 1:
            found.points[name] = int(nodes[0])
            continue
        chain = _chain(np.asarray(nodes), boundary)
        if chain is not None:
            found.chains[name] = chain
    return found


def _name_loops(found: Names, mesh: Mesh, boundary: Boundary, axis: bool) -> None:
    """ "outline" and "hole1", ...; of a half section also "surface", without the axis, and open cavities as holes."""
    outer, *holes = boundary.loops
    found.chains["outline"] = (outer, True)
    rest: list[tuple[IntArray, bool]] = [(hole, True) for hole in holes]
    if axis:
        radius = mesh.places[:, 1]
        on_axis = (radius[outer] == 0.0) & (np.roll(radius[outer], -boundary.stride) == 0.0)
        on_axis[np.arange(len(outer)) % boundary.stride != 0] = False
        pieces = _pieces(outer, ~on_axis[:: boundary.stride], boundary.stride)
        pieces.sort(key=lambda piece: -mesh.places[piece[0][0], 0])  # the outer one comes back from the far end
        found.chains["surface"], rest = pieces[0], pieces[1:] + rest
    for k, chain in enumerate(rest, start=1):
        found.chains[f"hole{k}"] = chain
    for name, (nodes, _) in found.chains.items():
        found.sets[name] = np.unique(nodes)


def _pieces(loop: IntArray, kept: np.ndarray[Any, np.dtype[np.bool_]], stride: int) -> list[tuple[IntArray, bool]]:
    """The runs of the edges ``kept`` of a closed loop, as chains."""
    if kept.all():
        return [(loop, True)]
    begins = np.flatnonzero(kept & ~np.roll(kept, 1))
    ends = np.flatnonzero(kept & ~np.roll(kept, -1))
    pieces = []
    for begin in begins:
        after = ends[ends >= begin]
        length = (int(after[0]) if len(after) else int(ends[0]) + len(kept)) - int(begin) + 1
        places = (stride * int(begin) + np.arange(stride * length + 1)) % len(loop)
        pieces.append((loop[places], False))
    return pieces


def _chain(nodes: IntArray, boundary: Boundary) -> tuple[IntArray, bool] | None:
    """The nodes in the order of their loop, if they are one unbroken row of its edges."""
    for loop in boundary.loops:
        inside = np.isin(loop, nodes)
        whole = inside & np.roll(inside, -1)
        if boundary.stride == 2:
            whole = whole & np.roll(inside, -2)
        pieces = _pieces(loop, whole[:: boundary.stride], boundary.stride) if inside.any() else []
        if len(pieces) == 1 and len(pieces[0][0]) == len(nodes):
            return pieces[0]
    return None
