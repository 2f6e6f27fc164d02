"""Whether steps of fixed length were short enough for the loads, drives and springs of a run.

Looked for is what happens within a step: a force that swings or a pulse that is over before the step is, a drive whose
mean speed is not the one that was sampled, a spring that swings. It counts where it would change the largest speed of
the run, or a spring's stretch the distance travelled, by more than a hundredth; a pulse that would change that speed by
more than a fifth is a reason not to trust the run. Where nothing moves, speeds are measured by what all loads, at their
mean sizes, would do in one step, and it is no matter when in a step a force comes.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np

from lcpflex.basics.alarm import Alarm
from lcpflex.checks.bent_steps import BentSteps
from lcpflex.checks.run_scales import RunScales
from lcpflex.compile.compiled_scene import CompiledScene
from lcpflex.dynamics.applied_forces import FOLLOWER, FORCE, TORQUE
from lcpflex.dynamics.time_functions import COMPILED, EXTERNAL, HARMONIC, PIECES, ForceCallback
from lcpflex.dynamics.time_probe import probed
from lcpflex.dynamics.time_structure import probe_of
from lcpflex.jit.kernel import FloatArray
from lcpflex.jit.struct import pack
from lcpflex.kinematics.places import material_shapes
from lcpflex.kinematics.relative import Motion, apart, coordinate_gradient
from lcpflex.model.arrays import Model
from lcpflex.model.coordinates import ANGULAR
from lcpflex.model.layout import dimension, is_spatial
from lcpflex.model.planar import N_RIGID
from lcpflex.results.result import Result
from lcpflex.scene.user_system import UserSystem

__all__ = ["place_name", "resisted", "with_unseen_loads"]

TURN = 0.45  # omega times step up to which a mean over the step is good to (omega step)^2 / 12
SPRING_TURN = 0.6  # the same for a spring, whose frequency is off by (omega step)^2 / 24
MATTERS = 0.01  # of the largest speed, or of the distance travelled
MISSED = 0.2  # of the largest speed: what a single step leaves out, from where on a run is not to be trusted
HELD = 0.5  # of the impulse of all loads in a step: so much may be missed where they hold each other, as of a jump
NEGLIGIBLE = 1e-3  # of the other forces: what is smaller does not matter where nothing moves either
LOST = 0.03  # of the path of a drive
GOOD = 20.0  # steps in a period, or in the shortest bend: what is advised

Profiles = dict[int, tuple[FloatArray, FloatArray]]  # instants and values of functions of time


def with_unseen_loads(result: Result, step: float, source: CompiledScene | UserSystem) -> Result:
    """The result with warnings for what steps of ``step`` [s] did not see, each with the step that would do.

    Without trust where one of them has missed a good part of all motion.
    """
    if len(result.times) < 2 or not np.isfinite(result.u).all():
        return result
    with np.errstate(all="ignore"):  # a run that went astray is judged elsewhere
        if isinstance(source, UserSystem):
            found, missed = _unseen_of_user(result, step, source)
        else:
            found, missed = _unseen(result, source, step)
    if not (found or missed):
        return result
    return replace(result, warnings=(*result.warnings, *found), found_wrong=(*result.found_wrong, *missed))


def _unseen(result: Result, compiled: CompiledScene, step: float) -> tuple[tuple[str, ...], tuple[Alarm, ...]]:
    """Warnings, and reasons not to trust a run of a scene."""
    scales = RunScales(result, compiled)
    profiles = _profiles(compiled, scales.duration)
    forces = _forces(compiled, step, scales, profiles)
    found = (
        *(str(text) for text, missed in forces if not missed),
        *_drives(compiled, step, scales, profiles),
        *_springs(result, compiled, step, scales),
    )
    return found, tuple(text for text, missed in forces if missed)


def _unseen_of_user(result: Result, step: float, user: UserSystem) -> tuple[tuple[str, ...], tuple[Alarm, ...]]:
    """The same of a user's own system, by its forces and its mass at the start, each coordinate for itself."""
    functions, q, u = user._functions, result.q[0], result.u[0]
    duration = float(result.times[-1])
    times, values = probed(lambda t: functions.force(t, q, u), duration, closely=False)
    mobility = np.diag(np.linalg.inv(functions.mass(q)))
    found: list[str] = []
    wrong: list[Alarm] = []
    for k, force in enumerate(values.T if len(times) else ()):
        bent = BentSteps(times, force, step, duration)
        if not len(bent.begin):
            continue
        taken = _mean_impulse_of(times, force, step, duration)
        speed = float(np.abs(result.u[:, k]).max()) / float(mobility[k])
        words, missed = _missed(bent, step, speed, taken)
        if words:
            told = words.of(f"the force on coordinate {k}")
            if missed:
                wrong.append(told)
            else:
                found.append(str(told))
    return tuple(found), tuple(wrong)


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


def _forces(compiled: CompiledScene, step: float, scales: RunScales, profiles: Profiles) -> list[tuple[Alarm, bool]]:
    """Forces and torques that go on within a step, and whether that is a good part of all motion."""
    model, found = compiled.model, []
    largest = [_largest(model, k, profiles) for k in range(len(model.signals.kind))]
    usual = _usual_impulse(model, profiles, scales, step)
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
            taken = usual * (0.5 * scales.size if torque else 1.0)
            words, missed = _unseen_force(model, signal, profiles, step, scales, along, taken)
            if words:
                found.append((words.of(f"the {'torque' if torque else 'force'} on {place_name(compiled, p)}"), missed))
    return found


