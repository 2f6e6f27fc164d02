"""Forces of contacts that share a load in more than one way: the least ones are stored, and the motion is the same."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.jit.kernel import FloatArray
from tests.scenes import floor_of

G = 9.81
STEPPERS = [
    pytest.param(lf.MoreauJean(step=1e-3), id="moreau-jean"),
    pytest.param(lf.GeneralizedAlpha(step=1e-3), id="generalized-alpha"),
    pytest.param(lf.MoreauJean(step=1e-3, adaptive=lf.AdaptiveStep()), id="adaptive moreau-jean"),
    pytest.param(lf.EventDriven(), id="event-driven"),
]


def last_forces(result: lf.Result) -> FloatArray:
    """(points, 2) forces at the end [N], from left to right."""
    last = result.contact_points.record == len(result.times) - 1
    order = np.argsort(result.contact_points.place[last, 0])
    return np.asarray(result.contact_points.force[last][order])


def box(
    slope: float = 0.0, friction: float = 0.5, size: float = 1.0, mass: float = 1.0, speed: float = 0.0
) -> lf.Scene:
    """A box of 0.4 by 0.2 on a plane, gravity turned by ``slope``."""
    scene = lf.Scene(gravity=(G * size * math.sin(slope), -G * size * math.cos(slope)))
    body = lf.Box(0.4 * size, 0.2 * size, mass=mass)
    placed = scene.add(body, name="box", position=(0.0, 0.1 * size), velocity=(speed, 0.0))
    scene.contact(placed.surface(), floor_of(scene), friction=friction, name="floor")
    return scene


@pytest.mark.parametrize("stepper", STEPPERS)
@pytest.mark.parametrize(("size", "mass"), [(1.0, 1.0), (1e3, 1e-3), (0.01, 50.0)], ids=["m, kg", "mm, t", "small"])
def test_standing_box_has_no_friction(stepper: Any, size: float, mass: float) -> None:
    """Its corners could push against each other by up to mu N; a vertex of all solutions did."""
    result = lf.simulate(box(size=size, mass=mass), 0.02, stepper)
    half = 0.5 * mass * G * size
    assert last_forces(result) == pytest.approx(np.array([[half, 0.0], [half, 0.0]]), abs=1e-7 * half)
    assert not result.warnings


@pytest.mark.parametrize("stepper", STEPPERS)
def test_box_on_a_slope_shares_friction(stepper: Any) -> None:
    """Normal forces follow from equilibrium; friction is split evenly, as far as each corner can hold its half."""
    for slope, even in ((0.1, True), (0.43, False)):
        forces = last_forces(lf.simulate(box(slope), 0.02, stepper))
        tip = 0.25 * G * math.sin(slope)  # moment of friction over the width
        assert forces[:, 0] == pytest.approx(
            [0.5 * G * math.cos(slope) - tip, 0.5 * G * math.cos(slope) + tip], abs=1e-7
        )
        assert forces[:, 1].sum() == pytest.approx(-G * math.sin(slope), abs=1e-7)
        assert (np.abs(forces[:, 1]) <= 0.5 * forces[:, 0] * (1.0 + 1e-9)).all()
        if even:
            assert forces[0, 1] == pytest.approx(forces[1, 1], abs=1e-7)
        elif not isinstance(stepper, lf.EventDriven):  # the upper corner at its limit, the other one holds the rest
            assert forces[0, 1] == pytest.approx(-0.5 * forces[0, 0], abs=1e-6)


@pytest.mark.parametrize("stepper", STEPPERS)
def test_what_is_determined_stays_as_it_is(stepper: Any) -> None:
    """A sliding box: friction is mu N at each corner, and N differs by the moment of friction."""
    forces = last_forces(lf.simulate(box(speed=1.0), 0.02, stepper))
    tip = 0.25 * 0.5 * G
    assert forces[:, 0] == pytest.approx([0.5 * G - tip, 0.5 * G + tip], abs=1e-6)
    assert forces[:, 1] == pytest.approx(-0.5 * forces[:, 0], abs=1e-6)


@pytest.mark.parametrize("stepper", STEPPERS)
def test_disc_in_a_wedge(stepper: Any) -> None:
    """Two walls at 20 degrees to the vertical: with mu = 0.5 friction at its limit asks for the least of all forces."""
    half = math.radians(20.0)
    scene = lf.Scene()
    disc = scene.add(lf.Disc(0.1, mass=1.0), position=(0.0, 0.1 / math.sin(half)))
    for side in (1.0, -1.0):
        wall = scene.ground.half_plane((0, 0), (side * math.cos(half), math.sin(half)))
        scene.contact(disc.surface(), wall, friction=0.5)
    forces = last_forces(lf.simulate(scene, 0.02, stepper))
    normal = 0.5 * G / (math.sin(half) + 0.5 * math.cos(half))
    assert forces[:, 0] == pytest.approx([normal, normal], rel=1e-6)
    assert np.abs(forces[:, 1]) == pytest.approx([0.5 * normal, 0.5 * normal], rel=1e-6)
    assert forces[0, 1] == pytest.approx(-forces[1, 1], rel=1e-6)


def supported(places: tuple[float, ...]) -> lf.Scene:
    """A beam of 3 kg on round supports at ``places``."""
    scene = lf.Scene()
    beam = scene.add(lf.Box(1.0, 0.1, mass=3.0), position=(0.0, 0.05))
    for x in places:
        scene.contact(beam.surface(), scene.ground.circle((x, -0.05), 0.05), friction=0.3)
    return scene


@pytest.mark.parametrize("stepper", STEPPERS[:3])
def test_three_supports_share_evenly(stepper: Any) -> None:
    """N of three supports from two equations: a vertex has one of them carry nothing, or all."""
    forces = last_forces(lf.simulate(supported((-0.4, 0.0, 0.4)), 0.02, stepper))
    assert forces == pytest.approx(np.array([[G, 0.0]] * 3), abs=1e-7)
    skew = last_forces(lf.simulate(supported((0.4, -0.1, -0.4)), 0.02, stepper))  # least: N linear in x
    assert np.diff(skew[:, 0]) / np.array([0.3, 0.5]) == pytest.approx([np.diff(skew[:, 0])[0] / 0.3] * 2, abs=1e-6)
    assert skew[:, 0].sum() == pytest.approx(3.0 * G, abs=1e-7)
    assert skew[:, 0] @ np.array([-0.4, -0.1, 0.4]) == pytest.approx(0.0, abs=1e-7)


@pytest.mark.parametrize("places", [(-0.4, 0.0, 0.4), (-0.4, -0.2, 0.0, 0.2, 0.4), (0.4, -0.1, -0.4)])
def test_event_driven_says_which_support_was_spared(places: tuple[float, ...]) -> None:
    """It maintains contacts that carry a force only: one choice of several, and marked as such."""
    result = lf.simulate(supported(places), 0.02, lf.EventDriven())
    (said,) = result.notes
    assert "contact forces are not unique" in said
    assert "was taken to carry nothing" in said
    assert said in result.summary()
    forces = last_forces(result)
    assert forces[:, 0].sum() == pytest.approx(3.0 * G, abs=1e-7)
    assert len(forces) < len(places)


@pytest.mark.parametrize(
    "scene", [supported((-0.4, 0.4)), box(), box(0.1), box(speed=1.0)], ids=["beam", "box", "slope", "slides"]
)
def test_event_driven_says_nothing_of_forces_that_are_all_there(scene: lf.Scene) -> None:
    assert not lf.simulate(scene, 0.02, lf.EventDriven()).notes


def row_of_dominoes(count: int, backwards: bool) -> lf.Scene:
    scene = lf.Scene()
    floor = floor_of(scene)
    order = range(count - 1, -1, -1) if backwards else range(count)
    for i in order:
        domino = scene.add(lf.Box(0.008, 0.05, mass=0.01), position=(0.03 * i, 0.025))
        scene.contact(domino.surface(), floor, friction=0.4)
    return scene


@pytest.mark.parametrize("backwards", [False, True])
def test_standing_dominoes_do_not_lean_on_friction(backwards: bool) -> None:
    """Twenty of them: each showed T = -+ mu N at its corners, 22 degrees off."""
    result = lf.simulate(row_of_dominoes(20, backwards), 0.01, lf.MoreauJean(step=1e-3))
    forces = last_forces(result)
    assert forces.shape == (40, 2)
    assert forces[:, 0] == pytest.approx(0.005 * G, rel=1e-7)
    assert np.abs(forces[:, 1]).max() < 1e-9


def heap(seed: int) -> lf.Scene:
    draw = np.random.default_rng(seed).uniform
    scene = lf.Scene()
    for point, normal in (((0, 0), (0, 1)), ((-0.4, 0), (1, 0)), ((0.4, 0), (-1, 0))):
        scene.ground.half_plane(point, normal)
    for k in range(4):
        scene.add(
            lf.Box(draw(0.1, 0.3), draw(0.05, 0.2), mass=draw(0.5, 5.0)), position=(draw(-0.1, 0.1), 0.2 + 0.3 * k)
        )
    scene.contact_all(friction=0.6)
    return scene


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_least_forces_move_the_bodies_just_the_same(seed: int) -> None:
    """A heap of boxes: equal bits of motion, forces in their cones, and no larger than those of the solver."""
    result = lf.simulate(heap(seed), 1.0, lf.MoreauJean(step=1e-3))
    normal, tangential = result.contact_points.force.T
    assert (np.abs(tangential) <= 0.6 * normal * (1.0 + 1e-6) + 1e-9).all()
    assert normal.min() >= 0.0
    # equal bits whether instants are stored (and forces replaced) at all steps or at a few
    other = lf.simulate(heap(seed), 1.0, lf.MoreauJean(step=1e-3), record=0.1)
    assert np.array_equal(other.q[-1], result.q[-1])
    assert np.array_equal(other.u[-1], result.u[-1])
