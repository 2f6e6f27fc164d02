"""Shares of contacts that carry a load together, where nothing determines them and friction depends on them.

Four corners of a box carry its weight in many ways. Where they slide, each way has another friction torque, so that the
motion depends on it. Taken is the one that contacts of equal compliance come to as that vanishes, or of compliances
1 / w_k: of all normal forces with the same effect

    min sum f_k^2 / w_k,   f_k >= 0,      so that f = D B z,   D = diag(w),   B: rows of the normals, z: any motion

With the friction of contacts that slide in the columns of their normals, velocities are u = W r + q, W = B A^-1 C^T.
Forces without effect, W n = 0, are not orthogonal to the forces D B z: those are to z with z^T W = 0, since B^T z = 0.
So r + N c with Z^T D^-1 (r + N c) = 0 is taken, N and Z the null vectors of W from the right and from the left. Those
that would pull are left out, and the others begin anew. Contacts that stick have three rows of B, and no friction in
the column of their normal.
"""

from __future__ import annotations

import math

import numpy as np

from lcpflex.jit.kernel import FloatArray, IntArray, kernel
from lcpflex.jit.struct import allocate, array, struct

__all__ = ["MATTERS", "NEEDED", "SLIPS", "TOUCHING", "Shares", "at_edge", "share_out", "shares"]

NEEDED = 3  # contacts of one pair of bodies: two at different places are never dependent
TOUCHING = 1e-8  # of the load: contacts that open faster carry nothing
SLIPS = 1e-9  # of the load: slower slip is none
EDGE = 1e-9  # of Coulomb's limit: friction that is less by more holds
MATTERS = 1e-6  # of the load: so much slip by other shares is another motion

DEPENDENT = 1e-11  # a pivot below this part of the largest, of a matrix with unit diagonal, is a dependent row
LIGHTEST = 1e-8  # of the largest weight: less gets no less, being nothing
PULLS = 1e-12  # of the largest force: a pull of less is rounding
MISSED = 1e-9  # of the forces that are to be met, what a choice of contacts may leave


@struct
class Shares:
    """A problem of m unknowns, the first n of them normal forces, and room to work in; a solution goes to ``x``."""

    n: int
    m: int
    left: int  # unknowns that are not left out in the end
    told: int  # 1 + declared contact with friction that has depended on shares
    W: FloatArray = array("rows", "rows")
    x: FloatArray = array("rows")  # forces that solve the problem, and out
    idle: IntArray = array("contacts")  # 1: a contact of an island on its sets has no share, though it touches
    own: FloatArray = array("rows")  # what each row does to itself without friction: its unit is 1 / sqrt of that
    weight: FloatArray = array("rows")
    contact: IntArray = array("rows")  # that each unknown belongs to
    a: FloatArray = array("rows", "rows")
    b: FloatArray = array("rows")
    y: FloatArray = array("rows")
    z: FloatArray = array("rows")
    scale: FloatArray = array("rows")
    cost: FloatArray = array("rows")
    kept: IntArray = array("rows")
    row: IntArray = array("rows")
    column: IntArray = array("rows")
    # of an island: its contacts of one pair of bodies
    member: IntArray = array("rows")  # contacts, by their places in the island
    rough: IntArray = array("rows")  # first unknown in the tangents of each; -1: none
    along: FloatArray = array("rows", 2)  # friction of each that slides, over its normal force
    part: IntArray = array("rows")  # rows of the scene
    G: FloatArray = array("rows", "rows")  # three rows each
    before: FloatArray = array("triples")  # forces to go back to
    leader: IntArray = array("contacts")  # first contact of the same pair of bodies, by their places
    count: IntArray = array("contacts")  # of a leader
    further: IntArray = array("contacts")  # another leader of the same body
    head: IntArray = array("ndof")  # the last leader of each body


