"""Where spatial mechanics ends and solvers begin: the contact problems of the rows laid, one for each island.

Three rows a contact, (n, t1, t2). Without joints the Delassus operator is never formed: forces p move the bodies by
A^-1 W p, and contacts move with them. With joints it is, and these are condensed as in the plane.
"""

from __future__ import annotations

from lcpflex.dynamics.contact_problem import factor_joints
from lcpflex.dynamics.delassus import delassus
from lcpflex.dynamics.islands import find_islands
from lcpflex.dynamics.joint_response import condense
from lcpflex.dynamics.spatial.inertia import SpatialWork
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.solvers.balance import DEAD, contact_units
from lcpflex.solvers.contact.judging import FLOOR, measure_loads
from lcpflex.solvers.contact.laws import COULOMB

__all__ = [
    "describe_contacts",
    "describe_island",
    "give_forces",
    "has_joints",
    "lay_contacts",
    "pose_island",
    "take_forces",
]


@kernel
def lay_contacts(work: SpatialWork) -> None:
    """Begin with the contacts of the rows laid: which islands they make, under Coulomb's law."""
    work.posed.on_sets = 0
    work.posed.shifted = 0
    work.posed.lifted = 0
    for k in range(work.rows.n_contacts):
        work.posed.tangent_of[k] = -1
    for j in range(0, work.rows.n_tangents, 2):
        work.posed.tangent_of[work.rows.tangent[j]] = j
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
def has_joints(work: SpatialWork, i: int) -> bool:
    """Whether a contact of island i moves a body with joints."""
    n_joint, islands, first, row_body = work.rows.n_joint, work.posed.islands, work.rows.joints.first, work.rows.body
    if n_joint == 0:
        return False
    for c in range(islands.start[i], islands.start[i + 1]):
        r = n_joint + islands.contact[c]
        for side in range(2):
            b = row_body[r, side]
            if b >= 0 and first[b] < first[b + 1]:
                return True
    return False


@kernel
def product(rows: FloatArray, solved: FloatArray, a: int, b: int, i: int, j: int, width: int) -> float:
    """Block i of rows_a with block j of A^-1 rows_b."""
    total = 0.0
    for c in range(width):
        total += rows[a, i, c] * solved[b, j, c]
    return total


@kernel
def describe_island(work: SpatialWork, i: int) -> None:
    """The contacts of island i, which has no joints: their rows, own blocks of G, units and loads."""
    group, scene, islands = work.impulses.solver.group, work.impulses.solver.scene, work.posed.islands
    n_joint, dof = work.rows.n_joint, work.rows.dof
    rows, solved, row_body, free = work.rows.J, work.rows.solved, work.rows.body, work.free.v
    own, unit, contact = group.own, group.unit, islands.contact
    first = islands.start[i]
    n = islands.start[i + 1] - first
    group.n = n
    for c in range(n):
        k = contact[first + c]
        r, j = n_joint + k, work.posed.tangent_of[k]
        s = n_joint + work.rows.n_contacts + j if j >= 0 else -1
        scene.normal[c], scene.tangent[c] = r, s
        group.law[c], group.mu[c] = COULOMB, work.rows.mu[k] if s >= 0 else 0.0
        group.free[c, 0] = free[r]
        group.free[c, 1], group.free[c, 2] = (free[s], free[s + 1]) if s >= 0 else (0.0, 0.0)
        nn, n1, n2, aa, ab, bb = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for x in range(2):
            b = row_body[r, x]
            if b < 0:
                continue
            for y in range(2):
                if row_body[r, y] != b:
                    continue
                width = dof[b + 1] - dof[b]
                nn += product(rows, solved, r, r, x, y, width)
                if s >= 0:
                    n1 += product(rows, solved, r, s, x, y, width)
                    n2 += product(rows, solved, r, s + 1, x, y, width)
                    aa += product(rows, solved, s, s, x, y, width)
                    ab += product(rows, solved, s, s + 1, x, y, width)
                    bb += product(rows, solved, s + 1, s + 1, x, y, width)
        own[c, 0], own[c, 1], own[c, 2] = nn, n1, n2
        own[c, 3], own[c, 4], own[c, 5] = n1, aa, ab
        own[c, 6], own[c, 7], own[c, 8] = n2, ab, bb
        unit[c] = max(nn, max(aa, bb))
        work.posed.own[k] = nn
        work.posed.effect[k] = free[r]
    contact_units(unit, n, DEAD)
    for c in range(n):
        group.load[c] = load_of(work, c)
    measure_loads(group, work.impulses.solver.judged)


