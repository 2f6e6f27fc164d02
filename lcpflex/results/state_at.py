"""The state of a run at any time, from what it has stored, and never across what it has not.

Between two stored instants a motion without a velocity jump is the polynomial with the places and velocities at both
(cubic Hermite), or at three where the middle of each step was kept (degree 5). A step of a time-stepping scheme with a
jump is moved by its parts: with the velocity before it, then with the one behind it. A motion q = a cos(omega t) stored
h apart is found up to (omega h)^4 / 384 a by two instants; where omega h > 0.3 or impulses tell of a touch in between,
nothing is told. In space the same is done in coordinates about the first of these instants
(:mod:`lcpflex.results.spatial.chart`), so that what comes out is a rotation.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from lcpflex.basics.arguments import flag
from lcpflex.basics.attributes import NamesNearest
from lcpflex.errors import ModelError, in_range
from lcpflex.model.arrays import OPEN
from lcpflex.model.planar import N_RIGID
from lcpflex.results.material_points import deflection_of, place_of, velocity_of
from lcpflex.results.polynomials import hermite, lagrange
from lcpflex.results.stored_instants import DENSE, at_events, each_step, impulse_noise, tells_of_steps

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lcpflex.compile.compiled_scene import CompiledScene
    from lcpflex.jit.kernel import FloatArray, IntArray
    from lcpflex.results.result import Result
    from lcpflex.results.spatial.chart import SpatialChart

__all__ = ["StateAt", "state_at"]

TURN = 0.3  # omega h that two instants resolve: an error below TURN^3 / 384 of the path between them
SAME = 1e-12  # of the duration: times that count as the same
ROUNDING = 1e-9  # of places and of the fastest motion: what drift and rounding leave


@dataclass(frozen=True, slots=True, eq=False)
class StateAt(NamesNearest):
    """The state at one time: nc contacts, nj joints, ndof coordinates, as in :class:`lcpflex.Result`.

    Attributes
    ----------
    time
        [s].
    q, u
        (nq,) coordinates and (ndof,) velocities [m], [rad], [kg^1/2 m] and by the second, as in the result.
    force
        (nc, 2), in space (nc, 4): normal force and friction of each contact [N], interpolated between instants; of
        rigid contacts under time stepping, which has their impacts in it, that of the step.
    state
        (nc,) OPEN, STICK, SLIP or CREEP, of the nearest instant or of the step.
    joint_force
        (nj, 3) F_x, F_y [N] and M [N m] of each joint, world axes, interpolated, or under time stepping the mean
        between both instants; None where none were recorded.
    how
        "stored", "dense" (degree 5), "cubic", or "parts" of a step with a velocity jump.
    """

    time: float
    q: FloatArray
    u: FloatArray
    force: FloatArray
    state: NDArray[np.int8]
    joint_force: FloatArray | None
    how: str
    _of: CompiledScene | None = field(default=None, repr=False)

    def point(self, body: str, point: str | tuple[float, ...]) -> FloatArray:
        """Place of a material point, (2,) or (3,) [m], world axes; see :meth:`lcpflex.Result.point`."""
        return place_of(self._of, self.q, body, point)

    def velocity(self, body: str, point: str | tuple[float, ...]) -> FloatArray:
        """Velocity of a material point, (2,) or (3,) [m/s], world axes; see :meth:`lcpflex.Result.velocity`."""
        return np.asarray(velocity_of(self._of, self.q[None], self.u[None], body, point)[0])

    def deflection(self, body: str, point: str | tuple[float, ...]) -> FloatArray:
        """Displacement of a material point, (2,) or (3,) [m], body axes; see :meth:`lcpflex.Result.deflection`."""
        return deflection_of(self._of, self.q, body, point)


def state_at(result: Result, t: float, before: bool = False) -> StateAt:
    """See :meth:`lcpflex.Result.at`."""
    times = result.times
    if not len(times):
        raise ModelError("at: this result holds no stored instant; expected one of a run that began")
    slack = SAME * float(times[-1] - times[0])
    t = in_range("t", t, float(times[0]) - slack, float(times[-1]) + slack)
    t = min(max(t, float(times[0])), float(times[-1]))
    first, behind = np.searchsorted(times, t, "left"), np.searchsorted(times, t, "right")
    if behind > first:
        return _stored(result, int(first if flag("before", before) else behind - 1))
    flag("before", before)
    k = int(first) - 1
    if result.compiled is None and result.q.shape[1] != result.u.shape[1]:
        raise ModelError(
            f"t: {t:.9g} s was given, between stored instants of a system with kinematics of its own, which a result "
            "does not know; expected one of result.times"
        )
    if result.stored == DENSE and at_events(result):
        return _smooth(result, t, k, _triple(times, k), "dense")
    gained = _gained(result, k)
    if not tells_of_steps(result) or not each_step(result):
        _refuse_unseen(result, t, k, gained)
    elif np.any(gained & ((result.state[k] == OPEN) | (result.state[k + 1] == OPEN))):
        return _by_parts(result, t, k)
    return _smooth(result, t, k, slice(k, k + 2), "cubic")


def _stored(result: Result, k: int) -> StateAt:
    joints = None if result.joint_force is None else result.joint_force[k].copy()
    return StateAt(
        float(result.times[k]), result.q[k].copy(), result.u[k].copy(), result.force[k].copy(),
        result.state[k].copy(), joints, "stored",
        result.compiled,
    )  # fmt: skip


def _triple(times: FloatArray, k: int) -> slice:
    """Start, middle and end of the step in which the interval behind instant k lies; two of them where it was cut."""
    same = np.flatnonzero(np.diff(times[: k + 1]) <= 0.0)
    start = int(same[-1]) + 1 if len(same) else 0  # of the motion since the last event
    first = start + 2 * ((k - start) // 2)
    whole = first + 2 < len(times) and bool(np.all(np.diff(times[first : first + 3]) > 0.0))
    return slice(first, first + 3) if whole else slice(k, k + 2)


def _gained(result: Result, k: int) -> NDArray[np.bool_]:
    """Which rigid contacts took an impulse behind instant k."""
    return np.asarray(_rigid(result) & np.any(result.impulse[k + 1] != result.impulse[k], axis=1))


def _rigid(result: Result) -> NDArray[np.bool_]:
    """Which contacts are no continuous force, (nc,)."""
    return np.array([name not in result.compliant for name in result.contact_names], dtype=bool)


def _smooth(result: Result, t: float, k: int, rows: slice, how: str) -> StateAt:
    times, path = result.times[rows], _path(result, rows)
    q, u = path.state(*hermite(times, path.places, path.rates, t))
    nearest = k + 1 if tells_of_steps(result) or t - result.times[k] > result.times[k + 1] - t else k
    force = lagrange(times, result.force[rows], t)
    if tells_of_steps(result):  # which put an impact among the forces of a step
        rigid = _rigid(result)
        force[rigid] = result.force[k + 1, rigid]
    joints = result.joint_force
    if joints is not None:
        joints = joints[k + 1].copy() if tells_of_steps(result) else lagrange(times, joints[rows], t)
    return StateAt(t, q, u, force, result.state[nearest].copy(), joints, how, result.compiled)


def _in_space(result: Result) -> bool:
    return result.compiled is not None and hasattr(result.compiled.model.bodies, "place")


class _Path:
    """Coordinates and their rates (m, ndof) at a few instants, and the state that others of them are."""

    def __init__(self, places: FloatArray, rates: FloatArray, chart: SpatialChart | None = None) -> None:
        self.places, self.rates = places, rates
        self._chart = chart

    def state(self, place: FloatArray, rate: FloatArray) -> tuple[FloatArray, FloatArray]:
        """q and u of coordinates and their rates (ndof,)."""
        return (place, rate) if self._chart is None else self._chart.state(place, rate)

    def number(self, coordinate: int) -> int:
        """Of q, the one that goes with a coordinate."""
        return coordinate if self._chart is None else self._chart.number(coordinate)


def _path(result: Result, rows: slice) -> _Path:
    q, u = result.q[rows], result.u[rows]
    if not _in_space(result):
        return _Path(q, u)
    from lcpflex.results.spatial.chart import SpatialChart

    bodies: Any = result.compiled.model.bodies if result.compiled is not None else None
    chart = SpatialChart(bodies, q[0])
    return _Path(*chart.coordinates(q, u), chart)


def _by_parts(result: Result, t: float, k: int) -> StateAt:
    """A step in which velocities jump at one instant, where both parts meet best in the metric of the masses.

    Moreau's q+ = q + h ((1 - theta) u + theta u+) is met exactly, at (1 - theta) h. What is left of other schemes,
    which differ by the curvature of the path, is shared by both parts.
    """
    h = float(result.times[k + 1] - result.times[k])
    since = t - float(result.times[k])
    weight, path = _masses(result)[0], _path(result, slice(k, k + 2))
    q, u = path.places, path.rates
    jump = weight * (u[0] - u[1])
    square = float(jump @ jump)
    s = float(np.clip(jump @ (weight * (q[1] - q[0] - h * u[1])) / square, 0.0, h)) if square > 0.0 else 0.5 * h
    left = q[1] - q[0] - s * u[0] - (h - s) * u[1]
    if since < s:
        place, velocity = q[0] + since * u[0] + 0.5 * since / s * left, result.u[k]
    else:
        share = 0.0 if s == h else 0.5 * (h - since) / (h - s)
        place, velocity = q[1] - (h - since) * u[1] - share * left, result.u[k + 1]
    joints = result.joint_force
    return StateAt(
        t, path.state(place, velocity)[0], velocity.copy(), result.force[k + 1].copy(), result.state[k + 1].copy(),
        None if joints is None else joints[k + 1].copy(), "parts",
    )  # fmt: skip


def _masses(result: Result) -> tuple[FloatArray, IntArray]:
    """Square root of the inertia of each coordinate, modes having 1, and the body it belongs to, (ndof,) each.

    A user's own system tells neither: each of its coordinates is by itself.
    """
    ndof = result.u.shape[1]
    if result.compiled is None:
        return np.ones(ndof), np.arange(ndof)
    bodies: Any = result.compiled.model.bodies
    if _in_space(result):
        from lcpflex.results.spatial.chart import square_roots_of_masses

        return square_roots_of_masses(bodies)
    owner = np.repeat(np.arange(len(bodies.mass)), np.diff(bodies.dof))
    weight = np.ones(ndof)
    for b, d in enumerate(bodies.dof[:-1]):
        weight[d : d + N_RIGID] = np.sqrt(bodies.mass[b])
        weight[d + N_RIGID - 1] = np.sqrt(bodies.inertia[b])
    return weight, owner


def _refuse_unseen(result: Result, t: float, k: int, gained: NDArray[np.bool_]) -> None:
    """Raise ModelError where what happened behind instant k was not stored closely enough."""
    why = ""
    if tells_of_steps(result) and gained.any():
        why = f"in which contact {result.contact_names[int(np.argmax(gained))]!r} took impulses that may jump"
    elif (contact := _hidden_touch(result, k)) is not None:
        why = f"in which contact {result.contact_names[contact]!r} had other forces than at both"
    elif (coordinate := _unresolved(result, k)) is not None:
        name = result.coordinate_names()[_path(result, slice(k, k + 2)).number(coordinate)]
        why = f"between which {name} turns too far to be interpolated"
    if not why:
        return
    more = "record='dense' stores what is needed" if at_events(result) else "record=0 stores each step"
    if result.stored != "instants":
        more = "record='dense' stores what is needed" if at_events(result) else "shorter steps (max_step) would tell"
    raise ModelError(
        f"t: {t:.9g} s was given, between the stored instants {result.times[k]:.9g} and {result.times[k + 1]:.9g} s, "
        f"{why}; expected a run with a smaller record ({more}), or one of result.times"
    )


def _hidden_touch(result: Result, k: int) -> int | None:
    """A contact the impulse of which is not that of forces between those at both instants."""
    h = float(result.times[k + 1] - result.times[k])
    ends = result.force[k : k + 2]
    if tells_of_steps(result) and not result.compliant:
        return None
    gained = result.impulse[k + 1] - result.impulse[k]
    largest = np.abs(ends).max(axis=0)
    noise = max(impulse_noise(result), ROUNDING) * np.abs(result.impulse[[k, k + 1, -1]]).max(axis=(0, 2))[:, None]
    off = np.abs(gained - 0.5 * h * ends.sum(axis=0)) > 0.5 * h * largest * (1.0 + ROUNDING) + noise
    found = np.flatnonzero(off.any(axis=1))
    return int(found[0]) if len(found) else None


def _unresolved(result: Result, k: int) -> int | None:
    """A coordinate that two instants do not resolve: from r = q+ - q - h (u + u+) / 2 = -h^3 q''' / 12.

    omega h is estimated by the square root of 12 r / (h v), and the error of the cubic by r omega h / 32; v is the
    larger speed. An error that is as small beside the path of its body counts as none.
    """
    h = float(result.times[k + 1] - result.times[k])
    weight, owner = _masses(result)
    path = _path(result, slice(k, k + 2))
    q, u = weight * path.places, np.abs(weight * path.rates)
    r = np.abs(q[1] - q[0] - 0.5 * h * weight * (path.rates[0] + path.rates[1]))
    v = np.maximum(u.max(axis=0), np.abs(q[1] - q[0]) / h)
    fastest = np.sqrt(2.0 * max(float(result.energies.kinetic.max()), 0.0))
    speed = np.sqrt(np.bincount(owner, v**2))[owner]
    place = np.sqrt(np.bincount(owner, np.abs(q).max(axis=0) ** 2))[owner]
    with np.errstate(divide="ignore", invalid="ignore"):
        turn = np.nan_to_num(np.sqrt(12.0 * r / (h * v)), nan=0.0, posinf=np.inf)
    error = r * np.minimum(turn / 32.0, 1.0)
    small = error <= TURN**3 / 384.0 * h * speed + ROUNDING * (place + h * fastest)
    found = np.flatnonzero((turn > TURN) & ~small)
    return int(found[0]) if len(found) else None
