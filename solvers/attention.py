"""Ctrl-C while a kernel works: a number in its own memory that the signal sets, asked for by counted work.

Python runs the handler of a signal between two of its own instructions, and a kernel is one. But what the system calls
first also writes a byte to a file, if it is told which (``signal.set_wakeup_fd``); that file is the memory of the
integers that a solver works with, whose last one is 0 else. A kernel asks for it once a pivot, a row that it
eliminates or a sweep, and returns; Python then runs the handler, which raises KeyboardInterrupt. Where a handler
returns, the solve is repeated from its beginning: nothing that it finds depends on whether somebody called.
"""

from __future__ import annotations

import mmap
import os
import signal
import tempfile
import threading
from collections.abc import Callable
from typing import TypeVar

import numpy as np

from lcpflex.jit.kernel import IntArray, kernel

__all__ = ["Ear", "is_called", "listening"]

LARGE = 150  # unknowns from which a solve may last for a second; below, to listen would be a part of its time
BEHIND = 4096  # bytes of the file behind the integers: signals after the first one write there

Found = TypeVar("Found")


@kernel
def is_called(numbers: IntArray) -> bool:
    """Whether a signal has come: the last of a solver's integers, which is 0 else."""
    return bool(numbers[len(numbers) - 1] != 0)


class Ear:
    """The integers of a solver, in memory that a signal reaches where the problem is large.

    numbers: zero at its end; replaced by ``self.numbers``, of the same content. Only the main thread is called, and not
    where something else listens already, as the loop of asyncio does.
    """

    def __init__(self, numbers: IntArray) -> None:
        self.numbers, self._file = numbers, -1
        if threading.current_thread() is threading.main_thread():
            self._share()

    def __del__(self) -> None:
        if self._file >= 0:
            os.close(self._file)

    def _share(self) -> None:
        """Move the numbers to a file in memory."""
        kept = self.numbers
        try:
            self._file = _memory(kept.nbytes + BEHIND)
            shared = np.frombuffer(mmap.mmap(self._file, kept.nbytes + BEHIND), np.int64, len(kept))
        except (OSError, ValueError):  # a system that has no such file answers later
            return
        shared[:] = kept
        self.numbers = shared

    def __call__(self, solve: Callable[[], Found]) -> Found:
        """What ``solve`` finds, from its beginning each time; it may end early once a signal has come."""
        if self._file < 0 or self.numbers.flags.owndata:
            return solve()
        before = signal.set_wakeup_fd(self._file, warn_on_full_buffer=False)
        try:
            if before != -1:
                signal.set_wakeup_fd(before)
                return solve()
            while True:
                self.numbers[-1] = 0
                os.lseek(self._file, self.numbers.nbytes - self.numbers.itemsize, os.SEEK_SET)
                found = solve()
                if not is_called(self.numbers):
                    return found
        finally:
            signal.set_wakeup_fd(before)


def listening(numbers: IntArray, size: int) -> tuple[IntArray, Ear | None]:
    """The integers that a solver of ``size`` unknowns is to work with, and the ear that they are of, if it is large."""
    if size < LARGE:
        return numbers, None
    ear = Ear(numbers)
    return ear.numbers, ear


def _memory(size: int) -> int:
    """A file of that size [bytes] in memory, or else on the disc, which does not block who writes."""
    if hasattr(os, "memfd_create"):
        file = os.memfd_create("lcpflex")
    else:
        with tempfile.TemporaryFile() as temporary:
            file = os.dup(temporary.fileno())
    os.ftruncate(file, size)
    os.set_blocking(file, False)
    return file
