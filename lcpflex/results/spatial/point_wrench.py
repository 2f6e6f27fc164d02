"""Forces and moments on the material of bodies in space."""

from __future__ import annotations

from typing import NamedTuple

from lcpflex.jit.kernel import FloatArray

__all__ = ["PointWrench"]


class PointWrench(NamedTuple):
    """Forces and moments on the material of a body at a point, or between some as weights say: a generalised force."""

    body: int
    points: tuple[tuple[int, float], ...]  # material points and their weights, of sum 1
    block: FloatArray  # (6 + n,) force, world axes [N]; moment about the origin of its frame, body axes [N m]; modal
