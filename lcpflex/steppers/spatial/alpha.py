"""Contacts in space under generalised-alpha: two directions of friction, and slip whose direction turns.

Friction of a contact that slides is -mu lambda_N d, d = gamma / |gamma|, with the slip gamma of the iterate at the end
of the step. A pass of Newton's method that took d as the last pass left it would multiply errors of d by r / |gamma|,
where -r d is what friction has made of gamma in the step: it would fail in the last steps before a stop. So d is that
of gamma + r d_last: friction that only turns with d is then taken at its new direction. Where friction is more than
what there is to stop, d stays that of the slip without it, as in the plane, and the problem of velocities stops it.
From the third pass on friction turns with the slip in the problem itself, for all contacts at once
(:mod:`lcpflex.dynamics.spatial.turning_slip`).

Contacts without slip have a cone in the problem of accelerations (:mod:`lcpflex.dynamics.spatial.acceleration`). The
forces of the smooth motion are kept in world axes.
"""

from __future__ import annotations

import math
from typing import Any

from lcpflex.contact.detection import detect
from lcpflex.contact.spatial.table import SpatialContactTable, side_of, with_edge
from lcpflex.dynamics.acceleration import FORCE
from lcpflex.dynamics.contact_problem import list_tangents
from lcpflex.dynamics.delassus import row_velocity
from lcpflex.dynamics.mechanics import fill_contact_rows, solve_vector
from lcpflex.dynamics.spatial.acceleration import SLIDING, across, slip_of
from lcpflex.dynamics.spatial.inertia import SpatialWork
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.kinematics.spatial.vectors import dot
from lcpflex.model.spatial import N_RIGID
from lcpflex.solvers.contact.index_sets import SMOOTH as FRICTIONLESS, STICKING
from lcpflex.solvers.contact.recollection import turn_over
from lcpflex.steppers.event_driven.memory import copy_entry
from lcpflex.steppers.generalized_alpha.memory import POSITION, SMOOTH, hold, match, note_overrun
from lcpflex.steppers.generalized_alpha.smooth import add_row
from lcpflex.steppers.island_problems import solve_island, solve_islands
from lcpflex.steppers.recorded_contacts import INSIDE
from lcpflex.steppers.recorder import Recorder
from lcpflex.steppers.spatial.island_problems import keep_island
from lcpflex.steppers.spatial.records import friction_vector
from lcpflex.steppers.spatial.sets import solve_on_sets
from lcpflex.steppers.status import RunStatus

__all__ = [
    "gather_resting",
    "note_resting",
    "pose_modes",
    "resting_load",
    "same_node",
    "slips_anew",
    "solve_problems",
    "speed_left",
]

LEFT = 1e-6  # of the terms of a free velocity: what answers that count as solved may leave of it
TURNED = 2  # passes after which friction turns in the problem itself (:mod:`lcpflex.dynamics.spatial.turning_slip`)
FROZEN = 5  # passes after which the direction of slip that comes to a stop is left as it is


@kernel
def gather_resting(model: Any, work: SpatialWork, scheme: Any) -> int:
    """Contacts closed at rest at the start of the step, with their modes; returns how many pairs are closed."""
    q, u = scheme.q, scheme.u
    slow = max(scheme.velocity_threshold, 2.0 * scheme.left)  # open contacts have as much from the same answer
    scheme.n_found = 0
    work.rows.table.faces.kept.used = 1
    found = detect(model, q, scheme.gap_tolerance, work.rows.table)
    if found == 0 or found > len(work.rows.table.key):
        return found
    n_joint = len(work.scratch.residual)
    n_tangent = fill_contact_rows(model, q, found, n_joint, work.rows)
    kept, j = 0, 0
    for k in range(found):
        frictional = j < n_tangent and work.rows.tangent[j] == k
        if abs(row_velocity(work.rows.J, work.rows.body, n_joint + k, work.rows.dof, u)) <= slow:
            mode = FRICTIONLESS
            if frictional:
                r = n_joint + found + j
                first = row_velocity(work.rows.J, work.rows.body, r, work.rows.dof, u)
                second = row_velocity(work.rows.J, work.rows.body, r + 1, work.rows.dof, u)
                mode = STICKING if math.hypot(first, second) <= slow else SLIDING
            copy_entry(work.rows.table, k, work.rows.table, kept)
            scheme.sets.mode[kept] = mode
            kept += 1
        if frictional:
            j += 2
    scheme.n_found = kept
    return found


