"""Islands of many contacts as problems in the velocities of their bodies, joints included.

Which bodies, joint rows and contacts belong to it: a body that the ground holds by joints belongs to each island that
touches it, with these joints.
"""

from __future__ import annotations

from lcpflex.dynamics.delassus import apply_impulses, row_velocity
from lcpflex.dynamics.islands import root
from lcpflex.dynamics.mechanics import whiten_rows
from lcpflex.dynamics.workspace import Workspace
from lcpflex.jit.kernel import kernel
from lcpflex.jit.leaf import in_space
from lcpflex.model.arrays import Model
from lcpflex.solvers.contact.index_sets import STICKING
from lcpflex.solvers.contact.recollection import place_of

__all__ = [
    "begin_with_remembered",
    "count_forces",
    "describe_island",
    "is_free",
    "is_large",
    "prepare_large",
    "restore_free",
]


@kernel
def is_large(work: Workspace, i: int) -> bool:
    """Whether island i is solved in the velocities of its bodies."""
    return bool(work.posed.islands.start[i + 1] - work.posed.islands.start[i] > work.impulses.dense_limit)


@in_space("lcpflex.dynamics.spatial.contact_blocks")
@kernel
def wants_white(work: Workspace, i: int) -> bool:
    """Whether island i, which has many contacts, is solved by rows that are whitened: in the plane all are."""
    return True


@kernel
def is_free(work: Workspace, i: int) -> bool:
    """Whether no contact of island i has a force that is bound otherwise than by Coulomb's law and contact.

    Bound are those that are known to slide one way, whose friction acts in the column of the normal force, and normal
    forces with a least value.
    """
    posed = work.posed
    if posed.shifted == 1:
        return False
    if posed.on_sets == 1:
        islands = posed.islands
        for c in range(islands.start[i], islands.start[i + 1]):
            if posed.mode[islands.contact[c]] > STICKING:
                return False
    return True


@kernel
def count_forces(work: Workspace) -> None:
    """Take normal forces that ``free`` counts already out of it, in all rows of the large problem; see restore_free."""
    large, aside, total = work.posed.large, work.scratch.aside, work.scratch.velocity
    for i in range(len(total)):
        total[i] = 0.0
    for c in range(large.n_contacts):
        r = large.normal_row[c]
        start = work.impulses.p[r]
        work.impulses.p[r] = -work.posed.counted[r - work.rows.n_joint]
        apply_impulses(work.rows.solved, work.rows.body, r, r + 1, work.impulses.p, work.rows.dof, total)
        work.impulses.p[r] = start
    for k in range(large.n_contacts + large.n_joints):
        r = large.normal_row[k] if k < large.n_contacts else large.joint_row[k - large.n_contacts]
        aside[k, 1] = work.free.v[r]
        work.free.v[r] += row_velocity(work.rows.J, work.rows.body, r, work.rows.dof, total)


@kernel
def restore_free(work: Workspace) -> None:
    """The right-hand side as it was before :func:`count_forces`."""
    large = work.posed.large
    for k in range(large.n_contacts + large.n_joints):
        r = large.normal_row[k] if k < large.n_contacts else large.joint_row[k - large.n_contacts]
        work.free.v[r] = work.scratch.aside[k, 1]


@kernel
def prepare_large(model: Model, work: Workspace) -> None:
    """Rows by L^-1 where there are large islands."""
    for i in range(work.posed.islands.count):
        if is_large(work, i) and len(work.rows.white) > 0 and wants_white(work, i):
            whiten_rows(model, work.rows, 0, work.rows.n_joint + work.rows.n_contacts + work.rows.n_tangents)
            return


@kernel
def describe_island(work: Workspace, i: int) -> None:
    """``posed.large``: contacts, bodies and joint rows of island i; ``posed.effect`` without those of joints."""
    large, islands, row_body = work.posed.large, work.posed.islands, work.rows.body
    first, n_joint = islands.start[i], work.rows.n_joint
    n = islands.start[i + 1] - first
    for b in range(len(work.scratch.marked)):
        own = islands.held[b] == 0 and islands.island[root(islands.parent, b)] == i
        work.scratch.marked[b] = 1 if own else 0
    for c in range(n):
        k = islands.contact[first + c]
        r = n_joint + k
        large.normal_row[c] = r
        work.posed.effect[k] = work.free.v[r]
        j = work.posed.tangent_of[k]
        rough = j >= 0 and (work.posed.on_sets == 0 or work.posed.mode[k] == STICKING)
        large.tangent_row[c] = n_joint + work.rows.n_contacts + j if rough else -1
        if j >= 0 and not rough:
            work.impulses.p[n_joint + work.rows.n_contacts + j] = 0.0
        large.friction[c] = work.rows.mu[k]
        for side in range(2):
            if row_body[r, side] >= 0:
                work.scratch.marked[row_body[r, side]] = 1
    large.n_contacts = n
    list_joints(work)
    list_bodies(work)


@kernel
def list_joints(work: Workspace) -> None:
    """Joint rows of the bodies marked; bodies that the ground holds, at the other end of such a joint, are marked."""
    large, row_body, held = work.posed.large, work.rows.body, work.posed.islands.held
    found = 0
    for r in range(work.rows.n_joint):
        a, b = row_body[r, 0], row_body[r, 1]
        own = (a >= 0 and work.scratch.marked[a] == 1 and held[a] == 0) or (
            b >= 0 and work.scratch.marked[b] == 1 and held[b] == 0
        )
        if own:
            for side in range(2):
                if row_body[r, side] >= 0:
                    work.scratch.marked[row_body[r, side]] = 1
    for r in range(work.rows.n_joint):
        a, b = row_body[r, 0], row_body[r, 1]
        inside = (a < 0 or work.scratch.marked[a] == 1) and (b < 0 or work.scratch.marked[b] == 1)
        moving = (a >= 0 and held[a] == 0) or (b >= 0 and held[b] == 0)
        if inside and (moving or a < 0 or b < 0):
            large.joint_row[found] = r
            found += 1
    large.n_joints = found


@kernel
def list_bodies(work: Workspace) -> None:
    """The bodies marked."""
    found = 0
    for b in range(len(work.scratch.marked)):
        if work.scratch.marked[b] == 1:
            work.posed.large.bodies[found] = b
            found += 1
    work.posed.large.n_bodies = found


@kernel
def begin_with_remembered(work: Workspace, last: bool) -> int:
    """Impulses ``work.impulses.p`` of the large problem as in the last step, or none: of another problem.

    Returns how many of its contacts are remembered.
    """
    large, known, n_joint = work.posed.large, work.impulses.remembered, work.rows.n_joint
    force = known.force[known.now]
    guess, found = 0, 0
    for c in range(large.n_contacts):
        k = large.normal_row[c] - n_joint
        place = place_of(known, work.rows.table.key[k], guess) if last else -1
        normal, tangential = 0.0, 0.0
        if place >= 0:
            normal, tangential = force[place, 0], force[place, 1]
            guess = place + 1 if place + 1 < known.n else 0
            found += 1
        work.impulses.p[large.normal_row[c]] = normal
        if large.tangent_row[c] >= 0:
            work.impulses.p[large.tangent_row[c]] = tangential
    for j in range(large.n_joints):
        work.impulses.p[large.joint_row[j]] = work.impulses.recalled[large.joint_row[j]] if last else 0.0
    return found
