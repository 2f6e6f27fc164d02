"""The contact problems of a step in space, one for each island, solved one after the other.

Without joints in the velocities of its bodies, by sweeps; with joints, or by a solver of the user's, as one dense
problem. Of many contacts, with joints or where sweeps crawl, by Newton's method in the velocities of bodies
(:mod:`lcpflex.solvers.contact.large`).
"""

from __future__ import annotations

import math

from lcpflex.dynamics.contact_problem import fits, pose_island
from lcpflex.dynamics.large_island import describe_island as describe_bodies, is_large
from lcpflex.dynamics.spatial.cone_sweeps import judge_island, sweep_island
from lcpflex.dynamics.spatial.contact_blocks import is_rough, is_wide, wants_white
from lcpflex.dynamics.spatial.contact_problem import describe_island, give_forces, has_joints, take_forces
from lcpflex.dynamics.spatial.held_islands import GOES_ON, hold_island, moves, way_of_motion
from lcpflex.dynamics.spatial.inertia import SpatialWork
from lcpflex.dynamics.spatial.least_cones import shorten_island
from lcpflex.dynamics.spatial.mechanics import whiten_late
from lcpflex.dynamics.spatial.shared_loads import judge_forces, put_forces, share_loads, shares_in_joints
from lcpflex.jit.kernel import kernel, late_kernel
from lcpflex.solvers.contact.algebra import IN_SPACE
from lcpflex.solvers.contact.cones.dense import FIRST_SWEEPS, solve_cones, tell
from lcpflex.solvers.contact.cones.memory import POSED
from lcpflex.solvers.contact.cones.recollection import keep_force, known_force
from lcpflex.solvers.contact.judging import is_good, lags
from lcpflex.solvers.contact.large.solving import ROOM, solve_large as solve_many
from lcpflex.solvers.contact.memory import NOTHING_KNOWN
from lcpflex.solvers.contact.operators.fronts import lacks_room
from lcpflex.solvers.contact.recollection import place_of, turn_over
from lcpflex.solvers.contact.sweeping import is_settled
from lcpflex.solvers.status import SOLVED
from lcpflex.steppers.island_problems import tell_island
from lcpflex.steppers.recorder import Recorder, note_certificate
from lcpflex.steppers.spatial.wide_islands import exchange_normals, lacks_places
from lcpflex.steppers.status import RunStatus

__all__ = ["shorten_forces", "solve_island", "solve_islands"]

LAST_WORD = 128  # contacts of the largest island that is posed densely where another way has failed


@kernel
def begin_island(work: SpatialWork, i: int, warm: bool) -> None:
    """Where the forces ``work.impulses.p`` of island i begin: from the last step, from none, or where they are."""
    memory, islands = work.impulses.solver, work.posed.islands
    table, known, p = work.rows.table, work.impulses.remembered, work.impulses.p
    first, guess = islands.start[i], 0
    memory.sweeping.polished = 0
    if memory.begun == 1:
        memory.begun = 0
        for c in range(islands.start[i + 1] - first):
            memory.group.slip[c] = 0.0
        return
    for c in range(islands.start[i + 1] - first):
        k = islands.contact[first + c]
        place = place_of(known, table.key[k], guess) if warm else -1
        f, f1, f2, slip = known_force(known, place, table.normal, table.tangent, k, work.rows.mu[k])
        if place >= 0:
            guess = place + 1 if place + 1 < known.n else 0
            memory.sweeping.polished = max(memory.sweeping.polished, known.polished[known.now, place])
        r, j = work.rows.n_joint + k, work.posed.tangent_of[k]
        p[r] = f
        if j >= 0:
            s = work.rows.n_joint + work.rows.n_contacts + j
            p[s], p[s + 1] = f1, f2
        memory.group.slip[c] = slip


@kernel
def keep_island(work: SpatialWork, i: int) -> None:
    """Add the contacts of the island just solved to those that the next step begins from."""
    memory, islands = work.impulses.solver, work.posed.islands
    table, known, p = work.rows.table, work.impulses.remembered, work.impulses.p
    first = islands.start[i]
    n = islands.start[i + 1] - first
    for c in range(n):
        k = islands.contact[first + c]
        r, j = work.rows.n_joint + k, work.posed.tangent_of[k]
        f1, f2 = 0.0, 0.0
        if j >= 0:
            s = work.rows.n_joint + work.rows.n_contacts + j
            f1, f2 = p[s], p[s + 1]
        known.carried[1 - known.now, known.n_next + c] = 1 if known.before[k] > 0.0 else 0
        known.polished[1 - known.now, known.n_next + c] = memory.sweeping.polished
        keep_force(
            known, known.n_next + c, table.key[k], table.normal, table.tangent, k, p[r], f1, f2, memory.group.slip[c]
        )
    known.n_next += n


