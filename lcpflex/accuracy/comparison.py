"""How far two runs of the same bodies are apart at equal times: places, rotations, velocities off impacts, forces.

Velocities jump at an impact, and two runs take it at times that differ a little: near one, a difference tells of that
time alone. So velocities of a body, and forces on it, are compared where neither run has an impact within a window, on
the body or on those that joints tie to it. ``rms`` has these times, too.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from lcpflex.basics.lengths import lengths
from lcpflex.compile.touched_pairs import pair_of
from lcpflex.jit.struct import pack
from lcpflex.kinematics.configuration import difference
from lcpflex.model.layout import SPACE, dimension, place_offsets
from lcpflex.results.motion_units import Units, scene_size
from lcpflex.results.watched_places import gyration

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lcpflex.jit.kernel import FloatArray
    from lcpflex.results.result import Result

__all__ = [
    "Around",
    "Bodies",
    "Differences",
    "around",
    "bodies_of",
    "differences",
    "grid_of",
    "impacts",
    "joined",
    "places_apart",
    "places_between",
    "rates_between",
    "sizes_of",
    "values_at",
    "window_of",
]

SAME = 1e-9  # of the duration: instants nearer than that are one; free: steps are summed up to 1e-12
BENT = (
    0.1  # of the change of the velocity: at a steady acceleration the way is the mean velocity's; at a jump it is not
)
STRAIGHT = 1e-3  # of the way, which velocities that hardly change tell to rounding
SUDDEN = 0.5  # of the impulse between two instants that the forces at both do not explain: an impact
SMALLEST = 1e-9  # of the largest number of q: what is smaller is near to the rounding of places
AT_REST = 1e-4  # of the extent over the duration: slower is at rest, where rounding is as large as the speed
STILL = 1e-6  # of the largest range of a user's coordinates: a smaller one is rounding


class Bodies(NamedTuple):
    """What the differences of two runs are measured in."""

    names: tuple[str, ...]
    units: Units
    model: Any
    own: bool  # a user's own system: of its coordinates, over their ranges
    group: NDArray[np.int64]  # (nb,) bodies that joints tie together have the same number
    ranges: tuple[FloatArray, FloatArray]  # of a user's own coordinates and velocities


class Differences(NamedTuple):
    """Of two runs at nt equal times, of nb bodies or of a user's coordinates; NaN where velocities are not compared."""

    times: FloatArray  # (nt,) [s]
    place: FloatArray  # (nt, nb) of the worst point, rotation apart [m]
    turn: FloatArray  # (nt, nb) rotation times extent [m]
    speed: FloatArray  # (nt, nb) of the worst point [m/s]
    rms: FloatArray  # (nb,) of velocities, impacts included [m/s]
    gap: dict[str, FloatArray]  # (nt,) by contact; 0 where either is farther than gaps are measured [m]
    force: dict[str, float]  # by contact, off impacts [N]
    impulse: dict[str, float]  # by contact [N s]


def bodies_of(result: Result) -> Bodies:
    """What the differences of runs of this scene are measured in."""
    compiled = result.compiled
    if compiled is None or not len(compiled.model.bodies.mass):
        return _own(result)
    model = compiled.model
    if dimension(model.bodies) is SPACE:  # kernels of space go by the name of a struct
        model = pack(model)
    count = len(model.bodies.mass)
    none = np.ones(0)
    return Bodies(
        compiled.layout.bodies, Units(model, result.u.shape[1]), model, False, joined(model, count), (none,) * 2
    )


def _own(result: Result) -> Bodies:
    """Of a user's own system: every coordinate is a body, all of them tied together."""
    names = tuple(f"q {k + 1}" for k in range(result.q.shape[1]))
    ranges = []
    for values in (np.ptp(result.q, axis=0), np.abs(result.u).max(axis=0, initial=0.0)):
        floor = max(STILL * float(values.max(initial=0.0)), np.finfo(float).tiny)
        ranges.append(np.maximum(values, floor))
    group = np.zeros(len(names), dtype=np.int64)
    return Bodies(names, Units(_NoBodies(), result.u.shape[1]), None, True, group, (ranges[0], ranges[1]))


