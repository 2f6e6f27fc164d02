"""Contacts by a continuous force law beside set-valued ones: they are forces, and memory that is renewed after steps.

    M udot = h + sum W_N lambda_N(delta, deltadot) + W_T lambda_T(lambda_N, gdot_T) + what set-valued contacts do

Detection for set-valued contacts leaves them out (``ContactTable.collects``), and they have a table of their own.
"""

from __future__ import annotations

import math

from lcpflex.compiled import FloatArray, kernel
from lcpflex.contact.detection import detect
from lcpflex.contact.hollow import yield_to_deeper
from lcpflex.contact.kinematics import contact_rows
from lcpflex.contact.laws.elastic_kernels import indentation_of
from lcpflex.contact.laws.friction_kernels import friction_force
from lcpflex.contact.laws.memory import ContactMemory
from lcpflex.dynamics.constraint_rows import joint_rows
from lcpflex.dynamics.contact_memory import (
    pair_energy,
    pair_force,
    pair_place,
    pair_stiffness,
    settle,
    unsettled,
)
from lcpflex.dynamics.delassus import cholesky, cholesky_solve, delassus, row_velocity
from lcpflex.dynamics.inertia import factorise, solve_block
from lcpflex.dynamics.law_memory import LawContacts
from lcpflex.dynamics.workspace import Workspace
from lcpflex.model import Model

__all__ = ["begun", "law_forces", "law_forces_after", "law_horizon", "take_note"]

ONSET = 0.5  # of the time in which a contact would reach its largest indentation: how far a step may go into it
LEAVING = 1.001  # times that in which a contact would part at its present rate
LEAST_SHARE = 1e-3  # of the step before, below which that does not shorten one
SWEEPS = 3  # over the friction of several contacts
HALVINGS = 40
MOST_DOUBLINGS = 60
ROUNDING = 1e-14  # of the largest coordinate, at least of 1: contacts nearer than that have begun


@kernel
def look(model: Model, q: FloatArray, margin: float, laws: LawContacts) -> int:
    """Contacts by law with gap <= margin [m] into their table; returns how many."""
    n = detect(model, q, margin, laws.table)
    if n > len(laws.table.key):
        laws.found[2] = 1
        n = 0
    laws.found[0] = n
    return n


@kernel
def lay(model: Model, q: FloatArray, k: int, laws: LawContacts) -> int:
    """Rows of entry k at q; the number of the normal one. The tangential one is that of a place both bodies share."""
    r = len(laws.joint)
    contact_rows(model, q, laws.table, k, laws.rows[r], laws.rows[r + 1])
    for i in range(2):
        body = laws.table.body[k, i]
        laws.row_body[r, i] = body
        laws.row_body[r + 1, i] = body
        if body >= 0:
            laws.rows[r + 1, i, 2] += 0.5 * laws.table.gap[k]
    return r


@kernel
def push(model: Model, laws: LawContacts, rows: FloatArray, r: int, force: float, out: FloatArray) -> None:
    """out += row r of ``rows`` times a force."""
    dof = model.bodies.dof
    for i in range(2):
        b = laws.row_body[r, i]
        if b >= 0:
            for k in range(dof[b + 1] - dof[b]):
                out[dof[b] + k] += rows[r, i, k] * force


@kernel
def mobility(model: Model, laws: LawContacts, r: int, work: Workspace) -> float:
    """G_NN of row r [1/kg] without joints, with the mass matrix that was factorised last: not less than with them."""
    total = 0.0
    dof = model.bodies.dof
    for i in range(2):
        b = laws.row_body[r, i]
        if b >= 0:
            solve_block(model.bodies, work.arrow, b, laws.rows[r, i], laws.solved[r, i])
            for k in range(dof[b + 1] - dof[b]):
                total += laws.rows[r, i, k] * laws.solved[r, i, k]
    return total


@kernel
def balanced_friction(memory: ContactMemory, law: int, mu: float, normal: float, slip: float, share: float) -> float:
    """The friction f [N] with f = F_T(slip + share f), ``share`` = h G_TT [s/kg]; F_T at ``slip`` itself where it is 0.

    The left side less the right has opposite signs at 0 and beyond F_T(slip): friction opposes, and is bounded.
    """
    kinds = memory.kinds[law]
    p = memory.parameters[law]
    first = friction_force(kinds, p, slip, normal, mu, 0.0, 0.0)
    if share == 0.0 or first == 0.0:
        return first
    low = 0.0
    high = first
    for _ in range(MOST_DOUBLINGS):
        if (high - friction_force(kinds, p, slip + share * high, normal, mu, 0.0, 0.0)) * first >= 0.0:
            break
        low = high
        high *= 2.0
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        if (middle - friction_force(kinds, p, slip + share * middle, normal, mu, 0.0, 0.0)) * first >= 0.0:
            high = middle
        else:
            low = middle
    return 0.5 * (low + high)


