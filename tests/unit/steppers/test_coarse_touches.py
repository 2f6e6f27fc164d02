"""Touches of force laws in steps of one length: too few steps are said, with the step that would do, which does."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest

import lcpflex as lf

TIME = 2e-3  # of a touch [s]


def dropped(in_space, scale=1.0, law=None):
    """A disc or ball of 1 kg on a linear spring whose touches take TIME; ``scale``: of lengths, as 1000 in mm."""
    law = law or lf.ContactLaw(lf.laws.PowerLaw((math.pi / TIME) ** 2, 1.0), lf.laws.KelvinVoigt(0.7, mass=1.0))
    if in_space:
        scene = lf.SpatialScene(gravity=(0, 0, -9.81 * scale))
        ball = scene.add(lf.Sphere(0.05 * scale, mass=1.0), position=(0, 0, 0.07 * scale))
        floor = scene.ground.plane((0, 0, 0), (0, 0, 1))
    else:
        scene = lf.Scene(gravity=(0, -9.81 * scale))
        ball = scene.add(lf.Disc(0.05 * scale, mass=1.0), position=(0, 0.07 * scale))
        floor = scene.ground.half_plane((0, 0), (0, 1))
    scene.contact(ball.surface(), floor, law=law, name="pad")
    return scene


def steppers(step):
    return {
        "Moreau-Jean": lf.MoreauJean(step=step),
        "theta = 1": lf.MoreauJean(step=step, theta=1.0),
        "Verlet": lf.Smooth(integrator=lf.Verlet(step)),
    }


def told(result):
    """Warnings of touches, and the longest steps that they name [s]."""
    texts = [text for text in result.warnings if "touches of contact" in text]
    return texts, [float(re.search(r"at most ([0-9.e+-]+) s", text)[1]) for text in texts]


def run(scene, stepper, duration=0.2):
    return lf.simulate(scene, duration, stepper, record=1e-3, progress=False)


@pytest.mark.parametrize("scale", [1.0, 1000.0])
@pytest.mark.parametrize("in_space", [False, True], ids=["plane", "space"])
@pytest.mark.parametrize("which", ["Moreau-Jean", "theta = 1", "Verlet"])
@pytest.mark.parametrize("steps", [6.3, 8.3, 12.7, 17.4])
def test_few_steps_of_a_touch_are_said_with_steps_that_do(steps, which, in_space, scale):
    step = TIME / steps
    result = run(dropped(in_space, scale), steppers(step)[which])
    texts, (enough,) = told(result)
    assert "'pad'" in texts[0]
    assert 0.2 * step < enough < step
    assert "Read its warnings" in str(result.verdict) or result.verdict.level == 0
    assert not told(run(dropped(in_space, scale), steppers(enough)[which]))[0]


@pytest.mark.parametrize("in_space", [False, True], ids=["plane", "space"])
def test_enough_steps_and_error_control_are_not_warned_of(in_space):
    for stepper in (
        *steppers(TIME / 24.0).values(), lf.EventDriven(), lf.Smooth(),
        lf.MoreauJean(step=1e-3, adaptive=lf.AdaptiveStep(rtol=1e-4)),
    ):  # fmt: skip
        assert not told(run(dropped(in_space), stepper))[0]


def test_touches_that_hardly_count_are_not_said():
    """One that grazes in few steps, before long ones; and a body that rests on its law in one touch without an end."""
    soft = lf.ContactLaw(lf.laws.PowerLaw(2e3, 1.0), lf.laws.KelvinVoigt(0.05, mass=1.0))
    result = run(dropped(False, law=soft), lf.MoreauJean(step=1e-3), 1.5)
    assert result.force[-1, 0, 0] == pytest.approx(9.81, rel=1e-2)
    assert not told(result)[0]


def test_a_few_steps_leave_nothing_of_a_law():
    result = run(dropped(False), lf.MoreauJean(step=TIME / 2.5))
    assert "NOT to be trusted" in result.summary()
    assert any("touches of contact 'pad'" in text for text in result.found_wrong)


@pytest.mark.parametrize("in_space", [False, True], ids=["plane", "space"])
@pytest.mark.parametrize("step", [1e-3, 1e-4, 1e-5, 3e-6])
def test_a_roller_pressed_from_zero_gap_is_right_or_not_to_be_trusted(step, in_space):
    """Its impact speed is the guard speed: the damping is far too stiff for such steps, and the force jumps about."""
    law = lf.ContactLaw(lf.laws.PowerLaw(1e8, 1.5), lf.laws.HysteresisDamping(0.7))
    if in_space:
        scene = lf.SpatialScene(gravity=(0, 0, 0))
        body, floor = (
            scene.add(lf.Sphere(0.05, mass=1.0), position=(0, 0, 0.05)),
            scene.ground.plane((0, 0, 0), (0, 0, 1)),
        )
        scene.load(lf.Force(body.at(0, 0, 0), (0, 0, -1000.0)))
    else:
        scene = lf.Scene(gravity=(0, 0))
        body, floor = scene.add(lf.Disc(0.05, mass=1.0), position=(0, 0.05)), scene.ground.half_plane((0, 0), (0, 1))
        scene.load(lf.Force(body.at(0, 0), (0, -1000.0)))
    scene.contact(body.surface(), floor, law=law, friction=0.3)
    result = lf.simulate(scene, 0.05, lf.MoreauJean(step=step), record=1e-4, progress=False)
    off = np.abs(result.force[len(result.force) // 5 :, 0, 0] - 1000.0).max()
    assert off > 300.0 or step == 1e-4  # there it is the start that is wrong
    assert result.verdict.word == "NOT to be trusted"


# ---- pins with small play


def pin(play, force, law, radius=0.01):
    scene = lf.Scene(gravity=(0, 0))
    body = scene.add(lf.RigidBody(1.0, 1e-3), name="pin")
    scene.revolute_with_clearance(scene.ground.at(0, 0), body.at(0, 0), radius - play, radius, law=law, name="play")
    scene.load(lf.Force(body.at(0, 0), (0.3 * force, -force)))
    return scene


@pytest.mark.parametrize("play", [1e-4, 1e-5])
@pytest.mark.parametrize("law", [None, "spring", "hysteresis"])
@pytest.mark.parametrize("part", [0.3, 1.0, 3.0, 8.0])
def test_advice_for_a_pin_with_play_is_a_shorter_step_and_one_that_holds_it(part, law, play):
    """Of the time sqrt(m c / F) in which the force takes the pin through its play c."""
    laws = {None: None, "spring": lf.ContactLaw(lf.laws.PowerLaw(1e9, 1.5))}
    laws["hysteresis"] = lf.ContactLaw(lf.laws.PowerLaw(1e9, 1.5), lf.laws.HysteresisDamping(0.5))
    force, duration = 1000.0, 60.0 * math.sqrt(play / 1000.0)
    step = part * math.sqrt(play / force)

    def named(result):
        texts = " ".join((*result.warnings, *result.found_wrong))
        return [float(number) for number in re.findall(r"at most ([0-9.e+-]+) s", texts)]

    result = lf.simulate(pin(play, force, laws[law]), duration, lf.MoreauJean(step=step), progress=False)
    lost = np.hypot(*result.q[:, :2].T).max() > 0.01
    if lost:
        assert named(result)
        assert result.verdict.word == "NOT to be trusted"
    for _ in range(4):
        advised = named(result)
        if not advised:
            break
        assert max(advised) < step
        step = min(advised)
        result = lf.simulate(pin(play, force, laws[law]), duration, lf.MoreauJean(step=step), progress=False)
    assert not named(result)
    if law:  # a rigid one goes a step too far, which is no matter of its law
        assert np.hypot(*result.q[:, :2].T).max() < play + 3e-4


def test_a_passage_within_a_step_names_no_longer_step():
    """The load of one step carries a body through a plate; where its first velocity led is no measure of that."""
    scene = lf.Scene(gravity=(0, 0))
    ball = scene.add(lf.Disc(0.01, mass=1.0), position=(0, 0.03))
    plate = scene.ground.chain([(-1.0, -0.005), (1.0, -0.005), (1.0, 0.005), (-1.0, 0.005)], closed=True)
    scene.contact(ball.surface(), plate, name="plate")
    scene.load(lf.Force(ball.at(0, 0), (0, -1000.0)))
    step = 2e-2
    result = lf.simulate(scene, 3 * step, lf.MoreauJean(step=step), progress=False)
    (clause,) = [text for text in result.found_wrong if "passed through" in text]
    assert float(re.search(r"at most ([0-9.e+-]+) s", clause)[1]) < 0.5 * step
