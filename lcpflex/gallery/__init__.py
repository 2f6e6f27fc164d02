"""Reference scenes, each with what must come out where that is known exactly.

    from lcpflex import gallery, simulate

    case = gallery.scenes()["bouncing_ball"]
    result = simulate(case.build(), case.duration, case.stepper)

Tests, examples, charts and the command line take their scenes from here. The functions have parameters:
``gallery.elastic_bar(elements=100)``.
"""

from __future__ import annotations

from dataclasses import replace

from lcpflex.gallery import bars, flexible, rigid, user_systems
from lcpflex.gallery.bars import bar_with_foot, elastic_bar, prestressed_bar, two_bars
from lcpflex.gallery.case import Case
from lcpflex.gallery.flexible import hemisphere_pendulum, pendulum, sliding_beam
from lcpflex.gallery.rigid import (
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
from lcpflex.gallery.user_systems import impacting_bar, slider_crank, woodpecker

__all__ = [
    "Case",
    "bar_with_foot",
    "block_on_incline",
    "bouncing_ball",
    "double_pendulum",
    "elastic_bar",
    "hemisphere_pendulum",
    "impacting_bar",
    "oblique_bounce",
    "painleve_friction",
    "painleve_rod",
    "pendulum",
    "prestressed_bar",
    "rocking_block",
    "scenes",
    "slider_crank",
    "sliding_beam",
    "spring_block",
    "stack",
    "stick_slip_block",
    "three_balls",
    "two_bars",
    "warmup_cases",
    "woodpecker",
]


def scenes() -> dict[str, Case]:
    """All cases by name."""
    return {case.name: case for module in (flexible, rigid, bars, user_systems) for case in module.cases()}


def warmup_cases() -> tuple[Case, ...]:
    """A few short runs that between them use every kernel, with both steppers."""
    from lcpflex.steppers.event_driven import EventDriven

    known = scenes()
    stepping = ("sliding_beam", "double_pendulum", "impacting_bar")
    locating = ("stick_slip", "oblique_bounce")
    return (
        *(replace(known[name], duration=1e-3) for name in stepping),
        *(replace(known[name], duration=1e-2, stepper=EventDriven()) for name in locating),
    )
