"""Generalised forces of springs, dampers, forces and torques in space: none yet, NaN where there are some."""

from __future__ import annotations

import math

from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.model.spatial import SpatialModel

__all__ = ["applied_forces", "spring_energy"]


@kernel
def applied_forces(
    model: SpatialModel,
    t: float,
    q: FloatArray,
    u: FloatArray,
    span: FloatArray,
    external: FloatArray,
    conservative: FloatArray,
    dissipative: FloatArray,
    driving: FloatArray,
) -> None:
    """Add the generalised forces of springs, of dampers, and of forces and torques at time t, each (nu,)."""
    if len(model.loads.spring_kind) + len(model.loads.force_kind) > 0:
        for i in range(len(driving)):
            driving[i] = math.nan


@kernel
def spring_energy(model: SpatialModel, q: FloatArray) -> float:
    """Energy of all springs [J]."""
    return 0.0 if len(model.loads.spring_kind) == 0 else math.nan
