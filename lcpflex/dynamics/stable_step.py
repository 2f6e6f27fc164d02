"""The step that an explicit scheme admits where contacts give way: frequencies with contacts closed and joints held.

No frequency of M udd + (K + W F^-1 W^T) q = 0 on J u = 0 exceeds sqrt(s), W being the rows of closed normals and of
tangents that stick, if and only if on J u = 0 the matrix A = M - K/s, and then

    F - W^T (A^-1 - A^-1 J^T S^-1 J A^-1) W / s,   S = J A^-1 J^T

are positive semidefinite: exact, by Schur's complements, without an eigenvalue. A itself need not be positive: modes
that joints stop vibrate far below their own frequency. It is on J u = 0 if S has as many negative eigenvalues as A,
which the pivots of S tell. The force of sliding contacts is no spring, and not in it.
"""

from __future__ import annotations

import math

from lcpflex.dynamics.delassus import delassus
from lcpflex.dynamics.inertia import solve_block
from lcpflex.dynamics.mechanics import factorise, solve_rows
from lcpflex.dynamics.workspace import Workspace
from lcpflex.jit.kernel import FloatArray, IntArray, kernel, late_kernel
from lcpflex.jit.leaf import in_space
from lcpflex.jit.struct import array, struct
from lcpflex.kinematics.joint_rows import joint_rows
from lcpflex.kinematics.modal_places import first_mode, first_rate
from lcpflex.model.arrays import Model
from lcpflex.solvers.contact.compiled import sticks
from lcpflex.solvers.semidefinite import dot

__all__ = ["HeldRows", "admissible", "admit", "is_admitted"]

REDUNDANT = 1e-10  # pivot, relative to the compliance of its row, that counts as zero


@struct
class HeldRows:
    """Scratch for joints: those of the step wait in the workspace for the next one."""

    rows: FloatArray = array("joints", 2, "width")
    solved: FloatArray = array("joints", 2, "width")  # A^-1 rows
    row_body: IntArray = array("joints", 2)
    wrench: FloatArray = array("joints", "reaction")
    rate: FloatArray = array("joints")
    bias: FloatArray = array("joints")
    part: IntArray = array("joints")  # those that may matter
    S: FloatArray = array("joints", "joints")  # of these, and what is left of it
    size: FloatArray = array("joints")  # sums of the magnitudes of the terms of its diagonal
    pivot: FloatArray = array("joints")  # 0 of dependent rows
    order: IntArray = array("joints")  # of the pivots
    spring: IntArray = array("pairs")  # rows of the contact problem that are springs
    coupling: FloatArray = array("pairs", "joints")  # of each of these rows, eliminated
    bodies: IntArray = array("bodies")  # 1: joints on it may matter
    width: IntArray = array("bodies")  # velocities of each up to the last one that has a mass
    key: IntArray = array("pairs")  # contacts that were admitted last, in space
    sticks: IntArray = array("pairs")  # 1: it stuck then
    n_admitted: int
    admitted: float  # square of the frequency that they were admitted with [1/s^2]
    age: int  # how often this was made use of


@kernel
def semidefinite(A: FloatArray, n: int, scale: FloatArray, part: IntArray) -> bool:
    """Whether the symmetric A[:n, :n] is positive semidefinite; its lower triangle is overwritten by its factor.

    To rounding, relative to the diagonal of ``scale`` at the places ``part`` (n,): contacts at one place are redundant.
    """
    for i in range(n):
        own = scale[part[i], part[i]]
        for j in range(i + 1):
            total = A[i, j] - dot(A[i], A[j], 0, j)
            if j == i:
                if not total >= -REDUNDANT * own:
                    return False
                A[i, i] = math.sqrt(total) if total > REDUNDANT * own else 0.0
            elif A[j, j] > 0.0:
                A[i, j] = total / A[j, j]
            elif total * total > REDUNDANT * own * scale[part[j], part[j]]:
                return False
            else:
                A[i, j] = 0.0
    return True


@in_space("lcpflex.dynamics.spatial.admitted")
@kernel
def is_admitted(held: HeldRows, work: Workspace, square: float) -> bool:
    """Whether contacts of the present solution were found to admit sqrt(square) [1/s] of late: in the plane never."""
    return False


@in_space("lcpflex.dynamics.spatial.admitted")
@kernel
def admit(held: HeldRows, work: Workspace, square: float) -> None:
    """Keep the contacts of the present solution as such: in the plane nothing."""


