"""Axial forces of beams in a run, against what their stiffness counts with and against small slopes.

The bending of a linear beam does not feel its axial force N, which changes the square of its lowest frequency by about
N / N_Euler, N_Euler = pi^2 E I / L^2. At stored instants N(x) follows from the equilibrium of the part behind x,

    N(x) = sum of F_i over x_i > x + integral from x to L of rho A (g - a) dx',   a = Rddot - omega^2 x'

along the axis of the frame, deflections left out. F_i are loads, springs, contacts, and reactions of joints, from
M udot = h + W p + J^T lambda, J udot + b = 0. Beams do not vibrate along their axis there, which is over many times
while they bend once, unless their stretching shares what joints hold more than once. Collisions are left out until the
beam has vibrated once: they take no time to bend it. Where something always strikes, the median over time is taken.
Beams that count with their actual axial force are of small slopes: beyond SLOPE the result is not to be trusted.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from lcpflex.compile.compiled_scene import CompiledScene
from lcpflex.contact.near import near
from lcpflex.contact.rows import contact_point, contact_rows
from lcpflex.dynamics.applied_forces import TORQUE, applied_forces, stretch
from lcpflex.dynamics.body_forces import elastic_forces, inertial_forces
from lcpflex.dynamics.inertia import arrow, factorise
from lcpflex.dynamics.mass_matrix import slowest_vibrations
from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.jit.struct import pack
from lcpflex.kinematics.joint_rows import joint_rows
from lcpflex.kinematics.relative import coordinate_gradient, relative_motion
from lcpflex.model.arrays import Axis, Loads, Model
from lcpflex.model.planar import N_RIGID
from lcpflex.results.acting_forces import accelerations
from lcpflex.results.result import Result
from lcpflex.results.stated_error import CLAMPED

__all__ = ["with_axial_loads"]

SHARE = 0.03  # of Euler's load, from where on a linear beam warns
SLOPE = 0.1  # beyond which the strain u' + w'^2 / 2 is none
INSTANTS = 200  # looked at, at most
STRIKES = 0.5  # of the impulse between two instants that forces do not explain, from where on it is that of an impact
ENOUGH = 0.2  # of the instants, to look at those without collisions only
NEAR = 1e-3  # of the size of the scene: pairs among which those that press are looked for
REDUNDANT = 1e-12

Pulls = list[tuple[float, FloatArray]]  # station [m] and force (2,) [N], world axes


@dataclass(frozen=True, slots=True)
class Worst:
    """The largest axial force that a beam does not count with."""

    force: float  # [N], tension positive
    time: float  # [s]
    station: float  # [m]


def with_axial_loads(result: Result) -> Result:
    """The result with a warning for each linear beam under axial load, and without trust where slopes are too large."""
    compiled = result.compiled
    if compiled is None or not any(compiled.layout.axes) or not np.isfinite(result.q).all():
        return result
    warnings, wrong = list(result.warnings), list(result.found_wrong)
    wrong += [text for b, axis in _beams(compiled, actual=True) if (text := _too_steep(result, compiled, b, axis))]
    linear = _beams(compiled, actual=False)
    for (b, axis), worst in zip(linear, _worst(result, compiled, linear), strict=True):
        if abs(worst.force) > SHARE * axis.euler:
            warnings.append(_told(compiled.layout.bodies[b], axis, worst))
    return replace(result, warnings=tuple(warnings), found_wrong=tuple(wrong))


def _beams(compiled: CompiledScene, actual: bool) -> list[tuple[int, Axis]]:
    """Beams that bend, with the actual axial force or without."""
    modes = np.diff(compiled.model.bodies.dof) - N_RIGID
    axes = enumerate(compiled.layout.axes)
    return [(b, axis) for b, axis in axes if axis is not None and axis.actual == actual and modes[b]]


def _told(name: str, axis: Axis, worst: Worst) -> str:
    kind = "compression" if worst.force < 0.0 else "tension"
    share = 100.0 * abs(worst.force) / axis.euler
    return (
        f"beam {name!r}: {kind} of {abs(worst.force):.4g} N at x = {worst.station:.4g} m, t = {worst.time:.6g} s, "
        f"{share:.2g} % of its Euler load pi^2 E I / L^2 = {axis.euler:.4g} N: its bending does not feel that; "
        f'stiffening=Stiffening(axial_force="actual") of a beam with axial=True lets it'
    )


def _too_steep(result: Result, compiled: CompiledScene, b: int, axis: Axis) -> str:
    """Why a beam that counts with its axial force is not to be trusted; empty if its slopes are small."""
    dof = compiled.model.bodies.dof
    steepest = np.abs(result.q[:, dof[b] + N_RIGID : dof[b + 1]] @ axis.slope.T).max(axis=1, initial=0.0)
    if not steepest.max(initial=0.0) > SLOPE:
        return ""
    first = float(result.times[int(np.argmax(steepest > SLOPE))])
    return (
        f"slopes of the beam {compiled.layout.bodies[b]!r} pass {SLOPE:g} at t = {first:.6g} s and reach "
        f"{steepest.max():.3g}: its axial force is that of small slopes, which has no state beyond buckling (weld "
        "several shorter beams instead)"
    )


def _worst(result: Result, compiled: CompiledScene, beams: list[tuple[int, Axis]]) -> list[Worst]:
    """Of each beam, over the instants looked at: the largest, or the median in a run that strikes all the time."""
    if not beams:
        return []
    forces = _Forces(compiled, [b for b, _ in beams])
    instants, calm = _instants(result, compiled, [b for b, _ in beams])
    looked: list[list[FloatArray]] = [[] for _ in beams]
    for k in instants.tolist():
        try:
            found = forces.at(result, k)
        except np.linalg.LinAlgError:  # a state that went astray, which is judged elsewhere
            found = None
        if found is None:
            return [Worst(0.0, 0.0, 0.0) for _ in beams]
        acceleration, pulls = found
        for i, (b, axis) in enumerate(beams):
            looked[i].append(_uncounted(compiled.model, b, axis, result.q[k], result.u[k], acceleration, pulls[b]))
    worst = []
    for (_, axis), histories in zip(beams, looked, strict=True):
        N = np.array(histories)  # (instants, 2, stations)
        if not calm:  # a beam that rings is pulled as often as pressed
            N = np.where(np.sort(N, axis=0)[len(N) // 2] == N, N, 0.0)
        when, side, x = np.unravel_index(int(np.abs(N).argmax()), N.shape)
        worst.append(Worst(float(N[when, side, x]), float(result.times[instants[when]]), float(axis.station[x])))
    return worst


def _instants(result: Result, compiled: CompiledScene, beams: list[int]) -> tuple[IntArray, bool]:
    """Indices of the stored instants to look at, evenly spread; whether they are those without collisions.

    A collision lasts until the slowest vibration of a beam is over. Where hardly an instant is left, all are.
    """
    times, slowest = result.times, slowest_vibrations(compiled.model.bodies)
    held = np.unique(compiled.model.points.body[compiled.model.joints.point])
    slowest[held[held >= 0]] *= CLAMPED
    lasts = float(slowest[beams].max())
    calm = np.ones(len(times), dtype=bool)
    for law, name in enumerate(result.contact_names):
        pushes = _short(result, law, lasts) if name in result.compliant else _strikes(result, law)
        for first, last in pushes:
            calm[(times >= times[first]) & (times <= times[last] + lasts)] = False
    lasting = bool(calm.mean() >= ENOUGH)
    left = np.flatnonzero(calm if lasting else np.ones_like(calm))
    return left[np.unique(np.linspace(0, len(left) - 1, INSTANTS).astype(np.int64))], lasting


def _strikes(result: Result, law: int) -> list[tuple[int, int]]:
    """First and last instant of the impacts of a contact: it takes more impulse than its force at both explains."""
    force = result.force[:, law, 0]
    taken = np.diff(result.impulse[:, law, 0])
    steady = np.minimum(force[1:], force[:-1]) * np.diff(result.times)
    return [(k, k + 1) for k in np.flatnonzero((taken > 0.0) & (taken - steady > STRIKES * taken)).tolist()]


def _short(result: Result, law: int, lasts: float) -> list[tuple[int, int]]:
    """First and last instant of the pushes of a compliant contact that are over within ``lasts`` [s]."""
    pressed = np.concatenate([[False], result.force[:, law, 0] > 0.0, [False]])
    edges = np.flatnonzero(np.diff(pressed.astype(np.int8))).reshape(-1, 2)
    pushes = [(int(first), int(last) - 1) for first, last in edges]
    return [(first, last) for first, last in pushes if result.times[last] - result.times[first] <= lasts]


def _uncounted(
    model: Model, b: int, axis: Axis, q: FloatArray, u: FloatArray, acceleration: FloatArray, pulls: Pulls
) -> FloatArray:
    """N (2, k) before and behind each station that the stiffness of beam b does not count with [N]."""
    d = int(model.bodies.dof[b])
    along = np.array([np.cos(q[d + 2]), np.sin(q[d + 2])])
    x, density = axis.station, float(model.bodies.mass[b]) / axis.length
    carried = float(along @ (model.loads.gravity - acceleration[d : d + 2]))
    N = density * ((axis.length - x) * carried + 0.5 * u[d + 2] ** 2 * (axis.length**2 - x**2))
    before, behind = N.copy(), N
    for station, force in pulls:
        before += (station >= x) * (along @ force)
        behind += (station > x) * (along @ force)
    both = np.stack([before, behind]) - u[d + 2] ** 2 * axis.spin
    other = both - axis.given
    both = np.where(np.abs(other) < np.abs(both), other, both)
    both[0, x <= 0.0] = both[1, x >= axis.length] = 0.0  # past the ends there is no section
    return np.asarray(both)


class _Forces:
    """Accelerations of a scene, and what pulls at its beams, at stored instants."""

    def __init__(self, compiled: CompiledScene, beams: list[int]) -> None:
        self._compiled = compiled
        self._beams = beams
        self._model: Any = pack(compiled.model)
        bodies = compiled.model.bodies
        self._arrow = arrow(len(bodies.mass), len(bodies.stiffness))
        self._loads = [(b, x, pack(compiled.model._replace(loads=one))) for b, x, one in _single(compiled, beams)]
        count, width = int(compiled.model.joints.row[-1]), int(np.diff(bodies.dof).max())
        rows = np.zeros((count, 2, width)), np.zeros((count, 2), dtype=np.int64), np.zeros((count, N_RIGID))
        self._rows = *rows, np.zeros(count), np.zeros(count)
        self._stretching = np.concatenate([_stretching(compiled, b) for b in beams])

    def at(self, result: Result, k: int) -> tuple[FloatArray, dict[int, Pulls]] | None:
        """udot (ndof,) and the pulls at each beam; None where a Python function of the scene cannot be asked again."""
        model, t, q, u = self._model, float(result.times[k]), result.q[k].copy(), result.u[k].copy()
        u[self._stretching] = 0.0
        external = np.zeros((self._compiled.n_external, 3))
        try:
            for callback in self._compiled.callbacks:
                callback.fill(t, self._compiled.state(t, q, u), external)
        except Exception:  # it was asked in the run: what is wrong with it now is no matter of the run
            return None
        pulls: dict[int, Pulls] = {b: [] for b in self._beams}
        force, span = np.zeros_like(q), np.zeros(2)
        for b, x, alone in self._loads:
            force[:] = 0.0
            applied_forces(alone, t, q, u, span, external, force, force, force)
            d = int(self._compiled.model.bodies.dof[b])
            pulls[b].append((x, force[d : d + 2].copy()))
        self._draw(q, u, pulls)
        force[:] = 0.0
        inertial_forces(model.bodies, model.loads, q, u, force)
        elastic_forces(model.bodies, q, u, force, force)
        applied_forces(model, t, q, u, span, external, force, force, force)
        self._press(result, k, q, force, pulls)
        return self._accelerated(t, q, u, external, force, pulls), pulls

    def _draw(self, q: FloatArray, u: FloatArray, pulls: dict[int, Pulls]) -> None:
        """Add the forces of springs and dampers, which may be between two points of one beam."""
        bodies, points, loads = self._model.bodies, self._model.points, self._model.loads
        for k in range(len(loads.spring_kind)):
            ends = [int(p) for p in loads.spring_point[k]]
            if not any(int(points.body[p]) in pulls for p in ends):
                continue
            at, motion, _ = relative_motion(bodies, points, q, u, *ends)
            of = int(loads.spring_kind[k]), at, motion, *loads.spring_axis[k].tolist()
            gx, gy, turn_p, turn_q, _ = coordinate_gradient(*of)
            rate = gx * motion.vx + gy * motion.vy + turn_p * motion.spin_p + turn_q * motion.spin_q
            stiffness, damping, _ = loads.spring_value[k]
            pull = -(stiffness * stretch(self._model, q, k) + damping * rate) * np.array([gx, gy])
            for p, force in zip(ends, (pull, -pull), strict=True):
                if int(points.body[p]) in pulls:
                    pulls[int(points.body[p])].append((float(points.place[p, 0]), force))

    def _press(self, result: Result, k: int, q: FloatArray, force: FloatArray, pulls: dict[int, Pulls]) -> None:
        """Add the contact forces that were stored, on the pairs that touch there."""
        touching = result.contact_points
        pressing = np.flatnonzero((touching.record == k) & (touching.force[:, 0] > 0.0))
        if not len(pressing):
            return
        table, found = near(self._model, q, NEAR * self._compiled.size)
        places = np.array([contact_point(self._model, q, table, i) for i in range(found)]).reshape(found, 2)
        dof = self._compiled.model.bodies.dof
        rows = np.zeros((2, 2, int(np.diff(dof).max())))
        for point in pressing:
            own = np.flatnonzero(table.law[:found] == touching.contact[point])
            if not len(own):
                continue
            i = int(own[np.hypot(*(places[own] - touching.place[point]).T).argmin()])
            contact_rows(self._model, q, table, i, rows[0], rows[1:])
            row = touching.force[point, 0] * rows[0] + touching.force[point, 1] * rows[1]
            for side, b in enumerate(table.body[i].tolist()):
                if b < 0:
                    continue
                force[dof[b] : dof[b + 1]] += row[side, : dof[b + 1] - dof[b]]
                if b in pulls:
                    d, away = int(dof[b]), touching.place[point] - q[dof[b] : dof[b] + 2]
                    pulls[b].append((float(np.cos(q[d + 2]) * away[0] + np.sin(q[d + 2]) * away[1]), row[side, :2]))

    def _accelerated(
        self, t: float, q: FloatArray, u: FloatArray, external: FloatArray, force: FloatArray, pulls: dict[int, Pulls]
    ) -> FloatArray:
        """udot (ndof,); adds the reactions of the joints to the pulls."""
        model, (rows, owner, wrench, rate, bias) = self._model, self._rows
        points, joints, dof = self._compiled.model.points, self._compiled.model.joints, self._compiled.model.bodies.dof
        factorise(model.bodies, q, 0.0, 0.0, self._arrow)
        if not len(rate):
            return self._solved(force)
        joint_rows(model, t, q, u, external, rows, owner, wrench, rate, bias)
        J = np.zeros((len(rate), len(q)))
        for r, side in np.argwhere(owner >= 0).tolist():
            b = int(owner[r, side])
            J[r, dof[b] : dof[b + 1]] += rows[r, side, : dof[b + 1] - dof[b]]
        held = self._held(J)
        J, bias = np.vstack([J, held]), np.concatenate([bias, np.zeros(len(held))])
        free = self._solved(force)
        spread = np.column_stack([self._solved(row) for row in J])
        reaction = -np.linalg.pinv(J @ spread, rcond=REDUNDANT, hermitian=True) @ (J @ free + bias)
        for joint in range(len(joints.point)):
            own = slice(joints.row[joint], joints.row[joint + 1])
            for side in range(2):
                p = int(joints.point[joint, side])
                if int(points.body[p]) in pulls:
                    pulled = reaction[own] @ rows[own, side, :2]
                    pulls[int(points.body[p])].append((float(points.place[p, 0]), pulled))
        return np.asarray(free + spread @ reaction)

    def _held(self, J: FloatArray) -> FloatArray:
        """(k, ndof) rows that keep beams from vibrating along their axis; none where joints hold them there twice."""
        still = J.copy()
        still[:, self._stretching] = 0.0
        if np.linalg.matrix_rank(still) < np.linalg.matrix_rank(J):
            return np.zeros((0, J.shape[1]))
        return np.asarray(np.eye(J.shape[1])[self._stretching])

    def _solved(self, force: FloatArray) -> FloatArray:
        return accelerations(self._model.bodies, self._arrow, force)


def _stretching(compiled: CompiledScene, b: int) -> IntArray:
    """Coordinates of a beam that do not bend it."""
    axis, first = compiled.layout.axes[b], int(compiled.model.bodies.dof[b]) + N_RIGID
    assert axis is not None
    return first + np.flatnonzero(~axis.slope.any(axis=0))


def _single(compiled: CompiledScene, beams: list[int]) -> list[tuple[int, float, Loads]]:
    """Each force on a beam by itself: the beam, the station [m], and loads that are this one only."""
    loads, points = compiled.model.loads, compiled.model.points
    found = []
    for k in np.flatnonzero(loads.force_kind != TORQUE).tolist():
        p, one, none = int(loads.force_point[k]), slice(k, k + 1), slice(0, 0)
        if points.body[p] in beams:
            alone = loads._replace(
                spring_kind=loads.spring_kind[none], spring_point=loads.spring_point[none],
                spring_axis=loads.spring_axis[none], spring_value=loads.spring_value[none],
                force_kind=loads.force_kind[one], force_point=loads.force_point[one],
                force_signal=loads.force_signal[one],
            )  # fmt: skip
            found.append((int(points.body[p]), float(points.place[p, 0]), alone))
    return found
