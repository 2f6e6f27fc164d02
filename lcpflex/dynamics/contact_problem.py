"""Where mechanics ends and solvers begin: the contact problems of the rows laid, one for each island.

With the right-hand side b of the rows (velocities, accelerations or gaps without constraint forces), joints condensed,

    v = G_c lambda + b_c,   G_c = G_WW - G_WJ G_JJ^-1 G_JW,   b_c = b_W - G_WJ G_JJ^-1 b_J.
"""

from __future__ import annotations

from lcpflex.dynamics.delassus import delassus
from lcpflex.dynamics.islands import find_islands, one_island
from lcpflex.dynamics.joint_response import condense, couple, factorise_joints, solve_joints
from lcpflex.dynamics.workspace import Workspace
from lcpflex.jit.kernel import kernel
from lcpflex.jit.leaf import in_space
from lcpflex.solvers.contact.index_sets import STICKING, sliding_sign

__all__ = ["describe_contacts", "factor_joints", "fits", "lay_as_one", "lay_contacts", "pose_island", "take_forces"]


@in_space("lcpflex.dynamics.spatial.contact_problem")
@kernel
def lay_contacts(work: Workspace) -> None:
    """Begin with the contacts of the rows laid: which islands they make, under Coulomb's law.

    The right-hand side is ``work.free.v``, sizes of what cancels in it ``work.free.terms``.
    """
    lay_as_one(work)
    factor_joints(work)
    find_islands(
        work.posed.islands,
        work.rows.J,
        work.rows.solved,
        work.rows.body,
        work.rows.dof,
        work.rows.n_joint,
        work.rows.n_contacts,
    )


@kernel
def lay_as_one(work: Workspace) -> None:
    """The contacts of the rows laid as one island, under Coulomb's law and without joints."""
    work.posed.on_sets = 0
    work.posed.shifted = 0
    work.posed.lifted = 0
    for k in range(work.rows.n_contacts):
        work.posed.tangent_of[k] = -1
    for j in range(work.rows.n_tangents):
        work.posed.tangent_of[work.rows.tangent[j]] = j
    one_island(work.posed.islands, work.rows.n_contacts)


@kernel
def factor_joints(work: Workspace) -> None:
    """The factor of the joints, their answer to the right-hand side, and what they have to do with each contact row."""
    n_joint = work.rows.n_joint
    if n_joint > 0:
        answer = work.rows.joints.answer
        for j in range(n_joint):
            answer[j] = work.free.v[j]
        factorise_joints(work.rows)
        solve_joints(work.rows, answer)
        couple(work.rows, n_joint, work.rows.n_contacts + work.rows.n_tangents)


@kernel
def fits(work: Workspace, i: int) -> bool:
    """Whether there is room for the problem of island i; ``work.impulses.most`` becomes what it needs."""
    size = work.posed.islands.start[i + 1] - work.posed.islands.start[i]
    work.impulses.most = max(work.impulses.most, size)
    return bool(size <= len(work.posed.problem.friction))


@in_space("lcpflex.dynamics.spatial.contact_problem")
@kernel
def pose_island(work: Workspace, i: int) -> None:
    """``work.posed.problem`` of the contacts of island i."""
    describe_contacts(work, i)
    n_joint, problem, part = work.rows.n_joint, work.posed.problem, work.posed.part
    m = problem.n_contacts + problem.n_tangents
    G, free = problem.delassus, problem.free
    delassus(work.rows.J[n_joint:], work.rows.solved[n_joint:], work.rows.body[n_joint:], part, m, G)
    for c in range(m):
        free[c] = work.free.v[n_joint + part[c]]
    if n_joint > 0:
        condense(work.rows, part, n_joint, m, G, free)
    note_effects(work, i)


@kernel
def note_effects(work: Workspace, i: int) -> None:
    """What is known of each contact of island i alone; forces that are counted already leave the right-hand side."""
    posed = work.posed
    problem, contact = posed.problem, posed.islands.contact
    first, n = posed.islands.start[i], problem.n_contacts
    for c in range(n):
        k = contact[first + c]
        posed.own[k] = problem.delassus[c, c]
        posed.effect[k] = problem.free[c]
    if posed.lifted == 1:
        for c in range(n):
            for e in range(n):
                problem.free[c] -= problem.delassus[c, e] * posed.counted[contact[first + e]]


@kernel
def describe_contacts(work: Workspace, i: int) -> None:
    """Friction, tangents and names of the contacts of island i, and in ``work.posed.part`` the rows of its problem."""
    posed = work.posed
    problem, part, contact = posed.problem, posed.part, posed.islands.contact
    first = posed.islands.start[i]
    n = posed.islands.start[i + 1] - first
    all_contacts, table = work.rows.n_contacts, work.rows.table
    tangent_of, terms = posed.tangent_of, work.free.terms
    on_sets, shifted = posed.on_sets, posed.shifted
    found = 0
    for c in range(n):
        k = contact[first + c]
        part[c] = k
        problem.friction[c] = work.rows.mu[k]
        problem.key[c] = table.key[k]
        problem.pair[c] = table.law[k]
        problem.terms[c] = terms[k]
        if on_sets == 1:
            problem.mode[c] = posed.mode[k]
        if shifted == 1:
            problem.least[c] = posed.least[k]
        j = tangent_of[k]
        if j >= 0:
            part[n + found] = all_contacts + j
            problem.tangent[found] = c
            problem.terms[n + found] = terms[all_contacts + j]
            found += 1
    problem.n_contacts = n
    problem.n_tangents = found
    problem.on_sets = on_sets
    problem.shifted = shifted


@kernel
def take_forces(work: Workspace) -> None:
    """Forces of the problem just solved to ``impulses.p``; of sliding contacts on index sets from their normals."""
    problem, solver, part, p = work.posed.problem, work.impulses.solver, work.posed.part, work.impulses.p
    n_joint, n = work.rows.n_joint, problem.n_contacts
    for c in range(n):
        p[n_joint + part[c]] = solver.normal[c]
    if problem.on_sets == 0:
        for j in range(problem.n_tangents):
            p[n_joint + part[n + j]] = solver.tangential[j]
        return
    stuck = 0
    for j in range(problem.n_tangents):
        c = problem.tangent[j]
        if problem.mode[c] == STICKING:
            p[n_joint + part[n + j]] = solver.tangential[stuck]
            stuck += 1
        else:
            p[n_joint + part[n + j]] = -sliding_sign(problem.mode[c]) * problem.friction[c] * solver.normal[c]