def joined(model: Any, count: int) -> NDArray[np.int64]:
    """(nb,) numbers of the groups of bodies that joints tie together; the ground ties nothing."""
    ties = model.points.body[model.joints.point].reshape(-1, model.joints.point.shape[-1])
    first, last = ties[:, 0], ties[:, -1]
    both = (first >= 0) & (last >= 0)
    graph = coo_array((np.ones(int(both.sum())), (first[both], last[both])), shape=(count, count))
    return np.asarray(connected_components(graph, directed=False)[1], dtype=np.int64)


def grid_of(result: Result, until: float = np.inf) -> NDArray[np.int64]:
    """Rows of the stored instants up to ``until`` [s], of those at one time the last."""
    last = np.append(result.times[1:] > result.times[:-1], True) if len(result.times) else np.zeros(0, dtype=bool)
    return np.flatnonzero(last & (result.times <= until * (1.0 + SAME)))


class Around(NamedTuple):
    """Between which stored instants k times are: rows before and behind, the share of the way, their distance [s]."""

    row: NDArray[np.int64]
    behind: NDArray[np.int64]
    share: FloatArray  # (k, 1)
    span: FloatArray  # (k,)


def around(times: FloatArray, at: FloatArray) -> Around:
    """Between which stored instants some times are; of two instants at one time the later is taken."""
    slack = SAME * float(max(times[-1], at[-1]))
    row = np.clip(np.searchsorted(times, at + slack, side="right") - 1, 0, len(times) - 1)
    behind = np.minimum(row + 1, len(times) - 1)
    span = times[behind] - times[row]
    share = np.where(span > 0.0, (at - times[row]) / np.where(span > 0.0, span, 1.0), 0.0)
    share = np.where(share * span > slack, np.minimum(share, 1.0), 0.0)[:, None]
    return Around(row, behind, share, span)


def values_at(result: Result, at: FloatArray, bodies: Bodies) -> tuple[FloatArray, FloatArray, NDArray[np.int64]]:
    """q and u at some times, and the stored instants before or at them; linear between instants.

    Of two instants at one time the later is taken.
    """
    held = around(result.times, at)
    q = places_between(result.q, None if bodies.own else result.u, held)
    return q, rates_between(result.u, held), held.row


def rates_between(u: FloatArray, held: Around) -> FloatArray:
    """Velocities between stored instants: linear."""
    return np.asarray((1.0 - held.share) * u[held.row] + held.share * u[held.behind])


def places_between(q: FloatArray, u: FloatArray | None, held: Around) -> FloatArray:
    """Places between two instants: a cubic by the velocities at both where its bend is small, else straight."""
    row, behind, share, span = held
    found = (1.0 - share) * q[row] + share * q[behind]
    inside = np.flatnonzero(share[:, 0] > 0.0)
    if not len(inside) or u is None or q.shape[1] != u.shape[1]:
        return np.asarray(found)
    a, b, s = q[row[inside]], q[behind[inside]], share[inside]
    h = span[inside, None]
    v, w = h * u[row[inside]], h * u[behind[inside]]
    way = b - a
    bent = s * (1.0 - s) * ((1.0 - s) * (v - way) - s * (w - way))
    # where a velocity jumps in between, the path has a corner and no cubic follows it
    smooth = np.abs(way - 0.5 * (v + w)) <= BENT * np.abs(v - w) + STRAIGHT * np.abs(way)
    found[inside] += np.where(smooth, bent, 0.0)
    return np.asarray(found)


def differences(result: Result, other: Result, bodies: Bodies, window: float) -> Differences:
    """How far two runs are apart, up to the end of the shorter one; impacts within ``window`` [s] free velocities."""
    rows, times, place, turn, u, held = _compared(result, other, bodies)
    fast = _speeds_apart(result.u[rows], u, other, times, held, bodies)
    near = [freed(one, bodies, times, window) for one in (result, other)]
    off = ~(near[0] | near[1])
    speed = np.where(off, fast, np.nan)
    square = 0.5 * (fast[1:] ** 2 + fast[:-1] ** 2) * np.diff(times)[:, None]
    rms = np.sqrt(square.sum(axis=0) / max(float(times[-1] - times[0]), np.finfo(float).tiny))
    return Differences(times, place, turn, speed, rms, *_contacts(result, rows, other, held, bodies, off))


