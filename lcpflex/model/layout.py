"""How many numbers the parts of a configuration and of a velocity have: in the plane, and in space."""

from __future__ import annotations

from typing import Any, NamedTuple

from lcpflex.jit.kernel import IntArray
from lcpflex.model import planar, spatial

__all__ = ["PLANE", "SPACE", "Dimension", "dimension", "is_spatial", "place_offsets", "sums_of_contacts"]


class Dimension(NamedTuple):
    """Numbers of a rigid body in q and in u, and components of a place."""

    places: int  # of a body in q before its modal coordinates
    rigid: int  # in u before their rates
    components: int  # of a place


PLANE = Dimension(planar.N_RIGID, planar.N_RIGID, 2)
SPACE = Dimension(spatial.N_PLACE, spatial.N_RIGID, 3)


def dimension(bodies: Any) -> Dimension:
    """Of the bodies of a model; PLANE, where q has no angles, of a user's own system, which has none."""
    return SPACE if hasattr(bodies, "centred") and len(bodies.mass) else PLANE


def is_spatial(model: Any) -> bool:
    """Whether the bodies of a model move in space, or the contacts of a user's own system slide in planes."""
    return hasattr(model.bodies, "centred")


def place_offsets(bodies: Any) -> IntArray:
    """(nb + 1,) offsets of the bodies into q."""
    offsets: IntArray = getattr(bodies, "place", bodies.dof)
    return offsets


def sums_of_contacts(model: Any) -> int:
    """What is summed up of a declared contact: its normal forces and its friction, in space as a vector."""
    return 4 if is_spatial(model) else 2
