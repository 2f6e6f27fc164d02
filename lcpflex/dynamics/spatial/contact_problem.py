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
from lcpflex.solvers.contact.cones.dense import FLOOR
from lcpflex.solvers.contact.judging import measure_loads
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
    work.on_sets = 0
    work.shifted = 0
    work.lifted = 0
    for k in range(work.n_contacts):
        work.tangent_of[k] = -1
    for j in range(0, work.n_tangents, 2):
        work.tangent_of[work.tangent[j]] = j
    factor_joints(work)
    find_islands(work.islands, work.rows, work.solved, work.row_body, work.dof, work.n_joint, work.n_contacts)


@kernel
def has_joints(work: SpatialWork, i: int) -> bool:
    """Whether a contact of island i moves a body with joints."""
    n_joint, islands, first, row_body = work.n_joint, work.islands, work.joints.first, work.row_body
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
    group, scene, islands, n_joint, dof = work.solver.group, work.solver.scene, work.islands, work.n_joint, work.dof
    rows, solved, row_body, free = work.rows, work.solved, work.row_body, work.free
    own, unit, contact = group.own, group.unit, islands.contact
    first = islands.start[i]
    n = islands.start[i + 1] - first
    group.n = n
    for c in range(n):
        k = contact[first + c]
        r, j = n_joint + k, work.tangent_of[k]
        s = n_joint + work.n_contacts + j if j >= 0 else -1
        scene.normal[c], scene.tangent[c] = r, s
        group.law[c], group.mu[c] = COULOMB, work.mu[k] if s >= 0 else 0.0
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
        work.own[k] = nn
        work.effect[k] = free[r]
    contact_units(unit, n, DEAD)
    for c in range(n):
        group.load[c] = load_of(work, c)
    measure_loads(group, work.solver.judged)


@kernel
def load_of(work: SpatialWork, c: int) -> float:
    """Free velocity of contact c of the island, or what its terms make it worth, in its unit."""
    terms, free, n_joint = work.terms, work.solver.group.free, work.n_joint
    r, s = work.solver.scene.normal[c], work.solver.scene.tangent[c]
    size = max(abs(free[c, 0]), FLOOR * terms[r - n_joint])
    if s >= 0:
        size = max(size, max(abs(free[c, 1]), FLOOR * terms[s - n_joint]))
        size = max(size, max(abs(free[c, 2]), FLOOR * terms[s + 1 - n_joint]))
    return float(work.solver.group.unit[c] * size)


@kernel
def describe_contacts(work: SpatialWork, i: int) -> int:
    """Friction and names of the contacts of island i; in ``work.part`` the rows that there are, and their number."""
    problem, part, contact = work.problem, work.part, work.islands.contact
    first = work.islands.start[i]
    n = work.islands.start[i + 1] - first
    found = 0
    for c in range(n):
        k = contact[first + c]
        j = work.tangent_of[k]
        problem.friction[c] = work.mu[k] if j >= 0 else 0.0
        problem.key[c] = work.table.key[k]
        problem.pair[c] = work.table.law[k]
        if work.on_sets == 1:
            problem.mode[c] = work.mode[k]
        if work.shifted == 1:
            problem.least[c] = work.least[k]
        part[found] = k
        problem.terms[3 * c] = work.terms[k]
        problem.terms[3 * c + 1], problem.terms[3 * c + 2] = 0.0, 0.0
        found += 1
        if j >= 0:
            for t in range(2):
                part[found] = work.n_contacts + j + t
                problem.terms[3 * c + 1 + t] = work.terms[part[found]]
                found += 1
    problem.n_contacts, problem.n_tangents = n, 2 * n
    problem.on_sets = work.on_sets
    problem.shifted = work.shifted
    return found


@kernel
def pose_island(work: SpatialWork, i: int) -> None:
    """``work.problem`` of the contacts of island i, joints condensed."""
    m = describe_contacts(work, i)
    n_joint, problem, part = work.n_joint, work.problem, work.part
    G, free, n = problem.delassus, problem.free, problem.n_contacts
    delassus(work.rows[n_joint:], work.solved[n_joint:], work.row_body[n_joint:], part, m, G)
    for c in range(m):
        free[c] = work.free[n_joint + part[c]]
    if n_joint > 0:
        condense(work, part, n_joint, m, G, free)
    if m < 3 * n:
        spread_rows(work, i, m)
    for c in range(n):
        k = work.islands.contact[work.islands.start[i] + c]
        work.own[k] = G[3 * c, 3 * c]
        work.effect[k] = free[3 * c]
    if work.lifted == 1:
        for r in range(3 * n):
            for c in range(n):
                free[r] -= G[r, 3 * c] * work.counted[work.islands.contact[work.islands.start[i] + c]]


@kernel
def spread_rows(work: SpatialWork, i: int, m: int) -> None:
    """Three rows for contacts without friction as well: from the m rows that there are, the last first."""
    problem, contact, first = work.problem, work.islands.contact, work.islands.start[i]
    G, free, part, n = problem.delassus, problem.free, work.part, problem.n_contacts
    at = m
    for c in range(n - 1, -1, -1):
        rough = work.tangent_of[contact[first + c]] >= 0
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
            rough = work.tangent_of[contact[first + c]] >= 0
            at -= 3 if rough else 1
            for t in range(2, -1, -1):
                G[r, 3 * c + t] = G[r, at + t] if t == 0 or rough else 0.0


@kernel
def take_forces(work: SpatialWork) -> None:
    """Forces of the problem just solved to ``work.p``."""
    problem, part, p, n_joint = work.problem, work.part, work.p, work.n_joint
    for r in range(3 * problem.n_contacts):
        if part[r] >= 0:
            p[n_joint + part[r]] = work.solver.group.p[r // 3, r % 3]


@kernel
def give_forces(work: SpatialWork) -> None:
    """Forces ``work.p`` to the problem posed: where its solver begins."""
    problem, part, p, n_joint = work.problem, work.part, work.p, work.n_joint
    for r in range(3 * problem.n_contacts):
        work.solver.group.p[r // 3, r % 3] = p[n_joint + part[r]] if part[r] >= 0 else 0.0
