"""How far forces are from solving a contact problem, judged with the velocities that they cause, made anew.

Each unit misses something of its law, in its own unit. The worst miss of all is told in two sizes: relative to the
terms that cancel in the velocities (guarded, :func:`lcpflex.solvers.certificate.guarded_residual`), and to the free
velocities alone. A light body beside heavy ones is nothing in these: each contact is measured by its own load, too.
"""

from __future__ import annotations

import numpy as np

from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.jit.struct import struct
from lcpflex.solvers.certificate import OWN, guarded_residual, own_share, strict_residual
from lcpflex.solvers.contact.algebra import Vector, put, slip_size, taken
from lcpflex.solvers.contact.best import Best
from lcpflex.solvers.contact.group import Group
from lcpflex.solvers.contact.laws import BILATERAL, miss
from lcpflex.solvers.contact.operators import Operator, begin, terms, velocity

__all__ = [
    "FLOOR", "SLIDING", "Judged", "is_enough", "is_exact", "is_good", "judge", "lags", "measure_loads", "term_size",
    "weigh",
]  # fmt: skip

FLOOR = 1e-3  # of the terms of which free velocities are made: less of them is no measure of a residual
SLIDING = 1e-6  # of the free velocities: a contact that slips by more is no resting one


@struct
class Judged:
    """What is known of the forces judged last."""

    tolerance: float  # of the residual
    load: float  # size of the free velocities, in units of the contacts
    worst: float  # largest miss
    terms: float  # largest size of what cancels in a velocity
    residual: float  # the miss relative to the terms, guarded
    strict: float  # and relative to the free velocities alone
    missed: float  # the largest part of its own load that is left of a contact
    behind: int  # that contact
    sliding: int  # 1: some contact that presses slips


@kernel
def measure_loads(group: Group, judged: Judged) -> None:
    """The largest load of all units."""
    load = 0.0
    for k in range(group.n):
        load = max(load, group.load[k])
    judged.load = load


@kernel
def judge(op: Operator, group: Group, judged: Judged, p: FloatArray, like: Vector) -> float:
    """Velocities ``group.y`` under the forces p (units, S), and the largest miss; inf for what is not finite."""
    begin(op, group, p, like)
    worst = 0.0
    for k in range(group.n):
        v = velocity(op, group, k, like)
        put(group.y, k, v)
        group.miss[k] = miss(group, k, taken(p, k, like), v)
        worst = max(worst, group.miss[k])
    judged.worst = worst
    return worst


@kernel
def weigh(op: Operator, group: Group, judged: Judged, p: FloatArray, like: Vector) -> None:
    """:func:`judge`, and the sizes of what is left of the whole and of each contact."""
    judge(op, group, judged, p, like)
    largest, missed, speed = 0.0, 0.0, 0.0
    for k in range(group.n):
        force, v = taken(p, k, like), taken(group.y, k, like)
        size, with_others = terms(op, group, k, p, v)
        if not size < np.inf:  # NaN, too, which max() may drop
            largest = np.inf
        largest = max(largest, size)
        if group.law[k] != BILATERAL:
            share = own_share(group.miss[k], with_others, group.load[k], judged.load)
            if share > missed:
                missed, judged.behind = share, k
            if force[0] > 0.0:
                speed = max(speed, group.unit[k] * slip_size(v))
    judged.missed = missed
    judged.terms = max(largest, judged.load)
    judged.sliding = 1 if speed > SLIDING * judged.load else 0
    if judged.worst < np.inf and judged.load < np.inf and largest < np.inf:
        judged.residual = guarded_residual(judged.worst, judged.terms, judged.load)
        judged.strict = strict_residual(judged.worst, judged.load)
    else:
        judged.residual, judged.strict, judged.missed = np.inf, np.inf, np.inf


@kernel
def term_size(op: Operator, group: Group, judged: Judged, p: FloatArray, like: Vector) -> float:
    """The largest size of what cancels in the velocities ``group.y`` under the forces p; inf where it is no number."""
    largest = judged.load
    for k in range(group.n):
        size, _ = terms(op, group, k, p, taken(group.y, k, like))
        if not size < np.inf:
            return np.inf
        largest = max(largest, size)
    return largest


@kernel
def is_enough(op: Operator, group: Group, judged: Judged, best: Best, like: Vector) -> bool:
    """Whether the best point is within the tolerance as a whole."""
    if is_exact(judged, best.worst):
        return True
    if not best.worst < judged.load < np.inf:
        return False
    size = term_size(op, group, judged, best.p, like)
    return bool(size < np.inf and guarded_residual(best.worst, size, judged.load) <= judged.tolerance)


@kernel
def is_exact(judged: Judged, worst: float) -> bool:
    """Whether so large a miss is within the tolerance even of the free velocities, which are finite."""
    return bool(worst <= judged.tolerance * judged.load < np.inf)


@kernel
def is_good(judged: Judged) -> bool:
    """Whether the forces weighed are within the tolerance as a whole, and near it by the own load of each contact.

    A light body beside heavy ones is nothing in the residual of the whole, and goes astray where that alone counts.
    """
    return bool(judged.residual <= judged.tolerance and judged.missed <= OWN * judged.tolerance)


@kernel
def lags(judged: Judged) -> bool:
    """Whether the forces weighed are within the tolerance as a whole, and some contact is not."""
    return bool(judged.residual <= judged.tolerance and not is_good(judged))
