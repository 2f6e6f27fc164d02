"""Acceptance of the ball on a plate of many modes."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from lcpflex.gallery.acceptance.check import Check, Entries, Entry, Quantity, Refused
from lcpflex.gallery.mechanisms.plates import BALL_SPEED, BALL_TIME, cases
from lcpflex.steppers.event_driven.stepper import EventDriven
from lcpflex.steppers.generalized_alpha.stepper import GeneralizedAlpha
from lcpflex.steppers.massless_boundary.stepper import MasslessBoundary
from lcpflex.steppers.moreau_jean.stepper import MoreauJean

if TYPE_CHECKING:
    from lcpflex.results.result import Result

__all__ = ["checks", "contact_time", "restitution"]

MODES = "the plate has 408 modes: the error falls as their number, to 2e-5 and 1e-4 with 3500"


def checks() -> tuple[Check, ...]:
    """Those of this module."""
    (case,) = cases()
    quantities = (
        Quantity("restitution", case.reference["restitution"], "", restitution),
        Quantity("contact time", case.reference["contact_time"], "s", contact_time),
    )
    entries: Entries = {
        "Moreau-Jean": Entry(MoreauJean(step=1e-3 * BALL_TIME), MODES),
        "event-driven": Entry(EventDriven(rtol=1e-8), MODES),
        "generalised-alpha": Refused(GeneralizedAlpha(step=1e-3 * BALL_TIME), "force law", "takes no force laws"),
        "massless boundary": Refused(MasslessBoundary(), "force law", "takes a law as compliance, without its damping"),
        "smooth": Entry(case.stepper, MODES),
    }
    return (Check(case, quantities, entries, record=BALL_TIME / 200.0),)


def restitution(result: Result) -> float:
    """Speed of the ball at the end over that before."""
    assert result.compiled is not None
    first = int(result.compiled.model.bodies.dof[result.compiled.layout.bodies.index("ball")])
    return float(result.u[-1, first + 2]) / BALL_SPEED


def contact_time(result: Result) -> float:
    """Time at which F^(2/3), the indentation, comes to zero: through its last three instants [s]."""
    depth = result.force[:, 0, 0] ** (2.0 / 3.0)
    (last,) = np.flatnonzero(depth > 0.0)[-1:]
    near = slice(last - 2, last + 1)
    since = (result.times[near] - result.times[last]) / BALL_TIME
    roots = np.roots(np.polyfit(since, depth[near], 2)).real
    return float(result.times[last] + BALL_TIME * roots[np.argmin(np.abs(roots))])
