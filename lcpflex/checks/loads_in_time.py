"""Whether steps of fixed length were short enough for the loads, drives and springs of a run.

Looked for is what happens within a step: a force that swings or a pulse that is over before the step is, a drive whose
mean speed is not the one that was sampled, a spring that swings. It counts where it would change the largest speed of
the run, or a spring's stretch the distance travelled, by more than a hundredth.
"""

from __future__ import annotations

import math
from functools import cached_property
from typing import Any

import numpy as np

from lcpflex.compile.compiled_scene import CompiledScene
from lcpflex.dynamics.applied_forces import FOLLOWER, FORCE, TORQUE
from lcpflex.dynamics.mass_matrix import held_inverse, mass_matrix
from lcpflex.dynamics.start import violation
from lcpflex.dynamics.time_functions import COMPILED, EXTERNAL, HARMONIC, PIECES, ForceCallback
from lcpflex.dynamics.time_structure import bends, probe_of
from lcpflex.jit.kernel import FloatArray
from lcpflex.jit.struct import pack
from lcpflex.kinematics.relative import Motion, apart, coordinate_gradient
from lcpflex.model.arrays import Model
from lcpflex.model.coordinates import ANGULAR
from lcpflex.model.layout import PLANE, dimension, is_spatial, place_offsets
from lcpflex.model.planar import N_RIGID
from lcpflex.model.spatial import N_PLACE
from lcpflex.results.places import material_shapes
from lcpflex.results.result import Result

__all__ = ["masses_and_joints", "place_name", "resisted", "unseen_loads"]

TURN = 0.45  # omega times step up to which a mean over the step is good to (omega step)^2 / 12
SPRING_TURN = 0.6  # the same for a spring, whose frequency is off by (omega step)^2 / 24
MATTERS = 0.01  # of the largest speed, or of the distance travelled
NEGLIGIBLE = 1e-3  # of the other forces: what is smaller does not matter where nothing moves either
LOST = 0.03  # of the path of a drive
GOOD = 20.0  # steps in a period, or in the shortest bend: what is advised

Profiles = dict[int, tuple[FloatArray, FloatArray]]  # instants and values of functions of time


def unseen_loads(result: Result, step: float) -> tuple[str, ...]:
    """Warnings for what steps of ``step`` [s] did not see, each with the step that would do."""
    compiled = result.compiled
    if compiled is None or len(result.times) < 2 or not np.isfinite(result.u).all():
        return ()
    with np.errstate(all="ignore"):  # a run that went astray is judged elsewhere
        scales = _Scales(result, compiled)
        profiles = _profiles(compiled, scales.duration)
        return (
            *_forces(compiled, step, scales, profiles),
            *_drives(compiled, step, scales, profiles),
            *_springs(result, compiled, step, scales),
        )


class _Scales:
    """What is large or small in a run."""

    def __init__(self, result: Result, compiled: CompiledScene) -> None:
        model = compiled.model
        _, rigid, components = dimension(model.bodies)
        dof = model.bodies.dof[:-1, None]
        self.size = compiled.size
        self.duration = float(result.times[-1])
        spins = np.linalg.norm(result.u[:, dof + np.arange(components, rigid)], axis=2)
        self.spin = float(spins.max())
        speeds = np.linalg.norm(result.u[:, dof + np.arange(components)], axis=2) + 0.5 * self.size * spins
        self.speed = float(speeds.max())
        places = result.q[:, place_offsets(model.bodies)[:-1, None] + np.arange(components)]
        travel = np.linalg.norm(np.ptp(places, axis=0), axis=1)
        self.travel = float((travel + 0.5 * self.size * _turned(result, model.bodies)).max())
        self.weight = float(model.bodies.mass.sum() * np.linalg.norm(model.loads.gravity))
        self._compiled = compiled
        self._rigid = (dof + np.arange(rigid)).ravel()

    @cached_property
    def _mechanics(self) -> tuple[FloatArray, FloatArray]:
        return masses_and_joints(self._compiled, self._compiled.q)

    @cached_property
    def _inverse(self) -> FloatArray:
        return held_inverse(*self._mechanics)

    @cached_property
    def _stiff(self) -> FloatArray:
        M, J = self._mechanics
        return held_inverse(M[np.ix_(self._rigid, self._rigid)], J[:, self._rigid])

    def mobility(self, rows: FloatArray) -> float:
        """Largest change of speed by a unit impulse along ``rows`` (k, ndof) [1/kg] or [1/(kg m^2)], joints held."""
        return max(float(np.linalg.eigvalsh(rows @ self._inverse @ rows.T)[-1]), 0.0)

    def drift(self, rows: FloatArray) -> float:
        """The same of bodies as if they were rigid: what lasts."""
        rows = rows[:, self._rigid]
        return max(float(np.linalg.eigvalsh(rows @ self._stiff @ rows.T)[-1]), 0.0)


