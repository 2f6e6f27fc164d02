"""Drift of closed contacts in space, taken out of the configuration after a step."""

from __future__ import annotations

from lcpflex.dynamics.spatial.inertia import SpatialWork
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.model.spatial import SpatialModel

__all__ = ["lift_island"]


@kernel
def lift_island(model: SpatialModel, work: SpatialWork, i: int, q: FloatArray) -> bool:
    """Lift the sunk contacts of island i; whether there were any, and it could be done."""
    return False
