"""The contact problem at acceleration level, on index sets.

    M udot = h + J^T lambda_J + (W_N + W_G mu_G) lambda_N + W_H lambda_H,    J udot + b = 0

The contacts of the table are all closed with gdot_N = 0 (set N). Those that may stick (set H) have a tangential
unknown; sliding ones (set G) have none: mu_G = -mu sign(gdot_T) is a part of their normal column. Two questions are
asked:

* which contacts stay closed, stick, slip which way: the LCP of size n_N + 2 n_H (:func:`pose_sets`);
* what are the forces while that does not change: one linear solve (:func:`fixed_forces`), whose
  shortest solution is taken where contacts are redundant: the motion is the same.

Sources: Pfeiffer & Glocker 1996; Glocker & Studer 2005.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from lcpflex.contact.narrow_phase.feature import refresh
from lcpflex.contact.table import ContactTable
from lcpflex.dynamics.contact_forces import add_contact_forces
from lcpflex.dynamics.contact_problem import fits, lay_contacts, list_tangents, pose_island
from lcpflex.dynamics.delassus import apply_impulses, free_velocities, row_velocity
from lcpflex.dynamics.impulse import answer_joints
from lcpflex.dynamics.islands import forget_islands
from lcpflex.dynamics.mechanics import (
    contact_biases,
    count_rows,
    displace,
    factorise,
    fill_contact_rows,
    fill_joint_rows,
    forces,
    solve_rows,
    solve_vector,
    supply,
)
from lcpflex.dynamics.workspace import Workspace
from lcpflex.jit.kernel import FloatArray, IntArray, kernel
from lcpflex.jit.leaf import in_space
from lcpflex.jit.struct import allocate, array, struct
from lcpflex.kinematics.joint_rows import joint_residual
from lcpflex.model.arrays import Model
from lcpflex.solvers.contact.algebra import PLANAR
from lcpflex.solvers.contact.index_sets import (
    SLIDE_BACK,
    SLIDE_FORTH,
    SMOOTH,
    STICKING,
    reduce_columns,
    sliding_sign,
)

__all__ = [
    "SMOOTH",
    "SLIDE_BACK",
    "SLIDE_FORTH",
    "STICKING",
    "ContactSets",
    "assemble",
    "contact_sets",
    "fixed_forces",
    "lay_rows",
    "pose_sets",
    "position_errors",
    "project",
    "reduce_sets",
    "room_for",
    "sliding_sign",
]

POSITION, VELOCITY, FORCE = 0, 1, 2  # what is solved for, ContactSets.level

DEPENDENT = 1e-11  # a pivot below this part of the largest, of a matrix with unit diagonal, is a dependent row


@struct
class ContactSets:
    """Index sets of the contacts in the table, and the memory of the linear solve of an island.

    dense: contacts that one island may have; rows: twice as many.
    """

    mode: IntArray = array("contacts")  # SMOOTH, STICKING, SLIDE_FORTH or SLIDE_BACK
    tangent_of: IntArray = array("contacts")  # tangential row of each contact, -1: frictionless
    tried: IntArray = array("contacts")  # modes that the problem of accelerations has chosen
    kept: IntArray = array("contacts")  # 1: carries a force there
    fallback: IntArray = array("contacts")  # modes to return to where a simpler choice breaks its own law
    stick: IntArray = array("dense")  # contacts of the set H in the island
    here: IntArray = array("dense")  # modes of the contacts of the island
    row_here: IntArray = array("dense")  # and their tangential rows
    reduced: FloatArray = array("rows", "rows")  # columns with sliding friction in the normal ones
    right: FloatArray = array("rows")
    solution: FloatArray = array("rows")
    scale: FloatArray = array("rows")
    order: IntArray = array("rows")
    level: int  # POSITION, VELOCITY or FORCE
    n_stick: int  # contacts in H, of the island


def contact_sets(capacity: int, dense: int | None = None, in_space: bool = False) -> Any:
    """Memory for ``capacity`` contacts, islands of up to ``dense`` ones: all by default."""
    if in_space:
        from lcpflex.dynamics.spatial.acceleration import spatial_contact_sets

        return spatial_contact_sets(capacity, dense)
    room = capacity if dense is None else dense
    return allocate(ContactSets, {"contacts": capacity, "dense": room, "rows": 2 * room})


@in_space("lcpflex.contact.spatial.manifold.renewal")
@kernel
def renew_weights(model: Model, q: FloatArray, n: int, table: ContactTable) -> None:
    """Weights by which the first n entries share loads, at q; in the plane there are none."""


@kernel
def lay_rows(model: Model, t: float, q: FloatArray, u: FloatArray, n: int, work: Workspace, sets: ContactSets) -> None:
    """Rows of joints and of the first n contacts at q, their A^-1 rows and their Delassus operator."""
    n_joint = len(work.scratch.residual)
    supply(model, t, q, u, work)
    factorise(model, q, 0.0, 0.0, work)
    if n_joint > 0:
        fill_joint_rows(model, t, q, u, work.free.external, work.rows)
    for k in range(n):
        refresh(model, q, work.rows.table, k)
    renew_weights(model, q, n, work.rows.table)
    n_tangent = fill_contact_rows(model, q, n, n_joint, work.rows)
    solve_rows(model, work.rows, 0, n_joint + n + n_tangent)
    count_rows(work.rows, n_joint, n, n_tangent)
    list_tangents(work.rows, sets.tangent_of)


@kernel
def assemble(model: Model, t: float, q: FloatArray, u: FloatArray, n: int, work: Workspace, sets: ContactSets) -> None:
    """Condensed operator and free accelerations of the first n contacts; ``work.free.u`` = M^-1 h [m/s^2]."""
    lay_rows(model, t, q, u, n, work, sets)
    forces(model, t, q, u, work)
    add_contact_forces(model, q, u, work)
    contact_biases(model, q, u, n, work.rows.n_tangents, work.rows.n_joint, work.rows)
    for i in range(len(u)):
        work.free.u[i] = work.free.total[i]
    solve_vector(model, work, work.free.u)
    n_joint = work.rows.n_joint
    total = n_joint + n + work.rows.n_tangents
    free_velocities(
        work.rows.J, work.rows.body, n_joint, total, work.rows.dof, work.free.u, work.free.v, work.free.terms
    )
    for r in range(total):
        work.free.v[r] += work.rows.bias[r]
    for r in range(n_joint, total):
        work.free.terms[r - n_joint] += abs(work.rows.bias[r])
    lay_contacts(work)


@in_space("lcpflex.dynamics.spatial.acceleration")
@kernel
def reduce_sets(work: Workspace, sets: ContactSets) -> int:
    """Columns [N with sliding friction, H] of the island posed last; returns the number of its contacts in H.

    Sliding friction counts at the level of forces only, sticking not at that of positions.
    """
    sliding, sticking = sets.level == FORCE, sets.level != POSITION
    problem = work.posed.problem
    for c in range(problem.n_contacts):
        sets.here[c] = sets.mode[work.posed.part[c]]
        sets.row_here[c] = -1
    for j in range(problem.n_tangents):
        sets.row_here[problem.tangent[j]] = j
    n_stick = reduce_columns(problem, sets.here, sets.row_here, sliding, sticking, sets.stick, sets.reduced, sets.right)
    sets.n_stick = n_stick
    return n_stick


@kernel
def pose_sets(work: Workspace, sets: ContactSets) -> int:
    """Let the sets count in the contact problems just laid; returns the size of H."""
    work.posed.on_sets = 1
    sets.level = FORCE
    n_stick = 0
    for k in range(work.rows.n_contacts):
        work.posed.mode[k] = sets.mode[k]
        if sets.mode[k] == STICKING:
            n_stick += 1
    return n_stick


@kernel
def eliminate(sets: ContactSets, m: int) -> int:
    """Upper triangle of ``reduced`` and ``right`` by complete pivoting, columns in ``order``; returns the rank."""
    a = sets.reduced
    b = sets.right
    for k in range(m):
        r, s = k, k
        for i in range(k, m):
            for j in range(k, m):
                if abs(a[i, j]) > abs(a[r, s]):
                    r, s = i, j
        if not abs(a[r, s]) > DEPENDENT:
            return k
        if r != k:
            b[k], b[r] = b[r], b[k]
            for j in range(k, m):
                a[k, j], a[r, j] = a[r, j], a[k, j]
        if s != k:
            sets.order[k], sets.order[s] = sets.order[s], sets.order[k]
            for i in range(m):
                a[i, k], a[i, s] = a[i, s], a[i, k]
        for i in range(k + 1, m):
            factor = a[i, k] / a[k, k]
            if factor != 0.0:
                b[i] -= factor * b[k]
                for j in range(k + 1, m):
                    a[i, j] -= factor * a[k, j]
    return m


@kernel
def shorten(sets: ContactSets, rank: int, m: int) -> None:
    """Of all solutions of a system of less than full rank the shortest: it depends continuously on the state.

    In the order of elimination: right[:rank] is the solution with the other unknowns 0. With the null vectors
    [-U^-1 V; I] of reduced = [U V], those unknowns c minimise |x|: (I + N^T N) c = N^T x, N = U^-1 V.
    """
    a = sets.reduced
    b = sets.right
    free = m - rank
    for j in range(rank, m):
        for k in range(rank - 1, -1, -1):
            for i in range(k + 1, rank):
                a[k, j] -= a[k, i] * a[i, j]
            a[k, j] /= a[k, k]
    for i in range(free):  # Cholesky factor in rows rank:m, columns rank:m; right-hand side in right[rank:m]
        b[rank + i] = 0.0
        for k in range(rank):
            b[rank + i] += a[k, rank + i] * b[k]
        for j in range(i + 1):
            total = 1.0 if i == j else 0.0
            for k in range(rank):
                total += a[k, rank + i] * a[k, rank + j]
            for k in range(j):
                total -= a[rank + i, rank + k] * a[rank + j, rank + k]
            a[rank + i, rank + j] = math.sqrt(total) if i == j else total / a[rank + j, rank + j]
    for i in range(free):
        for k in range(i):
            b[rank + i] -= a[rank + i, rank + k] * b[rank + k]
        b[rank + i] /= a[rank + i, rank + i]
    for i in range(free - 1, -1, -1):
        for k in range(i + 1, free):
            b[rank + i] -= a[rank + k, rank + i] * b[rank + k]
        b[rank + i] /= a[rank + i, rank + i]
    for k in range(rank):
        for j in range(rank, m):
            b[k] -= a[k, j] * b[j]


@kernel
def solve_consistent(sets: Any, m: int) -> int:
    """solution = -reduced^-1 right, the shortest one (scaled to a unit diagonal) where rows are dependent; the rank."""
    a = sets.reduced
    b = sets.right
    for i in range(m):
        sets.order[i] = i
        sets.scale[i] = 1.0 / np.sqrt(abs(a[i, i])) if a[i, i] != 0.0 else 1.0
    for i in range(m):
        b[i] *= -sets.scale[i]
        for j in range(m):
            a[i, j] *= sets.scale[i] * sets.scale[j]
    rank = eliminate(sets, m)
    for k in range(rank - 1, -1, -1):
        for j in range(k + 1, rank):
            b[k] -= a[k, j] * b[j]
        b[k] /= a[k, k]
    if rank < m:
        shorten(sets, rank, m)
    for k in range(m):
        i = sets.order[k]
        sets.solution[i] = b[k] * sets.scale[i]
    return rank


@in_space("lcpflex.dynamics.spatial.acceleration")
@kernel
def solve_sets(work: Workspace, sets: ContactSets, level: int) -> None:
    """Forces or impulses ``work.impulses.p`` of all rows with the sets as they are, island by island."""
    sets.level = level
    for i in range(work.posed.islands.count):
        pose_island(work, i, PLANAR)
        n_stick = reduce_sets(work, sets)
        solve_consistent(sets, work.posed.problem.n_contacts + n_stick)
        spread(work, sets)
    work.posed.islands.next = work.posed.islands.count
    answer_joints(work)


@kernel
def spread(work: Workspace, sets: ContactSets) -> None:
    """Forces or impulses p of the contacts of the island posed last from the solution of its reduced system."""
    problem, part, n_joint = work.posed.problem, work.posed.part, work.rows.n_joint
    n = problem.n_contacts
    for j in range(problem.n_tangents):
        c = problem.tangent[j]
        sign = sliding_sign(sets.here[c]) if sets.level == FORCE else 0.0
        work.impulses.p[n_joint + part[n + j]] = -sign * problem.friction[c] * sets.solution[c] if sign != 0.0 else 0.0
    for c in range(n):
        work.impulses.p[n_joint + part[c]] = sets.solution[c]
    for j in range(sets.n_stick):
        work.impulses.p[n_joint + part[n + sets.row_here[sets.stick[j]]]] = sets.solution[n + j]


@kernel
def fixed_forces(work: Workspace, sets: ContactSets) -> None:
    """Constraint forces ``work.impulses.p`` with the sets as they are, and the acceleration in ``work.free.u``."""
    solve_sets(work, sets, FORCE)
    total = work.rows.n_joint + work.rows.n_contacts + work.rows.n_tangents
    apply_impulses(work.rows.solved, work.rows.body, 0, total, work.impulses.p, work.rows.dof, work.free.u)


@kernel
def room_for(model: Model, t: float, q: FloatArray, u: FloatArray, n: int, work: Workspace, sets: ContactSets) -> bool:
    """Whether there is room for the problem of each island of the first n contacts of the table."""
    if n <= len(work.posed.problem.friction):
        return True
    lay_rows(model, t, q, u, n, work, sets)
    lay_contacts(work)
    room = True
    for i in range(work.posed.islands.count):
        room = fits(work, i) and room
    forget_islands(work.posed.islands)
    return room


@kernel
def position_errors(model: Model, t: float, q: FloatArray, n: int, work: Workspace) -> tuple[float, float]:
    """Residuals of joints and gaps to ``work.free.v``, 0 for tangents; the largest of each."""
    n_joint = len(work.scratch.residual)
    if n_joint > 0:
        joint_residual(model, t, q, work.free.external, work.scratch.residual)
    joint_drift = 0.0
    gap_drift = 0.0
    for r in range(n_joint):
        work.free.v[r] = work.scratch.residual[r]
        joint_drift = max(joint_drift, abs(work.scratch.residual[r]))
    for k in range(n):
        work.free.v[n_joint + k] = work.rows.table.gap[k]
        gap_drift = max(gap_drift, abs(work.rows.table.gap[k]))
    for r in range(n_joint + n, n_joint + n + work.rows.n_tangents):
        work.free.v[r] = 0.0
    return joint_drift, gap_drift


@kernel
def project(
    model: Model, t: float, q: FloatArray, u: FloatArray, n: int, velocities: bool, work: Workspace, sets: ContactSets
) -> tuple[float, float]:
    """Put q on the joints and the gaps of the first n contacts to zero: nearest in the mass metric. Lays rows.

    With ``velocities``, u then goes onto the velocity constraints of joints, closed gaps and sticking contacts.
    Returns the largest violation of a joint and of a gap that was found [m or rad, m].
    """
    n_joint = len(work.scratch.residual)
    joint_drift = 0.0
    gap_drift = 0.0
    if n_joint + n == 0:
        return joint_drift, gap_drift
    largest = 1.0
    for i in range(len(q)):
        largest = max(largest, abs(q[i]))
    left = 6 + (1 if velocities else 0)  # corrections: of positions, the last of velocities
    while left > 0:
        lay_rows(model, t, q, u, n, work, sets)
        total = n_joint + n + work.rows.n_tangents
        worst = position_errors(model, t, q, n, work)
        if joint_drift + gap_drift == 0.0:
            joint_drift = worst[0]
            gap_drift = worst[1]
        size = max(worst[0], worst[1])
        if size <= 1e-14 * largest or (left == 1 and velocities):
            left = 1 if velocities else 0
        if left == 0:
            break
        if left == 1 and velocities:
            for r in range(total):
                work.free.v[r] = row_velocity(work.rows.J, work.rows.body, r, work.rows.dof, u)
                if r < n_joint:
                    work.free.v[r] += work.rows.rate[r]
        lay_contacts(work)
        solve_sets(work, sets, VELOCITY if left == 1 and velocities else POSITION)
        if left == 1 and velocities:
            apply_impulses(work.rows.solved, work.rows.body, 0, total, work.impulses.p, work.rows.dof, u)
        else:
            displace(model, work.rows, 0, total, work.impulses.p, q)
        left -= 1
    return joint_drift, gap_drift
