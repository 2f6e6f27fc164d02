"""What moves a row of rests: a drive or a load of a compiled scene, held at one value after the other.

Its functions of time become constants of the compiled arrays. The scene is compiled once, so that its keys of contacts
and joints stay, and each place of rest has arrays of its own, in which the drive stands where it was then.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from lcpflex.basics.arguments import absent
from lcpflex.dynamics.time_functions import HARMONIC
from lcpflex.errors import ModelError
from lcpflex.jit.struct import pack
from lcpflex.kinematics.signal_values import signal_value
from lcpflex.model.arrays import Signals, frozen
from lcpflex.model.coordinates import ANGULAR
from lcpflex.results.joint_reaction import joint_reaction
from lcpflex.scene.loads.effort import Effort
from lcpflex.scene.register import Register
from lcpflex.scene.substitution import one_with, remade
from lcpflex.statics.balance import Balance
from lcpflex.statics.rests_as_result import rests_as_result

if TYPE_CHECKING:
    from lcpflex.bodies.placed_point import PlacedPoint
    from lcpflex.compile.compiled_scene import CompiledScene
    from lcpflex.jit.kernel import FloatArray
    from lcpflex.statics.rest import Rest

__all__ = ["Drive", "begun", "drive_of"]

UNITS = ("m", "N"), ("rad", "N m")  # of travel and force: along, and about something
THERE = 1e-9  # of the size, or rad: a drive so near to where the bodies stand is there


class Drive(Protocol):
    """A drive or a load by its name."""

    @property
    def name(self) -> str: ...
    @property
    def units(self) -> Mapping[str, str]:
        """Of its "values", its "travel" and its "force"."""
        ...

    def held(self, compiled: CompiledScene, value: float) -> CompiledScene:
        """The scene with it held at that value."""
        ...

    def curve(self, values: FloatArray, rests: Sequence[Rest]) -> tuple[FloatArray, FloatArray]:
        """How far it has gone, and its force, (k,) each, of one or more rests with their values (k,)."""
        ...


def drive_of(scene: Any, compiled: CompiledScene, name: Any, time: float) -> Drive:
    """The drive or load of that name. Raises ModelError where there is none, or several."""
    parts, joints = scene.parts(), compiled.layout.joints
    loads = [load for load in parts.loads if _forms(load)]
    model = compiled.model
    driven = [joint for joint, row in zip(joints, model.joints.row[1:], strict=True) if _moves(model, int(row) - 1)]
    known = [*driven, *(load.name for load in loads if load.name)]
    if not isinstance(name, str) or name not in known:
        if isinstance(name, str) and name in joints:
            raise ModelError(f"drive: the joint {name!r} drives nothing, expected a DrivenDisplacement or DrivenAngle")
        raise ModelError(f"drive: no drive or load {absent(name, known)}")
    if known.count(name) > 1:
        raise ModelError(
            f"drive: {known.count(name)} drives and loads have the name {name!r}, expected names of their own"
        )
    if name in driven:
        return _of_joint(compiled, name)
    return _of_load(compiled, [load.name for load in loads].index(name), loads, time)


def begun(scene: Any, name: Any) -> tuple[Any, float | None]:
    """The scene with a drive where its bodies stand, and its value there; as it is, and None, for all but a drive.

    Assembled with a drive elsewhere, a part would be moved into what it is to press on.
    """
    if not (isinstance(scene, Register) and isinstance(name, str) and _has_motion(scene, name)):
        return scene, None
    scene = scene.reduced()  # type: ignore[attr-defined]  # of both kinds
    compiled = scene.compiled(project=True, push=None)
    drive = _of_joint(compiled, name)
    row = int(compiled.model.joints.row[compiled.layout.joints.index(name)])
    q = np.concatenate([placed.start[0] for placed in scene.parts().placed])
    stands = float(Balance(drive.held(compiled, 0.0)).look(q, 0.0).phi[row])
    off = Balance(compiled).look(q, 0.0).phi[row]
    if abs(off) <= THERE * (compiled.size if drive.units["travel"] == "m" else 1.0):
        return scene, stands
    bodies = [one_with(placed, None) for placed in scene.parts().placed]
    return remade(scene, bodies, {name: replace(scene.parts().joints[name], motion=stands)}), stands


def _has_motion(scene: Any, name: str) -> bool:
    return hasattr(scene.parts().joints.get(name), "motion")


def _forms(load: Any) -> bool:
    """Whether a load is a force or a torque."""
    forms = load.spatial_forms() if load.P.in_space else (load.form(),)
    return isinstance(forms[0], Effort)


def _moves(model: Any, row: int) -> bool:
    """Whether a row of a joint is one with a motion: of a drive the only one, and so the last."""
    return row >= 0 and bool(model.joints.signal[row] >= 0)


@dataclass(frozen=True, slots=True)
class JointDrive:
    """A joint that drives a relative coordinate."""

    name: str
    units: Mapping[str, str]
    signal: int

    def held(self, compiled: CompiledScene, value: float) -> CompiledScene:
        """See :class:`Drive`."""
        return _with_constants(compiled, {self.signal: value})

    def curve(self, values: FloatArray, rests: Sequence[Rest]) -> tuple[FloatArray, FloatArray]:
        """See :class:`Drive`; the force is lambda, with the power lambda f'(t)."""
        force = joint_reaction(rests_as_result(rests), self.name).drive
        assert force is not None  # it has one row
        return values.copy(), force


