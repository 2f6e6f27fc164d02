"""Reactions of joints and drives over the stored instants, by name."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial, reduce
from typing import TYPE_CHECKING

import numpy as np

from lcpflex.basics.arguments import absent
from lcpflex.basics.attributes import NamesNearest
from lcpflex.errors import ModelError
from lcpflex.kinematics.places import material_shapes, trajectory, turned
from lcpflex.kinematics.spatial.frames import rotated
from lcpflex.model.coordinates import ANGULAR, COMPONENT, DISTANCE
from lcpflex.model.layout import SPACE, dimension
from lcpflex.results.orientation import body_angle, body_orientation
from lcpflex.results.stored_instants import tells_of_steps

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lcpflex.jit.kernel import FloatArray
    from lcpflex.results.result import Result

__all__ = ["JointReaction", "joint_reaction"]


@dataclass(frozen=True, slots=True, eq=False)
class JointReaction(NamesNearest):
    """What a joint does to the body of its first point P, at P; the body of Q bears the opposite at the same place.

    With the multiplier lambda of a row c of the joint (:mod:`lcpflex.kinematics.relative`), the power of the joint is

        lambda cdot = F.(rdot_P - rdot_Q) + M (alphadot_P - alphadot_Q)    where Q is at the place of P.

    In space F and M have three components, M about P, and the last term is M.(Omega_P - Omega_Q). The moment of a
    ``DrivenAngle`` is the torque of the drive, the force of a ``DrivenDisplacement`` is along its axis; ``drive`` is
    lambda of what a joint drives, with the power lambda f'(t).

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
        (m, 2) F [N], in ``axes``; (m, 3) in space. NaN where no step tells of a force, as at the start of Moreau-Jean,
        and where each one since the instant before had an impact.
    moment
        (m,) M [N m], counter-clockwise; in space (m, 3), about P, in ``axes``.
    largest_force, largest_moment
        (m,) largest |F| and |M| of a step or instant since the instant before.
    impulse, angular_impulse
        (m, 2) [N s], (m,) [N m s], in space (m, 3) both: of impacts, since the start.
    unique
        (m,) whether the motion determines the reaction. Redundant joints, as those of most mechanisms in space are,
        share their load in many ways with the same motion; here it is the one of the least norm, sum of |F|^2 +
        |M|^2 / L^2 over all joints, L the extent of the largest body; the largest ones are then those of that.
        Contacts may share a load with joints, too, as under a chain that lies on a rough floor: the reaction then is in
        balance with the impulses of the contacts, and is marked where the least contact forces, which are stored, would
        change it.
    axes
        "world", or the name of the body in whose frame, as it is turned at the instant, vectors are given: the impulse
        is the sum of those in world axes. A mean since the instant before is turned by the mean of both angles, in
        space half-way between both orientations.
    drive
        (m,) torque [N m] or force [N] of a drive along the coordinate c = f(t) that it prescribes, positive where it
        pushes c up; None for joints without a motion. NaN as ``force`` is.
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
    axes: str = "world"
    drive: FloatArray | None = None

    def __str__(self) -> str:
        force, moment = (float(np.nanmax(values, initial=0.0)) for values in (self.largest_force, self.largest_moment))
        text = f"{self.name}: at most {force:.4g} N and {moment:.4g} N m"
        return text if self.unique.all() else f"{text}, not determined by the motion"


def joint_reaction(result: Result, joint: str, axes: str = "world") -> JointReaction:
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
    axes, frame = _frame(result, k, axes)
    now, mean, d = _into(result, frame, False), _into(result, frame, True), dimension(result.compiled.model.bodies)
    vector, moment = slice(d.components), slice(d.components, None) if d is SPACE else d.components
    told = force[:, k], impulse[:, k]
    return JointReaction(
        name=joint,
        times=result.times,
        force=mean(told[0][:, vector]),
        moment=mean(told[0][:, moment]) if d is SPACE else told[0][:, moment],
        largest_force=peak[:, k, 0],
        largest_moment=peak[:, k, 1],
        impulse=now(told[1][:, vector]),
        angular_impulse=now(told[1][:, moment]) if d is SPACE else told[1][:, moment],
        unique=unique[:, k] == 1,
        axes=axes,
        drive=_drive(result, k, force[:, k]),
    )


