"""Data lines of Abaqus input files: numbers between commas, and members of sets."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from lcpflex.bodies.fem.files.abaqus_text import Keyword, decoded, words_of
from lcpflex.bodies.fem.files.found import CELLS, Unreadable
from lcpflex.bodies.fem.files.numbering import EXACT, floats_of, integers_of
from lcpflex.errors import shown
from lcpflex.jit.kernel import FloatArray, IntArray

__all__ = ["Member", "element_table", "first_numbers", "instance_motion", "member_of", "members", "node_table", "pairs"]

EMPTY = re.compile(rb",(?=[ \t]*,)")
TRAILING = re.compile(rb",[ \t]*$", re.MULTILINE)
BLANK = re.compile(rb"\n\s*\n")
FIRST = re.compile(rb"^[ \t]*(\d+)", re.MULTILINE)
NAMED = re.compile(rb"[A-Za-z_\".]")
INNER = (11, 12)  # numbers on lines of C3D8I with the nodes that CalculiX adds for incompatible modes, which are left
COMMAS = bytes.maketrans(b",", b" ")
FORTRAN = bytes.maketrans(b"Dd", b"Ee")  # of exponents


@dataclass(frozen=True, slots=True, eq=False)
class Member:
    """What a data line puts into a set: numbers, a range of them (first, last, step), or the name of a set.

    ``instance``: whose numbers or set they are; "": those of the set itself. ``of_elements``: the name is one of
    elements, whose nodes are meant.
    """

    numbers: IntArray | None = None
    range: tuple[int, int, int] | None = None
    name: str = ""
    instance: str = ""
    of_elements: bool = False


def _lines(keyword: Keyword, fill: bool) -> tuple[bytes, IntArray]:
    """Data lines with blanks for commas, and how many entries each has. fill: empty entries are zero."""
    text = BLANK.sub(b"\n", keyword.text().strip())
    text = TRAILING.sub(b"", text)
    if EMPTY.search(text) is not None:
        if not fill:
            raise Unreadable(f"*{keyword.name} {keyword.where} has a line with an empty entry, expected numbers")
        text = EMPTY.sub(b",0", text)
    if not text:
        return b"", np.zeros(0, dtype=np.int64)
    codes = np.frombuffer(text, dtype=np.uint8)
    starts = np.concatenate([[0], np.flatnonzero(codes == ord("\n")) + 1])
    counts = np.add.reduceat((codes == ord(",")).astype(np.int64), starts) + 1
    return text.translate(COMMAS), counts


def node_table(keyword: Keyword) -> tuple[IntArray, FloatArray]:
    """Numbers and (n, 3) places of the lines of *NODE: number, up to three coordinates, and a normal, which is left."""
    where = f"*NODE {keyword.where}"
    text, counts = _lines(keyword, fill=True)
    if b"d" in text or b"D" in text:
        text = text.translate(FORTRAN)
    numbers = floats_of(text, where)
    _check_entries(len(numbers), counts, where)
    if len(counts) and counts.max() > 7:
        raise Unreadable(f"{where} has a line of {counts.max()} numbers, expected a number and three coordinates")
    starts = np.cumsum(counts) - counts
    tags = numbers[starts]
    if not (np.abs(tags) < EXACT).all() or (tags != np.rint(tags)).any():
        raise Unreadable(f"{where} has a line that begins with no whole number, expected numbers of nodes")
    places = np.zeros((len(counts), 3))
    for count in np.unique(counts):
        some, width = np.flatnonzero(counts == count), min(int(count) - 1, 3)
        places[some, :width] = numbers[starts[some][:, None] + np.arange(1, width + 1)]
    return tags.astype(np.int64), _cartesian(keyword, places)


def _cartesian(keyword: Keyword, places: FloatArray) -> FloatArray:
    system = keyword.options.get("SYSTEM", "R").upper()
    if system == "R":
        return places
    if system != "C":
        raise Unreadable(
            f"*NODE {keyword.where} has SYSTEM={shown(system)}, expected R (rectangular) or C (cylindrical)"
        )
    angle = np.radians(places[:, 1])
    return np.column_stack([places[:, 0] * np.cos(angle), places[:, 0] * np.sin(angle), places[:, 2]])


def _check_entries(found: int, counts: IntArray, where: str) -> None:
    if found != int(counts.sum()):
        raise Unreadable(f"{where} has numbers without a comma between them, expected commas")


def element_table(keyword: Keyword, kind: str) -> tuple[IntArray, IntArray]:
    """Numbers and (m, nodes) numbers of nodes of the lines of *ELEMENT, however an element is spread over lines."""
    where = f"*ELEMENT {keyword.where}"
    text, counts = _lines(keyword, fill=False)
    numbers = integers_of(text, where)
    _check_entries(len(numbers), counts, where)
    width = 1 + CELLS[kind].nodes
    if kind == "hexahedron" and len(counts) and counts[0] in INNER and (counts == counts[0]).all():
        return _columns(numbers, int(counts[0]), width)
    begins = np.zeros(len(numbers) + 1, dtype=np.bool_)
    begins[np.cumsum(counts)] = True
    begins[0] = True
    if len(numbers) % width or not begins[::width].all():
        raise Unreadable(
            f"{where} has lines that are no elements of {width - 1} nodes, expected a number and so many nodes for each"
        )
    return _columns(numbers, width, width)


def _columns(numbers: IntArray, length: int, width: int) -> tuple[IntArray, IntArray]:
    table = numbers.reshape(-1, length)
    return table[:, 0], table[:, 1:width]


def first_numbers(keyword: Keyword) -> IntArray:
    """Numbers of elements that are no part of a mesh, whose nodes may be named in other ways."""
    return np.array([int(number[:18]) for number in FIRST.findall(keyword.text())], dtype=np.int64)


def members(keyword: Keyword) -> Iterator[Member]:
    """What the data lines of *NSET or *ELSET put into a set."""
    where, instance = f"*{keyword.name} {keyword.where}", keyword.options.get("INSTANCE", "")
    text = keyword.text()
    if "GENERATE" in keyword.options:
        yield from _ranges(keyword, where, instance)
        return
    if NAMED.search(text) is None:
        numbers = integers_of(text.translate(COMMAS), where)
        if len(numbers):
            yield Member(numbers=numbers, instance=instance)
        return
    for line in decoded(text).splitlines():
        for word in words_of(line):
            if word:
                yield member_of(word, instance, where)


def member_of(word: str, instance: str, where: str) -> Member:
    """A number or name, with the name of an instance and a dot before it where it is one of that."""
    owner, dot, last = word.rpartition(".")
    if dot and not instance and owner:
        word, instance = last, owner
    if word.isdecimal():
        return Member(numbers=integers_of(word.encode(), where), instance=instance)
    return Member(name=word, instance=instance)


def _ranges(keyword: Keyword, where: str, instance: str) -> Iterator[Member]:
    text, counts = _lines(keyword, fill=False)
    numbers = integers_of(text, where)
    _check_entries(len(numbers), counts, where)
    at = 0
    for count in counts.tolist():
        if count not in (2, 3):
            raise Unreadable(f"{where} has a line of {count} numbers, expected the first, the last and the step")
        first, last, step = (*numbers[at : at + count].tolist(), 1)[:3]
        at += count
        if step < 1 or last < first:
            raise Unreadable(f"{where} has the range {first}, {last}, {step}, expected a step >= 1 and a rising range")
        yield Member(range=(first, last, step), instance=instance)


def pairs(keyword: Keyword) -> Iterator[tuple[str, str]]:
    """Members of *SURFACE: an element, node, set or surface, and the name of a face or "" on each line."""
    for line in decoded(keyword.text()).splitlines():
        words = words_of(line)
        if words[0]:
            yield words[0], words[1].upper() if len(words) > 1 else ""


def instance_motion(keyword: Keyword) -> tuple[FloatArray, FloatArray]:
    """Rotation R (3, 3) and shift s (3,) of an *INSTANCE: x becomes R x + s.

    Its first line is a translation; its second, two points of an axis and an angle in degrees about it, comes after.
    """
    where = f"*INSTANCE {keyword.where}"
    text, counts = _lines(keyword, fill=True)
    numbers = floats_of(text, where)
    _check_entries(len(numbers), counts, where)
    rotation = np.eye(3)
    if not len(numbers):
        return rotation, np.zeros(3)
    lines = counts.tolist()
    if lines[0] > 3 or lines[1:] not in ([], [7]) or not np.isfinite(numbers).all():
        raise Unreadable(f"{where} has lines of {lines} numbers, expected 3 of a translation, and 7 of a rotation")
    shift = np.zeros(3)
    shift[: lines[0]] = numbers[: lines[0]]
    if len(lines) == 1:
        return rotation, shift
    start, axis, angle = numbers[-7:-4], numbers[-4:-1] - numbers[-7:-4], np.radians(numbers[-1])
    length = float(np.linalg.norm(axis))
    if not 0.0 < length < np.inf:
        raise Unreadable(f"{where} turns about an axis between equal points, expected different ones")
    x, y, z = axis / length
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    rotation = rotation + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross
    return rotation, rotation @ (shift - start) + start
