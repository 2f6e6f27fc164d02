"""A beam at and beyond the load at which it buckles is not to be trusted unless it feels its axial force."""

from __future__ import annotations

import math
from typing import Any

import pytest
from scipy.spatial.transform import Rotation

import lcpflex as lf
from lcpflex.bodies.reduction.stiffening import Stiffening
from lcpflex.results.doubts import doubts

STEPPERS = [
    pytest.param(lf.MoreauJean(step=1e-3), id="moreau"),
    pytest.param(lf.GeneralizedAlpha(step=1e-3), id="alpha", marks=pytest.mark.slow),
    pytest.param(lf.EventDriven(), id="events", marks=pytest.mark.slow),
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


def column_in_space(ends: str, share: float, turn: tuple[float, float, float], flat: bool) -> lf.SpatialScene:
    """The same strip, flat or on edge, however it lies in space."""
    way = Rotation.from_rotvec(turn)
    weak, stiff = 0.02 * 0.005**3 / 12.0, 0.005 * 0.02**3 / 12.0
    moments = (weak, stiff) if flat else (stiff, weak)
    body = lf.SpatialBeam(1.0, 1e-4, moments, 4.0 * weak, 2700.0, 7e10, poissons_ratio=0.3, elements=20)
    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    beam = scene.add(body.reduce(modes=8, damping=0.05), "strut", orientation=way)

    def there(x: float) -> Any:
        return scene.ground.at(*way.apply([x, 0.0, 0.0]))

    left, right = beam.at(-0.5, 0.0, 0.0), beam.at(0.5, 0.0, 0.0)
    if ends == "cantilever":
        scene.join(lf.Weld(left, there(-0.5)))
    else:
        scene.join(lf.Ball(left, there(-0.5)))
        scene.join(lf.PointOnLine(right, there(0.5), tuple(way.apply([1.0, 0.0, 0.0]))))
    force = share * CRITICAL[ends] * math.pi**2 * 7e10 * weak
    scene.load(lf.Force(right, tuple(way.apply([-force, 0.0, 0.0]).tolist())))
    scene.load(lf.Force(beam.at(0.0, 0.0, 0.0), tuple(way.apply([0.0, 1e-3 * force, 1e-3 * force]).tolist())))
    return scene


@pytest.mark.parametrize("stepper", STEPPERS)
@pytest.mark.parametrize("ends", ["pinned", "cantilever"])
@pytest.mark.parametrize(
    ("turn", "flat"), [((0.0, 0.0, 0.0), True), ((0.3, -0.8, 1.1), False)], ids=["flat", "on edge"]
)
def test_beams_of_space_buckle_too(stepper: Any, ends: str, turn: Any, flat: bool) -> None:
    def said(share: float) -> tuple[list[str], list[str]]:
        result = lf.simulate(column_in_space(ends, share, turn, flat), 0.04, stepper, progress=False)
        return buckles(result.warnings), buckles(doubts(result))

    assert said(0.05) == ([], [])
    warned, wrong = said(0.6)
    assert not wrong
    share = float(warned[0].partition(" s, ")[2].partition(" %")[0])
    assert (59.0 if ends == "pinned" else 50.0) < share < 60.5
    for twice in (1.02, 2.0):
        warned, wrong = said(twice)
        assert not warned
        assert "beam 'strut': compression of" in wrong[0]
    assert said(-2.0) == ([], [])


def stiffened_column(share: float, given: float) -> lf.SpatialScene:
    """Pinned, in space, under ``share`` of the load at which it buckles, of which its stiffness has ``given``."""
    weak, stiff = 0.02 * 0.005**3 / 12.0, 0.005 * 0.02**3 / 12.0
    euler = math.pi**2 * 7e10 * weak
    beam = lf.SpatialBeam(1.0, 1e-4, (weak, stiff), 4.0 * weak, 2700.0, 7e10, poissons_ratio=0.3, elements=20)
    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    body = beam.reduce(8, 0.05, stiffening=Stiffening(axial_force=-given * euler) if given else None)
    placed = scene.add(body, "strut")
    scene.join(lf.Ball(placed.point("left"), scene.ground.at(-0.5, 0.0, 0.0)))
    scene.join(lf.PointOnLine(placed.point("right"), scene.ground.at(0.5, 0.0, 0.0), (1.0, 0.0, 0.0)))
    scene.load(lf.Force(placed.point("right"), (-share * euler, 0.0, 0.0)))
    scene.load(lf.Force(placed.point("center"), (0.0, 0.0, 1e-3 * euler)))
    return scene


def test_a_beam_of_space_is_not_warned_of_what_it_counts_with() -> None:
    def warned(share: float, given: float) -> list[str]:
        stepper = lf.MoreauJean(step=1e-3)
        return buckles(lf.simulate(stiffened_column(share, given), 0.04, stepper, progress=False).warnings)

    assert warned(0.6, 0.0)
    assert not warned(0.6, 0.6)
    (told,) = warned(0.6, 0.3)  # of the other half
    assert "compression of 43" in told
    assert warned(0.0, 0.6) == []  # a cable within it


def test_spin_that_stiffens_is_counted_with() -> None:
    """Of a beam that flies free but says that it is held at its end the tension is far less than it counts with."""

    def told(stiffening: Stiffening | None) -> list[str]:
        beam = lf.SpatialBeam(1.0, 1e-4, (2e-10, 2e-10), 3e-10, 2700.0, 7e10, poissons_ratio=0.3, elements=20)
        scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
        scene.add(beam.reduce(8, 0.05, stiffening=stiffening), angular_velocity=(0.0, 0.0, 60.0))
        result = lf.simulate(scene, 0.04, lf.MoreauJean(step=5e-4), progress=False)
        return buckles((*result.warnings, *doubts(result)))

    assert told(None) == told(Stiffening()) == []
    (text,) = told(Stiffening(held="left"))
    assert "compression of 486 N at x = -0.5 m" in text
