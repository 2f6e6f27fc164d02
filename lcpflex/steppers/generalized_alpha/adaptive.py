"""Generalised-alpha time stepping under error control (:mod:`lcpflex.steppers.step_doubling`)."""

from __future__ import annotations

from lcpflex.dynamics.instants import at_stop
from lcpflex.dynamics.workspace import Workspace
from lcpflex.jit.kernel import kernel
from lcpflex.model.arrays import Model
from lcpflex.steppers.adaptive import MOST_STRIKES, SETTLE, Limits, resume, threshold
from lcpflex.steppers.backup import Backup
from lcpflex.steppers.clock import ALONE, StepClock
from lcpflex.steppers.generalized_alpha.memory import RESTART, SMOOTH, AlphaScheme
from lcpflex.steppers.recorder import Recorder
from lcpflex.steppers.scheme import NEVER, begin_part, begin_trial, go_on, judge, unmet_share
from lcpflex.steppers.unmet import closed_pairs

__all__: list[str] = []


@begin_trial.of(AlphaScheme)
@kernel
def restart_at_stop(model: Model, scheme: AlphaScheme, t: float, duration: float) -> None:
    """Where a load has a stop forces may jump, and the recursion with them."""
    if scheme.phase == SMOOTH and at_stop(model.signals, t, duration):
        scheme.phase = RESTART


@begin_part.of(AlphaScheme)
@kernel
def choose_thresholds(scheme: AlphaScheme, alone: bool, stopped: float, rebound: float, work: Workspace) -> None:
    """What a trial has met counts for nothing in its halves."""
    scheme.rebound = rebound
    scheme.settle = SETTLE if alone else 0.0
    if not alone:
        scheme.lifted = 0.0
        scheme.approach = 0.0
        scheme.struck_at = 0.0
        scheme.stopped = 0.0
        scheme.overrun = 0.0


@unmet_share.of(AlphaScheme)
@kernel
def touch_down(scheme: AlphaScheme, limits: Limits, clock: StepClock) -> float:
    """Share of the step at which the pair closed that a position problem has moved out.

    A step that is to end at an impact must not end far behind: of a short contact little approach would be left.
    """
    approach = scheme.approach
    if approach <= threshold(limits, clock) or clock.strikes >= MOST_STRIKES:
        return NEVER
    late = scheme.struck_at / approach
    if late <= limits.shortest or late >= clock.tried:
        return NEVER
    clock.strikes += 1
    return 1.0 - late / clock.tried


@judge.of(AlphaScheme)
@kernel
def judge_step(
    model: Model,
    scheme: AlphaScheme,
    clock: StepClock,
    error: float,
    near: float,
    work: Workspace,
    recorder: Recorder,
    kept: Backup,
) -> tuple[float, float, float, float]:
    """What ends in the second half is put at the end by both results, an impact or a slip: they differ by nothing.

    What has sunk by then tells, and how far the smooth motion has slid on.
    """
    sunk = closed_pairs(model, scheme.q, scheme.u, 0.0, work, recorder, kept)[0]
    if clock.part != ALONE:
        error = max(error, max(sunk - clock.deepest, scheme.lifted, scheme.overrun) / near)
    return error, sunk, 0.0, 0.0


@go_on.of(AlphaScheme)
@kernel
def note_impacts(
    scheme: AlphaScheme, limits: Limits, clock: StepClock, approach: float, pull: float, work: Workspace
) -> None:
    """Of impacts that were met in the step, and the length tried before one that had to end at an impact."""
    clock.fastest = max(clock.fastest, scheme.approach)
    clock.stopped = max(clock.stopped, scheme.stopped)
    resume(limits, clock)
    clock.strikes = 0
