"""What a step leaves in a contact is no large penetration; what is large is named, with when and how much."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.results.doubts import doubts

HEIGHTS = (0.0101, 0.1003, 0.3004, 1.0, 3.0)
AHEAD = ((0.0, 1.0), (0.2, 0.0))  # places and speeds along x of two balls that touch


def dropped(height: float, space: bool, scale: float = 1.0, bounce: float = 0.0) -> Any:
    """A ball of 100 mm that falls through ``height`` [m], all lengths times ``scale``."""
    radius, place = 0.05 * scale, (0.05 + height) * scale
    if space:
        scene: Any = lf.SpatialScene(gravity=(0.0, 0.0, -9.81 * scale))
        ball = scene.add(lf.Sphere(radius, mass=1.0), name="ball", position=(0.0, 0.0, place))
        floor = scene.ground.plane((0, 0, 0), (0, 0, 1))
    else:
        scene = lf.Scene(gravity=(0.0, -9.81 * scale))
        ball = scene.add(lf.Disc(radius, mass=1.0), name="ball", position=(0.0, place))
        floor = scene.ground.half_plane((0, 0), (0, 1))
    scene.contact(ball.surface(), floor, friction=0.3, restitution=bounce, name="floor")
    return scene


@pytest.mark.parametrize("space", [False, True], ids=["plane", "space"])
@pytest.mark.parametrize("height", HEIGHTS)
@pytest.mark.parametrize("bounce", [0.0, 0.5])
def test_the_approach_of_a_step_is_no_large_penetration(height: float, space: bool, bounce: float) -> None:
    whole = lf.simulate(dropped(height, space, bounce=bounce), 0.9, lf.MoreauJean(step=1e-3), progress=False)
    assert not doubts(whole)


@pytest.mark.parametrize("space", [False, True], ids=["plane", "space"])
@pytest.mark.parametrize("scale", [1.0, 1e3, 1e-3])
def test_a_run_and_its_parts_have_one_verdict(space: bool, scale: float) -> None:
    """Wherever it is broken off: before the impact, within it, or at rest, millimetres in the floor."""
    scene = dropped(0.5006, space, scale)
    stepper = lf.MoreauJean(step=1e-3)
    whole = lf.simulate(scene, 0.6, stepper, progress=False)
    assert whole.penetration.max() > 1e-3 * 0.1 * scale
    assert not doubts(whole)
    for until in (0.31, 0.32, 0.4):
        first = lf.simulate(scene, until, stepper, progress=False)
        second = lf.simulate(scene, 0.6 - until, stepper, initial=first, progress=False)
        assert not doubts(first)
        assert not doubts(second)
        assert np.abs(second.q[-1] - whole.q[-1]).max() < 1e-2 * 0.1 * scale


def test_a_run_goes_on_with_the_doubts_of_what_it_began_from() -> None:
    scene = dropped(1.0, False)
    stepper = lf.MoreauJean(step=2e-2)
    first = lf.simulate(scene, 0.6, stepper, progress=False)
    assert doubts(first)
    second = lf.simulate(scene, 0.3, stepper, initial=first, progress=False)
    assert doubts(second)[0].startswith(
        "the result that it began from is not to be trusted (contact 'floor' penetrates by"
    )
    assert "it stopped early" not in doubts(second)[0]


@pytest.mark.parametrize("space", [False, True], ids=["plane", "space"])
@pytest.mark.parametrize("record", [0, 1e-2, 0.1])
def test_a_large_penetration_names_contact_time_and_step(space: bool, record: float) -> None:
    """Two balls, one of which is too fast for its step."""
    scene = dropped(0.02, space)
    radius, place = 0.05, 0.5
    if space:
        fast = scene.add(lf.Sphere(radius, mass=1.0), "fast", position=(0.5, 0.0, place), velocity=(0.0, 0.0, -9.0))
        floor = scene.ground.plane((0, 0, 0), (0, 0, 1))
    else:
        fast = scene.add(lf.Disc(radius, mass=1.0), "fast", position=(0.5, place), velocity=(0.0, -9.0))
        floor = scene.ground.half_plane((0, 0), (0, 1))
    scene.contact(fast.surface(), floor, name="hard")
    result = lf.simulate(scene, 0.3, lf.MoreauJean(step=5e-3), record=record, progress=False)
    (said,) = doubts(result)
    assert said.startswith("contact 'hard' penetrates by ")
    assert "at t = 0.0" in said or (record == 0.1 and "at t = 0.1" in said)
    assert "take steps of 1" in said or "take steps of 2" in said
    assert (said.what, said.where) == ("penetration", "contact 'hard'")
    assert said.amount == result.penetration.max()
    assert result.times[1] <= said.when <= 0.1


@pytest.mark.parametrize("space", [False, True], ids=["plane", "space"])
def test_under_error_control_the_shortest_step_takes_impacts(space: bool) -> None:
    """It goes into a contact as a step of that length does: by h |v|; what is deeper than that is told."""
    control = lf.AdaptiveStep(rtol=1e-5, shortest=5e-4)
    result = lf.simulate(dropped(0.2003, space), 0.3, lf.MoreauJean(step=1e-3, adaptive=control), progress=False)
    assert result.penetration.max() > 1e-3 * 0.1
    assert not doubts(result)
    deeper = result.penetration * (5e-4 * 2.0 * np.sqrt(2.0 * 9.81 * 0.2) / result.penetration.max() + 1.0)
    (said,) = doubts(replace(result, penetration=deeper))
    assert said.advice == "take tighter tolerances"


def in_bowl() -> lf.Scene:
    """A disc that slides to and fro in a bowl."""
    scene = lf.Scene()
    disc = scene.add(lf.Disc(0.1, mass=1.0), position=(-0.9 * np.sin(0.7), 1.0 - 0.9 * np.cos(0.7)))
    bowl = scene.ground.arc((0.0, 1.0), 1.0, 1.01 * np.pi, 0.98 * np.pi, hole=True)
    scene.contact(disc.surface(), bowl, name="bowl")
    return scene


def test_a_contact_drifts_as_far_as_error_control_lets_it() -> None:
    """By the tolerance of both bodies a step; the same depth of a run that accepts less is large."""
    loose = lf.simulate(in_bowl(), 3.0, lf.MoreauJean(step=1e-3, adaptive=lf.AdaptiveStep(rtol=1e-3)), progress=False)
    assert 1e-3 * 0.2 < loose.penetration.max() < 2.0 * loose.steps * loose.step_tolerance
    assert not doubts(loose)
    event = lf.simulate(in_bowl(), 0.5, lf.EventDriven(), progress=False)
    tight = lf.simulate(in_bowl(), 0.5, lf.GeneralizedAlpha(1e-3, adaptive=lf.AdaptiveStep(rtol=1e-9)), progress=False)
    for result in (event, tight):
        assert not doubts(result)
        (said,) = doubts(replace(result, penetration=np.full(len(result.times), loose.penetration.max())))
        assert said.startswith("a contact penetrates by ")


@pytest.mark.parametrize("space", [False, True], ids=["plane", "space"])
def test_a_joint_that_has_drifted_is_named(space: bool) -> None:
    if space:
        scene: Any = lf.SpatialScene(gravity=(0.0, 0.0, -9.81))
        for k in range(2):
            box = scene.add(lf.Cuboid(0.2, 0.1, 0.1, mass=1.0), position=(0.1, k, 0.0))
            scene.join(lf.Ball(box.at(-0.1, 0.0, 0.0), scene.ground.at(0.0, k, 0.0), name=f"pin{k}"))
    else:
        scene = lf.Scene()
        for k in range(2):
            bar = scene.add(lf.Box(0.2, 0.1, mass=1.0), position=(0.1, k))
            scene.join(lf.Revolute(bar.at(-0.1, 0.0), scene.ground.at(0.0, k), name=f"pin{k}"))
    result = lf.simulate(scene, 0.1, lf.MoreauJean(step=1e-3), progress=False)
    assert not doubts(result)
    off = result.q.copy()
    off[50:, 7 if space else 3] += 0.01
    drift = np.where(np.arange(len(off)) >= 50, 0.01, 0.0)
    (said,) = doubts(replace(result, q=off, joint_drift=drift))
    assert said.startswith(
        "joint 'pin1' has drifted by 10 mm at t = 0.05 s, which is large for a scene of 200 mm: take a shorter"
    )


@pytest.mark.parametrize("space", [False, True], ids=["plane", "space"])
def test_what_is_carried_on_at_its_depth_is_as_deep_as_when_it_closed(space: bool) -> None:
    """Two balls that stick together fly on: no impulse holds them any more, and rounding is no further penetration."""
    if space:
        scene: Any = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
        balls = [scene.add(lf.Sphere(0.1, mass=1.0), position=(x, 0.0, 0.0), velocity=(v, 0.0, 0.0)) for x, v in AHEAD]
    else:
        scene = lf.Scene(gravity=(0.0, 0.0))
        balls = [scene.add(lf.Disc(0.1, mass=1.0), position=(x, 0.0), velocity=(v, 0.0)) for x, v in AHEAD]
    scene.contact(balls[0].surface(), balls[1].surface(), restitution=0.0)
    result = lf.simulate(scene, 0.5, lf.MoreauJean(step=1e-3), progress=False)
    assert result.penetration.max() > 2e-4
    assert not doubts(result)
