"""Which runs are compared: every scene of the gallery under every stepper, and for how long.

Schemes with fixed steps get the step of the case, or one of STEPS in the duration where that is longer: the whole
motion with all its touches is then in the run, for a bounded number of steps. Where a run costs much all the same,
``SHARES`` says how much of the duration is run, and nothing else does: no clock decides how far a run goes.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from tests.comparison.shares import SHARES, TOO_STIFF

__all__ = ["STEPPERS", "is_sensible", "share_of"]

STEPS = 1000  # of a scheme with fixed steps in the duration of a case, at most
FINER = 4.0  # steps of Verlet in one of those: it is explicit
STIFFNESS = 1e5  # of contacts of a scene that names no law [N/m]


def _step(case: Any) -> float:
    own = getattr(case.stepper, "step", None)
    return float(max(own or 0.0, case.duration / STEPS))


def _short(case: Any) -> float:
    own = getattr(case.stepper, "step", None)
    return float(min(own or case.duration, case.duration / (FINER * STEPS)))


def _law(lf: Any, case: Any) -> Any:
    """The law of the case's own stepper, or a spring."""
    return case.stepper.law if isinstance(case.stepper, lf.Smooth) else lf.Penalty(STIFFNESS)


def _laws(case: Any) -> Any:
    return getattr(case.stepper, "laws", {})


def _control(lf: Any, case: Any) -> Any:
    return lf.AdaptiveStep(rtol=1e-3, atol=1e-4, shortest=1e-5 * case.duration)


STEPPERS: dict[str, Callable[[Any, Any], Any]] = {
    "own": lambda lf, case: case.stepper,
    "moreau-jean": lambda lf, case: lf.MoreauJean(step=_step(case)),
    "moreau-jean-adaptive": lambda lf, case: lf.MoreauJean(step=_step(case), adaptive=_control(lf, case)),
    "generalized-alpha": lambda lf, case: lf.GeneralizedAlpha(step=_step(case)),
    "generalized-alpha-adaptive": lambda lf, case: lf.GeneralizedAlpha(step=_step(case), adaptive=_control(lf, case)),
    "event-driven": lambda lf, case: lf.EventDriven(rtol=1e-6),
    "event-driven-poisson": lambda lf, case: lf.EventDriven(rtol=1e-6, impact=lf.Poisson()),
    "event-driven-stronge": lambda lf, case: lf.EventDriven(rtol=1e-6, impact=lf.Stronge()),
    "event-driven-in-turn": lambda lf, case: lf.EventDriven(rtol=1e-6, impact=lf.Stronge(sequential=True)),
    "massless-boundary": lambda lf, case: lf.MasslessBoundary(),
    "smooth": lambda lf, case: lf.Smooth(_law(lf, case), _laws(case), integrator=lf.ExplicitRungeKutta(rtol=1e-6)),
    "smooth-stiff": lambda lf, case: lf.Smooth(_law(lf, case), _laws(case), integrator=lf.Stiff(rtol=1e-4)),
    "smooth-verlet": lambda lf, case: lf.Smooth(_law(lf, case), _laws(case), integrator=lf.Verlet(_short(case))),
}


def is_sensible(scene: str, stepper: str) -> bool:
    """Whether the run is made at all; whether the stepper takes the scene, it says itself."""
    return stepper != "smooth-stiff" or scene not in TOO_STIFF


def share_of(case: Any, stepper: str) -> float:
    """Part of the duration of the case that is run."""
    return SHARES.get(case.name, {}).get(stepper, SHARES.get(case.name, {}).get(_kind(stepper), 1.0))


def _kind(stepper: str) -> str:
    """The column of SHARES that a stepper is in."""
    if stepper.startswith("event-driven"):
        return "events"
    return "controlled" if stepper.endswith("-adaptive") else stepper
