"""How far about the predicted configuration contacts of the massless-boundary scheme are looked for."""

from __future__ import annotations

from lcpflex.dynamics.position import static_sway
from lcpflex.dynamics.workspace import Workspace
from lcpflex.jit.kernel import kernel
from lcpflex.jit.leaf import in_space
from lcpflex.model.arrays import Model
from lcpflex.steppers.massless_boundary.memory import BoundaryScheme

__all__ = ["has_strayed", "look_around"]


@in_space("lcpflex.steppers.spatial.massless_reach")
@kernel
def look_around(model: Model, scheme: BoundaryScheme, work: Workspace) -> float:
    """How far the static coordinates of ``work.free.middle``, which are predicted, may be from the solution [m].

    In the plane whatever they are: as far as they go by themselves.
    """
    deflection = static_sway(model, scheme.flexibility, scheme.q)
    return deflection + static_sway(model, scheme.flexibility, work.free.middle)


@in_space("lcpflex.steppers.spatial.massless_reach")
@kernel
def has_strayed(model: Model, scheme: BoundaryScheme, work: Workspace) -> bool:
    """Whether the solution of the contact problem is farther away than contacts were looked for: in the plane never."""
    return False
