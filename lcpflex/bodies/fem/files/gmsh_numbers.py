"""Numbers of a section of a Gmsh file, taken one after another: from its text, or from its bytes."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from lcpflex.bodies.fem.files.found import Unreadable
from lcpflex.bodies.fem.files.numbering import EXACT, floats_of, integers_of
from lcpflex.jit.kernel import FloatArray, IntArray

__all__ = ["BinaryNumbers", "Numbers", "TextNumbers", "line_counts", "run_of"]


class Numbers(Protocol):
    """What both kinds of files give; raises Unreadable where the section ends too soon."""

    def ints(self, count: int) -> IntArray:
        """Whole numbers of 4 bytes."""

    def sizes(self, count: int) -> IntArray:
        """Whole numbers >= 0 of the size that the header tells."""

    def floats(self, count: int) -> FloatArray:
        """Floating-point numbers."""


class TextNumbers:
    """The numbers of a text. whole: all are whole numbers, which are read faster."""

    def __init__(self, text: bytes, section: str, whole: bool = False) -> None:
        self._section, self._at = section, 0
        self._all = integers_of(text, section) if whole else floats_of(text, section)

    def _taken(self, count: int) -> np.ndarray:
        left = len(self._all) - self._at
        if not 0 <= count <= left:
            raise Unreadable(
                f"{self._section} ends too soon: {count} numbers are told, {left} follow, expected all of them"
            )
        self._at += count
        return self._all[self._at - count : self._at]

    def ints(self, count: int) -> IntArray:
        """Whole numbers, which floats hold exactly."""
        taken = self._taken(count)
        if taken.dtype == np.int64:
            return taken
        broken = ~(np.abs(taken) < EXACT) | (taken != np.rint(taken))
        if broken.any():
            raise Unreadable(f"{self._section} holds {taken[broken][0]:.17g}, expected a whole number there")
        return taken.astype(np.int64)

    def sizes(self, count: int) -> IntArray:
        """Whole numbers >= 0."""
        return _checked_sizes(self.ints(count), self._section)

    def floats(self, count: int) -> FloatArray:
        """Numbers as they are."""
        return np.asarray(self._taken(count), dtype=np.float64)

    def check_end(self) -> None:
        """Raise Unreadable where numbers are left."""
        if self._at < len(self._all):
            raise Unreadable(
                f"{self._section} has {len(self._all) - self._at} numbers more than it tells, expected none"
            )


class BinaryNumbers:
    """The numbers in the bytes of a file from a place on.

    order: "<" or ">", the first byte of a number being its lowest or highest. size: bytes of sizes.
    """

    def __init__(self, data: bytes, at: int, order: str, size: int, section: str) -> None:
        self._data, self.at, self._order, self._size, self._section = data, at, order, size, section

    def _taken(self, count: int, dtype: np.dtype, what: str = "numbers") -> np.ndarray:
        left = (len(self._data) - self.at) // dtype.itemsize
        if not 0 <= count <= left:
            raise Unreadable(
                f"{self._section} tells {count} {what}, expected no more than the {left} that fit into the file"
            )
        taken = np.frombuffer(self._data, dtype, count, self.at)
        self.at += count * dtype.itemsize
        return taken

    def _numbers(self, count: int, code: str) -> np.ndarray:
        return self._taken(count, np.dtype(self._order + code))

    def ints(self, count: int) -> IntArray:
        """Numbers of 4 bytes."""
        return self._numbers(count, "i4").astype(np.int64)

    def sizes(self, count: int) -> IntArray:
        """Numbers >= 0 of 4 or 8 bytes."""
        return _checked_sizes(self._numbers(count, f"i{self._size}").astype(np.int64), self._section)

    def floats(self, count: int) -> FloatArray:
        """Numbers of 8 bytes."""
        return self._numbers(count, "f8").astype(np.float64)

    def rest(self) -> np.ndarray:
        """Numbers of 4 bytes up to the end of the file, which are not taken."""
        return np.frombuffer(self._data, np.dtype(self._order + "i4"), (len(self._data) - self.at) // 4, self.at)

    def records(self, count: int, fields: list[tuple[str, str, int]]) -> np.ndarray:
        """Records of fields: names, types without byte order, and lengths."""
        own = [(name, self._order + code, (length,)) for name, code, length in fields]
        return self._taken(count, np.dtype(own), "entries")


def _checked_sizes(values: IntArray, section: str) -> IntArray:
    if (values < 0).any():
        raise Unreadable(f"{section} has the number {values.min()}, expected one >= 0")
    return values


def line_counts(text: bytes) -> IntArray:
    """How many words each line has, of those that have some."""
    codes = np.frombuffer(text, dtype=np.uint8)
    begins = codes > ord(" ")
    begins[1:] &= codes[:-1] <= ord(" ")
    words = np.flatnonzero(begins)
    upto = np.searchsorted(words, np.flatnonzero(codes == ord("\n")))
    counts = np.diff(np.concatenate([[0], upto, [len(words)]]))
    return np.asarray(counts[counts > 0])


def run_of(numbers: IntArray, at: int, length: int, alike: slice) -> int:
    """How many records of that length follow each other from a place on that are alike in some of their numbers.

    alike: those numbers of a record. Windows that double keep many short runs cheap.
    """
    count, window, most = 1, 64, (len(numbers) - at) // length
    wanted = numbers[at : at + length][alike]
    while count < most:
        some = min(window, most - count)
        begin = at + count * length
        unlike = (numbers[begin : begin + some * length].reshape(some, length)[:, alike] != wanted).any(axis=1)
        if unlike.any():
            return count + int(unlike.argmax())
        count += some
        window *= 2
    return min(count, most)
