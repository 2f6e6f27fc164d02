"""Numbers of elements that scikit-fem stores in files of Gmsh: which facets and elements its names stand for."""

from __future__ import annotations

import numpy as np

from lcpflex.bodies.fem.files.found import Unreadable
from lcpflex.bodies.fem.files.gmsh_numbers import BinaryNumbers, TextNumbers
from lcpflex.errors import shown
from lcpflex.jit.kernel import FloatArray, IntArray

__all__ = ["element_data"]

MOST = 1000  # of each kind of entries in the head of such a section


def element_data(section: bytes, order: str) -> tuple[str, IntArray, FloatArray] | None:
    """Name, numbers of elements, and their values, of a section $ElementData; None for those of other programs.

    section: what stands in it. order: the byte order, "<" or ">"; "": text.
    """
    lines, at = _head(section)
    if not lines[0] or not lines[0][0].startswith("skfem:"):
        return None
    name, counts = lines[0][0], lines[2]
    if len(counts) < 3 or counts[1] != "1" or not counts[2].isdecimal():
        raise Unreadable(f"$ElementData {shown(name)} has the numbers {shown(counts)}, expected one value an element")
    count = int(counts[2][:20])
    if order:
        table = BinaryNumbers(section, at, order, 8, "$ElementData").records(
            count, [("number", "i4", 1), ("value", "f8", 1)]
        )
        return name, table["number"][:, 0].astype(np.int64), table["value"][:, 0].astype(np.float64)
    numbers = TextNumbers(section[at:], "$ElementData")
    table = numbers.floats(2 * count).reshape(count, 2)
    numbers.check_end()
    if not (np.abs(table[:, 0]) < 2.0**53).all():
        raise Unreadable("$ElementData has numbers of elements that are none, expected whole ones")
    return name, table[:, 0].astype(np.int64), np.ascontiguousarray(table[:, 1])


def _head(section: bytes) -> tuple[list[list[str]], int]:
    """Texts, numbers and whole numbers, each a line behind a line with their count; and where they end."""
    at, lines = 0, []
    for _ in range(3):
        word, at = _line(section, at)
        if not word.isdecimal() or int(word[:9]) > MOST:
            raise Unreadable(f"$ElementData has {shown(word)}, expected a number of tags")
        entries = []
        for _ in range(int(word)):
            entry, at = _line(section, at)
            entries.append(entry.strip('"'))
        lines.append(entries)
    return lines, at


def _line(section: bytes, at: int) -> tuple[str, int]:
    end = section.find(b"\n", at)
    if end < 0:
        raise Unreadable("$ElementData ends amid its tags, expected texts, numbers and whole numbers")
    return section[at:end].decode(errors="replace").strip(), end + 1