def places_apart(result: Result, other: Result, bodies: Bodies) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Times (nt,), and how far places and rotations times extent are apart then, (nt, nb) each; see Differences."""
    return _compared(result, other, bodies)[1:4]


def _compared(result: Result, other: Result, bodies: Bodies) -> tuple[Any, ...]:
    """Stored rows of ``result`` and their times, places and turns apart, and what ``other`` does then."""
    rows = grid_of(result, float(other.times[-1]))
    times = result.times[rows]
    q, u, held = values_at(other, times, bodies)
    return rows, times, *_apart(result.q[rows], q, bodies), u, held


def _apart(q: FloatArray, other: FloatArray, bodies: Bodies) -> tuple[FloatArray, FloatArray]:
    """(nt, nb) distances of places and of rotations times extent [m]."""
    if bodies.own:
        return np.abs(q - other) / bodies.ranges[0], np.zeros_like(q)
    return bodies.units.parts(_change(bodies.model, q, other))


def _change(model: Any, q: FloatArray, other: FloatArray) -> FloatArray:
    """(nt, ndof) what moves each of ``q`` to ``other``."""
    if dimension(model.bodies) is not SPACE:
        return other - q
    change = np.zeros((len(q), int(model.bodies.dof[-1])))
    for row, a, b in zip(change, np.ascontiguousarray(q), np.ascontiguousarray(other), strict=True):
        difference(model, a, b, row)
    return change


def _speeds_apart(
    mine: FloatArray, theirs: FloatArray, other: Result, times: FloatArray, held: NDArray[np.int64], bodies: Bodies
) -> FloatArray:
    """(nt, nb) differences of velocities; where the other has an impact between two instants, from the nearer one.

    It may be anywhere between them, or at the same time but for rounding: no motion has a velocity within a jump.
    """
    found = _speeds(theirs - mine, bodies)
    slack = SAME * float(max(other.times[-1], times[-1]))
    first = np.minimum(np.searchsorted(other.times, times - slack), held)
    inside = times > other.times[held] + slack
    last = np.where(inside, np.minimum(held + 1, len(other.times) - 1), held)
    jumps = freed(other, bodies, times, slack) & (last > first)[:, None]
    rows = np.flatnonzero(jumps.any(axis=1))
    ends = [_speeds(other.u[at[rows]] - mine[rows], bodies) for at in (first, last)]
    found[rows] = np.where(jumps[rows], np.minimum(*ends), found[rows])
    return found


def _speeds(change: FloatArray, bodies: Bodies) -> FloatArray:
    """(nt, nb) differences of velocities, of the point of each body that is worst off [m/s]."""
    if not bodies.own:
        return np.asarray(sum(bodies.units.parts(change)))
    shares = np.abs(change) / bodies.ranges[1]
    if shares.shape[1] == len(bodies.names):
        return np.asarray(shares)
    # more numbers than velocities: which belongs to which is not known
    return np.repeat(shares.max(axis=1, keepdims=True, initial=0.0), len(bodies.names), axis=1)


def freed(result: Result, bodies: Bodies, times: FloatArray, window: float) -> NDArray[np.bool_]:
    """(nt, nb) whether an impact on a body, or on one tied to it by joints, is within ``window`` [s] of a time."""
    count = len(bodies.names)
    found = np.zeros((len(times), count), dtype=bool)
    struck = impacts(result)
    groups = bodies.group
    for law in np.flatnonzero(struck.any(axis=0)).tolist():
        hit = _hit(result, bodies, result.contact_names[law])
        if not hit.any():
            continue
        own = np.isin(groups, np.unique(groups[hit]))
        rows = np.flatnonzero(struck[:, law])
        begin, end = result.times[rows] - window, result.times[rows + 1] + window
        first, last = np.searchsorted(times, begin, side="left"), np.searchsorted(times, end, side="right")
        marks = np.zeros(len(times) + 1)
        np.add.at(marks, first, 1.0)
        np.add.at(marks, last, -1.0)
        found[:, own] |= (np.cumsum(marks)[:-1] > 0.0)[:, None]
    return found


def impacts(result: Result) -> NDArray[np.bool_]:
    """(m - 1, nc) whether a contact strikes between two stored instants: more impulse than the forces at both explain.

    A contact with a law of its force does not: its velocities are continuous.
    """
    rigid = ~np.isin(result.contact_names, result.compliant)
    taken = np.diff(result.impulse[:, :, 0], axis=0)
    force = result.force[:, :, 0]
    steady = np.minimum(force[1:], force[:-1]) * np.diff(result.times)[:, None]
    return np.asarray((taken - steady > SUDDEN * taken) & (taken > 0.0) & rigid)


def _hit(result: Result, bodies: Bodies, name: str) -> NDArray[np.bool_]:
    """(nb,) the bodies of a contact."""
    found = np.zeros(len(bodies.names), dtype=bool)
    if bodies.own or result.compiled is None:
        return ~found
    contacts = result.compiled.model.contacts
    at = np.flatnonzero(contacts.pass_law == result.contact_names.index(name))
    touched = contacts.surface_body[np.concatenate([contacts.pass_node[at], contacts.pass_feature[at]])]
    if not len(at):  # a pair under the rule of the scene
        pair = pair_of(result.compiled, name)
        touched = contacts.surface_body[list(pair)] if pair else np.arange(len(found))
    found[touched[touched >= 0]] = True
    return found


def _contacts(
    result: Result, rows: NDArray[np.int64], other: Result, held: NDArray[np.int64], bodies: Bodies, off: Any
) -> tuple[dict[str, FloatArray], dict[str, float], dict[str, float]]:
    """Differences of gaps (nt,) [m], the largest of forces off impacts [N] and of impulses [N s], by contact.

    What never touched under a rule has neither force nor gap.
    """
    gap, force, impulse = {}, {}, {}
    for name in dict.fromkeys((*result.contact_names, *other.contact_names)):
        mine, theirs = (_history(run, name, at) for run, at in ((result, rows), (other, held)))
        own = _hit(result if name in result.contact_names else other, bodies, name)
        away = off[:, own].all(axis=1)
        gap[name] = np.nan_to_num(np.abs(mine[2] - theirs[2]))
        apart = lengths(mine[0] - theirs[0])
        force[name] = float(apart[away].max(initial=0.0))
        impulse[name] = float(lengths(mine[1] - theirs[1]).max(initial=0.0))
    return gap, force, impulse


def _history(result: Result, name: str, rows: NDArray[np.int64]) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Force, impulse and gap of a contact at some instants; zeros, and no gap, where it never touched."""
    if name not in result.contact_names:
        none = np.zeros((len(rows), result.force.shape[2]))
        return none, none, np.full(len(rows), np.nan)
    k = result.contact_names.index(name)
    return result.force[rows, k], result.impulse[rows, k], result.gap[rows, k]