def _frame(result: Result, joint: int, axes: str) -> tuple[str, str | None]:
    """Name of the frame that ``axes`` asks for, and the body that it is of; None for the world, that of the ground."""
    assert result.compiled is not None
    bodies, model = result.compiled.layout.bodies, result.compiled.model
    if not isinstance(axes, str) or axes not in ("world", "body", *bodies):
        raise ModelError(f"axes: no frame {absent(axes, ('world', 'body', *bodies))}")
    if axes == "body":
        b = int(model.points.body[model.joints.point[joint, 0]])
        axes = bodies[b] if b >= 0 else "world"
    elif axes == "world":
        return axes, None
    return axes, axes if axes in bodies else None


def _into(result: Result, body: str | None, mean: bool) -> Callable[[FloatArray], FloatArray]:
    """From world axes to those of a body, (m, d), at the instants, or as means since the instant before belong to."""
    assert result.compiled is not None
    if body is None:
        return _as_it_is
    if result.compiled.spatial:
        p = _quaternions(result, body, mean)
        return partial(rotated, p * np.array([1.0, -1.0, -1.0, -1.0]))
    angle = body_angle(result, body)
    return partial(turned, -(_mean(result, angle) if mean else angle))


def _as_it_is(vectors: FloatArray) -> FloatArray:
    return vectors.copy()


def _quaternions(result: Result, body: str, mean: bool) -> FloatArray:
    """Orientation of a body at the instants, (m, 4), or half-way from the instants before where ``mean`` is told."""
    p = body_orientation(result, body).as_quat()[:, [3, 0, 1, 2]]
    if not (mean and tells_of_steps(result)):
        return np.asarray(p)
    before = p[:-1] * np.where((p[:-1] * p[1:]).sum(axis=1) < 0.0, -1.0, 1.0)[:, None]
    middle = np.concatenate([p[:1], before + p[1:]])
    return np.asarray(middle / np.linalg.norm(middle, axis=1)[:, None])


def _mean(result: Result, angle: FloatArray) -> FloatArray:
    """Angle to which a stored force belongs: at the instant, or of a mean since the instant before."""
    if not tells_of_steps(result):
        return angle
    return np.concatenate([angle[:1], 0.5 * (angle[:-1] + angle[1:])])


def _drive(result: Result, joint: int, stored: FloatArray) -> FloatArray | None:
    """lambda of the row with a motion, from the stored force and moment.

    Of a force F = lambda g with |g| = 1, g.F; a moment is lambda times an axis, in the plane lambda itself.
    """
    assert result.compiled is not None
    model = result.compiled.model
    rows = np.arange(model.joints.row[joint], model.joints.row[joint + 1])
    driven = rows[model.joints.signal[rows] >= 0]
    if len(driven) != 1:
        return None
    kind, d = int(model.joints.kind[driven[0]]), dimension(model.bodies)
    angular = bool(ANGULAR[kind])
    if np.count_nonzero(ANGULAR[model.joints.kind[rows]] == angular) > 1:
        return None  # other rows add to what is stored
    if angular and d is not SPACE:
        return stored[:, 2]
    force = stored[:, d.components :] if angular else stored[:, : d.components]
    direction = _direction(result, joint, int(driven[0]), kind)
    # the only force of the joint: its direction tells the sign, and that of the material may differ by a bending
    return np.asarray(np.sign(np.einsum("ki,ki->k", force, direction)) * reduce(np.hypot, force.T))


def _direction(result: Result, joint: int, row: int, kind: int) -> FloatArray:
    """About (m, d) where the force or moment of a driven row acts."""
    assert result.compiled is not None
    model, layout = result.compiled.model, result.compiled.layout
    p, q = (int(point) for point in model.joints.point[joint])
    axis = model.joints.axis[row]
    if kind == DISTANCE:
        return _path(result, p) - _path(result, q)
    b = int(model.points.body[q])
    if kind == COMPONENT or b < 0:
        return np.broadcast_to(axis, (len(result.times), len(axis)))
    if result.compiled.spatial:
        return rotated(_quaternions(result, layout.bodies[b], True), np.asarray(axis))
    return turned(_mean(result, body_angle(result, layout.bodies[b])), np.asarray(axis))


def _path(result: Result, point: int) -> FloatArray:
    """r_P over the stored instants (m, d) [m]."""
    assert result.compiled is not None
    model = result.compiled.model
    b, place = int(model.points.body[point]), model.points.place[point]
    if b < 0:
        return np.broadcast_to(place, (len(result.times), len(place)))
    return trajectory(model, result.q, b, place, material_shapes(model, np.array([point]))[0])
