"""One segment of an event-driven run: Runge-Kutta steps with fixed index sets, and the search for what ends them.

Events are looked for at four samples of each step and located on its dense output.
"""

from __future__ import annotations

import math

from lcpflex.contact.narrow_phase.feature import foot_margin, node_margin
from lcpflex.contact.narrow_phase.limits import SPAN_TOLERANCE
from lcpflex.dynamics.acceleration import STICKING, sliding_sign
from lcpflex.dynamics.contact_forces import (
    compression,
    fill_rows,
    find_contacts,
    mobility,
    parting_time,
)
from lcpflex.dynamics.contact_forces_history import has_begun
from lcpflex.dynamics.delassus import row_velocity
from lcpflex.dynamics.instants import longest_look, time_left
from lcpflex.dynamics.mechanics import solve_rows
from lcpflex.dynamics.workspace import Workspace
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.jit.leaf import in_space
from lcpflex.model.arrays import Model
from lcpflex.steppers.event_driven.gaps import CROSSED, NARROW, first_closing, first_dip
from lcpflex.steppers.event_driven.memory import (
    CLOSING,
    CONE,
    PRESSURE,
    SLIDING,
    SPAN,
    EventMemory,
    EventSettings,
    within,
)
from lcpflex.steppers.event_driven.root import asked, found, start, tell
from lcpflex.steppers.event_driven.slope import slope
from lcpflex.steppers.runge_kutta import STAGES, C, copy_state, error_norm, stage_state, step_factor
from lcpflex.steppers.short_steps import ALL_OF_IT, onset_share, travel_time

__all__ = ["FORCE_TOLERANCE", "measure", "search", "step", "watch"]

NOTHING = -1
SAMPLES = 4
FORCE_TOLERANCE = 1e-9  # of the largest contact force: a smaller wrong sign is rounding
LEAST_SHARE = 1e-6  # of a step: what is not understood in so short a time is told
REPEATS = 3  # of a step, to end where it begins


@in_space("lcpflex.steppers.spatial.sliding")
@kernel
def turning_time(work: Workspace, memory: EventMemory, u: FloatArray) -> float:
    """The longest step [s] in which no slip turns unseen: in the plane it changes its sign where it does."""
    return math.inf


@in_space("lcpflex.steppers.spatial.sliding")
@kernel
def used(memory: EventMemory) -> int:
    """Components of the state but for those of laws that no pair has got yet."""
    return memory.nq + len(memory.u) + 3 + 2 * memory.seen.pairs.n_laws


@in_space("lcpflex.steppers.spatial.sliding")
@kernel
def watch(model: Model, work: Workspace, memory: EventMemory, y: FloatArray) -> None:
    """Watched functions of all maintained contacts, after ``slope`` at the same state."""
    nq = memory.nq
    q = y[:nq]
    u = y[nq : nq + len(memory.u)]
    n_joint = work.rows.n_joint
    n = memory.n_contacts
    memory.force = 0.0
    for k in range(n):
        p_n = work.impulses.p[n_joint + k]
        memory.value[PRESSURE, k] = p_n
        memory.value[CONE, k] = math.inf
        memory.value[SLIDING, k] = math.inf
        memory.value[SPAN, k] = foot_margin(model, q, work.rows.table, k)
        memory.value[SPAN, k] = min(memory.value[SPAN, k], node_margin(model, q, work.rows.table, k))
        size = abs(p_n)
        if work.posed.own[k] > 0.0:
            size = max(size, abs(work.posed.effect[k]) / work.posed.own[k])
        memory.force = max(memory.force, size)
        tangent = memory.sets.tangent_of[k]
        if tangent >= 0:
            r = n_joint + n + tangent
            if memory.sets.mode[k] == STICKING:
                memory.value[CONE, k] = work.rows.mu[k] * p_n - abs(work.impulses.p[r])
            else:
                sign = sliding_sign(memory.sets.mode[k])
                memory.value[SLIDING, k] = sign * row_velocity(work.rows.J, work.rows.body, r, work.rows.dof, u)


@in_space("lcpflex.steppers.spatial.sliding")
@kernel
def tolerance_of(settings: EventSettings, memory: EventMemory, kind: int) -> float:
    """How far below zero a watched function may be."""
    if kind == SPAN:
        return SPAN_TOLERANCE
    if kind == SLIDING:
        return settings.slip_threshold
    return FORCE_TOLERANCE * memory.force


@in_space("lcpflex.steppers.spatial.sliding")
@kernel
def watched_first(memory: EventMemory, place: int) -> int:
    """Which watched function is asked at a place of the order: in the plane they are asked as they are numbered."""
    return place


@in_space("lcpflex.steppers.spatial.sliding")
@kernel
def before_it_leaves(memory: EventMemory, low: float, high: float) -> float:
    """Share of a step at which forces are looked at, too, where a foot leaves at ``high``: in the plane at none."""
    return high


