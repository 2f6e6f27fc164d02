"""What a mesh file holds: places, elements of all kinds in the order of the file, and named groups of them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from lcpflex.errors import shown
from lcpflex.jit.kernel import FloatArray, IntArray

__all__ = ["CELLS", "Cell", "FoundMesh", "Group", "Part", "Unreadable", "cell_of", "distinct", "grouped"]


class Unreadable(Exception):
    """A file that is not what its format says; the message says what was found and what was expected."""


@dataclass(frozen=True, slots=True)
class Cell:
    """One kind of element: its dimension, corners and nodes."""

    dimension: int
    corners: int
    nodes: int


CELLS = {  # by the names of meshio, whose local order of nodes is VTK's
    "vertex": Cell(0, 1, 1),
    "line": Cell(1, 2, 2),
    "line3": Cell(1, 2, 3),
    "triangle": Cell(2, 3, 3),
    "triangle6": Cell(2, 3, 6),
    "quad": Cell(2, 4, 4),
    "quad8": Cell(2, 4, 8),
    "quad9": Cell(2, 4, 9),
    "tetra": Cell(3, 4, 4),
    "tetra10": Cell(3, 4, 10),
    "hexahedron": Cell(3, 8, 8),
    "hexahedron20": Cell(3, 8, 20),
    "hexahedron27": Cell(3, 8, 27),
    "wedge": Cell(3, 6, 6),
    "wedge15": Cell(3, 6, 15),
    "wedge18": Cell(3, 6, 18),
    "pyramid": Cell(3, 5, 5),
    "pyramid13": Cell(3, 5, 13),
    "pyramid14": Cell(3, 5, 14),
}
FACE_CORNERS = {"tetra": 3, "tetra10": 3, "hexahedron": 4, "hexahedron20": 4, "hexahedron27": 4}
FAMILIES = {"line": (1, 2), "triangle": (2, 3), "quad": (2, 4)}  # of whatever order: dimension and corners


def cell_of(kind: str) -> Cell | None:
    """The kind of element of that name; of unknown order, without a number of nodes; None for any other."""
    if kind in CELLS:
        return CELLS[kind]
    family = FAMILIES.get(kind.rstrip("0123456789"))
    return None if family is None else Cell(*family, 0)


@dataclass(frozen=True, slots=True, eq=False)
class Group:
    """Named nodes, and the facets that the name stands for where it is one of surfaces of a solid mesh.

    Attributes
    ----------
    nodes : rising
    facets : (k, 3 | 4) corner nodes, in the order of the file, or None
    """

    nodes: IntArray
    facets: IntArray | None = None


@dataclass(frozen=True, slots=True, eq=False)
class FoundMesh:
    """N nodes in the order of the file.

    Attributes
    ----------
    points : (N, 3) finite places, in the unit of the file
    blocks : names of kinds (those of meshio) and (m, nodes) nodes of elements; a kind may come several times
    groups : named nodes and facets
    source : what the mesh is called in messages
    tags : numbers that scikit-fem stores with its elements, by name: an array for each block
    """

    points: FloatArray
    blocks: Sequence[tuple[str, IntArray]]
    groups: Mapping[str, Group]
    source: str = "mesh"
    tags: Mapping[str, Sequence[FloatArray]] = field(default_factory=dict)

    def counts(self) -> dict[str, int]:
        """How many elements of each kind there are."""
        counts: dict[str, int] = {}
        for kind, cells in self.blocks:
            if len(cells):
                counts[kind] = counts.get(kind, 0) + len(cells)
        return counts

    def cells(self, kind: str) -> IntArray:
        """(m, nodes) all elements of a kind, in the order of the file."""
        return np.concatenate([cells for name, cells in self.blocks if name == kind])


Part = tuple[str, str, IntArray]  # name of a group, kind of its elements, their nodes


def grouped(sets: Mapping[str, IntArray], sources: Sequence[Sequence[Part]], kinds: Iterable[str]) -> dict[str, Group]:
    """Groups by name: sets of nodes first, then parts of points and lines, of areas, of volumes.

    A name that comes twice keeps its first meaning, to which facets of the same nodes are added; parts of one source,
    name and dimension are one group. Areas give facets where the mesh has solid elements of one kind.

    sets: nodes by name. sources: lists of parts, the former before the latter. kinds: of all elements of the mesh.
    """
    groups = {name: Group(distinct(nodes)) for name, nodes in sets.items() if len(nodes)}
    solid = {kind for kind in kinds if (cell := cell_of(kind)) is None or cell.dimension == 3}
    corners = FACE_CORNERS.get(solid.pop(), 0) if len(solid) == 1 else 0
    for dimensions in ((0, 1), (2,), (3,)):
        for source in sources:
            pieces: dict[str, list[tuple[str, IntArray]]] = {}
            for name, kind, cells in source:
                cell = cell_of(kind)
                if len(cells) and (3 if cell is None else cell.dimension) in dimensions:
                    pieces.setdefault(name, []).append((kind, cells))
            for name, of_name in pieces.items():
                nodes = distinct(np.concatenate([cells.ravel() for _, cells in of_name]))
                faces = _facets(name, of_name, corners) if dimensions == (2,) and corners else None
                known = groups.get(name)
                if known is None or (known.facets is None and np.array_equal(known.nodes, nodes)):
                    groups[name] = Group(nodes, faces)
    return groups


def distinct(nodes: IntArray) -> IntArray:
    """Each of the numbers once, rising; marks are quicker than sorting where there are many."""
    if not len(nodes) or int(nodes.max()) > 4 * len(nodes):
        return np.unique(nodes)
    marked = np.zeros(int(nodes.max()) + 1, dtype=np.bool_)
    marked[nodes] = True
    return np.flatnonzero(marked)


def _facets(name: str, pieces: list[tuple[str, IntArray]], corners: int) -> IntArray:
    for kind, _ in pieces:
        cell = cell_of(kind)
        if cell is None or cell.corners != corners:
            shape = "triangles" if corners == 3 else "quadrilaterals"
            raise Unreadable(f"group {shown(name)} of the surface has elements {kind}, expected {shape}")
    return np.concatenate([cells[:, :corners] for _, cells in pieces])