@kernel
def pose_begun(work: SpatialWork, i: int) -> None:
    """``posed.problem`` of island i, and in ``impulses.solver`` the forces ``impulses.p`` to begin from."""
    pose_island(work, i, IN_SPACE)
    give_forces(work)


@late_kernel
def solve_posed(work: SpatialWork, i: int, tolerance: float) -> int:
    """Island i as one dense problem, from the forces ``work.impulses.p``: DONE, GROW or SOLVER_FAILED."""
    memory = work.impulses.solver
    if not fits(work, i):
        return RunStatus.GROW
    if memory.known == NOTHING_KNOWN:
        pose_begun(work, i)
    else:  # forces wait for the problem posed
        pose_island(work, i, IN_SPACE)
    work.impulses.number = solve_cones(work.posed.problem, memory)
    if work.impulses.number != 0 or not memory.residual <= tolerance:
        return RunStatus.SOLVER_FAILED
    take_forces(work)
    return RunStatus.DONE


@kernel
def solve_in_bodies(work: SpatialWork, i: int, alone: bool) -> bool:
    """Island i in the velocities of its bodies, from the forces ``work.impulses.p``; whether they are good enough.

    alone: it is wide, and has normal forces alone.
    """
    memory = work.impulses.solver
    describe_island(work, i)
    memory.size, memory.sweeping.iterations = 3 * memory.group.n, 0
    judge_island(work)
    if alone and not (is_good(memory.judged) and is_settled(memory.judged, memory.sweeping)):
        exchange_normals(work, i)
        judge_island(work)
    good = sweep_island(work, FIRST_SWEEPS, False)
    tell(memory)
    return good


@kernel
def begin_joints(work: SpatialWork, warm: bool) -> None:
    """Forces of joint rows to begin from: those of the last step, or none."""
    for r in range(work.rows.n_joint):
        work.impulses.p[r] = work.impulses.recalled[r] if warm else 0.0


@late_kernel
def solve_large(work: SpatialWork, i: int, warm: bool) -> int:
    """Island i, of many contacts, by Newton's method from the forces ``p``: DONE, GROW or SOLVER_FAILED."""
    large, memory = work.impulses.large_solver, work.impulses.solver
    n = work.posed.islands.start[i + 1] - work.posed.islands.start[i]
    work.impulses.largest = max(work.impulses.largest, n)
    if len(work.rows.white) == 0 or lacks_room(large.op.factor):  # the latter, where sunk contacts were to be lifted
        return RunStatus.GROW
    if not wants_white(work, i):
        whiten_late(work, i)
    describe_bodies(work, i)
    begin_joints(work, warm)
    large.judged.tolerance = memory.judged.tolerance
    status = solve_many(work.posed.large, large, IN_SPACE)
    if status == ROOM:
        return RunStatus.GROW
    memory.size, made = 3 * n, large.search.sweeps + large.newton.factors
    if has_joints(work, i):
        memory.residual, memory.strict = large.judged.residual, large.judged.strict
        memory.iterations = 1.0 * made
        return RunStatus.DONE if status == SOLVED else RunStatus.SOLVER_FAILED
    memory.sweeping.iterations += made
    describe_island(work, i)
    judge_island(work)
    if lags(memory.judged):
        sweep_island(work, FIRST_SWEEPS, False)
    tell(memory)
    enough = is_good(memory.judged) or (n > LAST_WORD and lags(memory.judged))
    return RunStatus.DONE if enough else RunStatus.SOLVER_FAILED


@kernel
def go_on(work: SpatialWork, i: int, solved: bool, recorder: Recorder) -> int:
    """Note how island i was solved; an island of many contacts that was not is an error, or is gone on with."""
    if not solved:
        judged = work.impulses.large_solver.judged
        work.posed.large.n_contacts = work.posed.islands.start[i + 1] - work.posed.islands.start[i]
        judged.residual, judged.strict = work.impulses.solver.residual, work.impulses.solver.strict
        if work.impulses.strict_large == 1:
            work.impulses.unsolved_large = 1
            return RunStatus.SOLVER_FAILED
        work.impulses.unsolved += 1
        note_unsolved(work, recorder)
    tell_island(work, i)
    note_certificate(work, recorder)
    return RunStatus.DONE


