"""The error of its steps that a result states, from what the run has noted and stored.

It is a sum of local errors: of sampled steps of fixed length (:mod:`lcpflex.steppers.step_error`), or of what the error
control of others accepted, and of impacts. Time stepping puts an impact at the end of a step of length h, at most h/2
from where it belongs on the average, in which places go wrong by e = h/2 |jump of the velocity|. Errors of velocities
go on into places, for as long as a coordinate takes through its range. An impact magnifies what is wrong before it: a
body with corners that is turned by e over its extent is left with another velocity by e |jump of omega|, one that is
struck on a round of radius R by another round by e |jump of the velocity| / R, and this, too, goes on. No error is
larger than twice the range of the motion itself.
"""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from lcpflex.compiled import FloatArray
from lcpflex.steppers.run import Records
from lcpflex.steppers.step_error import ORDER, Units

if TYPE_CHECKING:
    from lcpflex.model import Model
    from lcpflex.result import Result

__all__ = ["accepted", "error_shares", "stated_errors"]

MEAN = 0.3  # of its tolerance: what an accepted step has for an error, ordinarily
SMALL = 1e-6  # of the largest range of a coordinate: a smaller one is rounding
AT_REST = 1e-4  # of the size over the duration: slower is at rest, where rounding is as large as the speed


def accepted(stepper: object, steps: int) -> tuple[float, float, float] | None:
    """What the error control of a stepper accepted in so many steps, as a sum of ratios to its rtol and atol.

    They are in the result; None without error control. Of each step it is taken as :data:`MEAN` of its tolerance.
    """
    adaptive = getattr(stepper, "adaptive", None)
    control = adaptive or getattr(stepper, "integrator", stepper)
    rtol, atol = getattr(control, "rtol", None), getattr(control, "atol", None)
    if rtol is None or atol is None:
        return None
    return MEAN * (0.5 * steps if adaptive else steps), float(rtol), float(atol)  # two steps to an error by doubling


def stated_errors(
    model: Model, records: Records, data: dict[str, FloatArray], steps: int
) -> tuple[float, float] | tuple[None, None]:
    """Errors of places [m] and of velocities [m/s], of the body that is worst off; None where the run has noted none.

    In a user's own system: of a coordinate, over its range, and of its rate, over the largest.
    """
    q, u = data["q"], data["u"]
    if not (len(q) and np.isfinite(q).all() and np.isfinite(u).all()):
        return None, None
    units = Units(model, q.shape[1])
    span = float(data["times"][-1] - data["times"][0])
    ranges = np.array([np.ptp(q, axis=0), np.abs(u).max(axis=0)])
    # 1/omega of a vibration, half the time of a flight
    passing = np.minimum(0.5 * ranges[0] / np.maximum(ranges[1], np.finfo(float).tiny), 0.5 * span)
    local = _local(records, q, u, steps)
    if local is None:
        return None, None
    local[0] = np.maximum(local[0], passing * local[1])
    errors = units.of(np.minimum(local, 2.0 * ranges))
    if records.impact_step > 0.0:
        errors = _with_impacts(errors, units, model, records, data)
        errors = np.minimum(errors, units.of(2.0 * ranges))
    if units.own:
        ranges = np.maximum(ranges, SMALL * ranges.max(axis=1, keepdims=True))
        errors = np.divide(errors, ranges, out=np.zeros_like(errors), where=ranges > 0.0)
    return float(errors[0].max(initial=0.0)), float(errors[1].max(initial=0.0))


def _local(records: Records, q: FloatArray, u: FloatArray, steps: int) -> FloatArray | None:
    """Sums of the local errors of coordinates and rates (2, ndof); None where nothing is known."""
    if records.controlled is not None:
        ratios, rtol, atol = records.controlled
        return np.array([ratios * (atol + rtol * np.abs(values).max(axis=0)) for values in (q, u)])
    found = None if records.sampling is None else records.sampling.found
    return np.abs(found).mean(axis=0) * (ORDER * steps) if found else None


