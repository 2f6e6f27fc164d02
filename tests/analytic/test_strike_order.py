"""Contacts that close one after another within a step are struck in that order: balls on a line, known exactly."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pytest

import lcpflex as lf

ALPHA: dict[str, Callable[[float], Any]] = {
    "GeneralizedAlpha": lambda step: lf.GeneralizedAlpha(step=step),
    "rho 1/2": lambda step: lf.GeneralizedAlpha(step=step, rho_inf=0.5),
}
STEPPERS: dict[str, Callable[[float], Any]] = {**ALPHA, "MoreauJean": lambda step: lf.MoreauJean(step=step)}


def after_all(masses: Sequence[float], gaps: Sequence[float], speeds: Sequence[float], e: float) -> list[float]:
    """Velocities of points on a line once none approaches another: one impact after the other, each at its time."""
    u, g = list(speeds), list(gaps)
    while True:
        closing = [(max(g[k], 0.0) / (u[k] - u[k + 1]), k) for k in range(len(g)) if u[k] > u[k + 1] + 1e-9]
        if not closing:
            return u
        time, k = min(closing)
        for i in range(len(g)):
            g[i] += time * (u[i + 1] - u[i])
        g[k] = 0.0
        p = (1.0 + e) * (u[k] - u[k + 1]) * masses[k] * masses[k + 1] / (masses[k] + masses[k + 1])
        u[k] -= p / masses[k]
        u[k + 1] += p / masses[k + 1]


def centre_velocity(result: lf.Result, body: str, space: bool = False) -> Any:
    """(instants, components) of the centre of a body [m/s]."""
    return result.velocity(body, (0.0, 0.0, 0.0) if space else (0.0, 0.0))


def row(
    masses: Sequence[float], gaps: Sequence[float], speed: float, e: float, length: float, space: bool, turned: bool
) -> Any:
    """Balls with centres on the x axis, the first of which comes; ``turned``: declared and added from the other end."""
    scene: Any = lf.SpatialScene(gravity=(0.0, 0.0, 0.0)) if space else lf.Scene(gravity=(0.0, 0.0))
    radius = 0.05 * length
    places = np.concatenate([[0.0], np.cumsum(2.0 * radius + np.asarray(gaps))])
    zeros = (0.0,) * (2 if space else 1)
    order = range(len(masses))[:: -1 if turned else 1]
    balls = {}
    for k in order:
        body = lf.Sphere(radius, mass=masses[k]) if space else lf.Disc(radius, mass=masses[k])
        velocity = (speed if k == 0 else 0.0, *zeros)
        balls[k] = scene.add(body, name=f"ball{k}", position=(float(places[k]), *zeros), velocity=velocity)
    for k in order[:-1] if not turned else order[1:]:
        scene.contact(balls[k].surface(), balls[k + 1].surface(), restitution=e)
    return scene


@pytest.mark.parametrize("stepper", ALPHA)
@pytest.mark.parametrize(
    ("masses", "e", "units", "space", "turned"),
    [
        ((1.0,) * 5, 1.0, (1.0, 1.0), False, False),
        ((1.0,) * 5, 0.8, (1.0, 1.0), False, True),
        ((1.0, 0.3, 2.0, 0.5, 1.0), 1.0, (1.0, 1.0), False, False),
        ((1.0, 0.3, 2.0, 0.5, 1.0), 0.7, (1e3, 1e-3), False, True),  # millimetres and tonnes
        ((1.0, 0.3, 2.0, 0.5, 1.0), 0.9, (1.0, 1.0), True, False),
        ((0.1, 4.0, 0.2), 1.0, (1.0, 1.0), True, True),
    ],
)
def test_a_row_of_balls_a_tenth_of_a_step_apart(
    stepper: str, masses: tuple[float, ...], e: float, units: tuple[float, float], space: bool, turned: bool
) -> None:
    """Newton's cradle with gaps of 1e-4 m at 1 m/s and steps of 1 ms: all of it happens in a step or two."""
    m, kg = units
    weights, gaps = [kg * mass for mass in masses], [1e-4 * m] * (len(masses) - 1)
    scene = row(weights, gaps, m, e, m, space, turned)
    result = lf.simulate(scene, 0.02, ALPHA[stepper](1e-3))
    last = [centre_velocity(result, f"ball{k}", space)[-1, 0] for k in range(len(masses))]
    expected = after_all(weights, gaps, [m] + [0.0] * (len(masses) - 1), e)
    assert np.asarray(last) == pytest.approx(expected, abs=2e-3 * m)
    assert "NOT" not in result.summary()
    assert not result.warnings


def test_strikes_in_turn_under_moreau_jean() -> None:
    """A step of it strikes no contact that its strikes make to close: of unequal balls it says which step would do."""
    masses, gaps = (1.0, 0.3, 2.0, 0.5, 1.0), [1e-4] * 4
    expected = after_all(masses, gaps, [1.0] + [0.0] * 4, 1.0)
    results = [
        lf.simulate(row(masses, gaps, 1.0, 1.0, 1.0, False, False), 0.02, lf.MoreauJean(step=h)) for h in (1e-3, 1e-5)
    ]
    off = [np.abs(result.u[-1, 0::3] - expected).max() for result in results]
    assert off[0] > 0.1
    (said,) = results[0].warnings
    assert "struck within 2 steps" in said
    assert 5e-6 < float(said.split("at most ")[1].split(" s ")[0]) < 3e-5
    assert off[1] < 1e-3
    assert not results[1].warnings


