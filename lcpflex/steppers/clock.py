"""Where a run stands: time and steps, and what a loop that returned has to say."""

from __future__ import annotations

from lcpflex.jit.struct import struct

__all__ = ["StepClock", "StepCount"]


@struct
class StepCount:
    """Of steps of one length, and of their parts."""

    number: float  # explains what a loop returned
    made: int  # steps
    stored: int  # the step last stored
    within: float  # time made of the present step [s]
    begun: int  # 1 where the state at the start was recorded
    parts: float  # of a step
    closed_then: int  # contacts closed when a step was divided


@struct
class StepClock:
    """Of steps of controlled length."""

    number: float  # explains what a loop returned
    time: float  # [s]
    step: float  # to try next [s]
    steps: int  # made
    recent: float  # length of the last one [s]
    due: float  # time at which an instant is to be stored [s]
    n_shortest: int  # steps of the shortest length
    rejected: int  # 1 after a rejection
    deepest: float  # penetration at the end of the last step [m]
    # impacts, see after_impact
    fastest: float  # impact so far [m/s]
    pull: float  # what a shortest step adds to an approach [m/s]
    cruise: float  # length tried before a step that had to end at an impact [s]
    strikes: int  # shortest steps in a row for impacts
    stopped: float  # fastest approach that was stopped [m/s]
    # steps that are made in parts
    part: int
    tried: float  # length of the step whose parts these are [s]
    scaled: float  # step that the recursive acceleration belongs to [s]
