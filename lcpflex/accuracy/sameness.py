"""Whether what is run again is what was run: the scene at hand, its stepper, and functions that answer as they did."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np

from lcpflex.compile.compiled_scene import CompiledScene
from lcpflex.errors import LcpflexError, ModelError, shown
from lcpflex.results.contact_windows import STEPS
from lcpflex.results.energy_balance import EnergyGrowth
from lcpflex.results.result import Result
from lcpflex.runs.origin import Origin
from lcpflex.runs.request import stored_interval
from lcpflex.runs.setup import Options, compiled_for, set_up
from lcpflex.runs.simulate import carry_out

__all__ = ["origin_of", "refuse_others"]

FIRST = 3  # stored instants that must come out as they did
LOOK = 2000  # steps in which they are looked for
ROUNDING = 1e-9  # of the largest number: another machine rounds differently


def origin_of(result: Result, scene: Any, stepper: Any) -> Origin:
    """What to run again: that of the result, or of a loaded one what is given."""
    if result.origin is not None and scene is None and stepper is None:
        found: Origin = result.origin
        return found
    own = None if result.origin is None else result.origin.stepper
    stepper = own if stepper is None else stepper
    if stepper is None:
        raise ModelError(
            f"stepper: None was given for a result of a file, expected the one it was run with, {result.stepper[:200]}"
        )
    if isinstance(stepper, type) or not callable(getattr(stepper, "start", None)) or repr(stepper) != result.stepper:
        raise ModelError(
            f"stepper: {shown(stepper)} was given, expected the one it was run with, {result.stepper[:200]}"
        )
    source = _stored(result) if scene is None else _given(result, scene, stepper)
    interval = stored_interval(0.0 if result.stored == STEPS else None, result.duration, stepper)
    options = Options(result.duration, interval, False, EnergyGrowth.WARN)
    return Origin(source, stepper, options, scene)


def _stored(result: Result) -> CompiledScene:
    """The scene that a file holds."""
    kept = result.compiled
    if kept is None:
        raise ModelError("scene: None was given for a system of the user's own, expected its UserSystem")
    lost = kept.laws_are_lost or (kept.n_external and not kept.callbacks) or len(kept.model.signals.address)
    if result.origin is None and lost:
        raise ModelError(
            "scene: None was given for a result of a file, which keeps no functions and laws, expected its scene"
        )
    return kept


def _given(result: Result, scene: Any, stepper: Any) -> Any:
    """A scene compiled anew, at the state that the result began from."""
    source = compiled_for(scene, stepper, True)
    numbers = np.asarray(source.q).size
    if numbers != result.q.shape[1] or np.asarray(source.u).size != result.u.shape[1]:
        raise ModelError(
            f"scene: one with {numbers} coordinates was given, expected the one of the result, with {result.q.shape[1]}"
        )
    q, u = result.q[0].copy(), result.u[0].copy()
    if isinstance(source, CompiledScene):
        q.setflags(write=False)
        u.setflags(write=False)
    return replace(source, q=q, u=u)


def refuse_others(result: Result, origin: Origin) -> None:
    """Run the first instants once more. Raises ModelError where they come out otherwise.

    A function with a memory, or with chance in it, cannot be called again as if nothing had been; nor is a scene that
    was given for a loaded result always the one that was run.
    """
    if not _may_differ(result, origin):
        return
    try:
        options = replace(origin.options, records_problems=False, choice=None)
        again = carry_out(set_up(origin.source, origin.stepper, options, None), False, most=LOOK)
    except LcpflexError as error:
        if not isinstance(partial := getattr(error, "result", None), Result):
            raise ModelError(f"verify: run again, it fails at once ({error}); the run did not") from error
        again = partial
    count = min(FIRST, len(again.times), len(result.times))
    for k in range(count):
        for name in ("times", "q", "u"):
            one, other = np.atleast_1d(getattr(result, name)[k]), np.atleast_1d(getattr(again, name)[k])
            largest = float(np.abs(getattr(result, name)[: k + 1]).max(initial=0.0))
            off = float(np.abs(one - other).max(initial=0.0))
            if not off <= ROUNDING * largest + math.ulp(0.0):
                raise ModelError(
                    f"verify: run again, {name} at t = {result.times[k]:.6g} s is off by {off:.3g}: a function of the "
                    "scene or of the stepper answers otherwise than in the run, or another scene was given; expected "
                    "functions that answer the same when they are asked the same"
                )


def _may_differ(result: Result, origin: Origin) -> bool:
    """Whether functions of the user are asked, or the scene was given by hand."""
    source = origin.source
    if result.origin is not origin or not isinstance(source, CompiledScene):
        return True
    own_solver = type(getattr(origin.stepper, "solver", None)).__module__.partition(".")[0] not in (
        "lcpflex",
        "builtins",
    )
    return bool(source.callbacks or source.functions or any(law is not None for law in source.laws) or own_solver)