@in_space("lcpflex.dynamics.spatial.position")
@kernel
def stiffens(work: Workspace, r: int) -> bool:
    """Whether contact row r is a spring in the present solution: a normal that is closed, a tangent that sticks."""
    n = work.rows.n_contacts
    if r < n:
        return work.impulses.solver.normal[r] > 0.0
    return sticks(work.posed.problem, work.impulses.solver, r - n)


@kernel
def fast_modes(model: Model, square: float, flexibility: FloatArray) -> int:
    """How many modes with a mass have a frequency from sqrt(square) on, free as they are."""
    bodies = model.bodies
    count = 0
    for b in range(len(bodies.mass)):
        first = first_rate(model, b)
        own = first_mode(model, b)
        for i in range(bodies.dof[b + 1] - first):
            if flexibility[first + i] == 0.0 and not bodies.stiffness[own + i] < square:
                count += 1
    return count


@kernel
def admissible(
    model: Model,
    q: FloatArray,
    square: float,
    flexibility: FloatArray,
    unit: FloatArray,
    held: HeldRows,
    work: Workspace,
) -> bool:
    """Whether no frequency of the system with its contacts as they are closed exceeds sqrt(square) [1/s].

    Joints only lower the frequencies, and are looked at where that decides. Overwrites the factors of M, and the solved
    rows of the contacts.
    """
    joints = len(work.scratch.residual)
    fast = fast_modes(model, square, flexibility)
    if fast > 0 and joints == 0:
        return False
    springs = list_springs(work, held)
    if springs == 0 and fast == 0:
        return True
    factorise(model, q, 0.0, -1.0 / square, work)
    for s in range(springs):
        r = joints + work.posed.part[held.spring[s]]
        solve_rows(model, work.rows, r, r + 1)
        clear_static(model, work, flexibility, r)
    measure_widths(model, flexibility, held)
    if fast == 0:
        respond_as_springs(work, held, square, unit, springs)
        if semidefinite(work.scratch.G, springs, work.posed.problem.delassus, held.spring):
            return True
        if joints == 0:
            return False
    n = factorise_held(model, q, square, flexibility, held, work, fast)
    if n < 0:
        return False
    if springs == 0:
        return True
    respond_as_springs(work, held, square, unit, springs)
    add_held(work, held, n, springs, 1.0 / (square * unit[1]))
    return semidefinite(work.scratch.G, springs, work.posed.problem.delassus, held.spring)


@kernel
def list_springs(work: Workspace, held: HeldRows) -> int:
    """held.spring: rows of the problem posed that are springs in its solution; how many there are."""
    problem, part, count = work.posed.problem, work.posed.part, 0
    for i in range(problem.n_contacts + problem.n_tangents):
        if part[i] >= 0 and stiffens(work, part[i]):
            held.spring[count] = i
            count += 1
    return count


@kernel
def respond_as_springs(work: Workspace, held: HeldRows, square: float, unit: FloatArray, springs: int) -> None:
    """G <- F - W^T A^-1 W / s of the contact rows that are springs, as if no joint held them."""
    rows, part, spring, joints = work.rows, work.posed.part, held.spring, len(work.scratch.residual)
    scale, width, G, F = 1.0 / (square * unit[1]), held.width, work.scratch.G, work.posed.problem.delassus
    for a in range(springs):
        r = joints + part[spring[a]]
        for b in range(a + 1):
            s = joints + part[spring[b]]
            total = 0.0
            for i in range(2):
                for j in range(2):
                    on = rows.body[r, i]
                    if on >= 0 and on == rows.body[s, j]:
                        total += dot(rows.J[r, i], rows.solved[s, j], 0, width[on])
            G[a, b] = F[spring[a], spring[b]] - scale * total


@kernel
def measure_widths(model: Model, flexibility: FloatArray, held: HeldRows) -> None:
    """held.width: static coordinates behind the last one with a mass have no part in the answer of a body."""
    dof = model.bodies.dof
    for b in range(len(held.width)):
        width = dof[b + 1] - dof[b]
        while width > 0 and flexibility[dof[b] + width - 1] > 0.0:
            width -= 1
        held.width[b] = width


@kernel
def clear_static(model: Model, work: Workspace, flexibility: FloatArray, r: int) -> None:
    """solved[r] without its static coordinates."""
    for i in range(2):
        b = work.rows.body[r, i]
        if b >= 0:
            d = work.rows.dof[b]
            for k in range(first_rate(model, b) - d, work.rows.dof[b + 1] - d):
                if flexibility[d + k] > 0.0:
                    work.rows.solved[r, i, k] = 0.0


