"""The smallest bodies that a scene needs: rigid, a few modes, many, or the full mesh.

import lcpflex as lf
from lcpflex.studies import right_size

found = right_size(scene, "impulses", 1e-2, duration=0.5, stepper=lf.MoreauJean(step=1e-4))
print(found)                     # table and a sentence
result = lf.simulate(found.scene, 0.5, lf.MoreauJean(step=1e-4))
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

from lcpflex.accuracy.refinement import brief
from lcpflex.basics.arguments import flag, optional_flag, positive, raised
from lcpflex.basics.progress import Progress
from lcpflex.errors import LcpflexError, ModelError, in_range, shown
from lcpflex.steppers.generalized_alpha.stepper import GeneralizedAlpha
from lcpflex.studies.given_functions import is_stepper
from lcpflex.studies.model_order.estimate import left_at, trend_of
from lcpflex.studies.model_order.report import FidelityRun, NextLevel, RightSize
from lcpflex.studies.model_order.scenes import FULL, Fidelities, State, comparable, of_scene
from lcpflex.studies.model_order.search import Search
from lcpflex.studies.model_order.steps import StepErrors, step_errors
from lcpflex.studies.model_order.verdict import contradictions, remedy

__all__ = ["right_size"]

STEPS = 2000  # of a run, at least, where no stepper is given
A_PERIOD = 2000  # steps in a period of the lowest mode of the stiffest body: rich ones have far higher modes
MOST = 500_000  # steps of such a run
SHORTER = 4.0  # factor by which the step is shortened where rich bodies cannot be trusted with it
ATTEMPTS = 3
LIMIT = 60.0  # [s]
QUICK = 0.25  # part of the limit that a run may take with a step that was shortened for accuracy alone


def right_size(
    scene: Any,
    outputs: Any = None,
    tolerance: float = 1e-2,
    *,
    duration: float | None = None,
    stepper: Any = None,
    limit: float = LIMIT,
    verify: bool = True,
    progress: bool | None = None,
) -> RightSize:
    """Find the cheapest fidelity of each body at which the outputs of a scene are within a tolerance of the full mesh.

    Every body that has fidelity levels (made by ``reduce`` of a beam, bar or mesh) starts rigid. One run far up is what
    all others are compared with; its own error is extrapolated with the rate that the levels below it show. Then
    the bodies climb: only those whose refinement changes the outputs, each until the estimate is within the tolerance.
    The full mesh itself is that run where this is expected to take no longer than the three rich runs which it takes to
    do without; else it is run only where nothing below is proved to be good enough. For one to three bodies all runs
    together took as long as two to five of the full mesh, and with the reruns below as six to twelve
    (``tests/unit/studies/test_right_size_scenes.py``).

    All levels are run with the same step, so that their differences measure the model and not the step. What the step
    does is measured as :meth:`Result.verify` does it: twice the largest difference of the outputs to reruns with a
    quarter of the step and by another method, of the scene that was found, and of that which all others are compared
    with; where another method would cost too much by the counted work, to the first of them alone. Nothing is promised
    where one of these errors is above the tolerance, where richer bodies were off, where rich ones cannot be trusted,
    or where an output is zero; what was not run is said.

    Parameters
    ----------
    scene
        A :class:`Scene`, a function that builds one, or a :class:`Case`.
    outputs
        As in :func:`work_precision`: names of standard outputs, functions of a :class:`Result`, :class:`Output`. By
        default "motion", the positions of two places of each body, and "impulses" of the contacts. Velocities
        ("trajectory") and the "peak force" show every wave, and need far richer bodies.
    tolerance
        Largest error of each output, relative to its scale.
    duration
        Time to simulate [s]; that of the case by default.
    stepper
        One for all levels, or a function of the scene that makes one (for explicit schemes, whose step has to fall with
        the highest mode; then the step differs and its error is part of what is measured). Where rich bodies cannot be
        trusted with it, one with which they can is looked for and named. By default the one of the case; without one,
        or if the result with rich bodies warns, ``GeneralizedAlpha``, which damps modes too fast for its step, with
        the smaller of a 2000th of the duration and a 2000th of the longest period of the stiffest body, then a quarter
        of that step and again of it, also if that leaves an error above the tolerance and runs are quick; but at most
        500 000 steps.
    limit
        Wall time [s] of a run: what is predicted to take longer is not run.
    verify
        Run the full mesh where that is as cheap as to do without, and where no reduced run proves that another one is
        good enough. Else that is not proved, and the scene is the cheapest whose estimate is within the tolerance.
    progress
        Show a progress bar; by default on a terminal, after two seconds, and elsewhere a line a minute: see
        :func:`simulate`.

    Returns
    -------
    RightSize
        The scene, the table of runs, what the next levels would cost and change, a chart, and advice in words. After
        Ctrl-C with what was measured before, marked incomplete.

    Raises
    ------
    KeyboardInterrupt
        After Ctrl-C before anything was measured.
    ModelError
        For arguments out of range, and a scene none of whose bodies has fidelity levels.
    """
    tolerance = in_range("tolerance", tolerance, 0.0, 1.0, open_ends=True)
    limit = in_range("limit", limit, 0.0, math.inf, open_ends=True)
    verify, progress = flag("verify", verify), optional_flag("progress", progress)
    span = getattr(scene, "duration", None) if duration is None else duration
    if span is None:
        raise ModelError("duration: not given, and the scene does not say; expected a number of seconds > 0")
    span = positive("duration", span)
    fidelities = of_scene(scene)
    used = comparable(fidelities, outputs)
    attempts, own = _attempts(fidelities, span, getattr(scene, "stepper", None), stepper)
    spent = 0.0
    given_up: list[str] = []
    with Progress(progress, what="right_size", unit="run", leave=False) as bar:
        for k, make in enumerate(attempts):
            last = k + 1 == len(attempts)
            quick = QUICK * limit / SHORTER if k >= own and not last else None
            search = Search(fidelities, used, tolerance, span, make, limit, verify, not last, quick, bar.update)
            others = [] if stepper is None else _defaults(fidelities, span)
            found, steps, better, complete = _measured(search, others)
            spent += search.spent
            used_step = brief(make(fidelities.scene))
            if last or not complete:
                break
            if search.untrusted:
                given_up += [f"{used_step} was given up: {note}" for note in search.notes]
            elif k >= own and steps.largest > tolerance and SHORTER * search.cost(fidelities.top) < QUICK * limit:
                given_up.append(
                    f"{used_step} was given up: its steps leave an error of {100.0 * steps.largest:.2g} %, by reruns"
                )
            else:
                break
    search.notes[:0] = given_up
    return replace(_report(search, found, steps, spent, complete), better=better)


def _measured(search: Search, others: Sequence[Callable[[Any], Any]]) -> tuple[State | None, StepErrors, Any, bool]:
    """What was found, the errors of its steps, a better one of other steppers, and whether Ctrl-C was not."""
    found, steps = None, StepErrors()
    try:
        found = search.find()
        if found is not None:
            steps = step_errors(search, found)
        elif (
            search.coarse is not None and search.coarse.largest > search.tolerance
        ):  # the search ended there: a shorter step is to come
            steps = StepErrors(search.coarse)
        return found, steps, remedy(search, others), True
    except KeyboardInterrupt:
        if not search.trials:
            raise
        return found, steps, None, False


def _attempts(fidelities: Fidelities, duration: float, own: Any, given: Any) -> tuple[list[Callable[[Any], Any]], int]:
    """Steppers to be tried in turn, and how many of them others have chosen: that of the user alone, or of a case."""
    if given is not None:
        return [_stepper(given)], 1
    chosen = [] if own is None else [_stepper(own)]
    return [*chosen, *_defaults(fidelities, duration)], len(chosen)


def _defaults(fidelities: Fidelities, duration: float) -> list[Callable[[Any], Any]]:
    """Steppers to be tried, from long to short steps."""
    periods = [2.0 * math.pi / float(levels[1].make().frequencies().min()) for levels in fidelities.levels]
    longest = min(duration / STEPS, min(periods) / A_PERIOD)
    steps = dict.fromkeys(max(longest / SHORTER**k, duration / MOST) for k in range(ATTEMPTS))
    return [_stepper(GeneralizedAlpha(step=step)) for step in steps]


def _stepper(given: Any) -> Callable[[Any], Any]:
    """What makes the stepper of a scene."""
    if is_stepper(given):
        return lambda scene: given
    if not callable(given) or isinstance(given, type):
        raise ModelError(
            f"stepper: {shown(given)} was given, expected a stepper, or a function that makes one for a scene"
        )

    def made(scene: Any) -> Any:
        try:
            one = given(scene)
        except LcpflexError:
            raise
        except Exception as error:
            raise raised("stepper", error, "a stepper such as MoreauJean(step=1e-4)") from error
        if not is_stepper(one):
            raise ModelError(
                f"stepper: the function made {shown(one)}, expected a stepper such as MoreauJean(step=1e-4)"
            )
        return one

    return made


def _report(search: Search, found: State | None, steps: StepErrors, spent: float, complete: bool) -> RightSize:
    fidelities = search.fidelities
    runs = tuple(
        _run(search, state, found) for state in sorted(search.trials, key=lambda s: (fidelities.coordinates(s), s))
    )
    best = search.best() if found is None and search.reference is not None else found
    top = fidelities.top
    whole = all(fidelities.whole(b) for b in range(len(top)))
    return RightSize(
        scene=None if best is None else fidelities.at(best),
        proved=found is not None,
        tolerance=search.tolerance,
        levels={} if best is None else fidelities.labels(best),
        errors={} if best is None else search.errors(best),
        runs=runs,
        next=() if best is None else tuple(_next(search, best)),
        reference={} if search.reference is None else fidelities.labels(search.reference),
        stepper=search.stepper_of(fidelities.scene),
        duration=search.duration,
        spent=spent,
        full=search.cost(top) if whole else math.nan,
        full_was_run=whole and top in search.trials and search.trials[top].complete,
        step_error=steps.own.largest,
        reference_step_error=steps.reference.largest,
        reruns=tuple(one.what for one in steps.own.reruns),
        reference_reruns=tuple(one.what for one in steps.reference.reruns),
        exhausted=search.exhausted,
        unmeasured=steps.missing,
        contradictions=tuple(contradictions(search, found)),
        notes=tuple(search.notes),
        complete=complete,
    )


def _run(search: Search, state: State, found: State | None) -> FidelityRun:
    one = search.trials[state]
    errors = search.errors(state)
    return FidelityRun(
        levels=search.fidelities.labels(state),
        coordinates=search.fidelities.coordinates(state),
        steps=one.steps,
        wall_time=one.wall_time,
        errors=errors,
        within=search.good(state),
        chosen=state == found,
        reference=state == search.reference,
        full=all(level == FULL for level in search.fidelities.labels(state).values()),
        failure=one.failure,
    )


def _next(search: Search, state: State) -> list[NextLevel]:
    """What one level more of each body, and the full mesh, would cost and change; measured where they were run."""
    fidelities = search.fidelities
    found = []
    for b, name in enumerate(fidelities.names):
        if state[b] < fidelities.top[b]:
            richer = (*state[:b], state[b] + 1, *state[b + 1 :])
            run = search.sound(richer)
            cost = search.cost(richer) / search.cost(state)
            found.append(
                NextLevel(
                    f"{name}: {fidelities.levels[b][state[b] + 1].name}",
                    cost if run else max(cost, 1.0),
                    search.estimate(richer) if run else _expected(search, state, richer, b),
                    run,
                )
            )
    return found


def _expected(search: Search, state: State, richer: State, body: int) -> float:
    """The error with one level more, where it was not run: by the trend of the body if that changes anything."""
    if body not in search.needing:
        return search.estimate(state)
    now, then = search.fidelities.modes(state)[body], search.fidelities.modes(richer)[body]
    worst = 0.0
    for output in search.used():
        samples, size, full = search.samples(output)
        trend = trend_of(samples, size)
        before, after = left_at(trend, now, full), left_at(trend, then, full)
        worst = max(worst, search.errors(state)[output.name] * (after / before if before > 0.0 else 1.0))
    return worst
