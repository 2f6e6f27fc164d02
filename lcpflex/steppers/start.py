"""The run of a time-stepping scheme: with steps of one length, or under error control."""

from __future__ import annotations

from lcpflex.steppers.adaptive import AdaptiveStep
from lcpflex.steppers.fixed_steps import FixedSteps
from lcpflex.steppers.run import Run
from lcpflex.steppers.step_doubling import StepDoubling
from lcpflex.steppers.time_stepping import TimeStepping

__all__ = ["started"]


def started(
    stepping: TimeStepping,
    adaptive: AdaptiveStep | None,
    duration: float,
    interval: float,
    average: tuple[float, float],
) -> Run:
    """A run over ``duration`` [s] that stores an instant about every ``interval`` [s].

    ``average``: shares of a step of fixed length before and after the time that forces are asked for, over which loads
    are averaged.
    """
    if adaptive is None:
        return Run(FixedSteps(stepping, duration, interval, average))
    return Run(StepDoubling(stepping, adaptive.limits(stepping.system, duration, interval)))
