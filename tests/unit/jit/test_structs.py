"""Structs: declared fields and shapes, numbers that kernels and Python both write."""

from __future__ import annotations

import copy
import math
import pickle

import numpy as np
import pytest

from lcpflex.jit.kernel import FloatArray, IntArray, kernel
from lcpflex.jit.struct import allocate, array, copy_parts, parts_of, struct, with_parts


@struct
class Inner:
    """With a number behind its array."""

    x: FloatArray = array("n")
    weight: float


@struct
class Outer:
    """Numbers, arrays and another struct, in any order."""

    count: int
    inner: Inner
    grid: FloatArray = array(2, "n")
    time: float
    keys: IntArray = array("m")


def example(n: int = 3, m: int = 2) -> Outer:
    return allocate(Outer, {"n": n, "m": m}, inner=allocate(Inner, {"n": n}), time=0.5)


@kernel
def step(outer: Outer, h: float) -> int:
    outer.time += h
    outer.count = outer.count + 2
    outer.inner.weight = outer.time * outer.inner.x[1]
    outer.grid[1, 0] = outer.inner.weight
    return outer.count


@kernel
def repeat(outer: Outer, h: float, times: int) -> float:
    total = 0.0
    for _ in range(times):
        step(outer, h)
        total += outer.time
    return total


@pytest.mark.parametrize("compiled", [True, False])
def test_numbers_are_read_and_written_on_both_sides(compiled: bool) -> None:
    outer = example()
    outer.inner.x[1] = 4.0
    run = step if compiled else step.py_func
    assert run(outer, 0.25) == 2
    assert (outer.time, outer.count, outer.inner.weight) == (0.75, 2, 3.0)
    assert outer.grid[1, 0] == 3.0
    outer.count, outer.time = 40, math.inf
    assert run(outer, 1.0) == 42
    assert outer.time == math.inf


def test_a_loop_sees_every_write() -> None:
    outer = example()
    assert repeat(outer, 1.0, 4) == 1.5 + 2.5 + 3.5 + 4.5


def test_types_of_numbers() -> None:
    outer = example()
    assert type(outer.count) is int
    assert type(outer.time) is float
    outer.count = 2**60
    assert step(outer, 0.0) == 2**60 + 2


def test_what_is_missing_or_unknown_is_named() -> None:
    with pytest.raises(TypeError, match="weight"):
        Inner(y=np.zeros(1))  # type: ignore[call-arg]
    with pytest.raises(KeyError, match="n"):
        allocate(Inner, {})


@pytest.mark.parametrize("again", [copy.deepcopy, lambda value: pickle.loads(pickle.dumps(value))])
def test_copies_have_memory_of_their_own(again) -> None:
    outer = example()
    outer.keys[:] = 7, 8
    other = again(outer)
    assert other.time == 0.5
    step(other, 1.0)
    assert (outer.time, other.time) == (0.5, 1.5)
    np.testing.assert_array_equal(other.keys, [7, 8])


def test_content_goes_into_a_larger_one() -> None:
    small, large = example(), example(5, 4)
    small.count, small.inner.weight = 3, 2.5
    small.grid[:] = np.arange(6).reshape(2, 3)
    large.keys[:] = 9
    copy_parts(small, large)
    assert (large.count, large.inner.weight, large.time) == (3, 2.5, 0.5)
    np.testing.assert_array_equal(large.grid, [[0, 1, 2, 0, 0], [3, 4, 5, 0, 0]])
    np.testing.assert_array_equal(large.keys, [0, 0, 9, 9])
    assert list(parts_of(small)) == ["count", "time", "inner", "grid", "keys"]


def test_fields_may_be_called_as_they_like() -> None:
    @struct
    class Named:
        parts: float
        label: int
        memory: FloatArray = array(2)

    named = allocate(Named, {}, parts=2.0, label=3)
    assert list(parts_of(named)) == ["parts", "label", "memory"]
    assert (with_parts(named, {"parts": 4.0}).parts, named.parts) == (4.0, 2.0)
