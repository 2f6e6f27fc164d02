"""Where mechanics ends and solvers begin: the contact problems of the rows laid, one for each island.

With the right-hand side b of the rows (velocities, accelerations or gaps without constraint forces), joints condensed,

    v = G_c lambda + b_c,   G_c = G_WW - G_WJ G_JJ^-1 G_JW,   b_c = b_W - G_WJ G_JJ^-1 b_J.
"""

from __future__ import annotations

from lcpflex.dynamics.delassus import delassus
from lcpflex.dynamics.islands import find_islands, one_island
from lcpflex.dynamics.joint_response import condense, couple, factorise_joints, solve_joints
from lcpflex.dynamics.rows import Rows
from lcpflex.dynamics.workspace import Workspace
from lcpflex.jit.kernel import FloatArray, IntArray, kernel
from lcpflex.jit.leaf import in_space, leaf
from lcpflex.solvers.contact.algebra import Vector
from lcpflex.solvers.contact.index_sets import STICKING, sliding_sign

__all__ = [
    "describe_contacts",
    "factor_joints",
    "fits",
    "lay_as_one",
    "lay_contacts",
    "list_tangents",
    "pose_island",
    "pose_rows",
    "rows_of_each",
    "take_forces",
]


@kernel
def lay_contacts(work: Workspace) -> None:
    """Begin with the contacts of the rows laid: which islands they make, under Coulomb's law.

    The right-hand side is ``work.free.v``, sizes of what cancels in it ``work.free.terms``.
    """
    lay_as_one(work)
    factor_joints(work)
    find_islands(work.posed.islands, work.rows)


@kernel
def lay_as_one(work: Workspace) -> None:
    """The contacts of the rows laid as one island, under Coulomb's law and without joints."""
    posed = work.posed
    posed.on_sets = 0
    posed.shifted = 0
    posed.lifted = 0
    if work.rows.across == 1 or work.rows.n_contacts < 2:  # the least forces: in space sought once
        posed.islands.shortened = 0
    list_tangents(work.rows, posed.tangent_of)
    one_island(posed.islands, work.rows.n_contacts)


@kernel
def list_tangents(rows: Rows, tangent_of: IntArray) -> None:
    """The tangential row of each contact laid, the first one in space; -1 without friction."""
    for k in range(rows.n_contacts):
        tangent_of[k] = -1
    for j in range(rows.n_tangents - 1, -1, -1):
        tangent_of[rows.tangent[j]] = j


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


@kernel
def pose_island(work: Workspace, i: int, like: Vector) -> None:
    """``work.posed.problem`` of the contacts of island i; like: zeros, as many as a contact has rows."""
    describe_contacts(work, i, like)
    problem, part, counted = work.posed.problem, work.posed.part, work.posed.counted
    m, G, free = problem.n_contacts + problem.n_tangents, problem.delassus, problem.free
    pose_rows(work, m, G, free)
    if work.posed.lifted == 1:  # forces that are counted already leave the right-hand side
        for r in range(m):
            for s in range(m):
                if 0 <= part[s] < work.rows.n_contacts:
                    free[r] -= G[r, s] * counted[part[s]]


@kernel
def rows_of_each(work: Workspace) -> int:
    """Rows of the problem posed from one normal to the next: in space three, or where nothing rubs one."""
    return 2 * work.rows.across - 1 if work.posed.problem.n_tangents > 0 else 1


@in_space("lcpflex.dynamics.spatial.contact_blocks")
@kernel
def fill_delassus(work: Workspace, m: int, G: FloatArray) -> None:
    """G of the m rows ``posed.part``, joints left aside."""
    rows, part, n_joint = work.rows, work.posed.part, work.rows.n_joint
    delassus(rows.J[n_joint:], rows.solved[n_joint:], rows.body[n_joint:], part, m, G)


@kernel
def pose_rows(work: Workspace, m: int, G: FloatArray, free: FloatArray) -> None:
    """G and ``free`` of the m rows ``posed.part``, joints condensed; what is known of each contact there alone."""
    rows, part, n_joint = work.rows, work.posed.part, work.rows.n_joint
    fill_delassus(work, m, G)
    for r in range(m):
        free[r] = work.free.v[n_joint + part[r]] if part[r] >= 0 else 0.0
    if n_joint > 0:
        condense(rows, part, n_joint, m, G, free)
    for r in range(m):
        if 0 <= part[r] < rows.n_contacts:
            work.posed.own[part[r]] = G[r, r]
            work.posed.effect[part[r]] = free[r]


@kernel
def describe_contacts(work: Workspace, i: int, like: Vector) -> None:
    """Friction and names of the contacts of island i, and in ``work.posed.part`` the rows of its problem."""
    posed, problem, table = work.posed, work.posed.problem, work.rows.table
    first = posed.islands.start[i]
    problem.n_contacts, problem.n_tangents = posed.islands.start[i + 1] - first, 0
    problem.on_sets, problem.shifted = posed.on_sets, posed.shifted
    for c in range(problem.n_contacts):
        k = posed.islands.contact[first + c]
        problem.friction[c] = work.rows.mu[k] if posed.tangent_of[k] >= 0 else 0.0
        problem.key[c] = table.key[k]
        problem.pair[c] = table.law[k]
        if posed.on_sets == 1:
            problem.mode[c] = posed.mode[k]
        if posed.shifted == 1:
            problem.least[c] = posed.least[k]
        list_rows(work, c, k, like)


@leaf
def list_rows(work: Workspace, c: int, k: int, like: Vector) -> None:
    """The rows of contact c of the problem, k of the table, to ``posed.part``; sizes of what cancels in them.

    In the plane all normals come first, then tangents where there is friction; in space three rows a contact, those
    that it has not as -1.
    """
    raise NotImplementedError


@list_rows.of(2)
@kernel
def list_rows_in_plane(work: Workspace, c: int, k: int, like: Vector) -> None:
    problem, part, terms, j = work.posed.problem, work.posed.part, work.free.terms, work.posed.tangent_of[k]
    part[c], problem.terms[c] = k, terms[k]
    if j >= 0:
        r = problem.n_contacts + problem.n_tangents
        part[r], problem.terms[r] = work.rows.n_contacts + j, terms[work.rows.n_contacts + j]
        problem.tangent[problem.n_tangents] = c
        problem.n_tangents += 1


@list_rows.of(3)
@kernel
def list_rows_in_space(work: Workspace, c: int, k: int, like: Vector) -> None:
    problem, part, terms, j = work.posed.problem, work.posed.part, work.free.terms, work.posed.tangent_of[k]
    for t in range(3):
        row = k if t == 0 else (work.rows.n_contacts + j + t - 1 if j >= 0 else -1)
        part[3 * c + t], problem.terms[3 * c + t] = row, terms[row] if row >= 0 else 0.0
    problem.n_tangents += 2


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