@in_space("lcpflex.steppers.spatial.speeds")
@kernel
def unseen_step(model: Model, margin: float, memory: EventMemory) -> float:
    """Step [s] in which no two bodies come nearer by more than ``margin`` [m]: nothing farther apart is looked at."""
    size = 0.0
    for extent in model.contacts.surface_extent:
        if extent < math.inf:
            size = max(size, extent)
    fastest, second = 0.0, 0.0
    ndof = len(memory.u)
    for b in range(len(model.bodies.mass)):
        d = ndof + model.bodies.dof[b]
        speed = math.hypot(memory.y[d], memory.y[d + 1]) + size * abs(memory.y[d + 2])
        pull = math.hypot(memory.slopes[0, d], memory.slopes[0, d + 1]) + size * abs(memory.slopes[0, d + 2])
        speed += math.sqrt(margin * pull)
        if speed > fastest:
            fastest, second = speed, fastest
        else:
            second = max(second, speed)
    return margin / (fastest + second) if fastest > 0.0 else math.inf


@kernel
def compliant_step(model: Model, margin: float, last: float, work: Workspace, memory: EventMemory) -> float:
    """Longest step [s] that passes over no compliant contact, after ``slope`` at y.

    It ends where the first pair nearer than ``margin`` [m] closes, with the present accelerations, and goes a part of
    the compression further; nor does it go far beyond the end of an indentation, measured by the ``last`` step [s].
    """
    nq, base = memory.nq, memory.nq + len(memory.u)
    contacts = work.compliant
    q, u, a = memory.y[:nq], memory.y[nq:base], memory.slopes[0, nq:base]
    longest = math.inf
    find_contacts(model, q, margin, contacts)
    fill_rows(model, q, contacts)
    for k in range(contacts.rows.n_contacts):
        gap = contacts.rows.table.gap[k]
        r = contacts.rows.n_joint + k
        approach = -row_velocity(contacts.rows.J, contacts.rows.body, r, contacts.rows.dof, u)
        if gap > 0.0:
            pull = -row_velocity(contacts.rows.J, contacts.rows.body, r, contacts.rows.dof, a)
            square = approach * approach + 2.0 * pull * gap  # of the speed at which they meet
            if square > 0.0 and (approach > 0.0 or pull > 0.0):
                solve_rows(model, contacts.rows, r, r + 1)
                speed = math.sqrt(square)
                depth = compression(contacts, k, square, mobility(contacts, r))
                longest = min(longest, 2.0 * gap / (approach + speed) + depth / speed)
        elif gap < 0.0 and approach < 0.0:  # where damping is clipped, nothing else tells of the end of the spring
            longest = min(longest, parting_time(gap, approach, last))
    return longest


@kernel
def step(model: Model, settings: EventSettings, work: Workspace, memory: EventMemory) -> bool:
    """One accepted Runge-Kutta step from y to end; its length in memory.step_taken. False if no length is short enough.

    The slope at y is in ``slopes[0]``.
    """
    t = memory.time
    rest = time_left(model.signals, t, settings.duration)
    nq, base = memory.nq, memory.nq + len(memory.u)
    h = memory.step
    if not h > 0.0:
        h = error_norm(memory.y, memory.y, memory.slopes, 1.0, base, settings.rtol, settings.atol)
        h = 0.01 * settings.duration if h < 1e-3 else min(0.01 * settings.duration, 0.1 / h)
    rejected = False
    longest = SAMPLES * travel_time(model, memory.y, memory.slopes[0])
    if len(work.compliant.friction) > 0:  # which no sample looks for
        reach = compliant_step(model, settings.margin, h, work, memory)
        longest = min(longest / SAMPLES, reach, unseen_step(model, settings.margin, memory))
    longest = min(settings.max_step, longest, longest_look(model.signals))
    longest = min(longest, turning_time(work, memory, memory.y[nq:base]))
    if memory.looks > 0:
        longest = min(longest, h * 0.1**memory.looks)
    left = REPEATS
    while True:
        h = min(h, longest)
        if h > 0.99 * rest and left == REPEATS:
            h = rest
        for stage in range(1, STAGES):
            stage_state(memory.y, memory.slopes, h, stage, memory.end)
            slope(model, t + C[stage] * h, memory.end, work, memory, memory.slopes[stage])
        # impulses and work, too: a body that sticks under a changing load does not move, and would hide it
        error = error_norm(memory.y, memory.end, memory.slopes, h, used(memory), settings.rtol, settings.atol)
        if error <= 1.0:
            share = 1.0
            contacts = work.compliant
            if len(contacts.history.feature) > 0 and has_begun(model, memory.end[:nq], memory.end[nq:base], contacts):
                share = onset_share(model, nq, memory.y, memory.slopes, h, memory.at, contacts)
            if share < ALL_OF_IT and left > 0:  # its stages would mix what is before and behind
                if left == REPEATS:
                    memory.step = h
                left -= 1
                h *= share
                continue
            factor = step_factor(error, memory.error)
            if rejected:
                factor = min(factor, 1.0)
            if left == REPEATS and memory.looks == 0:
                memory.step = max(memory.step, h) if h == rest else h * factor
            memory.error = error
            memory.step_taken = h
            return True
        rejected = True
        h *= max(0.1, 0.9 * error**-0.2) if error < math.inf else 0.1
        if h < 1e-14 * max(t, 1e-3 * settings.duration):
            return False


