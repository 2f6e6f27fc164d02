"""Reference scenes, each with what must come out where that is known exactly.

    from lcpflex import gallery, simulate

    case = gallery.scenes()["bouncing_ball"]
    result = simulate(case.build(), case.duration, case.stepper)

Tests, examples, charts and the command line take their scenes from here. The functions have parameters:
``gallery.elastic_bar(elements=100)``.
"""

from __future__ import annotations

from dataclasses import replace

from lcpflex.dynamics.impact_laws import Poisson, Stronge
from lcpflex.force_laws.penalty import Penalty
from lcpflex.gallery.mechanisms import bars, coaxial, flexible, rigid, stops, user_systems
from lcpflex.gallery.mechanisms.bars import bar_with_foot, elastic_bar, prestressed_bar, two_bars
from lcpflex.gallery.mechanisms.claws import claw
from lcpflex.gallery.mechanisms.coaxial import meshed_ball, meshed_rod, meshed_sphere_on_rod
from lcpflex.gallery.mechanisms.flexible import hemisphere_pendulum, pendulum, sliding_beam
from lcpflex.gallery.mechanisms.rigid import (
    block_on_incline,
    bouncing_ball,
    double_pendulum,
    oblique_bounce,
    painleve_friction,
    painleve_rod,
    rocking_block,
    spring_block,
    stack,
    stick_slip_block,
    three_balls,
)
from lcpflex.gallery.mechanisms.stops import elastic_stop, hinged_beam, sphere_on_beam, sphere_on_rod
from lcpflex.gallery.mechanisms.user_systems import impacting_bar, slider_crank, woodpecker
from lcpflex.runs.case import Case
from lcpflex.steppers.adaptive import AdaptiveStep
from lcpflex.steppers.event_driven.stepper import EventDriven
from lcpflex.steppers.generalized_alpha.stepper import GeneralizedAlpha
from lcpflex.steppers.massless_boundary.stepper import MasslessBoundary
from lcpflex.steppers.moreau_jean.stepper import MoreauJean
from lcpflex.steppers.smooth.stepper import Smooth, Stiff, Verlet

__all__ = [
    "Case",
    "bar_with_foot",
    "block_on_incline",
    "bouncing_ball",
    "claw",
    "double_pendulum",
    "elastic_bar",
    "elastic_stop",
    "hemisphere_pendulum",
    "hinged_beam",
    "impacting_bar",
    "meshed_ball",
    "meshed_rod",
    "meshed_sphere_on_rod",
    "oblique_bounce",
    "painleve_friction",
    "painleve_rod",
    "pendulum",
    "prestressed_bar",
    "rocking_block",
    "scenes",
    "slider_crank",
    "sliding_beam",
    "sphere_on_beam",
    "sphere_on_rod",
    "spring_block",
    "stack",
    "stick_slip_block",
    "three_balls",
    "two_bars",
    "warmup_cases",
    "woodpecker",
]


def __dir__() -> list[str]:
    return sorted(__all__)


def scenes() -> dict[str, Case]:
    """All cases by name."""
    return {
        case.name: case for module in (flexible, rigid, bars, user_systems, stops, coaxial) for case in module.cases()
    }


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
    )
    return (
        *(replace(known[name], duration=1e-3) for name in own),
        *(replace(known[name], duration=duration, stepper=stepper) for name, duration, stepper in others),
    )