class _NoBodies:
    """A model without bodies."""

    class _None:
        mass = second = dof = body = place = surface_body = np.zeros(0)

    bodies = points = contacts = _None


def window_of(result: Result, others: Sequence[Result]) -> float:
    """Within which time an impact frees velocities [s]: two of the longest steps that put impacts at their ends."""
    longest = max(run.impact_step for run in (result, *others))
    return max(2.0 * longest, SAME * float(result.times[-1]))


def sizes_of(result: Result, bodies: Bodies) -> tuple[float, float]:
    """Largest extent of a body or way of its origin [m], and largest speed of a point [m/s]; of own systems 1.

    A body without an outline is as large as its radius of gyration, and nothing is smaller than rounding of places.
    """
    if bodies.own or result.compiled is None:
        return 1.0, 1.0
    way = 0.0
    for moved in _ways(result, bodies):
        way = max(way, float(moved.max(initial=0.0)))
    size = scene_size(result) or max(gyration(result.compiled, b) for b in range(len(bodies.names)))
    extent = max(size, way, SMALLEST * float(np.abs(result.q).max(initial=0.0)), np.finfo(float).tiny)
    span = float(result.times[-1] - result.times[0])
    fastest = float(np.max(sum(bodies.units.parts(result.u)), initial=0.0))
    return extent, max(fastest, AT_REST * extent / span)


def _ways(result: Result, bodies: Bodies) -> list[FloatArray]:
    """How far the origin of each body was from where it began [m]."""
    components = dimension(bodies.model.bodies).components
    starts = place_offsets(bodies.model.bodies)[:-1].tolist()
    return [lengths(result.q[:, k : k + components] - result.q[0, k : k + components]) for k in starts]
