"""Where mechanics ends and solvers begin: the contact problem of the rows laid.

With the right-hand side b of the rows (velocities, accelerations or gaps without constraint forces), joints condensed,

    v = G_c lambda + b_c,   G_c = G_WW - G_WJ G_JJ^-1 G_JW,   b_c = b_W - G_WJ G_JJ^-1 b_J.
"""

from __future__ import annotations

from lcpflex.dynamics.delassus import condense, delassus
from lcpflex.dynamics.workspace import Workspace
from lcpflex.jit.kernel import kernel
from lcpflex.solvers.semidefinite import cholesky

__all__ = ["describe_contacts", "pose_contacts"]


@kernel
def pose_contacts(work: Workspace) -> None:
    """``work.problem`` of the rows laid, for the right-hand side ``work.free``."""
    n_joint = work.n_joint
    total = n_joint + work.n_contacts + work.n_tangents
    problem = work.problem
    delassus(work.rows, work.solved, work.row_body, total, work.G)
    cholesky(work.G, n_joint, work.lower)
    condense(work.G, work.free, n_joint, total, work.lower, work.share, problem.delassus, problem.free)
    describe_contacts(work)


@kernel
def describe_contacts(work: Workspace) -> None:
    """Friction, tangents and names of the contacts in the table; all of them under Coulomb's law, without restraint."""
    problem = work.problem
    problem.n_contacts = work.n_contacts
    problem.n_tangents = work.n_tangents
    problem.on_sets = 0
    problem.shifted = 0
    for k in range(work.n_contacts):
        problem.friction[k] = work.mu[k]
        problem.key[k] = work.table.key[k]
        problem.pair[k] = work.table.law[k]
    for j in range(work.n_tangents):
        problem.tangent[j] = work.tangent[j]
