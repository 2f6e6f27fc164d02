"""Numbers in texts, and numbers that files give to nodes and elements: any, with gaps, in any order."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np

from lcpflex.bodies.fem.files.found import Unreadable
from lcpflex.errors import shown
from lcpflex.jit.kernel import FloatArray, IntArray

__all__ = ["Numbering", "floats_of", "integers_of", "joined"]

SPARSE = 4  # numbers up to so many times their count are looked up in a table
EXACT = 2.0**53  # up to which floats hold whole numbers


def floats_of(text: bytes, where: str) -> FloatArray:
    """The numbers of a text, with white space between them; raises Unreadable for anything else in it."""
    return _parsed(text, np.float64, where)


def integers_of(text: bytes, where: str) -> IntArray:
    """The whole numbers of a text, with white space between them; raises Unreadable for anything else in it."""
    return _parsed(text, np.int64, where)


def _parsed(text: bytes, dtype: Any, where: str) -> Any:
    if not text.strip():
        return np.zeros(0, dtype=dtype)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            return np.fromstring(text, dtype=dtype, sep=" ")
    except (ValueError, DeprecationWarning):
        kind = "whole numbers" if dtype is np.int64 else "numbers"
        raise Unreadable(f"{where} holds {_culprit(text, dtype)}, expected {kind} only") from None


def _culprit(text: bytes, dtype: Any) -> str:
    """The first word that is no number, for a message."""
    for word in text.split():
        try:
            int(word) if dtype is np.int64 else float(word)
        except ValueError:
            return shown(word.decode(errors="replace"))
    return "something else"


class Numbering:
    """Where each number of a list stands in it.

    numbers: of nodes or elements, none twice; raises Unreadable otherwise. what: they are, for messages.
    """

    def __init__(self, numbers: IntArray, what: str) -> None:
        self.what, self.count, self._numbers = what, len(numbers), numbers
        self._table: IntArray | None = None
        self._order: IntArray | None = None
        low, high = (int(numbers.min()), int(numbers.max())) if len(numbers) else (0, -1)
        if low < 0:
            raise Unreadable(f"{what} {low}, expected numbers from 0")
        self._low, self._high = low, high
        if len(numbers) and high - low < SPARSE * len(numbers):
            self._table = np.full(high - low + 1, -1, dtype=np.int64)
            self._table[numbers - low] = np.arange(len(numbers))
            if int((self._table >= 0).sum()) < len(numbers):
                self._refuse_twins(np.sort(numbers))
            return
        self._order = np.argsort(numbers, kind="stable")
        self._sorted = numbers[self._order]
        if (self._sorted[1:] == self._sorted[:-1]).any():
            self._refuse_twins(self._sorted)

    def _refuse_twins(self, rising: IntArray) -> None:
        twin = rising[1:][rising[1:] == rising[:-1]][0]
        raise Unreadable(f"{self.what} {twin} comes twice, expected a number of its own for each")

    def places(self, numbers: IntArray) -> IntArray:
        """Places in the list, -1 where it has no such number."""
        if self._table is not None:
            inside = (numbers >= self._low) & (numbers <= self._high)
            return np.where(inside, self._table[np.where(inside, numbers - self._low, 0)], -1)
        if self._order is None or not self.count:
            return np.full(numbers.shape, -1, dtype=np.int64)
        at = np.minimum(np.searchsorted(self._sorted, numbers), self.count - 1)
        return np.where(self._sorted[at] == numbers, self._order[at], -1)

    def within(self, first: int, last: int, step: int) -> IntArray:
        """Places of the numbers first, first + step, ... up to last that are there; raises Unreadable for none."""
        if self._order is None:
            self._order = np.argsort(self._numbers, kind="stable")
            self._sorted = self._numbers[self._order]
        begin, end = np.searchsorted(self._sorted, first), np.searchsorted(self._sorted, last, side="right")
        found = self._order[begin:end][(self._sorted[begin:end] - first) % step == 0]
        if not len(found):
            raise Unreadable(f"a set has {self.what}s {first} to {last} by {step}, expected some that are in the file")
        return found

    def known(self, numbers: IntArray, owner: str) -> IntArray:
        """Places in the list; raises Unreadable for a number that is not there. owner: of the numbers in messages."""
        places = self.places(numbers)
        if (places < 0).any():
            missing = numbers[places < 0].flat[0]
            raise Unreadable(f"{owner}: {self.what} {missing} is not in the file, expected numbers that are there")
        return places


def joined(parts: list[IntArray]) -> IntArray:
    """The arrays one after another; none gives an empty one."""
    return np.concatenate(parts) if parts else np.zeros(0, dtype=np.int64)