@kernel
def pose_modes(model: Any, alpha_c: float, work: SpatialWork, scheme: Any) -> int:
    """Directions of the contacts that slide, for the problems just laid; 0: they begin from no forces.

    alpha_c: dv/dw of the velocity at the end of the step [s].
    """
    sets, push, turning = scheme.sets, scheme.momentum, scheme.sets.turning
    sets.level = FORCE
    n_joint, n = work.rows.n_joint, work.rows.n_contacts
    list_tangents(work.rows, sets.tangent_of)
    again = scheme.turn > 0
    turned = 1 if turning.counts == 1 and again else 0
    turning.counts = 1 if scheme.turn >= TURNED else 0
    if again:
        answer_friction(model, work, push)
    for k in range(n):
        by_force = turned == 1 and turning.yields[k] >= 0.0 and work.impulses.p[n_joint + k] > 0.0
        turning.yields[k] = -1.0
        if sets.mode[k] != SLIDING:
            continue
        first, second = slip_of(work, sets, k, scheme.v_new)
        ahead = first * sets.along[k, 0] + second * sets.along[k, 1]
        if scheme.turn >= FROZEN and ahead <= 0.0:
            continue  # it stops in this step, in which direction the problem of velocities tells
        if by_force:
            r = n_joint + n + sets.tangent_of[k]
            first, second = -work.impulses.p[r], -work.impulses.p[r + 1]
        elif again:
            pushed = slip_of(work, sets, k, push)
            taken = -alpha_c * (sets.along[k, 0] * pushed[0] + sets.along[k, 1] * pushed[1])
            if taken > 0.0:
                first += taken * sets.along[k, 0]
                second += taken * sets.along[k, 1]
        else:
            before = slip_of(work, sets, k, scheme.u)
            if not first * before[0] + second * before[1] > 0.0:
                first, second = before
        size = math.hypot(first, second)
        if size > 0.0:
            sets.along[k, 0], sets.along[k, 1] = first / size, second / size
        if turning.counts == 1 and ahead > 0.0:
            let_turn(work, scheme, k, alpha_c)
    return 0


@kernel
def answer_friction(model: Any, work: SpatialWork, out: FloatArray) -> None:
    """The acceleration that the friction of the last pass makes."""
    first = work.rows.n_joint + work.rows.n_contacts
    for i in range(len(out)):
        out[i] = 0.0
    for r in range(first, first + work.rows.n_tangents):
        add_row(work, r, work.impulses.p[r], out)
    solve_vector(model, work, out)


@kernel
def gives_way(work: SpatialWork, r: int) -> bool:
    """Whether a body of row r has modes: contacts of rigid ones share loads in many ways, by the operator as it is."""
    found = False
    for side in range(2):
        b = work.rows.body[r, side]
        found = found or (b >= 0 and work.rows.dof[b + 1] - work.rows.dof[b] > N_RIGID)
    return found


@kernel
def let_turn(work: SpatialWork, scheme: Any, k: int, alpha_c: float) -> None:
    """Let friction of contact k, which slides, turn with its slip at the end of the step, where a body gives way."""
    sets, turning = scheme.sets, scheme.sets.turning
    r = work.rows.n_joint + work.rows.n_contacts + sets.tangent_of[k]
    friction = work.rows.mu[k] * work.impulses.p[work.rows.n_joint + k]
    if not friction > 0.0 or not alpha_c > 0.0 or not gives_way(work, r):
        return
    first, second = slip_of(work, sets, k, scheme.v_new)
    x, y = -sets.along[k, 1], sets.along[k, 0]
    now = slip_of(work, sets, k, scheme.w_new)
    speed = max(first * sets.along[k, 0] + second * sets.along[k, 1], 0.0)
    turning.yields[k] = speed / (alpha_c * friction)
    turning.missing[k] = (x * first + y * second) / alpha_c
    turning.missing[k] -= x * (now[0] + work.rows.bias[r]) + y * (now[1] + work.rows.bias[r + 1])


@kernel
def slide_on(work: SpatialWork, scheme: Any) -> None:
    """Modes of the contacts of the problem of velocities: those that the smooth motion leaves sliding go on so.

    Their whole impulse is in the cone at the direction of the smooth friction, which is then met without another one:
    the direction of the velocity after the step would make friction that turns of order 1. Not in islands where a
    contact does not rest: an impact may turn the slip of all.
    """
    sets, islands = scheme.sets, work.posed.islands
    sets.level = FORCE
    for k in range(work.rows.n_contacts):
        sets.tangent_of[k] = work.posed.tangent_of[k]
        sets.mode[k] = STICKING if work.posed.tangent_of[k] >= 0 else FRICTIONLESS
    for i in range(islands.count):
        rests = True
        for c in range(islands.start[i], islands.start[i + 1]):
            rests = rests and scheme.matched[islands.contact[c]] >= 0
        if not rests:
            continue
        for c in range(islands.start[i], islands.start[i + 1]):
            k = islands.contact[c]
            m = scheme.matched[k]
            if sets.tangent_of[k] < 0 or scheme.resting.mode[m] != SLIDING:
                continue
            first, second = slip_of(work, sets, k, scheme.v_new)
            x, y = resting_friction(work, scheme, k)
            size = math.hypot(x, y)
            if size > 0.0 and -(first * x + second * y) > scheme.velocity_threshold * size:
                sets.mode[k] = SLIDING
                sets.along[k, 0], sets.along[k, 1] = -x / size, -y / size


