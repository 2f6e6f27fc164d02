"""Moreau-Jean time stepping under error control (:mod:`lcpflex.steppers.step_doubling`)."""

from __future__ import annotations

from lcpflex.dynamics.workspace import Workspace
from lcpflex.jit.kernel import kernel
from lcpflex.model.arrays import Model
from lcpflex.steppers.adaptive import Limits, after_impact
from lcpflex.steppers.backup import Backup
from lcpflex.steppers.clock import ALONE, StepClock
from lcpflex.steppers.moreau_jean.memory import MoreauJeanScheme
from lcpflex.steppers.recorder import Recorder
from lcpflex.steppers.scheme import begin_part, go_on, judge
from lcpflex.steppers.unmet import closed_pairs, unmet

__all__: list[str] = []


@begin_part.of(MoreauJeanScheme)
@kernel
def choose_threshold(scheme: MoreauJeanScheme, alone: bool, stopped: float, rebound: float, work: Workspace) -> None:
    """What a trial has stopped counts for nothing."""
    work.impulses.stopped = stopped
    scheme.velocity_threshold = rebound


@judge.of(MoreauJeanScheme)
@kernel
def judge_step(
    model: Model,
    scheme: MoreauJeanScheme,
    clock: StepClock,
    error: float,
    near: float,
    work: Workspace,
    recorder: Recorder,
    kept: Backup,
) -> tuple[float, float, float, float]:
    """One that has gone far beyond what it closed with was not controlled by the difference of states."""
    if not error <= 1.0:
        return error, 0.0, 0.0, 0.0
    sunk, approach, pull = closed_pairs(model, scheme.q, scheme.u, scheme.gap_tolerance, work, recorder, kept)
    if clock.part != ALONE:
        late = max(sunk - clock.deepest, unmet(model, scheme.q, work.compliant, recorder.table))
        error = max(error, late / near)
    return error, sunk, approach, pull


@go_on.of(MoreauJeanScheme)
@kernel
def take_impact(
    scheme: MoreauJeanScheme, limits: Limits, clock: StepClock, approach: float, pull: float, work: Workspace
) -> None:
    """A pair that has closed without an impulse is struck in the next step, which is a short one."""
    clock.stopped = work.impulses.stopped
    after_impact(limits, clock, approach, pull * limits.shortest / clock.tried, clock.part == ALONE)
