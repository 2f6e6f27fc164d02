"""What loads hold in place stores no energy to compare with: its units are forces, and it is trusted."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.results.doubts import doubts
from lcpflex.results.energy_balance import Energies, EnergyGrowth, energy_doubts

STEPPERS = [
    pytest.param(lf.EventDriven(), id="events"),
    pytest.param(lf.MoreauJean(step=1e-3), id="moreau"),
    pytest.param(lf.GeneralizedAlpha(step=1e-3), id="alpha"),
]


def pressed(force: tuple[float, float] = (2.0, -10.0), size: float = 1.0, mass: float = 1.0) -> lf.Scene:
    """A box on the floor, lengths in units of 1/size metres."""
    scene = lf.Scene(gravity=(0.0, 0.0))
    box = scene.add(lf.Box(0.2 * size, 0.1 * size, mass=mass), position=(0.0, 0.05 * size))
    scene.contact(box.surface(), scene.ground.half_plane((0, 0), (0, 1)), friction=0.5)
    scene.load(lf.Force(box.at(0.0, -0.05 * size), force))
    return scene


def brake() -> lf.Scene:
    """Two pads on a disc, which a torque would turn."""
    scene = lf.Scene(gravity=(0.0, 0.0))
    disc = scene.add(lf.Disc(0.1, mass=2.0))
    scene.join(lf.Revolute(disc.point("center"), scene.ground.at(0.0, 0.0)))
    for side in (1.0, -1.0):
        pad = scene.add(lf.Box(0.05, 0.02, mass=0.1), position=(0.0, side * 0.11))
        scene.join(lf.Prismatic(pad.point("center"), scene.ground.at(0.0, side * 0.11), axis=(0.0, 1.0)))
        scene.contact(pad.surface(), disc.surface(), friction=0.5)
        scene.load(lf.Force(pad.point("center"), (0.0, -side * 50.0)))
    scene.load(lf.Torque(disc.point("center"), 2.0))
    return scene


def joints_alone() -> lf.Scene:
    scene = lf.Scene(gravity=(0.0, 0.0))
    box = scene.add(lf.Box(0.2, 0.1, mass=1.0), position=(0.1, 0.0))
    scene.join(lf.Weld(box.at(-0.1, 0.0), scene.ground.at(0.0, 0.0)))
    scene.load(lf.Force(box.at(0.1, 0.0), (10.0, 3.0)))
    return scene


def on_a_spring() -> lf.Scene:
    scene = lf.Scene(gravity=(0.0, 0.0))
    box = scene.add(lf.Box(0.2, 0.1, mass=1.0), position=(0.0, 0.05))
    scene.contact(box.surface(), scene.ground.half_plane((0, 0), (0, 1)), friction=0.5)
    scene.load(lf.Spring(box.at(0.0, 0.0), scene.ground.at(0.0, 1.0), stiffness=100.0, length=2.0))
    return scene


def light_below_heavy() -> lf.Scene:
    scene = lf.Scene(gravity=(0.0, 0.0))
    low = scene.add(lf.Box(0.2, 0.1, mass=1e-4), position=(0.0, 0.05))
    top = scene.add(lf.Box(0.2, 0.1, mass=1e4), position=(0.0, 0.15))
    scene.contact(low.surface(), scene.ground.half_plane((0, 0), (0, 1)), friction=0.5)
    scene.contact(low.surface(), top.surface(), friction=0.5)
    scene.load(lf.Force(top.at(0.0, -0.05), (2.0, -10.0)))
    return scene


def in_space(mass: float = 1.0) -> lf.SpatialScene:
    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    box = scene.add(lf.Cuboid(0.2, 0.1, 0.1, mass=mass), position=(0.0, 0.0, 0.05))
    scene.contact(box.surface(), scene.ground.plane((0, 0, 0), (0, 0, 1)), friction=0.5)
    scene.load(lf.Force(box.at(0.0, 0.0, -0.05), (2.0, 1.0, -10.0)))
    return scene


def damped() -> lf.Scene:
    """With a damper far too strong for a step, which has nothing to do."""
    scene = pressed()
    scene.load(lf.Spring(scene.body("body1").at(0.0, 0.0), scene.ground.at(0.0, 1.0), stiffness=0.0, damping=3e3))
    return scene


SCENES: dict[str, Callable[[], Any]] = {
    "pressed": pressed,
    "pressed alone": lambda: pressed((0.0, -10.0)),
    "millimetres": lambda: pressed((2e3, -1e4), 1e3),
    "tonnes and millimetres": lambda: pressed((2.0, -10.0), 1e3, 1e-3),
    "kilometres": lambda: pressed((2.0, -10.0), 1e-3),
    "meganewtons": lambda: pressed((2e6, -1e7)),
    "brake": brake,
    "joints": joints_alone,
    "spring": on_a_spring,
    "masses": light_below_heavy,
    "space": in_space,
    "light in space": lambda: in_space(1e-3),
    "damper": damped,
}


@pytest.mark.parametrize("stepper", STEPPERS)
@pytest.mark.parametrize("name", SCENES)
def test_it_is_trusted_without_a_warning(name: str, stepper: Any) -> None:
    result = lf.simulate(SCENES[name](), 0.2, stepper, progress=False)
    assert not doubts(result)
    assert not result.warnings


def unbalanced(result: lf.Result, energy: float) -> lf.Result:
    """The result with so much energy more at its end than it can explain [J]."""
    e = result.energies
    more = energy * np.linspace(0.0, 1.0, len(e.kinetic))
    found = Energies.audit(e.kinetic + more, e.elastic, e.potential, e.friction, e.impact, e.damping, e.work)
    return replace(result, energies=found)


@pytest.mark.parametrize("space", [False, True], ids=["plane", "space"])
def test_what_counts_is_what_forces_would_do(space: bool) -> None:
    """10 N over .2 m are 2 J: a millionth of that is nothing where all rests, and is much where something moves."""
    result = lf.simulate(in_space() if space else pressed(), 0.1, STEPPERS[1].values[0], progress=False)
    assert not doubts(unbalanced(result, 2e-6))
    assert "gained without explanation" in doubts(unbalanced(result, 2e-4))[0]
    moved = result.q + np.linspace(0.0, 1e-3, len(result.q))[:, None] * np.eye(result.q.shape[1])[0]
    assert "gained without explanation" in doubts(replace(unbalanced(result, 2e-6), q=moved))[0]


def test_energy_that_grew_by_half_is_never_trusted() -> None:
    """However much more the loads could do: something moves, slowly, and has half as much energy again as it may."""
    zero = np.zeros(101)
    for growth, told in ((0.6, True), (0.2, False)):
        grown = Energies.audit(1e-3 * np.linspace(1.0 - growth, 1.0, 101), zero, zero, zero, zero, zero, zero)
        asked = grown, (0.0, 0.0, 0.0), EnergyGrowth.WARN, 100, 2e3
        assert bool(energy_doubts(*asked, moved=True)) == told
        assert not energy_doubts(*asked, moved=False)