@kernel
def resting_friction(work: SpatialWork, scheme: Any, k: int) -> tuple[float, float]:
    """Friction of the smooth motion on contact k, which rested, in its tangents [N]."""
    load, i = scheme.resting.load, scheme.matched[k]
    t, s = across(work, k)
    friction = (load[i, 1], load[i, 2], load[i, 3])
    return dot(friction, t), dot(friction, s)


@kernel
def slides(work: SpatialWork, scheme: Any, i: int) -> bool:
    """Whether a contact of island i slides."""
    islands, found = work.posed.islands, False
    for c in range(islands.start[i], islands.start[i + 1]):
        found = found or scheme.sets.mode[islands.contact[c]] == SLIDING
    return found


@kernel
def rest_on(work: SpatialWork, scheme: Any, i: int) -> None:
    """Forces ``p`` of island i as they were in the last smooth motion, in the cone: where the solver begins."""
    islands = work.posed.islands
    for c in range(islands.start[i], islands.start[i + 1]):
        k = islands.contact[c]
        m, j = scheme.matched[k], work.posed.tangent_of[k]
        force = float(scheme.resting.load[m, 0]) if m >= 0 else 0.0
        work.impulses.p[work.rows.n_joint + k] = force
        if j >= 0:
            first, second = resting_friction(work, scheme, k) if m >= 0 else (0.0, 0.0)
            size, most = math.hypot(first, second), work.rows.mu[k] * force
            share = most / size if size > most else 1.0
            r = work.rows.n_joint + work.rows.n_contacts + j
            work.impulses.p[r], work.impulses.p[r + 1] = share * first, share * second


@kernel
def solve_problems(work: SpatialWork, scheme: Any, t: float, last: bool, recorder: Recorder) -> int:
    """The problems laid that are not solved yet; but of positions and strikes with known slip where one slides."""
    smooth = scheme.phase <= SMOOTH  # or begins anew
    if not smooth:
        scheme.sets.turning.counts = 0
    if scheme.phase == POSITION or scheme.order.goes_on == 1:
        return solve_islands(work, t, scheme.tolerance, scheme.warm == 1, last, recorder)
    islands, warm = work.posed.islands, scheme.warm == 1
    if last and islands.next == 0:
        work.impulses.remembered.n_next = 0
        slide_on(work, scheme)
    work.impulses.unsolved_large = 0
    if smooth and scheme.turn == 0:
        match(work.rows.table, work.rows.n_contacts, scheme.resting, scheme.matched)
    while islands.next < islands.count:
        i = islands.next
        if slides(work, scheme, i):
            status = solve_on_sets(work, scheme.sets, i, scheme.tolerance, warm, recorder)
            for c in range(islands.start[i + 1] - islands.start[i]):
                work.impulses.solver.group.slip[c] = 0.0
        else:
            if smooth and scheme.turn == 0:
                rest_on(work, scheme, i)
            work.impulses.solver.begun = 1 if smooth else 0  # of later passes from the one before
            status = solve_island(work, i, scheme.tolerance, warm, recorder)
            work.impulses.solver.begun = 0
        if status != RunStatus.DONE:
            return status
        if last:
            keep_island(work, i)
        islands.next += 1
    if last:
        turn_over(work.impulses.remembered)
    return RunStatus.DONE


@kernel
def note_resting(work: SpatialWork, scheme: Any, at: Any, recorder: Recorder) -> None:
    """Hold the contacts that carry with their forces, and add these to ``at``."""
    n_joint, n, resting = work.rows.n_joint, work.rows.n_contacts, scheme.resting
    for k in range(n):
        normal = work.impulses.p[n_joint + k]
        if normal <= 0.0:
            continue
        law = work.rows.table.law[k]
        add_row(work, n_joint + k, normal, at.normal)
        hold(work.rows.table, k, normal, scheme.sets.mode[k], resting)
        at.contact[law, 0] += normal
        if scheme.sets.tangent_of[k] >= 0:
            r = n_joint + n + scheme.sets.tangent_of[k]
            add_row(work, r, work.impulses.p[r], at.friction)
            add_row(work, r + 1, work.impulses.p[r + 1], at.friction)
            friction = friction_vector(work.rows.table, k, work.impulses.p[r], work.impulses.p[r + 1])
            side = side_of(recorder.table, law, work.rows.table.body[k, 0])
            for i in range(3):
                resting.load[resting.count - 1, 1 + i] = friction[i]
                at.contact[law, 1 + i] += side * friction[i]


