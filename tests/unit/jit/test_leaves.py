"""Leaves that are chosen by the length of a tuple, and kernels that are copied into their callers."""

from __future__ import annotations

import pytest

from lcpflex.jit.kernel import Kernel, kernel
from lcpflex.jit.keys import _own, content
from lcpflex.jit.leaf import leaf
from lcpflex.solvers.contact.algebra import less
from lcpflex.solvers.contact.sweeping import sweep

Vector = tuple[float, ...]


@leaf
def total(a: Vector) -> float:
    """Of all numbers."""
    raise NotImplementedError


@total.of(2)
@kernel(inline=True)
def total_of_two(a: Vector) -> float:
    """Two."""
    return a[0] + a[1]


@total.of(3)
@kernel(inline=True)
def total_of_three(a: Vector) -> float:
    """Three."""
    return a[0] + a[1] + a[2]


@kernel
def twice(a: Vector) -> float:
    """The same loop for both."""
    return 2.0 * total(a)


def test_the_length_of_a_tuple_chooses() -> None:
    """In Python and in kernels."""
    assert (total((1.0, 2.0)), total((1.0, 2.0, 4.0))) == (3.0, 7.0)
    assert (twice((1.0, 2.0)), twice((1.0, 2.0, 4.0))) == (6.0, 14.0)


def test_kernels_of_all_lengths_are_in_the_key_of_a_caller(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its arguments do not tell which tuples it makes: an edit of either kernel must be seen."""
    source = getattr(sweep, "py_func", sweep)
    before = content(source)
    assert {"#2", "#3"} <= set(less.of_kinds(frozenset()))
    for length, other in (("#2", "#3"), ("#3", "#2")):
        with monkeypatch.context() as patch:
            patch.setitem(less.kernels, length, less.kernels[other])
            content.cache_clear()
            _own.cache_clear()
            assert content(source) != before
    content.cache_clear()
    _own.cache_clear()
    assert content(source) == before


def test_how_a_kernel_is_called_is_in_the_key_of_its_caller(monkeypatch: pytest.MonkeyPatch) -> None:
    """Whether its code is copied changes the caller's."""
    source, called = getattr(sweep, "py_func", sweep), less.kernels["#2"]
    if not isinstance(called, Kernel):
        pytest.skip("kernels are plain functions here")
    before = content(source)
    monkeypatch.setattr(called, "inline", False)
    content.cache_clear()
    _own.cache_clear()
    changed = content(source)
    content.cache_clear()
    _own.cache_clear()
    assert changed != before
