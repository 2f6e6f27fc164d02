"""What functions of a user's gave at the stored instants, so that stresses of a result from a file count with them.

A file keeps no functions. What recovers stresses asks them at the stored instants alone: their values there stand in
the place of values from outside (:class:`lcpflex.model.arrays.Signals`, kind 2), to the same bits.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from lcpflex.dynamics.time_functions import COMPILED, EXTERNAL
from lcpflex.errors import ModelError
from lcpflex.jit.struct import pack
from lcpflex.kinematics.signal_values import signal_value
from lcpflex.model.arrays import frozen
from lcpflex.model.recovery import small_enough
from lcpflex.results.acting_forces import ActingForces
from lcpflex.results.section_forces import mean_step

if TYPE_CHECKING:
    from lcpflex.compile.compiled_scene import CompiledScene
    from lcpflex.jit.kernel import FloatArray, IntArray
    from lcpflex.results.result import Result
    from lcpflex.results.spatial.acting_forces import SpatialActingForces

__all__ = ["with_values", "without_functions"]


def with_values(result: Result) -> Result:
    """The result with the values of its functions, where its scene has some, and bodies whose stresses are known.

    Where a function fails now, all stays as it is: a file then refuses to tell stresses.
    """
    compiled = result.compiled
    if compiled is None or compiled.functions_are_lost or not any(one is not None for one in compiled.recovery):
        return result
    own = np.flatnonzero(compiled.model.signals.kind == COMPILED)
    if not compiled.callbacks and not len(own):
        return result
    try:
        values = _values(result, compiled, own)
    except ModelError:
        return result
    signals = compiled.model.signals
    kind, first = signals.kind.copy(), signals.first.copy()
    kind[own], first[own] = EXTERNAL, compiled.n_external + np.arange(len(own))
    told = signals._replace(kind=frozen(kind, np.int64), first=frozen(first, np.int64), address=frozen([], np.int64))
    model = compiled.model._replace(signals=told)
    kept = replace(compiled, model=model, n_external=values.shape[1], callbacks=(), functions=())
    return replace(result, compiled=kept, outside=values)


def without_functions(result: Result) -> Result:
    """What a file can hold of a result: values in the place of functions, no force laws, no large matrices."""
    told = with_values(result)
    kept = told.compiled
    if kept is None:
        return replace(told, origin=None)
    lost = kept.laws_are_lost or any(law is not None for law in kept.laws)
    bare = replace(kept, callbacks=(), materials=None, functions=(), laws=(None,) * len(kept.laws), sensors=())
    bare = replace(bare, recovery=small_enough(kept.recovery), laws_are_lost=lost)
    return replace(told, compiled=bare, origin=None)


def _acting(compiled: CompiledScene, step: float) -> ActingForces | SpatialActingForces:
    if compiled.spatial:
        from lcpflex.results.spatial.acting_forces import SpatialActingForces

        return SpatialActingForces(compiled, step)
    return ActingForces(compiled, step)


def _values(result: Result, compiled: CompiledScene, own: IntArray) -> FloatArray:
    """(m, slots, 3) value, rate and acceleration: of Python functions, then of the compiled ones ``own``."""
    acting = _acting(compiled, mean_step(result))
    signals = pack(compiled.model.signals)
    values = np.zeros((len(result.times), compiled.n_external + len(own), 3))
    for k, t in enumerate(result.times.tolist()):
        u = result.u[k].copy()
        u[acting.still] = 0.0
        values[k, : compiled.n_external] = acting.outside(k, t, result.q[k], u)
        for row, index in enumerate(own.tolist()):
            values[k, compiled.n_external + row] = signal_value(signals, index, t, values[k])
    return values
