"""Contact problems in space in which some contacts are known to slide: cones and half-lines side by side.

Velocities (or accelerations) are u = W r + q, W square and in general unsymmetric: contact c has the unknown r_c along
its normal and, where it may stick, two more at ``at[c]`` in its tangent plane (at[c] = -1: none). It holds

    r_N >= f  _|_  u_N >= 0,   f = 0, or what it carries at least,
    r_T = proj(r_T - u_T) on the disc |r_T| <= mu r_N,

so a contact that slides along d is one without tangents, its friction -mu r_N d being a part of its column.
The unit of each contact is d = 1 / sqrt(largest of its diagonal): r' = r / d and u' = d u of all are alike.
They are solved by :mod:`lcpflex.solvers.contact.cones.mixed`.
"""

from __future__ import annotations

import math

import numpy as np

from lcpflex.jit.kernel import FloatArray, IntArray, kernel
from lcpflex.jit.struct import allocate, array, struct

__all__ = ["MixedProblem", "fill_units", "mixed_problem", "own_pulls"]


@struct
class MixedProblem:
    """A problem, its solution and room for :mod:`.reserve`; rows: three times as many as contacts, and one."""

    n: int  # contacts
    m: int  # unknowns
    W: FloatArray = array("rows", "rows")
    q: FloatArray = array("rows")
    terms: FloatArray = array("rows")  # of which q is the sum: where they cancel, rounding is left
    at: IntArray = array("contacts")
    friction: FloatArray = array("contacts")
    floor: FloatArray = array("contacts")
    r: FloatArray = array("rows")
    unit: FloatArray = array("rows")
    u: FloatArray = array("rows")  # under the forces judged last
    x: FloatArray = array("rows")
    trial: FloatArray = array("rows")
    best: FloatArray = array("rows")
    centre: FloatArray = array("rows")
    step: FloatArray = array("rows")
    jacobian: FloatArray = array("rows", "rows")
    pivots: IntArray = array("rows")
    rests: IntArray = array("contacts")  # 1: its forces may be changed, see :mod:`.reserve`
    member: IntArray = array("rows")
    basis: FloatArray = array("rows", "rows")
    most: float  # of all normal forces that may be changed together, over L
    strict: float  # residual of the forces judged last, relative to the load
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


def own_pulls(p: MixedProblem) -> FloatArray:
    """(n,) how the force of each contact opens it, with friction; of one that may stick at least. < 0: pulled in."""
    pull = np.diag(p.W)[: p.n].copy()
    for c in range(p.n):
        if p.at[c] >= 0:
            pull[c] -= p.friction[c] * math.hypot(p.W[c, p.at[c]], p.W[c, p.at[c] + 1])
    return pull
