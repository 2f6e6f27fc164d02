"""Index sets of contacts in space, and their forces while the sets do not change.

    M udot = h + J^T lambda_J + (W_N - mu W_T d) lambda_N + W_H lambda_H,    d = gamma / |gamma|

A contact that slides has no tangential unknown: its friction points against its slip velocity gamma, a vector in the
tangent plane, and is a part of its normal column. The right-hand side is smooth as long as |gamma| > 0. Where gamma is
no more than the threshold below which slip counts as none, the direction is the one that is kept of each contact, as
a world vector: that in which the problem of accelerations lets it begin to slide, or that of its last step. Where it
has just begun, it is kept up to a thousand thresholds: slip that grows as slowly as the load turns at the rate
mu g / |gamma| into its direction, and steps that follow that were many and short.

Contacts that stick are bilateral in both tangents. Where they share a load in many ways, their forces are the shortest;
where some of them slide, those of :mod:`lcpflex.solvers.contact.cones.shares`, as the motion depends on them.
Where the shortest break Coulomb's law, although others do not, they are those nearest to a reference that was chosen at
the last event as far inside the law as there is (:mod:`lcpflex.solvers.contact.cones.reserve`), in the norm
sum x_N^2 / lambda_N + |x_T|^2 / (mu lambda_N) of that reference: contacts that carry more take more.
"""

from __future__ import annotations

import math
from typing import Any

from lcpflex.dynamics.acceleration import FORCE, POSITION, VELOCITY, eliminate, shorten, solve_consistent
from lcpflex.dynamics.contact_problem import pose_rows
from lcpflex.dynamics.delassus import row_velocity
from lcpflex.dynamics.impulse import answer_joints
from lcpflex.dynamics.spatial.inertia import SpatialWork
from lcpflex.dynamics.spatial.shared_sets import share_sets, slides
from lcpflex.dynamics.spatial.symmetric_sets import solve_symmetric
from lcpflex.dynamics.spatial.turning_slip import TurningSlip
from lcpflex.jit.kernel import FloatArray, IntArray, kernel
from lcpflex.jit.struct import allocate, array, struct
from lcpflex.kinematics.spatial.rotations import Vector, cross
from lcpflex.kinematics.spatial.vectors import dot, row_vector
from lcpflex.solvers.contact.cones.mixed import MixedMemory, mixed_memory
from lcpflex.solvers.contact.cones.mixed_problem import MixedProblem, mixed_problem
from lcpflex.solvers.contact.index_sets import SLIDE_FORTH, SMOOTH, STICKING

__all__ = [
    "BEGINS",
    "ON_ITS_WAY",
    "SLIDING",
    "SLOW",
    "SpatialContactSets",
    "across",
    "find_slips",
    "keep_direction",
    "pose_on_sets",
    "put_force",
    "reduce_sets",
    "slip_of",
    "solve_sets",
    "spatial_contact_sets",
    "spread",
]

SLIDING = SLIDE_FORTH  # along ``direction``
LIGHTEST = 1e-6  # of the largest force of the reference: less weighs no less
ON_ITS_WAY = 1e3  # thresholds: what is faster slides as it moves, not as it was to begin
FAST, SLOW, BEGINS = 0, 1, 2  # ContactSets.youth of a contact that slides


@struct
class SpatialContactSets:
    """Index sets of the contacts in the table; dense: contacts that one island may have, rows: three times as many.

    Fields that the plane has, too, mean the same.
    """

    mode: IntArray = array("contacts")  # SMOOTH, STICKING or SLIDING
    tangent_of: IntArray = array("contacts")  # first tangential row of each contact, -1: frictionless
    tried: IntArray = array("contacts")
    kept: IntArray = array("contacts")
    fallback: IntArray = array("contacts")
    youth: IntArray = array("contacts")  # BEGINS: just now; SLOW: slower than the threshold since; else FAST
    direction: FloatArray = array("contacts", 3)  # of slip, kept, world axes
    along: FloatArray = array("contacts", 2)  # of slip at the present state, in the tangents
    miss: FloatArray = array("contacts")  # force that its acceleration is worth where the sets cannot all be kept [N]
    chosen: FloatArray = array("contacts", 4)  # normal force and friction (world) of the problem of accelerations
    at: IntArray = array("dense")  # first tangential unknown of each contact of the island, -1: none
    row_here: IntArray = array("dense")  # its first tangential row in the island's operator, -1: none
    place: IntArray = array("rows")  # of each unknown in that operator
    free: FloatArray = array("rows")  # right-hand side of that operator
    reduced: FloatArray = array("rows", "rows")
    right: FloatArray = array("rows")
    solution: FloatArray = array("rows")
    reference: FloatArray = array("rows")
    scale: FloatArray = array("rows")
    slack: FloatArray = array("rows")
    order: IntArray = array("rows")
    problem: MixedProblem
    search: MixedMemory
    turning: TurningSlip
    level: int
    n_stick: int
    referred: int  # 1: forces are those nearest to ``chosen``
    slow: float  # slower slip counts as none [m/s]


