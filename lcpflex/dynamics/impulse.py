"""The contact problem at impulse level: one step of a time-stepping scheme, or one collision.

    A (u+ - u_free) = J^T p_J + W_N p_N + W_T p_T,   J u+ = -rate
    0 <= p_N  _|_  gdot_N+ + e_N gdot_N- >= 0,   p_T in mu p_N Sign(-(gdot_T+ + e_T gdot_T-))

Unknowns: n_N + 2 n_H for n_N closed contacts, n_H of them with friction; joints are condensed.
Sources: Moreau 1988; Glocker & Studer 2005 (the LCP of planar Coulomb friction).
"""

from __future__ import annotations

from lcpflex.compiled import FloatArray, kernel
from lcpflex.dynamics.delassus import (
    cholesky,
    condense,
    delassus,
    joint_impulses,
    row_velocity,
)
from lcpflex.dynamics.workspace import Workspace
from lcpflex.model import Model
from lcpflex.solvers.certificate import natural_residual
from lcpflex.solvers.friction import assemble_friction_lcp, split_friction_solution
from lcpflex.solvers.lemke import lemke

__all__ = ["distribute", "pose", "solve_lcp"]


@kernel
def pose(model: Model, work: Workspace, u_before: FloatArray, lead: float, velocity_threshold: float) -> None:
    """Assemble M, q of the LCP from rows, solved rows and the free velocity in ``work``.

    ``lead``: time [s] from the configuration of the rows to the end of the step; all rows are carried
    there by their bias, W(q+)^T u+ ~ W^T u+ + lead w, so that a hinge or a rolling contact loses no energy to the
    linearisation. Normal velocity below ``velocity_threshold`` [m/s] is not reflected (e_N = 0).
    """
    n_joint = work.step_size[0]
    n = work.step_size[1]
    n_tangent = work.step_size[2]
    total = n_joint + n + n_tangent
    for r in range(total):
        work.free[r] = row_velocity(work.rows, work.row_body, r, work.dof, work.free_u)
        if lead > 0.0:
            work.free[r] += lead * work.bias[r]
    for r in range(n_joint):
        work.free[r] += work.rate[r]
    for k in range(n):
        law = work.table.law[k]
        e_n = model.contacts.restitution[law]
        if e_n > 0.0:
            before = row_velocity(work.rows, work.row_body, n_joint + k, work.dof, u_before)
            if abs(before) > velocity_threshold:
                work.free[n_joint + k] += e_n * before
    for j in range(n_tangent):
        e_t = model.contacts.tangential_restitution[work.table.law[work.tangent[j]]]
        if e_t > 0.0:
            r = n_joint + n + j
            work.free[r] += e_t * row_velocity(work.rows, work.row_body, r, work.dof, u_before)
    delassus(work.rows, work.solved, work.row_body, total, work.G)
    cholesky(work.G, n_joint, work.lower)
    condense(work.G, work.free, n_joint, total, work.lower, work.share, work.Gc, work.bc)
    assemble_friction_lcp(work.Gc, work.bc, work.mu, work.tangent, n, n_tangent, work.M, work.q)
    work.step_size[3] = n + 2 * n_tangent


@kernel
def solve_lcp(work: Workspace) -> int:
    """Solve the posed LCP by Lemke's method; 0 where solved. Residual and pivots go to ``work.certificate``."""
    m = work.step_size[3]
    status, pivots = lemke(work.M, work.q, m, work.z, work.tableau, work.basis, 1000 + 50 * m)
    work.certificate[0] = natural_residual(work.M, work.q, work.z, m)
    work.certificate[1] = pivots
    return status


@kernel
def distribute(work: Workspace) -> None:
    """Impulses p of all rows (joints, normals, tangents) from the solution z of the LCP."""
    n_joint = work.step_size[0]
    n = work.step_size[1]
    n_tangent = work.step_size[2]
    split_friction_solution(work.z, work.mu, work.tangent, n, n_tangent, work.normal, work.tangential)
    for k in range(n):
        work.p[n_joint + k] = work.normal[k]
    for j in range(n_tangent):
        work.p[n_joint + n + j] = work.tangential[j]
    joint_impulses(work.free, n_joint, n_joint + n + n_tangent, work.lower, work.share, work.p)
