"""Contact problems in space that are not posed with their matrix: islands without joints.

Three rows a contact, (n, t1, t2). Forces p move the bodies by A^-1 W p, and contacts move with them. With joints the
Delassus operator is formed, see :mod:`lcpflex.dynamics.contact_problem`; forces go to and fro.
"""

from __future__ import annotations

from lcpflex.dynamics.spatial.inertia import SpatialWork
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.solvers.balance import DEAD, contact_units
from lcpflex.solvers.contact.judging import FLOOR, measure_loads
from lcpflex.solvers.contact.laws import COULOMB

__all__ = ["describe_island", "give_forces", "has_joints", "take_forces"]


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
