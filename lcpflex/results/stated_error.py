"""The error of its steps that a result states, from what the run has noted and stored.

It is a sum of local errors: of sampled steps of fixed length (:mod:`lcpflex.steppers.step_error`), or of all that error
control has accepted, and of impacts. Time stepping puts an impact at the end of a step of length h, at most h/2 from
where it belongs on the average, in which places go wrong by h/2 |jump of the velocity|. Errors of velocities go on into
places, for as long as a coordinate takes through its range. An impact magnifies what is wrong before it, and that the
bodies go on by e = h/2 |velocity| before it is taken: one with corners is left with another velocity by e |jump of
omega|, one that is struck on a round of radius R by another round by e |jump of the velocity| / R, and this, too, goes
on. No error is larger than twice the range of the motion itself.
"""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from lcpflex.basics.lengths import lengths
from lcpflex.contact.narrow_phase.feature import SEGMENT
from lcpflex.contact.spatial.kinds import SIDE
from lcpflex.dynamics.mass_matrix import slowest_vibrations
from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.jit.struct import pack
from lcpflex.model.layout import dimension, is_spatial, place_offsets
from lcpflex.steppers.records import Records
from lcpflex.steppers.step_error import ORDER, Units, ranges_of

if TYPE_CHECKING:
    from lcpflex.model.arrays import Model
    from lcpflex.results.result import Result

__all__ = ["error_shares", "has_moved", "stated_errors"]

SMALL = 1e-6  # of the largest range of a coordinate: a smaller one is rounding
GRAZING = 4.0  # velocity over that of the impact, at most: of the push in a contact that goes on, no more is new
CLAMPED = 6.4  # slowest vibration of a beam with one end clamped over that of a free one: a body that is held
MOST = 500  # impacts that are looked at one by one
RESTING = 0.1  # of the duration that a compliant contact lasts: longer is no impact
MOVED = 1e-3  # of the size of the scene: what has moved by less has not, by any point of a body
AT_REST = 1e-4  # of the size over the duration: slower is at rest, where rounding is as large as the speed


def stated_errors(
    model: Model, records: Records, rigid: IntArray, data: dict[str, FloatArray], steps: int, controlled: bool
) -> tuple[float, float] | tuple[None, None]:
    """Errors of places [m] and of velocities [m/s], of the body that is worst off; None where the run has noted none.

    ``rigid``: which contacts are; ``controlled``: whether error control chose the steps, so that the errors of all of
    them are known.
    In a user's own system: of a coordinate, over its range, and of its rate, over the largest.
    """
    q, u = data["q"], data["u"]
    if not (len(q) and np.isfinite(q).all() and np.isfinite(u).all()):
        return None, None
    if is_spatial(model):  # kernels of space go by the name of a struct, which a model put together anew has not
        model = pack(model)
    units = Units(model, u.shape[1])
    if units.own and q.shape[1] != u.shape[1]:  # what errors of its numbers mean is not known
        return None, None
    span = float(data["times"][-1] - data["times"][0])
    ranges = ranges_of(model, q, u)
    # 1/omega of a vibration, half the time of a flight
    with np.errstate(over="ignore"):  # a coordinate that hardly moves is never past
        passing = np.minimum(0.5 * ranges[0] / np.maximum(ranges[1], np.finfo(float).tiny), 0.5 * span)
    local = records.recorder.local.copy() if controlled else _sampled(records, steps)
    if local is None:
        return None, None
    local[0] = np.maximum(local[0], passing * local[1])
    errors = units.of(np.minimum(local, 2.0 * ranges))
    errors = np.minimum(_with_impacts(errors, units, model, records, rigid, data), units.of(2.0 * ranges))
    if units.own:
        ranges = np.maximum(ranges, SMALL * ranges.max(axis=1, keepdims=True))
        errors = np.divide(errors, ranges, out=np.zeros_like(errors), where=ranges > 0.0)
    return float(errors[0].max(initial=0.0)), float(errors[1].max(initial=0.0))


def _sampled(records: Records, steps: int) -> FloatArray | None:
    """Sums of the local errors of coordinates and rates (2, ndof), from those of samples; None without any."""
    found = None if records.sampling is None else records.sampling.found
    return np.abs(found).mean(axis=0) * (ORDER * steps) if found else None