def spatial_contact_sets(capacity: int, dense: int | None = None) -> SpatialContactSets:
    """Memory for ``capacity`` contacts, islands of up to ``dense`` ones: all by default."""
    room = capacity if dense is None else dense
    sizes = {"contacts": capacity, "dense": room, "rows": 3 * room}
    turning = allocate(TurningSlip, sizes)
    return allocate(SpatialContactSets, sizes, problem=mixed_problem(room), search=mixed_memory(room), turning=turning)


@kernel
def across(work: SpatialWork, k: int) -> tuple[Vector, Vector]:
    """Both tangents of entry k, world axes."""
    first = row_vector(work.rows.table.tangent, k)
    return first, cross(row_vector(work.rows.table.normal, k), first)


@kernel
def slip_of(work: SpatialWork, sets: SpatialContactSets, k: int, u: FloatArray) -> tuple[float, float]:
    """gamma of a contact with friction, by the rows laid [m/s]."""
    r = work.rows.n_joint + work.rows.n_contacts + sets.tangent_of[k]
    first = row_velocity(work.rows.J, work.rows.body, r, work.rows.dof, u)
    return first, row_velocity(work.rows.J, work.rows.body, r + 1, work.rows.dof, u)


@kernel
def keep_direction(work: SpatialWork, sets: SpatialContactSets, k: int, first: float, second: float) -> None:
    """Keep the direction of first t1 + second t2, not 0, as that in which contact k slides."""
    size = math.hypot(first, second)
    t, s = across(work, k)
    for i in range(3):
        sets.direction[k, i] = (first * t[i] + second * s[i]) / size
    sets.along[k, 0], sets.along[k, 1] = first / size, second / size


@kernel
def find_slips(work: SpatialWork, sets: SpatialContactSets, u: FloatArray) -> None:
    """``along`` of the contacts that slide, by the rows laid and the velocity u."""
    for k in range(work.rows.n_contacts):
        if sets.mode[k] != SLIDING:
            continue
        first, second = slip_of(work, sets, k, u)
        size = math.hypot(first, second)
        if not size > sets.slow * (1.0 if sets.youth[k] == FAST else ON_ITS_WAY):
            t, s = across(work, k)
            kept = row_vector(sets.direction, k)
            first, second = dot(kept, t), dot(kept, s)
            size = math.hypot(first, second)
        if size > 0.0:
            sets.along[k, 0], sets.along[k, 1] = first / size, second / size


@kernel
def pose_on_sets(work: SpatialWork, sets: SpatialContactSets, i: int) -> int:
    """The operator of island i, joints condensed, to ``scratch.G``: its normal rows, then pairs of tangential ones."""
    part, contact = work.posed.part, work.posed.islands.contact
    problem, table = work.posed.problem, work.rows.table
    first = work.posed.islands.start[i]
    n = work.posed.islands.start[i + 1] - first
    m = n
    for c in range(n):
        k = contact[first + c]
        part[c] = k
        problem.friction[c] = work.rows.mu[k]
        problem.key[c] = table.key[k]
        problem.pair[c] = table.law[k]
        j = sets.tangent_of[k]
        sets.row_here[c] = m if j >= 0 else -1
        if j >= 0:
            part[m] = work.rows.n_contacts + j
            part[m + 1] = work.rows.n_contacts + j + 1
            m += 2
    problem.n_contacts = n
    problem.n_tangents = m - n
    pose_rows(work, m, work.scratch.G, sets.free)
    return n


