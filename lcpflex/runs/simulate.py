"""The one driver: a scene or a user's own system, a stepper, a duration; out comes a result."""

from __future__ import annotations

import math
import os
import time
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from lcpflex.basics.progress import Progress, tell
from lcpflex.basics.pulse import beating
from lcpflex.basics.stopwatch import Budget, Stopwatch
from lcpflex.checks.wound_springs import wound_spring
from lcpflex.errors import LcpflexError, ModelError, SolverError, StepError, in_range, shown
from lcpflex.jit.background import expecting
from lcpflex.results.energy_balance import (
    EnergyGrowth,
)
from lcpflex.results.problem_log import ProblemLog, RecordProblems
from lcpflex.results.result import Result
from lcpflex.runs import later
from lcpflex.runs.checkpoint import Checkpoints
from lcpflex.runs.collected import check_result, collect, growth_cause
from lcpflex.runs.initial_state import began_wrong, started_from
from lcpflex.runs.limits import Limits
from lcpflex.runs.origin import Origin
from lcpflex.runs.request import checked_budget, checked_request, checked_verify, stored_interval
from lcpflex.runs.setup import Options, Run, Setup, Stepper, compiled_for, set_up
from lcpflex.runs.words import RunWords
from lcpflex.statics.rest import Rest

if TYPE_CHECKING:
    from lcpflex.runs.checkpoint import Checkpoint
    from lcpflex.scene.scene import Scene
    from lcpflex.scene.spatial.scene import SpatialScene
    from lcpflex.scene.user_system import UserSystem

__all__ = ["Stepper", "carry_out", "given_up_after", "kind_of_run", "simulate"]

CHUNK_SECONDS = 0.1  # wall time between looks at progress and at Ctrl-C
LEAST_BUDGET = 1e-9  # that is left to a run that begins anew [s]
NAMED = 8  # closed contacts that an error names


def kind_of_run(scene: object, stepper: object) -> str:
    """Which kernels a run needs, in a few words: "plane MoreauJean"; "" for a user's own system.

    By them the kernels that another process may compile meanwhile are listed (:mod:`lcpflex.jit.manifest`).
    """
    if not hasattr(scene, "spatial"):
        return ""
    integrator = getattr(stepper, "integrator", None)
    marks = [type(integrator).__name__] if integrator else ["adaptive"] if getattr(stepper, "adaptive", None) else []
    return " ".join(["space" if scene.spatial else "plane", type(stepper).__name__, *marks])


