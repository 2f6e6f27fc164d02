"""Contacts that close within one step, struck in the order in which they close.

A step finds at its end what has closed in it. Where some of these share a body, and rebound, their order decides: a
ball that lands, and then meets one that follows it, throws that one up with 3 v - of two struck at once neither does
more than it would alone. Between strikes bodies move evenly: contact k, at the gap g_k at the start of the step, closes
after g_k / -gdot_k, and those of an island that close by the same instant are struck together, by the law of the step.
Gaps go on from there with the velocities after it, until no contact approaches.

Contacts that rest take part in each strike of their island; those that are yet to close do not.

Few runs have such steps: what only these need is compiled in the first of them.
"""

from __future__ import annotations

import math

from lcpflex.contact.narrow_phase.feature import refresh
from lcpflex.dynamics.delassus import row_velocity
from lcpflex.dynamics.impulse import add_impulses, answer_joints
from lcpflex.dynamics.islands import Islands
from lcpflex.dynamics.workspace import Workspace
from lcpflex.jit.kernel import FloatArray, IntArray, kernel, late_kernel
from lcpflex.jit.struct import allocate, array, struct
from lcpflex.model.arrays import Model
from lcpflex.model.layout import is_spatial
from lcpflex.steppers.system import System

__all__ = [
    "StrikeOrder",
    "add_strikes",
    "apply_strike",
    "begin_order",
    "choose_strikes",
    "end_order",
    "needs_order",
    "order_remarks",
    "strike_order",
]

MOST_STRIKES = 30  # of an island in a step, and one more for each contact: then the rest is struck at once


@struct
class StrikeOrder:
    """Strikes of a step, as far as they have been followed."""

    gap: FloatArray = array("contacts")  # of contacts that close in this step, at the last strike of their island [m]
    closes: IntArray = array("contacts")  # 1: closes in this step
    now: IntArray = array("contacts")  # 1: takes part in the present strike
    before: FloatArray = array("ndof")  # velocity that restitution reflects: of the start, and what strikes have added
    after: FloatArray = array("ndof")  # velocity at the end of the step, with the strikes so far
    p: FloatArray = array("rows")  # impulses of the strikes so far [N s]
    slow: float  # slower approach is none [m/s]
    rounds: int  # strikes so far
    goes_on: int  # 1: the present problem is one of them, and another one follows
    ordered: int  # steps with several
    cut: int  # steps whose strikes were not followed to their end


@kernel
def needs_order(restitution: FloatArray, law: IntArray, n: int, closes: IntArray) -> bool:
    """Whether more than one of n contacts closes, and one that does rebounds: their islands are to be looked at."""
    count, rebounds = 0, False
    for k in range(n):
        if closes[k] == 1:
            count += 1
            rebounds = rebounds or restitution[law[k]] > 0.0
    return count > 1 and rebounds


@kernel
def first_closing(work: Workspace, order: StrikeOrder, i: int, slow: float) -> float:
    """Time until the next contact of island i closes [s], at velocities ``order.before`` faster than ``slow`` [m/s].

    Negative where it has sunk in before: a step may find what closed in the one before. Not of contacts that forces
    open by the end of the step as fast as they would rebound: no strike would change that.
    """
    first = math.inf
    for c in range(work.posed.islands.start[i], work.posed.islands.start[i + 1]):
        k = work.posed.islands.contact[c]
        if order.closes[k] == 1:
            v = row_velocity(work.rows.J, work.rows.body, work.rows.n_joint + k, work.rows.dof, order.before)
            if v < -slow and work.free.v[work.rows.n_joint + k] < 0.0:
                first = min(first, order.gap[k] / -v)
    return first


@kernel
def choose_island(
    work: Workspace, order: StrikeOrder, restitution: FloatArray, i: int, closed: float, slow: float
) -> bool:
    """The contacts of island i that are struck next, to ``order.now``; False where no order is left to be kept.

    closed: gap up to which contacts count as closed [m].
    """
    islands, n_joint = work.posed.islands, work.rows.n_joint
    time = first_closing(work, order, i, slow)
    if time == math.inf:
        return False
    apart, rebounds = False, False
    for c in range(islands.start[i], islands.start[i + 1]):
        k = islands.contact[c]
        order.now[k] = 1
        if order.closes[k] == 0:
            continue
        rebounds = rebounds or restitution[work.rows.table.law[k]] > 0.0
        v = row_velocity(work.rows.J, work.rows.body, n_joint + k, work.rows.dof, order.before)
        if order.gap[k] + time * v > closed:
            order.now[k] = 0
            apart = True
    if order.rounds == 0 and not (apart and rebounds):
        return False
    for c in range(islands.start[i], islands.start[i + 1]):
        k = islands.contact[c]
        if order.closes[k] == 1:
            v = row_velocity(work.rows.J, work.rows.body, n_joint + k, work.rows.dof, order.before)
            order.gap[k] = max(order.gap[k] + time * v, 0.0)
    return True


