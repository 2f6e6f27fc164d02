"""Forces of contacts that share a load in more than one way: of all that give the same motion, the least.

A box on its two lower corners may stand without friction, or with friction of both corners against each other: the
motion does not tell, and a solver returns an extreme case. What is stored is the one of least norm,

    min |p|   with   G p = G p_0,   p_N >= 0,   |p_T| <= mu p_N,   p_T = -mu p_N sign(gdot_T) in slip,

with the Delassus operator G of the last contact problem and its solution p_0. Where G determines p, nothing is changed,
and the motion is not touched at all.
"""

from __future__ import annotations

import math

from lcpflex.dynamics.delassus import cholesky, cholesky_solve
from lcpflex.dynamics.workspace import Workspace
from lcpflex.jit.kernel import FloatArray, kernel

__all__ = ["least_impulses"]

ZERO = 1e-9  # of its terms: a smaller velocity of a contact is none
NULL = 1e-8  # of its row of the operator: what a null vector may leave
SWEEPS = 300  # of Dykstra's algorithm
CLOSE = 1e-12  # change relative to the largest impulse that ends it
OUTSIDE = 1e-9  # of the largest impulse: by so much an impulse may be outside of its cone


@kernel
def contact_velocity(work: Workspace, r: int) -> float:
    """Velocity of contact row r after the step; 0 where it is rounding."""
    n_joint = work.n_joint
    total = work.problem.free[r]
    size = abs(total)
    for s in range(work.n_contacts + work.n_tangents):
        part = work.problem.delassus[r, s] * work.p[n_joint + s]
        total += part
        size += abs(part)
    return 0.0 if abs(total) <= ZERO * size else total


@kernel
def list_unknowns(work: Workspace) -> int:
    """Impulses that may differ from zero; returns their number.

    Unknown i is that of contact row basis[i] and, times bias[i] (sliding friction), of row basis[half + i]. A contact
    that sticks has two in a row, normal and tangential.
    """
    n_joint = work.n_joint
    n = work.n_contacts
    half = 2 * len(work.mu)
    count = 0
    j = 0
    for k in range(n):
        tangent = -1
        if j < work.n_tangents and work.tangent[j] == k:
            tangent = n + j
            j += 1
        normal = work.p[n_joint + k]
        if normal <= 0.0 and contact_velocity(work, k) != 0.0:
            continue
        work.solver.basis[count] = k
        work.solver.basis[half + count] = k
        work.bias[count] = 0.0
        count += 1
        if tangent >= 0:
            slip = contact_velocity(work, tangent)
            if slip == 0.0:
                work.solver.basis[count] = tangent
                work.solver.basis[half + count] = tangent
                work.bias[count] = 0.0
                count += 1
            else:
                work.solver.basis[half + count - 1] = tangent
                ratio = work.p[n_joint + tangent] / normal if normal > 0.0 else math.copysign(work.mu[k], -slip)
                work.bias[count - 1] = ratio
    return count


@kernel
def reduced_entry(work: Workspace, i: int, k: int) -> float:
    """Entry of the Delassus operator of the unknowns."""
    half = 2 * len(work.mu)
    a, b = work.solver.basis[i], work.solver.basis[half + i]
    c, d = work.solver.basis[k], work.solver.basis[half + k]
    f, g = work.bias[i], work.bias[k]
    G = work.problem.delassus
    return G[a, c] + g * G[a, d] + f * (G[b, c] + g * G[b, d])


@kernel
def null_vectors(work: Workspace, count: int) -> int:
    """Orthonormal impulses without effect, to the first rows of the tableau; returns their number."""
    G, lower, rows = work.G, work.solver.M, work.solver.tableau
    for i in range(count):
        for k in range(i + 1):
            G[i, k] = reduced_entry(work, i, k)
            G[k, i] = G[i, k]
    cholesky(G, count, lower)
    found = 0
    for i in range(count):
        if lower[i, i] > 0.0:
            continue
        row = rows[found]
        for k in range(count):
            row[k] = G[k, i]
        cholesky_solve(lower, count, row)
        for k in range(count):
            row[k] = (1.0 if k == i else 0.0) - row[k]
        for k in range(count):
            left, size = 0.0, 0.0
            for c in range(count):
                left += G[k, c] * row[c]
                size += abs(G[k, c])
            if abs(left) > NULL * size:
                return 0
        for _ in range(2):  # twice is enough
            take_off(rows, found, row, count)
        norm = 0.0
        for k in range(count):
            norm += row[k] * row[k]
        for k in range(count):
            row[k] /= math.sqrt(norm)
        found += 1
    return found


@kernel
def take_off(rows: FloatArray, found: int, x: FloatArray, count: int) -> None:
    """x without its parts along the first ``found`` rows."""
    for i in range(found):
        part = 0.0
        for k in range(count):
            part += rows[i, k] * x[k]
        for k in range(count):
            x[k] -= part * rows[i, k]


@kernel
def to_cones(work: Workspace, count: int, x: FloatArray) -> float:
    """Nearest impulses that contacts may have; returns by how much the farthest was moved."""
    n = work.n_contacts
    moved = 0.0
    for i in range(count):
        if work.solver.basis[i] >= n:
            continue
        normal, tangential = x[i], 0.0
        sticks = i + 1 < count and work.solver.basis[i + 1] >= n
        if sticks:
            mu = work.mu[work.solver.basis[i]]
            tangential = x[i + 1]
            if mu * abs(tangential) <= -normal:
                x[i], x[i + 1] = 0.0, 0.0
            elif abs(tangential) > mu * normal:
                x[i] = (normal + mu * abs(tangential)) / (1.0 + mu * mu)
                x[i + 1] = math.copysign(mu * x[i], tangential)
            moved = max(moved, abs(x[i + 1] - tangential))
        else:
            x[i] = max(normal, 0.0)
        moved = max(moved, abs(x[i] - normal))
    return moved


@kernel
def least_impulses(work: Workspace) -> None:
    """Replace the contact impulses in ``work.p`` by the least ones of the same effect.

    Uses the memory of the solver, which begins each step anew, and the Delassus operator of all rows.
    """
    n_joint = work.n_joint
    if work.n_contacts < 2:
        return
    count = list_unknowns(work)
    free = null_vectors(work, count)
    if free == 0:
        return
    rows = work.solver.tableau
    start, x, y, rest = rows[free], rows[free + 1], rows[free + 2], rows[free + 3]
    largest = 0.0
    for i in range(count):
        start[i] = work.p[n_joint + work.solver.basis[i]]
        largest = max(largest, abs(start[i]))
        rest[i] = 0.0
        y[i] = 0.0
    for _ in range(SWEEPS):
        # nearest to y of the same effect: start plus the part of y - start along null vectors
        for i in range(count):
            x[i] = start[i] - y[i]
        take_off(rows, free, x, count)
        change = 0.0
        for i in range(count):
            x[i] += y[i]
            change = max(change, abs(x[i] - y[i]))
        if change <= CLOSE * largest:
            break
        for i in range(count):
            y[i] = x[i] + rest[i]
            rest[i] = y[i]
        to_cones(work, count, y)
        for i in range(count):
            rest[i] -= y[i]
    for i in range(count):
        y[i] = x[i]
    if to_cones(work, count, y) > OUTSIDE * largest:
        return
    half = 2 * len(work.mu)
    for i in range(count):
        work.p[n_joint + work.solver.basis[i]] = x[i]
        if work.bias[i] != 0.0:
            work.p[n_joint + work.solver.basis[half + i]] = work.bias[i] * x[i]
