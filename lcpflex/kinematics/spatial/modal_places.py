"""Where the modal coordinates of a spatial body begin: see :mod:`lcpflex.kinematics.modal_places`."""

from __future__ import annotations

from lcpflex.jit.kernel import kernel
from lcpflex.model.spatial import N_PLACE, N_RIGID, SpatialModel

__all__ = ["first_amplitude", "first_rate"]


@kernel
def first_amplitude(model: SpatialModel, b: int) -> int:
    """Of body b, the place of its first modal coordinate in q."""
    return model.bodies.place[b] + N_PLACE


@kernel
def first_rate(model: SpatialModel, b: int) -> int:
    """Of body b, the place of the rate of its first modal coordinate in u."""
    return model.bodies.dof[b] + N_RIGID
