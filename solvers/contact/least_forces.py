"""Forces of contacts that share a load in more than one way: of all that give the same motion, the least.

A box on its two lower corners may stand without friction, or with friction of both corners against each other: the
motion does not tell, and a solver returns an extreme case. The one of least norm is

    min |p|   with   G p = G p_0,   p_N >= 0,   |p_T| <= mu p_N,   p_T = -mu p_N sign(gdot_T) in slip,

with the Delassus operator G of a contact problem and a solution p_0 of it. Where G determines p, nothing is changed,
and the motion is not touched at all.
"""

from __future__ import annotations

import math

from lcpflex.jit.kernel import FloatArray, IntArray, kernel, late_kernel
from lcpflex.solvers.contact.memory import ContactData, SolverMemory
from lcpflex.solvers.semidefinite import cholesky, cholesky_solve

__all__ = ["least_forces"]

ZERO = 1e-9  # of its terms: a smaller velocity of a contact is none
NULL = 1e-8  # of its row of the operator: what a null vector may leave
SWEEPS = 300  # of Dykstra's algorithm
CLOSE = 1e-12  # change relative to the largest impulse that ends it
OUTSIDE = 1e-9  # of the largest impulse: by so much an impulse may be outside of its cone


@kernel
def contact_velocity(data: ContactData, p: FloatArray, r: int) -> float:
    """Velocity of contact row r under the forces; 0 where it is rounding."""
    total = data.free[r]
    size = abs(total)
    for s in range(data.n_contacts + data.n_tangents):
        part = data.delassus[r, s] * p[s]
        total += part
        size += abs(part)
    return 0.0 if abs(total) <= ZERO * size else total


@kernel
def list_unknowns(data: ContactData, memory: SolverMemory, p: FloatArray) -> int:
    """Forces that may differ from zero; returns their number.

    Unknown i is that of contact row first[i] and, times ratio[i] (sliding friction), of row second[i]. A contact that
    sticks has two in a row, normal and tangential.
    """
    n = data.n_contacts
    first, second, ratio = memory.first, memory.second, memory.ratio
    count = 0
    j = 0
    for k in range(n):
        tangent = -1
        if j < data.n_tangents and data.tangent[j] == k:
            tangent = n + j
            j += 1
        normal = p[k]
        if normal <= 0.0 and contact_velocity(data, p, k) != 0.0:
            continue
        first[count], second[count], ratio[count] = k, k, 0.0
        count += 1
        if tangent >= 0:
            slip = contact_velocity(data, p, tangent)
            if slip == 0.0:
                first[count], second[count], ratio[count] = tangent, tangent, 0.0
                count += 1
            else:
                second[count - 1] = tangent
                ratio[count - 1] = p[tangent] / normal if normal > 0.0 else math.copysign(data.friction[k], -slip)
    return count


@kernel
def reduced_entry(data: ContactData, memory: SolverMemory, i: int, k: int) -> float:
    """Entry of the Delassus operator of the unknowns."""
    a, b = memory.first[i], memory.second[i]
    c, d = memory.first[k], memory.second[k]
    f, g = memory.ratio[i], memory.ratio[k]
    G = data.delassus
    entry: float = G[a, c] + g * G[a, d] + f * (G[b, c] + g * G[b, d])
    return entry


@kernel
def null_vectors(data: ContactData, memory: SolverMemory, count: int) -> int:
    """Orthonormal forces without effect, to the first rows of the tableau; returns their number."""
    G, lower, rows = memory.alike, memory.M, memory.tableau
    for i in range(count):
        for k in range(i + 1):
            G[i, k] = reduced_entry(data, memory, i, k)
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
def to_cones(data: ContactData, first: IntArray, count: int, x: FloatArray) -> float:
    """Nearest forces that contacts may have; returns by how much the farthest was moved."""
    n = data.n_contacts
    moved = 0.0
    for i in range(count):
        if first[i] >= n:
            continue
        normal, tangential = x[i], 0.0
        sticks = i + 1 < count and first[i + 1] >= n
        if sticks:
            mu = data.friction[first[i]]
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
def least_forces(data: ContactData, memory: SolverMemory, p: FloatArray) -> None:
    """Replace the forces p (rows,) that solve a contact problem by the least ones of the same effect.

    p: normals, then tangents. The memory serves as room to work in; what it knows of the next problem stays.
    """
    if data.n_contacts > 1:
        take_least(data, memory, p)


@late_kernel
def take_least(data: ContactData, memory: SolverMemory, p: FloatArray) -> None:
    """``least_forces`` where a force may have another in its place."""
    count = list_unknowns(data, memory, p)
    free = null_vectors(data, memory, count)
    if free == 0:
        return
    rows, first = memory.tableau, memory.first
    start, x, y, rest = rows[free], rows[free + 1], rows[free + 2], rows[free + 3]
    largest = 0.0
    for i in range(count):
        start[i] = p[first[i]]
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
        to_cones(data, first, count, y)
        for i in range(count):
            rest[i] -= y[i]
    for i in range(count):
        y[i] = x[i]
    if to_cones(data, first, count, y) > OUTSIDE * largest:
        return
    for i in range(count):
        p[first[i]] = x[i]
        if memory.ratio[i] != 0.0:
            p[memory.second[i]] = memory.ratio[i] * x[i]
