"""A run of an iteration on spatial contacts: where it is, and the ways to go on from there."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from lcpflex.basics import libs
from lcpflex.jit.kernel import FloatArray
from lcpflex.solvers.attention import Ear, listening
from lcpflex.solvers.contact.cones.blocks import ConeBlocks, newton_on_blocks, proximal_on_blocks
from lcpflex.solvers.contact.cones.newton import cone_work, newton, proximal
from lcpflex.solvers.contact.cones.sweeps import sweep_cone_blocks, sweep_cone_factor, sweep_cones
from lcpflex.solvers.contact.problem import aligned
from lcpflex.solvers.contact.spatial import SpatialContactProblem
from lcpflex.solvers.problem import Solution, restored

__all__ = ["ConeRun", "own_units", "start_of"]

COMPILED = 64  # contacts up to which Newton's method is compiled, on a dense operator
FAR = 1e3  # residual of a guess from which to start would only be to carry its rounding along
GOAL = 1e-13  # |F| at which Newton's method ends, where the largest free velocity is between 1 and 2


def start_of(problem: SpatialContactProblem, guess: Solution | None) -> FloatArray:
    """Forces (3 k,) to begin from, in units of the contacts: those of the guess, matched by contact, or zero."""
    start = None if guess is None else aligned(guess, problem.unknown_keys)
    if start is None or start.z.shape != (problem.size,) or not np.isfinite(start.z).all():
        return np.zeros(problem.size)
    forces = problem.unknown_units.inward(start.z)
    return forces if problem.balanced().residual(forces) <= FAR else np.zeros(problem.size)


def own_units(problem: SpatialContactProblem, found: Solution, tolerance: float) -> Solution:
    """The solution of :meth:`SpatialContactProblem.balanced` as one of the problem."""
    return replace(restored(problem, found, problem.unknown_units, tolerance), keys=problem.unknown_keys)


class ConeRun:
    """Forces and slips of contacts measured in units of their own, and what they are advanced by."""

    def __init__(self, problem: SpatialContactProblem, start: FloatArray) -> None:
        self.problem, self.n, self.start = problem, len(problem.friction), start
        self.forces = np.array(start)
        self.dense: FloatArray | None = None
        self.blocks: ConeBlocks | None = None
        self._work: Any = None
        self.ear: Ear | None = None
        matrix = problem.matrix()
        if matrix is None:
            J = libs.sparse.csr_array(problem.factor)
            self.rows = (J.indptr.astype(np.int64), J.indices.astype(np.int64), np.ascontiguousarray(J.data))
            self.own = _own_blocks(J)
            self.x: FloatArray = np.asarray(J.T @ self.forces)
        elif self.n <= COMPILED:
            self.dense = np.ascontiguousarray(matrix if isinstance(matrix, np.ndarray) else matrix.toarray())
            self.small = np.zeros(9)
        else:
            self.blocks = ConeBlocks(matrix)
        self.slip = self._slip()

    def _slip(self) -> FloatArray:
        """|u_T| / |r_T| of the contacts that rub, else 0."""
        if not self.forces.any():
            return np.zeros(self.n)
        u, r = self.problem.velocity(self.forces).reshape(-1, 3), self.forces.reshape(-1, 3)
        rub = np.hypot(r[:, 1], r[:, 2])
        return np.where(rub > 0.0, np.hypot(u[:, 1], u[:, 2]) / np.where(rub > 0.0, rub, 1.0), 0.0)

    def sweep(self, sweeps: int, target: float) -> tuple[int, float]:
        """Up to so many sweeps; how many were made, and the largest change of a velocity in the last one."""
        _, free, friction, _ = self.problem._data
        state = (self.forces, self.slip)
        if self.dense is not None:
            return sweep_cones(self.dense, free, friction, self.n, *state, self.small, sweeps, target)
        if self.blocks is not None:
            W = self.blocks
            return sweep_cone_blocks(W.first, W.other, W.block, W.own, free, friction, *state, sweeps, target)
        return sweep_cone_factor(*self.rows, self.own, free, friction, self.x, *state, sweeps, target)

    def points(self) -> list[tuple[FloatArray, str]]:
        """The forces as they are."""
        return [(self.forces.copy(), "")]

    def newton(self, forces: FloatArray, limit: int) -> int:
        """Newton's method from the forces to the best point, in place; how many linear systems were solved."""
        method = newton if self.dense is not None else newton_on_blocks
        arguments = (self._operator(), *self.problem._data[1:3], self.n, 0.0, forces, GOAL, limit, self._work)
        return self._heard(forces, lambda: method(*arguments))

    def proximal(self, forces: FloatArray, tolerance: float, limit: int) -> int:
        """Proximal points from the forces to the best point, in place; how many linear systems were solved."""
        method = proximal if self.dense is not None else proximal_on_blocks
        arguments = (self._operator(), *self.problem._data[1:3], self.n, forces, tolerance, limit, self._work)
        return self._heard(forces, lambda: method(*arguments))

    def _heard(self, forces: FloatArray, advance: Callable[[], tuple[float, int]]) -> int:
        """How many linear systems it took to advance the forces, from where they are however often a signal comes."""
        start = forces.copy()

        def solve() -> tuple[float, int]:
            forces[:] = start
            return advance()

        return int((solve() if self.ear is None else self.ear(solve))[1])

    def _operator(self) -> Any:
        if self._work is None:
            work = cone_work(self.n, dense=self.dense is not None)
            pivots, self.ear = listening(work.pivots, self.problem.size)
            self._work = work._replace(pivots=pivots)
        return self.dense if self.dense is not None else self.blocks


def _own_blocks(J: Any) -> FloatArray:
    """(n, 9) blocks of J J^T of each contact with itself."""
    own = np.empty((J.shape[0] // 3, 9))
    for i in range(3):
        for j in range(3):
            own[:, 3 * i + j] = J[i::3].multiply(J[j::3]).sum(axis=1)
    return own
