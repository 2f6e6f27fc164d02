"""Contacts in space between two events: what the run sums up of them, what is watched, how long a step may be.

A contact that slides is watched by its slip: |gamma| - v_s, v_s the threshold below which slip counts as none. |gamma|
has no change of sign to be found by, so no step is longer than a part of |gamma| / |gammadot|: none passes over the
place where it is least. A contact that has just begun to slide is slower than v_s at first. It is watched by
d . gamma + 2 v_s, d the direction that it was to slide in, until it is a thousand times faster at the start of a step.
"""

from __future__ import annotations

import math
from typing import Any

from lcpflex.contact.narrow_phase.feature import foot_margin, node_margin, refresh
from lcpflex.contact.narrow_phase.limits import SPAN_TOLERANCE
from lcpflex.contact.spatial.detection import detect
from lcpflex.contact.spatial.pairs import contact_point, gap_rate
from lcpflex.contact.spatial.table import EDGE_FACET, NODE_CAP, NODE_FACET, side_of
from lcpflex.contact.table import entry_of
from lcpflex.dynamics.delassus import row_velocity
from lcpflex.dynamics.spatial.acceleration import (
    BEGINS,
    FAST,
    ON_ITS_WAY,
    SLIDING,
    SLOW,
    across,
    keep_direction,
    slip_of,
)
from lcpflex.dynamics.spatial.inertia import SpatialWork
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.kinematics.spatial.rotations import Vector
from lcpflex.kinematics.spatial.vectors import added, dot, row_vector, scaled
from lcpflex.model.arrays import SLIP, STICK
from lcpflex.model.spatial import SpatialModel
from lcpflex.solvers.contact.index_sets import SMOOTH, STICKING
from lcpflex.steppers.event_driven.leaving import move_on
from lcpflex.steppers.event_driven.memory import CONE, PRESSURE, SLIDING as SLIDES, SPAN, EventSettings, copy_entry
from lcpflex.steppers.event_driven.segment import FORCE_TOLERANCE
from lcpflex.steppers.recorder import Recorder
from lcpflex.steppers.spatial.records import note_spatial_contact

__all__ = [
    "add_rates",
    "arises",
    "before_it_leaves",
    "count_impulses",
    "first_side",
    "is_vertex",
    "note_forces",
    "rises",
    "steps_behind",
    "sum_of",
    "tolerance_of",
    "turning_time",
    "used",
    "watch",
    "watched_first",
]

SUMS = 4  # of each declared contact: normal impulse, that of friction in world axes
MOVED, UPWARDS = 1e2, 1e-6  # gap tolerances by which bodies move to tell, and by which part of that a gap opens
STEPS_BEHIND = 3  # a contact that has left its feature: ever ten times as long, the first a thousandth of the usual
GRAIN = 1e-3  # of the threshold: how far below it slip may be
INCONSISTENT = (
    1e-4  # of the largest force: more that a contact misses is no rounding, nor that of drives told by differences
)
JUST_BEFORE = 1e-3  # of a sample of a step: before the end of which a force that changes its sign there has its old one
PART = 0.5  # of |gamma| / |gammadot|: the longest step


@kernel
def used(memory: Any) -> int:
    """Components of the state but for those of laws that no pair has got yet."""
    return memory.nq + len(memory.u) + 3 + SUMS * memory.seen.pairs.n_laws


@kernel
def sum_of(work: SpatialWork, memory: Any, k: int) -> int:
    """Where the sums of the declared contact of entry k begin in the state."""
    return memory.nq + len(memory.u) + 3 + SUMS * work.rows.table.law[k]


@kernel
def first_side(work: SpatialWork, memory: Any, k: int) -> float:
    """1 where side i of entry k is that of the first surface of its declared contact, else -1."""
    return side_of(memory.seen, work.rows.table.law[k], work.rows.table.body[k, 0])


@kernel
def friction_of(work: SpatialWork, memory: Any, k: int) -> Vector:
    """Friction by ``p`` on the body of the first surface of the declared contact of k, world axes; it has some."""
    side = first_side(work, memory, k)
    r = work.rows.n_joint + work.rows.n_contacts + memory.sets.tangent_of[k]
    first, second = across(work, k)
    return added(scaled(side * work.impulses.p[r], first), scaled(side * work.impulses.p[r + 1], second))


