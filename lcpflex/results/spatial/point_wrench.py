"""Forces and moments on the material of bodies in space."""

from __future__ import annotations

from typing import NamedTuple, TypeAlias

import numpy as np

from lcpflex.jit.kernel import FloatArray
from lcpflex.model.spatial import SpatialPoints

__all__ = ["PointWrench", "Where", "place_of"]

# a material point by its number, or by its undeformed place in the frame of its body, where the model has not got it
Where: TypeAlias = "int | tuple[float, float, float]"


class PointWrench(NamedTuple):
    """Forces and moments on the material of a body at a point, or between some as weights say: a generalised force."""

    body: int
    points: tuple[tuple[Where, float], ...]  # material points and their weights, of sum 1
    block: FloatArray  # (6 + n,) force, world axes [N]; moment about the origin of its frame, body axes [N m]; modal


def place_of(points: SpatialPoints, where: Where) -> FloatArray:
    """(3,) undeformed, in the frame of its body [m]."""
    return np.asarray(points.place[where] if isinstance(where, int) else where)
