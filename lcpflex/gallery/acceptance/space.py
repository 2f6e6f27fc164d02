"""Acceptance of bodies and mechanisms in space."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from lcpflex.gallery.acceptance.check import Check, Entries, Entry, Quantity
from lcpflex.gallery.mechanisms.space import cases
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


def checks() -> tuple[Check, ...]:
    """Those of this module."""
    known = {case.name: case for case in cases()}
    return (
        _free(known["dzhanibekov"]),
        _steady(known["heavy_top"]),
        _released(known["released_top"]),
        _driven(known["driven_slider_crank"]),
        _running(known["free_slider_crank"]),
        _swinging(known["spherical_pendulum"]),
    )


def _entries(step: float, rtol: float = 1e-8) -> Entries:
    return {
        "Moreau-Jean": Entry(MoreauJean(step=step)),
        "event-driven": Entry(EventDriven(rtol=rtol)),
        "generalised-alpha": Entry(GeneralizedAlpha(step=step)),
        "massless boundary": Entry(MasslessBoundary(step=step)),
        "smooth": Entry(Smooth(integrator=ExplicitRungeKutta(rtol=rtol))),
    }


def _of(case: Case, *names: tuple[str, str, Callable[[Result], float], float]) -> tuple[Quantity, ...]:
    """Quantities named as the references of the case, and what their errors are divided by."""
    return tuple(
        Quantity(name.replace("_", " "), case.reference[name], unit, take, scale) for name, unit, take, scale in names
    )


def _free(case: Case) -> Check:
    def spin(i: int) -> Callable[[Result], float]:
        return lambda r: float(r.u[-1, 3 + i])

    def place(i: int) -> Callable[[Result], float]:
        return lambda r: float(r.q[-1, 3 + i] * np.sign(r.q[-1, 3]))  # p and -p are one rotation

    spins = (("omega_x", "rad/s", spin(0), 5.0), ("omega_y", "rad/s", spin(1), 5.0), ("omega_z", "rad/s", spin(2), 5.0))
    places = tuple((f"p_{i}", "", place(i), 1.0) for i in range(4))
    return Check(case, _of(case, *spins, *places), _entries(1e-3))


def _axis(result: Result) -> FloatArray:
    """Axis of the top, world axes (m, 3)."""
    return np.asarray(result.orientation("top").apply([0.0, 0.0, 1.0]))


def _lean(result: Result) -> FloatArray:
    axis = _axis(result)
    return np.asarray(np.arctan2(np.hypot(axis[:, 0], axis[:, 1]), axis[:, 2]))


def _turn(places: FloatArray) -> float:
    """Angle about the vertical from the first place to the last [rad]."""
    angle = np.unwrap(np.arctan2(places[:, 1], places[:, 0]))
    return float(angle[-1] - angle[0])


def _steady(case: Case) -> Check:
    quantities = _of(
        case,
        ("lean", "rad", lambda r: float(_lean(r)[-1]), 1.0),
        ("precession", "rad/s", lambda r: _turn(_axis(r)) / float(r.times[-1]), case.reference["precession"]),
    )
    return Check(case, quantities, _entries(1e-4), record=1e-3)


def _released(case: Case) -> Check:
    quantities = _of(
        case,
        ("largest_lean", "rad", lambda r: float(_lean(r).max()), 1.0),
        ("turn", "rad", lambda r: _turn(_axis(r)), 1.0),
    )
    return Check(case, quantities, _entries(1e-4), record=1e-4)


def _driven(case: Case) -> Check:
    quantities = _of(
        case,
        ("x_3", "m", lambda r: float(r.q[-1, 7]), 1.0),
        ("v_3", "m/s", lambda r: float(r.u[-1, 6]), 1.0),
    )
    return Check(case, quantities, _entries(1e-3))


def _running(case: Case) -> Check:
    quantities = _of(
        case,
        ("theta_5", "rad", lambda r: float(np.unwrap(2.0 * np.arctan2(r.q[:, 4], r.q[:, 3]))[-1]), 1.0),
        ("rate_5", "rad/s", lambda r: float(r.u[-1, 3]), case.reference["rate_5"]),
        ("x_5", "m", lambda r: float(r.q[-1, 7]), 1.0),
    )
    return Check(case, quantities, _entries(1e-3), record=1e-2)


def _swinging(case: Case) -> Check:
    def theta(result: Result) -> float:
        x, y, z = result.q[-1, :3]
        return float(np.arctan2(np.hypot(x, y), -z))

    quantities = _of(case, ("theta", "rad", theta, 1.0), ("phi", "rad", lambda r: _turn(r.q[:, :3]), 1.0))
    return Check(case, quantities, _entries(1e-3), record=1e-2)
