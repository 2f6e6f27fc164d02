"""Friction that turns with its slip, in the problems of a pass of Newton's method.

Friction of a contact that slides is -mu lambda_N gamma / |gamma|, with the slip gamma at the end of the step.
Linearised at the direction d of a pass, with e across it, it has a part s e across the slip, for which

    e . gamma + |gamma| s / (mu lambda_N) = 0,

with lambda_N and |gamma| of the pass before: slip across d is resisted as by a viscous damper. gamma depends on the
forces of all contacts, and so do the s: they are eliminated from the operator of the island before its problem is
solved, and come to the forces after. Without them directions are found contact by contact, which where contacts push
each other aside converges by a factor of .5 to .9 a pass, or not at all.
Source: Alart & Curnier 1991, the generalised derivative of a sliding contact.
"""

from __future__ import annotations

from typing import Any

from lcpflex.dynamics.spatial.inertia import SpatialWork
from lcpflex.jit.kernel import FloatArray, IntArray, kernel
from lcpflex.jit.struct import array, struct
from lcpflex.solvers.semidefinite import backward, cholesky, dot, forward

__all__ = ["TurningSlip", "add_across", "eliminate_across"]


@struct
class TurningSlip:
    """Contacts whose friction turns with their slip, and its part across the direction ``along`` of the sets."""

    counts: int  # 1: in the problem that is posed
    count: int  # of them in the island posed last
    yields: FloatArray = array("contacts")  # d(e . acceleration)/ds that the damper leaves [1/kg]; < 0: does not turn
    missing: FloatArray = array("contacts")  # acceleration by which e . gamma is reached over the step [m/s^2]
    member: IntArray = array("dense")  # contacts of the island
    rows: FloatArray = array("dense", "rows")  # L^-1 times their rows of the operator
    own: FloatArray = array("dense", "dense")
    lower: FloatArray = array("dense", "dense")
    right: FloatArray = array("dense")
    force: FloatArray = array("rows")  # of all rows of the operator


@kernel
def lay_across(work: SpatialWork, sets: Any) -> None:
    """Rows across the slip of the contacts of the island posed last that turn, factorised."""
    turning, G = sets.turning, work.scratch.G
    problem, part = work.posed.problem, work.posed.part
    m = problem.n_contacts + problem.n_tangents
    count = 0
    for c in range(problem.n_contacts):
        k, j = part[c], sets.row_here[c]
        if j < 0 or not turning.yields[k] >= 0.0:
            continue
        x, y = -sets.along[k, 1], sets.along[k, 0]
        turning.member[count] = c
        for r in range(m):
            turning.rows[count, r] = x * G[j, r] + y * G[j + 1, r]
        turning.right[count] = x * sets.free[j] + y * sets.free[j + 1] + turning.missing[k]
        count += 1
    turning.count = count
    for a in range(count):
        for b in range(a + 1):
            k, j = part[turning.member[b]], sets.row_here[turning.member[b]]
            turning.own[a, b] = sets.along[k, 0] * turning.rows[a, j + 1] - sets.along[k, 1] * turning.rows[a, j]
        turning.own[a, a] += turning.yields[part[turning.member[a]]]
    cholesky(turning.own, count, turning.lower)


@kernel
def eliminate_across(work: SpatialWork, sets: Any) -> None:
    """Let the parts across the slip answer all others, in the operator of the island posed last and its free motion."""
    turning, G, problem = sets.turning, work.scratch.G, work.posed.problem
    if turning.counts == 0:
        return
    lay_across(work, sets)
    m, count, rows = problem.n_contacts + problem.n_tangents, turning.count, turning.rows
    for i in range(count):
        for j in range(i):
            share = turning.lower[i, j]
            for r in range(m):
                rows[i, r] -= share * rows[j, r]
        pivot = turning.lower[i, i]
        for r in range(m):
            rows[i, r] = rows[i, r] / pivot if pivot > 0.0 else 0.0
    forward(turning.lower, count, turning.right)
    for i in range(count):
        for r in range(m):
            answer = rows[i, r]
            sets.free[r] -= answer * turning.right[i]
            for s in range(m):
                G[r, s] -= answer * rows[i, s]


@kernel
def add_across(work: SpatialWork, sets: Any) -> None:
    """The parts across the slip to the forces ``work.impulses.p`` of the island posed last."""
    turning, problem, part = sets.turning, work.posed.problem, work.posed.part
    if turning.counts == 0:
        return
    p, n_joint = work.impulses.p, work.rows.n_joint
    m, count, s = problem.n_contacts + problem.n_tangents, turning.count, turning.right
    for r in range(m):
        turning.force[r] = p[n_joint + part[r]]
    for i in range(count):
        s[i] = -(s[i] + dot(turning.rows[i], turning.force, 0, m))
    backward(turning.lower, count, s)
    for i in range(count):
        k, r = part[turning.member[i]], n_joint + part[sets.row_here[turning.member[i]]]
        if not p[n_joint + k] > 0.0:
            continue  # it opens: no friction without a normal force
        p[r] -= s[i] * sets.along[k, 1]
        p[r + 1] += s[i] * sets.along[k, 0]