def dropped(gap: float, e: float, space: bool = False, follow: float = 0.0) -> Any:
    """A small ball above a large one, both falling onto a floor from a height of half a metre."""
    scene: Any = lf.SpatialScene() if space else lf.Scene()
    up = (0.0,) * (2 if space else 1)
    floor = scene.ground.plane((0, 0, 0), (0, 0, 1)) if space else scene.ground.half_plane((0, 0), (0, 1))
    ball: Any = lf.Sphere if space else lf.Disc
    low = scene.add(ball(0.12, mass=0.6), name="low", position=(*up, 0.62))
    top = scene.add(ball(0.03, mass=0.06), name="top", position=(*up, 0.77 + gap), velocity=(*up, -follow))
    scene.contact(low.surface(), floor, restitution=e)
    scene.contact(low.surface(), top.surface(), restitution=e)
    return scene


@pytest.mark.parametrize("stepper", STEPPERS)
@pytest.mark.parametrize(
    ("gap", "e", "space", "follow"),
    [
        (1e-3, 1.0, False, 0.0),
        (1e-5, 1.0, False, 0.0),
        (1e-3, 0.7, False, 0.0),
        (3e-4, 1.0, True, 0.0),
        (1e-3, 0.9, False, 5e-3),
    ],
)
def test_a_ball_on_a_ball_that_lands(stepper: str, gap: float, e: float, space: bool, follow: float) -> None:
    """Floor first, then the pair, for any gap: what the small ball leaves with, to what gravity does in two steps."""
    step = 1e-3
    fall = math.sqrt(2.0 * 9.81 * 0.5)
    low, top = after_all([1e30, 0.6, 0.06], [0.0, gap], [0.0, -fall, -fall - follow], e)[1:]
    result = lf.simulate(dropped(gap, e, space, follow), 0.4, STEPPERS[stepper](step))
    assert centre_velocity(result, "top", space)[:, -1].max() == pytest.approx(top, abs=3.0 * 9.81 * step)
    assert low < top
    if stepper in ALPHA:  # Moreau-Jean tells how far its steps go into the floor
        assert "NOT" not in result.summary()


def landing(tilt: float, e: float, friction: float, width: float) -> lf.Scene:
    """A flat box, its ends nearly level, falls onto a floor from 0.25 m."""
    scene = lf.Scene()
    floor = scene.ground.half_plane((0.0, 0.0), (0.0, 1.0))
    box = scene.add(lf.Box(width, 0.1, mass=1.0), name="box", position=(0.0, 0.3 + 0.5 * width * tilt), angle=tilt)
    scene.contact(box.surface(), floor, restitution=e, friction=friction)
    return scene


@pytest.mark.parametrize("stepper", STEPPERS)
@pytest.mark.parametrize(
    ("tilt", "e", "friction", "width"), [(1e-3, 0.5, 0.3, 0.4), (3e-3, 1.0, 0.0, 0.4), (-5e-4, 0.8, 0.1, 0.6)]
)
def test_one_end_of_a_box_lands_just_before_the_other(
    stepper: str, tilt: float, e: float, friction: float, width: float
) -> None:
    """Within a step: struck at once it would not turn; it leaves with the spin of an event-driven run."""
    scenes = [landing(tilt, e, friction, width) for _ in range(2)]
    exact = lf.simulate(scenes[0], 0.26, lf.EventDriven())
    result = lf.simulate(scenes[1], 0.26, STEPPERS[stepper](1e-3))
    spin = float(exact.u[-1, 2])
    assert abs(spin) > 0.3
    assert result.u[-1, 2] == pytest.approx(spin, rel=0.1)
    assert centre_velocity(result, "box")[-1] == pytest.approx(centre_velocity(exact, "box")[-1], abs=0.04)


def test_ends_that_land_at_once_are_struck_at_once() -> None:
    """A level box keeps its angle, and no order is made up from rounding."""
    for make in STEPPERS.values():
        for tilt in (0.0, 1e-13):
            result = lf.simulate(landing(tilt, 0.5, 0.3, 0.4), 0.3, make(1e-3))
            assert np.abs(result.angle("box")).max() < 1e-9


def test_what_is_struck_in_turn_loses_what_each_strike_takes() -> None:
    """The energy balance holds over steps of several strikes, friction included."""
    for make, (first, second) in itertools.product(STEPPERS.values(), ((0.9, 0.3), (0.4, 0.0))):
        result = lf.simulate(landing(1e-3, first, second, 0.4), 0.3, make(5e-4))
        assert result.energies.relative_remainder < 2e-3
        total = result.energies.kinetic + result.energies.potential
        assert total.max() < total[0] * (1.0 + 1e-3)
