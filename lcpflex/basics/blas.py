"""Small dense problems on one thread: the threads of OpenBLAS wait for each other longer than they compute.

To add a place: ``with one_thread(n):`` around dense eigenproblems and decompositions of n unknowns.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from importlib import import_module
from threading import Lock

__all__ = ["one_thread"]

# Compiled modules that are linked with OpenBLAS, numpy's and scipy's own copies of it among them.
LINKED = ("numpy.linalg._umath_linalg", "scipy.linalg._flapack")
SMALL = 1200  # unknowns: two threads take five times as long for them where others compute, and gain nothing elsewhere
NAMES = [f"{prefix}openblas_{{}}_num_threads{suffix}" for prefix in ("scipy_", "") for suffix in ("64_", "")]

_lock = Lock()
_inside = 0  # callers in ``one_thread``
_before: list[int] = []  # threads of each library outside of it


@contextmanager
def one_thread(n: int) -> Iterator[None]:
    """OpenBLAS computes on one thread inside if ``n`` unknowns are few; any other BLAS is left alone.

    The number belongs to the process: it holds for its other threads, too, and is that of before when the last caller
    has left. Results of small problems do not depend on the number of processors.
    """
    global _inside
    if n > SMALL:
        yield
        return
    with _lock:
        _inside += 1
        if _inside == 1:
            _before[:] = [read() for read, _ in _libraries()]
            for _, write in _libraries():
                write(1)
    try:
        yield
    finally:
        with _lock:
            _inside -= 1
            if _inside == 0:
                for (_, write), threads in zip(_libraries(), _before, strict=True):
                    write(threads)


@cache
def _libraries() -> list[tuple[Callable[[], int], Callable[[int], None]]]:
    """What reads and what writes the number of threads of each OpenBLAS."""
    found: list[tuple[Callable[[], int], Callable[[int], None]]] = []
    for module in LINKED:
        try:  # the system looks in what the file is linked with, too
            library = ctypes.CDLL(str(import_module(module).__file__))
        except (ImportError, AttributeError, OSError):
            continue
        for name in NAMES:
            read, write = (getattr(library, name.format(verb), None) for verb in ("get", "set"))
            if read is not None and write is not None:
                write.restype = None
                found.append((read, write))
                break
    return found
