"""A run of an iteration on spatial contacts: where it is, and the ways to go on from there."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from lcpflex.jit.kernel import FloatArray
from lcpflex.solvers.attention import Ear, listening
from lcpflex.solvers.contact.cones.blocks import ConeBlocks, newton_on_blocks
from lcpflex.solvers.contact.cones.newton import cone_work, newton
from lcpflex.solvers.contact.spatial import SpatialContactProblem
from lcpflex.solvers.contact.system import ContactSystem, storage_of

__all__ = ["ConeRun"]

GOAL = 1e-13  # |F| at which Newton's method ends, where the largest free velocity is between 1 and 2


class ConeRun:
    """Contacts measured in units of their own, and what their forces are advanced by."""

    def __init__(self, problem: SpatialContactProblem, start: FloatArray) -> None:
        """start (3 k,): forces to begin from."""
        self.problem, self.n = problem, len(problem.friction)
        storage: Any = storage_of(problem)
        self.system = ContactSystem(problem, storage)
        self.system.take(start)
        self.dense: FloatArray | None = storage if isinstance(storage, np.ndarray) else None
        self.blocks: ConeBlocks | None = None if self.dense is not None else storage
        self._work: Any = None
        self.ear: Ear | None = None

    def newton(self, forces: FloatArray, limit: int) -> int:
        """Newton's method from the forces to the best point, in place; how many linear systems were solved."""
        method = newton if self.dense is not None else newton_on_blocks
        arguments = (self._operator(), *self.problem._data[1:3], self.n, 0.0, forces, GOAL, limit, self._work)
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
