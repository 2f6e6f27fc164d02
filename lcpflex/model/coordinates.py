"""The kinds of relative coordinates of two points, in one table: what joints prescribe, and what springs resist.

Scenes name a kind, compiled arrays hold its place in the table. Value, gradient and bias of each are a branch of
:mod:`lcpflex.kinematics.relative` in the plane, of :mod:`lcpflex.kinematics.spatial.relative` in space; what a kind
looks like to anybody else is a column here, so that a new one is a line and its branches.
"""

from __future__ import annotations

from typing import NamedTuple

from lcpflex.model.arrays import frozen

__all__ = [
    "ALONG",
    "ANGLE",
    "ANGULAR",
    "COMPONENT",
    "COORDINATES",
    "DISTANCE",
    "KINDS",
    "PERPENDICULAR",
    "SPATIAL_KINDS",
    "TURN",
    "UNITS",
    "Coordinate",
    "is_angular",
]


class Coordinate(NamedTuple):
    """A kind of relative coordinate."""

    name: str
    unit: str
    angular: bool  # what prescribes one makes a moment alone, what prescribes another a force
    in_space_alone: bool = False  # these come last: numbers of the others are the same in the plane and in space


COORDINATES = (
    Coordinate("component", "m", angular=False),
    Coordinate("along", "m", angular=False),
    Coordinate("angle", "rad", angular=True),
    Coordinate("distance", "m", angular=False),
    Coordinate("perpendicular", "rad", angular=True, in_space_alone=True),  # a sine: of an angle, where it is small
    Coordinate("turn", "rad", angular=True, in_space_alone=True),
)
COMPONENT, ALONG, ANGLE, DISTANCE, PERPENDICULAR, TURN = range(len(COORDINATES))

SPATIAL_KINDS = tuple(kind.name for kind in COORDINATES)
KINDS = tuple(kind.name for kind in COORDINATES if not kind.in_space_alone)  # of the plane
UNITS = tuple(kind.unit for kind in COORDINATES)
ANGULAR = frozen([kind.angular for kind in COORDINATES], bool)  # by the numbers that compiled arrays hold


def is_angular(name: str) -> bool:
    """Whether the kind that a scene names so is."""
    return COORDINATES[SPATIAL_KINDS.index(name)].angular
