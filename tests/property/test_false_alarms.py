"""Ordinary runs of the gallery at their default steppers: none is called untrustworthy."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

import lcpflex as lf
from lcpflex import gallery
from lcpflex.results.doubts import doubts

Variation = tuple[str, Callable[..., Any], dict[str, float]]


def variations() -> list[Variation]:
    """A hundred: the case whose duration and stepper are taken, what builds the scene, and its numbers."""
    grids: list[tuple[str, Callable[..., Any], str, tuple[float, ...]]] = [
        ("pendulum", gallery.pendulum, "friction", (0.0, 0.1, 0.2, 0.5, 0.8)),
        ("pendulum", gallery.pendulum, "modes", (2, 4, 6, 12)),
        ("pendulum", gallery.pendulum, "restitution", (0.3, 0.6)),
        ("hemisphere", gallery.hemisphere_pendulum, "modes", (4, 6)),
        ("sliding_beam", gallery.sliding_beam, "friction", (0.0, 0.1, 0.5)),
        ("sliding_beam", gallery.sliding_beam, "damping", (0.0, 0.03)),
        ("incline", gallery.block_on_incline, "friction", (0.0, 0.1, 0.2, 0.3, 0.5, 0.57)),
        ("incline", gallery.block_on_incline, "speed", (0.5, 1.0, 3.0)),
        ("incline", gallery.block_on_incline, "degrees", (10.0, 20.0, 45.0)),
        ("incline_sticks", gallery.block_on_incline, "friction", (0.6, 0.8, 1.0)),
        ("stick_slip", gallery.stick_slip_block, "friction", (0.1, 0.2, 0.35)),
        ("stick_slip", gallery.stick_slip_block, "omega", (1.0, 4.0, 8.0)),
        ("spring_block", gallery.spring_block, "friction", (0.05, 0.2)),
        ("bouncing_ball", gallery.bouncing_ball, "restitution", (0.0, 0.2, 0.4, 0.6, 0.8, 0.9, 1.0)),
        ("bouncing_ball", gallery.bouncing_ball, "height", (0.1, 0.5, 2.0)),
        ("oblique_bounce", gallery.oblique_bounce, "friction", (0.0, 0.1, 0.5)),
        ("oblique_bounce", gallery.oblique_bounce, "restitution", (0.0, 0.3, 1.0)),
        ("three_balls", gallery.three_balls, "restitution", (0.0, 0.5, 0.8)),
        ("rocking_block", gallery.rocking_block, "tilt", (0.3, 0.7)),
        ("rocking_block", gallery.rocking_block, "height", (0.5, 0.8)),
        ("stack", gallery.stack, "boxes", (2, 4, 6, 8)),
        ("stack", gallery.stack, "friction", (0.1, 0.3, 0.8)),
        ("heavy_stack", gallery.stack, "top_mass", (10.0, 30.0, 1000.0)),
        ("elastic_bar", gallery.elastic_bar, "elements", (50, 100)),
        ("two_bars", gallery.two_bars, "elements", (50, 100)),
        ("two_bars", gallery.two_bars, "speed", (5.0, 20.0)),
        ("prestressed_bar", gallery.prestressed_bar, "elements", (50, 80)),
        ("woodpecker", gallery.woodpecker, "friction", (0.25, 0.3)),
        ("slider_crank", gallery.slider_crank, "restitution", (0.2, 0.4)),
        ("elastic_stop", gallery.elastic_stop, "speed", (0.5, 2.0)),
        ("hinged_beam", gallery.hinged_beam, "modes", (5, 10)),
    ]
    found = [(case, build, {name: value}) for case, build, name, values in grids for value in values]
    plain = ("pendulum", "smooth_pendulum", "incline", "incline_sticks", "stick_slip", "spring_block", "bouncing_ball",
             "oblique_bounce", "three_balls", "stack", "heavy_stack", "rocking_block", "sliding_beam", "woodpecker",
             "slider_crank", "elastic_bar", "two_bars", "elastic_stop")  # fmt: skip
    return [*found, *((name, gallery.scenes()[name].build, {}) for name in plain)]


ALL = variations()
QUICK = ("oblique_bounce", "three_balls")  # some tenths of a second each


def marked(variation: Variation) -> Any:
    case, build, numbers = variation
    marks = [] if case in QUICK else [pytest.mark.slow]
    values = " ".join(f"{name}={value:g}" for name, value in numbers.items())
    return pytest.param(case, build, numbers, marks=marks, id=f"{case} {values}".strip())


def test_there_are_a_hundred() -> None:
    assert len(ALL) >= 100


@pytest.mark.parametrize(("name", "build", "numbers"), [marked(variation) for variation in ALL])
def test_ordinary_runs_are_trusted(name: str, build: Callable[..., Any], numbers: dict[str, float]) -> None:
    case = gallery.scenes()[name]
    stepper = lf.MoreauJean(step=1e-5) if name == "pendulum" else case.stepper  # of its dozen, a coarser one will do
    result = lf.simulate(build(**numbers), case.duration, stepper, progress=False)
    assert not doubts(result), result.summary()
