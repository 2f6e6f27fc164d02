"""Elastic bearing."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import chain
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from lcpflex.basics.arguments import array_of
from lcpflex.basics.options import is_number
from lcpflex.bodies.placed_point import PlacedPoint, check_pair
from lcpflex.errors import ModelError, shown
from lcpflex.scene.spatial.axes import BASIS, check_turns, vector
from lcpflex.scene.spatial.joints.joint import refuse_planar
from lcpflex.scene.spatial.keep import keep_orientation
from lcpflex.scene.spatial.relative import NOWHERE, SpatialRelative, SpatialResistance, Way

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

__all__ = ["Bushing"]

COEFFICIENTS = ("stiffness", "damping", "rotational_stiffness", "rotational_damping")


@dataclass(frozen=True, slots=True)
class Bushing:
    """Elastic bearing: springs and dampers along and about three axes that are fixed in the material at Q.

    With d_i = e_i.(r_P - r_Q) along the axes e_i, and theta the rotation vector that leads from the relative rotation
    without torque to that of now, seen along the same axes, the energy is

        E = sum_i k_i (d_i - offset_i)^2 / 2 + sum_i c_i theta_i^2 / 2,

    and the force and the torque on P and on Q are minus its gradients: exact for any rotation up to 170 degrees. A run
    that turns it further ends with an error.

    ``stiffness`` k [N/m], ``damping`` [N s/m], ``rotational_stiffness`` c [N m/rad] and ``rotational_damping``
    [N m s/rad], all >= 0: (3,), or a number for all three axes. ``axes``: a scipy Rotation, or a 3 x 3 matrix whose
    columns are the e_i in the axes of the body of Q (world axes on the ground), which they are if omitted.
    ``offset`` (3,) [m] and ``orientation`` (a Rotation or a matrix, A_Q^T A_P) have no force and no torque; those of
    the start if omitted. Raises ModelError for points or numbers that cannot be.
    """

    P: PlacedPoint
    Q: PlacedPoint
    stiffness: npt.ArrayLike = 0.0
    rotational_stiffness: npt.ArrayLike = 0.0
    damping: npt.ArrayLike = 0.0
    rotational_damping: npt.ArrayLike = 0.0
    axes: Rotation | npt.ArrayLike | None = None
    offset: npt.ArrayLike | None = None
    orientation: Rotation | npt.ArrayLike | None = None

    def __post_init__(self) -> None:
        check_pair("Bushing", self.P, self.Q)
        if not self.P.in_space:
            refuse_planar(self)
        for name in COEFFICIENTS:
            object.__setattr__(self, name, _three(f"Bushing: {name}", getattr(self, name)))
        if self.offset is not None:
            object.__setattr__(self, "offset", vector(array_of("Bushing: offset", self.offset, (3,))))
        keep_orientation(self, "axes")
        if self.axes is None:
            object.__setattr__(self, "axes", BASIS)
        keep_orientation(self)
        check_turns(self, tuple(form.coordinate for form in self.spatial_forms()))

    def spatial_forms(self) -> tuple[SpatialResistance, ...]:
        """The coordinates that resist, without those that do not."""
        ways = [vector(column) for column in np.transpose(self.axes)]  # type: ignore[arg-type]  # kept as a matrix
        k, d, c, e = (getattr(self, name) for name in COEFFICIENTS)
        rests = (None, None, None) if self.offset is None else self.offset
        theta = None if self.orientation is None else _rotation_vector(self.orientation)  # type: ignore[arg-type]
        moved = (SpatialRelative("along", way, rest=rest) for way, rest in zip(ways, rests, strict=True))  # type: ignore[arg-type]
        turned = (SpatialRelative("turn", way, on_p=theta, like=NOWHERE) for way in ways)
        every = zip(chain(moved, turned), (*k, *c), (*d, *e), strict=True)
        return tuple(SpatialResistance(*one) for one in every if one[1] or one[2])


def _three(name: str, given: npt.ArrayLike) -> Way:
    """A coefficient for each axis."""
    values = array_of(name, [given] * 3 if is_number(given) else given, (3,))
    if (values < 0.0).any():
        raise ModelError(f"{name}: {shown(given)} was given, expected numbers >= 0")
    return vector(values)


def _rotation_vector(matrix: npt.ArrayLike) -> Way:
    """The rotation vector of a matrix [rad]."""
    from scipy.spatial.transform import Rotation

    return vector(Rotation.from_matrix(np.asarray(matrix)).as_rotvec())