def shares(contacts: int, rows: int, ndof: int) -> Shares:
    """Room for so many contacts, ``rows`` unknowns of one problem, bodies with so many velocities."""
    return allocate(Shares, {"contacts": contacts, "triples": 3 * contacts, "rows": rows, "ndof": ndof})


@kernel
def at_edge(f: float, f1: float, f2: float, mu: float) -> bool:
    """Whether friction is as much as Coulomb's law allows; where there is no normal force it is."""
    return bool(math.hypot(f1, f2) >= mu * f * (1.0 - EDGE))


@kernel
def eliminate(s: Shares, m: int) -> int:
    """Factors of ``a`` by complete pivoting, ``b`` with it; returns the rank."""
    a, b, row, column = s.a, s.b, s.row, s.column
    for k in range(m):
        i0, j0, most = k, k, 0.0
        for i in range(k, m):
            for j in range(k, m):
                if abs(a[i, j]) > most:
                    i0, j0, most = i, j, abs(a[i, j])
        if not most > DEPENDENT:
            return k
        if i0 != k:
            b[k], b[i0] = b[i0], b[k]
            row[k], row[i0] = row[i0], row[k]
            for j in range(m):
                a[k, j], a[i0, j] = a[i0, j], a[k, j]
        if j0 != k:
            column[k], column[j0] = column[j0], column[k]
            for i in range(m):
                a[i, k], a[i, j0] = a[i, j0], a[i, k]
        for i in range(k + 1, m):
            factor = a[i, k] / a[k, k]
            a[i, k] = factor
            if factor != 0.0:
                b[i] -= factor * b[k]
                for j in range(k + 1, m):
                    a[i, j] -= factor * a[k, j]
    return m


@kernel
def null_vectors(s: Shares, rank: int, m: int) -> None:
    """Of the factors: y = the solution of ``b`` with ``rank`` unknowns; -N in the last columns, -Z in the last rows."""
    a, b = s.a, s.b
    for k in range(rank - 1, -1, -1):
        for j in range(k + 1, rank):
            b[k] -= a[k, j] * b[j]
        b[k] /= a[k, k]
    for j in range(rank, m):
        for k in range(rank - 1, -1, -1):
            for i in range(k + 1, rank):
                a[k, j] -= a[k, i] * a[i, j]
            a[k, j] /= a[k, k]
    for i in range(rank, m):
        for k in range(rank - 1, -1, -1):
            for j in range(k + 1, rank):
                a[i, k] -= a[i, j] * a[j, k]


@kernel
def solve_small(s: Shares, rank: int, m: int) -> bool:
    """b[rank:m] := a[rank:m, rank:m]^-1 b[rank:m]; False where that is singular."""
    a, b = s.a, s.b
    for k in range(rank, m):
        best = k
        for i in range(k + 1, m):
            if abs(a[i, k]) > abs(a[best, k]):
                best = i
        if not abs(a[best, k]) > 0.0:
            return False
        if best != k:
            b[k], b[best] = b[best], b[k]
            for j in range(k, m):
                a[k, j], a[best, j] = a[best, j], a[k, j]
        for i in range(k + 1, m):
            factor = a[i, k] / a[k, k]
            if factor != 0.0:
                b[i] -= factor * b[k]
                for j in range(k + 1, m):
                    a[i, j] -= factor * a[k, j]
    for k in range(m - 1, rank - 1, -1):
        for j in range(k + 1, m):
            b[k] -= a[k, j] * b[j]
        b[k] /= a[k, k]
        if not abs(b[k]) < np.inf:
            return False
    return True


@kernel
def pose_kept(s: Shares, m: int) -> float:
    """The system of the m unknowns kept, in units; right of it what forces left out did. Returns the largest of that.

    ``y``: the forces left out, 0 for those kept.
    """
    W, x, kept, scale = s.W, s.y, s.kept, s.scale
    largest = 0.0
    for i in range(m):
        r = kept[i]
        s.row[i], s.column[i] = i, i
        load = 0.0
        if m < s.m:
            for j in range(s.m):
                load += W[r, j] * x[j]
        s.b[i] = scale[r] * load
        largest = max(largest, abs(s.b[i]))
        for j in range(m):
            s.a[i, j] = scale[r] * scale[kept[j]] * W[r, kept[j]]
    return largest


