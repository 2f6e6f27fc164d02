"""Symbolic part of a sparse Cholesky factor: the order of elimination, and the entries that the factor has.

Unknowns come in blocks, such as the rows of a joint, all of which share their neighbours. The natural order is kept
where no other has fewer entries: of a chain or a tree declared from link to link, none has.

Source: Davis, Direct Methods for Sparse Linear Systems, 2006 (elimination tree, row subtrees).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from lcpflex.basics import libs
from lcpflex.jit.kernel import FloatArray, IntArray

__all__ = ["Pattern", "sparse_pattern"]

NO_PARENT = -1


class Pattern(NamedTuple):
    """The lower triangular factor of a symmetric matrix of n unknowns: row i belongs to unknown ``order[i]``."""

    order: IntArray  # (n,)
    parent: IntArray  # (n,) of each row in the elimination tree, -1: none
    start: IntArray  # (n + 1,) entries of each row, the diagonal last
    column: IntArray  # (entries,) ascending in each row
    below: IntArray  # (n + 1,) of each column, its entries below the diagonal in the two following arrays
    below_row: IntArray  # (entries - n,) ascending in each column
    below_entry: IntArray  # (entries - n,) where they are among all entries


class _Tree(NamedTuple):
    """Of blocks in an order of elimination: the blocks that each row has entries in, and the elimination tree."""

    order: list[int]
    rows: list[list[int]]  # of each place, the places before it, ascending
    parent: list[int]


def sparse_pattern(neighbours: Sequence[set[int]], first: Sequence[int]) -> Pattern:
    """The pattern of a matrix of blocks.

    Parameters
    ----------
    neighbours
        Of each block, those that it shares an entry with.
    first
        The first unknown of each block, and at last their number; no block is empty.
    """
    sizes: IntArray = np.diff(np.asarray(first))
    tree = _eliminated(neighbours, range(len(neighbours)))
    order = _order(neighbours, tree, sizes)
    if order != tree.order:
        tree = _eliminated(neighbours, order)
    return _by_unknowns(tree, first, sizes)


def _order(neighbours: Sequence[set[int]], natural: _Tree, sizes: IntArray) -> list[int]:
    """Parts without connection one behind the other: in natural order, or by degree where that has fewer entries."""
    part = _parts(natural)
    place = np.arange(len(part))
    if sum(map(len, natural.rows)) > sum(map(len, neighbours)) // 2:
        reduced = _eliminated(neighbours, _minimum_degree(neighbours))
        by_degree = np.empty_like(place)
        by_degree[reduced.order] = place
        entries = [np.bincount(part, _entries(tree, sizes), len(part)) for tree in (natural, reduced)]
        place = np.where((entries[1] < entries[0])[part], by_degree, place)
    return [int(block) for block in np.lexsort([place, part])]


def _eliminated(neighbours: Sequence[set[int]], order: Sequence[int]) -> _Tree:
    """Entries of each row: the paths in the elimination tree that begin at its neighbours."""
    n = len(order)
    place = [0] * n
    for i, block in enumerate(order):
        place[block] = i
    parent, seen = [NO_PARENT] * n, [NO_PARENT] * n
    rows = []
    for i, block in enumerate(order):
        seen[i] = i
        row = []
        for j in (place[other] for other in neighbours[block]):
            while j < i and seen[j] != i:
                row.append(j)
                seen[j] = i
                if parent[j] == NO_PARENT:
                    parent[j] = i
                j = parent[j]
        rows.append(sorted(row))
    return _Tree(list(order), rows, parent)


def _minimum_degree(neighbours: Sequence[set[int]]) -> list[int]:
    """The order that SuperLU eliminates a matrix of this pattern in, one that needs no pivoting."""
    columns = [[block, *sorted(others)] for block, others in enumerate(neighbours)]
    start = np.cumsum([0, *map(len, columns)])
    values = np.concatenate([[len(rows), *[-0.5] * (len(rows) - 1)] for rows in columns])
    n = len(columns)
    matrix = libs.sparse.csc_array((values, np.concatenate(columns), start), shape=(n, n))
    matrix.sort_indices()
    factors = libs.splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    return [int(block) for block in np.argsort(factors.perm_c)]


def _parts(natural: _Tree) -> IntArray:
    """Of each block, in natural order, the last one of its part: the root of its tree."""
    root = np.arange(len(natural.parent))
    for i in reversed(range(len(root))):
        if natural.parent[i] != NO_PARENT:
            root[i] = root[natural.parent[i]]
    return root


def _entries(tree: _Tree, sizes: IntArray) -> FloatArray:
    """Entries of the rows of each block."""
    own = sizes[tree.order]
    entries = np.empty(len(own))
    entries[tree.order] = [own[i] * own[row].sum() + own[i] * (own[i] + 1) // 2 for i, row in enumerate(tree.rows)]
    return entries


def _by_unknowns(tree: _Tree, first: Sequence[int], sizes: IntArray) -> Pattern:
    """The pattern in unknowns: the rows of a block follow each other."""
    at = np.cumsum([0, *sizes[tree.order]]).tolist()
    order: list[int] = []
    parent: list[int] = []
    lengths: list[int] = []
    columns: list[int] = []
    for i, block in enumerate(tree.order):
        before = [k for j in tree.rows[i] for k in range(at[j], at[j + 1])]
        order += range(first[block], first[block + 1])
        for k in range(at[i], at[i + 1]):
            columns += before
            columns += range(at[i], k + 1)
            lengths.append(len(before) + k + 1 - at[i])
        up = tree.parent[i]
        parent += [*range(at[i] + 1, at[i + 1]), NO_PARENT if up == NO_PARENT else at[up]]
    start = np.cumsum([0, *lengths])
    column = np.asarray(columns, dtype=np.int64)
    row = np.repeat(np.arange(len(order)), lengths)
    entry = np.flatnonzero(column < row)
    entry = entry[np.argsort(column[entry], kind="stable")]
    below = np.cumsum([0, *np.bincount(column[entry], minlength=len(order))])
    arrays = (order, parent, start, column, below, row[entry], entry)
    return Pattern(*(np.array(values, dtype=np.int64) for values in arrays))