def simulate(
    scene: Scene | SpatialScene | UserSystem,
    duration: float,
    stepper: Stepper | str | None = None,
    *,
    record: float | str | None = None,
    progress: bool | None = None,
    project: bool = False,
    energy_growth: EnergyGrowth = EnergyGrowth.WARN,
    record_problems: RecordProblems | None = None,
    initial: Result | Rest | None = None,
    checkpoint: str | os.PathLike[str] | None = None,
    every: float = 60.0,
    budget: float | None = None,
    verify: bool | str = False,
    tolerance: float | None = None,
    outputs: Any = None,
) -> Result:
    """Advance ``scene`` over ``duration`` [s] with ``stepper``.

    Parameters
    ----------
    scene
        A :class:`Scene` or :class:`SpatialScene`, or a :class:`UserSystem` given by its functions M, h, gaps, W, w.
    duration
        Time to simulate [s], > 0.
    stepper
        ``MoreauJean(step)``, ``GeneralizedAlpha(step)``, ``EventDriven()``, ``MasslessBoundary()`` or ``Smooth(law)``,
        with its solver; or a name as of ``lcpflex run --stepper`` ("moreau-jean", "event-driven", ...), which takes its
        step from the scene. None: event-driven stepping, but where more than twelve bodies may lie on each other or
        flexible ones may, where modes would take too many steps, and where it stops or takes too much work: then the
        run is begun anew with generalised-alpha (rigid piles: Moreau-Jean), at a step that is good for a first look.
        Bodies with residual modes whose contacts will close point by point, not flat, get a massless boundary. A note
        of the result says which it is, why, and how to pin it; what is counted is the scene's, not the clock's.
    record
        Time between stored instants [s]; a thousandth of the duration by default, and never less than a step; 0 stores
        each step. "dense": all that :meth:`Result.at` needs, each step and with ``EventDriven`` its middle, too.
    progress
        Show a progress bar. By default on a terminal, once the run has lasted two seconds; elsewhere a line a minute
        tells how far the run has come, how fast it goes and, of an event-driven one, which contact makes most events:
        by the logger ``lcpflex`` at level INFO, or on stderr where logging is not set up. False: no bar, and lines by
        the logger alone.
    project
        Move an initial state that violates joints onto them, and push bodies that penetrate each other apart, instead
        of refusing it: the least motion in the mass metric M + (1000 / omega_1)^2 K, in which bodies deform only where
        joints leave them no other way. All gaps are then >= 0 to rounding, and the notes of the result tell how far
        each contact was pushed. What is wedged is refused.
    energy_growth
        Whether contact impulses that create energy end the run, make a warning (default), or are accepted.
    record_problems
        Write contact problems of the run to a file, for ``lcpflex cross-check`` and :func:`lcpflex.solvers.replay`.
    initial
        Start from the last state of this result, of the same bodies, instead of that of the scene: from its positions
        and velocities alone. Time begins at 0 again; what the stepper remembered beside is not carried over, and the
        notes of the result say what that is. To go on with a run bit for bit, use ``checkpoint``. Or from a place of
        rest, as :func:`lcpflex.equilibrium` and :func:`lcpflex.path` find it; the joints of the scene are assembled
        then, as there, and where its own start is, and what overlaps there, does not matter.
    checkpoint
        A file from which :func:`lcpflex.resume` goes on with this run, bit for bit, after the process was killed: npz,
        never unpickled, always whole. Written at the start, at the end, at Ctrl-C, and in between.
    every
        Time between checkpoints in seconds of the clock on the wall; at most that much work is lost. It is stretched,
        with a warning, where writing would take more than 2 % of the time: a checkpoint holds all that was recorded
        so far, and is as large.
    budget
        Seconds of computing, compilation not counted, after which the run ends where it is: None for any. A step that
        is under way is finished, and with ``checkpoint`` the file is written, from which ``resume`` goes on.
    verify
        Whether to measure the error of the run by reruns (:meth:`Result.verify`), which take some six times its work
        and call functions of the user again: ``result.error`` holds it then. "auto": where the run is small, by its
        steps, coordinates and contacts, so that the same script says the same words on every machine.
    tolerance
        Error that the run may have: of places of the worst point of each body, rotations included, over the largest
        extent or travel (.01: 1 %); of ``outputs``, where they are given, over their ranges. Method, step and modes are
        chosen by short runs, all counted, none timed: bodies that the scene reduces (``modes=``), or that were reduced,
        get as many modes as the tolerance needs, fewer than were given or more. The finest run made is returned, with
        ``result.error`` and ``result.choice``, which says what was tried and which method of another kind bears it out.
        A stepper that is given keeps its method, and its step or tolerance is chosen. ``verify`` has nothing to add;
        ``initial`` keeps the modes; ``checkpoint``, ``budget`` and ``record_problems`` are refused. Ctrl-C ends it
        without a result.
    outputs
        What the tolerance is of: functions of a :class:`Result` by name, names of standard outputs ("trajectory",
        "motion", "impulses", "peak force", "peak impulse", "energy") or :class:`lcpflex.studies.Output`, as in studies.

    Returns
    -------
    Result
        Complete; or up to an interruption by Ctrl-C, or to where its budget was spent, marked incomplete, with a
        message that tells at which time and why.

    Raises
    ------
    ModelError
        For an argument out of its range, before time is spent.
    StepError
        If a step cannot be made; its ``result`` holds everything up to there.
    ToleranceError
        If the tolerance cannot be had, or no method of another kind bears it out, with the reason; its ``result`` is
        the best run made.
    """
    if tolerance is not None:
        checked_verify(verify)
        unused = {"checkpoint": checkpoint, "budget": budget, "record_problems": record_problems}
        return later.run_to_tolerance(
            scene, duration, tolerance, outputs, stepper, record, progress, project, energy_growth, initial, unused
        )
    if outputs is not None:
        raise ModelError(f"outputs: {shown(outputs)} was given without a tolerance, expected None")
    wish = None
    if stepper is None or isinstance(stepper, str):
        from lcpflex.runs.default_stepper import Wish  # which runs of a given stepper do without

        wish = Wish(stepper, duration)
        stepper = wish.expected
    duration, interval, progress, project = checked_request(
        duration, stepper, record, progress, project, energy_growth, record_problems
    )
    verify = checked_verify(verify)
    with expecting(kind_of_run(scene, stepper)):
        resting = isinstance(initial, Rest)
        source = compiled_for(scene, stepper, project or resting, None if resting else project and initial is None)
        choice = None
        if wish is not None:
            choice = wish.choice(source if initial is None else started_from(source, initial, stepper)[0])
            stepper = choice.stepper
            interval = stored_interval(record, duration, stepper)
        notes: tuple[str, ...] = ()
        if initial is not None:
            source, notes = started_from(source, initial, stepper)
        records_problems = record_problems is not None
        every = in_range("every", every, 0.0, float("inf"))
        wrong = began_wrong(initial)
        options = Options(duration, interval, project, energy_growth, notes, wrong, every, records_problems, choice)
        budget = checked_budget(budget)
        keeper = None if checkpoint is None else Checkpoints(checkpoint, every)
        if keeper is not None:
            keeper.refuse_others()
        result = carry_out(set_up(source, stepper, options, record_problems), progress, keeper, budget=budget)
    return _verified(result, verify, scene, progress)


