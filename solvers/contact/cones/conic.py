"""Convex programs over the friction cones of contacts in space, by Clarabel, their last digits by Newton steps.

    min 1/2 r.G r + (free + e).r  subject to r in K    <=>    K ∋ r  _|_  G r + free + e ∈ K*

With e = 0 it is the convex relaxation of Coulomb's law (Anitescu 2006), which lifts contacts that slide; with
e = mu s n and s = |u_T| of its own solution it is Coulomb's law (Acary, Cadoux, Lemarechal & Malick 2011).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from lcpflex.basics import libs
from lcpflex.basics.blas import one_thread
from lcpflex.jit.kernel import FloatArray, IntArray, kernel
from lcpflex.solvers.clock import out_of_time
from lcpflex.solvers.contact.clarabel import conic_program
from lcpflex.solvers.contact.cones.certificate import nearest_in_cone
from lcpflex.solvers.contact.matrices import is_sparse
from lcpflex.solvers.contact.spatial import SpatialContactProblem

__all__ = ["ConicProgram", "relaxed_miss"]

LARGEST = 1200  # force components up to which Newton steps with a dense matrix take out what Clarabel leaves
STEPS = 12  # of Newton
REGULARISED = 1e-10  # of the diagonal: what the Jacobian alone is given, as G is singular where supports are redundant


@kernel
def relaxed_miss(
    forces: FloatArray, velocity: FloatArray, friction: FloatArray, n: int, miss: FloatArray, slope: FloatArray
) -> float:
    """r - P_K(r - u) of n contacts, and the derivative of P_K there; the largest component of the former.

    forces, velocity (3 n,): in units in which the contacts are alike. Out: miss (3 n,), slope (3 n, 3).
    """
    worst = 0.0
    for k in range(n):
        i, mu = 3 * k, friction[k]
        x_n, x_1, x_2 = forces[i] - velocity[i], forces[i + 1] - velocity[i + 1], forces[i + 2] - velocity[i + 2]
        p_n, p_1, p_2 = nearest_in_cone(x_n, x_1, x_2, mu)
        miss[i], miss[i + 1], miss[i + 2] = forces[i] - p_n, forces[i + 1] - p_1, forces[i + 2] - p_2
        inside = p_n == x_n and p_1 == x_1 and p_2 == x_2
        if inside:
            miss[i], miss[i + 1], miss[i + 2] = velocity[i], velocity[i + 1], velocity[i + 2]
        for a in range(3):
            worst = max(worst, abs(miss[i + a]))
            for b in range(3):
                slope[i + a, b] = 1.0 if inside and a == b else 0.0
        if not inside and p_n > 0.0:
            _edge_slope(x_1, x_2, mu, p_1 * p_1 + p_2 * p_2, i, slope)
    return worst


@kernel
def _edge_slope(x_1: float, x_2: float, mu: float, square: float, i: int, slope: FloatArray) -> None:
    """The derivative of P_K where it is on the edge of the cone, |P_T|^2 = square."""
    slip = np.hypot(x_1, x_2)
    share = 1.0 / (1.0 + mu * mu)
    t_1, t_2 = (x_1 / slip, x_2 / slip) if slip > 0.0 else (0.0, 0.0)
    turned = np.sqrt(square) / slip if slip > 0.0 else 0.0
    along = mu * mu * share
    slope[i, 0] = share
    slope[i, 1] = slope[i + 1, 0] = mu * share * t_1
    slope[i, 2] = slope[i + 2, 0] = mu * share * t_2
    slope[i + 1, 1] = along * t_1 * t_1 + turned * t_2 * t_2
    slope[i + 2, 2] = along * t_2 * t_2 + turned * t_1 * t_1
    slope[i + 1, 2] = slope[i + 2, 1] = (along - turned) * t_1 * t_2


@dataclass(frozen=True, slots=True, eq=False)
class ConicProgram:
    """The convex program of a problem in balanced units, prepared for several loads.

    rows (m,): of the problem that are unknowns, those of contacts without friction, which have one, first. unit (m,):
    r = unit x, in which every cone is |x_T| <= x_N. P (m, m) or B (m, j) with P = B B^T. lagged: half of G - G^T, which
    is no part of a program; None where G is symmetric.
    """

    problem: SpatialContactProblem
    rows: IntArray
    unit: FloatArray
    smooth: int
    P: Any
    B: Any
    lagged: Any

    @classmethod
    def of(cls, problem: SpatialContactProblem) -> ConicProgram:
        """problem: balanced."""
        friction = problem.friction
        smooth, rough = 3 * np.flatnonzero(friction == 0.0), 3 * np.flatnonzero(friction)
        rows = np.concatenate([smooth, (rough[:, None] + np.arange(3)).ravel()]).astype(np.int64)
        aspect = np.repeat(friction, 3)
        aspect[::3] = 1.0
        unit = aspect[rows]
        P = B = lagged = None
        delassus, _, _, factor = problem._data
        if factor is not None and problem.symmetric:
            B = libs.sparse.diags_array(unit) @ libs.sparse.csr_array(factor)[rows]
        else:
            G = 0.5 * (delassus + delassus.T)
            lagged = None if problem.symmetric else delassus - G
            chosen = G[rows][:, rows] if is_sparse(G) else G[np.ix_(rows, rows)]
            scale = libs.sparse.diags_array(unit)
            P = scale @ chosen @ scale if is_sparse(chosen) else chosen * np.outer(unit, unit)
        return cls(problem, rows, unit, len(smooth), P, B, lagged)

    def load(self, slip: FloatArray, forces: FloatArray) -> FloatArray:
        """free + mu s n (3 k,), with what the unsymmetric part of G makes of the forces. slip (k,)."""
        load = np.array(self.problem.free)
        load[::3] += self.problem.friction * slip
        return load if self.lagged is None else load + self.lagged @ forces

    def solve(self, load: FloatArray) -> tuple[FloatArray, int, str]:
        """Forces (3 k,) in the cones, the iterations and what Clarabel says."""
        c = self.unit * load[self.rows]
        largest = float(np.abs(c).max(initial=0.0))
        forces = np.zeros(self.problem.size)
        if largest == 0.0:
            return forces, 0, "Solved"
        x, iterations, said = conic_program(self.P, self.B, c / largest, self.smooth, 3)
        forces[self.rows] = largest * (self.unit * x)
        return forces, iterations, said

    def polished(self, load: FloatArray, forces: FloatArray) -> tuple[FloatArray, float]:
        """The same forces with more digits, and the largest component of r - P_K(r - (G r + load)) that is left.

        By semismooth Newton steps, while they help; inf for what is left where the problem is too large for them.
        """
        problem, m = self.problem, self.problem.size
        if m > LARGEST or not np.isfinite(forces).all():
            return forces, np.inf
        G = problem.dense() if self.lagged is None else 0.5 * (problem.dense() + problem.dense().T)
        with one_thread(m):
            return _newton(problem._data[2], G, load, forces)


def _newton(friction: FloatArray, G: FloatArray, load: FloatArray, forces: FloatArray) -> tuple[FloatArray, float]:
    """The point of :meth:`ConicProgram.polished`."""
    n, m = len(friction), len(forces)
    miss, slope = np.empty(m), np.empty((m, 3))
    best, least = forces, np.inf
    r = forces.copy()
    for _ in range(STEPS):
        worst = relaxed_miss(r, G @ r + load, friction, n, miss, slope)
        if not worst < least:
            break
        best, least = r.copy(), worst
        if worst == 0.0 or out_of_time():
            break
        r = r - _step(G, miss, slope, n)
        if not np.isfinite(r).all():
            break
    return best, least


def _step(G: FloatArray, miss: FloatArray, slope: FloatArray, n: int) -> FloatArray:
    """(I - S (I - G'))^-1 miss, with S the slopes of the contacts and G' = G and a little more."""
    softened = np.eye(3 * n) - G
    softened[np.diag_indices(3 * n)] -= REGULARISED
    product = np.matmul(slope.reshape(n, 3, 3), softened.reshape(n, 3, 3 * n)).reshape(3 * n, 3 * n)
    try:
        step = np.linalg.solve(np.eye(3 * n) - product, miss)
    except np.linalg.LinAlgError:
        return np.full(3 * n, np.nan)
    return np.asarray(step)
