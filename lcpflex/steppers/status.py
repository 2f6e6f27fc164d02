"""Why a compiled loop returned: one enumeration for all steppers."""

from __future__ import annotations

from enum import IntEnum

__all__ = ["RunStatus"]


class RunStatus(IntEnum):
    """What a loop returns; ``sentence`` is what the run is told where nothing more is known of it."""

    _said: str

    def __new__(cls, value: int, said: str = "") -> RunStatus:
        member = int.__new__(cls, value)
        member._value_ = value
        member._said = said
        return member

    @property
    def sentence(self) -> str:
        """Never empty: a run that is not told why it cannot go on would try again."""
        return self._said or self.name.lower().replace("_", " ")

    DONE = 0
    PART = 17  # of a step was made
    # something is full or too small: the loop goes on with more room
    TAPE_FULL = 1
    GROW = 2
    GROW_TAPE = 3
    EVENTS_FULL = 4
    GROW_FACTOR = 18  # of the forces of large islands that are stored
    # the run has something to do before the loop goes on
    PASSED = 5  # a body may have passed through another one
    CALM = 6  # raised thresholds are to be lowered
    PAUSE = 19  # the loop has run for a while: see lcpflex.basics.pulse
    # the loop cannot go on as it is
    SOLVER_FAILED = 7, "a velocity or force of the contact problem is no finite number"  # else the solver is asked why
    NOT_FINITE = 8, "the state is no longer finite: the step is too long for the forces of this scene"
    STEP_TOO_SHORT = 9, "no step is short enough: the forces are not smooth, or the state grows without bound"
    OUT_OF_RANGE = 10  # a contact law, of the indentations it is valid for
    TOO_LONG = 11
    STIFF = 12
    UNSETTLED = (
        13,
        "the forces of the elastic laws of contacts do not settle to one part in a billion: shorten the step",
    )
    CHATTER = 14
    TOO_OFTEN = 15
    HIT_TOGETHER = 16
