"""Energy that nobody explains: within touches of few steps it is the error of these, and is told as that."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.results.doubts import doubts
from lcpflex.results.unexplained import unexplained_energy

TIME = 2e-3  # of a touch [s]


def bounced(in_space, stepper, record=None, scale=1.0):
    """A ball of 1 kg falls on a spring and is in the air in the end; ``scale``: of lengths, as 1000 in mm."""
    law = lf.Penalty((math.pi / TIME) ** 2)
    up = (0.0, 0.0, 1.0) if in_space else (0.0, 1.0)
    scene = (lf.SpatialScene if in_space else lf.Scene)(gravity=tuple(-9.81 * scale * x for x in up))
    shape = (lf.Sphere if in_space else lf.Disc)(0.05 * scale, mass=1.0)
    ball = scene.add(shape, position=tuple(0.1 * scale * x for x in up))
    ground = scene.ground
    floor = ground.plane((0, 0, 0), up) if in_space else ground.half_plane((0, 0), up)
    scene.contact(ball.surface(), floor, law=law, name="pad")
    return lf.simulate(scene, 0.15, stepper, record=record, progress=False)


def unexplained(result):
    return [text for text in doubts(result) if "without explanation" in text]


STEPPERS = {
    "Moreau-Jean": lambda step: lf.MoreauJean(step=step),
    "Verlet": lambda step: lf.Smooth(integrator=lf.Verlet(step)),
}


@pytest.mark.parametrize("which", STEPPERS)
@pytest.mark.parametrize("in_space", [False, True], ids=["plane", "space"])
@pytest.mark.parametrize("steps", [6.1, 8.1])
def test_a_touch_of_few_steps_is_told_as_such_and_not_as_lost_energy(steps, in_space, which):
    """Where steps fall such that the ball leaves nearly as fast as it came."""
    for record, scale in ((0, 1.0), (2e-3, 1.0), (0, 1000.0)):
        result = bounced(in_space, STEPPERS[which](TIME / steps), record, scale)
        assert result.energies.relative_remainder > 0.02 or record
        assert result.coarse == ("pad",)
        assert unexplained_energy(result)[1] < 0.01
        assert not unexplained(result)
        assert any("touches of contact 'pad'" in text for text in result.warnings)
        assert unexplained(replace(result, coarse=())) or record


def test_energy_that_grows_and_goes_within_a_touch_is_no_doubt():
    """More than 2 % of it; what such a touch leaves behind is one."""
    result = bounced(False, lf.MoreauJean(step=TIME / 7.0), 0)
    assert result.energies.growth > 0.02 * result.energies.scale
    assert any("energy grew" in text for text in result.warnings)
    assert not doubts(result)
    left = bounced(False, lf.MoreauJean(step=TIME / 7.4), 0)
    assert any("energy grew" in text for text in left.found_wrong)


def test_what_a_touch_leaves_behind_is_in_doubt(tmp_path):
    result = bounced(False, lf.MoreauJean(step=TIME / 8.1), 0)
    behind = result.times > result.times[np.flatnonzero(result.force[:, 0, 0])[-1]]
    assert behind.any()
    for sign, word in ((1.0, "gained"), (-1.0, "lost")):
        wrong = np.where(behind, sign * 0.03 * result.energies.scale, result.energies.remainder)
        told = unexplained(replace(result, energies=replace(result.energies, remainder=wrong)))
        assert word in told[0]
    lost = np.where(behind, np.nan, result.energies.remainder)
    assert unexplained(replace(result, energies=replace(result.energies, remainder=lost)))
    assert lf.Result.load(result.save(tmp_path / "bounced.npz")).coarse == result.coarse


def test_a_long_touch_is_no_excuse():
    """The same contact, which presses for more steps than it needs."""
    result = bounced(False, lf.MoreauJean(step=TIME / 8.1), 0)
    force = np.array(result.force)
    force[:, 0, 0] = 1.0
    assert unexplained(replace(result, force=force))


def test_touches_without_a_break_are_no_excuse():
    """Between two springs that a disc just fits between one presses always: its whole motion would be excused."""
    scene = lf.Scene(gravity=(0.0, 0.0))
    disc = scene.add(lf.Disc(0.05, mass=1.0), velocity=(1.0, 0.0))
    for side in (-1.0, 1.0):
        wall = scene.ground.half_plane((0.05 * side, 0.0), (-side, 0.0))
        scene.contact(disc.surface(), wall, law=lf.Penalty((math.pi / TIME) ** 2), name=f"spring{side}")
    for step, off in ((TIME / 8.1, True), (TIME / 25.0, False)):
        result = lf.simulate(scene, 0.05, lf.MoreauJean(step=step), record=0, progress=False)
        assert (result.energies.relative_remainder > 0.02) == off
        assert unexplained_energy(result)[1] == result.energies.relative_remainder
        assert bool(unexplained(result)) == off


def test_touches_of_enough_steps_are_no_excuse_and_need_none():
    result = bounced(False, lf.MoreauJean(step=TIME / 25.0), 0)
    assert result.coarse == ()
    assert result.energies.relative_remainder < 0.01
    assert unexplained_energy(result)[1] == result.energies.relative_remainder
