"""The contact problems of a step, one for each island, solved one after the other.

Where one is not solved, the loop returns with it in ``posed.problem``; once an answer waits in ``impulses.solver``, it
goes on there. Islands of many contacts are solved in the velocities of their bodies; where that does not reach the
tolerance within its budget, a step goes on with the best point unless it is to be an error.
"""

from __future__ import annotations

from lcpflex.dynamics.contact_problem import fits, pose_island, take_forces
from lcpflex.dynamics.large_island import (
    begin_with_remembered,
    count_forces,
    describe_island,
    is_free,
    is_large,
    restore_free,
)
from lcpflex.dynamics.workspace import Workspace
from lcpflex.jit.kernel import kernel, late_kernel
from lcpflex.jit.leaf import in_space
from lcpflex.solvers.contact.algebra import PLANAR
from lcpflex.solvers.contact.compiled import solve_contacts
from lcpflex.solvers.contact.judging import lags
from lcpflex.solvers.contact.large.least import least_impulses
from lcpflex.solvers.contact.large.solving import ROOM, solve_large, take_impulses
from lcpflex.solvers.contact.least_forces import least_forces
from lcpflex.solvers.contact.operators.fronts import lacks_room
from lcpflex.solvers.contact.recollection import recall_basis, remember_basis, remember_forces, turn_over
from lcpflex.solvers.status import SOLVED
from lcpflex.steppers.doubtful import keep_doubtful
from lcpflex.steppers.recorder import Recorder, note_certificate, note_lagging, note_large
from lcpflex.steppers.status import RunStatus

__all__ = ["shorten_forces", "solve_island", "solve_islands", "tell_island"]

LAST_WORD = 128  # contacts of the largest island that is posed densely where another way has failed


@in_space("lcpflex.steppers.spatial.island_problems")
@kernel
def solve_island(work: Workspace, i: int, tolerance: float, warm: bool, recorder: Recorder) -> int:
    """Forces ``impulses.p`` of the contacts of island i; DONE, GROW, or SOLVER_FAILED with the reason in ``number``.

    As one dense problem; warm: from what contacts did in the last step.
    """
    impulses = work.impulses
    if not fits(work, i):
        return RunStatus.GROW
    pose_island(work, i, PLANAR)
    if warm:
        recall_basis(work.posed.problem, impulses.solver, impulses.remembered)
    impulses.number = solve_contacts(work.posed.problem, impulses.solver)
    if impulses.number != 0 or not impulses.solver.residual <= tolerance:
        return RunStatus.SOLVER_FAILED
    note_certificate(work, recorder)
    take_forces(work)
    return RunStatus.DONE


@kernel
def solve_dense_island(work: Workspace, i: int, tolerance: float, warm: bool, last: bool, recorder: Recorder) -> int:
    """:func:`solve_island`; where it is the ``last`` problem of a step, the next one begins from it."""
    status = solve_island(work, i, tolerance, warm, recorder)
    if status == RunStatus.DONE and last:
        remember_basis(work.posed.problem, work.impulses.solver, work.impulses.remembered)
    return status


@kernel
def tell_island(work: Workspace, i: int) -> None:
    """Island i was solved in the velocities of its bodies; in a run that keeps contact problems, it is told of it."""


