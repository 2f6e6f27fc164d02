"""Which contacts act on which: the Delassus operator in blocks of two contacts, those that are zero left out.

Block (k, c) holds G_NN, G_NT, G_TN, G_TT of the velocities of contact k and the forces of contact c, in units of the
contacts (:mod:`lcpflex.solvers.balance`). Where a contact touches two bodies and a body few contacts, their number is
linear in the contacts, and so is all that is done with them: the residual, a sweep, the search for independent parts.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from lcpflex.basics import libs
from lcpflex.jit.kernel import FloatArray, IntArray, kernel
from lcpflex.solvers.certificate import measured, worse

__all__ = ["MOST_BLOCKS", "ConeBlocks", "Coupling", "coupling_of", "grouped", "tangents"]

# Blocks that are made of a factor at most, 160 MB: a body that touches thousands of contacts couples each with all.
MOST_BLOCKS = 4_000_000


@dataclass(frozen=True, slots=True, eq=False)
class Coupling:
    """Blocks of contact k: first[k] to first[k + 1], with contact other[e] and entries block[e] = (NN, NT, TN, TT).

    own (n, 4): the block of each contact with itself, zero if there is none. free (m,), friction (n,): of the contact
    problem; tangent_of (n,): row of the tangent, -1 without friction.
    """

    first: IntArray
    other: IntArray
    block: FloatArray
    own: FloatArray
    free: FloatArray
    friction: FloatArray
    tangent_of: IntArray

    def weighed(self, z: FloatArray, w: FloatArray) -> tuple[float, float, float]:
        """How wrong z is as :func:`weigh_contacts` tells; w = M z + q of the LCP is written unless ``w`` is empty."""
        rows = (self.first, self.other, self.block)
        return weigh_contacts(*rows, self.free, self.friction, self.tangent_of, z, w, z[:0])

    def missed(self, z: FloatArray) -> FloatArray:
        """(n,) what z leaves of the own load of each contact."""
        strict = np.empty(len(self.friction))
        rows = (self.first, self.other, self.block)
        weigh_contacts(*rows, self.free, self.friction, self.tangent_of, z, z[:0], strict)
        return strict

    def parts(self) -> tuple[int, IntArray]:
        """How many independent parts there are, and (n,) the number of that of each contact, in order of the first."""
        label = np.empty(len(self.friction), dtype=np.int64)
        return label_parts(self.first, self.other, label), label


def tangents(friction: FloatArray) -> IntArray:
    """(n,) row of the tangent of each contact, -1 without friction."""
    n, rubs = len(friction), friction > 0.0
    return np.where(rubs, n - 1 + np.cumsum(rubs), -1)


def coupling_of(delassus: Any, free: FloatArray, friction: FloatArray, units: FloatArray) -> Coupling:
    """The blocks of a Delassus matrix, dense or CSR, times the units of both contacts.

    free (m,) in these units; friction (n,); units (n,).
    """
    n, tangent_of = len(friction), tangents(friction)
    first = np.zeros(n + 1, dtype=np.int64)
    mark, contact_of = np.full(n, -1, dtype=np.int64), np.empty(len(free), dtype=np.int64)
    contact_of[:n] = np.arange(n)
    contact_of[n:] = np.flatnonzero(tangent_of >= 0)
    if hasattr(delassus, "indptr"):
        start, place, value = delassus.indptr.astype(np.int64), delassus.indices.astype(np.int64), delassus.data
    else:
        start, place, value = compressed(delassus)
    rows = (start, place, value, tangent_of, contact_of)
    count = count_blocks(*rows, mark, first)
    other, block, own = np.empty(count, dtype=np.int64), np.zeros((count, 4)), np.zeros((n, 4))
    fill_blocks(*rows, units, mark, first, other, block, own)
    return Coupling(first, other, block, own, free, friction, tangent_of)


def compressed(matrix: FloatArray) -> tuple[IntArray, IntArray, FloatArray]:
    """Starts of rows, places and values of the entries that are not zero."""
    filled = matrix != 0.0
    start = np.zeros(len(matrix) + 1, dtype=np.int64)
    np.cumsum(np.count_nonzero(filled, axis=1), out=start[1:])
    flat = np.flatnonzero(filled)
    return start, flat % max(len(matrix), 1), matrix.ravel()[flat]


@kernel
def count_blocks(
    start: IntArray,
    place: IntArray,
    value: FloatArray,
    tangent_of: IntArray,
    contact_of: IntArray,
    mark: IntArray,
    first: IntArray,
) -> int:
    """Blocks up to each contact, first (n + 1,), from the compressed rows of a matrix; returns how many there are.

    mark (n,): -1 everywhere, before and afterwards.
    """
    n, count = len(tangent_of), 0
    for k in range(n):
        for row in (k, tangent_of[k]):
            if row >= 0:
                for e in range(start[row], start[row + 1]):
                    c = contact_of[place[e]]
                    if mark[c] != k and value[e] != 0.0:
                        mark[c] = k
                        count += 1
        first[k + 1] = count
    for k in range(n):
        mark[k] = -1
    return count


@kernel
def fill_blocks(
    start: IntArray,
    place: IntArray,
    value: FloatArray,
    tangent_of: IntArray,
    contact_of: IntArray,
    units: FloatArray,
    mark: IntArray,
    first: IntArray,
    other: IntArray,
    block: FloatArray,
    own: FloatArray,
) -> None:
    """Their contacts and entries: arrays as of :func:`count_blocks`, ``block`` and ``own`` zero before."""
    n = len(tangent_of)
    for k in range(n):
        end = first[k]
        for side in range(2):
            row = k if side == 0 else tangent_of[k]
            if row < 0:
                continue
            for e in range(start[row], start[row + 1]):
                if value[e] == 0.0:
                    continue
                c = contact_of[place[e]]
                if mark[c] < first[k]:
                    mark[c] = end
                    other[end] = c
                    end += 1
                entry = value[e] * (units[k] * units[c])
                column = 2 * side + (0 if place[e] < n else 1)
                block[mark[c], column] = entry
                if c == k:
                    own[k, column] = entry


@kernel
def weigh_contacts(
    first: IntArray,
    other: IntArray,
    block: FloatArray,
    free: FloatArray,
    friction: FloatArray,
    tangent_of: IntArray,
    z: FloatArray,
    w: FloatArray,
    missed: FloatArray,
) -> tuple[float, float, float]:
    """The largest over all contacts of the three sizes of :func:`lcpflex.solvers.certificate.measured`.

    z (n,): [lambda_N, lambda_R, xi_L]; w = M z + q of the LCP. A row misses |min(d_i z_i, w_i)|, d_i the largest |M_ij|
    of it (1 for a zero row), and a contact what the worst of its rows does. Arrays as of :class:`Coupling`. Out, unless
    they are empty: w (n,), and what is left of the own load of each contact, missed (contacts,).
    """
    kept = len(w) > 0
    n, m = len(friction), len(free)
    told, finite, largest = (0.0, 0.0, 0.0), True, 0.0
    for i in range(m):
        largest = max(largest, abs(free[i]))
    for k in range(n):
        v_n, terms_n, row_n = 0.0, abs(free[k]), 0.0
        v_t, terms_t, row_t = 0.0, 0.0, 0.0
        for e in range(first[k], first[k + 1]):
            c = other[e]
            mu, pressed, right = friction[c], z[c], 0.0
            if tangent_of[c] >= 0:
                right = z[tangent_of[c]]
            rubbed = right - mu * pressed
            nn, nt, tn, tt = block[e, 0], block[e, 1], block[e, 2], block[e, 3]
            v_n += nn * pressed + nt * rubbed
            v_t += tn * pressed + tt * rubbed
            a, b = abs(nn - mu * nt), abs(tn - mu * tt)
            terms_n += a * abs(pressed) + abs(nt * right)
            terms_t += b * abs(pressed) + abs(tt * right)
            row_n = max(row_n, max(a, abs(nt)))
            row_t = max(row_t, max(b, abs(tt)))
        v_n += free[k]
        load = abs(free[k])
        lifted = z[k] * (row_n if row_n > 0.0 else 1.0)
        worst = abs(min(lifted, v_n))
        size = terms_n
        if not (terms_n < np.inf and abs(lifted) < np.inf):
            finite = False
        if kept:
            w[k] = v_n
        t = tangent_of[k]
        if t >= 0:
            left, mu = z[m - n + t], friction[k]
            slip = v_t + free[t] + left
            bound = 2.0 * mu * z[k] - z[t]
            if kept:
                w[t], w[m - n + t] = slip, bound
            terms_t += abs(free[t]) + abs(left)
            load = max(load, abs(free[t]))
            worst = max(worst, abs(min(max(row_t, 1.0) * z[t], slip)))
            worst = max(worst, abs(min(max(2.0 * mu, 1.0) * left, bound)))
            size = max(size, max(terms_t, abs(2.0 * mu * z[k]) + abs(z[t])))
            if not (terms_t < np.inf and abs(bound) < np.inf and max(row_t, 1.0) * abs(z[t]) < np.inf):
                finite = False
        if not worst < np.inf:
            finite = False
        own = measured(worst, size, load, largest)
        if len(missed) > 0:
            missed[k] = own[1]
        told = worse(told, own)
    if not finite:
        return np.inf, np.inf, np.inf
    return told


@kernel
def label_parts(first: IntArray, other: IntArray, label: IntArray) -> int:
    """label (n,): to which part each contact belongs, parts numbered by their first contact; returns their number."""
    n = len(label)
    for k in range(n):
        label[k] = k
    for k in range(n):
        for e in range(first[k], first[k + 1]):
            a, b = k, other[e]
            while label[a] != a:
                label[a] = label[label[a]]
                a = label[a]
            while label[b] != b:
                label[b] = label[label[b]]
                b = label[b]
            if a < b:
                label[b] = a
            elif b < a:
                label[a] = b
    count = 0
    for k in range(n):  # a contact points to an earlier one, which has its number already
        if label[k] == k:
            label[k] = -1 - count
            count += 1
        else:
            label[k] = label[label[k]]
    for k in range(n):
        label[k] = -1 - label[k]
    return count


def grouped(count: int, label: IntArray) -> list[IntArray]:
    """The contacts of each part, in order."""
    order = np.argsort(label, kind="stable")
    return np.split(order, np.cumsum(np.bincount(label, minlength=count))[:-1]) if count else []


class ConeBlocks:
    """Blocks of contact k: first[k] to first[k + 1], with contact other[e], entries block[e] (9,) by rows.

    own (n, 9): the block of each contact with itself, which is kept even if it is zero.
    """

    def __init__(self, matrix: Any) -> None:
        n = matrix.shape[0] // 3
        coupled = libs.sparse.bsr_array(libs.sparse.csr_array(matrix), blocksize=(3, 3))
        present = libs.sparse.csr_array(
            (np.ones(len(coupled.indices)), coupled.indices, coupled.indptr), shape=(n, n)
        )  # fmt: skip
        if not present.diagonal().all():  # a contact between two bodies that are held
            coupled = _with_diagonal(coupled, n)
        coupled.sort_indices()
        self.first, self.other = coupled.indptr.astype(np.int64), coupled.indices.astype(np.int64)
        self.block = np.ascontiguousarray(coupled.data.reshape(-1, 9))
        self.own = np.ascontiguousarray(self.block[self.other == np.repeat(np.arange(n), np.diff(self.first))])


def _with_diagonal(coupled: Any, n: int) -> Any:
    """The same blocks and those of each contact with itself, zero or not: a sum would leave zeros out."""
    rows = np.repeat(np.arange(n), np.diff(coupled.indptr))
    missing = np.setdiff1d(np.arange(n), rows[coupled.indices == rows])
    rows, others = np.concatenate([rows, missing]), np.concatenate([coupled.indices, missing])
    block = np.concatenate([coupled.data, np.zeros((len(missing), 3, 3))])
    order = np.lexsort([others, rows])
    first = np.concatenate([[0], np.cumsum(np.bincount(rows, minlength=n))])
    return libs.sparse.bsr_array((block[order], others[order], first), shape=(3 * n, 3 * n))
