"""The contact problem at impulse level: one step of a time-stepping scheme, or one collision.

    A (u+ - u_free) = J^T p_J + W_N p_N + W_T p_T,   J u+ = -rate
    0 <= p_N  _|_  gdot_N+ + e_N gdot_N- >= 0,   p_T in mu p_N Sign(-(gdot_T+ + e_T gdot_T-))

Unknowns: n_N + 2 n_H for n_N closed contacts, n_H of them with friction; joints are condensed.
Sources: Moreau 1988; Glocker & Studer 2005 (the LCP of planar Coulomb friction).
"""

from __future__ import annotations

from lcpflex.contact.table import entry_of
from lcpflex.dynamics.contact_problem import lay_contacts
from lcpflex.dynamics.delassus import apply_impulses, free_velocities, row_velocity
from lcpflex.dynamics.joint_response import joint_impulses
from lcpflex.dynamics.large_island import prepare_large
from lcpflex.dynamics.workspace import Workspace
from lcpflex.jit.kernel import FloatArray, kernel, late_kernel
from lcpflex.jit.leaf import in_space
from lcpflex.model.arrays import Model

__all__ = ["add_impulses", "answer_joints", "lay_impulse", "pose", "recall_joints"]


@in_space("lcpflex.dynamics.spatial.delassus")
@kernel
def measure_free(work: Workspace) -> None:
    """``work.free`` and ``work.terms`` of the rows laid at ``work.free_u``."""
    n = work.n_joint + work.n_contacts + work.n_tangents
    free_velocities(work.rows, work.row_body, work.n_joint, n, work.dof, work.free_u, work.free, work.terms)


@in_space("lcpflex.dynamics.spatial.delassus")
@kernel
def add_impulses(work: Workspace, u: FloatArray) -> None:
    """u += A^-1 W p of all rows laid and their impulses ``work.p``."""
    total = work.n_joint + work.n_contacts + work.n_tangents
    apply_impulses(work.solved, work.row_body, 0, total, work.p, work.dof, u)


@kernel
def pose(model: Model, work: Workspace, u_before: FloatArray, lead: float, velocity_threshold: float) -> None:
    """Lay the contact problems of all islands from rows, solved rows and the free velocity in ``work``.

    ``lead``: time [s] from the configuration of the rows to the end of the step; all rows are carried
    there by their bias, W(q+)^T u+ ~ W^T u+ + lead w, so that a hinge or a rolling contact loses no energy to the
    linearisation. Normal velocity below ``velocity_threshold`` [m/s] is not reflected (e_N = 0), nor, where there is
    one, that of a contact that goes on.
    """
    n_joint = work.n_joint
    n = work.n_contacts
    n_tangent = work.n_tangents
    total = n_joint + n + n_tangent
    measure_free(work)
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
                if not (velocity_threshold > 0.0 and goes_on(work, k, before)):
                    work.free[n_joint + k] += e_n * before
            else:
                work.stopped = max(work.stopped, -before)
    for j in range(n_tangent):
        e_t = model.contacts.tangential_restitution[work.table.law[work.tangent[j]]]
        if e_t > 0.0:
            r = n_joint + n + j
            work.free[r] += e_t * row_velocity(work.rows, work.row_body, r, work.dof, u_before)
    lay_contacts(work)
    prepare_large(model, work)


@late_kernel
def goes_on(work: Workspace, k: int, before: float) -> bool:
    """Whether contact k stayed closed over the last step, and its velocity ``before`` is no more than forces give.

    Its rows have turned since: at those of its own step, what carries has none. To reflect it, as that of a body that
    tips over its corner, is to let it sink or jump, in every step in which rows turn by more than the threshold.
    """
    if not abs(before) <= 2.0 * abs(work.free[work.n_joint + k] - before):
        return False
    return bool(entry_of(work.held_key[0], work.n_held, work.table.key[k], 0) >= 0)


@kernel
def answer_joints(work: Workspace) -> None:
    """Impulses ``work.p`` of the joints, those of the contacts being known."""
    joint_impulses(work, work.n_joint + work.n_contacts + work.n_tangents, work.p)


@kernel
def recall_joints(work: Workspace) -> None:
    """Impulses of the joints are those that large islands of the next step begin from."""
    for r in range(work.n_joint):
        work.recalled[r] = work.p[r]


@kernel
def lay_impulse(work: Workspace, normal: float, tangential: float) -> None:
    """Impulses ``work.p`` of all rows, of which those of a single contact are given; joints answer them."""
    n_joint = work.n_joint
    work.p[n_joint] = normal
    if work.n_tangents > 0:
        work.p[n_joint + 1] = tangential
    answer_joints(work)
    for r in range(n_joint):
        work.joints.answer[r] = 0.0  # met by the first of several phases