@kernel
def add_rates(work: SpatialWork, memory: Any, u: FloatArray, base: int, out: FloatArray) -> None:
    """Rates of what contact forces do and sum up to, after ``fixed_forces``."""
    sets = memory.sets
    for k in range(work.rows.n_contacts):
        at = sum_of(work, memory, k)
        out[at] += work.impulses.p[work.rows.n_joint + k]
        if sets.tangent_of[k] >= 0:
            r = work.rows.n_joint + work.rows.n_contacts + sets.tangent_of[k]
            first, second = slip_of(work, sets, k, u)
            out[base] -= work.impulses.p[r] * first + work.impulses.p[r + 1] * second
            friction = friction_of(work, memory, k)
            for i in range(3):
                out[at + 1 + i] += friction[i]


@kernel
def count_impulses(work: SpatialWork, memory: Any) -> None:
    """Add the impulses of a projection of velocities, and what those that stop slip below the threshold take.

    Contacts that begin to slide are on their way from now on.
    """
    sets, n_joint = memory.sets, work.rows.n_joint
    base = memory.nq + len(memory.u)
    for k in range(memory.n_contacts):
        at = sum_of(work, memory, k)
        memory.y[at] += work.impulses.p[n_joint + k]
        if sets.tangent_of[k] >= 0:
            r = n_joint + work.rows.n_contacts + sets.tangent_of[k]
            friction = friction_of(work, memory, k)
            for i in range(3):
                memory.y[at + 1 + i] += friction[i]
            memory.y[base] -= 0.5 * (work.impulses.p[r] * work.free.v[r] + work.impulses.p[r + 1] * work.free.v[r + 1])
        if sets.youth[k] == BEGINS:
            sets.youth[k] = SLOW


@kernel
def watch(model: Any, work: SpatialWork, memory: Any, y: FloatArray) -> None:
    """Watched functions of all maintained contacts, after ``slope`` at the same state.

    Contacts that the others forbid to keep what they do press no longer: what happens is the problem's to say.
    """
    nq = memory.nq
    q, u = y[:nq], y[nq : nq + len(memory.u)]
    sets, value, n_joint = memory.sets, memory.value, work.rows.n_joint
    memory.force = 0.0
    for k in range(work.rows.n_contacts):
        force = work.impulses.p[n_joint + k]
        value[PRESSURE, k] = force
        value[CONE, k] = math.inf
        value[SLIDES, k] = math.inf
        value[SPAN, k] = min(foot_margin(model, q, work.rows.table, k), node_margin(model, q, work.rows.table, k))
        size = abs(force)
        if work.posed.own[k] > 0.0:
            size = max(size, abs(work.posed.effect[k]) / work.posed.own[k])
        memory.force = max(memory.force, size)
        if sets.tangent_of[k] < 0:
            continue
        if sets.mode[k] == STICKING:
            r = n_joint + work.rows.n_contacts + sets.tangent_of[k]
            value[CONE, k] = work.rows.mu[k] * force - math.hypot(work.impulses.p[r], work.impulses.p[r + 1])
        elif sets.mode[k] == SLIDING:
            first, second = slip_of(work, sets, k, u)
            if sets.youth[k] == FAST:
                value[SLIDES, k] = math.hypot(first, second) - sets.slow
            else:
                t, s = across(work, k)
                kept = row_vector(sets.direction, k)
                value[SLIDES, k] = first * dot(kept, t) + second * dot(kept, s) + 2.0 * sets.slow
    for k in range(work.rows.n_contacts):
        if sets.miss[k] > INCONSISTENT * memory.force:
            value[PRESSURE, k] = min(value[PRESSURE, k], -sets.miss[k])


@kernel
def tolerance_of(settings: EventSettings, memory: Any, kind: int) -> float:
    """How far below zero a watched function may be."""
    if kind == SPAN:
        return SPAN_TOLERANCE
    if kind == SLIDES:
        return GRAIN * settings.slip_threshold
    return FORCE_TOLERANCE * memory.force


@kernel
def watched_first(memory: Any, place: int) -> int:
    """Which watched function is asked at a place of the order: feet first, where one has left forces mean nothing."""
    return SPAN if place == 0 else place - 1


@kernel
def before_it_leaves(memory: Any, low: float, high: float) -> float:
    """Share of a step at which forces are looked at, too, where a foot leaves at ``high``.

    Where a crossing leaves by the end of an edge it meets the vertex there, and the load that both share is divided by
    the distance between them: it grows beyond all bounds, of one sign before and of the other behind.
    """
    return high - JUST_BEFORE * (high - low)