def _turned(result: Result, bodies: Any) -> FloatArray:
    """By how much each body has turned (nb,) [rad]; in space the range of the integral of its angular velocity.

    Rotations from one stored instant to the next are added as vectors: about a fixed axis that is the angle.
    """
    if dimension(bodies) is PLANE:
        return np.asarray(np.ptp(result.q[:, bodies.dof[:-1] + 2], axis=0))
    p = result.q[:, bodies.place[:-1, None] + np.arange(3, N_PLACE)]
    w, v = p[..., :1], p[..., 1:]
    scalar = w[1:] * w[:-1] + (v[1:] * v[:-1]).sum(axis=-1, keepdims=True)
    vector = w[:-1] * v[1:] - w[1:] * v[:-1] - np.cross(v[1:], v[:-1])
    vector *= np.where(scalar < 0.0, -1.0, 1.0)  # the shorter way round
    length = np.linalg.norm(vector, axis=-1, keepdims=True)
    angle = 2.0 * np.arctan2(length, np.abs(scalar))
    steps = np.divide(angle * vector, length, out=np.zeros_like(vector), where=length > 0.0)
    ways = np.concatenate([np.zeros((1, *steps.shape[1:])), np.cumsum(steps, axis=0)])
    return np.asarray(np.linalg.norm(np.ptp(ways, axis=0), axis=-1))


