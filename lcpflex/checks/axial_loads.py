"""Axial forces of beams in a run, against what their stiffness counts with and against small slopes.

The bending of a linear beam does not feel its axial force N, which changes the square of its lowest frequency by about
N / N_Euler, N_Euler = pi^2 E I / L^2. At stored instants N(x) follows from the equilibrium of the part behind x,

    N(x) = sum of F_i over x_i > x + integral from x to L of rho A (g - a) dx',   a = Rddot - omega^2 x'

along the axis of the frame, deflections left out. F_i are loads, springs, contacts, and reactions of joints, from
M udot = h + W p + J^T lambda, J udot + b = 0. Beams do not vibrate along their axis there, which is over many times
while they bend once, unless their stretching shares what joints hold more than once. Collisions are left out until the
beam has vibrated once: they take no time to bend it. Where something always strikes, the median over time is taken.
Beams that count with their actual axial force are of small slopes: beyond SLOPE the result is not to be trusted. Nor is
that of one that does not, and bears more than it buckles under, for as long as that takes: it has no such state.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import numpy as np

from lcpflex.basics.alarm import Alarm
from lcpflex.checks.grown import has_grown
from lcpflex.compile.compiled_scene import CompiledScene
from lcpflex.dynamics.mass_matrix import slowest_vibrations
from lcpflex.errors import LcpflexError
from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.model.arrays import Axis, Model
from lcpflex.model.layout import is_spatial
from lcpflex.model.planar import N_RIGID
from lcpflex.model.recovery import SpatialLineShapes
from lcpflex.results.result import Result
from lcpflex.results.stored_instants import tells_of_steps

if TYPE_CHECKING:
    from lcpflex.checks.beam_forces import BeamForces, Pulls

__all__ = ["axial_loads_at", "with_axial_loads"]

SHARE = 0.03  # of Euler's load, from where on a linear beam warns
BUCKLED = 0.999  # of the load at which a beam buckles: what loads that are given as that come to
OUT, BENT = 0.5, 0.5  # of that load, and slope of the beam from the chord of its frame: it has gone out of its way
CLAMPED = 6.4  # slowest vibration of a beam with one end clamped over that of a free one: a body that is held
LASTS = 0.25  # of its slowest vibration: for so long at least it bears more
SLOPE = 0.1  # beyond which the strain u' + w'^2 / 2 is none
INSTANTS, IN_SPACE = 200, 20  # looked at, at most, in the plane and in space
STRIKES = 0.5  # of the impulse between two instants that forces do not explain, from where on it is that of an impact
ENOUGH = 0.2  # of the instants, to look at those without collisions only


@dataclass(frozen=True, slots=True)
class Worst:
    """The largest axial force that a beam does not count with."""

    force: float  # [N], tension positive
    time: float  # [s]
    station: float  # [m]
    share: float = 0.0  # of the load at which it buckles, held as it is then
    buckles: bool = False  # whether it bears more than that for as long as that takes


def with_axial_loads(result: Result) -> Result:
    """The result with a warning for each linear beam under axial load, and without trust where slopes are too large."""
    compiled = result.compiled
    if compiled is None or has_grown(result):
        return result
    if is_spatial(compiled.model):
        return _in_space(result, compiled)
    if not any(compiled.layout.axes):
        return result
    warnings, wrong = list(result.warnings), list(result.found_wrong)
    wrong += [text for b, axis in _beams(compiled, actual=True) if (text := _too_steep(result, compiled, b, axis))]
    linear = _beams(compiled, actual=False)
    for (b, axis), worst in zip(linear, _worst(result, compiled, linear), strict=True):
        if abs(worst.force) > SHARE * axis.euler:
            (wrong if worst.buckles else warnings).append(_told(compiled.layout.bodies[b], axis, worst))
    return replace(result, warnings=tuple(map(str, warnings)), found_wrong=tuple(wrong))


def _in_space(result: Result, compiled: CompiledScene) -> Result:
    """The same of a spatial scene."""
    beams = [b for b, shapes in enumerate(compiled.recovery) if isinstance(shapes, SpatialLineShapes)]
    if not beams or len(result.times) < 2:
        return result
    from lcpflex.checks.spatial_axial_loads import spatial_axial_loads  # which scenes without beams do without
    from lcpflex.results.section_forces import mean_step

    instants, calm = _instants(result, compiled, beams)
    instants = instants[np.unique(np.linspace(0, len(instants) - 1, IN_SPACE).astype(np.int64))]
    warnings: list[str] = []
    wrong: list[str] = []
    for b in beams:
        try:
            told, buckles = spatial_axial_loads(result, compiled, b, instants, calm, LASTS, mean_step(result))
        except (LcpflexError, np.linalg.LinAlgError):  # functions that are not there, a state that went astray
            continue
        if told:
            (wrong if buckles else warnings).append(told)
    if not (warnings or wrong):
        return result
    return replace(result, warnings=(*result.warnings, *map(str, warnings)), found_wrong=(*result.found_wrong, *wrong))


def axial_loads_at(compiled: CompiledScene, t: float, q: FloatArray, touching: Any) -> tuple[list[str], list[str]]:
    """Warnings of linear beams under axial load at a place of rest q at time t [s], and clauses: which ones buckle.

    touching: as the ``contact_points`` of a result with one instant.
    """
    if is_spatial(compiled.model):
        return _in_space_at(compiled, t, q, touching)
    beams = _beams(compiled, actual=False)
    warnings: list[str] = []
    wrong: list[str] = []
    if not beams:
        return warnings, wrong
    from lcpflex.checks.beam_forces import BeamForces  # which scenes without beams do without
    from lcpflex.checks.buckling import critical_share

    still = np.zeros_like(q)
    rest: Any = SimpleNamespace(times=np.array([t]), q=q[None], u=still[None], contact_points=touching)
    forces = BeamForces(compiled, [b for b, _ in beams])
    found = forces.at(rest, 0)
    for b, axis in beams if found is not None else []:
        assert found is not None
        N = _uncounted(compiled.model, b, axis, q, still, found[0], found[1][b])
        side, x = np.unravel_index(int(np.abs(N).argmax()), N.shape)
        force = float(N[side, x])
        if not abs(force) > SHARE * axis.euler:
            continue
        share = critical_share(compiled, b, axis, q, _inside(N), forces.supports) if N.min() < 0.0 else 0.0
        worst = Worst(force, t, float(axis.station[x]), share, _gives_way(compiled, b, axis, q, share))
        (wrong if worst.buckles else warnings).append(_told(compiled.layout.bodies[b], axis, worst))
    return warnings, wrong


def _in_space_at(compiled: CompiledScene, t: float, q: FloatArray, touching: Any) -> tuple[list[str], list[str]]:
    """The same of a spatial scene."""
    beams = [b for b, shapes in enumerate(compiled.recovery) if isinstance(shapes, SpatialLineShapes)]
    warnings: list[str] = []
    wrong: list[str] = []
    if not beams:
        return warnings, wrong
    from lcpflex.checks.spatial_axial_loads import spatial_axial_loads  # which scenes without beams do without

    pressed = np.zeros((1, len(compiled.layout.contacts), 1))
    np.add.at(pressed, (0, touching.contact, 0), touching.force[:, 0])
    still = np.zeros((1, len(compiled.u)))
    rest: Any = SimpleNamespace(
        times=np.array([t]), q=q[None], u=still, force=pressed, contact_points=touching, outside=None
    )
    for b in beams:
        told, buckles = spatial_axial_loads(rest, compiled, b, np.zeros(1, np.int64), True, 0.0, 0.0)
        if told:
            (wrong if buckles else warnings).append(told)
    return warnings, wrong


def _beams(compiled: CompiledScene, actual: bool) -> list[tuple[int, Axis]]:
    """Beams that bend, with the actual axial force or without."""
    modes = np.diff(compiled.model.bodies.dof) - N_RIGID
    axes = enumerate(compiled.layout.axes)
    return [(b, axis) for b, axis in axes if axis is not None and axis.actual == actual and modes[b]]


def _told(name: str, axis: Axis, worst: Worst) -> Alarm:
    kind = "compression" if worst.force < 0.0 else "tension"
    share = 100.0 * abs(worst.force) / axis.euler
    feels, buckled = "its bending does not feel that", ""
    if worst.share > 0.0:
        buckled = f" and {100.0 * worst.share:.3g} % of the load at which it buckles, held as it is"
    if worst.buckles:
        feels = f"it has no such state, and {feels}"
    clause = (
        f"beam {name!r}: {kind} of {abs(worst.force):.4g} N at x = {worst.station:.4g} m, t = {worst.time:.6g} s, "
        f"{share:.2g} % of its Euler load pi^2 E I / L^2 = {axis.euler:.4g} N{buckled}: {feels}"
    )
    advice = 'take stiffening=Stiffening(axial_force="actual") of a beam with axial=True'
    return Alarm(clause, "axial load", f"beam {name!r}", worst.time, worst.force, advice)


def _too_steep(result: Result, compiled: CompiledScene, b: int, axis: Axis) -> Alarm | None:
    """Why a beam that counts with its axial force is not to be trusted; None if its slopes are small."""
    dof = compiled.model.bodies.dof
    steepest = np.abs(result.q[:, dof[b] + N_RIGID : dof[b + 1]] @ axis.slope.T).max(axis=1, initial=0.0)
    if not steepest.max(initial=0.0) > SLOPE:
        return None
    first = float(result.times[int(np.argmax(steepest > SLOPE))])
    name, most = f"beam {compiled.layout.bodies[b]!r}", float(steepest.max())
    clause = (
        f"slopes of the {name} pass {SLOPE:g} at t = {first:.6g} s and reach {most:.3g}, while its axial force is that "
        "of small slopes, which has no state beyond buckling"
    )
    return Alarm(clause, "slope", name, first, most, "weld several shorter beams instead")


def _worst(result: Result, compiled: CompiledScene, beams: list[tuple[int, Axis]]) -> list[Worst]:
    """Of each beam, over the instants looked at: the largest, or the median in a run that strikes all the time."""
    if not beams:
        return []
    from lcpflex.checks.beam_forces import BeamForces  # which scenes without beams do without

    forces = BeamForces(compiled, [b for b, _ in beams])
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
        every = N = np.array(histories)  # (instants, 2, stations)
        if not calm:  # a beam that rings is pulled as often as pressed
            N = np.where(np.sort(N, axis=0)[len(N) // 2] == N, N, 0.0)
        when, side, x = np.unravel_index(int(np.abs(N).argmax()), N.shape)
        largest = Worst(float(N[when, side, x]), float(result.times[instants[when]]), float(axis.station[x]))
        least = every.min(axis=(1, 2))
        usual = int(least.argmin() if calm else np.argsort(least)[len(least) // 2])
        worst.append(_with_share(result, compiled, forces, instants, every, usual, (b, axis), largest))
    return worst


def _with_share(
    result: Result, compiled: CompiledScene, forces: BeamForces, instants: IntArray, N: FloatArray, when: int,
    beam: tuple[int, Axis], worst: Worst,
) -> Worst:  # fmt: skip
    """The same with its share of the load at which the beam buckles, under N (instants, 2, stations) at ``when``."""
    b, axis = beam
    least = N.min(axis=(1, 2))
    if not -least[when] > SHARE * axis.euler:
        return worst
    k = int(instants[when])
    from lcpflex.checks.buckling import critical_share  # which most beams do without

    forces.at(result, k)
    share = critical_share(compiled, b, axis, result.q[k], _inside(N[when]), forces.supports)
    # instants are spread evenly over the run, or over the part of it without collisions
    level = BUCKLED if share >= BUCKLED else OUT
    lasts = float((-least * share >= -least[when] * level).mean() * (result.times[-1] - result.times[0]))
    slow = LASTS * float(slowest_vibrations(compiled.model.bodies)[b])
    gives_way = _gives_way(compiled, b, axis, result.q[k], share)
    return replace(worst, share=share, buckles=gives_way and lasts >= slow)


def _inside(N: FloatArray) -> FloatArray:
    """N (k,) at stations, of that before and behind each (2, k); at the ends, where loads are, that beside them."""
    profile = np.asarray(N.mean(axis=0))
    profile[[0, -1]] = N[0, 1], N[1, -2]
    return profile


def _gives_way(compiled: CompiledScene, b: int, axis: Axis, q: FloatArray, share: float) -> bool:
    """Whether a beam bears more than it buckles under, or has bent out from under such a load, which is less then."""
    dof = compiled.model.bodies.dof
    steepest = float(np.abs(axis.slope @ q[dof[b] + N_RIGID : dof[b + 1]]).max(initial=0.0))
    return share >= BUCKLED or (share >= OUT and steepest >= BENT)


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
    if tells_of_steps(result) and result.contact_names and len(left) > 1 and left[0] == 0:
        left = left[1:]  # of contacts nothing is known before the first step
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