@kernel
def rub(model: Model, q: FloatArray, u: FloatArray, h: float, work: Workspace) -> None:
    """Friction of the contacts whose normal forces are known, to ``laws.p`` and ``laws.friction``.

    Explicit at h = 0. In a step of h > 0 [s] at its end, as it would be without set-valued contacts and joints: the
    slope of friction at rest, mu N over the slip speed, admits no explicit step. Then M is to be factorised.
    """
    laws = work.laws
    n = laws.found[0]
    for i in range(len(q)):
        laws.free[i] = u[i]
        laws.friction[i] = 0.0
    if h > 0.0:
        for i in range(len(q)):
            laws.push[i] = h * (work.conservative[i] + work.dissipative[i] + work.driving[i])
        move(model, laws, work)
    for _ in range(SWEEPS if h > 0.0 and n > 1 else 1):
        for k in range(n):
            law = laws.table.law[k]
            mu = model.contacts.friction[law]
            if not (laws.p[k, 0] > 0.0 and mu > 0.0):
                continue
            r = lay(model, q, k, laws) + 1
            share = h * mobility(model, laws, r, work) if h > 0.0 else 0.0
            slip = row_velocity(laws.rows, laws.row_body, r, model.bodies.dof, laws.free) - share * laws.p[k, 1]
            force = balanced_friction(laws.memory, law, mu, laws.p[k, 0], slip, share)
            laws.sticks[k] = 1 if abs(slip + share * force) < laws.memory.slip_speed[law] else 0
            change = force - laws.p[k, 1]
            laws.p[k, 1] = force
            push(model, laws, laws.rows, r, change, laws.friction)
            if h > 0.0:
                push(model, laws, laws.solved, r, h * change, laws.free)


@kernel
def move(model: Model, laws: LawContacts, work: Workspace) -> None:
    """laws.free += M^-1 laws.push, with M as it was factorised last."""
    dof = model.bodies.dof
    for b in range(len(dof) - 1):
        block = laws.push[dof[b] : dof[b + 1]]
        solve_block(model.bodies, work.arrow, b, block, block)
    for i in range(len(laws.push)):
        laws.free[i] += laws.push[i]


@kernel
def law_forces(model: Model, q: FloatArray, u: FloatArray, h: float, work: Workspace) -> None:
    """Add the forces of contacts by law to those in ``work``: of springs to conservative, the rest to dissipative.

    Friction at h > 0 is that at the end of a step of h [s], see ``rub``.
    """
    laws = work.laws
    if len(laws.friction) == 0:
        return
    n = look(model, q, 0.0, laws)
    yield_to_deeper(laws.table, n)
    laws.stored[0] = 0.0
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
        laws.stored[0] += pair_energy(memory, law, place, depth)
        laws.sticks[k] = 0
    rub(model, q, u, h, work)
    for i in range(len(q)):
        work.dissipative[i] += laws.friction[i]
        work.total[i] = work.conservative[i] + work.dissipative[i] + work.driving[i]


@kernel
def law_forces_after(model: Model, q: FloatArray, u: FloatArray, work: Workspace) -> None:
    """Forces of contacts by law in the state (q, u) that a step with ``law_forces`` led to, with the friction of it.

    Part of the slip at its end is what set-valued contacts did not let happen: friction of that slip did not act.
    """
    laws = work.laws
    n = laws.found[0]
    for k in range(n):
        laws.last[k, 0] = laws.table.key[k] if laws.p[k, 0] > 0.0 else -1.0
        laws.last[k, 1] = laws.p[k, 1] / laws.p[k, 0]
        laws.last[k, 2] = laws.sticks[k]
    law_forces(model, q, u, 0.0, work)
    for k in range(laws.found[0]):
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
    n_joint = len(laws.joint)
    joint_rows(model, t, q, u, work.external, laws.rows, laws.row_body, laws.bias[0], laws.bias[1])
    for r in range(n_joint):
        for i in range(2):
            b = laws.row_body[r, i]
            if b >= 0:
                solve_block(model.bodies, work.arrow, b, laws.rows[r, i], laws.solved[r, i])
    for k in range(laws.found[0]):
        r = lay(model, q, k, laws)
        mobility(model, laws, r, work)
        delassus(laws.rows, laws.solved, laws.row_body, n_joint + 1, laws.G)
        cholesky(laws.G, n_joint, laws.lower)
        for j in range(n_joint):
            laws.joint[j] = laws.G[j, r]
        cholesky_solve(laws.lower, n_joint, laws.joint)
        for j in range(n_joint):
            laws.inverse[k, k] -= laws.joint[j] * laws.G[j, r]


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
    n = laws.found[0]
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
            laws.stored[1] = max(laws.stored[1], damping + math.sqrt(damping * damping + stiffness))
    if begins and len(laws.joint) > 0:
        hold_joints(model, t, q, u, work)
    laws.found[1] = settle(model, laws.memory, laws.table, n, laws.rate, laws.inverse, laws.states)
    return laws.found[1] < 0 and laws.found[2] == 0
