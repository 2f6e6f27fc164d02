"""Where a run of a time-stepping scheme stands: time and steps, and what a loop that returned has to say."""

from __future__ import annotations

from lcpflex.jit.struct import struct

__all__ = ["ALONE", "FIRST", "FRESH", "LONG", "SECOND", "StepClock", "StepCount"]

# StepClock.part: of a step that is tried as a whole and in two halves, or made alone; FRESH: none is begun
FRESH, LONG, FIRST, SECOND, ALONE = range(5)


@struct
class StepCount:
    """Of steps of one length."""

    number: float  # explains what a loop returned
    time: float  # [s]
    steps: int  # made
    step_taken: float  # length of the last part of one [s]
    length: float  # of the steps [s]
    start: float  # time at which steps of this length began [s]
    first: int  # steps made until then
    last: int  # step after which the run ends, which is stored
    stride: int  # steps between stored instants
    stored: int  # the step last stored
    within: float  # time made of the present step [s]
    begun: int  # 1 where the state at the start is whole and may be recorded


@struct
class StepClock:
    """Of steps of controlled length."""

    number: float  # explains what a loop returned
    time: float  # [s]
    step: float  # to try next [s]
    steps: int  # made
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
