"""The few scenes of the gallery that between them use every kernel."""

from __future__ import annotations

from dataclasses import replace

from lcpflex.dynamics.impact_laws import Poisson, Stronge
from lcpflex.force_laws.penalty import Penalty
from lcpflex.gallery.collection import scenes
from lcpflex.runs.case import Case
from lcpflex.steppers.adaptive import AdaptiveStep
from lcpflex.steppers.event_driven.stepper import EventDriven
from lcpflex.steppers.generalized_alpha.stepper import GeneralizedAlpha
from lcpflex.steppers.massless_boundary.stepper import MasslessBoundary
from lcpflex.steppers.moreau_jean.stepper import MoreauJean
from lcpflex.steppers.smooth.stepper import Smooth, Stiff, Verlet

__all__ = ["warmup_cases"]


def warmup_cases() -> tuple[Case, ...]:
    """A few short runs that between them use every kernel, with every stepper."""
    known = scenes()
    control, spring = AdaptiveStep(), Penalty(1e5)
    own = ("sliding_beam", "double_pendulum", "impacting_bar")
    others = (
        ("stick_slip", 1e-2, EventDriven()),
        ("oblique_bounce", 1e-2, EventDriven()),
        ("oblique_bounce", 1e-2, EventDriven(impact=Poisson())),
        ("oblique_bounce", 1e-2, EventDriven(impact=Stronge())),
        ("double_pendulum", 1e-3, MoreauJean(step=1e-4, adaptive=control)),
        ("double_pendulum", 1e-3, GeneralizedAlpha(step=1e-4)),
        ("double_pendulum", 1e-3, GeneralizedAlpha(step=1e-4, adaptive=control)),
        ("pendulum", 1e-3, MasslessBoundary(step=1e-4)),
        ("stick_slip", 1e-3, Smooth(spring)),
        ("stick_slip", 1e-3, Smooth(spring, integrator=Stiff())),
        ("stick_slip", 1e-3, Smooth(spring, integrator=Verlet(1e-4))),
        ("driven_slider_crank", 1e-3, MoreauJean(step=1e-4)),
        ("driven_slider_crank", 1e-2, EventDriven()),
        ("driven_slider_crank", 1e-3, GeneralizedAlpha(step=1e-4)),
    )
    return (
        *(replace(known[name], duration=1e-3) for name in own),
        *(replace(known[name], duration=duration, stepper=stepper) for name, duration, stepper in others),
    )