@kernel
def measure(model: Model, work: Workspace, memory: EventMemory, share: float) -> None:
    """State, slope and watched functions at a share of the step."""
    within(model, memory, share, memory.at)
    slope(model, memory.time + share * memory.step_taken, memory.at, work, memory, memory.slope)
    watch(model, work, memory, memory.at)


@kernel
def violated(settings: EventSettings, memory: EventMemory) -> bool:
    """Whether a watched function is below zero; which one, to memory.kind and memory.which."""
    for place in range(4):
        kind = watched_first(memory, place)
        tolerance = tolerance_of(settings, memory, kind)
        for k in range(memory.n_contacts):
            if memory.value[kind, k] < -tolerance:
                memory.kind = kind
                memory.which = k
                return True
    return False


@in_space("lcpflex.steppers.spatial.sliding")
@kernel
def steps_behind(work: Workspace) -> int:
    """Steps at whose ends contacts are sought that begin where another one has left; see ``arises``."""
    return 0


@in_space("lcpflex.steppers.spatial.sliding")
@kernel
def arises(model: Model, settings: EventSettings, work: Workspace, memory: EventMemory) -> bool:
    """Whether a contact that is not maintained touches at the end of the step, in ``memory.before``.

    In the plane none does that would not have closed: faces touch in no more than their ends.
    """
    return False


@kernel
def search(model: Model, settings: EventSettings, work: Workspace, memory: EventMemory) -> bool:
    """First event of the step, to memory.share and memory.cause. False if tables must grow, to memory.number.

    A violated function is located, and what is violated there too in turn, until nothing else is.
    """
    n = memory.n_contacts
    narrow = NARROW * (memory.time + memory.step_taken) / memory.step_taken
    memory.cause = NOTHING
    memory.share = 1.0
    copy_state(memory.y, memory.before)
    for sample in range(1, SAMPLES + 1):
        low = (sample - 1) / SAMPLES
        high = sample / SAMPLES
        while True:  # earlier and earlier, until nothing has closed before
            within(model, memory, high, memory.at)
            closing = first_dip(model, settings, work, memory, low, high)
            if closing < 0.0:
                memory.number = closing
                return False
            if closing < high:
                memory.cause = CLOSING if memory.hidden == CROSSED else NOTHING
                high = closing
                continue
            closing = first_closing(model, settings, work, memory, low, high)
            if closing < 0.0:
                memory.number = -closing
                return False
            if closing < high:
                memory.cause = CLOSING
                high = closing
                continue
            if closing > high and memory.hidden == 1 and high - low > LEAST_SHARE:
                memory.cause = NOTHING
                high = low + 0.5 * (high - low)
                continue
            if closing == high:
                memory.cause = CLOSING
            break
        for kind in range(4):
            for k in range(n):
                memory.old_value[kind, k] = memory.value[kind, k]
        target = high  # the root finder is at work where this is behind the end known so far
        looked = False
        while n > 0:
            measure(model, work, memory, target)
            kind = memory.kind
            k = memory.which
            if target < high:
                tell(memory.bracket, memory.value[kind, k])
                if asked(memory.bracket) < 0.0:
                    memory.cause = kind
                    if found(memory.bracket) >= high - narrow:
                        break  # as near as time resolves
                    high = found(memory.bracket)
                    target = high
                    continue
            elif violated(settings, memory):
                kind = memory.kind
                k = memory.which
                f_low = memory.old_value[kind, k]
                tolerance = tolerance_of(settings, memory, kind)
                if kind == SLIDING and f_low < -tolerance:  # an impact has left it sliding the other way: choose anew
                    memory.cause = kind
                    high = low + LEAST_SHARE * (high - low)
                    break
                start(memory.bracket, low, high, f_low, memory.value[kind, k], tolerance, narrow)
                if asked(memory.bracket) < 0.0 or not asked(memory.bracket) < high:
                    memory.cause = kind
                    break
            elif memory.cause == SPAN and not looked and before_it_leaves(memory, low, high) < high:
                looked = True
                measure(model, work, memory, before_it_leaves(memory, low, high))
                if violated(settings, memory):
                    high = before_it_leaves(memory, low, high)
                target = high
                continue
            else:
                break
            target = asked(memory.bracket)
        if memory.cause != NOTHING or high < sample / SAMPLES:
            memory.share = high
            memory.looks = steps_behind(work) if memory.cause == SPAN else 0
            return True
        within(model, memory, high, memory.before)
    if memory.looks > 0:
        memory.looks -= 1
        if arises(model, settings, work, memory):
            memory.looks, memory.cause = 0, CLOSING
    return True
