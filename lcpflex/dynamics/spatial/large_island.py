"""Islands of many contacts in space."""

from __future__ import annotations

from lcpflex.dynamics.spatial.inertia import SpatialWork
from lcpflex.jit.kernel import kernel
from lcpflex.model.spatial import SpatialModel

__all__ = ["prepare_large"]


@kernel
def prepare_large(model: SpatialModel, work: SpatialWork) -> None:
    """Nothing is prepared: rows are taken as they are."""
