"""Small contact problems that may have several solutions, kept as they were solved, to be looked at between steps.

Where friction couples the normal and the tangential motion of a contact strongly, mu |G_NT| against G_NN, the matrix of
the problem need not be a P-matrix, and several velocities may follow from one state (Painleve). A problem is kept where
it is of another kind than the one before: other sets, another sign of what is free, another coupling.
"""

from __future__ import annotations

from lcpflex.dynamics.owners import DOUBTFUL_KINDS
from lcpflex.dynamics.workspace import DOUBTFUL_CONTACTS, Workspace
from lcpflex.jit.kernel import FloatArray, kernel, late_kernel
from lcpflex.solvers.contact.compiled import motion_of

__all__ = ["keep_doubtful"]

COUPLED = 0.5  # mu |G_NT| / G_NN of a contact from which on its problems are looked at


@kernel
def keep_doubtful(work: Workspace, t: float) -> None:
    """Keep the contact problem just solved, of the step from time ``t`` [s], where it may have several solutions."""
    problem = work.posed.problem
    n, n_tangents = problem.n_contacts, problem.n_tangents
    if n_tangents == 0 or n > DOUBTFUL_CONTACTS:
        return
    for j in range(n_tangents):
        k = problem.tangent[j]
        if problem.friction[k] * abs(problem.delassus[k, n + j]) > COUPLED * problem.delassus[k, k]:
            keep_coupled(work, t)
            return
    work.impulses.doubtful_kind[problem.key[0] % DOUBTFUL_KINDS] = 0


@late_kernel
def keep_coupled(work: Workspace, t: float) -> None:
    """The same where friction couples the motions of a contact: kept if it is of another kind than the one before."""
    problem, impulses = work.posed.problem, work.impulses
    n, n_tangents = problem.n_contacts, problem.n_tangents
    kind = n
    for j in range(n_tangents):
        k = problem.tangent[j]
        c = problem.friction[k] * abs(problem.delassus[k, n + j])
        kind = 2 * kind + (1 if c > problem.delassus[k, k] else 0)
    for k in range(n):
        kind = 4 * kind + (2 if problem.free[k] < 0.0 else 0) + (1 if impulses.solver.normal[k] > 0.0 else 0)
    for j in range(n_tangents):
        kind = 4 * kind + motion_of(problem, impulses.solver, j)
    place = problem.key[0] % DOUBTFUL_KINDS
    if kind == impulses.doubtful_kind[place]:
        return
    impulses.doubtful_kind[place] = kind
    if impulses.n_doubtful < len(impulses.doubtful):
        write_problem(work, t, impulses.doubtful[impulses.n_doubtful])
        impulses.n_doubtful += 1


@kernel
def write_problem(work: Workspace, t: float, row: FloatArray) -> None:
    """Time, sizes, laws, friction, free velocities, Delassus operator and forces, one after the other."""
    n = work.posed.problem.n_contacts
    m = n + work.posed.problem.n_tangents
    row[0], row[1], row[2] = t, n, m
    at = 3
    for k in range(n):
        row[at + k] = work.posed.problem.pair[k]
        row[at + n + k] = work.posed.problem.friction[k]
    at += 2 * n
    for r in range(m):
        row[at + r] = work.posed.problem.free[r]
        for s in range(m):
            row[at + m + r * m + s] = work.posed.problem.delassus[r, s]
    at += m + m * m
    for k in range(n):
        row[at + k] = work.impulses.solver.normal[k]
    for j in range(m - n):
        row[at + n + j] = work.impulses.solver.tangential[j]
