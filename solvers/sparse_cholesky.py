"""Sparse Cholesky factor of a positive semidefinite matrix of a fixed pattern: ordered once, factorised in each step.

G = L L^T row by row ("up-looking"), L stored by rows with columns ascending. A pivot that is nothing but rounding marks
a dependent row, whose unknown is 0, as in :mod:`lcpflex.solvers.semidefinite`; in natural order all sums are those of
the dense factor, in the same order.

Vectors are in the order of the factor: x[i] belongs to unknown ``order[i]``.

Source: Davis, Direct Methods for Sparse Linear Systems, 2006.
"""

from __future__ import annotations

import math

from lcpflex.jit.kernel import FloatArray, IntArray, kernel
from lcpflex.jit.struct import allocate, array, struct
from lcpflex.solvers.elimination import Pattern
from lcpflex.solvers.semidefinite import REDUNDANT

__all__ = [
    "SparseFactor",
    "add_path",
    "factorise_sparse",
    "forget_path",
    "reduce_row",
    "solve_on_path",
    "solve_sparse",
    "sparse_factor",
]


WEAK = 1e-6  # a pivot below this part of its row's diagonal


@struct
class SparseFactor:
    """L of a matrix of n unknowns, and the pattern that it has (:class:`lcpflex.solvers.elimination.Pattern`)."""

    order: IntArray  # (n,)
    parent: IntArray  # (n,)
    start: IntArray  # (n + 1,)
    column: IntArray  # (entries,)
    below: IntArray  # (n + 1,)
    below_row: IntArray  # (entries - n,)
    below_entry: IntArray  # (entries - n,)
    value: FloatArray = array("entries")  # of the lower triangle of G, then of L
    own: FloatArray = array("n")  # diagonal of G; 0 of rows that are not to be looked at
    row: FloatArray = array("n")  # scratch, 0 between calls
    path: IntArray = array("n")  # the last n_path entries: rows on a path, each before its parent
    on_path: IntArray = array("n")  # 1 for those rows
    n_path: int
    dependent: int  # dependent rows of the last factor
    weak: int  # rows of small pivots, those included: answers are then to be checked


def sparse_factor(pattern: Pattern) -> SparseFactor:
    """Memory for the factor of a matrix of this pattern."""
    sizes = {"n": len(pattern.order), "entries": len(pattern.column)}
    return allocate(SparseFactor, sizes, **pattern._asdict())


@kernel
def reduce_row(factor: SparseFactor, i: int) -> float:
    """Row i of L but for its diagonal, those before it being known; returns the square of that."""
    start, column, value, row = factor.start, factor.column, factor.value, factor.row
    first, last = start[i], start[i + 1] - 1
    total = value[last]
    for e in range(first, last):
        j = column[e]
        entry = value[e]
        end = start[j + 1] - 1
        for f in range(start[j], end):
            entry -= row[column[f]] * value[f]
        entry = entry / value[end] if value[end] > 0.0 else 0.0
        row[j] = entry
        value[e] = entry
        total -= entry * entry
    for e in range(first, last):
        row[column[e]] = 0.0
    return float(total)


@kernel
def factorise_sparse(factor: SparseFactor) -> None:
    """L in place of the entries of G's lower triangle in ``factor.value``."""
    start, value, diagonal = factor.start, factor.value, factor.own
    dependent, weak = 0, 0
    for i in range(len(diagonal)):
        last = start[i + 1] - 1
        own = value[last]
        total = reduce_row(factor, i)
        diagonal[i] = own
        if total > REDUNDANT * own:
            value[last] = math.sqrt(total)
        else:
            value[last] = 0.0
            dependent += 1
        if not total > WEAK * own:
            weak += 1
    factor.dependent = dependent
    factor.weak = weak


@kernel
def solve_sparse(factor: SparseFactor, x: FloatArray) -> None:
    """x <- G^-1 x in place; 0 for dependent rows."""
    start, column, value = factor.start, factor.column, factor.value
    below, below_row, below_entry = factor.below, factor.below_row, factor.below_entry
    n = len(x)
    for i in range(n):
        total = x[i]
        last = start[i + 1] - 1
        for e in range(start[i], last):
            total -= value[e] * x[column[e]]
        x[i] = total / value[last] if value[last] > 0.0 else 0.0
    for i in range(n - 1, -1, -1):
        total = x[i]
        for c in range(below[i], below[i + 1]):
            total -= value[below_entry[c]] * x[below_row[c]]
        own = value[start[i + 1] - 1]
        x[i] = total / own if own > 0.0 else 0.0


@kernel
def forget_path(factor: SparseFactor) -> None:
    """Begin with no path."""
    n = len(factor.path)
    for k in range(n - factor.n_path, n):
        factor.on_path[factor.path[k]] = 0
    factor.n_path = 0


@kernel
def add_path(factor: SparseFactor, i: int) -> None:
    """Add row i and those that it leads to in the elimination tree: where the answer to a load on row i begins.

    Rows added later come before those added earlier, so that each stands before its parent.
    """
    parent, path, on_path = factor.parent, factor.path, factor.on_path
    count = 0
    j = i
    while j >= 0 and on_path[j] == 0:
        on_path[j] = 1
        count += 1
        j = parent[j]
    at = len(path) - factor.n_path - count
    j = i
    for k in range(at, at + count):
        path[k] = j
        j = parent[j]
    factor.n_path += count


@kernel
def solve_on_path(factor: SparseFactor, x: FloatArray) -> None:
    """The rows on the path of G^-1 x in place; x is 0 but on the path, and stays it."""
    start, column, value, path = factor.start, factor.column, factor.value, factor.path
    below, below_row, below_entry = factor.below, factor.below_row, factor.below_entry
    n = len(path)
    first = n - factor.n_path
    for k in range(first, n):
        i = path[k]
        total = x[i]
        last = start[i + 1] - 1
        for e in range(start[i], last):
            total -= value[e] * x[column[e]]
        x[i] = total / value[last] if value[last] > 0.0 else 0.0
    for k in range(n - 1, first - 1, -1):
        i = path[k]
        total = x[i]
        for c in range(below[i], below[i + 1]):
            total -= value[below_entry[c]] * x[below_row[c]]
        own = value[start[i + 1] - 1]
        x[i] = total / own if own > 0.0 else 0.0
