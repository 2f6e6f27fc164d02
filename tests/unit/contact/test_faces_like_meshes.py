"""Nodes of a linear face touch as those of the whole surface do, whatever the other one is and whoever steps."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.contact.near import near
from lcpflex.contact.spatial.table import copy_entry
from lcpflex.jit.struct import pack

STEPPERS = {
    "MoreauJean": lf.MoreauJean(step=2e-5),
    "GeneralizedAlpha": lf.GeneralizedAlpha(step=2e-5),
    "EventDriven": lf.EventDriven(),
}


@cache
def block() -> lf.SpatialBody:
    steel = {"density": 7800.0, "youngs_modulus": 2.1e9, "poissons_ratio": 0.3}
    return lf.Solid.box((0.1, 0.1, 0.05), elements=(3, 3, 2), **steel).reduce(modes=2, contact="bottom", rows="normal")


def dropped(master: str, side: str, points: str | None = None) -> lf.SpatialScene:
    """A block that falls, and slides, on something."""
    scene = lf.SpatialScene()
    body = scene.add(block(), position=(0.003, 0.001, 0.0251), velocity=(0.1, 0.0, -0.1))
    ground = scene.ground
    other: Any = ground.plane((0, 0, 0), (0, 0, 1))
    if master == "box":
        other = ground.box((0, 0, -0.1), (0.4, 0.4, 0.2))
    if master == "rigid body":
        plate = scene.add(lf.Cuboid(0.2, 0.2, 0.05, density=7800.0), position=(0, 0, -0.025))
        other = plate.surface()
        scene.contact(other, ground.plane((0, 0, -0.05), (0, 0, 1)), friction=0.5)
    own = body.surface() if side == "mesh" else body.face("bottom")
    scene.contact(own, other, friction=0.3, points=points)
    return scene


@pytest.mark.filterwarnings("ignore::lcpflex.ModelWarning")
@pytest.mark.parametrize("stepper", STEPPERS)
@pytest.mark.parametrize("master", ["plane", "box", "rigid body"])
def test_runs_are_those_of_the_whole_surface(master: str, stepper: str) -> None:
    ends = [
        lf.simulate(dropped(master, side, points), 2e-3, STEPPERS[stepper]).q[-1]
        for side, points in (("mesh", None), ("face", "nodes"))
    ]
    np.testing.assert_allclose(ends[1], ends[0], atol=1e-9)


@pytest.mark.filterwarnings("ignore::lcpflex.ModelWarning")
def test_an_entry_of_means_may_be_copied_to_its_own_place_and_elsewhere() -> None:
    scene = dropped("box", "face", "areas")
    compiled = scene.compile()  # which warns of two modes that give way too little
    table, n = near(pack(compiled.model), np.array(compiled.q), 1e-3)
    assert n > 2
    assert table.averaged[:n].all()
    before = [np.array(table.faces.means.phi), np.array(table.faces.means.place)]
    copy_entry(table, 1, table, 1)
    np.testing.assert_array_equal(table.faces.means.phi, before[0])
    np.testing.assert_array_equal(table.faces.means.place, before[1])
    copy_entry(table, 2, table, 0)
    half = len(before[1]) // len(table.key)
    np.testing.assert_array_equal(table.faces.means.place[:half], before[1][2 * half : 3 * half])
    assert table.point[0, :4].tolist() == [0, 2, 4, 6]
