"""What a time-stepping scheme is made of: kernels over a struct of its own, by whose type loops find them.

A scheme is a struct with the fields ``step``, the length of its steps [s], ``tolerance``, of contact problems, ``q``,
``u``, and whatever else its steps take over from each other, with

1. :data:`take_step`, which predicts, detects, poses, solves and corrects;
2. :data:`record`, which stores an instant;
3. :data:`end_step`, where contacts take note of a step that counts;
4. :data:`set_length`, where something of its memory belongs to steps of one length;

and, for error control by :mod:`lcpflex.steppers.step_doubling`, besides

5. :data:`begin_trial` and :data:`begin_part`, before a step is tried and before each part of it;
6. :data:`unmet_share`, where such a step should have ended;
7. :data:`judge`, what a step has missed, and :data:`go_on`, once it is accepted.

The third to sixth have a default. :class:`lcpflex.steppers.time_stepping.Support` is what Python is asked beside.
"""

from __future__ import annotations

from typing import Any

from lcpflex.dynamics.workspace import Workspace
from lcpflex.jit.leaf import leaf, optional_leaf
from lcpflex.model.arrays import Model
from lcpflex.steppers.clock import StepClock
from lcpflex.steppers.recorder import Recorder

__all__ = [
    "NEVER",
    "NO_FACTOR",
    "begin_part",
    "begin_trial",
    "end_step",
    "go_on",
    "judge",
    "record",
    "set_length",
    "take_step",
    "unmet_share",
]

NEVER = 2.0  # share of a step
NO_FACTOR = -1


@leaf
def take_step(model: Model, scheme: Any, t: float, work: Workspace, recorder: Recorder, clock: Any) -> int:
    """One step from t, in place; DONE, PART where only a part of it was made, or why not, see ``clock.number``.

    What was not finished goes on at the next call.
    """
    raise NotImplementedError


@leaf
def record(model: Model, scheme: Any, t: float, work: Workspace, recorder: Recorder) -> int:
    """Store the present instant; returns the entries that the contact table of the recorder must hold, or NO_FACTOR.

    Then the memory ``work.impulses.large_solver.apart`` is to be widened first.
    """
    raise NotImplementedError


@optional_leaf
def end_step(model: Model, scheme: Any, t: float, explicit: bool, work: Workspace) -> bool:
    """The step to t counts; False where a contact is off the range of its law. ``explicit``: none will be shorter."""
    return True


@optional_leaf
def set_length(scheme: Any, length: float) -> None:
    """Go on with steps of another length [s]."""
    scheme.step = length


@optional_leaf
def begin_trial(model: Model, scheme: Any, t: float, duration: float) -> None:
    """Before a step from t is tried for the first time."""


@leaf
def begin_part(scheme: Any, alone: bool, stopped: float, rebound: float, work: Workspace) -> None:
    """Before a step of two halves is begun, or one that is made ``alone``.

    ``stopped``: fastest approach that was stopped so far, ``rebound``: up to which they are stopped, not reflected
    [m/s].
    """
    raise NotImplementedError


@optional_leaf
def unmet_share(scheme: Any, limits: Any, clock: StepClock) -> float:
    """Share of a step of two halves at which it should have ended; above 1: it need not."""
    return NEVER


@leaf
def judge(
    model: Model,
    scheme: Any,
    clock: StepClock,
    error: float,
    near: float,
    work: Workspace,
    recorder: Recorder,
    kept: Any,
) -> tuple[float, float, float, float]:
    """What a step has come to at its end, of ``error`` over its tolerance by doubling, 0 where it was made alone.

    The error with what has sunk unseen over ``near`` [m]; deepest penetration [m]; fastest approach of pairs that no
    problem has held, and by how much the step has changed a gap rate at most [m/s].
    """
    raise NotImplementedError


@leaf
def go_on(scheme: Any, limits: Any, clock: StepClock, approach: float, pull: float, work: Workspace) -> None:
    """After a step that was accepted: what it tells of the next one; approach and pull as :data:`judge` found them."""
    raise NotImplementedError