@kernel
def turning_time(work: SpatialWork, memory: Any, u: FloatArray) -> float:
    """The longest step [s] over which no slip changes by more than a part of itself, after ``slope`` to slopes[0].

    What has left the threshold behind slides from now on, and its direction is kept.
    """
    sets = memory.sets
    base = memory.nq + len(memory.u)
    rates = memory.slopes[0, memory.nq : base]
    longest = math.inf
    for k in range(work.rows.n_contacts):
        if sets.mode[k] != SLIDING:
            continue
        first, second = slip_of(work, sets, k, u)
        slip = math.hypot(first, second)
        if sets.youth[k] != FAST:
            if not slip > ON_ITS_WAY * sets.slow:
                continue
            sets.youth[k] = FAST
        keep_direction(work, sets, k, first, second)
        r = work.rows.n_joint + work.rows.n_contacts + sets.tangent_of[k]
        change = math.hypot(
            row_velocity(work.rows.J, work.rows.body, r, work.rows.dof, rates) + work.rows.bias[r],
            row_velocity(work.rows.J, work.rows.body, r + 1, work.rows.dof, rates) + work.rows.bias[r + 1],
        )
        if change > 0.0:
            longest = min(longest, PART * slip / change)
    return longest


@kernel
def note_forces(
    model: Any,
    settings: EventSettings,
    q: FloatArray,
    u: FloatArray,
    work: SpatialWork,
    memory: Any,
    recorder: Recorder,
) -> None:
    """Add the touching points with the forces ``work.impulses.p`` to the instant about to be stored."""
    sets = memory.sets
    for k in range(work.rows.n_contacts):
        first, second = 0.0, 0.0
        state = STICK if sets.mode[k] == STICKING else SLIP
        if sets.mode[k] != SMOOTH:
            r = work.rows.n_joint + work.rows.n_contacts + sets.tangent_of[k]
            first, second = work.impulses.p[r], work.impulses.p[r + 1]
            slip = slip_of(work, sets, k, u)
            if math.hypot(slip[0], slip[1]) <= settings.slip_threshold:
                state = STICK
        place = contact_point(model, q, work.rows.table, k)
        note_spatial_contact(
            recorder, work.rows.table, k, place, work.impulses.p[work.rows.n_joint + k], first, second, state
        )


@kernel
def steps_behind(work: SpatialWork) -> int:
    """Steps at whose ends contacts are sought that begin where another one has left; see ``arises``."""
    return STEPS_BEHIND


@kernel
def arises(model: SpatialModel, settings: EventSettings, work: SpatialWork, memory: Any) -> bool:
    """Whether a contact that is not maintained touches at the end of the step, in ``memory.before``.

    Where a vertex leaves a face over its side, an edge on either side of it crosses that: both crossings begin at one
    place, where they are one contact, and the one that was not found there never closes.
    """
    nq = memory.nq
    q, u = memory.before[:nq], memory.before[nq : nq + len(memory.u)]
    table, seen = work.rows.table, memory.near
    count = detect(model, q, settings.gap_tolerance, seen)
    if count > len(seen.key):
        return False
    for i in range(count):
        if abs(seen.gap[i]) > settings.gap_tolerance or entry_of(table.key, memory.n_contacts, seen.key[i], 0) >= 0:
            continue
        for k in range(memory.n_contacts):  # of two bodies that rest on each other already
            if table.law[k] == seen.law[i]:
                return bool(abs(gap_rate(model, q, u, seen, i)) <= settings.velocity_threshold)
    return False


@kernel
def is_vertex(table: Any, k: int) -> bool:
    """Whether entry k is a single point on a flat face."""
    return bool(table.kind[k] == NODE_FACET or table.kind[k] == NODE_CAP)


@kernel
def rises(model: Any, settings: EventSettings, memory: Any, k: int) -> bool:
    """Whether a crossing over a face that was seen opens as it moves along its edge, which leads up from the face.

    Its row tells nothing of that, being of the material there. A vertex of a tilted face that leaves it over a side
    makes two crossings: along the edge that touches one goes on, along the other one the gap begins from 0.
    """
    nq, seen = memory.nq, memory.seen
    if seen.kind[k] != EDGE_FACET:
        return False
    largest = 0.0
    for i in range(len(memory.u)):
        largest = max(largest, abs(memory.y[nq + i]))
    if not largest > 0.0:
        return False
    moved = MOVED * settings.gap_tolerance
    move_on(model, memory, moved / largest)
    copy_entry(seen, k, memory.near, 0)
    refresh(model, memory.dipping[:nq], memory.near, 0)
    return bool(memory.near.gap[0] - seen.gap[k] > UPWARDS * moved)