@kernel
def load_of(work: SpatialWork, c: int) -> float:
    """Free velocity of contact c of the island, or what its terms make it worth, in its unit."""
    terms, free, n_joint = work.free.terms, work.impulses.solver.group.free, work.rows.n_joint
    r, s = work.impulses.solver.scene.normal[c], work.impulses.solver.scene.tangent[c]
    size = max(abs(free[c, 0]), FLOOR * terms[r - n_joint])
    if s >= 0:
        size = max(size, max(abs(free[c, 1]), FLOOR * terms[s - n_joint]))
        size = max(size, max(abs(free[c, 2]), FLOOR * terms[s + 1 - n_joint]))
    return float(work.impulses.solver.group.unit[c] * size)


@kernel
def describe_contacts(work: SpatialWork, i: int) -> int:
    """Friction and names of the contacts of island i; in ``posed.part`` the rows that there are, and their number."""
    problem, part, contact = work.posed.problem, work.posed.part, work.posed.islands.contact
    first = work.posed.islands.start[i]
    n = work.posed.islands.start[i + 1] - first
    found = 0
    for c in range(n):
        k = contact[first + c]
        j = work.posed.tangent_of[k]
        problem.friction[c] = work.rows.mu[k] if j >= 0 else 0.0
        problem.key[c] = work.rows.table.key[k]
        problem.pair[c] = work.rows.table.law[k]
        if work.posed.on_sets == 1:
            problem.mode[c] = work.posed.mode[k]
        if work.posed.shifted == 1:
            problem.least[c] = work.posed.least[k]
        part[found] = k
        problem.terms[3 * c] = work.free.terms[k]
        problem.terms[3 * c + 1], problem.terms[3 * c + 2] = 0.0, 0.0
        found += 1
        if j >= 0:
            for t in range(2):
                part[found] = work.rows.n_contacts + j + t
                problem.terms[3 * c + 1 + t] = work.free.terms[part[found]]
                found += 1
    problem.n_contacts, problem.n_tangents = n, 2 * n
    problem.on_sets = work.posed.on_sets
    problem.shifted = work.posed.shifted
    return found


@kernel
def pose_island(work: SpatialWork, i: int) -> None:
    """``work.posed.problem`` of the contacts of island i, joints condensed."""
    m = describe_contacts(work, i)
    n_joint, problem, part = work.rows.n_joint, work.posed.problem, work.posed.part
    G, free, n = problem.delassus, problem.free, problem.n_contacts
    delassus(work.rows.J[n_joint:], work.rows.solved[n_joint:], work.rows.body[n_joint:], part, m, G)
    for c in range(m):
        free[c] = work.free.v[n_joint + part[c]]
    if n_joint > 0:
        condense(work.rows, part, n_joint, m, G, free)
    if m < 3 * n:
        spread_rows(work, i, m)
    for c in range(n):
        k = work.posed.islands.contact[work.posed.islands.start[i] + c]
        work.posed.own[k] = G[3 * c, 3 * c]
        work.posed.effect[k] = free[3 * c]
    if work.posed.lifted == 1:
        for r in range(3 * n):
            for c in range(n):
                free[r] -= G[r, 3 * c] * work.posed.counted[work.posed.islands.contact[work.posed.islands.start[i] + c]]


@kernel
def spread_rows(work: SpatialWork, i: int, m: int) -> None:
    """Three rows for contacts without friction as well: from the m rows that there are, the last first."""
    problem, contact, first = work.posed.problem, work.posed.islands.contact, work.posed.islands.start[i]
    G, free, part, n = problem.delassus, problem.free, work.posed.part, problem.n_contacts
    at = m
    for c in range(n - 1, -1, -1):
        rough = work.posed.tangent_of[contact[first + c]] >= 0
        at -= 3 if rough else 1
        for t in range(2, -1, -1):
            kept = t == 0 or rough
            r = 3 * c + t
            part[r] = part[at + t] if kept else -1
            free[r] = free[at + t] if kept else 0.0
            for e in range(m):
                G[r, e] = G[at + t, e] if kept else 0.0
    for r in range(3 * n):
        at = m
        for c in range(n - 1, -1, -1):
            rough = work.posed.tangent_of[contact[first + c]] >= 0
            at -= 3 if rough else 1
            for t in range(2, -1, -1):
                G[r, 3 * c + t] = G[r, at + t] if t == 0 or rough else 0.0


@kernel
def take_forces(work: SpatialWork) -> None:
    """Forces of the problem just solved to ``work.impulses.p``."""
    problem, part, p, n_joint = work.posed.problem, work.posed.part, work.impulses.p, work.rows.n_joint
    for r in range(3 * problem.n_contacts):
        if part[r] >= 0:
            p[n_joint + part[r]] = work.impulses.solver.group.p[r // 3, r % 3]


@kernel
def give_forces(work: SpatialWork) -> None:
    """Forces ``work.impulses.p`` to the problem posed: where its solver begins."""
    problem, part, p, n_joint = work.posed.problem, work.posed.part, work.impulses.p, work.rows.n_joint
    for r in range(3 * problem.n_contacts):
        work.impulses.solver.group.p[r // 3, r % 3] = p[n_joint + part[r]] if part[r] >= 0 else 0.0
