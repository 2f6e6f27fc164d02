"""Contacts by a continuous force law beside set-valued ones: they are forces, and memory that is renewed after steps.

    M udot = h + sum W_N lambda_N(delta, deltadot) + W_T lambda_T(lambda_N, gdot_T) + what set-valued contacts do

Detection for set-valued contacts leaves them out (``ContactTable.collects``), and they have a table of their own.
"""

from __future__ import annotations

import math

from lcpflex.contact.concave_corners import yield_to_deeper
from lcpflex.dynamics.contact_memory import (
    pair_energy,
    pair_force,
    pair_place,
    pair_stiffness,
    settle,
    unsettled,
)
from lcpflex.dynamics.delassus import row_velocity
from lcpflex.dynamics.inertia import factorise
from lcpflex.dynamics.law_friction import rub
from lcpflex.dynamics.law_rows import couple_joints, factor_joints, lay, look, mobility, push
from lcpflex.dynamics.workspace import Workspace
from lcpflex.force_laws.elastic.kernels import indentation_of
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.model.arrays import Model

__all__ = ["begun", "law_forces", "law_forces_after", "law_horizon", "take_note"]

ONSET = 0.5  # of the time in which a contact would reach its largest indentation: how far a step may go into it
LEAVING = 1.001  # times that in which a contact would part at its present rate
LEAST_SHARE = 1e-3  # of the step before, below which that does not shorten one
ROUNDING = 1e-14  # of the largest coordinate, at least of 1: contacts nearer than that have begun


@kernel
def law_forces(model: Model, t: float, q: FloatArray, u: FloatArray, h: float, work: Workspace) -> None:
    """Add the forces of contacts by law to those in ``work``: of springs to conservative, the rest to dissipative.

    Friction at h > 0 is that at the end of a step of h [s], see ``rub``.
    """
    laws = work.laws
    if len(laws.friction) == 0:
        return
    n = look(model, q, 0.0, laws)
    yield_to_deeper(laws.table, n)
    laws.stored = 0.0
    for k in range(n):
        laws.p[k, 0] = 0.0
        laws.p[k, 1] = 0.0
        depth = -laws.table.gap[k]
        if not depth > 0.0:
            continue
        law = laws.table.law[k]
        memory = laws.memory
        r = lay(model, q, k, laws)
        rate = -row_velocity(laws.rows, laws.row_body, r, model.bodies.dof, u)
        place = pair_place(model, memory, laws.table, k)
        force, elastic = pair_force(memory, law, place, depth, rate)
        push(model, laws, laws.rows, r, elastic, work.conservative)
        push(model, laws, laws.rows, r, force - elastic, work.dissipative)
        laws.p[k, 0] = force
        laws.stored += pair_energy(memory, law, place, depth)
        laws.sticks[k] = 0
    rub(model, t, q, u, h, work)
    for i in range(len(q)):
        work.dissipative[i] += laws.friction[i]
        work.total[i] = work.conservative[i] + work.dissipative[i] + work.driving[i]


@kernel
def law_forces_after(model: Model, q: FloatArray, u: FloatArray, work: Workspace) -> None:
    """Forces of contacts by law in the state (q, u) that a step with ``law_forces`` led to, with the friction of it.

    Part of the slip at its end is what set-valued contacts did not let happen: friction of that slip did not act.
    """
    laws = work.laws
    n = laws.n_touching
    for k in range(n):
        laws.last[k, 0] = laws.table.key[k] if laws.p[k, 0] > 0.0 else -1.0
        laws.last[k, 1] = laws.p[k, 1] / laws.p[k, 0] if laws.p[k, 0] > 0.0 else 0.0
        laws.last[k, 2] = laws.sticks[k]
    law_forces(model, 0.0, q, u, 0.0, work)
    for k in range(laws.n_touching):
        for i in range(n):
            if laws.last[i, 0] == laws.table.key[k]:
                laws.p[k, 1] = laws.last[i, 1] * laws.p[k, 0]
                laws.sticks[k] = 1 if laws.last[i, 2] > 0.0 else 0