def _with_impacts(
    smooth: FloatArray, units: Units, model: Model, records: Records, rigid: IntArray, data: dict[str, FloatArray]
) -> FloatArray:
    """Errors of places and velocities (2, units) with impacts, which magnify those ``smooth`` ones before them."""
    u, impacts = data["u"], _impacts(rigid, data)
    times = data["times"][[0, *(last for _, last, _ in impacts), -1]]
    place, speed = np.zeros(units.count), np.zeros(units.count)
    grown = np.diff(smooth[0] * _shares(records, units, times), axis=0)
    first, last = np.array([impact[:2] for impact in impacts], dtype=np.int64).reshape(-1, 2).T
    jumps = units.of(u[last] - u[first])
    episodes = (
        None if units.own or not len(impacts) else _Episodes(model, units, records.impact_step, data, first, last)
    )
    for k, (_, _, laws) in enumerate(impacts):
        place += (times[k + 1] - times[k]) * speed + grown[k]
        if rigid[laws].any():
            place += 0.5 * records.impact_step * jumps[k]
        if episodes is not None:
            speed = episodes.magnified(k, laws, place, speed)
    place += (times[-1] - times[-2]) * speed + grown[-1]
    shaken = 0.0 if episodes is None else np.sqrt(episodes.shaken)
    return np.array([place, smooth[1] + speed + shaken])


def _shares(records: Records, units: Units, times: FloatArray) -> FloatArray:
    """Which part of the local errors there has been up to ``times`` (m,), of each unit (m, units)."""
    even = ((times - times[0]) / max(float(times[-1] - times[0]), np.finfo(float).tiny))[:, None]
    if records.sampling is None or not records.sampling.found:
        return np.broadcast_to(even, (len(times), units.count))
    errors = units.of(np.array(records.sampling.found)).max(axis=1)
    when = np.array([times[0], *records.sampling.times])
    total = np.cumsum(np.concatenate([np.zeros((1, units.count)), errors]), axis=0)
    shares = [np.interp(times, when, part / part[-1]) if part[-1] > 0.0 else even[:, 0] for part in total.T]
    return np.stack(shares, axis=1)


def _impacts(rigid: IntArray, data: dict[str, FloatArray]) -> list[tuple[int, int, list[int]]]:
    """First and last stored instant of all impacts with their contacts, in the order of their ends.

    Something strikes between two stored instants where a contact takes more impulse than its force at both explains. A
    compliant contact strikes as long as it takes impulse, unless it rests.
    """
    times, force = data["times"], data["force"][:, :, 0]
    taken = np.diff(data["impulse"][:, :, 0], axis=0)
    steady = np.minimum(force[1:], force[:-1]) * np.diff(times)[:, None]
    struck = (taken - steady > 0.5 * taken) & (taken > 0.0) & rigid
    rows = np.flatnonzero(struck.any(axis=1)).tolist()
    found = [(row, row + 1, np.flatnonzero(struck[row]).tolist()) for row in rows]
    for law in np.flatnonzero(~rigid).tolist():
        edges = np.diff(np.concatenate([[0], taken[:, law] > 0.0, [0]]).astype(np.int8))
        for first, last in zip(np.flatnonzero(edges > 0).tolist(), np.flatnonzero(edges < 0).tolist(), strict=True):
            if times[last] - times[first] <= RESTING * (times[-1] - times[0]):
                found.append((first, last, [law]))
    return _merged(sorted(found, key=lambda impact: impact[1]))


