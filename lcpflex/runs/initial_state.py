"""Starting a run from the last state of a result, or from a place of rest."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from lcpflex.basics.alarm import Alarm
from lcpflex.compile.compiled_scene import CompiledScene
from lcpflex.compile.consistency import start_apart
from lcpflex.dynamics.start import violation
from lcpflex.errors import ModelError, shown
from lcpflex.model.coordinates import ANGULAR
from lcpflex.results.result import Result
from lcpflex.results.stored_instants import CONTINUED
from lcpflex.statics.rest import Rest

if TYPE_CHECKING:
    from lcpflex.jit.kernel import FloatArray
    from lcpflex.runs.setup import Stepper
    from lcpflex.scene.user_system import UserSystem

__all__ = ["began_wrong", "started_from"]

OFF = 1e-3  # of the size, or rad: what joints may be off at the start; runs without projection drift by less

# what steppers remember from step to step beside positions and velocities, by the name of their class
REMEMBERED = {
    "GeneralizedAlpha": "its recursive acceleration begins anew, as that of the first step",
    "EventDriven": "its index sets and its step length are chosen anew",
    "MasslessBoundary": "the velocities of its static modes begin at 0",
    "Smooth": "",
    "MoreauJean": "",
}


def started_from(
    source: CompiledScene | UserSystem, initial: Result | Rest, stepper: Stepper
) -> tuple[CompiledScene | UserSystem, tuple[str, ...]]:
    """``source`` at the last state of ``initial``, or at rest there, and notes of what is not carried over.

    Raises ModelError for what is neither, holds no instant, or is of other coordinates.
    """
    if isinstance(initial, Rest):
        q, u = np.array(initial.q), np.zeros(len(initial.compiled.u))
    elif not isinstance(initial, Result):
        raise ModelError(
            f"initial: {shown(initial)} was given, expected a Result, as simulate() returns it, or a Rest, as "
            "equilibrium() does"
        )
    elif not len(initial.times):
        raise ModelError("initial: a Result without an instant was given, expected one with a last state")
    else:
        q, u = np.array(initial.q[-1]), np.array(initial.u[-1])
    if not (np.isfinite(q).all() and np.isfinite(u).all()):
        raise ModelError("initial: the last state of the Result is not finite, expected finite numbers")
    ours, theirs = _coordinates(source), _coordinates(initial.compiled, len(q))
    if ours != theirs:
        raise ModelError(
            f"initial: a {type(initial).__name__} with the coordinates {_listed(theirs)} was given, expected those of "
            f"the scene, {_listed(ours)}"
        )
    if isinstance(source, CompiledScene):
        _refuse_off_joints(source, q)
        if isinstance(initial, Rest):
            _refuse_overlap(source, q, u)
        q.setflags(write=False)
        u.setflags(write=False)
    notes = _notes_at_rest(initial) if isinstance(initial, Rest) else _notes(source, initial, stepper)
    return replace(source, q=q, u=u), tuple(notes)


def began_wrong(initial: Result | Rest | None) -> tuple[Alarm, ...]:
    """Why the result that a run begins from is not to be trusted, and so this run is not, either."""
    if not isinstance(initial, Result):
        return ()
    from lcpflex.results.doubts import doubts  # which runs from a scene do without

    # how far it came is no matter of its last state
    found = doubts(replace(initial, complete=True))
    if not found:
        return ()
    clause = f"the result that it began from is not to be trusted ({'; '.join(found)})"
    return (Alarm(clause, "beginning", "", 0.0, None, "have that run trusted first"),)


def _refuse_off_joints(source: CompiledScene, q: FloatArray) -> None:
    """Raise ModelError where a joint or drive at t = 0 is elsewhere: the first step would throw the bodies there."""
    model, names = source.model, source.layout.joints
    if not names:
        return
    external = np.zeros((source.n_external, 3))
    state = source.state(0.0, q, np.zeros_like(q))
    for callback in source.callbacks:
        callback.fill(0.0, state, external)
    off = np.abs(violation(model, q.copy(), np.zeros_like(q), external).position)
    worst = int(np.argmax(off / np.where(ANGULAR[model.joints.kind], 1.0, source.size)))
    angle = ANGULAR[model.joints.kind[worst]]
    if off[worst] > OFF * (1.0 if angle else source.size):
        name = names[int(np.searchsorted(model.joints.row, worst, side="right")) - 1]
        raise ModelError(
            f"initial: its state is off the joint {name!r} by {off[worst]:.4g} {'rad' if angle else 'm'} at t = 0, "
            "expected one that fulfils the joints: drives begin at their value at t = 0, whatever was before"
        )


def _refuse_overlap(source: CompiledScene, q: FloatArray, u: FloatArray) -> None:
    """Raise ModelError where bodies penetrate each other there: the start of the scene itself may be anywhere."""
    hard = {name for name, law in zip(source.layout.contacts, source.laws, strict=True) if law is None}
    external = np.zeros((source.n_external, 3))
    try:
        start_apart(source.model, source.layout, hard, q, u, external, source.size, False)
    except ModelError as error:
        raise ModelError(f"initial: at this place of rest {error}") from error


def _coordinates(source: Any, count: int | None = None) -> tuple[tuple[str, int], ...]:
    """Names of the bodies with how many coordinates each has; of a user's own system, how many there are."""
    layout = getattr(source, "layout", None)
    if layout is None:
        return (("q", len(source.q) if count is None else count),)
    return tuple(zip(layout.bodies, np.diff(source.model.bodies.dof).tolist(), strict=True))


def _listed(coordinates: tuple[tuple[str, int], ...]) -> str:
    words = ", ".join(f"{name} ({count})" for name, count in coordinates[:4])
    return words + (f" and {len(coordinates) - 4} more bodies" if len(coordinates) > 4 else "")


def _notes_at_rest(initial: Rest) -> list[str]:
    """That the run began there, and what is known of the place."""
    said = "the run began from a place of rest, without velocity"
    return [said if initial.stable else f"{said}, that is not stable: {'; '.join(initial.unstable)}"]


def _notes(source: Any, initial: Result, stepper: Stepper) -> list[str]:
    """That the run began there, and what is not carried over."""
    lost = [REMEMBERED.get(type(stepper).__name__, "what it remembers from step to step begins anew")]
    integrator = getattr(stepper, "integrator", None)
    adaptive = getattr(stepper, "adaptive", None) is not None
    if adaptive or (integrator is not None and not hasattr(integrator, "step")):
        lost.append("the length of its steps is chosen anew")
    closed = initial.state[-1] != 0
    if closed.any():
        named = ", ".join(name for name, shut in zip(initial.contact_names, closed, strict=True) if shut)
        lost.append(
            f"contacts that are closed ({named:.80}) count as closed anew: what they remember of their impact and of "
            "where they are held is lost"
        )
    lost = [words for words in lost if words]
    kept = "; ".join(lost) if lost else "its stepper remembers nothing else, and goes on as without a break"
    return [
        f"{CONTINUED}, at t = {float(initial.times[-1]):.9g} s there, and its time, "
        f"with loads and drives in time, at 0: of positions and velocities alone; {kept}"
    ]
