"""Contact problems in space in which some contacts are known to slide: cones and half-lines side by side.

Velocities (or accelerations) are u = W r + q, W square and in general unsymmetric: contact c has the unknown r_c along
its normal and, where it may stick, two more at ``at[c]`` in its tangent plane (at[c] = -1: none). It holds

    r_N >= f  _|_  u_N >= 0,   f = 0, or what it carries at least,
    r_T = proj(r_T - u_T) on the disc |r_T| <= mu r_N,

so a contact that slides along d is one without tangents, its friction -mu r_N d being a part of its column.
In units of each contact, d = 1 / sqrt(largest of its diagonal), r' = r / d and u' = d u, the residual is

    F_N = r'_N - max(f', r'_N - u'_N),   F_T = r'_T - proj(r'_T - u'_T) on the disc of radius mu max(f', r'_N - u'_N)

They are solved by :mod:`lcpflex.solvers.contact.cones.mixed`.
"""

from __future__ import annotations

import math

import numpy as np

from lcpflex.jit.kernel import FloatArray, IntArray, kernel
from lcpflex.jit.struct import allocate, array, struct
from lcpflex.solvers.certificate import guarded_residual, strict_residual

__all__ = ["MixedProblem", "fill_units", "judge_mixed", "mixed_problem", "own_pulls"]

FLOOR = 1e-3  # of the terms of which q is made: less of them is no measure of a residual
LOOK_BACK = 4  # residuals that a step may come up to again


@struct
class MixedProblem:
    """A problem, its solution and what is needed on the way; rows: three times as many as contacts, and one."""

    n: int  # contacts
    m: int  # unknowns
    W: FloatArray = array("rows", "rows")
    q: FloatArray = array("rows")
    terms: FloatArray = array("rows")  # of which q is the sum: where they cancel, rounding is left
    at: IntArray = array("contacts")
    friction: FloatArray = array("contacts")
    floor: FloatArray = array("contacts")
    r: FloatArray = array("rows")
    slip: FloatArray = array("contacts")
    unit: FloatArray = array("rows")
    u: FloatArray = array("rows")  # in units of the contacts, as what follows
    miss: FloatArray = array("rows")
    x: FloatArray = array("rows")
    trial: FloatArray = array("rows")
    best: FloatArray = array("rows")
    centre: FloatArray = array("rows")
    step: FloatArray = array("rows")
    jacobian: FloatArray = array("rows", "rows")
    back: FloatArray = array(LOOK_BACK)
    rests: IntArray = array("contacts")  # 1: its forces may be changed, see :mod:`.reserve`
    member: IntArray = array("rows")
    basis: FloatArray = array("rows", "rows")
    most: float  # of all normal forces that may be changed together, over L
    weight: float  # of the proximal term
    strict: float
    iterations: int


def mixed_problem(contacts: int) -> MixedProblem:
    """Room for so many contacts, and for the reserve of all their forces, where nothing determines any of them."""
    return allocate(MixedProblem, {"contacts": contacts, "rows": 3 * contacts + 1})


@kernel
def fill_units(p: MixedProblem) -> None:
    """1 / sqrt of the largest diagonal entry of each contact, at all its rows."""
    for c in range(p.n):
        t = p.at[c]
        size = abs(p.W[c, c])
        if t >= 0:
            size = max(size, max(p.W[t, t], p.W[t + 1, t + 1]))
        unit = 1.0 / math.sqrt(size) if size > 0.0 else 1.0
        p.unit[c] = unit
        if t >= 0:
            p.unit[t] = unit
            p.unit[t + 1] = unit


@kernel
def judge_mixed(p: MixedProblem, r: FloatArray) -> float:
    """Residual of r relative to the terms of u, guarded; relative to what is given alone it goes to ``p.strict``."""
    size, load = 0.0, 0.0
    for i in range(p.m):
        total, terms = p.q[i], abs(p.q[i])
        posed = max(abs(p.q[i]), FLOOR * p.terms[i])
        for j in range(p.m):
            if j < p.n:
                posed += abs(p.W[i, j]) * p.floor[j]
            total += p.W[i, j] * r[j]
            terms += abs(p.W[i, j] * r[j])
        p.u[i] = total
        size = max(size, p.unit[i] * terms)
        load = max(load, p.unit[i] * posed)
        if not (terms < np.inf):
            size = np.inf
    worst = 0.0
    for c in range(p.n):
        t, d = p.at[c], p.unit[c]
        a = r[c] / d
        press = max(p.floor[c] / d, a - d * p.u[c])
        worst = max(worst, abs(a - press))
        if t >= 0:
            a_1, a_2 = r[t] / d, r[t + 1] / d
            y_1, y_2 = a_1 - d * p.u[t], a_2 - d * p.u[t + 1]
            length, radius = math.hypot(y_1, y_2), p.friction[c] * press
            if length <= radius:
                worst = max(worst, d * max(abs(p.u[t]), abs(p.u[t + 1])))
            else:
                worst = max(worst, abs(a_1 - y_1 * (radius / length)))
                worst = max(worst, abs(a_2 - y_2 * (radius / length)))
    if not (worst < np.inf and size < np.inf):
        p.strict = np.inf
        return np.inf
    p.strict = strict_residual(worst, load)
    return guarded_residual(worst, size, load)


def own_pulls(p: MixedProblem) -> FloatArray:
    """(n,) how the force of each contact opens it, with friction; of one that may stick at least. < 0: pulled in."""
    pull = np.diag(p.W)[: p.n].copy()
    for c in range(p.n):
        if p.at[c] >= 0:
            pull[c] -= p.friction[c] * math.hypot(p.W[c, p.at[c]], p.W[c, p.at[c] + 1])
    return pull