@late_kernel
def solve_large_island(work: Workspace, i: int, tolerance: float, last: bool, recorder: Recorder) -> int:
    """Impulses of the contacts of island i to ``impulses.p``; DONE, GROW, or SOLVER_FAILED where that is to be told.

    GROW also where a start is to be sought, see :mod:`lcpflex.steppers.cold_islands`.

    Where they are not too many, and not found in this way, the dense problem has the last word. What is right as a
    whole, but not by the own load of each contact, will do where nothing is better, and is noted. last: as of
    :func:`solve_islands`.
    """
    large, solver = work.posed.large, work.impulses.large_solver
    work.impulses.largest = max(work.impulses.largest, work.posed.islands.start[i + 1] - work.posed.islands.start[i])
    if len(work.rows.white) == 0 or lacks_room(solver.op.factor):  # the latter, where sunk contacts were to be lifted
        return RunStatus.GROW
    describe_island(work, i)
    cold = work.impulses.has_start == 0 and begin_with_remembered(work, last) == 0 and last
    solver.judged.tolerance = tolerance
    if work.posed.lifted == 1:
        count_forces(work)
    status = solve_large(large, solver, PLANAR)
    if work.posed.lifted == 1:
        restore_free(work)
    if status == ROOM:
        return RunStatus.GROW
    lagging = lags(solver.judged)
    if status != SOLVED and large.n_contacts <= LAST_WORD:
        warm = last
        dense = solve_dense_island(work, i, tolerance, warm, last, recorder)
        if dense != RunStatus.SOLVER_FAILED or not lagging:
            return dense
    if lagging:
        note_lagging(work, recorder)
    elif status != SOLVED:
        if cold and large.n_joints == 0:
            work.impulses.wants_start = 1
            return RunStatus.GROW
        if work.impulses.strict_large == 1 or work.posed.on_sets == 1:
            work.impulses.unsolved_large = 1
            return RunStatus.SOLVER_FAILED
        work.impulses.unsolved += 1
    work.impulses.has_start = 0
    note_large(work, status != SOLVED and not lagging, recorder)
    tell_island(work, i)
    if last:
        remember_forces(large, work.rows.table.key, work.rows.n_joint, work.impulses.remembered)
    return RunStatus.DONE


@in_space("lcpflex.steppers.spatial.island_problems")
@kernel
def solve_islands(work: Workspace, t: float, tolerance: float, warm: bool, last: bool, recorder: Recorder) -> int:
    """The problems laid that are not solved yet; DONE, or as :func:`solve_island`.

    last: they are the last ones of the step from t [s]. The next one begins from them, and those that may have several
    solutions are kept.
    """
    islands = work.posed.islands
    if islands.next == 0:
        work.impulses.remembered.n_next = 0
    work.impulses.unsolved_large = 0
    while islands.next < islands.count:
        if is_large(work, islands.next) and is_free(work, islands.next):
            status = solve_large_island(work, islands.next, tolerance, last, recorder)
        else:
            status = solve_dense_island(work, islands.next, tolerance, warm, last, recorder)
            if status == RunStatus.DONE and last:
                keep_doubtful(work, t)
        if status != RunStatus.DONE:
            return status
        islands.next += 1
    if last:
        turn_over(work.impulses.remembered)
    return RunStatus.DONE


@in_space("lcpflex.steppers.spatial.island_problems")
@kernel
def shorten_forces(work: Workspace) -> bool:
    """Of all contact forces in ``work.impulses.p`` with the same effect the least ones, once a step.

    False where ``work.impulses.large_solver.apart`` needs more room first: the next call goes on with that island.
    """
    islands = work.posed.islands
    while islands.shortened < islands.count:
        if is_large(work, islands.shortened):
            if not shorten_large(work, islands.shortened):
                return False
        elif islands.start[islands.shortened + 1] - islands.start[islands.shortened] > 1:
            shorten_dense(work, islands.shortened)
        islands.shortened += 1
    return True


@late_kernel
def shorten_dense(work: Workspace, i: int) -> None:
    """The same of island i, of several contacts, as one dense problem."""
    islands, p, multipliers = work.posed.islands, work.impulses.p, work.scratch.multipliers
    if islands.count > 1:
        pose_island(work, i, PLANAR)
    problem, part, n_joint = work.posed.problem, work.posed.part, work.rows.n_joint
    m = problem.n_contacts + problem.n_tangents
    for r in range(m):
        multipliers[r] = p[n_joint + part[r]]
    least_forces(problem, work.impulses.solver, multipliers)
    for r in range(m):
        p[n_joint + part[r]] = multipliers[r]


@late_kernel
def shorten_large(work: Workspace, i: int) -> bool:
    """The same of island i in the velocities of its bodies, not solved again; what was not solved stays as it is.

    The residual that the next step looks back to stays. False where there is no room.
    """
    solver, room = work.impulses.large_solver, True
    judged = solver.judged
    if len(work.rows.white) > 0:
        strict, residual = judged.strict, judged.residual
        describe_island(work, i)
        if take_impulses(work.posed.large, solver, PLANAR):
            room = least_impulses(work.posed.large, solver) != ROOM
        judged.strict, judged.residual = strict, residual
    return room