@kernel
def resting_load(work: SpatialWork, scheme: Any, k: int, r: int) -> float:
    """Force of the smooth motion on row r, of contact k [N]; 0 where it did not rest."""
    i = scheme.matched[k]
    if i < 0:
        return 0.0
    first = work.rows.n_joint + work.rows.n_contacts
    if r < first:
        return float(scheme.resting.load[i, 0])
    friction = resting_friction(work, scheme, k)
    return friction[0] if work.posed.tangent_of[k] == r - first else friction[1]


@kernel
def same_node(table: SpatialContactTable, k: int, other: SpatialContactTable, i: int) -> bool:
    """Whether entry k of a table is of the same node, edge or rim as entry i of another one, whatever they touch."""
    if table.node[k] != other.node[i]:
        return False
    crosses, crossed = with_edge(table, k), with_edge(other, i)
    if not crosses and not crossed:
        return True
    return bool(crosses == crossed and table.point[k, 1] == other.point[i, 1])


@kernel
def speed_left(model: Any, work: SpatialWork, scheme: Any) -> float:
    """Speed of contacts that the velocity problem was to stop, at the velocity ``work.free.u`` [m/s].

    Solvers leave a part of the free velocities, of which those of stiff modes may be far larger than all others. So
    contacts of a held flexible body would not rest at 7e-9 m/s, fall out of the smooth motion, and let go of the body.
    """
    n, first, contacts, u = work.rows.n_contacts, work.rows.n_joint + work.rows.n_contacts, model.contacts, work.free.u
    left = 0.0
    for k in range(n):
        r, j = work.rows.n_joint + k, work.posed.tangent_of[k]
        law, rested = work.rows.table.law[k], scheme.matched[k] >= 0
        if not work.impulses.p[r] > 0.0:
            continue
        if rested or contacts.restitution[law] == 0.0:
            left = max(
                left,
                min(abs(row_velocity(work.rows.J, work.rows.body, r, work.rows.dof, u)), LEFT * work.free.terms[k]),
            )
        if j < 0 or not (rested or contacts.tangential_restitution[law] == 0.0):
            continue
        s = first + j
        if math.hypot(work.impulses.p[s], work.impulses.p[s + 1]) < INSIDE * work.rows.mu[k] * work.impulses.p[r]:
            slip = math.hypot(
                row_velocity(work.rows.J, work.rows.body, s, work.rows.dof, u),
                row_velocity(work.rows.J, work.rows.body, s + 1, work.rows.dof, u),
            )
            left = max(left, min(slip, LEFT * (work.free.terms[n + j] + work.free.terms[n + j + 1])))
    return left


@kernel
def slips_anew(work: SpatialWork, scheme: Any) -> bool:
    """Whether a contact that slid has come to rest, or has turned against its slip, at the velocity ``work.free.u``."""
    found = False
    for k in range(work.rows.n_contacts):
        i, j = scheme.matched[k], work.posed.tangent_of[k]
        if i < 0 or j < 0 or scheme.resting.mode[i] == STICKING:
            continue
        r = work.rows.n_joint + work.rows.n_contacts + j
        first = row_velocity(work.rows.J, work.rows.body, r, work.rows.dof, work.free.u)
        second = row_velocity(work.rows.J, work.rows.body, r + 1, work.rows.dof, work.free.u)
        x, y = resting_friction(work, scheme, k)
        ended = math.hypot(first, second) <= max(scheme.velocity_threshold, 2.0 * scheme.left)
        if ended or first * x + second * y > 0.0:
            found = True
            a = row_velocity(work.rows.J, work.rows.body, r, work.rows.dof, scheme.v_new)
            b = row_velocity(work.rows.J, work.rows.body, r + 1, work.rows.dof, scheme.v_new)
            c = row_velocity(work.rows.J, work.rows.body, r, work.rows.dof, scheme.u)
            d = row_velocity(work.rows.J, work.rows.body, r + 1, work.rows.dof, scheme.u)
            note_overrun(scheme, math.hypot(a - first, b - second), math.hypot(a - c, b - d))
    return found
