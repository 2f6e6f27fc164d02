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
    n, n_tangents = work.posed.problem.n_contacts, work.posed.problem.n_tangents
    if n_tangents == 0 or n > DOUBTFUL_CONTACTS:
        return
    kind = n
    coupled = False
    place = work.posed.problem.key[0] % DOUBTFUL_KINDS
    for j in range(n_tangents):
        k = work.posed.problem.tangent[j]
        c = work.posed.problem.friction[k] * abs(work.posed.problem.delassus[k, n + j])
        coupled = coupled or c > COUPLED * work.posed.problem.delassus[k, k]
        kind = 2 * kind + (1 if c > work.posed.problem.delassus[k, k] else 0)
    if not coupled:
        work.impulses.doubtful_kind[place] = 0
        return
    for k in range(n):
        kind = (
            4 * kind
            + (2 if work.posed.problem.free[k] < 0.0 else 0)
            + (1 if work.impulses.solver.normal[k] > 0.0 else 0)
        )
    for j in range(n_tangents):
        kind = 4 * kind + motion_of(work.posed.problem, work.impulses.solver, j)
    if kind == work.impulses.doubtful_kind[place]:
        return
    work.impulses.doubtful_kind[place] = kind
    if work.impulses.n_doubtful < len(work.impulses.doubtful):
        write_problem(work, t, work.impulses.doubtful[work.impulses.n_doubtful])
        work.impulses.n_doubtful += 1


@late_kernel
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
