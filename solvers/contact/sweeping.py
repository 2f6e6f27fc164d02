"""Block Gauss-Seidel with looks between sweeps: each unit solved by itself, exactly, the others as they are.

The one iteration of all contact problems: in the plane and in space, for any operator and any law. Sources: Jean 1999
(nonsmooth contact dynamics); Jourdan, Alart & Jean 1998; Bonnefon & Daviet 2011 (the exact law of one contact).

Sweeps go on until forces are good enough, or sweeps make them no better in good time. Where something slides good
enough is the tolerance; where all that press stick, forces are polished to rounding if that can be had: what rests does
not creep. What is to become less is what is left of the whole, or where contacts lag behind it, of their own loads.
"""

from __future__ import annotations

import numpy as np

from lcpflex.jit.kernel import kernel
from lcpflex.jit.struct import struct
from lcpflex.solvers.certificate import ROUNDED, ROUNDING
from lcpflex.solvers.contact.algebra import Vector, less, put, size_of, taken
from lcpflex.solvers.contact.best import Best, keep_best
from lcpflex.solvers.contact.group import Group
from lcpflex.solvers.contact.judging import Judged, is_exact, is_good, judge, lags, weigh
from lcpflex.solvers.contact.laws import solve
from lcpflex.solvers.contact.operators import Operator, push, velocity

__all__ = ["Sweeping", "is_settled", "left_over", "sweep", "sweep_on"]

SETTLED = 5e-14  # of the free velocities: what is left where nothing creeps, unless it is rounding of the terms
POLISHED = 3e-16  # sweeps that are made end there: those of the next step, which is like this one, are spared
WITHIN = 0.1  # of the tolerance: the change of a force below which a sweep is the last one before a look


@kernel
def sweep(op: Operator, group: Group, like: Vector, count: int, target: float) -> tuple[int, float]:
    """Up to ``count`` sweeps over all units; how many were made, and the largest change of a force in the last one.

    Forces and what the operator keeps of their effect (:func:`lcpflex.solvers.contact.operators.begin`) are advanced in
    place. Ends early once the change, in units of the contacts, is ``target`` or less. inf: a contact that no force of
    its own keeps apart, which the others may help.
    """
    p, unit, made, change = group.p, group.unit, 0, np.inf
    while made < count and change > target:
        change = 0.0
        for k in range(group.n):
            old = taken(p, k, like)
            new, found = solve(group, k, velocity(op, group, k, like), old)
            if not found:
                change = np.inf
                continue
            d = less(new, old)
            size = size_of(d)
            if size != 0.0:
                change = max(change, size / unit[k])
                put(p, k, new)
                push(op, group, k, d)
        made += 1
    return made, change


@struct
class Sweeping:
    """When is looked at forces, and when sweeps end; and what came of them."""

    look: int  # sweeps between two looks
    crawling: float  # of what was left: where a look finds more, it is too much to go on for, unless one is patient
    polish: int  # sweeps at most beyond the tolerance where all that press stick
    exact: int  # 1: ends within the tolerance of the free velocities; looks ask no more, and the best point is kept
    iterations: int  # sweeps so far, and the systems that other methods solved
    polished: int  # 1: forces were polished in the last step, and behind the solution: in this one


@kernel
def left_over(judged: Judged, lagging: bool) -> float:
    """What is to become less: what is left of the whole, or where contacts are ``lagging``, of their own loads."""
    return judged.missed if lagging else judged.worst


@kernel
def is_settled(judged: Judged, sweeping: Sweeping) -> bool:
    """Whether what is left is rounding.

    Forces that were polished have cancelled what was left of the velocities as well, and would bring it back with the
    other sign: in the step behind they are polished to the end, to those that keep still what is at rest.
    """
    share = POLISHED if sweeping.polished == 1 else SETTLED
    return bool(judged.worst <= max(share * judged.load, ROUNDED * ROUNDING * judged.terms))


@kernel
def sweep_on(
    op: Operator,
    group: Group,
    judged: Judged,
    sweeping: Sweeping,
    best: Best,
    like: Vector,
    count: int,
    patient: bool,
) -> bool:
    """Up to ``count`` sweeps from the forces judged last; whether they are good enough, or exact if that is asked for.

    Fewer where they crawl and one is not ``patient``. Forces are judged again behind the last sweep.
    """
    exact = sweeping.exact == 1
    rested = not exact and is_good(judged)
    polished, done, good = 0, 0, rested
    while done < count:
        if good:
            if judged.sliding == 1 or polished >= sweeping.polish or is_settled(judged, sweeping):
                break
            polished += sweeping.look
        lagging = not exact and lags(judged)
        before = left_over(judged, lagging)
        target = -1.0  # each of them is made
        if not exact:
            share = POLISHED if judged.residual <= judged.tolerance else WITHIN * judged.tolerance
            target = share * judged.load
        made, _ = sweep(op, group, like, sweeping.look, target)
        if made == 0:  # of loads that are not finite nothing is asked
            break
        done += made
        if exact:
            keep_best(group, best, group.p, judge(op, group, judged, group.p, like), like)
            good = is_exact(judged, best.worst)
            if good:
                break
        else:
            weigh(op, group, judged, group.p, like)
            good = is_good(judged)
        if left_over(judged, lagging) > sweeping.crawling * before and not patient:
            break
    sweeping.iterations += done
    if not exact:  # what was good enough before it was polished is polished to the end in the next step, once
        sweeping.polished = 1 if rested and polished > 0 and sweeping.polished == 0 else 0
    return good
