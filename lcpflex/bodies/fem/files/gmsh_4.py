"""Nodes, elements and entities of Gmsh's format 4.1."""

from __future__ import annotations

import numpy as np

from lcpflex.bodies.fem.files.found import CELLS, Unreadable
from lcpflex.bodies.fem.files.gmsh_cells import Block, Elements, Nodes, kind_of, ordered
from lcpflex.bodies.fem.files.gmsh_numbers import Numbers
from lcpflex.bodies.fem.files.numbering import joined
from lcpflex.jit.kernel import FloatArray, IntArray

__all__ = ["elements", "entities", "nodes"]


MOST = 1_000_000  # entities, and blocks of nodes or elements: real models have thousands


def entities(numbers: Numbers) -> dict[tuple[int, int], list[int]]:
    """Numbers of the physical groups of each entity, by its dimension and number."""
    found: dict[tuple[int, int], list[int]] = {}
    for dimension, count in enumerate(_counts("$Entities", numbers)):
        for _ in range(count):
            tag = int(numbers.ints(1)[0])
            numbers.floats(3 if dimension == 0 else 6)  # its place, or the box around it
            groups = numbers.ints(int(numbers.sizes(1)[0]))
            found[dimension, tag] = sorted({abs(int(group)) for group in groups})  # negative: turned around
            if dimension:
                numbers.ints(int(numbers.sizes(1)[0]))  # what bounds it
    return found


def nodes(numbers: Numbers) -> Nodes:
    """Blocks of the nodes of an entity: their numbers, then their places."""
    blocks, told, _, _ = _counts("$Nodes", numbers, 1)
    tags: list[IntArray] = []
    places: list[FloatArray] = []
    for _ in range(blocks):
        dimension, _, parametric = (int(value) for value in numbers.ints(3))
        count = int(numbers.sizes(1)[0])
        if not 0 <= dimension <= 3 or parametric not in (0, 1):
            raise Unreadable(
                f"$Nodes has nodes of dimension {dimension}, parametric {parametric}, expected 0 to 3, 0 or 1"
            )
        tags.append(numbers.sizes(count))
        width = 3 + parametric * dimension
        places.append(numbers.floats(count * width).reshape(count, width)[:, :3])
    every = joined(tags)
    _check_count("$Nodes", "nodes", told, len(every))
    return Nodes(every, np.concatenate(places) if places else np.zeros((0, 3)))


def elements(numbers: Numbers, groups: dict[tuple[int, int], list[int]] | None) -> Elements:
    """Blocks of the elements of an entity, which are in its physical groups. groups: of the entities, if told."""
    blocks, told, _, _ = _counts("$Elements", numbers, 1)
    found: Elements = []
    for _ in range(blocks):
        dimension, entity, number = (int(value) for value in numbers.ints(3))
        count = int(numbers.sizes(1)[0])
        kind = kind_of(number)
        if CELLS[kind].dimension != dimension:
            raise Unreadable(f"$Elements has {kind} in an entity of dimension {dimension}, expected elements of that")
        if groups is not None and (dimension, entity) not in groups:
            raise Unreadable(f"$Elements has entity {entity} of dimension {dimension}, expected one of $Entities")
        table = numbers.sizes(count * (1 + CELLS[kind].nodes)).reshape(count, -1 if count else 1 + CELLS[kind].nodes)
        physical = [(tag, slice(None)) for tag in (groups or {}).get((dimension, entity), ()) if tag]
        found.append(Block(kind, table[:, 0], ordered(kind, table[:, 1:]), physical))
    _check_count("$Elements", "elements", told, sum(len(block.numbers) for block in found))
    return found


def _counts(section: str, numbers: Numbers, entities: int = 4) -> list[int]:
    """The four numbers with which each section begins; the first of them, or all, count entities."""
    counts = [int(size) for size in numbers.sizes(4)]
    if max(counts[:entities]) > MOST:
        raise Unreadable(f"{section} tells {max(counts[:entities])} entities, expected at most {MOST}")
    return counts


def _check_count(section: str, what: str, told: int, found: int) -> None:
    if told != found:
        raise Unreadable(f"{section} tells {told} {what} and has {found}, expected as many")
