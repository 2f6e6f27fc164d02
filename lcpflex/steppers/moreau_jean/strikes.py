"""What closes, stays closed and is struck in a Moreau-Jean step.

See :mod:`lcpflex.steppers.moreau_jean.stepper` for the scheme, and :mod:`lcpflex.steppers.strike_order` for the order
in which contacts are struck that close within one step.
"""

from __future__ import annotations

from lcpflex.contact.table import entry_of
from lcpflex.dynamics.delassus import row_velocity
from lcpflex.dynamics.impulse import pose
from lcpflex.dynamics.joint_reactions import begin_reached, spread_reached, strike
from lcpflex.dynamics.reaction_memory import Reactions
from lcpflex.dynamics.workspace import Workspace
from lcpflex.jit.kernel import kernel, late_kernel
from lcpflex.model.arrays import Model
from lcpflex.steppers.event_driven.memory import copy_entry
from lcpflex.steppers.moreau_jean.memory import MoreauJeanScheme
from lcpflex.steppers.strike_order import begin_order, choose_strikes, needs_order

__all__ = ["follow_order", "held_within", "keep_closed", "struck"]

SLOWER = 10.0  # solver tolerances, times the velocities that cancel in it: such an approach is what solvers leave
IMPACT = 2.0  # times what forces change in a step: a faster approach is that of an impact
STILL = 1e-8  # of the fastest approach in a step: slower than that nothing approaches
HOVER = 10.0  # gap tolerances: a body that turns lifts what it stands on by far less in a step that error control takes


@kernel
def held_within(scheme: MoreauJeanScheme) -> float:
    """Gap up to which a contact that went on over the last step stays closed [m]: in error control, wider than others.

    One that hovers at the tolerance would be lost for a step, and fall, in every step longer than its error allows.
    """
    return (HOVER if scheme.velocity_threshold > 0.0 else 1.0) * scheme.gap_tolerance


@late_kernel
def keep_closed(tolerance: float, n: int, work: Workspace) -> int:
    """Of the first n entries those within ``tolerance`` [m], and those that went on over the last step."""
    m = 0
    for k in range(n):
        if (
            work.rows.table.gap[k] <= tolerance
            or entry_of(work.impulses.held_key[0], work.impulses.n_held, work.rows.table.key[k], 0) >= 0
        ):
            if m < k:
                copy_entry(work.rows.table, k, work.rows.table, m)
            m += 1
    return m


@kernel
def find_closing(model: Model, scheme: MoreauJeanScheme, work: Workspace) -> float:
    """Which contacts close by an impact in this step, whether their order is to be looked at; the fastest approach."""
    order, table, restitution = scheme.order, work.rows.table, model.contacts.restitution
    order.goes_on = 0
    rebounds = False
    for k in range(work.rows.n_contacts):
        rebounds = rebounds or restitution[table.law[k]] > 0.0
    if not rebounds:
        return 0.0
    fastest = 0.0
    for k in range(work.rows.n_contacts):
        r = work.rows.n_joint + k
        before = row_velocity(work.rows.J, work.rows.body, r, work.rows.dof, scheme.u)
        free = work.free.v[r] - (restitution[table.law[k]] * before if abs(before) > scheme.velocity_threshold else 0.0)
        order.closes[k] = 1 if -before > IMPACT * abs(free - before) else 0
        fastest = max(fastest, -before)
    order.goes_on = 1 if needs_order(restitution, table.law, work.rows.n_contacts, order.closes) else 0
    return fastest


@late_kernel
def follow_order(model: Model, scheme: MoreauJeanScheme, work: Workspace) -> None:
    """Leave those contacts in the problem posed that are struck next; after strikes, pose it at their velocities."""
    order = scheme.order
    if order.rounds == 0:
        order.slow = STILL * find_closing(model, scheme, work)
        if order.goes_on == 0:
            return
        begin_order(model, scheme.q, work.free.middle, scheme.u, work.free.u, work, order)
    else:
        for i in range(len(order.after)):
            work.free.u[i] = order.after[i]
        pose(model, work, order.before, (1.0 - scheme.theta) * scheme.step, scheme.velocity_threshold)
    slow = max(order.slow, scheme.velocity_threshold)
    choose_strikes(work, order, model.contacts.restitution, scheme.gap_tolerance, slow)


@kernel
def struck(model: Model, scheme: MoreauJeanScheme, work: Workspace, reactions: Reactions) -> bool:
    """Whether something was struck; ``reactions.reached``: the bodies that it reached."""
    some = False
    for k in range(work.rows.n_contacts):
        if closes_with_impact(model, scheme, work, k):
            if not some:
                begin_reached(work, reactions)
            some = True
            strike(work, k, reactions)
    if some:
        spread_reached(work, reactions)
    return some


@kernel
def closes_with_impact(model: Model, scheme: MoreauJeanScheme, work: Workspace, k: int) -> bool:
    """Whether contact k carries, and approached faster than forces let it within two steps: then it was an impact.

    Not where it stayed closed over the step before: what it approaches by is then the turn of its normal.
    """
    rows = work.rows
    r = rows.n_joint + k
    if not work.impulses.p[r] > 0.0:
        return False
    if scheme.order.rounds > 0 and scheme.order.closes[k] == 1:
        return True
    before = row_velocity(rows.J, rows.body, r, rows.dof, scheme.u)
    free = work.posed.effect[k]
    if abs(before) > scheme.velocity_threshold:
        free -= model.contacts.restitution[rows.table.law[k]] * before
    if not -before > IMPACT * abs(free - before) + SLOWER * scheme.tolerance * work.free.terms[k]:
        return False
    return bool(entry_of(work.impulses.held_key[0], work.impulses.n_held, rows.table.key[k], 0) < 0)
