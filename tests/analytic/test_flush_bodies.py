"""Bodies that lie on each other flush, equal and aligned, or next to it: they rest, and move as the aligned ones do."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
import pytest

import lcpflex as lf
from tests.flush.judging import Bound, broken, moves_as_it_must, rests
from tests.flush.places import Place, few, single
from tests.flush.scenes import MOTIONS, RESTS, STEPPERS, rolling

SIZE = 0.2  # [m] about, of all that rest
UPRIGHT = 0.3  # over the width: what is farther aside may tip

over_scenes = pytest.mark.parametrize("name", RESTS)
over_motions = pytest.mark.parametrize("name", MOTIONS)
over_steppers = pytest.mark.parametrize("stepper", STEPPERS)


def resting(name: str, stepper: str, places: Iterable[Place]) -> list[str]:
    """Where one of the scenes that must rest does not."""

    def judge(place: Place) -> Bound:
        return rests(lf.simulate(RESTS[name](place), 0.05, STEPPERS[stepper], progress=False), SIZE)

    return broken((place for place in places if place.aside <= UPRIGHT), judge)


def moving(name: str, stepper: str, places: Iterable[Place]) -> list[str]:
    """Where one of the scenes that move does not do so as it must."""
    motion = MOTIONS[name]
    aligned = lf.simulate(motion.build(Place()), motion.duration, STEPPERS[stepper], progress=False)
    return broken(places, lambda place: moves_as_it_must(motion, place, STEPPERS[stepper], aligned))


# event-driven solves a rest a few times in all, and takes a tenth of a second for it: of two kinds here
@pytest.mark.parametrize(
    ("name", "stepper"),
    [(n, s) for n in RESTS for s in STEPPERS if s != "EventDriven" or n in ("box on box", "drum on box")],
)
def test_flush_bodies_rest(name: str, stepper: str) -> None:
    assert not resting(name, stepper, few(tilts=False))


@over_motions
@over_steppers
def test_flush_bodies_move_as_aligned_ones(name: str, stepper: str) -> None:
    assert not moving(name, stepper, few(MOTIONS[name].tilts))


@pytest.mark.slow
@over_scenes
@over_steppers
def test_flush_bodies_rest_at_more_places(name: str, stepper: str) -> None:
    assert not resting(name, stepper, list(single(tilts=False))[1::9])


@pytest.mark.slow
@over_motions
@over_steppers
def test_flush_bodies_move_as_aligned_ones_at_more_places(name: str, stepper: str) -> None:
    assert not moving(name, stepper, list(single(MOTIONS[name].tilts))[1::9])


@pytest.mark.campaign
@over_scenes
@over_steppers
def test_flush_bodies_rest_at_all_places(name: str, stepper: str) -> None:
    assert not resting(name, stepper, single(tilts=False))


@pytest.mark.campaign
@over_motions
@over_steppers
def test_flush_bodies_move_as_aligned_ones_at_all_places(name: str, stepper: str) -> None:
    assert not moving(name, stepper, single(MOTIONS[name].tilts))


def test_the_judges_see_what_falls_through_and_what_is_late() -> None:
    """A body without contact does not rest, and is not balanced; a motion of another place is off by that place."""
    scene = RESTS["box on box"](Place())
    lone = lf.SpatialScene(gravity=(0.0, 0.0, -9.81))
    lone.add(lf.Cuboid(0.2, 0.1, 0.06, mass=1.0), "up", position=(0.0, 0.0, 0.09))
    assert rests(lf.simulate(scene, 0.02, STEPPERS["MoreauJean"], progress=False), SIZE).kept
    fallen = rests(lf.simulate(lone, 0.02, STEPPERS["MoreauJean"], progress=False), SIZE)
    assert not fallen.kept
    assert fallen.off == pytest.approx(1.0)  # of its weight
    motion = MOTIONS["slides"]
    other = lf.simulate(motion.build(Place(aside=1e-3)), motion.duration, STEPPERS["MoreauJean"], progress=False)
    found = moves_as_it_must(motion, Place(), STEPPERS["MoreauJean"], other)
    assert not found.kept
    assert found.off == pytest.approx(1e-4 / math.hypot(0.2, 0.1, 0.06), rel=1e-3)


def test_a_drum_rolls_on_a_box() -> None:
    """As far as it goes without slip, and no higher."""
    result = lf.simulate(rolling(Place()), 0.25, lf.EventDriven(), progress=False)
    np.testing.assert_allclose(result.q[-1, -7:-4], [0.1, 0.0, 0.11], atol=1e-8)
    np.testing.assert_allclose(result.u[-1, -6:-3], [1.0, 0.0, 0.0], atol=1e-8)
