"""Small dense problems are computed on one thread, and the number of threads is that of before again."""

from __future__ import annotations

import threading
from collections.abc import Iterator

import numpy as np
import pytest

from lcpflex.basics import blas
from lcpflex.basics.blas import SMALL, one_thread


@pytest.fixture
def threads() -> Iterator[list[int]]:
    """The libraries of numpy and scipy set to three threads each."""
    if not blas._libraries():
        pytest.skip("numpy and scipy are linked with another BLAS")
    before = [read() for read, _ in blas._libraries()]
    for _, write in blas._libraries():
        write(3)
    yield now()
    for (_, write), number in zip(blas._libraries(), before, strict=True):
        write(number)


def now() -> list[int]:
    """Threads of each library."""
    return [read() for read, _ in blas._libraries()]


def test_small_problems(threads: list[int]) -> None:
    """One inside the other, and where something is raised."""
    one = [1] * len(threads)
    with one_thread(10):
        assert now() == one
        with one_thread(SMALL):
            assert now() == one
        assert now() == one
    assert now() == threads
    with pytest.raises(np.linalg.LinAlgError), one_thread(2):
        np.linalg.cholesky(-np.eye(2))
    assert now() == threads


def test_large_problems(threads: list[int]) -> None:
    """They have all threads, unless a small one is computed at the same time."""
    with one_thread(SMALL + 1):
        assert now() == threads
        with one_thread(3):
            assert now() == [1] * len(threads)
        assert now() == threads


def test_several_threads(threads: list[int]) -> None:
    """The number of before comes back when the last one has left, whoever came first."""
    inside, left = threading.Barrier(2), threading.Event()

    def first() -> None:
        with one_thread(5):
            inside.wait()
        left.set()

    other = threading.Thread(target=first)
    other.start()
    with one_thread(5):
        inside.wait()
        left.wait()
        assert now() == [1] * len(threads)
    other.join()
    assert now() == threads


def test_another_blas(monkeypatch: pytest.MonkeyPatch) -> None:
    """Is left alone: files that are not there, and libraries without such functions."""
    monkeypatch.setattr(blas, "LINKED", ("math", "sys", "no_such_module", "json"))
    blas._libraries.cache_clear()
    try:
        assert blas._libraries() == []
        with one_thread(5):
            assert np.linalg.eigvalsh(np.eye(2)).tolist() == [1.0, 1.0]
    finally:
        blas._libraries.cache_clear()
