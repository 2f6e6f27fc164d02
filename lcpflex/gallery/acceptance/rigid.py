"""Acceptance of rigid bodies, with a pendulum and the systems given by their own equations."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from lcpflex.force_laws.penalty import Penalty
from lcpflex.gallery.acceptance import measures
from lcpflex.gallery.acceptance.check import Absent, Check, Entries, Entry, Quantity, Refused
from lcpflex.gallery.mechanisms.flexible import cases as flexible_cases, pendulum
from lcpflex.gallery.mechanisms.rigid import cases, painleve_rod
from lcpflex.gallery.mechanisms.user_systems import cases as user_cases
from lcpflex.steppers.event_driven.stepper import EventDriven
from lcpflex.steppers.generalized_alpha.stepper import GeneralizedAlpha
from lcpflex.steppers.massless_boundary.stepper import MasslessBoundary
from lcpflex.steppers.moreau_jean.stepper import MoreauJean
from lcpflex.steppers.smooth.stepper import ExplicitRungeKutta, Smooth

if TYPE_CHECKING:
    from lcpflex.results.result import Result
    from lcpflex.runs.case import Case

__all__ = ["checks"]

NO_MODES = Refused(MasslessBoundary(), "compliance", "rigid bodies have no modes that could be massless")
RESTITUTION = Refused(MasslessBoundary(), "restitution", "refuses a coefficient of restitution; rigid bodies")
USERS_OWN = Refused(MasslessBoundary(), "user's own system", "a user's own system has no modes that could be massless")
LAW = Penalty(1e6, damping=10.0, slip_speed=1e-4)
FORCE_LAW = Smooth(LAW)
BOUNCES = Absent("no restitution in a force law", FORCE_LAW, "restitution")
NO_LOSS = Absent("an impact without rebound is no part of a force law")
LOOSE = ExplicitRungeKutta(rtol=1e-6, atol=1e-9)


def checks() -> tuple[Check, ...]:
    """Those of this module."""
    known = {case.name: case for case in (*cases(), *user_cases(), *flexible_cases())}
    return (
        _ball(known["bouncing_ball"]),
        _bounce(known["oblique_bounce"]),
        _balls(known["three_balls"]),
        _rocking(known["rocking_block"]),
        _incline(known["incline"]),
        _sticking(known["incline_sticks"]),
        _stick_slip(known["stick_slip"]),
        _spring(known["spring_block"]),
        _kane(known["double_pendulum"]),
        _painleve(known["painleve_rod"], 0.5, 60.0, 0.908694),
        _painleve(known["painleve_rod"], 2.0, 30.0, 1.533922),
        _slider(known["slider_crank"]),
        _woodpecker(known["woodpecker"]),
        _pendulum(known["pendulum"]),
    )


def _three(step: float, slow: bool = False) -> Entries:
    """Entries of the rigid steppers."""
    return {
        "Moreau-Jean": Entry(MoreauJean(step=step), slow=slow),
        "event-driven": Entry(EventDriven(), slow=slow),
        "generalised-alpha": Entry(GeneralizedAlpha(step=step), slow=slow),
    }


def _of(
    case: Case, *names: tuple[str, str, Callable[[Result], float]], scale: float | None = None
) -> tuple[Quantity, ...]:
    """Quantities named as the references of the case."""
    return tuple(
        Quantity(name.replace("_", " "), case.reference[name], unit, take, scale) for name, unit, take in names
    )


def _ball(case: Case) -> Check:
    quantities = _of(case, ("first_impact", "s", measures.first_impact), ("rest_time", "s", measures.rest))
    return Check(case, quantities, {**_three(1e-5), "massless boundary": RESTITUTION, "smooth": BOUNCES}, record=1e-5)


def _bounce(case: Case) -> Check:
    quantities = _of(
        case,
        ("normal_impulse", "N s", measures.total_impulse),
        ("tangential_impulse", "N s", lambda r: float(r.impulse[-1, 0, 1])),
        ("v_x", "m/s", measures.last_speed(0)),
        ("v_y", "m/s", measures.last_speed(1)),
        ("omega", "rad/s", measures.last_speed(2)),
    )
    entries = {**_three(1e-3), "massless boundary": RESTITUTION, "smooth": BOUNCES}
    return Check(case, quantities, entries, duration=0.1)


def _balls(case: Case) -> Check:
    quantities = _of(case, *((f"v_{k + 1}", "m/s", measures.last_speed(3 * k)) for k in range(3)))
    entries = {**_three(1e-3), "massless boundary": RESTITUTION, "smooth": BOUNCES}
    return Check(case, quantities, entries, duration=0.1)


def _rocking(case: Case) -> Check:
    def ratio(result: Result) -> float:
        rate = result.u[:, 2]
        k = int(np.argmax(np.abs(np.diff(rate)) * (result.times[1:] > 0.3)))
        return float(rate[k + 1] / rate[k])

    quantities = _of(case, ("first_impact", "s", measures.first_impact_of_rate), ("rate_ratio", "", ratio))
    entries = {**_three(2e-5), "massless boundary": NO_MODES, "smooth": NO_LOSS}
    return Check(case, quantities, entries, duration=0.4, record=2e-5)


def _incline(case: Case) -> Check:
    def stop(result: Result) -> float:
        return measures.first_stop(result.times, measures.along_slope(result)[1])

    def back(result: Result) -> float:
        return float(-measures.along_slope(result)[1][-1] / (result.times[-1] - stop(result)))

    quantities = _of(
        case,
        ("stop_time", "s", stop),
        ("stop_distance", "m", lambda r: float(measures.along_slope(r)[0].max())),
        ("slide_back", "m/s^2", back),
    )
    return Check(case, quantities, {**_three(1e-5), **_smooth()}, record=1e-4)


def _smooth(why: str = "") -> Entries:
    """Rigid friction: the massless boundary refuses, the force law creeps."""
    return {"massless boundary": NO_MODES, "smooth": Entry(Smooth(LAW, integrator=LOOSE), why)}


def _sticking(case: Case) -> Check:
    def drift(result: Result) -> float:
        distance = measures.along_slope(result)[0]
        return float(np.ptp(distance[result.times > 0.5]))

    quantities = (Quantity("drift in 1 s", 0.0, "m", drift, 1.0),)
    return Check(
        case, quantities, {**_three(1e-4), **_smooth("it creeps at v_s artanh(tan 30 / mu)")}, duration=1.5, record=1e-3
    )


def _stick_slip(case: Case) -> Check:
    quantities = _of(
        case,
        ("slip_time", "s", lambda r: measures.slips(r)[0]),
        ("stick_time", "s", lambda r: measures.slips(r)[1]),
        ("displacement", "m", measures.end_of(0)),
    )
    late = "a regularised law slips from tanh(1) mu N on, and creeps below; the displacement of a slip is met"
    # the place where it sticks is met to a small part of the tolerance of a step at most by luck
    entries = {**_three(1e-5), "event-driven": Entry(EventDriven(rtol=1e-9)), **_smooth(late)}
    return Check(case, quantities, entries, duration=1.8, record=1e-5)


def _spring(case: Case) -> Check:
    half = np.pi / 100.0

    def turn(k: int, result: Result) -> float:
        x = result.q[np.abs(result.times - k * half) < 0.5 * half, 0]
        return float(x.min() if k % 2 else x.max())

    quantities = (
        *_of(case, *((f"turn_{k}", "m", partial(turn, k)) for k in (1, 2, 3)), ("rest", "m", measures.end_of(0))),
        *_of(case, ("rest_time", "s", lambda r: measures.slips(r)[1])),
    )
    return Check(case, quantities, {**_three(1e-6), **_smooth("what Coulomb friction would hold creeps")}, record=1e-6)


def _kane(case: Case) -> Check:
    def gain(result: Result) -> float:
        return float(result.energies.kinetic[1] / result.energies.kinetic[0] - 1.0)

    quantities = _of(
        case,
        ("upper_rate", "rad/s", lambda r: float(r.u[1, 2])),
        ("lower_rate", "rad/s", lambda r: float(r.u[1, 5])),
        ("normal_impulse", "N s", lambda r: float(r.impulse[1, 0, 0])),
        ("tangential_impulse", "N s", lambda r: float(r.impulse[1, 0, 1])),
        ("energy_gain", "", gain),
    )
    entries = {**_three(1e-8), "massless boundary": RESTITUTION, "smooth": BOUNCES}
    return Check(case, quantities, entries, duration=1e-8)


def _painleve(case: Case, friction: float, degrees: float, force: float) -> Check:
    case = replace(case, build=partial(painleve_rod, friction=friction, degrees=degrees))
    quantities = (Quantity("force", force, "N", lambda r: float(r.force[1, 0, 0])),)
    late = Absent("the force of a law builds up with the penetration: there is none at the start")
    entries = {**_three(1e-7), "massless boundary": NO_MODES, "smooth": late}
    name = f"painleve_rod, mu = {friction:g}, {degrees:g} deg"
    return Check(case, quantities, entries, duration=1e-6, record=1e-7, name=name)


def _slider(case: Case) -> Check:
    def hit(result: Result) -> int:
        return int(np.flatnonzero(result.impulse[:, :, 0].sum(axis=1))[0])

    quantities = _of(
        case,
        ("first_impact", "s", lambda r: float(r.times[hit(r)])),
        ("crank_before", "rad/s", lambda r: float(r.u[hit(r) - 1, 0])),
        ("crank_after", "rad/s", lambda r: float(r.u[hit(r), 0])),
        ("rod_before", "rad/s", lambda r: float(r.u[hit(r) - 1, 1])),
        ("rod_after", "rad/s", lambda r: float(r.u[hit(r), 1])),
        ("impulse", "N s", lambda r: float(r.impulse[hit(r), :, 0].sum())),
        ("energy_before", "J", lambda r: float(r.energies.stored[hit(r) - 1])),
        ("energy_after", "J", lambda r: float(r.energies.stored[hit(r)])),
    )
    entries = {**_three(2e-6), "massless boundary": USERS_OWN, "smooth": BOUNCES}
    return Check(case, quantities, entries, duration=0.0028, record=2e-6)


def _woodpecker(case: Case) -> Check:
    def pecks(result: Result) -> list[float]:
        beak = result.contact("beak")
        located = [event.time for event in result.events if event.kind == "impact" and event.contact == "beak"]
        times = np.array(located or beak.times[1:][np.diff(beak.impulse[:, 0]) > 0.0])
        return [float(times[times > after][0]) for after in (0.0, 0.15, 0.3)]

    def descent(result: Result) -> float:
        height = np.interp(pecks(result)[1:], result.times, result.q[:, 0])
        return float(height[0] - height[1])

    quantities = _of(
        case,
        ("first_peck", "s", lambda r: pecks(r)[0]),
        ("second_peck", "s", lambda r: pecks(r)[1]),
        ("third_peck", "s", lambda r: pecks(r)[2]),
        ("period", "s", lambda r: pecks(r)[2] - pecks(r)[1]),
        ("descent", "m", descent),
    )
    entries = {**_three(2e-5, slow=True), "massless boundary": USERS_OWN, "smooth": BOUNCES}
    return Check(case, quantities, entries, duration=0.39, record=2e-5)


def _pendulum(case: Case) -> Check:
    case = replace(case, build=partial(pendulum, modes=0, friction=0.0))
    quantities = (Quantity("tip speed", -1.4618, "m/s", lambda r: float(r.velocity("pendulum", "right")[-1, 1])),)
    entries = {**_three(1e-4), **_smooth()}
    return Check(case, quantities, entries, duration=0.1, name="rigid pendulum at 0.1 s")