def _merged(impacts: list[tuple[int, int, list[int]]]) -> list[tuple[int, int, list[int]]]:
    """At most ``MOST`` impacts: of a rattle that has more, neighbours are taken together."""
    size = -(-len(impacts) // MOST)
    groups = [impacts[k : k + size] for k in range(0, len(impacts), max(size, 1))]
    return [
        (min(i[0] for i in group), max(i[1] for i in group), sorted({law for i in group for law in i[2]}))
        for group in groups
    ]


class _Episodes:
    """By how much impacts magnify what is wrong before them; those on a vibrating body are one, as long as they last.

    A contact that bounces within the slowest vibration of its body hands momentum to and fro: the body as a whole is
    struck once, by what is left of it in the end.
    """

    def __init__(
        self, model: Model, units: Units, step: float, data: dict[str, FloatArray], first: IntArray, last: IntArray
    ) -> None:
        self._step, size = step, dimension(model.bodies)
        self._moves, self._turns = slice(size.components), slice(size.components, size.rigid)
        self._cornered, self._curved, self._partners = _shapes(model, units)
        self._restitution = model.contacts.restitution
        stiffness = np.zeros(int(model.bodies.dof[-1]))  # of each coordinate, over its mass [1/s^2]
        self._lasts = slowest_vibrations(model.bodies)
        self._unseen = np.zeros(units.count)  # share of its directions in which a body vibrates within a step
        for b, (d, end) in enumerate(pairwise(model.bodies.dof.tolist())):
            own = stiffness[d + size.rigid : end]
            own[:] = model.bodies.stiffness[d - size.rigid * b : end - size.rigid * b - size.rigid]
            self._unseen[b] = np.minimum(1.0, own * step**2 / 12.0).sum() / (len(own) + size.components)
        held = np.unique(model.points.body[model.joints.point])
        self._lasts[held[held >= 0]] *= CLAMPED
        # of all impacts (m, units): begin and end [s], velocities there of frames, and of places, vibrations apart
        times, u, before = data["times"], data["u"], np.maximum(first - 1, 0)
        frames = model.bodies.dof[:-1, None] + np.arange(size.rigid)
        self._begin, self._end, self._spell = times[first], times[last], times[first] - times[before]
        self._rigid, self._left = u[first][:, frames], u[last][:, frames]
        self._fast, self._changed = units.of(u[first]), units.of(u[last] - u[first])
        # a vibration that is met half a step late has another velocity by then
        self._pulled = 0.5 * step * units.of(stiffness * _modal(model, data["q"][first]))
        # by forces other than gravity: what falls freely comes later, but comes
        spell = np.where(self._spell > 0.0, self._spell, np.inf)[:, None, None]
        drawn = (self._rigid - u[before][:, frames])[..., self._moves] / spell
        self._pull = lengths(drawn - model.loads.gravity * np.isfinite(spell))
        self._seen, self._last = np.full(units.count, -np.inf), np.full(len(self._curved), -np.inf)
        self._begun = np.zeros((units.count, size.rigid))  # velocities before the episode
        self._speed = np.zeros(units.count)  # errors before it
        self.shaken = np.zeros(units.count)  # errors of velocities that vibrations are left with, squared

    def magnified(self, k: int, laws: list[int], place: FloatArray, speed: FloatArray) -> FloatArray:
        """Errors of velocities behind impact k, of contacts ``laws``; ``place`` and ``speed``: those before."""
        now, fast, pulled = float(self._end[k]), self._fast[k], self._pulled[k]
        lasts = self._lasts.copy()
        for law in laws:  # a rigid body, too, is struck to and fro by one that vibrates
            lasts[self._partners[law]] = lasts[self._partners[law]].max(initial=0.0)
        fresh = now - self._seen > lasts
        self._begun[fresh], self._speed[fresh] = self._rigid[k][fresh], speed[fresh]
        jump = self._left[k] - self._begun
        moved = lengths(jump[:, self._moves])
        turned, turning = lengths(jump[:, self._turns]), lengths(self._begun[:, self._turns])
        out = speed.copy()
        for law in laws:
            pair = self._partners[law]
            # the impact is taken where the bodies have got to by the end of a step
            met = float(fast[pair].sum())
            off = float(place[pair].sum()) + 0.5 * self._step * met
            parting = float(moved[pair].sum())
            alone = self._begin[k] - self._last[law] > self._spell[k] and not self._lasts[pair].any()
            # which may as well not come at all
            graze = alone and 2.0 * off * self._pull[k][pair].sum() > parting * parting
            self._last[law] = now
            self.shaken[pair] += np.minimum(pulled[pair].sum(), self._changed[k][pair]) ** 2
            # what is reflected is the velocity at the end of a step, vibrations and all
            bounced = self._restitution[law] * self._unseen[pair].max(initial=0.0)
            steep = met / parting if GRAZING * parting > met else GRAZING
            for b in pair.tolist():
                share = moved[b] / parting if moved[b] > 0.0 else 0.0
                spun = self._cornered[b] * (turned[b] + turning[b] * share)
                tilted = moved[b] * (1.0 + steep) * self._curved[law]
                out[b] = max(out[b], self._speed[b] + off * (spun + tilted) + (graze + bounced) * moved[b])
                self._seen[b] = now
        return out


def _shapes(model: Model, units: Units) -> tuple[FloatArray, FloatArray, list[IntArray]]:
    """Whether each body has corners (units,); of each contact by how much its normal turns over a way; its bodies.

    The normal turns by the curvature 1/R [1/m] of one round on another, or, of a side of a body, as that does: by one
    over the extent. It does not on a wall.
    """
    contacts = model.contacts
    cornered, curved = np.zeros(units.count), np.zeros(len(contacts.friction))
    partners: list[set[int]] = [set() for _ in contacts.friction]
    widest = [float(np.max(contacts.node_radius[a:b], initial=0.0)) for a, b in pairwise(contacts.node_start.tolist())]
    straight = [_is_straight(contacts, s) for s in range(len(contacts.surface_body))]
    for body, sides in zip(contacts.surface_body.tolist(), straight, strict=True):
        if body >= 0 and sides:
            cornered[body] = 1.0
    for node, feature, law in zip(contacts.pass_node, contacts.pass_feature, contacts.pass_law, strict=True):
        bodies = [int(b) for b in contacts.surface_body[[node, feature]] if b >= 0]
        partners[law].update(bodies)
        if (not straight[feature] or _is_round(contacts, feature)) and widest[node] > 0.0:
            own = slice(contacts.feature_start[feature], contacts.feature_start[feature + 1])
            radius = widest[node] + float(np.abs(contacts.feature_radius[own]).max(initial=0.0))
            curved[law] = max(curved[law], 1.0 / radius)
        elif len(bodies) == 2:
            extents = [units.extent(b) for b in bodies if cornered[b]]
            curved[law] = max([curved[law], *(1.0 / extent for extent in extents if extent > 0.0)])
    return cornered, curved, [np.array(sorted(pair), dtype=np.int64) for pair in partners]


def _is_round(contacts: Any, surface: int) -> bool:
    """Whether it is round where spheres touch it, although it has flat ends: a cylinder of space."""
    first, last = contacts.feature_start[surface : surface + 2].tolist()
    return not hasattr(contacts, "node_span") and bool((contacts.feature_kind[first:last] == SIDE).any())


def _is_straight(contacts: Any, surface: int) -> bool:
    """Whether a surface has sides or corners: segments, in space anything without a radius."""
    first, last = contacts.feature_start[surface : surface + 2].tolist()
    if hasattr(contacts, "node_span"):
        return bool((contacts.feature_kind[first:last] == SEGMENT).any())
    own = slice(*contacts.node_start[surface : surface + 2].tolist())
    return bool((contacts.feature_radius[first:last] == 0.0).any() or (contacts.node_radius[own] == 0.0).any())


def _modal(model: Model, q: FloatArray) -> FloatArray:
    """Modal coordinates of q (m, nq) in the places of their rates (m, ndof); what is there else has no stiffness."""
    bodies = model.bodies
    place, size = place_offsets(bodies), dimension(bodies)
    found = np.zeros((len(q), int(bodies.dof[-1])))
    for b, (d, end) in enumerate(pairwise(bodies.dof.tolist())):
        found[:, d + size.rigid : end] = q[:, int(place[b]) + size.places : int(place[b + 1])]
    return found


def scene_size(result: Result) -> float | None:
    """Largest extent of a body [m]; None for a system of the user's own or for bodies without outlines."""
    if result.compiled is None:
        return None
    if result.compiled.spatial:
        return result.compiled.size
    points = result.compiled.model.points
    extents = [np.ptp(points.place[points.body == b], axis=0).max() for b in np.unique(points.body) if b >= 0]
    extents += [2.0 * radius for _, radius in result.compiled.layout.circles]
    largest = float(max(extents, default=0.0))
    return largest if largest > 0.0 else None


def error_shares(result: Result) -> tuple[float, float] | None:
    """Stated errors of places, over the size of the scene or the largest travel, and of velocities, over the largest.

    None where none are stated.
    """
    if result.place_error is None or result.speed_error is None:
        return None
    if result.compiled is None:
        return result.place_error, result.speed_error
    model = result.compiled.model
    size = dimension(model.bodies)
    origins = place_offsets(model.bodies)[:-1, None] + np.arange(size.components)
    moved = (result.q - result.q[0])[:, origins]
    travel = float(np.sqrt((moved * moved).sum(axis=2)).max(initial=0.0))
    extent = max(scene_size(result) or 0.0, travel)
    speed = Units(model, result.u.shape[1]).largest(result.u)
    slow = AT_REST * extent / result.duration
    tiny = np.finfo(float).tiny
    return result.place_error / max(extent, tiny), result.speed_error / max(speed, slow, tiny)


def has_moved(model: Model, q: FloatArray, u: FloatArray, size: float) -> bool:
    """Whether any point of a body was MOVED ``size`` [m] away from where it began, by q and u (m, ndof)."""
    numbers = dimension(model.bodies)
    units = Units(model, u.shape[1])
    with np.errstate(all="ignore"):  # what is not finite has moved
        moved = units.of(_modal(model, q - q[:1]))
        for b, place in enumerate(place_offsets(model.bodies)[:-1].tolist()):
            away = q[:, place : place + numbers.places] - q[0, place : place + numbers.places]
            # an angle, or twice the change of four numbers, which is no less for one
            turned = lengths(away[:, numbers.components :]) * (2.0 if is_spatial(model) else 1.0)
            moved[:, b] += lengths(away[:, : numbers.components]) + 0.5 * size * turned
    return not float(moved.max(initial=0.0)) <= MOVED * size