@kernel
def note_unsolved(work: SpatialWork, recorder: Recorder) -> None:
    """Count the island that was not solved, once for its step."""
    counts, memory = recorder.counts, work.impulses.solver
    if work.impulses.unsolved == 1:
        counts.unsolved += 1.0
    counts.unsolved_islands += 1.0
    counts.worst_unsolved = max(counts.worst_unsolved, memory.residual)
    counts.worst_unsolved_strict = max(counts.worst_unsolved_strict, memory.strict)
    counts.typical_unsolved += math.log(max(memory.strict, 1e-300))


@kernel
def settle_shares(work: SpatialWork, i: int, tolerance: float, posed: bool, resting: bool) -> None:
    """Of several solutions of island i, which is solved, the one at rest, or that of forces shared by all contacts.

    resting: its contacts were at rest, whatever is remembered.
    """
    if not moves(work, i, posed):
        return
    way = way_of_motion(work, i, posed, resting) if work.posed.shifted == 0 else GOES_ON
    if way != GOES_ON and hold_island(work, i, posed, way):
        again = solve_posed(work, i, tolerance) == RunStatus.DONE if posed else solve_in_bodies(work, i, False)
        if not again:
            put_forces(work, i, True)
            judge_forces(work, posed, False)
    share_loads(work, i, posed)


@kernel
def solve_island(work: SpatialWork, i: int, tolerance: float, warm: bool, recorder: Recorder) -> int:
    """Forces ``impulses.p`` of the contacts of island i; DONE, GROW, or SOLVER_FAILED with the reason in ``number``.

    warm: from what contacts did in the last step.
    """
    memory, islands = work.impulses.solver, work.posed.islands
    n = islands.start[i + 1] - islands.start[i]
    memory.judged.tolerance = tolerance
    resting = memory.begun == 1
    if memory.known == NOTHING_KNOWN:
        begin_island(work, i, warm)
        if memory.method != POSED and work.posed.lifted == 0:
            rough = is_rough(work, i)
            plain = work.posed.on_sets == 0 and work.posed.shifted == 0
            held, wide = has_joints(work, i), plain and is_wide(work, i, rough)
            if wide and not held:
                if not rough and lacks_places(work, n):
                    return RunStatus.GROW
                status = solve_posed(work, i, tolerance) if rough else RunStatus.SOLVER_FAILED
                if status != RunStatus.SOLVER_FAILED:
                    return end_posed(work, i, tolerance, status, resting, recorder)
            if not held and solve_in_bodies(work, i, wide and not rough):
                settle_shares(work, i, tolerance, False, resting)
                return go_on(work, i, True, recorder)
            if is_large(work, i) and not shares_in_joints(work, i):
                status = solve_large(work, i, warm)
                if status == RunStatus.GROW:
                    return status
                if status == RunStatus.DONE or n > LAST_WORD:
                    return go_on(work, i, status == RunStatus.DONE, recorder)
    return end_posed(work, i, tolerance, solve_posed(work, i, tolerance), resting, recorder)


@kernel
def end_posed(work: SpatialWork, i: int, tolerance: float, status: int, resting: bool, recorder: Recorder) -> int:
    """Of several solutions of the island posed the one that is wanted, if it was solved; the status as it was."""
    if status == RunStatus.DONE:
        if work.impulses.solver.method != POSED and work.posed.lifted == 0:
            settle_shares(work, i, tolerance, True, resting)
        note_certificate(work, recorder)
    return status


@kernel
def solve_islands(work: SpatialWork, t: float, tolerance: float, warm: bool, last: bool, recorder: Recorder) -> int:
    """The problems laid that are not solved yet; DONE, or as :func:`solve_island`.

    last: they are the last ones of the step from t [s]: the next one begins from them.
    """
    islands = work.posed.islands
    if islands.next == 0:
        work.impulses.remembered.n_next = 0
    work.impulses.unsolved_large = 0
    while islands.next < islands.count:
        status = solve_island(work, islands.next, tolerance, warm, recorder)
        if status != RunStatus.DONE:
            return status
        if last:
            keep_island(work, islands.next)
        islands.next += 1
    if last:
        turn_over(work.impulses.remembered)
    return RunStatus.DONE


@kernel
def shorten_forces(work: SpatialWork) -> bool:
    """Of all contact forces in ``work.impulses.p`` with the same effect the least ones, once a step.

    Of islands without joints in which nothing slips; see :func:`lcpflex.dynamics.spatial.least_cones.shorten_island`.
    """
    islands = work.posed.islands
    while islands.shortened < islands.count:
        i = islands.shortened
        if islands.start[i + 1] - islands.start[i] > 1 and not has_joints(work, i):
            shorten_island(work, i)
        islands.shortened += 1
    return True
