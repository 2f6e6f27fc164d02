"""Going on with a run from a checkpoint."""

from __future__ import annotations

import os
from dataclasses import is_dataclass, replace
from typing import TYPE_CHECKING, Any

from lcpflex.basics.arguments import optional_flag
from lcpflex.compile.compiled_scene import CompiledScene
from lcpflex.dynamics.time_structure import with_signals
from lcpflex.errors import ModelError, shown
from lcpflex.runs.checkpoint import Checkpoint, Checkpoints, given_again, read
from lcpflex.runs.object_tree import Arrays
from lcpflex.runs.request import checked_budget
from lcpflex.runs.setup import Options, Stepper, compiled_for, set_up
from lcpflex.runs.simulate import carry_out
from lcpflex.runs.stamp import difference, functions_of, made, plain, scene_node, stepper_node
from lcpflex.scene.user_system import UserSystem

if TYPE_CHECKING:
    from lcpflex.results.problem_log import RecordProblems
    from lcpflex.results.result import Result
    from lcpflex.scene.scene import Scene

__all__ = ["resume"]


def resume(
    path: str | os.PathLike[str],
    scene: Scene | UserSystem | None = None,
    stepper: Stepper | None = None,
    *,
    progress: bool | None = None,
    record_problems: RecordProblems | None = None,
    budget: float | None = None,
) -> Result:
    """Go on with a run that ``simulate(..., checkpoint=path)`` began, and end with the bits it would have ended with.

    The file is all that is needed, unless the scene or the stepper holds Python functions (loads and motions in Python,
    force laws or solvers of one's own, a :class:`UserSystem`), which no file can hold: these must be given again, and
    be the same; what a function keeps to itself from call to call is not known here. Further checkpoints are written to
    the same file. The timings of the result are those of all parts of the run. A run that had come to its end gives its
    result at once.

    Parameters
    ----------
    path
        The checkpoint.
    scene, stepper
        As the run began with; refused if they differ from what the checkpoint tells of them.
    progress
        As for :func:`simulate`.
    record_problems
        To be given again where the run records contact problems, with a path for this file.
    budget
        As for :func:`simulate`, of this part of the run.

    Returns
    -------
    Result
        As of :func:`simulate`. Where numpy, scipy, numba or Python are others than those that the run began with, its
        notes say that bits may be others, too.

    Raises
    ------
    ModelError
        For a file that is no checkpoint or is damaged; for one of another version of lcpflex; for a scene or a stepper
        that is missing or another one.
    StepError
        As of :func:`simulate`.
    """
    progress, budget = optional_flag("progress", progress), checked_budget(budget)
    kept = read(path)
    notes = _versions(kept)
    given = _stepper(kept, stepper)
    options: Options = kept.thawed("options")
    if not isinstance(options, Options) or not callable(getattr(given, "start", None)):
        raise kept.damaged(ValueError("other entries than expected"))
    if options.records_problems != (record_problems is not None):
        wanted = "RecordProblems(path, ...), as the run began with" if options.records_problems else "None"
        raise ModelError(f"record_problems: {shown(record_problems)} was given, expected {wanted}")
    source = _source(kept, scene, given, options)
    setup = set_up(source, given, replace(options, notes=(*options.notes, *notes)), record_problems)
    return carry_out(setup, progress, Checkpoints(path, options.every), kept, budget)


def _versions(kept: Checkpoint) -> tuple[str, ...]:
    """A note where what bits depend on is of another version; ModelError where lcpflex is."""
    was, now = kept.structure["made"], made()
    if not isinstance(was, dict) or was.keys() != now.keys():
        raise kept.damaged(ValueError("other entries than expected"))
    if (was["lcpflex"], was["sources"]) != (now["lcpflex"], now["sources"]):
        sources = ", of other sources" if was["lcpflex"] == now["lcpflex"] else ""
        raise ModelError(
            f"path: {shown(kept.path)} was written by lcpflex {was['lcpflex']!s:.40}{sources}, expected "
            f"{now['lcpflex']}, which is running: what a run remembers may be another thing there"
        )
    others = [f"{name} {now[name]} after {was[name]!s:.20}" for name in now if was[name] != now[name]]
    if not others:
        return ()
    return (f"the run was resumed with {', '.join(others)}: its last bits may be others than without a break",)


def _stepper(kept: Checkpoint, given: Stepper | None) -> Any:
    """The stepper of the run."""
    missing = kept.structure["missing"]
    if given is None:
        if "stepper" in missing:
            raise given_again(missing, kept.path, "stepper")
        found = kept.thawed("stepper")
        if not is_dataclass(found) or isinstance(found, type):
            raise kept.damaged(ValueError("other entries than expected"))
        return replace(found)  # its numbers are checked as any others
    if isinstance(given, type) or not callable(getattr(given, "start", None)):
        raise ModelError(
            f"stepper: {shown(given)} was given, expected a stepper such as MoreauJean(step=1e-4), or None"
        )
    arrays: Arrays = {}
    node, why = stepper_node(given, arrays)
    if why or "stepper" in missing:
        differs = "" if plain(repr(given)) == kept.structure["stamp"]["stepper"] else "its text"
    else:
        differs = difference(kept.structure["stepper"], node, kept.arrays, arrays, "stepper")
    if differs:
        raise ModelError(
            f"stepper: {plain(repr(given))[:120]} was given, expected that of the checkpoint, "
            f"{kept.structure['stamp']['stepper'][:120]}: {differs} differs"
        )
    return given


def _source(kept: Checkpoint, scene: Scene | UserSystem | None, stepper: Stepper, options: Options) -> Any:
    """The compiled scene of the run, or the user's own system."""
    if scene is None:
        if "scene" in kept.structure["missing"]:
            raise given_again(kept.structure["missing"], kept.path, "scene")
        found = kept.thawed("scene")
        if not isinstance(found, CompiledScene):
            raise kept.damaged(ValueError("other entries than expected"))
        return found
    given = compiled_for(scene, stepper, options.project, options.project)
    arrays: Arrays = {}
    node, _ = scene_node(_at_start(given, kept), arrays)
    if differs := difference(kept.structure["scene"], node, kept.arrays, arrays, "scene"):
        raise ModelError(f"scene: another one was given than the run began with: {differs} differs")
    stamped, now = kept.structure["stamp"]["functions"], functions_of(given)
    if kept.structure["made"]["python"] == made()["python"]:
        others = sorted(name for name in stamped.keys() | now.keys() if stamped.get(name) != now.get(name))
        if others:
            raise ModelError(f"scene: other functions were given than the run began with: {', '.join(others)[:120]}")
    if isinstance(given, UserSystem):
        return given
    stored: CompiledScene = kept.thawed("scene")
    model = with_signals(stored.model, address=given.model.signals.address)
    parts = {
        name: getattr(given, name) for name in ("callbacks", "functions", "materials", "laws", "recovery", "sensors")
    }
    return replace(stored, model=model, **parts)  # the arrays to the last bit: a scene reduced anew may differ there


def _at_start(given: CompiledScene | UserSystem, kept: Checkpoint) -> Any:
    """``given`` from the state that the run began from, which may be that of a result."""
    stored = kept.thawed("scene") if isinstance(kept.structure["scene"], dict) else None
    if stored is None or not kept.thawed("options").notes:
        return given
    state = {name: stored[name] if isinstance(stored, dict) else getattr(stored, name) for name in ("q", "u")}
    return replace(given, **state)