@late_kernel
def factorise_held(
    model: Model,
    q: FloatArray,
    square: float,
    flexibility: FloatArray,
    held: HeldRows,
    work: Workspace,
    fast: int,
) -> int:
    """Eliminate the joints on bodies with modes that are ``fast`` or contacts that are closed; how many rows they have.

    -1: they do not stop so many modes. ``work.rows.arrow`` holds the factors of A.
    """
    joint_rows(
        model, 0.0, q, work.free.u, work.free.external, held.rows, held.row_body, held.wrench, held.rate, held.bias
    )
    mark_bodies(model, square, flexibility, held, work)
    n = 0
    for r in range(len(held.rate)):
        matters = False
        for i in range(2):
            b = held.row_body[r, i]
            if b >= 0:
                matters = matters or held.bodies[b] == 1
                solve_block(model.bodies, work.rows.arrow, b, held.rows[r, i], held.solved[r, i])
        if matters:
            held.part[n] = r
            n += 1
    delassus(held.rows, held.solved, held.row_body, held.part, n, held.S)
    negative = eliminate(held, n)
    return n if negative == fast else -1


@kernel
def mark_bodies(model: Model, square: float, flexibility: FloatArray, held: HeldRows, work: Workspace) -> None:
    """held.bodies: 1 of each body with a fast mode or a closed contact."""
    bodies = model.bodies
    joints = len(work.scratch.residual)
    for b in range(len(bodies.mass)):
        held.bodies[b] = 0
        first = first_rate(model, b)
        own = first_mode(model, b)
        for i in range(bodies.dof[b + 1] - first):
            if flexibility[first + i] == 0.0 and not bodies.stiffness[own + i] < square:
                held.bodies[b] = 1
    for r in range(work.rows.n_contacts):
        if stiffens(work, r):
            for i in range(2):
                if work.rows.body[joints + r, i] >= 0:
                    held.bodies[work.rows.body[joints + r, i]] = 1


@kernel
def eliminate(held: HeldRows, n: int) -> int:
    """Factors of the symmetric S[:n, :n], its largest pivot first; how many of them are negative.

    Column k of what is left of S stays for pivot k. A pivot that is rounding of its terms is a dependent row.
    """
    S = held.S
    for a in range(n):
        r = held.part[a]
        held.size[a] = 0.0
        held.order[a] = a
        for i in range(2):
            if held.row_body[r, i] >= 0:
                for k in range(held.rows.shape[2]):
                    held.size[a] += abs(held.rows[r, i, k] * held.solved[r, i, k])
    negative = 0
    for step in range(n):
        best = step
        for at in range(step, n):
            a, b = held.order[at], held.order[best]
            if abs(S[a, a]) * held.size[b] > abs(S[b, b]) * held.size[a]:
                best = at
        a = held.order[best]
        held.order[best] = held.order[step]
        held.order[step] = a
        if not abs(S[a, a]) > REDUNDANT * held.size[a]:
            held.pivot[a] = 0.0
            continue
        held.pivot[a] = S[a, a]
        if S[a, a] < 0.0:
            negative += 1
        for i in range(step + 1, n):
            for j in range(step + 1, n):
                b, c = held.order[i], held.order[j]
                S[b, c] -= S[b, a] * S[c, a] / held.pivot[a]
    return negative


@late_kernel
def add_held(work: Workspace, held: HeldRows, n: int, springs: int, scale: float) -> None:
    """Add to work.scratch.G what the n joint rows take from the answer of contact rows that are springs."""
    joints = len(work.scratch.residual)
    for r in range(springs):
        own = held.coupling[r]
        for a in range(n):
            own[a] = coupled(work, held, held.part[a], joints + work.posed.part[held.spring[r]])
        for step in range(n):
            a = held.order[step]
            if held.pivot[a] != 0.0:
                for i in range(step + 1, n):
                    b = held.order[i]
                    own[b] -= held.S[b, a] / held.pivot[a] * own[a]
        for s in range(r + 1):
            other = held.coupling[s]
            for a in range(n):
                if held.pivot[a] != 0.0:
                    work.scratch.G[r, s] += scale * own[a] * other[a] / held.pivot[a]


@kernel
def coupled(work: Workspace, held: HeldRows, j: int, r: int) -> float:
    """Joint row j with A^-1 times contact row r."""
    total = 0.0
    for i in range(2):
        b = held.row_body[j, i]
        for k in range(2):
            if b >= 0 and work.rows.body[r, k] == b:
                for d in range(work.rows.dof[b + 1] - work.rows.dof[b]):
                    total += held.rows[j, i, d] * work.rows.solved[r, k, d]
    return total
