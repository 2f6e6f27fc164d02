"""Acceptance of bodies that slide, roll and spin on planes in space."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from lcpflex.force_laws.penalty import Penalty
from lcpflex.gallery.acceptance.check import Check, Entries, Entry, Quantity, Refused
from lcpflex.gallery.mechanisms.space_contact import DISC, LARGE, LARGE_AT, cases, euler_rate
from lcpflex.steppers.event_driven.stepper import EventDriven
from lcpflex.steppers.generalized_alpha.stepper import GeneralizedAlpha
from lcpflex.steppers.massless_boundary.stepper import MasslessBoundary
from lcpflex.steppers.moreau_jean.stepper import MoreauJean
from lcpflex.steppers.smooth.stepper import ExplicitRungeKutta, Smooth

if TYPE_CHECKING:
    from lcpflex.jit.kernel import FloatArray
    from lcpflex.results.result import Result
    from lcpflex.runs.case import Case

__all__ = ["checks"]

RIGID_BODIES = Refused(MasslessBoundary(), "compliance", "rigid bodies have no modes that could be massless")
GIVES = "the floor gives way, and friction is regularised"
ROLLS = "rolling creeps under regularised friction, and the floor gives way"
LOOSE = ExplicitRungeKutta(rtol=1e-6, atol=1e-9)
SLIDING = Entry(Smooth(Penalty(stiffness=1e7, damping=10.0, slip_speed=1e-4), integrator=LOOSE), GIVES)
ROLLING = Entry(Smooth(Penalty(stiffness=1e6, damping=100.0, slip_speed=1e-3), integrator=LOOSE), ROLLS)
TURNING = Entry(Smooth(Penalty(stiffness=1e6, damping=10.0, slip_speed=1e-4), integrator=LOOSE), GIVES)


def checks() -> tuple[Check, ...]:
    """Those of this module."""
    known = {case.name: case for case in cases()}
    return (
        _ball(known["billiard_ball"]),
        _slope(known["sliding_puck"]),
        _puck(known["puck"]),
        _euler(known["euler_disc"]),
        _rolling(known["rolling_disc"]),
        _tippe(known["tippe_top"]),
    )


def _entries(step: float, by_law: Entry) -> Entries:
    return {
        "Moreau-Jean": Entry(MoreauJean(step=step)),
        "event-driven": Entry(EventDriven(rtol=1e-8)),
        "generalised-alpha": Entry(GeneralizedAlpha(step=step)),
        "massless boundary": RIGID_BODIES,
        "smooth": by_law,
    }


def _of(case: Case, *names: tuple[str, str, Callable[[Result], float], float]) -> tuple[Quantity, ...]:
    """Quantities named as the references of the case, and what their errors are divided by."""
    return tuple(
        Quantity(name.replace("_", " "), case.reference[name], unit, take, scale) for name, unit, take, scale in names
    )


def _speed(i: int, sign: float = 1.0) -> Callable[[Result], float]:
    return lambda result: sign * float(result.u[-1, i])


def _ball(case: Case) -> Check:
    """Of a sphere the spin about the normal is that about z in world axes."""

    def spin(result: Result) -> float:
        return float(result.angular_velocity("ball")[-1, 2])

    quantities = _of(
        case,
        ("v_x", "m/s", _speed(0), 2.0),
        ("v_y", "m/s", _speed(1), 2.0),
        ("spin", "rad/s", spin, 30.0),
    )
    return Check(case, quantities, _entries(1e-3, SLIDING))


def _slope(case: Case) -> Check:
    quantities = _of(case, ("across", "m/s", _speed(0), 1.0), ("down", "m/s", _speed(1, -1.0), 1.0))
    return Check(case, quantities, _entries(1e-4, SLIDING))


def _angle(result: Result) -> float:
    """By which a body has turned about the vertical [rad]."""
    return float(np.unwrap(2.0 * np.arctan2(result.q[:, 6], result.q[:, 3]))[-1])


def _puck(case: Case) -> Check:
    quantities = _of(
        case,
        ("x", "m", lambda r: float(r.q[-1, 0]), case.reference["x"]),
        ("y", "m", lambda r: float(r.q[-1, 1]), case.reference["x"]),
        ("angle", "rad", _angle, 1.0),
    )
    return Check(case, quantities, _entries(1e-4, SLIDING), record=1e-2)


def _axis(result: Result, body: str) -> FloatArray:
    """(m, 3) axis of a body that turns about its z, world axes."""
    axis: FloatArray = result.orientation(body).apply([0.0, 0.0, 1.0])
    return axis


def _euler(case: Case) -> Check:
    def inclination(result: Result) -> float:
        axis = _axis(result, "disc")[-1]
        return math.atan2(math.hypot(axis[0], axis[1]), axis[2])

    def rate(result: Result) -> float:
        """Mean rate at which the axis goes around."""
        axis = _axis(result, "disc")
        turned = np.unwrap(np.arctan2(axis[:, 1], axis[:, 0]))
        return float(abs(turned[-1] - turned[0]) / result.times[-1])

    def moved(result: Result) -> float:
        """Of the centre, which stays."""
        return float(np.abs(result.q[:, :3] - result.q[0, :3]).max())

    quantities = _of(
        case,
        ("inclination", "rad", inclination, 1.0),
        ("rate", "rad/s", rate, case.reference["rate"]),
        ("moved", "m", moved, DISC),
    )
    return Check(case, quantities, _entries(5e-4, ROLLING), record=math.pi / euler_rate(60.0) / 8.0)


def _rolling(case: Case) -> Check:
    def lean(result: Result) -> float:
        return -math.asin(_axis(result, "disc")[-1, 2])

    quantities = _of(case, ("lean", "rad", lean, case.reference["largest_lean"]))
    return Check(case, quantities, _entries(5e-4, ROLLING), record=0.1)


def _tippe(case: Case) -> Check:
    """Jellett's number: L . (a_1 e_3 - r_1 e_z)."""
    inertia = np.array([8e-7, 8e-7, 7e-7])

    def lean(result: Result) -> float:
        return math.acos(_axis(result, "top")[-1, 2])

    def jellett(result: Result) -> float:
        turned = result.orientation("top")[[0, -1]]
        arm = LARGE_AT * turned.apply([0.0, 0.0, 1.0]) - LARGE * np.array([0.0, 0.0, 1.0])
        first, last = np.einsum("ij,ij->i", turned.apply(inertia * result.u[[0, -1], 3:6]), arm)
        return float(last / first)

    quantities = _of(case, ("lean_at_1_s", "rad", lean, 1.0), ("Jellett's_number", "", jellett, 1.0))
    return Check(case, quantities, _entries(1e-4, TURNING), duration=1.0, record=0.1)
