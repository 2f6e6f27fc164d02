"""What the stored instants of a result are: events, all steps or some, and what is told at them."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from lcpflex.results.contact_windows import EVENTS, INSTANTS, STEPS

if TYPE_CHECKING:
    from lcpflex.results.result import Result

__all__ = [
    "AT_REST",
    "CONTINUED",
    "DENSE",
    "at_events",
    "each_step",
    "follows_modes",
    "impulse_noise",
    "located",
    "stored_as",
    "tells_of_steps",
]

NOISE = 0.1  # of the relative tolerance of an implicit integrator: smaller shares of an impulse are noise
CONTINUED = "the run began from the last state of a result"  # how a note of such runs begins
AT_REST = "equilibrium"  # Result.stepper of places of rest, see :mod:`lcpflex.statics.rests_as_result`
DENSE = "dense"  # Result.stored beside INSTANTS and STEPS: three instants of each step


def family(result: Result) -> str:
    """Name of the stepper, without its numbers."""
    return result.stepper.partition("(")[0]


def at_events(result: Result) -> bool:
    """Whether the instants before and after each event of rigid contacts are stored."""
    return family(result) == "EventDriven"


def tells_of_steps(result: Result) -> bool:
    """Whether an instant tells of the step before it; else of itself."""
    return family(result) not in ("EventDriven", "Smooth", AT_REST)


def follows_modes(result: Result) -> bool:
    """Whether no mode swings with the steps: error control of an explicit method makes them short enough for all.

    Nothing swings at rest.
    """
    return family(result) in ("EventDriven", AT_REST) or "integrator=ExplicitRungeKutta(" in result.stepper


def stored_as(interval: float) -> str:
    """``Result.stored`` of a run that was asked for this interval [s]: 0: each step; negative: the path of each."""
    if interval > 0.0:
        return INSTANTS
    return DENSE if interval < 0.0 else STEPS


def each_step(result: Result) -> bool:
    """Whether the end of each step is stored."""
    return result.stored != INSTANTS or (not at_events(result) and len(result.times) == result.steps + 1)


def located(result: Result, contact: str) -> str:
    """Between what touches of a contact are located: EVENTS, STEPS or INSTANTS."""
    if at_events(result) and contact not in result.compliant:
        return EVENTS
    return STEPS if each_step(result) else INSTANTS


def impulse_noise(result: Result) -> float:
    """Share of the impulse of a contact that an interval without a touch may show: ``Stiff`` solves for it."""
    found = re.search(r"Stiff\(rtol=([0-9.e+-]+)", result.stepper)
    return NOISE * float(found.group(1)) if found else 0.0