@kernel
def law_horizon(
    model: Model, q: FloatArray, u: FloatArray, a: FloatArray, margin: float, last: float, work: Workspace
) -> float:
    """Longest step [s] that passes over no contact by law, with accelerations ``a`` and M(q) factorised.

    It ends where the first pair nearer than ``margin`` [m] closes, and goes ONSET of the time of compression further;
    nor does it go far beyond the end of an indentation, if that is not much less than the ``last`` step [s].
    """
    laws = work.laws
    longest = math.inf
    if len(laws.friction) == 0:
        return longest
    n = look(model, q, margin, laws)
    for k in range(n):
        gap = laws.table.gap[k]
        r = lay(model, q, k, laws)
        approach = -row_velocity(laws.rows, laws.row_body, r, model.bodies.dof, u)
        if gap > 0.0:
            pull = -row_velocity(laws.rows, laws.row_body, r, model.bodies.dof, a)
            square = approach * approach + 2.0 * pull * gap  # of the speed at which they meet
            if square > 0.0 and (approach > 0.0 or pull > 0.0):
                law = laws.table.law[k]
                inverse = mobility(model, laws, r, work)
                time = 2.0 * gap / (approach + math.sqrt(square))
                if inverse > 0.0:
                    energy = 0.5 * square / inverse
                    depth = indentation_of(laws.memory.kinds[law], laws.memory.parameters[law], energy)
                    time += ONSET * depth / math.sqrt(square)
                longest = min(longest, time)
        elif gap < 0.0 and approach < 0.0:  # where damping is clipped, nothing else tells of the end of the spring
            longest = min(longest, max(LEAVING * gap / approach, LEAST_SHARE * last))
    return longest


@kernel
def roundings(values: FloatArray) -> float:
    """What may be lost by rounding in a sum of ``values`` and numbers of order 1, amply."""
    largest = 1.0
    for value in values:
        largest = max(largest, abs(value))
    return ROUNDING * largest


@kernel
def begun(model: Model, q: FloatArray, u: FloatArray, slack: float, work: Workspace) -> bool:
    """Whether a contact that will be remembered has begun and is not; gaps count as smaller by ``slack`` [m].

    Rates and G_NN without joints of all entries are left in ``work.laws``, the latter with the last factorised M.
    """
    laws = work.laws
    n = look(model, q, slack, laws)
    for k in range(n):
        r = lay(model, q, k, laws)
        laws.table.gap[k] -= slack
        laws.rate[k] = row_velocity(laws.rows, laws.row_body, r, model.bodies.dof, u)
        laws.inverse[k, k] = mobility(model, laws, r, work)
    yield_to_deeper(laws.table, n)
    return unsettled(model, laws.memory, laws.table, n, laws.rate)


@kernel
def hold_joints(model: Model, t: float, q: FloatArray, u: FloatArray, work: Workspace) -> None:
    """Take from the G_NN of all entries what joints do not let happen."""
    laws = work.laws
    factor_joints(model, t, q, u, work)
    for k in range(laws.n_touching):
        r = lay(model, q, k, laws)
        mobility(model, laws, r, work)
        laws.inverse[k, k] -= couple_joints(laws, r)


@kernel
def take_note(model: Model, t: float, q: FloatArray, u: FloatArray, work: Workspace) -> bool:
    """Let contacts by law take note of the accepted state (q, u) of time t; whether all are in range of their laws.

    What is short of a touch by rounding counts as touching: a step that ended there would not have ended for it.
    """
    laws = work.laws
    if len(laws.friction) == 0:
        return True
    factorise(model.bodies, q, 0.0, 0.0, work.arrow)
    begins = begun(model, q, u, roundings(q), work)
    n = laws.n_touching
    for k in range(n):
        if laws.table.gap[k] < 0.0:
            law, depth, rate = laws.table.law[k], -laws.table.gap[k], abs(laws.rate[k])
            place = pair_place(model, laws.memory, laws.table, k)
            stiffness = pair_stiffness(laws.memory, law, place, depth) * laws.inverse[k, k]
            damping = 0.0
            if rate > 0.0:  # on approach, where no force is clipped
                moving = pair_force(laws.memory, law, place, depth, rate)[0]
                still = pair_force(laws.memory, law, place, depth, 0.0)[0]
                damping = 0.5 * max(moving - still, 0.0) / rate * laws.inverse[k, k]
            laws.stiffest = max(laws.stiffest, damping + math.sqrt(damping * damping + stiffness))
    if begins and len(laws.joint) > 0:
        hold_joints(model, t, q, u, work)
    laws.out_of_range = settle(model, laws.memory, laws.table, n, laws.rate, laws.inverse, laws.states)
    return laws.out_of_range < 0 and laws.too_small == 0
