"""Triangles from STL files, ASCII and binary."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from lcpflex.errors import ModelError, path_of, shown
from lcpflex.jit.kernel import FloatArray

__all__ = ["TRIANGLES", "read_stl"]

TRIANGLES = 1_000_000  # of a surface, beyond which neither memory nor patience would do
LARGEST = 500 * TRIANGLES  # bytes: a triangle takes 50 of them, as text some 300
HEADER = 84  # bytes: 80 of anything, and the number of triangles
RECORD = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("more", "<u2")])  # 50 bytes
FACET = ("facet", "outer", "vertex", "vertex", "vertex", "endloop", "endfacet")  # first words of the lines of one


def read_stl(name: str, path: str | os.PathLike[str]) -> tuple[FloatArray, str]:
    """(T, 3, 3) corners of the triangles of a file, in its unit of length, and what to call it in messages.

    Corners are counter-clockwise seen from outside; the normals of the file are not looked at. Several solids in a
    file are one surface. A file of the length that its number of triangles asks for is a binary one, whatever it
    begins with; a few bytes behind them, less than a triangle has, are left alone.

    Raises
    ------
    ModelError
        For what is no such file, one that ends too soon or goes on, no triangles or more than a million, and numbers
        that are not finite.
    """
    file = path_of(name, path)
    source = f"{name} {shown(str(file))}"
    data = _bytes(file, source)
    count = int.from_bytes(data[HEADER - 4 : HEADER], "little") if len(data) >= HEADER else -1
    behind = len(data) - HEADER - count * RECORD.itemsize
    if count >= 0 and 0 <= behind < RECORD.itemsize:  # a line break, most often
        corners = np.frombuffer(data, dtype=RECORD, count=count, offset=HEADER)["corners"].astype(np.float64)
    elif data.lstrip()[:5].lower() == b"solid" and b"\0" not in data[:1000]:
        corners = _from_text(data.decode("latin-1"), source)  # names may be in any encoding, all else is ASCII
    else:
        size = f"its header tells of {count} triangles" if count >= 0 else "it has no header"
        raise ModelError(
            f"{source}: {size} and it has {len(data)} bytes, expected an STL file: ASCII, or binary with "
            f"{HEADER} bytes and {RECORD.itemsize} for each triangle"
        )
    if not 0 < len(corners) <= TRIANGLES:
        raise ModelError(f"{source}: {len(corners)} triangles were found, expected 1 to {TRIANGLES}")
    wrong = ~np.isfinite(corners).all(axis=(1, 2))
    if wrong.any():
        raise ModelError(f"{source}: triangle {wrong.argmax()} has places that are not finite, expected numbers")
    return corners, source


def _bytes(file: Path, source: str) -> bytes:
    try:
        if not file.is_file():
            raise ModelError(f"{source}: there is no such file, expected the name of an STL file")
        if file.stat().st_size > LARGEST:
            raise ModelError(f"{source}: it has {file.stat().st_size} bytes, expected a file of at most {LARGEST}")
        return file.read_bytes()
    except OSError as error:
        raise ModelError(f"{source}: it cannot be read ({error.strerror}), expected an STL file") from None


def _from_text(text: str, source: str) -> FloatArray:
    """(T, 3, 3) corners of an ASCII file: lines "solid", then facets of seven lines each, then "endsolid"."""
    found: list[list[float]] = []
    inside, at = False, 0  # a solid, and which line of a facet is next
    for number, line in enumerate(text.replace("\r", "\n").split("\n"), 1):
        words = line.split()
        if not words:
            continue
        word, expected = words[0].lower(), FACET[at] if inside else "solid"
        if word == expected == "solid":
            inside = True
        elif inside and at == 0 and word == "endsolid":
            inside = False
        elif word != expected:
            raise ModelError(f"{source}: line {number} is {shown(line.strip())}, expected {expected!r}")
        else:
            if word == "vertex":
                found.append(_numbers(words, number, source))
            at = (at + 1) % len(FACET)
    if inside:
        raise ModelError(f"{source}: it ends before 'endsolid', expected a whole file")
    return np.array(found, dtype=np.float64).reshape(-1, 3, 3)


def _numbers(words: list[str], number: int, source: str) -> list[float]:
    """The three numbers of a vertex."""
    try:
        if len(words) != 4 or any("_" in word for word in words):  # Python takes 1_000 for a number
            raise ValueError
        return [float(word) for word in words[1:]]
    except ValueError:
        given = shown(" ".join(words[:9]))
        raise ModelError(f"{source}: line {number} is {given}, expected 'vertex' and three numbers") from None