@kernel
def pose_conditions(s: Shares, rank: int, m: int) -> None:
    """a[rank:, rank:] c = b[rank:], that is Z^T D^-1 N c = Z^T D^-1 z, behind ``null_vectors``."""
    a, b, z, left, row, column, kept, cost = s.a, s.b, s.z, s.y, s.row, s.column, s.kept, s.cost
    for i in range(rank, m):
        for k in range(m):
            left[k] = 0.0
        for k in range(rank):
            left[row[k]] = -a[i, k]
        left[row[i]] = 1.0
        total = 0.0
        for k in range(m):
            c = column[k]
            left[c] *= cost[kept[c]]
            total += left[c] * z[k]
        b[i] = total
        for j in range(rank, m):
            total = left[column[j]]
            for k in range(rank):
                total -= left[column[k]] * a[k, j]
            a[i, j] = total


@kernel
def choose(s: Shares, m: int) -> bool:
    """y: the forces that the m unknowns kept take, those left out having none; False where none do the same."""
    a, b, z, column, kept = s.a, s.b, s.z, s.column, s.kept
    for r in range(s.m):
        s.y[r] = s.x[r]
    for i in range(m):
        s.y[kept[i]] = 0.0
    load = pose_kept(s, m)
    rank = eliminate(s, m)
    if rank == s.m:
        return False  # all are determined
    for i in range(rank, m):
        if abs(b[i]) > MISSED * load:
            return False
    null_vectors(s, rank, m)
    for k in range(m):
        r = kept[column[k]]
        z[k] = s.x[r] / s.scale[r] + (b[k] if k < rank else 0.0)
    pose_conditions(s, rank, m)
    if not solve_small(s, rank, m):
        return False
    for j in range(rank, m):
        for k in range(rank):
            z[k] += a[k, j] * b[j]
        z[j] -= b[j]
    for r in range(s.m):
        s.y[r] = 0.0
    for k in range(m):
        r = kept[column[k]]
        s.y[r] = s.scale[r] * z[k]
    return True


@kernel
def leave_out(s: Shares, m: int) -> int:
    """Leave out the contact that pulls most at ``y``; how many unknowns are left, m where none pulls."""
    worst, largest, out = 0.0, 0.0, -1
    for i in range(m):
        r = s.kept[i]
        if r < s.n:
            largest = max(largest, s.y[r])
            if s.y[r] < worst:
                worst, out = s.y[r], s.contact[r]
    if not -worst > PULLS * largest:
        return m
    left = 0
    for i in range(m):
        if s.contact[s.kept[i]] != out:
            s.kept[left] = s.kept[i]
            left += 1
    return left


@kernel
def share_out(s: Shares) -> bool:
    """The forces ``x`` by their shares; False where all are determined.

    Also where no forces that push do the same: ``x`` are then some of which at least one pulls.
    """
    heaviest = 0.0
    for r in range(s.m):
        heaviest = max(heaviest, s.weight[r])
    for r in range(s.m):
        s.kept[r] = r
        s.scale[r] = 1.0 / math.sqrt(s.own[r]) if s.own[r] > 0.0 else 1.0
        s.cost[r] = s.scale[r] * s.scale[r] * heaviest / max(s.weight[r], LIGHTEST * heaviest)
    m, s.left = 0, s.m
    while s.left != m:
        m = s.left
        if m == 0 or not choose(s, m):
            return False
        for r in range(s.m):
            s.x[r] = s.y[r]
        s.left = leave_out(s, m)
    for r in range(s.n):
        s.x[r] = max(s.x[r], 0.0)
    return True
