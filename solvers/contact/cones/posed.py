"""The spatial contact problem of a compiled stepper for solvers that are Python: as data of its own, and back."""

from __future__ import annotations

from typing import NoReturn

import numpy as np

from lcpflex.errors import ModelError
from lcpflex.jit.kernel import FloatArray
from lcpflex.solvers.contact.cones.memory import SpatialContactData, SpatialSolverMemory
from lcpflex.solvers.contact.judging import lags
from lcpflex.solvers.contact.memory import WEDGED_KNOWN
from lcpflex.solvers.contact.spatial import SpatialContactProblem
from lcpflex.solvers.problem import Solution
from lcpflex.solvers.refusals import NO_LCP

__all__ = ["lagging", "measured", "posed_lcp", "posed_problem", "put_wedged", "take_solution", "tried_point"]


def posed_problem(data: SpatialContactData, memory: SpatialSolverMemory) -> SpatialContactProblem:
    """The problem by its contacts; their names are numbers where two share a key."""
    n = data.n_contacts
    keys = tuple(data.key[:n].tolist())
    named = keys if len(set(keys)) == n else ()
    friction = data.friction[:n].copy()
    return SpatialContactProblem(data.delassus[: 3 * n, : 3 * n].copy(), data.free[: 3 * n].copy(), friction, named)


def posed_lcp(data: SpatialContactData, memory: SpatialSolverMemory) -> NoReturn:
    """Raises ModelError: friction in space is a cone, and no LCP."""
    raise ModelError(f"solver: {NO_LCP}")


def tried_point(memory: SpatialSolverMemory) -> FloatArray:
    """The forces that the last solve came to."""
    return memory.group.p[: memory.size // 3].flatten()


def measured(
    data: SpatialContactData, memory: SpatialSolverMemory, *points: FloatArray
) -> list[tuple[float, float, float]]:
    """Of the residual of forces z (3 n,): what is left, the size of its terms, its load."""
    problem = posed_problem(data, memory)
    load = float(memory.judged.load)
    found = [problem.residual_parts(z) for z in points]
    return [(worst, max(size, load), max(own, load)) for worst, size, own in found]


def put_wedged(memory: SpatialSolverMemory, z: FloatArray) -> None:
    """Leave there the best forces that could be found of wedged bodies, for when the problem is posed again."""
    memory.group.p[: len(z) // 3] = np.reshape(z, (-1, 3))
    memory.known = WEDGED_KNOWN


def lagging(memory: SpatialSolverMemory) -> bool:
    """Whether the last solve came to forces that are right as a whole, but not by the own load of some contact."""
    return lags(memory.judged)


def take_solution(data: SpatialContactData, memory: SpatialSolverMemory, solution: Solution) -> None:
    """The answer of a Python solver as if the compiled one had found it."""
    n = data.n_contacts
    memory.size = 3 * n
    memory.group.p[:n] = np.reshape(solution.z, (n, 3))
    memory.residual, memory.strict = solution.residual, getattr(solution, "strict", np.nan)
    memory.iterations = solution.iterations
    velocity = np.reshape(data.delassus[: 3 * n, : 3 * n] @ solution.z + data.free[: 3 * n], (n, 3))
    pull = np.linalg.norm(np.reshape(solution.z, (n, 3))[:, 1:], axis=1)
    memory.group.slip[:n] = np.divide(np.linalg.norm(velocity[:, 1:], axis=1), pull, out=np.zeros(n), where=pull > 0.0)
