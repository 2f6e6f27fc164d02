"""Sweeps over spatial contacts with Coulomb friction: the compiled part of the block Gauss-Seidel iteration.

The law of one contact, with the forces of all others held, is solved exactly (:mod:`.laws.disc`), one contact after the
other. A block W_kk that is not symmetric is taken by its symmetric part, the rest as known from the last force: what
is left of it shrinks with the sweeps. Sources: Jean 1999 (nonsmooth contact dynamics); Jourdan, Alart & Jean 1998.
"""

from __future__ import annotations

import numpy as np

from lcpflex.jit.kernel import FloatArray, IntArray, kernel
from lcpflex.solvers.contact.laws.disc import solve_cone

__all__ = ["sweep_cone_blocks", "sweep_cone_factor", "sweep_cones", "velocity_by_blocks"]


@kernel
def _renewed(
    own: FloatArray, u_n: float, u_1: float, u_2: float, k: int, mu: float, forces: FloatArray, slip: FloatArray
) -> tuple[float, float, float, float]:
    """Solve contact k for its own force; the change of that, and the largest change of velocity it makes.

    own (9,): W_kk by rows; u: velocity of the contact with the forces as they are. In place: forces[3 k:3 k + 3] and
    slip[k]. A contact that nothing solves alone keeps no force.
    """
    i = 3 * k
    p_n, p_1, p_2 = forces[i], forces[i + 1], forces[i + 2]
    W_n1, W_n2, W_12 = 0.5 * (own[1] + own[3]), 0.5 * (own[2] + own[6]), 0.5 * (own[5] + own[7])
    q_n = u_n - own[0] * p_n - W_n1 * p_1 - W_n2 * p_2
    q_1 = u_1 - W_n1 * p_n - own[4] * p_1 - W_12 * p_2
    q_2 = u_2 - W_n2 * p_n - W_12 * p_1 - own[8] * p_2
    r_n, r_1, r_2, slip[k] = solve_cone(own[0], W_n1, W_n2, own[4], W_12, own[8], q_n, q_1, q_2, mu, slip[k])
    forces[i], forces[i + 1], forces[i + 2] = r_n, r_1, r_2
    d_n, d_1, d_2 = r_n - p_n, r_1 - p_1, r_2 - p_2
    return d_n, d_1, d_2, max(abs(own[0] * d_n), max(abs(own[4] * d_1), abs(own[8] * d_2)))


@kernel
def sweep_cones(
    W: FloatArray,
    free: FloatArray,
    friction: FloatArray,
    n: int,
    forces: FloatArray,
    slip: FloatArray,
    own: FloatArray,
    sweeps: int,
    target: float,
) -> tuple[int, float]:
    """Up to ``sweeps`` sweeps over n contacts; (how many were made, largest change of a velocity in the last one).

    W (cap, cap) dense, free (cap,), rows (n, t1, t2) of each contact in turn; friction (n,). In place: forces (cap,)
    and slip (n,) of each contact (see ``solve_cone``). Ends early once the change is ``target`` or less.
    Work: own (9,).
    """
    m, change = 3 * n, np.inf
    for made in range(sweeps):
        change = 0.0
        for k in range(n):
            i = 3 * k
            first, second, third = W[i], W[i + 1], W[i + 2]
            u_n, u_1, u_2 = free[i], free[i + 1], free[i + 2]
            for j in range(m):
                p = forces[j]
                u_n += first[j] * p
                u_1 += second[j] * p
                u_2 += third[j] * p
            for j in range(3):
                own[j], own[3 + j], own[6 + j] = first[i + j], second[i + j], third[i + j]
            moved = _renewed(own, u_n, u_1, u_2, k, friction[k], forces, slip)[3]
            change = max(change, moved)
        if not target < change < np.inf:
            return made + 1, change
    return sweeps, change


@kernel
def velocity_by_blocks(
    first: IntArray, other: IntArray, block: FloatArray, free: FloatArray, forces: FloatArray, k: int
) -> tuple[float, float, float]:
    """u of contact k, from the blocks of :func:`sweep_cone_blocks`."""
    i = 3 * k
    u_n, u_1, u_2 = free[i], free[i + 1], free[i + 2]
    for e in range(first[k], first[k + 1]):
        j = 3 * other[e]
        p_n, p_1, p_2 = forces[j], forces[j + 1], forces[j + 2]
        u_n += block[e, 0] * p_n + block[e, 1] * p_1 + block[e, 2] * p_2
        u_1 += block[e, 3] * p_n + block[e, 4] * p_1 + block[e, 5] * p_2
        u_2 += block[e, 6] * p_n + block[e, 7] * p_1 + block[e, 8] * p_2
    return u_n, u_1, u_2


@kernel
def sweep_cone_blocks(
    first: IntArray,
    other: IntArray,
    block: FloatArray,
    own: FloatArray,
    free: FloatArray,
    friction: FloatArray,
    forces: FloatArray,
    slip: FloatArray,
    sweeps: int,
    target: float,
) -> tuple[int, float]:
    """As :func:`sweep_cones`, on the blocks W_kc that are not zero.

    Blocks of contact k: first[k] to first[k + 1], with contact other[e] and entries block[e] (9,) by rows; own (k, 9):
    its block with itself.
    """
    change = np.inf
    for made in range(sweeps):
        change = 0.0
        for k in range(len(friction)):
            u_n, u_1, u_2 = velocity_by_blocks(first, other, block, free, forces, k)
            moved = _renewed(own[k], u_n, u_1, u_2, k, friction[k], forces, slip)[3]
            change = max(change, moved)
        if not target < change < np.inf:
            return made + 1, change
    return sweeps, change


@kernel
def sweep_cone_factor(
    first: IntArray,
    place: IntArray,
    value: FloatArray,
    own: FloatArray,
    free: FloatArray,
    friction: FloatArray,
    x: FloatArray,
    forces: FloatArray,
    slip: FloatArray,
    sweeps: int,
    target: float,
) -> tuple[int, float]:
    """As :func:`sweep_cones`, on the factor J with W = J J^T.

    first (3 n + 1,), place, value: the rows of J in compressed form; own (n, 9); x: J^T forces, kept up to date.
    """
    change = np.inf
    for made in range(sweeps):
        change = 0.0
        for k in range(len(friction)):
            i = 3 * k
            u_n, u_1, u_2 = free[i], free[i + 1], free[i + 2]
            for e in range(first[i], first[i + 1]):
                u_n += value[e] * x[place[e]]
            for e in range(first[i + 1], first[i + 2]):
                u_1 += value[e] * x[place[e]]
            for e in range(first[i + 2], first[i + 3]):
                u_2 += value[e] * x[place[e]]
            d_n, d_1, d_2, moved = _renewed(own[k], u_n, u_1, u_2, k, friction[k], forces, slip)
            if moved > 0.0:
                for e in range(first[i], first[i + 1]):
                    x[place[e]] += d_n * value[e]
                for e in range(first[i + 1], first[i + 2]):
                    x[place[e]] += d_1 * value[e]
                for e in range(first[i + 2], first[i + 3]):
                    x[place[e]] += d_2 * value[e]
            change = max(change, moved)
        if not target < change < np.inf:
            return made + 1, change
    return sweeps, change
