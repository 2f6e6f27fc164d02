"""Forces on index sets of space without sliding friction: a symmetric operator, and the least weighted forces.

    G x = -b,   min sum x_k^2 / w_k,   G = U^T U of rank r, by Cholesky's method with the largest pivots first,
    y = U_1^-T (-b),   (U D U^T) z = y,   x = D U^T z,   D = diag(w)

in units in which G has a unit diagonal. Of a semidefinite matrix no entry is larger than the largest of the diagonal,
which a complete search would find, too. A contact meets few others: rows of U are short. Source: Higham, Analysis of
the Cholesky decomposition of a semi-definite matrix (1990).
"""

from __future__ import annotations

import math
from typing import Any

from lcpflex.dynamics.acceleration import DEPENDENT
from lcpflex.dynamics.spatial.inertia import SpatialWork
from lcpflex.jit.kernel import kernel
from lcpflex.solvers.semidefinite import cholesky, cholesky_solve

__all__ = ["solve_symmetric"]

LIGHTEST = 1e-8  # of the largest weight: less gets no less, being nothing


@kernel
def factor(sets: Any, m: int) -> int:
    """Rows U to those of ``reduced`` that ``order`` names, y to their ``right``; returns the rank."""
    a, b, order, open_ = sets.reduced, sets.right, sets.order, sets.slack
    for i in range(m):
        open_[i] = 1.0
    for k in range(m):
        p, largest = -1, DEPENDENT
        for i in range(m):
            if open_[i] == 1.0 and a[i, i] > largest:
                p, largest = i, a[i, i]
        if p < 0:
            return k
        order[k], open_[p] = p, 0.0
        root = math.sqrt(largest)
        row = a[p]
        for j in range(m):
            row[j] *= open_[j] / root
        row[p] = root
        b[p] /= root
        for i in range(m):
            share = row[i]
            if open_[i] == 0.0 or share == 0.0:
                continue
            b[i] -= share * b[p]
            other = a[i]
            for j in range(m):
                other[j] -= share * row[j]
    return m


@kernel
def weigh(work: SpatialWork, sets: Any, m: int) -> None:
    """D to ``slack``, over the largest weight of the island posed last."""
    n, part, weight = work.posed.problem.n_contacts, work.posed.part, work.rows.table.weight
    largest = 0.0
    for c in range(n):
        largest = max(largest, weight[part[c]])
    for c in range(n):
        own = max(weight[part[c]] / largest, LIGHTEST)
        sets.slack[c] = own
        if sets.at[c] >= 0:
            sets.slack[sets.at[c]], sets.slack[sets.at[c] + 1] = own, own


@kernel
def short(sets: Any, k: int, m: int) -> int:
    """Columns of row k of U that are not 0, to ``problem.member``; how many."""
    row, count = sets.reduced[sets.order[k]], 0
    for j in range(m):
        if row[j] != 0.0:
            sets.problem.member[count] = j
            count += 1
    return count


@kernel
def solve_symmetric(work: SpatialWork, sets: Any, m: int) -> int:
    """solution = -reduced^-1 right, the least weighted one where rows are dependent; the rank."""
    a, b, d, scale, member = sets.reduced, sets.right, sets.slack, sets.scale, sets.problem.member
    T, z = sets.problem.jacobian, sets.problem.step
    for i in range(m):
        scale[i] = 1.0 / math.sqrt(abs(a[i, i])) if a[i, i] != 0.0 else 1.0
    for i in range(m):
        b[i] *= -scale[i]
        for j in range(m):
            a[i, j] *= scale[i] * scale[j]
    rank = factor(sets, m)
    weigh(work, sets, m)
    for k in range(rank):
        row, count = a[sets.order[k]], short(sets, k, m)
        for i in range(k + 1):
            other, total = a[sets.order[i]], 0.0
            for number in range(count):
                j = member[number]
                total += row[j] * d[j] * other[j]
            T[k, i], T[i, k] = total, total
        z[k] = b[sets.order[k]]
    cholesky(T, rank, sets.problem.basis)
    cholesky_solve(sets.problem.basis, rank, z)
    for i in range(m):
        sets.solution[i] = 0.0
    for k in range(rank):
        row = a[sets.order[k]]
        for j in range(m):
            sets.solution[j] += row[j] * z[k]
    for i in range(m):
        sets.solution[i] *= d[i] * scale[i]
    return rank
