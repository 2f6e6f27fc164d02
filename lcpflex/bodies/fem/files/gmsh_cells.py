"""Elements of Gmsh: their numbers, and their nodes in the order of meshio."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from lcpflex.bodies.fem.files.found import CELLS, Unreadable
from lcpflex.jit.kernel import FloatArray, IntArray

__all__ = ["Block", "Elements", "Names", "Nodes", "kind_of", "merged_twins", "ordered"]

TYPES = {
    1: "line", 2: "triangle", 3: "quad", 4: "tetra", 5: "hexahedron", 6: "wedge", 7: "pyramid", 8: "line3",
    9: "triangle6", 10: "quad9", 11: "tetra10", 12: "hexahedron27", 13: "wedge18", 14: "pyramid14", 15: "vertex",
    16: "quad8", 17: "hexahedron20", 18: "wedge15", 19: "pyramid13",
}  # fmt: skip
HIGHER = (*range(20, 139), 140)  # numbers of elements of higher order, polygons and the like
ORDERS = {  # where the nodes of meshio stand among those of Gmsh
    "tetra10": [0, 1, 2, 3, 4, 5, 6, 7, 9, 8],
    "hexahedron20": [0, 1, 2, 3, 4, 5, 6, 7, 8, 11, 13, 9, 16, 18, 19, 17, 10, 12, 14, 15],
    "hexahedron27": [
        *[0, 1, 2, 3, 4, 5, 6, 7, 8, 11, 13, 9, 16, 18, 19, 17, 10, 12, 14, 15],
        *[22, 23, 21, 24, 20, 25, 26],
    ],
    "wedge15": [0, 1, 2, 3, 4, 5, 6, 9, 7, 12, 14, 13, 8, 10, 11],
    "wedge18": [0, 1, 2, 3, 4, 5, 6, 9, 7, 12, 14, 13, 8, 10, 11, 15, 17, 16],
    "pyramid13": [0, 1, 2, 3, 4, 5, 8, 10, 6, 7, 9, 11, 12],
    "pyramid14": [0, 1, 2, 3, 4, 5, 8, 10, 6, 7, 9, 11, 12, 13],
}

MULTIPLIER = 6364136223846793005  # Knuth's, of random numbers modulo 2^64

Names = dict[tuple[int, int], str]  # of physical groups, by dimension and number


@dataclass(frozen=True, slots=True, eq=False)
class Nodes:
    """Their numbers in the file, and (N, 3) places."""

    numbers: IntArray
    places: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Block:
    """Elements of one kind that follow each other in the file.

    Attributes
    ----------
    kind : by the names of meshio
    numbers : of the elements in the file
    cells : (m, nodes) numbers of nodes, in the order of meshio
    physical : numbers of physical groups, rising, and which elements are in each
    """

    kind: str
    numbers: IntArray
    cells: IntArray
    physical: Sequence[tuple[int, IntArray | slice]] = field(default_factory=list)


Elements = list[Block]


def kind_of(number: int) -> str:
    """The kind of element of that number; raises Unreadable for those that are not known."""
    if number in TYPES:
        return TYPES[number]
    kind = "one of higher order or another kind" if number in HIGHER else "unknown to Gmsh"
    raise Unreadable(f"elements of type {number} ({kind}), expected elements of first or second order")


def ordered(kind: str, cells: IntArray) -> IntArray:
    """Nodes of elements of Gmsh in the order of meshio."""
    return cells[:, ORDERS[kind]] if kind in ORDERS else cells


def merged_twins(
    blocks: list[tuple[str, IntArray]], tags: dict[str, list[FloatArray]]
) -> tuple[list[tuple[str, IntArray]], dict[str, list[FloatArray]]]:
    """The blocks without elements that come twice: format 2.2 writes an element for each physical group it is in."""
    kinds = {kind for kind, _ in blocks if CELLS[kind].dimension >= 2}
    for kind in kinds:
        which = [k for k, (name, _) in enumerate(blocks) if name == kind]
        cells = np.concatenate([blocks[k][1] for k in which])
        first = _first_of_twins(cells)
        if first.all():
            continue
        at = 0
        for k in which:
            kept = first[at : at + len(blocks[k][1])]
            at += len(kept)
            blocks[k] = kind, blocks[k][1][kept]
            for values in tags.values():
                values[k] = values[k][kept]
    return blocks, tags


def _first_of_twins(cells: IntArray) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    """Which rows have not come before: told by a number made of each, and where two are the same, by the rows."""
    keys = cells @ np.cumprod(np.full(cells.shape[1], MULTIPLIER))
    order = np.argsort(keys, kind="stable")
    first = np.ones(len(cells), dtype=np.bool_)
    same = np.flatnonzero(keys[order[1:]] == keys[order[:-1]])
    twins = (cells[order[same + 1]] == cells[order[same]]).all(axis=1)
    first[order[same[twins] + 1]] = False
    return first