@kernel
def holds(sets: SpatialContactSets, k: int) -> bool:
    """Whether contact k has tangential unknowns at the present level: what begins to slide is stopped before."""
    if sets.level == POSITION:
        return False
    return sets.mode[k] == STICKING or (sets.level == VELOCITY and sets.mode[k] == SLIDING and sets.youth[k] == BEGINS)


@kernel
def reduce_sets(work: SpatialWork, sets: SpatialContactSets) -> int:
    """Rows and columns [normals with sliding friction, pairs of those that stick] of the island posed last; how many.

    Sliding friction counts at the level of forces only.
    """
    n, G, part, place = work.posed.problem.n_contacts, work.scratch.G, work.posed.part, sets.place
    m = n
    for c in range(n):
        place[c] = c
        sets.at[c] = -1
        if sets.row_here[c] >= 0 and holds(sets, part[c]):
            sets.at[c] = m
            place[m], place[m + 1] = sets.row_here[c], sets.row_here[c] + 1
            m += 2
    for r in range(m):
        i = place[r]
        sets.right[r] = sets.free[i]
        for s in range(m):
            sets.reduced[r, s] = G[i, place[s]]
        for c in range(n):
            k = part[c]
            if sets.level == FORCE and sets.mode[k] == SLIDING:
                j = sets.row_here[c]
                sets.reduced[r, c] -= work.rows.mu[k] * (sets.along[k, 0] * G[i, j] + sets.along[k, 1] * G[i, j + 1])
    sets.n_stick = (m - n) // 2
    return m


@kernel
def refer(work: SpatialWork, sets: SpatialContactSets, m: int) -> None:
    """The forces chosen to ``reference``, and what they leave to ``right``."""
    for c in range(work.posed.problem.n_contacts):
        k, t = work.posed.part[c], sets.at[c]
        sets.reference[c] = sets.chosen[k, 0]
        if t >= 0:
            first, second = across(work, k)
            friction = (sets.chosen[k, 1], sets.chosen[k, 2], sets.chosen[k, 3])
            sets.reference[t], sets.reference[t + 1] = dot(friction, first), dot(friction, second)
    for r in range(m):
        for s in range(m):
            sets.right[r] += sets.reduced[r, s] * sets.reference[s]


@kernel
def weigh(work: SpatialWork, sets: SpatialContactSets, m: int, rank: int) -> None:
    """Columns of the eliminated system by the roots of the forces of the reference, which go to ``slack``."""
    n, largest = work.posed.problem.n_contacts, 0.0
    for c in range(n):
        largest = max(largest, sets.reference[c])
    for c in range(n):
        force, t = max(sets.reference[c], LIGHTEST * largest), sets.at[c]
        sets.slack[c] = math.sqrt(force / largest) if largest > 0.0 else 1.0
        if t >= 0:
            sets.slack[t] = sets.slack[c] * math.sqrt(work.rows.mu[work.posed.part[c]])
            sets.slack[t + 1] = sets.slack[t]
    for r in range(m):
        sets.slack[r] /= sets.scale[r]
    for k in range(rank):
        for j in range(k, m):
            sets.reduced[k, j] *= sets.slack[sets.order[j]]


@kernel
def solve_nearest(work: SpatialWork, sets: Any, m: int) -> None:
    """solution = -reduced^-1 right, the one nearest to ``reference`` where rows are dependent; see ``refer``."""
    a, b = sets.reduced, sets.right
    for i in range(m):
        sets.order[i] = i
        sets.scale[i] = 1.0 / math.sqrt(abs(a[i, i])) if a[i, i] != 0.0 else 1.0
    for i in range(m):
        b[i] *= -sets.scale[i]
        for j in range(m):
            a[i, j] *= sets.scale[i] * sets.scale[j]
    rank = eliminate(sets, m)
    weigh(work, sets, m, rank)
    for k in range(rank - 1, -1, -1):
        for j in range(k + 1, rank):
            b[k] -= a[k, j] * b[j]
        b[k] /= a[k, k]
    if rank < m:
        shorten(sets, rank, m)
    for k in range(m):
        i = sets.order[k]
        sets.solution[i] = sets.reference[i] + b[k] * sets.slack[i] * sets.scale[i]


