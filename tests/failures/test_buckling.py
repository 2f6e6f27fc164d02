"""A beam at and beyond the load at which it buckles is not to be trusted unless it feels its axial force."""

from __future__ import annotations

import math
from typing import Any

import pytest

import lcpflex as lf
from lcpflex.bodies.reduction.stiffening import Stiffening
from lcpflex.results.summary import doubts

STEPPERS = [
    pytest.param(lf.MoreauJean(step=1e-3), id="moreau"),
    pytest.param(lf.GeneralizedAlpha(step=1e-3), id="alpha"),
    pytest.param(lf.EventDriven(), id="events"),
]
# of pi^2 E I / L^2: the least positive root of the determinant of each pair of ends (Timoshenko & Gere)
CRITICAL = {"pinned": 1.0, "cantilever": 0.25, "clamped": 4.0, "propped": 4.493409458**2 / math.pi**2}


class Steel:
    """A strip ``size`` metres long."""

    def __init__(self, size: float = 1.0) -> None:
        self.length = size
        self.beam = lf.Beam(size, 0.02 * size, 0.005 * size, 2700.0, 7e10, elements=20)
        self.euler = math.pi**2 * 7e10 * 0.02 * size * (0.005 * size) ** 3 / 12.0 / size**2


def column(ends: str, share: float, size: float = 1.0, angle: float = 0.0, modes: int = 4, **more: Any) -> lf.Scene:
    """Under ``share`` of the load at which it buckles, and a little across."""
    steel = Steel(size)
    scene = lf.Scene(gravity=(0.0, 0.0))
    beam = scene.add(steel.beam.reduce(modes, damping=0.05, **more), "strut", angle=angle)
    along = math.cos(angle), math.sin(angle)
    left, right, ground = beam.point("left"), beam.point("right"), scene.ground
    there = ground.at(steel.length * along[0], steel.length * along[1])
    scene.join(lf.Revolute(left, ground.at(0, 0)) if ends == "pinned" else lf.Weld(left, ground.at(0, 0)))
    if ends in ("pinned", "propped"):
        scene.join(lf.PointOnLine(right, there, along))
    if ends == "clamped":
        scene.join(lf.Prismatic(right, there, axis=along))
    force = share * CRITICAL[ends] * steel.euler
    scene.load(lf.Force(right, (-force * along[0], -force * along[1])))
    scene.load(lf.Force(beam.point("center"), (-1e-3 * force * along[1], 1e-3 * force * along[0])))
    return scene


def buckles(texts: Any) -> list[str]:
    return [text for text in texts if "of the load at which it buckles, held as it is" in text]


@pytest.mark.parametrize("ends", CRITICAL)
@pytest.mark.parametrize(("size", "angle", "modes"), [(1.0, 0.0, 4), (0.3, 0.7, 6), (1.0, math.pi / 2, 3)])
def test_it_is_told_to_one_percent(ends: str, size: float, angle: float, modes: int) -> None:
    near = lf.simulate(column(ends, 0.99, size, angle, modes), 0.02, lf.MoreauJean(step=1e-3), progress=False)
    assert not buckles(doubts(near))
    assert "and 99 % of the load" in buckles(near.warnings)[0]
    beyond = lf.simulate(column(ends, 1.01, size, angle, modes), 0.02, lf.MoreauJean(step=1e-3), progress=False)
    (said,) = buckles(doubts(beyond))
    assert said.startswith("beam 'strut': compression of")
    assert "and 101 % of the load" in said
    assert "it has no such state" in said


@pytest.mark.parametrize("stepper", STEPPERS)
@pytest.mark.parametrize("share", [1.0, 2.0])
def test_at_eulers_load_and_twice_it_no_run_is_trusted(stepper: Any, share: float) -> None:
    result = lf.simulate(column("pinned", share), 0.05, stepper, progress=False)
    assert "NOT to be trusted" in result.summary()
    assert buckles(doubts(result))


@pytest.mark.parametrize("ends", CRITICAL)
def test_statics_calls_it_unstable(ends: str) -> None:
    near, beyond = (lf.equilibrium(column(ends, share)) for share in (0.97, 2.0))
    assert near.stable
    assert "and 97 % of the load" in buckles(near.warnings)[0]
    assert not beyond.stable
    (said,) = buckles(beyond.unstable)  # a cantilever has bent far aside, and bears less than that on its way
    assert ends == "cantilever" or "and 200 % of the load" in said
    assert "unstable: beam 'strut'" in beyond.summary()


def test_a_beam_that_feels_its_force_is_left_to_that() -> None:
    scene = column("pinned", 0.9, stiffening=Stiffening(axial_force="actual"))
    result = lf.simulate(scene, 0.05, lf.GeneralizedAlpha(step=1e-3), progress=False)
    assert not buckles((*result.warnings, *doubts(result)))
    assert lf.equilibrium(scene).stable


def test_tension_and_short_pushes_do_not_buckle() -> None:
    pulled = lf.simulate(column("pinned", -2.0), 0.05, lf.MoreauJean(step=1e-3), progress=False)
    assert not buckles((*pulled.warnings, *doubts(pulled)))
    steel = Steel()
    scene = column("pinned", 0.1)
    push = lf.Table([0.01, 0.011, 0.012, 0.013], [0.0, -3.0 * steel.euler, -3.0 * steel.euler, 0.0])
    scene.load(lf.Force(scene.body("strut").point("right"), (push, 0.0)))
    pushed = lf.simulate(scene, 0.1, lf.MoreauJean(step=1e-3), progress=False)
    assert not buckles(doubts(pushed))
    assert buckles(pushed.warnings)


@pytest.mark.parametrize(("share", "told"), [(0.9, False), (1.1, True)])
def test_contacts_hold_ends_as_joints_do(share: float, told: bool) -> None:
    """Between two V-shaped grooves, each two walls on a round end: pinned."""
    steel = Steel()
    scene = lf.Scene(gravity=(0.0, 0.0))
    beam = scene.add(steel.beam.reduce(4, damping=0.05), "strut")
    scene.contact(beam.node(0.0, 0.0), scene.ground.half_plane((0, 0), (1.0, 1.0)), name="below")
    scene.contact(beam.node(0.0, 0.0), scene.ground.half_plane((0, 0), (1.0, -1.0)), name="above")
    slider = lf.PointOnLine(beam.point("right"), scene.ground.at(1.0, 0.0), (1, 0))
    scene.join(slider)
    scene.load(lf.Force(beam.point("right"), (-share * steel.euler, 0.0)))
    result = lf.simulate(scene, 0.05, lf.MoreauJean(step=1e-3), progress=False)
    assert bool(buckles(doubts(result))) == told
    rest = lf.equilibrium(scene)
    assert rest.stable != told


def test_links_that_turn_are_no_columns_that_fall() -> None:
    """A pendulum upside down is pressed by its weight and tips over: its motion is right, and it does not buckle."""
    scene = lf.Scene()
    beam = scene.add(Steel().beam.reduce(4, damping=0.05), "strut", angle=math.pi / 2 + 0.01)
    scene.join(lf.Revolute(beam.point("left"), scene.ground.at(0, 0)))
    result = lf.simulate(scene, 0.3, lf.GeneralizedAlpha(step=1e-3), progress=False)
    assert not doubts(result)