def masses_and_joints(compiled: CompiledScene, q: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Mass matrix (ndof, ndof) and rows of the joints (nj, ndof) at q, drives as at t = 0."""
    still, external = np.zeros_like(compiled.u), np.zeros((compiled.n_external, 3))
    return mass_matrix(compiled.model, q), violation(compiled.model, q, still, external).jacobian


def _rows(model: Any, q: FloatArray, p: int) -> FloatArray:
    """Velocity (x, y) and rate of rotation of material point p by all velocities (3, ndof); in space (6, ndof)."""
    if is_spatial(model):
        from lcpflex.dynamics.spatial.load_rows import point_rows

        rows = np.zeros((6, int(model.bodies.dof[-1])))
        point_rows(pack(model), q.copy(), p, rows)
        return rows
    rows = np.zeros((3, len(q)))
    b = int(model.points.body[p])
    if b < 0:
        return rows
    d, end = int(model.bodies.dof[b]), int(model.bodies.dof[b + 1])
    phi = material_shapes(model, np.array([p]))[0]
    s = model.points.place[p] + q[d + N_RIGID : end] @ phi
    cos, sin = math.cos(q[d + 2]), math.sin(q[d + 2])
    A = np.array([[cos, -sin], [sin, cos]])
    rows[:2, d : d + 2] = np.eye(2)
    rows[:2, d + 2] = A @ np.array([-s[1], s[0]])
    rows[:2, d + N_RIGID : end] = A @ phi.T
    rows[2, d + 2] = 1.0
    first = int(model.points.start[p])
    rows[2, d + N_RIGID : end] = model.points.psi[first : first + end - d - N_RIGID]
    return rows


def place_name(compiled: CompiledScene, p: int) -> str:
    """What a material point is called."""
    b = int(compiled.model.points.body[p])
    if b < 0:
        return "the ground"
    names = [point for (body, point), k in compiled.layout.points.items() if k == p]
    return f"{compiled.layout.bodies[b]}.{names[0]}" if names else compiled.layout.bodies[b]


def _profiles(compiled: CompiledScene, duration: float) -> Profiles:
    """Instants and values of each function of time that is no harmonic."""
    signals, found = compiled.model.signals, {}
    start = compiled.state(0.0, compiled.q, compiled.u)
    probes: dict[tuple[int, ...], tuple[FloatArray, FloatArray]] = {}
    for callback in compiled.callbacks:
        times, values = probe_of(callback, start, duration)
        slots = callback.slots if isinstance(callback, ForceCallback) else (callback.slot,)
        probes.update({(EXTERNAL, slot): (times, column) for slot, column in zip(slots, values.T, strict=False)})
    for k, function in enumerate(compiled.functions):
        times, values = probe_of(function, start, duration)
        probes.update({(COMPILED, k, c): (times, column) for c, column in enumerate(values.T)})
    for k, kind in enumerate(signals.kind.tolist()):
        first, last = int(signals.first[k]), int(signals.last[k])
        if kind == PIECES:
            found[k] = (signals.breaks[first:last], signals.coefficients[first:last, 3])
        elif kind != HARMONIC:
            key = (kind, first) if kind == EXTERNAL else (kind, first, max(last, 0))
            if key in probes and len(probes[key][0]) > 1:
                found[k] = probes[key]
    return found


class _BentSteps:
    """The k steps within which a polygon bends, and the polygon with their ends among its corners."""

    def __init__(self, times: FloatArray, values: FloatArray, step: float, duration: float) -> None:
        knots = bends(times, values)
        knots = knots[(knots > 0.0) & (knots < duration)]
        number = np.unique(np.floor(knots / step))
        self.begin, self.end = number * step, (number + 1.0) * step
        self.middle = np.interp(self.begin + 0.5 * step, times, values)  # (k,) values
        inner = times[(times > 0.0) & (times < duration)]
        self.at = np.unique(np.concatenate([inner, self.begin, self.end]))
        self.value = np.interp(self.at, times, values)
        self.first, self.last = np.searchsorted(self.at, self.begin), np.searchsorted(self.at, self.end)

    def over(self, corners: FloatArray) -> FloatArray:
        """Integral over each step of what has the values ``corners`` at those of the polygon (k,)."""
        pieces = 0.5 * (corners[1:] + corners[:-1]) * np.diff(self.at)
        total = np.concatenate([[0.0], np.cumsum(pieces)])
        return np.asarray(total[self.last] - total[self.first])

    def beside_chords(self) -> float:
        """Area between the polygon and the chords of the steps, of all together."""
        ends = np.concatenate([self.first, self.last])
        ends = ends[np.argsort(self.at[ends], kind="stable")]
        chord = np.interp(self.at, self.at[ends], self.value[ends])
        return float(self.over(np.abs(self.value - chord)).sum())

    def lost_path(self) -> float:
        """What the polygon goes to and fro within steps, of all together."""
        gone = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(self.value)))])
        straight = np.abs(self.value[self.last] - self.value[self.first])
        return float((gone[self.last] - gone[self.first] - straight).sum())


def _forces(compiled: CompiledScene, step: float, scales: _Scales, profiles: Profiles) -> list[str]:
    """Forces and torques that go on within a step."""
    model, found = compiled.model, []
    largest = [_largest(model, k, profiles) for k in range(len(model.signals.kind))]
    for k, kind in enumerate(model.loads.force_kind.tolist()):
        p = int(model.loads.force_point[k])
        torque = kind not in (FORCE, FOLLOWER)
        axes = dimension(model.bodies).components
        rows = _rows(model, compiled.q, p)
        # speeds, of a torque at half the size
        rows = math.sqrt(0.5 * scales.size) * rows[axes:] if torque else rows[:axes]
        fixed = kind == FORCE or (kind == TORQUE and len(rows) > 1)  # in axes of the world
        components = model.loads.force_signal[k].tolist()
        own = set(components)
        rest = [] if torque else [scales.weight, *(x for j, x in enumerate(largest) if j not in own)]
        for signal in sorted(own):
            if largest[signal] <= NEGLIGIBLE * max(rest, default=0.0):
                continue
            along = rows[[c for c in range(axes) if components[c] == signal]] if fixed else rows
            words = _unseen_force(model, signal, profiles, step, scales, along)
            if words:
                found.append(f"the {'torque' if torque else 'force'} on {place_name(compiled, p)} {words}")
    return found


def _largest(model: Model, signal: int, profiles: Profiles) -> float:
    """Largest absolute value of a function of time."""
    if signal in profiles:
        return float(np.abs(profiles[signal][1]).max())
    if model.signals.kind[signal] != HARMONIC:
        return 0.0
    mean, amplitude = model.signals.coefficients[model.signals.first[signal], :2].tolist()
    return float(abs(mean) + abs(amplitude))


def _unseen_force(model: Model, signal: int, profiles: Profiles, step: float, scales: _Scales, rows: FloatArray) -> str:
    """What a run does not see of a force, in words; empty if that does not matter."""
    if model.signals.kind[signal] == HARMONIC:
        _, amplitude, omega, _ = model.signals.coefficients[model.signals.first[signal]].tolist()
        turn = abs(omega) * step
        if turn <= TURN or amplitude == 0.0:
            return ""
        speed = abs(amplitude / omega) * scales.mobility(rows) * min(1.0, turn * turn / 12.0)
        return _turns(omega, step) if speed > MATTERS * scales.speed else ""
    if signal not in profiles:
        return ""
    bent = _BentSteps(*profiles[signal], step, scales.duration)
    if not len(bent.begin):
        return ""
    taken = model.signals.kind[signal] == PIECES
    if taken:  # the impulse is right: what is not seen is when in the step it came
        off = bent.beside_chords() * 0.5 * step
    else:
        off = float(np.abs(np.cumsum(step * bent.middle - bent.over(bent.value))).max())
    error, scale = scales.mobility(rows) * off, scales.speed
    if taken:
        error, scale = scales.drift(rows) * off, scales.travel
    if error <= MATTERS * scale or not error > 0.0:
        return ""
    advised = step * max(NEGLIGIBLE, MATTERS * scale / error)
    return f"bends and jumps within steps of {step:.3g} s, which do not follow it: a step of {advised:.2g} s would"


def _turns(omega: float, step: float) -> str:
    """That a period has too few steps."""
    period = 2.0 * math.pi / abs(omega)
    return (
        f"has a period of {period:.3g} s, {period / step:.2g} steps of {step:.3g} s, which do not follow it: a step of "
        f"{period / GOOD:.2g} s would"
    )


def _drives(compiled: CompiledScene, step: float, scales: _Scales, profiles: Profiles) -> list[str]:
    """Drives that turn back within a step."""
    model, found = compiled.model, []
    owner = np.repeat(np.arange(len(model.joints.point)), np.diff(model.joints.row))
    for joint, kind, signal in zip(owner.tolist(), model.joints.kind, model.joints.signal.tolist(), strict=True):
        if signal < 0:
            continue
        words = ""
        if signal in profiles:
            words = _unseen_path(*profiles[signal], step, scales.duration)
        elif model.signals.kind[signal] == HARMONIC:
            _, amplitude, omega, _ = model.signals.coefficients[model.signals.first[signal]].tolist()
            fastest = scales.spin if ANGULAR[kind] else scales.speed
            if abs(omega) * step > TURN and abs(amplitude * omega) > MATTERS * fastest:
                words = _turns(omega, step)
        if words:
            found.append(f"the motion of joint {compiled.layout.joints[joint]!r} {words}")
    return found


def _unseen_path(times: FloatArray, values: FloatArray, step: float, duration: float) -> str:
    """That a drive goes to and fro within steps, in words; empty if it does not."""
    kept = times <= duration
    path, bent = float(np.abs(np.diff(values[kept])).sum()), _BentSteps(times, values, step, duration)
    lost = bent.lost_path()
    if lost <= LOST * path:
        return ""
    return (
        f"goes to and fro within steps of {step:.3g} s, which miss {100.0 * lost / path:.2g} % of its path: a step of "
        f"{step * max(NEGLIGIBLE, LOST * path / lost):.2g} s would follow it"
    )


def _springs(result: Result, compiled: CompiledScene, step: float, scales: _Scales) -> list[str]:
    """Springs that swing faster than steps can follow, and do swing."""
    model, found = pack(compiled.model), []
    for k, kind in enumerate(model.loads.spring_kind.tolist()):
        P, Q = model.loads.spring_point[k].tolist()
        row = resisted(model, compiled.q, k)
        omega = math.sqrt(float(model.loads.spring_value[k, 0]) * scales.mobility(row[None, :]))
        if omega * step <= SPRING_TURN:
            continue
        swing = _fastest_stretch(result, model, k) / omega * (0.5 * scales.size if ANGULAR[kind] else 1.0)
        if swing > MATTERS * max(scales.travel, NEGLIGIBLE * scales.size):
            names = f"{place_name(compiled, P)} and {place_name(compiled, Q)}"
            found.append(f"the spring between {names}, which swings, {_turns(omega, step)}")
    return found


def resisted(model: Any, q: FloatArray, k: int) -> FloatArray:
    """(ndof,) of the coordinate that spring k resists; the model is a packed one."""
    if is_spatial(model):
        from lcpflex.dynamics.spatial.load_rows import spring_row

        row = np.zeros(int(model.bodies.dof[-1]))
        spring_row(model, q.copy(), k, row)
        return row
    P, Q = model.loads.spring_point[k].tolist()
    at = apart(model.bodies, model.points, q.copy(), P, Q)
    still = Motion(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    kind, axis = int(model.loads.spring_kind[k]), model.loads.spring_axis[k].tolist()
    gx, gy, turn_p, turn_q, _ = coordinate_gradient(kind, at, still, *axis)
    of_p, of_q = (_rows(model, q, p) for p in (P, Q))
    return np.asarray(np.array([gx, gy]) @ (of_p - of_q)[:2] + turn_p * of_p[2] + turn_q * of_q[2])


def _fastest_stretch(result: Result, model: Model, k: int) -> float:
    """Largest rate of what spring k resists at the stored instants [m/s] or [rad/s]."""
    rates = (abs(float(resisted(model, q, k) @ u)) for q, u in zip(result.q, result.u, strict=True))
    return max(rates, default=0.0)
