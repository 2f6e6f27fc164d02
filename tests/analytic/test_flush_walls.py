"""Walls of bricks that are aligned but for next to nothing stand, or tip as the closed form says; cubes stack."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import lcpflex as lf
from tests.flush.judging import deepest_overlap, names_of, off_rest, poses, rests, turned, unbalanced
from tests.flush.pairs import BRICK, box
from tests.flush.scenes import GRAVITY, STEP, STEPPERS
from tests.flush.walls import LAST, half_bond, heap, ninety_degrees, stack_of_cubes, tipping, wall

NOISE = (0.0, 1e-10, 1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4)  # [m]
SIZE = float(np.linalg.norm(BRICK))
QUICK = 0.05  # [s]
TURNS = dict(ninety_degrees())

over_steppers = pytest.mark.parametrize("stepper", STEPPERS)


def stands(noise: float, stepper: str, duration: float) -> None:
    """Nothing has moved by 1e-6 m or turned by 1e-6 rad, and the floor carries all."""
    result = lf.simulate(wall(noise), duration, STEPPERS[stepper], progress=False)
    assert off_rest(result) < 1e-6
    force, moment = unbalanced(result)
    assert max(force, moment / SIZE) < 1e-6
    last = result.contact_points.at(len(result.times) - 1)
    on_floor = [("ground" in result.contact_names[c]) for c in last.contact]
    assert last.vector[on_floor].sum(axis=0) == pytest.approx([0.0, 0.0, 12.0 * GRAVITY], abs=1e-6 * 12.0 * GRAVITY)


@pytest.mark.parametrize("noise", [0.0, 1e-9, 1e-5])
def test_a_wall_stands(noise: float) -> None:
    stands(noise, "MoreauJean", QUICK)


@pytest.mark.slow
@pytest.mark.parametrize("noise", NOISE)
def test_a_wall_stands_for_two_seconds(noise: float) -> None:
    stands(noise, "MoreauJean", 2.0)


@pytest.mark.campaign
@pytest.mark.parametrize("noise", NOISE)
@over_steppers
def test_a_wall_stands_under_every_stepper(noise: float, stepper: str) -> None:
    stands(noise, stepper, 2.0)


def tips(noise: float, stepper: str, duration: float = 0.2) -> None:
    """The brick that nothing holds, by 5 % of its closed form; the others rest."""
    result = lf.simulate(half_bond(noise), duration, STEPPERS[stepper], progress=False)
    last = names_of(result).index(LAST)
    at = poses(result)[:, :, :3]
    angle, sunk = tipping(duration)
    assert at[0, last, 2] - at[-1, last, 2] == pytest.approx(sunk, rel=0.05)
    assert turned(result, last).magnitude() == pytest.approx(angle, rel=0.05)
    assert np.abs(np.delete(at[-1] - at[0], last, axis=0)).max() < 1e-6


def test_the_end_brick_of_a_half_bond_tips() -> None:
    tips(0.0, "MoreauJean")


@pytest.mark.slow
@pytest.mark.parametrize("noise", [0.0, 1e-8, 1e-5])
def test_the_end_brick_of_a_half_bond_with_noise_tips(noise: float) -> None:
    tips(noise, "MoreauJean")


@pytest.mark.campaign
@pytest.mark.parametrize("noise", [0.0, 1e-8, 1e-5])
@over_steppers
def test_the_end_brick_of_a_half_bond_tips_under_every_stepper(noise: float, stepper: str) -> None:
    tips(noise, stepper)


def test_the_closed_form_of_a_tipping_brick() -> None:
    """The published numbers, and small times: theta = g d t^2 / (2 k^2)."""
    assert tipping(0.2) == pytest.approx((0.10684, 0.384e-3), rel=1e-3)
    assert tipping(1e-3)[0] == pytest.approx(9.81 * 2e-3 * 1e-6 / (2.0 * 4.537333e-3), rel=1e-4)


def cubes(names: tuple[str, str, str]) -> tuple[Rotation, Rotation, Rotation]:
    first, second, third = (TURNS[name] for name in names)
    return first, second, third


SPELLED = [("exact, x", "float32, z", "quaternion of 7, z"), ("chain xyz", "float32, y", "degrees, z")]


# Of 27 stacks, and which ones is rounding: generalised-alpha lets a few fall for a step and a half, up to five times
# the bound of 1 um; event-driven once finds no step short enough, 0.14 us after the start, where sides that are open by
# 1e-8 m close one after the other.
ONE_OFF = pytest.mark.xfail(reason="a few stacks of 27 fall too far, or end in an error", strict=False)
MARKED = [pytest.param(name, marks=ONE_OFF) if name == "GeneralizedAlpha" else name for name in STEPPERS]


@pytest.mark.parametrize("names", SPELLED)
@pytest.mark.parametrize("stepper", MARKED)
def test_cubes_stack_however_right_angles_are_written(names: tuple[str, str, str], stepper: str) -> None:
    result = lf.simulate(stack_of_cubes(cubes(names)), QUICK, STEPPERS[stepper], progress=False)
    assert rests(result, 0.1).kept


@pytest.mark.slow
@pytest.mark.parametrize(
    "stepper", [name if name == "MoreauJean" else pytest.param(name, marks=ONE_OFF) for name in STEPPERS]
)
def test_cubes_stack_with_every_spelling(stepper: str) -> None:
    """Each in the middle, with the next ones in the list below and above.

    Chains of floats of four bytes are off by 1e-7 rad: a side is open by 1e-8 m, and falls for a step, by g h^2 / 2.
    Which of the spellings do is rounding.
    """
    names, fallen = list(TURNS), []
    for k in range(len(names)):
        three = (names[k - 1], names[k], names[(k + 7) % len(names)])
        result = lf.simulate(stack_of_cubes(cubes(three)), QUICK, STEPPERS[stepper], progress=False)
        fallen += [] if rests(result, 0.1).off <= 0.5 * GRAVITY * STEP**2 / 0.1 else [three]
    assert not fallen


@pytest.mark.slow
def test_fifty_tilted_boxes_come_to_rest_in_a_box() -> None:
    """All finite and none outside; none in another one by more than what a fast step leaves."""
    result = lf.simulate(heap(), 1.5, STEPPERS["MoreauJean"], progress=False)
    assert np.isfinite(result.q).all()
    at = poses(result)[-1, :, :3]
    assert np.abs(at[:, :2]).max() < 0.3
    assert at[:, 2].min() > 0.02
    assert np.abs(result.u[-1]).max() < 0.1
    assert deepest_overlap(result, box(0.14, 0.1, 0.06).corners) < 5e-3
