"""Packed named tuples: kernels and Python see the same arrays."""

from __future__ import annotations

from typing import NamedTuple

import numba
import numpy as np
import pytest

from lcpflex.jit.kernel import FloatArray, IntArray, kernel
from lcpflex.jit.struct import _type_of, pack


class Inner(NamedTuple):
    x: FloatArray
    n: IntArray


class Outer(NamedTuple):
    inner: Inner
    grid: FloatArray
    nothing: FloatArray


@kernel
def weigh(inner: Inner, i: int) -> float:
    return inner.x[i] * inner.n[0]


@kernel
def write(outer: Outer, i: int) -> int:
    outer.grid[1, i] += weigh(outer.inner, i)
    return len(outer.nothing)


def example() -> Outer:
    return Outer(Inner(np.array([1.0, 2.5]), np.array([4])), np.zeros((2, 3))[:, :2], np.zeros(0))


@pytest.mark.parametrize("packed", [False, True])
def test_kernels_read_and_write_the_arrays_themselves(packed: bool) -> None:
    values = example()
    given = pack(values) if packed else values
    assert write(given, 1) == 0
    np.testing.assert_array_equal(values.grid, [[0.0, 0.0], [0.0, 10.0]])
    assert given.inner.x is values.inner.x


def test_packing_twice_changes_nothing() -> None:
    packed = pack(example())
    assert pack(packed) is packed
    assert pack(packed.inner) is packed.inner


@pytest.mark.parametrize(
    "array",
    [
        np.zeros(3),
        np.zeros(0),
        np.zeros((2, 3)),
        np.zeros((2, 3)).T,
        np.zeros((4, 4))[::2, 1:],
        np.zeros((1, 3)).T,
        np.zeros((2, 3, 4)),
        np.zeros(3, dtype=np.int64),
        np.zeros((2, 2), dtype=np.int8),
        np.frombuffer(b"12345678"),
    ],
)
def test_types_are_those_of_numba(array: np.ndarray) -> None:
    """Asked for without numba's own look at each array, which takes thirty times as long."""
    assert _type_of(array) == numba.typeof(array)
