"""Relative coordinates of a spatial scene with what they take from its start: axes at P, rest values."""

from __future__ import annotations

import numpy as np

from lcpflex.basics import libs
from lcpflex.bodies.placed_point import PlacedPoint
from lcpflex.compile.spatial.assembly import SpatialAssembly
from lcpflex.errors import ModelError
from lcpflex.kinematics.spatial.relative import Directions
from lcpflex.scene.spatial.angle import carried
from lcpflex.scene.spatial.axes import vector
from lcpflex.scene.spatial.relative import SpatialRelative, Way

__all__ = ["at_start", "directions_at"]


def at_start(
    name: str, of: SpatialRelative, P: PlacedPoint, Q: PlacedPoint, assembly: SpatialAssembly
) -> tuple[Directions, float]:
    """Directions and rest value of a coordinate.

    Raises ModelError for an angle that has no meaning because the axis is opposite in the axes of both bodies.
    """
    way = directions_at(name, of, P, Q, assembly)
    if of.rest is not None:
        return way, of.rest
    return way, 0.0 if of.kind == "angle" else assembly.value(of.kind, way, P, Q)


def directions_at(
    name: str, of: SpatialRelative, P: PlacedPoint, Q: PlacedPoint, assembly: SpatialAssembly
) -> Directions:
    """The directions of a coordinate; those at P that were not given are what coincides with their partners."""
    if of.on_p is not None:
        return Directions(of.axis, of.on_p, of.on_q)
    turn = assembly.turn(P, Q)
    if of.kind == "turn":
        rest = libs.Rotation.from_matrix(turn).as_rotvec()
        return Directions(of.axis, vector(rest), of.on_q)
    if of.kind == "angle" and of.rest is not None:
        return Directions(of.axis, _counted(name, of, vector(turn.T @ np.array(of.axis))), of.on_q)
    return Directions(of.axis, vector(turn.T @ np.array(of.like)), of.on_q)


def _counted(name: str, of: SpatialRelative, axis_p: Way) -> Way:
    """x_P of a relative angle: x_Q after the shortest rotation of the axis in one body to that in the other."""
    found = carried(of.like, of.axis, axis_p)
    if found is None:
        raise ModelError(
            f"{name}: angle: {of.rest:g} was given, but the axis points opposite ways in the axes of the two bodies, "
            "so that no relative angle is the zero, expected none: the angle is then counted from the start"
        )
    return found
