"""The contact problem of a compiled stepper for solvers that are Python: as data of their own, and back."""

from __future__ import annotations

import math

import numpy as np

from lcpflex.jit.kernel import FloatArray
from lcpflex.jit.leaf import in_space
from lcpflex.solvers.certificate import residual_parts
from lcpflex.solvers.contact.compiled import pose_lcp, read_forces
from lcpflex.solvers.contact.index_sets import STICKING, sliding_sign
from lcpflex.solvers.contact.memory import SOLUTION_KNOWN, WEDGED_KNOWN, ContactData, SolverMemory
from lcpflex.solvers.contact.problem import ContactProblem
from lcpflex.solvers.problem import Lcp, Solution

__all__ = [
    "lagging", "measured", "own_pull", "posed_lcp", "posed_problem", "put_solution", "put_tried", "put_wedged",
    "take_solution", "tried_point",
]  # fmt: skip


@in_space("lcpflex.solvers.contact.cones.posed")
def posed_lcp(data: ContactData, memory: SolverMemory) -> Lcp:
    """The problem as an LCP, measured as the compiled solver would."""
    pose_lcp(data, memory)
    return _lcp(memory)


def _lcp(memory: SolverMemory) -> Lcp:
    m, count = memory.size, memory.n_stick
    lcp = Lcp(memory.M[:m, :m], memory.q[:m])
    return lcp._measured([memory.units[:m].copy(), "given"], (m - 2 * count, memory.stick[:count].copy()))


@in_space("lcpflex.solvers.contact.cones.posed")
def posed_problem(data: ContactData, memory: SolverMemory) -> Lcp | ContactProblem:
    """The problem by its contacts.

    Where some are known to slide, the Delassus matrix holds their friction in its normal columns and is unsymmetric.
    Contacts that share a key (two at one place) come as an LCP, and so does a problem with friction whose normal forces
    are at least something, as the expansion of Poisson's impact has them.
    """
    pose_lcp(data, memory)
    n, count = data.n_contacts, memory.n_stick
    m = n + count
    keys = tuple(data.key[:n].tolist())
    stick = memory.stick[:count]
    friction = np.zeros(n)
    friction[stick] = data.friction[stick]
    if len(set(keys)) < n or (data.shifted and (friction * data.least[:n]).any()):
        return _lcp(memory)
    delassus = data.delassus[:m, :m]
    if data.on_sets and (data.mode[data.tangent[: data.n_tangents]] != STICKING).any():
        delassus = memory.M[:m, :m].copy()
        delassus[:, stick] += delassus[:, n:] * friction[stick]
    return ContactProblem(delassus, memory.q[:m], friction, keys)


def own_pull(data: ContactData) -> FloatArray:
    """(n_contacts,) diagonal of :func:`posed_lcp`: how the force of a contact opens it, or < 0, with its friction."""
    n, G = data.n_contacts, data.delassus
    pull = np.diag(G)[:n].copy()
    for j in range(data.n_tangents):
        k = int(data.tangent[j])
        sign = 1.0 if not data.on_sets or data.mode[k] == STICKING else sliding_sign(int(data.mode[k]))
        pull[k] -= sign * data.friction[k] * G[k, n + j]
    return pull


@in_space("lcpflex.solvers.contact.cones.posed")
def tried_point(memory: SolverMemory) -> FloatArray:
    """The point that the last solve came to, in the unknowns of :func:`posed_lcp`."""
    return memory.z[: memory.size].copy()


@in_space("lcpflex.solvers.contact.cones.posed")
def measured(data: ContactData, memory: SolverMemory, *points: FloatArray) -> list[tuple[float, float, float]]:
    """Of the residual of points z (m,) of :func:`posed_lcp`: what is left, the size of its terms, its load."""
    pose_lcp(data, memory)
    m = memory.size
    with np.errstate(all="ignore"):  # what is not finite is judged so
        return [residual_parts(memory.alike, memory.load, z[:m] / memory.units[:m], m) for z in points]


@in_space("lcpflex.solvers.contact.cones.posed")
def put_wedged(memory: SolverMemory, z: FloatArray) -> None:
    """Leave there the best point that could be found of wedged bodies, for when the problem is posed again."""
    memory.z[: len(z)] = z
    memory.known = WEDGED_KNOWN


@in_space("lcpflex.solvers.contact.cones.posed")
def lagging(memory: SolverMemory) -> bool:
    """Whether the last solve came to a point that is right as a whole, but not by the own load of some contact."""
    return False  # pivoting comes to rounding in all rows alike


def put_tried(memory: SolverMemory) -> None:
    """Take the point that the last solve came to as the solution, for when the problem is posed again."""
    memory.known = SOLUTION_KNOWN


def put_solution(data: ContactData, memory: SolverMemory, solution: Solution) -> None:
    """Leave there what is known to solve the problem, for when it is posed again."""
    take_solution(data, memory, solution)
    memory.known = SOLUTION_KNOWN


@in_space("lcpflex.solvers.contact.cones.posed")
def take_solution(data: ContactData, memory: SolverMemory, solution: Solution) -> None:
    """The answer of a Python solver as if a compiled one had found it."""
    m = memory.size
    memory.z[:m] = solution.z
    memory.basis[:m] = solution.z > 0.0 if solution.active is None else solution.active
    memory.residual = solution.residual
    memory.iterations = solution.iterations
    memory.strict = getattr(solution, "strict", math.nan)
    read_forces(data, memory)
