"""Nodes and elements of Gmsh's format 2.2."""

from __future__ import annotations

import numpy as np

from lcpflex.bodies.fem.files.found import CELLS, Unreadable
from lcpflex.bodies.fem.files.gmsh_cells import Block, Elements, Nodes, kind_of, ordered
from lcpflex.bodies.fem.files.gmsh_numbers import BinaryNumbers, Numbers, line_counts, run_of
from lcpflex.bodies.fem.files.numbering import EXACT, integers_of
from lcpflex.jit.kernel import IntArray

__all__ = ["binary_elements", "binary_nodes", "text_elements", "text_nodes"]

TAGS = 10_000  # of an element at most: its groups, and partitions


def text_nodes(numbers: Numbers) -> Nodes:
    """A number and a place on each line."""
    count = int(numbers.sizes(1)[0])
    table = numbers.floats(4 * count).reshape(count, 4)
    if not (np.abs(table[:, 0]) < EXACT).all() or (table[:, 0] != np.rint(table[:, 0])).any():
        raise Unreadable("$Nodes has a line that begins with no whole number, expected numbers of nodes")
    return Nodes(table[:, 0].astype(np.int64), np.ascontiguousarray(table[:, 1:]))


def binary_nodes(numbers: BinaryNumbers, count: int) -> Nodes:
    """The same in bytes."""
    table = numbers.records(count, [("number", "i4", 1), ("place", "f8", 3)])
    return Nodes(table["number"][:, 0].astype(np.int64), table["place"].astype(np.float64))


def text_elements(text: bytes) -> Elements:
    """Number, type, count of tags, tags and nodes on each line."""
    numbers, counts = integers_of(text, "$Elements"), line_counts(text)
    if not len(counts) or counts[0] != 1 or counts.sum() != len(numbers):
        raise Unreadable("$Elements does not begin with a line of the number of elements, expected one")
    begins = np.cumsum(counts)[:-1]
    ends = begins + counts[1:]
    _check_count(int(numbers[0]), len(begins))
    if (counts[1:] < 4).any():
        raise Unreadable(f"$Elements has a line of {counts[1:].min()} numbers, expected an element on each")
    types, tags = numbers[begins + 1], numbers[begins + 2]
    blocks: Elements = []
    for number in np.unique(types):
        of = np.flatnonzero(types == number)
        kind = kind_of(int(number))
        lengths = ends[of] - begins[of]
        wrong = (lengths != 3 + tags[of] + CELLS[kind].nodes) | (tags[of] < 0)
        if wrong.any():
            k = int(wrong.argmax())
            raise Unreadable(
                f"$Elements has element {numbers[begins[of[k]]]}, {kind} of {tags[of[k]]} tags, on a line of "
                f"{lengths[k]} numbers, expected {3 + max(int(tags[of[k]]), 0) + CELLS[kind].nodes}"
            )
        cells = numbers[ends[of][:, None] - np.arange(CELLS[kind].nodes, 0, -1)]
        group = np.where(tags[of] > 0, numbers[begins[of] + 3], 0)
        blocks.append(_block(kind, numbers[begins[of]], group, cells))
    return blocks


def binary_elements(numbers: BinaryNumbers, told: int) -> Elements:
    """Headers of type, count and count of tags, each before its elements; there may be one for each element."""
    pieces: list[tuple[str, int, IntArray]] = []
    rest, at, found = numbers.rest(), 0, 0
    while found < told:
        if at + 3 > len(rest):
            raise Unreadable(f"$Elements ends after {found} elements, expected {told}")
        kind, count, tags = kind_of(int(rest[at])), int(rest[at + 1]), _tags(int(rest[at + 2]))
        width = 1 + tags + CELLS[kind].nodes
        if count < 0 or at + 3 + count * width > len(rest):
            raise Unreadable(f"$Elements tells {count} {kind}, expected no more than fit into the file")
        if count == 1:  # a header for each element
            count = min(run_of(rest, at, 3 + width, slice(0, 3)), told - found)
            table = rest[at : at + count * (3 + width)].reshape(count, 3 + width)[:, 3:]
            at += count * (3 + width)
        else:
            table = rest[at + 3 : at + 3 + count * width].reshape(count, width)
            at += 3 + count * width
        found += count
        if count:
            pieces.append((kind, tags, table.astype(np.int64)))
    _check_count(told, found)
    numbers.at += 4 * at
    return _blocks(pieces)


def _tags(count: int) -> int:
    if not 0 <= count <= TAGS:
        raise Unreadable(f"$Elements has an element of {count} tags, expected 0 to {TAGS}")
    return count


def _check_count(told: int, found: int) -> None:
    if told != found:
        raise Unreadable(f"$Elements tells {told} elements and has {found}, expected as many")


def _blocks(pieces: list[tuple[str, int, IntArray]]) -> Elements:
    """One block for each kind. pieces: kind, count of tags, and (m, 1 + tags + nodes) numbers."""
    blocks: Elements = []
    for kind in dict.fromkeys(kind for kind, _, _ in pieces):
        of = [(tags, table) for name, tags, table in pieces if name == kind]
        numbers = np.concatenate([table[:, 0] for _, table in of])
        cells = np.concatenate([table[:, 1 + tags :] for tags, table in of])
        groups = np.concatenate([table[:, 1] if tags else np.zeros(len(table), dtype=np.int64) for tags, table in of])
        blocks.append(_block(kind, numbers, groups, cells))
    return blocks


def _block(kind: str, numbers: IntArray, groups: IntArray, cells: IntArray) -> Block:
    """groups: numbers of physical groups; 0: none; a negative one: the element is turned around."""
    groups = np.abs(groups)
    order = np.argsort(groups, kind="stable")
    tags, first = np.unique(groups[order], return_index=True)
    members = np.split(order, first[1:])
    physical = [(int(tag), some) for tag, some in zip(tags, members, strict=True) if tag]
    return Block(kind, numbers, ordered(kind, cells), physical)
