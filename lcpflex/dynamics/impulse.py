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
    """``work.free.v`` and ``work.free.terms`` of the rows laid at ``work.free.u``."""
    rows = work.rows
    n = rows.n_joint + rows.n_contacts + rows.n_tangents
    free_velocities(rows.J, rows.body, rows.n_joint, n, rows.dof, work.free.u, work.free.v, work.free.terms)


@in_space("lcpflex.dynamics.spatial.delassus")
@kernel
def add_impulses(work: Workspace, u: FloatArray) -> None:
    """u += A^-1 W p of all rows laid and their impulses ``work.impulses.p``."""
    rows = work.rows
    total = rows.n_joint + rows.n_contacts + rows.n_tangents
    apply_impulses(rows.solved, rows.body, 0, total, work.impulses.p, rows.dof, u)


@kernel
def pose(model: Model, work: Workspace, u_before: FloatArray, lead: float, velocity_threshold: float) -> None:
    """Lay the contact problems of all islands from rows, solved rows and the free velocity in ``work``.

    ``lead``: time [s] from the configuration of the rows to the end of the step; all rows are carried
    there by their bias, W(q+)^T u+ ~ W^T u+ + lead w, so that a hinge or a rolling contact loses no energy to the
    linearisation. Normal velocity below ``velocity_threshold`` [m/s] is not reflected (e_N = 0), nor, where there is
    one, that of a contact that goes on.
    """
    rows, free = work.rows, work.free
    n_joint = rows.n_joint
    n = rows.n_contacts
    n_tangent = rows.n_tangents
    total = n_joint + n + n_tangent
    measure_free(work)
    if lead > 0.0:
        for r in range(total):
            free.v[r] += lead * rows.bias[r]
    for r in range(n_joint):
        free.v[r] += rows.rate[r]
    for k in range(n):
        law = rows.table.law[k]
        e_n = model.contacts.restitution[law]
        if e_n > 0.0:
            before = row_velocity(rows.J, rows.body, n_joint + k, rows.dof, u_before)
            if abs(before) > velocity_threshold:
                if not (velocity_threshold > 0.0 and goes_on(work, k, before)):
                    free.v[n_joint + k] += e_n * before
            else:
                work.impulses.stopped = max(work.impulses.stopped, -before)
    for j in range(n_tangent):
        e_t = model.contacts.tangential_restitution[rows.table.law[rows.tangent[j]]]
        if e_t > 0.0:
            r = n_joint + n + j
            free.v[r] += e_t * row_velocity(rows.J, rows.body, r, rows.dof, u_before)
    lay_contacts(work)
    prepare_large(model, work)


@late_kernel
def goes_on(work: Workspace, k: int, before: float) -> bool:
    """Whether contact k stayed closed over the last step, and its velocity ``before`` is no more than forces give.

    Its rows have turned since: at those of its own step, what carries has none. To reflect it, as that of a body that
    tips over its corner, is to let it sink or jump, in every step in which rows turn by more than the threshold.
    """
    if not abs(before) <= 2.0 * abs(work.free.v[work.rows.n_joint + k] - before):
        return False
    return bool(entry_of(work.impulses.held_key[0], work.impulses.n_held, work.rows.table.key[k], 0) >= 0)


@kernel
def answer_joints(work: Workspace) -> None:
    """Impulses ``work.impulses.p`` of the joints, those of the contacts being known."""
    joint_impulses(work.rows, work.rows.n_joint + work.rows.n_contacts + work.rows.n_tangents, work.impulses.p)


@kernel
def recall_joints(work: Workspace) -> None:
    """Impulses of the joints are those that large islands of the next step begin from."""
    for r in range(work.rows.n_joint):
        work.impulses.recalled[r] = work.impulses.p[r]


@kernel
def lay_impulse(work: Workspace, normal: float, tangential: float) -> None:
    """Impulses ``work.impulses.p`` of all rows, of which those of a single contact are given; joints answer them."""
    n_joint = work.rows.n_joint
    work.impulses.p[n_joint] = normal
    if work.rows.n_tangents > 0:
        work.impulses.p[n_joint + 1] = tangential
    answer_joints(work)
    for r in range(n_joint):
        work.rows.joints.answer[r] = 0.0  # met by the first of several phases
