"""The condensed tableau of a pivoting method, with exchanges that are carried out four at a time.

    x_B = b + T x_N,   T (n, n + 1):   exchanging row r with column s adds f p^T to T once row r and column s are zero,
    f = T e_s with f_r = 1,   p = -T^T e_r / T_rs with p_s = 1 / T_rs

The next pivot needs one column, one row and b, no more: they are put together from the stored T and the pairs (f, p)
that wait. Four of these are then added in one sweep, so that T is loaded and stored a quarter as often; for T beyond
the first cache that is nearly all the time there is.

Arrays of all kernels: table (cap + EXTRA, cap + 1) at least: T is table[:n, :n + 1], behind it are the rows named here.
"""

from __future__ import annotations

import numpy as np

from lcpflex.jit.kernel import FloatArray, IntArray, kernel

__all__ = ["enter", "exchange", "flush", "leaving_row"]

# Rows behind T, counted from n: four rows p and four columns f that wait (between two paths, room for others); the
# scaling, a candidate, a ray; b of the true problem and of the perturbed one.
ROWS, COLUMNS, SCALE, CANDIDATE, DIRECTION, TRUE, SHIFTED, EXTRA = 0, 4, 8, 9, 10, 11, 12, 13
WAITING = 4
PIVOT = 1e-11  # smaller entries of the scaled tableau are rounding, never pivots
SLIP = 1e-13  # how far a basic variable may pass zero in favour of a larger pivot


@kernel
def enter(table: FloatArray, n: int, s: int, waiting: int) -> None:
    """Column s of T as it stands becomes the next f; in what is stored, it is zero from now on."""
    f = table[n + COLUMNS + waiting]
    for i in range(n):
        f[i] = table[i, s]
        table[i, s] = 0.0
    for k in range(waiting):
        g, factor = table[n + COLUMNS + k], table[n + ROWS + k, s]
        if factor != 0.0:
            table[n + ROWS + k, s] = 0.0
            for i in range(n):
                f[i] += factor * g[i]


@kernel
def exchange(table: FloatArray, n: int, r: int, s: int, waiting: int) -> int:
    """Exchange the basic variable of row r with the nonbasic one of the column s entered last; pairs that now wait."""
    f, p, row = table[n + COLUMNS + waiting], table[n + ROWS + waiting], table[r]
    for j in range(n + 1):
        p[j] = row[j]
        row[j] = 0.0
    for k in range(waiting):
        other, factor = table[n + ROWS + k], table[n + COLUMNS + k, r]
        if factor != 0.0:
            table[n + COLUMNS + k, r] = 0.0
            for j in range(n + 1):
                p[j] += factor * other[j]
    inverse = 1.0 / f[r]
    for j in range(n + 1):
        p[j] *= -inverse
    p[s] = inverse
    f[r] = 1.0
    true, shifted = table[n + TRUE], table[n + SHIFTED]
    step, other_step = -inverse * true[r], -inverse * shifted[r]
    true[r] = 0.0
    shifted[r] = 0.0
    for i in range(n):
        true[i] += step * f[i]
        shifted[i] += other_step * f[i]
    return waiting + 1


@kernel
def flush(table: FloatArray, n: int) -> None:
    """Add the four pairs to T; a pair that is not there must have f = 0."""
    a, b, c, d = table[n + ROWS], table[n + ROWS + 1], table[n + ROWS + 2], table[n + ROWS + 3]
    f = n + COLUMNS
    for i in range(n):
        fa, fb, fc, fd = table[f, i], table[f + 1, i], table[f + 2, i], table[f + 3, i]
        if fa != 0.0 or fb != 0.0 or fc != 0.0 or fd != 0.0:
            row = table[i]
            for j in range(n + 1):
                row[j] += (fa * a[j] + fb * b[j]) + (fc * c[j] + fd * d[j])


@kernel
def leaving_row(table: FloatArray, basis: IntArray, n: int, waiting: int) -> int:
    """Row whose variable first falls to zero as the column entered last grows, -1 if none does.

    Two passes (Harris): the longest step that leaves every variable above -SLIP, then the largest pivot within that
    step; the artificial variable 2 n wins every tie, for its leaving ends the path.
    """
    f, b = table[n + COLUMNS + waiting], table[n + SHIFTED]
    step = np.inf
    for i in range(n):
        slope = -f[i]
        if slope > PIVOT:
            step = min(step, (max(b[i], 0.0) + SLIP) / slope)
    chosen, best = -1, 0.0
    if step < np.inf:
        for i in range(n):
            slope = -f[i]
            if slope > PIVOT and b[i] <= step * slope:
                if basis[i] == 2 * n:
                    return i
                if slope > best:
                    chosen, best = i, slope
    return chosen
