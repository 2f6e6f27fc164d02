"""Checks of joints that there are in space only."""

from __future__ import annotations

from typing import Any

from lcpflex.errors import ModelError
from lcpflex.scene.joints.joint import check_joint
from lcpflex.scene.spatial.axes import check_turns
from lcpflex.scene.spatial.keep import keep_axes

__all__ = ["check_spatial_joint", "refuse_planar"]


def check_spatial_joint(joint: Any, names: tuple[str, ...] = (), needed: tuple[str, ...] = ()) -> None:
    """Points of two bodies of a spatial scene, a name that is one, and directions kept as unit vectors."""
    if check_joint(joint):
        keep_axes(joint, names, needed)
        check_turns(joint, joint.spatial_rows())
    else:
        refuse_planar(joint)


def refuse_planar(part: Any) -> None:
    """Raise ModelError for a point of a planar scene."""
    owner = type(part).__name__
    raise ModelError(f"{owner}: P: {part.P.label} is a point of a planar scene, expected one of a SpatialScene")
