"""Directions of joints and springs in space, and the relative coordinates that axes and frames are held by.

An axis z comes with two more, x and y, right-handed. Two axes are parallel where z_P.x_Q = z_P.y_Q = 0; a rotation is
held by x_P.y_Q = y_P.z_Q = z_P.x_Q = 0 (Haug, Computer Aided Kinematics and Dynamics of Mechanical Systems, 1989).
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from lcpflex.basics.arguments import array_of
from lcpflex.errors import ModelError, shown
from lcpflex.jit.kernel import FloatArray
from lcpflex.model.coordinates import is_angular
from lcpflex.scene.spatial.orientation import matrix_of
from lcpflex.scene.spatial.relative import SpatialRelative, Way

__all__ = [
    "BASIS",
    "COINCIDENCE",
    "across",
    "axes_of",
    "check_turns",
    "locked",
    "off_line",
    "parallel",
    "vector",
    "way_of",
]

BASIS: tuple[Way, Way, Way] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
COINCIDENCE = tuple(SpatialRelative("component", axis) for axis in BASIS)  # r_P - r_Q = 0


def vector(numbers: FloatArray) -> Way:
    """Three numbers as floats of Python."""
    x, y, z = (float(number) for number in numbers)
    return x, y, z


def way_of(name: str, axis: npt.ArrayLike) -> Way:
    """``axis`` as a unit vector; raises ModelError for what is none."""
    given = array_of(name, axis, (3,))
    if not given.any():
        raise ModelError(f"{name}: {shown(axis)} was given, expected a direction (x, y, z), not all 0")
    scaled = given / np.abs(given).max()
    return vector(scaled / np.linalg.norm(scaled))


def across(axis: Way) -> tuple[Way, Way]:
    """x and y with x x y = axis, of a unit vector: x lies across the direction of the world that is least along it."""
    z = np.array(axis)
    x = np.cross(np.eye(3)[int(np.argmin(np.abs(z)))], z)
    x /= np.linalg.norm(x)
    return vector(x), vector(np.cross(z, x))


def parallel(axis: Way, axis_p: Way | None) -> tuple[SpatialRelative, ...]:
    """An axis at P stays parallel to one at Q (2 rows); ``axis_p`` None: what coincides with it at the start."""
    return tuple(SpatialRelative("perpendicular", side, on_p=axis_p, like=axis) for side in across(axis))


def axes_of(name: str, orientation: Any) -> tuple[Way, Way, Way] | None:
    """The rows of a relative orientation (3, 3); None for that of the start."""
    if orientation is None:
        return None
    x, y, z = (vector(row) for row in matrix_of(name, orientation))
    return x, y, z


def locked(orientation: npt.ArrayLike | None) -> tuple[SpatialRelative, ...]:
    """The axes at P keep their rotation against those at Q (3 rows): A_Q^T A_P = ``orientation``."""
    x, y, z = BASIS

    def at_p(axis: Way) -> Way | None:
        return None if orientation is None else vector(np.asarray(orientation).T @ axis)

    return tuple(
        SpatialRelative("perpendicular", side, on_p=at_p(axis), like=axis) for axis, side in ((x, y), (y, z), (z, x))
    )


def off_line(axis: Way) -> tuple[SpatialRelative, ...]:
    """P stays on the line along an axis through Q (2 rows)."""
    return tuple(SpatialRelative("along", side) for side in across(axis))


def check_turns(part: Any, coordinates: tuple[SpatialRelative, ...]) -> None:
    """Refuse points whose rotation is not known, as of nodes on one line, where the part asks for it."""
    owner = type(part).__name__
    kinds = {coordinate.kind for coordinate in coordinates}
    turns = any(map(is_angular, kinds))
    for argument, asked in (("P", turns), ("Q", turns or "along" in kinds)):
        point = getattr(part, argument)
        if asked and not point.material.turns:
            raise ModelError(
                f"{owner}: {argument}: {point.label} was given, whose nodes lie on one line and tell no rotation about "
                "it, expected nodes that span a surface, or a joint that leaves all rotations free, such as Ball"
            )