def _with_impacts(
    smooth: FloatArray, units: Units, model: Model, records: Records, data: dict[str, FloatArray]
) -> FloatArray:
    """Errors of places and velocities (2, units) with impacts, which magnify those ``smooth`` ones before them.

    Something strikes between two stored instants where a contact takes more impulse than its force at both explains.
    """
    times, u = data["times"], data["u"]
    taken = np.diff(data["impulse"][:, :, 0], axis=0)
    steady = np.minimum(data["force"][1:, :, 0], data["force"][:-1, :, 0]) * np.diff(times)[:, None]
    struck = (taken - steady > 0.5 * taken) & (taken > 0.0) & records.set_valued
    rows = np.flatnonzero(struck.any(axis=1))
    change = u[rows + 1] - u[rows]
    jumps = units.of(change)
    cornered, radii = _shapes(model, units.count)
    place, speed, before = np.zeros(units.count), np.zeros(units.count), float(times[0])
    drift = smooth[0] / max(float(times[-1] - times[0]), np.finfo(float).tiny)
    for k, row in enumerate(rows.tolist()):
        now = float(times[row + 1])
        place += (now - before) * (speed + drift) + 0.5 * records.impact_step * jumps[k]
        if not units.own:
            first = model.bodies.dof[:-1]
            turning = np.abs(change[k, first + 2]) * cornered
            round_ones = radii[struck[row]]
            curved = np.divide(1.0, round_ones, out=np.zeros_like(round_ones), where=round_ones > 0.0).max(axis=0)
            speed += place * (turning + np.hypot(change[k, first], change[k, first + 1]) * curved)
        before = now
    return np.array([place + (float(times[-1]) - before) * (speed + drift), smooth[1] + speed])


def _shapes(model: Model, count: int) -> tuple[FloatArray, FloatArray]:
    """Whether each body has corners (count,), and of each contact the radius on which a body is struck by a round one.

    The radii (contacts, count) [m] are 0 where a body does not take part, or one of the two surfaces is flat.
    """
    contacts = model.contacts
    cornered, radii = np.zeros(count), np.zeros((len(contacts.friction), count))
    kinds = [contacts.feature_kind[a:b] for a, b in pairwise(contacts.feature_start.tolist())]
    widest = [
        float(np.max(contacts.slave_radius[a:b], initial=0.0)) for a, b in pairwise(contacts.slave_start.tolist())
    ]
    for body, kind in zip(contacts.surface_body.tolist(), kinds, strict=True):
        if body >= 0 and (kind == 0).any():
            cornered[body] = 1.0
    for slave, feature, law in zip(contacts.pass_slave, contacts.pass_feature, contacts.pass_law, strict=True):
        round_feature = (kinds[feature] == 1).all()
        if round_feature and widest[slave] > 0.0:
            own = slice(contacts.feature_start[feature], contacts.feature_start[feature + 1])
            both = widest[slave] + float(np.abs(contacts.feature_radius[own]).max(initial=0.0))
            for surface in (slave, feature):
                if contacts.surface_body[surface] >= 0:
                    radii[law, contacts.surface_body[surface]] = both
    return cornered, radii


def error_shares(result: Result) -> tuple[float, float] | None:
    """Stated errors of places, over the size of the scene or the largest travel, and of velocities, over the largest.

    None where none are stated.
    """
    if result.place_error is None or result.speed_error is None:
        return None
    if result.compiled is None:
        return result.place_error, result.speed_error
    from lcpflex.summary import scene_size

    model = result.compiled.model
    origins = np.concatenate([[d, d + 1] for d in model.bodies.dof[:-1].tolist()])
    moved = (result.q - result.q[0])[:, origins]
    travel = float(np.hypot(moved[:, 0::2], moved[:, 1::2]).max(initial=0.0))
    size = max(scene_size(result) or 0.0, travel)
    speed = float(Units(model, result.q.shape[1]).of(result.u).max(initial=0.0))
    slow = AT_REST * size / result.duration
    tiny = np.finfo(float).tiny
    return result.place_error / max(size, tiny), result.speed_error / max(speed, slow, tiny)
