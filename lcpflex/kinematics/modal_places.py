"""Where the modal coordinates of a body begin, in q and in u: in the plane at the same place."""

from __future__ import annotations

from lcpflex.jit.kernel import kernel
from lcpflex.jit.leaf import in_space
from lcpflex.model.arrays import Model
from lcpflex.model.planar import N_RIGID

__all__ = ["first_amplitude", "first_mode", "first_rate"]


@in_space("lcpflex.kinematics.spatial.modal_places")
@kernel
def first_amplitude(model: Model, b: int) -> int:
    """Of body b, the place of its first modal coordinate in q."""
    return model.bodies.dof[b] + N_RIGID


@in_space("lcpflex.kinematics.spatial.modal_places")
@kernel
def first_rate(model: Model, b: int) -> int:
    """Of body b, the place of the rate of its first modal coordinate in u."""
    return model.bodies.dof[b] + N_RIGID


@kernel
def first_mode(model: Model, b: int) -> int:
    """Of body b, the place of its first mode among those of all bodies."""
    first = first_rate(model, b)
    return first - (first - model.bodies.dof[b]) * (b + 1)
