"""Flexible strips on a rough floor, lifted, pulled and peeled: many contacts whose friction hardly does anything."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from tests.scenes import floor_of

E, RHO, G = 2.1e11, 7850.0, 9.81
LENGTH, WIDTH = 1.0, 0.02
FEW = 20  # steps of a path: it moves for one or two, and is at rest; without end it made hundreds


def load_by_length(thickness: float) -> float:
    """Weight [N/m]."""
    return RHO * WIDTH * thickness * G


def strip(
    friction: float,
    thickness: float = 1e-3,
    modes: int = 8,
    elements: int = 40,
    unit: float = 1.0,
    mass: float = 1.0,
) -> lf.Scene:
    """Steel, 1 m long, flat on the floor; with ``unit`` lengths in a metre and ``mass`` masses in a kilogram."""
    scene = lf.Scene(gravity=(0.0, -G * unit))
    beam = lf.Beam(
        LENGTH * unit, WIDTH * unit, thickness * unit, RHO * mass / unit**3, E * mass / unit, elements=elements
    )
    body = scene.add(beam, "strip", position=(0.0, 0.5 * thickness * unit), modes=modes)
    scene.contact(body.surface("bottom"), floor_of(scene), friction=friction, name="floor")
    return scene


def lift(scene: lf.Scene, where: str, height: float, start: float) -> None:
    """A drive that takes a point from ``start`` up by ``height`` in a second."""
    way = lf.Table([0.0, 1.0], [start, start + height])
    point = scene.body("strip").point(where)
    scene.join(lf.DrivenDisplacement(point, scene.ground.at(0.0, 0.0), way, (0.0, 1.0), name=f"lift {where}"))


def check_forces(rest: lf.Rest, friction: float, weight: float, lifted: float, pulled: float = 0.0) -> None:
    """Weight, pull and friction are in balance, and each contact force is in its cone."""
    (floor,) = rest.contacts
    assert floor.normal.sum() + lifted == pytest.approx(weight, rel=1e-9)
    assert floor.tangential.sum() == pytest.approx(-pulled, abs=1e-9 * weight)
    assert (floor.normal >= -1e-9 * weight).all()
    assert (np.abs(floor.tangential) <= friction * floor.normal + 1e-9 * weight).all()
    assert rest.residual < 1e-9
    assert rest.steps < FEW
    assert rest.stable


@pytest.mark.parametrize("unit", [1.0, 1000.0], ids=["m, kg", "mm, t"])
@pytest.mark.parametrize(
    ("friction", "thickness", "modes", "height"),
    [
        (0.0, 1e-3, 20, 0.02),
        (0.3, 1e-3, 8, 0.02),
        (2.0, 2e-3, 8, 0.01),
        *(
            pytest.param(*one, marks=pytest.mark.slow)
            for one in (
                (0.1, 1e-3, 8, 0.02),
                (0.3, 1e-3, 20, 0.02),
                (2.0, 1e-3, 20, 0.02),
                (1.0, 2e-3, 8, 0.01),
                (0.5, 5e-4, 20, 0.005),
            )
        ),
    ],
)
@pytest.mark.filterwarnings("ignore:youngs_modulus")  # whose numbers look like N, mm and t, as they are
def test_one_end_lifted(friction: float, thickness: float, modes: int, height: float, unit: float) -> None:
    """The free length l of a heavy beam lifted by d at its end: d = w l^4 / (24 E I), and the end carries w l / 2."""
    mass = 1.0 if unit == 1.0 else 1e-3
    scene = strip(friction, thickness, modes, 40, unit, mass)
    lift(scene, "right", height * unit, 0.5 * thickness * unit)
    rest = lf.equilibrium(scene, time=1.0)
    w, EI = load_by_length(thickness), E * WIDTH * thickness**3 / 12.0
    free = (24.0 * EI * height / w) ** 0.25
    force = float(rest.joint("lift right").force[1])  # of 1 kg m/s^2 and of 1 t mm/s^2 alike
    assert force == pytest.approx(0.5 * w * free, rel=0.03)
    check_forces(rest, friction, w * LENGTH, force)


@pytest.mark.parametrize("friction", [0.1, 2.0, *(pytest.param(mu, marks=pytest.mark.slow) for mu in (0.3, 1.0))])
@pytest.mark.parametrize("thickness", [5e-4, 1e-3, pytest.param(3e-3, marks=pytest.mark.slow)])
def test_the_middle_pulled_up(friction: float, thickness: float) -> None:
    """By a force, less than the weight."""
    scene = strip(friction, thickness)
    weight = load_by_length(thickness) * LENGTH
    scene.load(lf.Force(scene.body("strip").point("center"), (0.0, 0.3 * weight)))
    check_forces(lf.equilibrium(scene), friction, weight, 0.3 * weight)


@pytest.mark.parametrize("friction", [0.1, 0.5, 2.0])
def test_lifted_and_pulled_along(friction: float) -> None:
    """By half of what friction holds: the pull is there, with its sign."""
    scene = strip(friction)
    weight = load_by_length(1e-3) * LENGTH
    pull = 0.5 * friction * 0.7 * weight
    scene.load(lf.Force(scene.body("strip").point("right"), (pull, 0.3 * weight)))
    check_forces(lf.equilibrium(scene), friction, weight, 0.3 * weight, pull)


def test_pressed_down_without_gravity() -> None:
    """Nothing weighs anything: by a force in the middle, with an end lifted against it."""
    scene = lf.Scene(gravity=(0.0, 0.0))
    body = scene.add(lf.Beam(1.0, WIDTH, 1e-3, RHO, E), "strip", position=(0.0, 5e-4), modes=8)
    scene.contact(body.surface("bottom"), floor_of(scene), friction=0.4, name="floor")
    scene.load(lf.Force(body.point("center"), (0.0, -2.0)))
    scene.load(lf.Force(body.point("right"), (0.0, 0.3)))
    check_forces(lf.equilibrium(scene), 0.4, 2.0, 0.3)


def peeled(friction: float) -> list[Any]:
    """Peeled slowly from one end, rest by rest."""
    scene = strip(friction)
    lift(scene, "right", 0.02, 5e-4)
    rests: list[lf.Rest] = []
    for time in (0.25, 0.5, 0.75, 1.0):
        rests.append(lf.equilibrium(scene, time=time, initial=rests[-1] if rests else None))
    return rests


@pytest.mark.parametrize("friction", [0.3, *(pytest.param(mu, marks=pytest.mark.slow) for mu in (0.1, 1.0))])
def test_peeled_slowly(friction: float) -> None:
    """The force grows with the fourth root of the height, at each of the places."""
    w, EI = load_by_length(1e-3), E * WIDTH * 1e-9 / 12.0
    for share, rest in zip((0.25, 0.5, 0.75, 1.0), peeled(friction), strict=True):
        force = float(rest.joint("lift right").force[1])
        assert force == pytest.approx(0.5 * w * (24.0 * EI * 0.02 * share / w) ** 0.25, rel=0.05)
        check_forces(rest, friction, w * LENGTH, force)


@pytest.mark.parametrize("friction", [0.3, *(pytest.param(mu, marks=pytest.mark.slow) for mu in (0.1, 1.0))])
def test_two_strips(friction: float) -> None:
    """One upon the other, of few elements; the upper one's end is lifted."""
    scene = strip(friction, modes=6, elements=12)
    beam = lf.Beam(LENGTH, WIDTH, 1e-3, RHO, E, elements=12)
    upper = scene.add(beam, "upper", position=(0.0, 1.5e-3), modes=6)
    scene.contact(upper.surface("bottom"), scene.body("strip").surface("top"), friction=friction, name="between")
    way = lf.Table([0.0, 1.0], [1.5e-3, 1.15e-2])
    scene.join(lf.DrivenDisplacement(upper.point("right"), scene.ground.at(0.0, 0.0), way, (0.0, 1.0), name="lift"))
    rest = lf.equilibrium(scene, time=1.0)
    weight = load_by_length(1e-3) * LENGTH
    force = float(rest.joint("lift").force[1])
    floor, between = rest.contacts
    assert floor.normal.sum() == pytest.approx(2.0 * weight - force, rel=1e-9)
    n = between.direction
    up = np.abs(n[:, 1]) * between.normal - np.sign(n[:, 1]) * n[:, 0] * between.tangential  # the strips are bent
    assert up.sum() == pytest.approx(weight - force, rel=1e-9)
    assert rest.steps < FEW
