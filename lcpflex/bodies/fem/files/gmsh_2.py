"""Nodes and elements of Gmsh's format 2.2."""

from __future__ import annotations

import numpy as np

from lcpflex.bodies.fem.files.found import CELLS, Unreadable
from lcpflex.bodies.fem.files.gmsh_cells import Block, Elements, Nodes, kind_of, ordered
from lcpflex.bodies.fem.files.gmsh_numbers import BinaryNumbers, Numbers, run_of
from lcpflex.bodies.fem.files.numbering import integers_of
from lcpflex.jit.kernel import IntArray

__all__ = ["binary_elements", "binary_nodes", "text_elements", "text_nodes"]

TAGS = 10_000  # of an element at most: its groups, and partitions


def text_nodes(numbers: Numbers) -> Nodes:
    """A number and a place on each line."""
    count = int(numbers.sizes(1)[0])
    table = numbers.floats(4 * count).reshape(count, 4)
    whole = table[:, 0].astype(np.int64) if np.isfinite(table[:, 0]).all() else None
    if whole is None or (whole != table[:, 0]).any():
        raise Unreadable("$Nodes has a line that begins with no whole number, expected numbers of nodes")
    return Nodes(whole, np.ascontiguousarray(table[:, 1:]))


def binary_nodes(numbers: BinaryNumbers, count: int) -> Nodes:
    """The same in bytes."""
    table = numbers.records(count, [("number", "i4", 1), ("place", "f8", 3)])
    return Nodes(table["number"][:, 0].astype(np.int64), table["place"].astype(np.float64))


def text_elements(text: bytes) -> Elements:
    """Number, type, count of tags, tags and nodes on each line."""
    numbers = integers_of(text, "$Elements")
    if not len(numbers):
        raise Unreadable("$Elements is empty, expected a number of elements")
    told, at, found = int(numbers[0]), 1, 0
    pieces: list[tuple[str, int, IntArray]] = []
    while at < len(numbers):
        if at + 3 > len(numbers):
            raise Unreadable("$Elements ends amid an element, expected its nodes")
        kind, tags = kind_of(int(numbers[at + 1])), _tags(int(numbers[at + 2]))
        length = 3 + tags + CELLS[kind].nodes
        if at + length > len(numbers):
            raise Unreadable(f"$Elements ends amid element {numbers[at]}, expected {length} numbers")
        count = run_of(numbers, at, length, slice(1, 3))
        table = numbers[at : at + count * length].reshape(count, length)
        pieces.append((kind, tags, np.delete(table, [1, 2], axis=1)))
        at, found = at + count * length, found + count
    _check_count(told, found)
    return _blocks(pieces)


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
    """Elements of one kind that follow each other are a block; groups are read off their first tags."""
    blocks: Elements = []
    at = 0
    while at < len(pieces):
        end = at + 1
        while end < len(pieces) and pieces[end][0] == pieces[at][0]:
            end += 1
        kind = pieces[at][0]
        numbers = np.concatenate([table[:, 0] for _, _, table in pieces[at:end]])
        cells = np.concatenate([table[:, 1 + tags :] for _, tags, table in pieces[at:end]])
        first = np.concatenate(
            [np.abs(table[:, 1]) if tags else np.zeros(len(table), dtype=np.int64) for _, tags, table in pieces[at:end]]
        )  # a negative one: the element is turned around
        physical = [(int(tag), np.flatnonzero(first == tag)) for tag in np.unique(first) if tag]
        blocks.append(Block(kind, numbers, ordered(kind, cells), physical))
        at = end
    return blocks
