"""Reactions of joints and drives over the stored instants, by name."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from lcpflex.basics.arguments import absent
from lcpflex.errors import ModelError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lcpflex.jit.kernel import FloatArray
    from lcpflex.results.result import Result

__all__ = ["JointReaction", "joint_reaction", "reaction_columns"]


@dataclass(frozen=True, slots=True, eq=False)
class JointReaction:
    """What a joint does to the body of its first point P, at P; the body of Q bears the opposite at the same place.

    With the multiplier lambda of a row c of the joint (:mod:`lcpflex.kinematics.relative`), the power of the joint is

        lambda cdot = F.(rdot_P - rdot_Q) + M (alphadot_P - alphadot_Q)    where Q is at the place of P.

    The moment of a ``DrivenAngle`` is the torque of the drive, the force of a ``DrivenDisplacement`` is along its axis.

    ``EventDriven`` and ``Smooth`` tell the force at the instant. Time-stepping schemes tell the mean since the instant
    before, weighted by time: ``MoreauJean`` of the impulses of its steps, ``GeneralizedAlpha`` and ``MasslessBoundary``
    of the forces at both ends of each. Impacts have impulses but no force: the impulses of a step of Moreau-Jean with
    an impact among the bodies that contacts and joints connect to those of the joint (with what all other forces do
    in that step) and those of the impacts of the other steppers are in ``impulse`` alone.

    Attributes
    ----------
    name
        Of the joint.
    times
        (m,) stored instants [s].
    force
        (m, 2) F [N], world axes; NaN where no step tells of a force, as at the start of Moreau-Jean, and where each
        one since the instant before had an impact.
    moment
        (m,) M [N m], counter-clockwise.
    largest_force, largest_moment
        (m,) largest |F| and |M| of a step or instant since the instant before.
    impulse, angular_impulse
        (m, 2) [N s], (m,) [N m s]: of impacts, since the start.
    unique
        (m,) whether the motion determines the reaction. Redundant joints share their load in many ways with the same
        motion; here it is the one of the least norm, sum of |F|^2 + (M / L)^2 over all joints, L the extent of the
        largest body; the largest ones are then those of that. Contacts may share a load with joints, too, as under a
        chain that lies on a rough floor: the reaction then is in balance with the impulses of the contacts, and is
        marked where the least contact forces, which are stored, would change it.
    """

    name: str
    times: FloatArray
    force: FloatArray
    moment: FloatArray
    largest_force: FloatArray
    largest_moment: FloatArray
    impulse: FloatArray
    angular_impulse: FloatArray
    unique: NDArray[np.bool_]

    def __str__(self) -> str:
        force, moment = (float(np.nanmax(values, initial=0.0)) for values in (self.largest_force, self.largest_moment))
        text = f"{self.name}: at most {force:.4g} N and {moment:.4g} N m"
        return text if self.unique.all() else f"{text}, not determined by the motion"


def joint_reaction(result: Result, joint: str) -> JointReaction:
    """That of one joint of a result. Raises ModelError where there is none."""
    stored = result.joint_force, result.joint_peak, result.joint_impulse, result.joint_unique
    force, peak, impulse, unique = stored
    if result.compiled is None:
        raise ModelError(
            "reaction: a system of the user's own tells no points of joints; expected the result of a Scene"
        )
    names = result.compiled.layout.joints
    if not isinstance(joint, str) or joint not in names:
        raise ModelError(f"joint: no joint {absent(joint, names)}")
    if force is None or peak is None or impulse is None or unique is None:
        raise ModelError("reaction: this result was saved by a version that recorded none; expected a newer one")
    k = names.index(joint)
    return JointReaction(
        joint,
        result.times,
        force[:, k, :2],
        force[:, k, 2],
        peak[:, k, 0],
        peak[:, k, 1],
        impulse[:, k, :2],
        impulse[:, k, 2],
        unique[:, k] == 1,
    )


def reaction_columns(result: Result) -> dict[str, Any]:
    """The columns of a table: force and moment of each joint."""
    if result.compiled is None or result.joint_force is None:
        return {}
    ways = ("force x", "force y", "moment")
    names = result.compiled.layout.joints
    return {f"{name}.{way}": result.joint_force[:, k, i] for k, name in enumerate(names) for i, way in enumerate(ways)}