def _verified(result: Result, verify: bool | str, scene: Any, progress: bool | None) -> Result:
    """The result, with its error where that was asked for; an interruption leaves it as it is."""
    result = replace(result, origin=replace(result.origin, scene=scene))
    if verify is False or not result.complete:
        return result
    if verify is True or later.is_cheap(result):
        why = ""
        try:
            later.verify(result, progress=progress)
        except KeyboardInterrupt:
            why = "it was interrupted"
        except LcpflexError as error:  # what was run is not lost with it
            why = str(error)
        if why:
            return replace(result, notes=(*result.notes, f"the error of the run was not measured: {why}"))
    return result


def given_up_after(
    seconds: float | None,
    scene: Scene | UserSystem,
    duration: float,
    stepper: Stepper,
    record: float | None = None,
    energy_growth: EnergyGrowth = EnergyGrowth.WARN,
) -> Result:
    """What :func:`simulate` returns, without a progress bar; StepError after so many seconds of computing."""
    duration, interval, _, _ = checked_request(duration, stepper, record, False, False, energy_growth, None)
    options = Options(duration, interval, False, energy_growth)
    setup = set_up(compiled_for(scene, stepper, False), stepper, options, None)
    return carry_out(setup, False, budget=seconds, fails=True)


def carry_out(
    setup: Setup,
    progress: bool | None = None,
    keeper: Checkpoints | None = None,
    kept: Checkpoint | None = None,
    budget: float | None = None,
    fails: bool = False,
    spent: tuple[float, float] = (0.0, 0.0),
    most: float = math.inf,
) -> Result:
    """Make the run to its end: from its beginning, or from a checkpoint ``kept`` of it, or until its ``budget`` [s] is
    spent or it has made the ``most`` steps and events that it may, which is an error if it ``fails`` then. ``spent``:
    on computing and on compiling before [s].

    Raises ModelError where the checkpoints of ``keeper`` cannot be written, and StepError as ``simulate`` does.
    """
    stepper, system = setup.stepper, setup.system
    options, problem_log = setup.options, setup.problem_log
    clock = Stopwatch()
    run = setup.run()
    errs = options.energy_growth is EnergyGrowth.ERROR
    limits = Limits(growth_cause(stepper, system) if errs else "", Budget(budget, clock), options.choice, most)
    message: str = ""
    cause: Exception | None = None
    if kept is not None:
        spent = kept.restore(setup, run)
    else:  # compiles, or loads from the cache; a loop in Python does so when it comes to a kernel
        with Progress(progress, lambda: "compiling or loading kernels", what="simulate", bar=False):
            message, cause = _guarded(run, limits, 1 if system.hooks else 0)
    clock.started()
    if keeper is not None:
        keeper.begin(setup, run, clock, spent, kept is not None)
    interrupted = False
    if not message:
        try:
            message, cause = _advance_all(setup, run, limits, progress, keeper)
        except KeyboardInterrupt:
            interrupted = True
    anew = None if interrupted else _begun_anew(setup, run, limits, message, cause)
    if keeper is not None:
        keeper.end(anew is None and (interrupted or limits.late or not message))
    if anew is not None:
        computing, loading = clock.ended()
        left = None if budget is None else max(budget - computing, LEAST_BUDGET)
        return carry_out(anew, progress, keeper, None, left, fails, (spent[0] + computing, spent[1] + loading))
    try:
        error = setup.sensing.finish(run.records)
    except KeyboardInterrupt:
        interrupted, error = True, None
        setup.sensing.stop(run.records)
    if error is not None and not message:
        message, cause = str(error), error
    computing, loading = clock.ended()
    timing = (spent[0] + computing, spent[1] + loading)
    complete = not (message or interrupted)
    note = "interrupted" if interrupted else message or "ran to the end"
    if interrupted or limits.late:
        note += f" at t = {run.time:.6g} s"
    result = check_result(collect(setup, run, timing, note, complete), setup, run)
    result = replace(result, origin=Origin(setup.source, stepper, options))
    if problem_log is not None:
        result = _save_problems(problem_log, result)
    if message and (fails or not limits.late):
        from lcpflex.checks.blocked_drives import blocked_drives  # which runs that end well do without
        from lcpflex.checks.jumped_gaps import jumped_gap

        touching = tuple(setup.contact_name(k) for k in run.touching)
        # a gap that jumps is what lets a drive run into a contact
        root = jumped_gap(result, run, setup.system, setup.source) or blocked_drives(result, run.touching)
        words = f"{message}{wound_spring(result)}{root}"
        raise StepError(
            f"at t = {run.time:.9g} s, after {run.steps} steps, {_closed(touching)}: {words}",
            time=run.time,
            step=run.steps,
            contacts=touching,
            result=result,
        ) from cause
    return result