@kernel
def is_symmetric(work: SpatialWork, sets: SpatialContactSets) -> bool:
    """Whether no friction of contacts that slide is in the columns of the island posed last."""
    for c in range(work.posed.problem.n_contacts):
        k = work.posed.part[c]
        if sets.level == FORCE and sets.mode[k] == SLIDING and work.rows.mu[k] > 0.0:
            return False
    return True


@kernel
def solve_sets(work: SpatialWork, sets: SpatialContactSets, level: int) -> None:
    """Forces or impulses ``work.impulses.p`` of all rows with the sets as they are, island by island."""
    sets.level = level
    for i in range(work.posed.islands.count):
        pose_on_sets(work, sets, i)
        m = reduce_sets(work, sets)
        referred = level == FORCE and sets.referred == 1
        if referred:
            refer(work, sets, m)
            solve_nearest(work, sets, m)
        elif is_symmetric(work, sets):
            solve_symmetric(work, sets, m)
        else:
            rank = solve_consistent(sets, m)
            if rank < m and level == FORCE and slides(work, sets):
                reduce_sets(work, sets)
                share_sets(work, sets, m)
        spread(work, sets, sets.solution)
        if level == FORCE:
            note_misses(work, sets)
    work.posed.islands.next = work.posed.islands.count
    answer_joints(work)


@kernel
def note_misses(work: SpatialWork, sets: SpatialContactSets) -> None:
    """Of each contact of the island posed last the largest acceleration that its set forbids, as the force of its row.

    It is rounding, but where more is kept than can be: a box that is held to the ground and to fingers that rise.
    """
    n, G = work.posed.problem.n_contacts, work.scratch.G
    part, p, n_joint = work.posed.part, work.impulses.p, work.rows.n_joint
    rows = n + work.posed.problem.n_tangents
    for c in range(n):
        k, j = part[c], sets.row_here[c]
        held = j >= 0 and holds(sets, k)
        miss = 0.0
        for x in range(3 if held else 1):
            r = c if x == 0 else j + x - 1
            total = sets.free[r]
            for s in range(rows):
                total += G[r, s] * p[n_joint + part[s]]
            if G[r, r] > 0.0:
                miss = max(miss, abs(total) / G[r, r])
        sets.miss[k] = miss


@kernel
def spread(work: SpatialWork, sets: SpatialContactSets, x: FloatArray) -> None:
    """Forces or impulses p of the contacts of the island posed last from the unknowns x of its reduced system."""
    part, n_joint, p = work.posed.part, work.rows.n_joint, work.impulses.p
    for c in range(work.posed.problem.n_contacts):
        k, j, t = part[c], sets.row_here[c], sets.at[c]
        p[n_joint + k] = x[c]
        if j < 0:
            continue
        r = n_joint + part[j]
        p[r], p[r + 1] = 0.0, 0.0
        if t >= 0:
            p[r], p[r + 1] = x[t], x[t + 1]
        elif sets.level == FORCE and sets.mode[k] == SLIDING:
            p[r], p[r + 1] = -work.rows.mu[k] * sets.along[k, 0] * x[c], -work.rows.mu[k] * sets.along[k, 1] * x[c]


@kernel
def put_force(work: SpatialWork, sets: SpatialContactSets, k: int) -> None:
    """The force of contact k in ``work.impulses.p`` to ``chosen``."""
    sets.chosen[k, 0] = work.impulses.p[work.rows.n_joint + k]
    sets.chosen[k, 1], sets.chosen[k, 2], sets.chosen[k, 3] = 0.0, 0.0, 0.0
    if sets.tangent_of[k] >= 0 and sets.mode[k] != SMOOTH:
        r = work.rows.n_joint + work.rows.n_contacts + sets.tangent_of[k]
        t, s = across(work, k)
        for i in range(3):
            sets.chosen[k, 1 + i] = work.impulses.p[r] * t[i] + work.impulses.p[r + 1] * s[i]
