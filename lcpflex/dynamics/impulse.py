"""The contact problem at impulse level: one step of a time-stepping scheme, or one collision.

    A (u+ - u_free) = J^T p_J + W_N p_N + W_T p_T,   J u+ = -rate
    0 <= p_N  _|_  gdot_N+ + e_N gdot_N- >= 0,   p_T in mu p_N Sign(-(gdot_T+ + e_T gdot_T-))

Unknowns: n_N + 2 n_H for n_N closed contacts, n_H of them with friction; joints are condensed.
Sources: Moreau 1988; Glocker & Studer 2005 (the LCP of planar Coulomb friction).
"""

from __future__ import annotations

from lcpflex.dynamics.contact_problem import pose_contacts
from lcpflex.dynamics.delassus import free_velocities, joint_impulses, row_velocity
from lcpflex.dynamics.workspace import Workspace
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.model.arrays import Model

__all__ = ["distribute", "lay_impulse", "pose"]


@kernel
def pose(model: Model, work: Workspace, u_before: FloatArray, lead: float, velocity_threshold: float) -> None:
    """Pose the contact problem from rows, solved rows and the free velocity in ``work``.

    ``lead``: time [s] from the configuration of the rows to the end of the step; all rows are carried
    there by their bias, W(q+)^T u+ ~ W^T u+ + lead w, so that a hinge or a rolling contact loses no energy to the
    linearisation. Normal velocity below ``velocity_threshold`` [m/s] is not reflected (e_N = 0).
    """
    n_joint = work.n_joint
    n = work.n_contacts
    n_tangent = work.n_tangents
    total = n_joint + n + n_tangent
    free_velocities(work.rows, work.row_body, n_joint, total, work.dof, work.free_u, work.free, work.problem.terms)
    if lead > 0.0:
        for r in range(total):
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
            else:
                work.stopped = max(work.stopped, -before)
    for j in range(n_tangent):
        e_t = model.contacts.tangential_restitution[work.table.law[work.tangent[j]]]
        if e_t > 0.0:
            r = n_joint + n + j
            work.free[r] += e_t * row_velocity(work.rows, work.row_body, r, work.dof, u_before)
    pose_contacts(work)


@kernel
def distribute(work: Workspace) -> None:
    """Impulses p of all rows (joints, normals, tangents) from the solution of the contact problem."""
    n_joint = work.n_joint
    n = work.n_contacts
    n_tangent = work.n_tangents
    for k in range(n):
        work.p[n_joint + k] = work.solver.normal[k]
    for j in range(n_tangent):
        work.p[n_joint + n + j] = work.solver.tangential[j]
    joint_impulses(work.free, n_joint, n_joint + n + n_tangent, work.lower, work.share, work.p)


@kernel
def lay_impulse(work: Workspace, normal: float, tangential: float) -> None:
    """Impulses ``work.p`` of all rows, of which those of a single contact are given; joints answer them."""
    n_joint = work.n_joint
    total = n_joint + 1 + work.n_tangents
    work.p[n_joint] = normal
    if work.n_tangents > 0:
        work.p[n_joint + 1] = tangential
    joint_impulses(work.free, n_joint, total, work.lower, work.share, work.p)
    for r in range(n_joint):
        work.free[r] = 0.0  # met by the first of several phases
