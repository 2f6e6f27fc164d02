"""Joints between two material points P and Q of bodies, flexible ones included, or between a body and the ground.

The angle of the material at a point is that of its body plus the rotation of its mode shapes there; an axis is fixed in
the material at Q, in the axes of the body of Q (world axes on the ground). The constraints phi(q, t) = 0 and
their rows are in :mod:`lcpflex.kinematics.joint_rows`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from lcpflex.basics.options import is_number, keep_number
from lcpflex.bodies.body import array_of
from lcpflex.bodies.placed_point import PlacedPoint, check_pair
from lcpflex.errors import ModelError, shown
from lcpflex.scene.loads import Motion, checked_motion

__all__ = [
    "Distance",
    "DrivenAngle",
    "DrivenDisplacement",
    "Joint",
    "JointForm",
    "PointOnLine",
    "Prismatic",
    "Revolute",
    "Weld",
]

REVOLUTE, WELD, PRISMATIC, POINT_ON_LINE, DISTANCE, DRIVEN_ANGLE, DRIVEN_DISPLACEMENT = range(7)


@dataclass(frozen=True, slots=True)
class JointForm:
    """What the kernels need of a joint; a rest angle or length of None is that of the start configuration."""

    kind: int
    rows: tuple[str, ...]  # units of the rows
    angle: float | None = 0.0  # [rad]
    axis: tuple[float, float] = (1.0, 0.0)
    length: float | None = 0.0  # [m]
    motion: Motion | None = None


def _check(joint: Any) -> None:
    """Points on two bodies, and a name that is one."""
    owner = type(joint).__name__
    check_pair(owner, joint.P, joint.Q)
    if joint.P.body == joint.Q.body:
        raise ModelError(
            f"{owner}: {joint.P.label} and {joint.Q.label} are points of the same body, expected points of two bodies"
        )
    if not isinstance(joint.name, str):
        raise ModelError(f"{owner}: name: {shown(joint.name)} was given, expected a text")


def _keep_angle(joint: Any) -> None:
    """Keep the rest angle as a float, unless it is None."""
    if joint.angle is not None:
        keep_number(joint, "angle", -math.inf, math.inf, label=f"{type(joint).__name__}: angle")


def _unit(owner: str, axis: npt.ArrayLike) -> tuple[float, float]:
    """``axis`` as a unit vector."""
    vector = array_of(f"{owner}: axis", axis, (2,))
    if not vector.any():
        raise ModelError(f"{owner}: axis: {shown(axis)} was given, expected a direction (x, y), not both 0")
    x, y = vector / np.abs(vector).max()
    length = math.hypot(x, y)
    return float(x / length), float(y / length)


@dataclass(frozen=True, slots=True)
class Revolute:
    """Pin: P and Q coincide, r_P - r_Q = 0 (2 rows). Raises ModelError for points that cannot be joined."""

    P: PlacedPoint
    Q: PlacedPoint
    name: str = ""

    def __post_init__(self) -> None:
        _check(self)

    def form(self) -> JointForm:
        """For the kernels."""
        return JointForm(REVOLUTE, ("m", "m"))


@dataclass(frozen=True, slots=True)
class Weld:
    """P and Q coincide and keep their relative angle: r_P - r_Q = 0, angle_P - angle_Q = ``angle`` (3 rows).

    ``angle`` [rad] is the relative angle of the start configuration if omitted. Raises ModelError for points
    that cannot be joined or an angle that is not finite.
    """

    P: PlacedPoint
    Q: PlacedPoint
    angle: float | None = None
    name: str = ""

    def __post_init__(self) -> None:
        _check(self)
        _keep_angle(self)

    def form(self) -> JointForm:
        """For the kernels."""
        return JointForm(WELD, ("m", "m", "rad"), angle=self.angle)


@dataclass(frozen=True, slots=True)
class Prismatic:
    """P slides along a line through Q without turning (2 rows): n_Q.(r_P - r_Q) = 0, angle_P - angle_Q = ``angle``.

    ``axis`` (2,) is the direction of the line, fixed in the material at Q, and n_Q its normal. ``angle`` [rad] is the
    relative angle of the start configuration if omitted. Raises ModelError for points that cannot be joined, a
    zero axis, numbers that are not finite.
    """

    P: PlacedPoint
    Q: PlacedPoint
    axis: npt.ArrayLike = (1.0, 0.0)
    angle: float | None = None
    name: str = ""

    def __post_init__(self) -> None:
        _check(self)
        _keep_angle(self)
        object.__setattr__(self, "axis", _unit("Prismatic", self.axis))

    def form(self) -> JointForm:
        """For the kernels."""
        return JointForm(PRISMATIC, ("m", "rad"), angle=self.angle, axis=_unit("Prismatic", self.axis))


@dataclass(frozen=True, slots=True)
class PointOnLine:
    """P stays on a line through Q, n_Q.(r_P - r_Q) = 0 (1 row), and may turn.

    ``axis`` (2,) is the direction of the line, fixed in the material at Q, and n_Q its normal. Raises ModelError for
    points that cannot be joined or a zero axis.
    """

    P: PlacedPoint
    Q: PlacedPoint
    axis: npt.ArrayLike = (1.0, 0.0)
    name: str = ""

    def __post_init__(self) -> None:
        _check(self)
        object.__setattr__(self, "axis", _unit("PointOnLine", self.axis))

    def form(self) -> JointForm:
        """For the kernels."""
        return JointForm(POINT_ON_LINE, ("m",), axis=_unit("PointOnLine", self.axis))


@dataclass(frozen=True, slots=True)
class Distance:
    """Massless rod: |r_P - r_Q| = ``length`` (1 row).

    ``length`` [m] is a number > 0, a function of time (:mod:`lcpflex.scene.loads`), or the distance of the
    start configuration if omitted. Raises ModelError for points that cannot be joined or a length <= 0.
    """

    P: PlacedPoint
    Q: PlacedPoint
    length: Motion | None = None
    name: str = ""

    def __post_init__(self) -> None:
        _check(self)
        if is_number(self.length):
            keep_number(self, "length", 0.0, math.inf, open_ends=True, label="Distance: length")
        elif self.length is not None:
            checked_motion("Distance: length", self.length)

    def form(self) -> JointForm:
        """For the kernels."""
        if self.length is None or isinstance(self.length, float):
            return JointForm(DISTANCE, ("m",), length=self.length)
        return JointForm(DISTANCE, ("m",), motion=self.length)


@dataclass(frozen=True, slots=True)
class DrivenAngle:
    """Rotary drive: angle_P - angle_Q - ``angle`` - f(t) = 0 (1 row). It holds no place: add a revolute joint.

    ``motion`` f [rad] is a number, :class:`~lcpflex.scene.loads.Harmonic`, :class:`~lcpflex.scene.loads.Table` or
    Python function of time. ``angle`` [rad] is the relative angle of the start configuration if omitted, so that f is
    the rotation since then; 0 makes f the relative angle itself. Raises ModelError for points that cannot be joined or
    a motion that is none.
    """

    P: PlacedPoint
    Q: PlacedPoint
    motion: Motion
    angle: float | None = None
    name: str = ""

    def __post_init__(self) -> None:
        _check(self)
        _keep_angle(self)
        object.__setattr__(self, "motion", checked_motion("DrivenAngle: motion", self.motion))

    def form(self) -> JointForm:
        """For the kernels."""
        return JointForm(DRIVEN_ANGLE, ("rad",), angle=self.angle, motion=self.motion)


@dataclass(frozen=True, slots=True)
class DrivenDisplacement:
    """Linear drive: axis_Q.(r_P - r_Q) - f(t) = 0 (1 row). It guides nothing: add a prismatic joint or a line.

    ``axis`` (2,) is fixed in the material at Q. ``motion`` f [m] is a number, :class:`~lcpflex.scene.loads.Harmonic`,
    :class:`~lcpflex.scene.loads.Table` or Python function of time. Raises ModelError for points that cannot be joined,
    a zero axis or a motion that is none.
    """

    P: PlacedPoint
    Q: PlacedPoint
    axis: npt.ArrayLike
    motion: Motion
    name: str = ""

    def __post_init__(self) -> None:
        _check(self)
        object.__setattr__(self, "axis", _unit("DrivenDisplacement", self.axis))
        object.__setattr__(self, "motion", checked_motion("DrivenDisplacement: motion", self.motion))

    def form(self) -> JointForm:
        """For the kernels."""
        axis = _unit("DrivenDisplacement", self.axis)
        return JointForm(DRIVEN_DISPLACEMENT, ("m",), axis=axis, motion=self.motion)


Joint = Revolute | Weld | Prismatic | PointOnLine | Distance | DrivenAngle | DrivenDisplacement
