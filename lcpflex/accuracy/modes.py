"""What twice as many modes change of a run: whether its steps or its modes err more."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from lcpflex.accuracy.apart import apart
from lcpflex.accuracy.comparison import grid_of
from lcpflex.accuracy.reruns import Finished, rerun, unsensed
from lcpflex.accuracy.richer import richer
from lcpflex.errors import LcpflexError
from lcpflex.model.layout import dimension
from lcpflex.results.measured_error import Rerun
from lcpflex.runs.setup import compiled_for

if TYPE_CHECKING:
    from lcpflex.jit.kernel import FloatArray
    from lcpflex.results.result import Result
    from lcpflex.runs.origin import Origin

__all__ = ["ModeError", "mode_error"]

FACTOR = 2.0  # over 60 scenes 2.0 [1.6, 2.2] times the truth, below it in 10 %; half as many modes: below in 33 %
MORE = 4.0  # times the steps of the run that one with more modes may take: event-driven ones follow the fastest mode


class ModeError(NamedTuple):
    """Of a run whose bodies are reduced; None and a reason where it is not known."""

    off: float | None  # twice the largest change of a place [m]
    note: str
    rerun: Rerun | None = None
    times: FloatArray | None = None
    curve: FloatArray | None = None  # of it over time [m]


def mode_error(result: Result, origin: Origin, until: float, interval: float) -> ModeError | None:
    """By how much twice as many modes move the bodies of a run; None where no body has modes."""
    compiled = result.compiled
    if compiled is None or not len(compiled.model.bodies.mass):
        return None
    bodies = compiled.model.bodies
    if int(bodies.dof[-1]) == len(bodies.mass) * dimension(bodies).rigid:
        return None
    if origin.scene is None:
        return ModeError(None, "what more modes would change is not known: the scene is not at hand")
    if origin.options.notes:
        return ModeError(None, "what more modes would change is not known: the run began from the state of another")
    try:
        scene, unknown = richer(origin.scene)
        if scene is origin.scene:
            words = f"of {', '.join(map(repr, unknown))} no more modes are known" if unknown else ""
            return ModeError(None if unknown else 0.0, words or "all modes of the meshes are there")
        source = compiled_for(scene, origin.stepper, origin.options.project)
        other = unsensed(replace(origin, source=source, scene=scene))
        found = rerun(other, origin.stepper, "twice as many modes", FACTOR, until, interval, MORE * result.steps)
        if not isinstance(found, Finished):
            return ModeError(None, f"with twice as many modes: {found}")
        at = result.times[grid_of(result, found.told.until)]
        off = apart(result, found.result, at)
    except LcpflexError as error:
        return ModeError(None, f"what more modes would change is not known: {error}")
    note = f"with twice as many modes it came to {found.told.until:.4g} s" if found.told.ended else ""
    if unknown:
        note += f"{'; ' if note else ''}of {', '.join(map(repr, unknown))} no more modes are known"
    # watched points at the ends of a body turn with it: a rotation is in their places
    curve = FACTOR * np.maximum(off.place, off.turn).max(axis=1, initial=0.0)
    return ModeError(float(curve.max(initial=0.0)), note, found.told, at, curve)