def _begun_anew(setup: Setup, run: Run, limits: Limits, message: str, cause: Exception | None) -> Setup | None:
    """The run with the other stepper where the one that was chosen stops; None where it does not, or none is left.

    What a function of the user's raises, and what the user has asked to be an error, ends the run under any stepper.
    """
    choice = setup.options.choice
    by_method = message and not limits.late and not limits.grown and (cause is None or isinstance(cause, SolverError))
    if not by_method or choice is None or choice.other is None:
        return None
    choice = choice.instead(run, message)
    tell(choice.note, quiet=True)
    options = replace(setup.options, choice=choice, interval=max(setup.options.interval, 0.0))  # < 0: events alone
    log = setup.problem_log
    return set_up(setup.source, choice.stepper, options, None if log is None else log.request)


def _closed(touching: tuple[str, ...]) -> str:
    """The contacts that are closed, in words."""
    if not touching:
        return "no contact closed"
    more = f" and {len(touching) - NAMED} more" if len(touching) > NAMED else ""
    return f"contact{'s' if len(touching) > 1 else ''} {', '.join(touching[:NAMED])}{more}"


def _save_problems(problem_log: ProblemLog, result: Result) -> Result:
    """Write the recorded problems; if that cannot be, the result says so and is not lost."""
    try:
        problem_log.save()
    except LcpflexError as error:
        return replace(result, warnings=(*result.warnings, f"the contact problems were not stored: {error}"))
    return result


def _guarded(run: Run, limits: Limits, n_steps: int) -> tuple[str, Exception | None]:
    """Up to n_steps steps: why it stopped, empty if it did not, and what a function or solver of the user raised."""
    try:
        return limits.advance(run, n_steps), None
    except SolverError as error:  # the cause is what a solver of the user's raised
        return str(error), error.__cause__ if isinstance(error.__cause__, Exception) else error
    except LcpflexError as error:
        return str(error), error
    except Exception as error:  # whatever it is, what was recorded before must not be lost with it
        return f"{type(error).__name__}: {error}", error


def _advance_all(
    setup: Setup, run: Run, limits: Limits, progress: bool | None, keeper: Checkpoints | None
) -> tuple[str, Exception | None]:
    """Advance in chunks of about CHUNK_SECONDS until the end."""
    duration = setup.options.duration
    bar_format = "{l_bar}{bar}| {n:.4g}/{total:.4g} s [{elapsed}<{remaining}]"
    words = RunWords(run, duration, setup.contact_name)
    bar = Progress(progress, words, what="simulate", total=duration, initial=run.time, unit="s", bar_format=bar_format)
    chunk = 16
    with beating(), bar:
        while True:
            if message := limits.overworked(run):
                return message, None
            if run.finished:
                return "", None
            began, before = time.perf_counter(), run.steps
            if keeper is not None:
                keeper.chunk_begins()
            message, cause = _guarded(run, limits, chunk)
            if message:
                return message, cause
            if keeper is not None:
                keeper.chunk_ends()
            bar.update(run.time - bar.n)
            if message := limits.spent(run):
                return message, None
            spent = time.perf_counter() - began
            made = max(1, run.steps - before)  # fewer than asked for where they are slow
            chunk = max(1, min(2 * chunk, int(made * CHUNK_SECONDS / max(spent, 1e-9))))
