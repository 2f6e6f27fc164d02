"""Cones of friction that forces x + N y lie in, and programs over y: with cones of second order those of space.

    C z >= 0,    (S_k z)_0 >= |(S_k z)_1,2|    of each z = x + N y

Programs are solved by an interior-point method, the shortest z then on the cones that it touches, to rounding.

Source: Boyd & Vandenberghe, Convex Optimization, 2004 (second-order cone programs).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lcpflex.basics import libs
from lcpflex.jit.kernel import FloatArray

__all__ = ["Cones", "ends_in_cones", "margins_in_cones", "shortest_in_cones"]

EXACT = 1e-12  # tolerance of programs, of the largest force
TOUCHED = 1e-5  # of the largest force: nearer to the side of a cone is on it, where the program ends so early
SETTLED = 1e-14  # of the largest force: a step of Newton's method that is none
TURNS = 30


@dataclass(frozen=True, slots=True, eq=False)
class Cones:
    """Of vectors z (n,)."""

    linear: FloatArray  # C (c, n)
    second: FloatArray  # S (s, 3, n)

    def sides(self, z: FloatArray) -> FloatArray:
        """(c + s,) how far z is inside of each cone."""
        if not len(self.second):
            return np.asarray(self.linear @ z)
        parts = self.second @ z
        return np.concatenate([self.linear @ z, parts[:, 0] - np.hypot(parts[:, 1], parts[:, 2])])

    def counted(self, weights: FloatArray) -> FloatArray:
        """(c + s,) the weights (n,) of the numbers that each cone is of, added up."""
        second = (np.abs(self.second).max(axis=1, initial=0.0) > 0.0).astype(float) @ weights
        return np.concatenate([(np.abs(self.linear) > 0.0).astype(float) @ weights, second])

    def with_one(self, bounds: FloatArray) -> Cones:
        """Of [z, 1], with the rows ``bounds`` (b, n + 1) of it >= 0 as well, behind the linear ones."""
        wide = np.hstack([self.linear, np.zeros((len(self.linear), 1))])
        second = np.concatenate([self.second, np.zeros((len(self.second), 3, 1))], axis=2)
        return Cones(np.vstack([wide, bounds]), second)


def shortest_in_cones(x: FloatArray, N: FloatArray, cones: Cones, slack: float) -> FloatArray | None:
    """y of the shortest x + N y that leaves no cone by more than ``slack``; None where there is none.

    x is at right angles to N, whose columns are orthonormal.
    """
    free = N.shape[1]
    y = _solved(np.eye(free), np.zeros(free), _rows(x, N, cones, slack))
    return None if y is None else _on_cones(x, N, cones, y)


def ends_in_cones(direction: FloatArray, x: FloatArray, N: FloatArray, cones: Cones, slack: float) -> float:
    """The largest direction.y (f,) of all x + N y in the cones; inf where it has no bound, or none was found."""
    free = N.shape[1]
    y = _solved(np.zeros((free, free)), -direction, _rows(x, N, cones, slack))
    return np.inf if y is None else float(direction @ y)


def margins_in_cones(
    x: FloatArray, N: FloatArray, cones: Cones, wanted: NDArray[np.bool_], most: float, slack: float
) -> FloatArray | None:
    """(c + s,) how far some x + N y is inside of each cone, the sum over the ``wanted`` ones as large as can be.

    No more than ``most`` is asked for; None where no answer was found.
    """
    free, count = N.shape[1], len(wanted)
    rows, right, kinds = _rows(x, N, cones, slack)
    c = len(cones.linear)
    own = np.zeros((len(rows), count))
    own[np.arange(c), np.arange(c)] = 1.0
    own[c + 3 * np.arange(count - c), np.arange(c, count)] = 1.0
    limits = np.vstack([np.eye(count), -np.eye(count)])
    rows = np.vstack([np.hstack([np.zeros((2 * count, free)), limits]), np.hstack([rows, own])])
    right = np.concatenate([np.full(count, most), np.zeros(count), right])
    linear = libs.clarabel.NonnegativeConeT(2 * count)
    weight = np.concatenate([np.zeros(free), -wanted.astype(float)])
    found = _solved(np.zeros((free + count,) * 2), weight, (rows, right, [linear, *kinds]))
    return None if found is None else found[free:]


def _rows(x: FloatArray, N: FloatArray, cones: Cones, slack: float) -> tuple[FloatArray, FloatArray, list[Any]]:
    """A, b and kinds of b - A y in cones: nonnegative, and of second order, each let out by ``slack``."""
    first = np.zeros((len(cones.second), 3))
    first[:, 0] = slack
    rows = np.vstack([-(cones.linear @ N), -(cones.second @ N).reshape(-1, N.shape[1])])
    right = np.concatenate([cones.linear @ x + slack, (cones.second @ x + first).ravel()])
    kinds = [libs.clarabel.NonnegativeConeT(len(cones.linear))] if len(cones.linear) else []
    return rows, right, kinds + [libs.clarabel.SecondOrderConeT(3)] * len(cones.second)


def _solved(P: FloatArray, q: FloatArray, rows: tuple[FloatArray, FloatArray, list[Any]]) -> FloatArray | None:
    """The least y.P y / 2 + q.y in the cones; None where there is none, or no bound."""
    settings = libs.clarabel.DefaultSettings()
    settings.verbose = False
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = EXACT
    A, b, kinds = rows
    sparse = libs.sparse.csc_matrix
    found = libs.clarabel.DefaultSolver(sparse(np.triu(P)), q, sparse(A), b, kinds, settings).solve()
    good = str(found.status) in ("Solved", "AlmostSolved", "InsufficientProgress")
    return np.asarray(found.x) if good else None


def _on_cones(x: FloatArray, N: FloatArray, cones: Cones, y: FloatArray) -> FloatArray:
    """The shortest x + N y on the cones that a y near to it touches: Newton's method on what is optimal there.

    y itself where it does not get there.
    """
    z = x + N @ y
    parts = cones.second @ z
    sizes = np.hypot(parts[:, 1], parts[:, 2])
    tips = (parts[:, 0] <= TOUCHED) & (sizes <= TOUCHED)
    sides = ~tips & (parts[:, 0] - sizes <= TOUCHED)
    flat = [cones.linear[cones.linear @ z <= TOUCHED], cones.second[tips].reshape(-1, len(x))]
    E, S = np.vstack(flat), cones.second[sides] @ N
    e, begin, free, there = E @ x, cones.second[sides] @ x, len(y), y
    multipliers = np.zeros(len(E) + len(S))
    for _ in range(TURNS):
        parts = begin + S @ there
        sizes = np.hypot(parts[:, 1], parts[:, 2])
        unit = parts[:, 1:] / sizes[:, None]
        slope = S[:, 0] - np.einsum("kt,ktf->kf", unit, S[:, 1:])
        across = -unit[:, 1, None] * S[:, 1] + unit[:, 0, None] * S[:, 2]
        bent = np.einsum("k,kf,kg->fg", multipliers[len(E) :] / sizes, across, across)
        G = np.vstack([E @ N, slope])
        K = np.block([[np.eye(free) + bent, -G.T], [G, np.zeros((len(G), len(G)))]])
        right = np.concatenate([-there, -(e + E @ N @ there), sizes - parts[:, 0]])
        step = np.linalg.lstsq(K, right, rcond=EXACT)[0]
        there, multipliers = there + step[:free], step[free:]
        if not np.isfinite(there).all() or not np.abs(there - y).max(initial=0.0) <= np.sqrt(TOUCHED):
            return y
        if np.abs(step[:free]).max(initial=0.0) <= SETTLED:
            break
    return there if (cones.sides(x + N @ there) >= np.minimum(cones.sides(z), 0.0) - EXACT).all() else y
