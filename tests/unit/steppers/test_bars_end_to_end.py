"""Flexible bars that meet with equal ends leave each other as one leaves a rigid wall."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import lcpflex as lf
from tests.split_surfaces import soft_block

LENGTH, WIDTH = 0.2, 0.04
SPEED, GAP, END = 1.0, 1e-4, 2.5e-3
STEPPERS = {
    "event-driven": lf.EventDriven(),
    "Moreau-Jean": lf.MoreauJean(step=1e-5),
    "generalised-alpha": lf.GeneralizedAlpha(step=1e-5),
}


@cache
def bar(narrower: float = 0.0, cells: tuple[int, int, int] = (8, 2, 2)) -> lf.SpatialBody:
    width = WIDTH * (1.0 - narrower)
    return soft_block((LENGTH, width, width), cells, 12, density=1000.0, youngs_modulus=2e8)


@cache
def from_the_wall(stepper: str) -> float:
    """The share of its speed that one bar leaves a rigid wall with."""
    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    one = scene.add(bar(), "one", (-0.5 * (LENGTH + GAP), 0.0, 0.0), velocity=(SPEED, 0.0, 0.0))
    scene.contact(one.surface(), scene.ground.plane((0.0, 0.0, 0.0), (-1.0, 0.0, 0.0)))
    return -float(lf.simulate(scene, END, STEPPERS[stepper]).u[-1, 0]) / SPEED


def met(stepper: str, one: lf.SpatialBody, two: lf.SpatialBody, aside: Any = (0.0, 0.0), turn: Any = None) -> Any:
    """Both velocities (6,) after two bars have met, as shares of the speed, and the run."""
    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    first = scene.add(one, "one", (-0.5 * (LENGTH + GAP), 0.0, 0.0), velocity=(SPEED, 0.0, 0.0))
    there = (0.5 * (LENGTH + GAP), *aside)
    second = scene.add(two, "two", there, Rotation.identity() if turn is None else turn, velocity=(-SPEED, 0.0, 0.0))
    scene.contact(first.surface(), second.surface())
    result = lf.simulate(scene, END, STEPPERS[stepper])
    n = result.u.shape[1] // 2
    return result.u[-1, :6] / SPEED, result.u[-1, n : n + 6] / SPEED, result


CASES: dict[str, Any] = {
    "equal": {},
    "aside 3e-12": {"aside": (3e-12, -1e-12)},
    "aside 4e-9": {"aside": (4e-9, 1e-9)},
    "aside 2e-6": {"aside": (-2e-6, 1e-6)},
    "aside 3e-5": {"aside": (3e-5, 1e-5)},
    "rolled 5e-8": {"turn": Rotation.from_euler("x", 5e-8)},
    "rolled 3e-4": {"turn": Rotation.from_euler("x", 3e-4)},
    "yaw 2e-9": {"turn": Rotation.from_euler("z", 2e-9)},
    "yaw 3e-7": {"turn": Rotation.from_euler("z", 3e-7)},
}
QUICK = [("event-driven", "yaw 2e-9"), ("Moreau-Jean", "aside 4e-9"), ("generalised-alpha", "aside 2e-6")]


@pytest.mark.parametrize(
    ("stepper", "case"),
    [
        pytest.param(stepper, case, marks=() if (stepper, case) in QUICK else pytest.mark.slow)
        for stepper in STEPPERS
        for case in CASES
    ],
)
def test_equal_bars_leave_as_from_a_wall(stepper: str, case: str) -> None:
    one, two, result = met(stepper, bar(), bar(), **CASES[case])
    assert not result.warnings
    assert -one[0] == pytest.approx(from_the_wall(stepper), abs=1.5e-3)
    assert two[0] == pytest.approx(-one[0], abs=1e-6)
    aside = max(np.abs(CASES[case].get("aside", (0.0, 0.0))))  # the arm of 1.8 m v: .27 rad/s a millimetre
    assert np.abs([one[1:3], two[1:3]]).max() < 1e-4 + 5.0 * aside  # sideways
    assert np.abs([one[3:], two[3:]]).max() < 5e-3 + 300.0 * aside  # [rad/s]


@pytest.mark.slow
@pytest.mark.parametrize("stepper", STEPPERS)
@pytest.mark.parametrize("narrower", [1e-2, 2e-3, 1.04e-3, 1e-3, 5e-4, 1e-4, 1e-6, 1e-9])
@pytest.mark.parametrize("first", [True, False])
def test_bars_of_hardly_different_width(narrower: float, first: bool, stepper: str) -> None:
    """The momentum of both is kept, and what they leave with changes with the width alone, whichever is first."""
    bars = (bar(narrower), bar()) if first else (bar(), bar(narrower))
    one, two, result = met(stepper, *bars)
    masses = [b.mass for b in bars]
    assert masses[0] * one[0] + masses[1] * two[0] == pytest.approx(masses[0] - masses[1], abs=1e-9)
    lighter = (1.0 - narrower) ** 2
    apart = two[0] - one[0]
    assert apart == pytest.approx(2.0 * from_the_wall(stepper), abs=1.5e-3 + 0.2 * (1.0 - lighter))
    assert np.abs([one[1:3], two[1:3]]).max() < 1e-4
    assert np.abs([one[3:], two[3:]]).max() < 5e-3
    assert not result.warnings


@pytest.mark.slow
@pytest.mark.parametrize("stepper", STEPPERS)
@pytest.mark.parametrize("cells", [(8, 3, 3), (6, 1, 1)])
def test_bars_with_other_meshes(cells: tuple[int, int, int], stepper: str) -> None:
    """A finer and a coarser one: as from a wall, to what the meshes differ by."""
    for aside in ((0.0, 0.0), (1e-9, 0.0), (1e-5, 2e-5)):
        one, two, result = met(stepper, bar(0.0, cells), bar(), aside)
        assert two[0] - one[0] == pytest.approx(2.0 * from_the_wall(stepper), abs=0.05)
        assert np.abs([one[3:], two[3:]]).max() < 0.02
        assert not result.warnings