def _usual_impulse(model: Model, profiles: Profiles, scales: RunScales, step: float) -> float:
    """What all weights and loads do in a step, at the mean of their sizes [N s]; torques at half the size."""
    total = step * scales.weight
    for kind, components in zip(model.loads.force_kind.tolist(), model.loads.force_signal.tolist(), strict=True):
        taken = sum(_mean_impulse(model, signal, profiles, step, scales.duration) for signal in set(components))
        total += taken / (1.0 if kind in (FORCE, FOLLOWER) else 0.5 * scales.size)
    return total


def _mean_impulse(model: Model, signal: int, profiles: Profiles, step: float, duration: float) -> float:
    """What a function of time, at the mean of its size, does in a step; of a harmonic no more than half a period."""
    if signal in profiles:
        return _mean_impulse_of(*profiles[signal], step, duration)
    if signal < 0 or model.signals.kind[signal] != HARMONIC:
        return 0.0
    mean, amplitude, omega, _ = model.signals.coefficients[model.signals.first[signal]].tolist()
    swing = step if omega == 0.0 else min(step, 2.0 / abs(omega))
    return float(abs(mean) * step + abs(amplitude) * swing)


def _mean_impulse_of(times: FloatArray, values: FloatArray, step: float, duration: float) -> float:
    """The same of a polygon."""
    at = np.unique(np.concatenate([[0.0, duration], times[(times > 0.0) & (times < duration)]]))
    return step * float(np.trapezoid(np.abs(np.interp(at, times, values)), at)) / duration


def _largest(model: Model, signal: int, profiles: Profiles) -> float:
    """Largest absolute value of a function of time."""
    if signal in profiles:
        return float(np.abs(profiles[signal][1]).max())
    if model.signals.kind[signal] != HARMONIC:
        return 0.0
    mean, amplitude = model.signals.coefficients[model.signals.first[signal], :2].tolist()
    return float(abs(mean) + abs(amplitude))


def _unseen_force(
    model: Model, signal: int, profiles: Profiles, step: float, scales: RunScales, rows: FloatArray, taken: float
) -> tuple[Alarm | None, bool]:
    """What a run does not see of a force, and whether it is not to be trusted; None if it does not matter.

    ``taken``: impulse of all loads in a step [N s]; what moves no faster than by that is at rest.
    """
    nothing = None, False
    if model.signals.kind[signal] == HARMONIC:
        _, amplitude, omega, _ = model.signals.coefficients[model.signals.first[signal]].tolist()
        turn = abs(omega) * step
        if turn <= TURN or amplitude == 0.0:
            return nothing
        mobility = scales.mobility(rows)
        speed = abs(amplitude / omega) * mobility * min(1.0, turn * turn / 12.0)
        return (_turns(omega, step), False) if speed > MATTERS * max(scales.speed, mobility * taken) else nothing
    if signal not in profiles:
        return nothing
    bent = BentSteps(*profiles[signal], step, scales.duration)
    if not len(bent.begin):
        return nothing
    mobility = scales.mobility(rows)
    if model.signals.kind[signal] != PIECES:
        return _missed(bent, step, scales.speed / mobility if mobility > 0.0 else math.inf, taken)
    if scales.speed <= mobility * taken:
        return nothing
    # the impulse is right: what is not seen is when in the step it came
    late = scales.drift(rows) * bent.beside_chords() * 0.5 * step
    return _told(bent, step, late, MATTERS * scales.travel), False


def _missed(bent: BentSteps, step: float, moved: float, taken: float) -> tuple[Alarm | None, bool]:
    """What steps leave out of the impulse of a Python function, which they take at a place or two; whether it is much.

    moved: impulse of the largest speed [N s]; where it is no more than ``taken``, things rest, and errors of single
    steps are not added up.
    """
    of_all, of_one = bent.missed()
    if moved <= taken:
        return _told(bent, step, of_one, HELD * taken), of_one > HELD * taken
    return _told(bent, step, max(of_all, of_one), MATTERS * moved), of_one > MISSED * moved


def _told(bent: BentSteps, step: float, error: float, allowed: float) -> Alarm | None:
    """What happens within steps, with the step that would do; None where the error is allowed."""
    if error <= allowed or not error > 0.0:
        return None
    at, width = bent.pulse()
    advised = step * max(NEGLIGIBLE, allowed / error)
    if width > 0.0:
        advised = min(advised, 0.5 * width)
    lasts = f"at t = {at:.6g} s it acts for {width:.2g} s" if width > 0.0 else f"as at t = {at:.6g} s"
    clause = f"bends and jumps within steps of {step:.3g} s, which do not follow it ({lasts})"
    return Alarm(clause, "load", "", float(at), float(error), f"a step of {advised:.2g} s would")


def _turns(omega: float, step: float) -> Alarm:
    """That a period has too few steps."""
    period = 2.0 * math.pi / abs(omega)
    clause = f"has a period of {period:.3g} s, {period / step:.2g} steps of {step:.3g} s, which do not follow it"
    return Alarm(clause, "load", "", None, period / step, f"a step of {period / GOOD:.2g} s would")


def _drives(compiled: CompiledScene, step: float, scales: RunScales, profiles: Profiles) -> list[str]:
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
    path, bent = float(np.abs(np.diff(values[kept])).sum()), BentSteps(times, values, step, duration)
    lost = bent.lost_path()
    if lost <= LOST * path:
        return ""
    return (
        f"goes to and fro within steps of {step:.3g} s, which miss {100.0 * lost / path:.2g} % of its path: a step of "
        f"{step * max(NEGLIGIBLE, LOST * path / lost):.2g} s would follow it"
    )


def _springs(result: Result, compiled: CompiledScene, step: float, scales: RunScales) -> list[str]:
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
