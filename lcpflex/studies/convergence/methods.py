"""The methods that a work-precision study tries where none are given."""

from __future__ import annotations

from typing import Any

from lcpflex.basics.arguments import positive
from lcpflex.steppers.adaptive import AdaptiveStep
from lcpflex.steppers.event_driven.stepper import EventDriven
from lcpflex.steppers.generalized_alpha.stepper import GeneralizedAlpha
from lcpflex.steppers.massless_boundary.stepper import MasslessBoundary
from lcpflex.steppers.moreau_jean.stepper import MoreauJean

__all__ = ["standard_methods"]

COARSEST = 1.0 / 50.0  # step, as a share of the duration
FACTOR = 3.0
LEVELS = 10


def standard_methods(duration: float) -> dict[str, tuple[Any, ...]]:
    """By label the series of every scheme, from coarse to fine, for a scene of ``duration`` [s].

    Steps from a fiftieth of the duration downwards by factors of three, tolerances from 1e-2 downwards by factors of
    ten. What takes too long is left out by the limit of the study, what does not apply by the scene. Smooth contact
    laws are not among them: their stiffness is part of the model, and only the user knows it.
    """
    duration = positive("duration", duration)
    steps = [COARSEST * duration / FACTOR**k for k in range(LEVELS)]
    tolerances = [10.0**-k for k in range(2, 11)]
    return {
        "Moreau-Jean": tuple(MoreauJean(step=h) for h in steps),
        "Moreau-Jean, adaptive": tuple(
            MoreauJean(step=1e-3 * duration, adaptive=AdaptiveStep(rtol=r, atol=0.1 * r, shortest=1e-2 * r * duration))
            for r in tolerances
        ),
        "generalised-alpha": tuple(GeneralizedAlpha(step=h) for h in steps),
        "massless boundary": tuple(MasslessBoundary(step=h) for h in steps),
        "event-driven": tuple(EventDriven(rtol=r, atol=0.1 * r) for r in tolerances),
    }