def _of_joint(compiled: CompiledScene, name: str) -> JointDrive:
    joints = compiled.model.joints
    row = int(joints.row[compiled.layout.joints.index(name)])
    travel, force = UNITS[int(ANGULAR[joints.kind[row]])]
    return JointDrive(name, {"values": travel, "travel": travel, "force": force}, int(joints.signal[row]))


@dataclass(frozen=True, slots=True, eq=False)
class LoadDrive:
    """A force or torque of growing size and one direction, in world axes or in those of the material at its point."""

    name: str
    units: Mapping[str, str]
    point: PlacedPoint
    signals: tuple[int, ...]
    direction: FloatArray  # (d,), of a torque of the plane (1,)
    follows: bool
    turns: bool  # whether it is a torque

    def held(self, compiled: CompiledScene, value: float) -> CompiledScene:
        """See :class:`Drive`."""
        parts = (value * self.direction).tolist()
        return _with_constants(compiled, dict(zip(self.signals, parts, strict=True)))

    def curve(self, values: FloatArray, rests: Sequence[Rest]) -> tuple[FloatArray, FloatArray]:
        """See :class:`Drive`: from rest to rest the way of its point along the force, or the turn about the torque."""
        states = [rest.compiled.state(rest.time, rest.q, np.zeros(len(rest.compiled.u))) for rest in rests]
        ways = [self._way(state) for state in states]
        steps = [
            0.5 * float((one_way + other_way) @ self._moved(one, other))
            for one, other, one_way, other_way in zip(states, states[1:], ways, ways[1:], strict=False)
        ]
        return np.concatenate([[0.0], np.cumsum(steps)]), values.copy()

    def _way(self, state: Any) -> FloatArray:
        """The direction in world axes."""
        if not self.follows:
            return self.direction
        if len(self.direction) == 3:
            return np.asarray(state.rotation(self.point) @ self.direction)
        angle = state.angle(self.point)
        turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        return np.asarray(turn @ self.direction)

    def _moved(self, one: Any, other: Any) -> FloatArray:
        """Displacement, or rotation vector, of the material at its point between two states."""
        if not self.turns:
            return np.asarray(other.position(self.point) - one.position(self.point))
        if len(self.direction) == 1:
            return np.array([other.angle(self.point) - one.angle(self.point)])
        from scipy.spatial.transform import Rotation

        turn = other.rotation(self.point) @ one.rotation(self.point).T
        return np.asarray(Rotation.from_matrix(turn).as_rotvec())


def _of_load(compiled: CompiledScene, k: int, loads: Sequence[Any], time: float) -> LoadDrive:
    """Of the k-th force or torque, in the direction that it has at that time and at the start."""
    load, model = loads[k], compiled.model
    kind = (load.spatial_forms()[0] if load.P.in_space else load.form()).kind
    turns = kind.startswith("torque")
    signals = tuple(model.loads.force_signal[k].tolist())
    if turns and not load.P.in_space:  # the number of its only component stands twice
        signals, direction = signals[:1], np.ones(1)
    else:
        given = _values(compiled, signals, time)
        size = float(np.linalg.norm(given))
        if not 0.0 < size < np.inf:
            raise ModelError(
                f"drive: the load {load.name!r} is {given.tolist()} at {time:g} s, expected one that is not 0 there: "
                "its direction is that of the loads of the path"
            )
        direction = given / size
    travel, force = UNITS[int(turns)]
    units = {"values": force, "travel": travel, "force": force}
    return LoadDrive(load.name, units, load.P, signals, direction, kind.endswith("follower"), turns)


def _values(compiled: CompiledScene, numbers_of: tuple[int, ...], time: float) -> FloatArray:
    """Of some functions of time, at the start."""
    external = np.zeros((compiled.n_external, 3))
    state = compiled.state(time, compiled.q, np.zeros(len(compiled.u)))
    for callback in compiled.callbacks:
        callback.fill(time, state, external)
    signals = pack(compiled.model.signals)
    return np.array([signal_value(signals, number, time, external)[0] for number in numbers_of])


def _with_constants(compiled: CompiledScene, constants: Mapping[int, float]) -> CompiledScene:
    """The scene with constants in the place of some functions of time, by their numbers."""
    model = compiled.model
    signals: Signals = model.signals
    kind, first, last = (np.array(part) for part in (signals.kind, signals.first, signals.last))
    count = len(signals.breaks)
    for k, number in enumerate(constants):
        kind[number], first[number], last[number] = HARMONIC, count + k, count + k + 1
    rows = np.array([(value, 0.0, 0.0, 0.0) for value in constants.values()])
    held = signals._replace(
        kind=frozen(kind, np.int64),
        first=frozen(first, np.int64),
        last=frozen(last, np.int64),
        breaks=frozen(np.append(signals.breaks, np.zeros(len(rows)))),
        coefficients=frozen(np.vstack([signals.coefficients, rows]), columns=4),
    )
    return replace(compiled, model=model._replace(signals=held))