@late_kernel
def choose_strikes(work: Workspace, order: StrikeOrder, restitution: FloatArray, closed: float, slow: float) -> None:
    """Which contacts of the islands laid are struck next; ``order.goes_on`` 0: no order is left to be kept."""
    islands, found = work.posed.islands, False
    most = MOST_STRIKES
    for i in range(islands.count):
        most = max(most, MOST_STRIKES + islands.start[i + 1] - islands.start[i])
        chosen = choose_island(work, order, restitution, i, closed, slow)
        if not chosen:
            for c in range(islands.start[i], islands.start[i + 1]):
                order.now[islands.contact[c]] = 0
        found = found or chosen
    if found and order.rounds >= most:
        order.cut += 1
        found = False
    if found and order.rounds == 0:
        order.ordered += 1
    order.goes_on = 1 if found else 0
    if found:
        keep_struck(islands, order.now)
        for r in range(work.rows.n_joint + work.rows.n_contacts + work.rows.n_tangents):
            work.impulses.p[r] = 0.0


@kernel
def keep_struck(of: Islands, now: IntArray) -> None:
    """Leave those contacts in the islands that are struck ``now``; an island may have none."""
    begin, at = of.start[0], 0
    for i in range(of.count):
        end = of.start[i + 1]
        for c in range(begin, end):
            if now[of.contact[c]] == 1:
                of.contact[at] = of.contact[c]
                at += 1
        of.start[i + 1] = at
        begin = end


@late_kernel
def begin_order(
    model: Model, q: FloatArray, now: FloatArray, u: FloatArray, free_u: FloatArray, work: Workspace, order: StrikeOrder
) -> None:
    """Before the first strike of a step from q and u, to ``free_u`` without impulses; ``now``: where contacts stand."""
    table = work.rows.table
    for k in range(work.rows.n_contacts):
        if order.closes[k] == 1:
            refresh(model, q, table, k)
            order.gap[k] = table.gap[k]
            refresh(model, now, table, k)
    for i in range(len(u)):
        order.before[i] = u[i]
        order.after[i] = free_u[i]


@late_kernel
def apply_strike(work: Workspace, order: StrikeOrder) -> None:
    """The strike just solved: what it adds to velocities and impulses, for the next one."""
    answer_joints(work)
    add_impulses(work, work.free.u)
    for i in range(len(order.after)):
        order.before[i] += work.free.u[i] - order.after[i]
        order.after[i] = work.free.u[i]
    for r in range(work.rows.n_joint + work.rows.n_contacts + work.rows.n_tangents):
        order.p[r] = work.impulses.p[r] + (0.0 if order.rounds == 0 else order.p[r])
    order.rounds += 1


@late_kernel
def add_strikes(work: Workspace, order: StrikeOrder) -> None:
    """Count the impulses of strikes into those of the last problem of the step; least forces are not sought then."""
    for r in range(work.rows.n_joint + work.rows.n_contacts + work.rows.n_tangents):
        work.impulses.p[r] += order.p[r]
    work.posed.islands.shortened = work.posed.islands.count


@kernel
def end_order(order: StrikeOrder) -> None:
    """The step is made."""
    order.rounds, order.goes_on = 0, 0


def strike_order(system: System, capacity: int) -> StrikeOrder:
    """Allocate for ``capacity`` contacts."""
    each = 3 if is_spatial(system.model) else 2  # rows of a contact
    sizes = {"contacts": capacity, "ndof": len(system.u), "rows": system.n_joint + each * capacity}
    return allocate(StrikeOrder, sizes)


def order_remarks(order: StrikeOrder, steps: int | None) -> list[str]:
    """Steps in which contacts strike each other more often than a step follows them one by one."""
    if not order.cut:
        return []
    of = f"{order.cut} steps" if steps is None else f"{order.cut} of {steps} steps"
    return [
        f"in {of} contacts that share a body would have struck more than {MOST_STRIKES} times, one after the other: "
        "the rest was struck at once, where the order decides the motion (a shorter step has fewer strikes)"
    ]
