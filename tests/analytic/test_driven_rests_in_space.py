"""Places of rest in space of flexible, clamped and driven bodies against closed forms."""

from __future__ import annotations

import math
import warnings

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import lcpflex as lf

G = 9.81
EXACT = 1e-8
DOWN = (0.0, 0.0, -G)
UP = (0.0, 0.0, 1.0)


def beam() -> lf.SpatialBeam:
    """1 m of steel, 20 x 10 mm, without shear."""
    side, height = 0.02, 0.01
    inertia = (side * height**3 / 12.0, height * side**3 / 12.0)
    torsion = 0.9 * inertia[0]
    return lf.SpatialBeam(1.0, side * height, inertia, torsion, 7850.0, 2.1e11, 0.3, shear_factor=None, elements=10)


def test_cantilever() -> None:
    """Bent in both planes and twisted by loads at its end: P l^3 / 3 E I, M l / G I_t; and what holds its root."""
    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    made = beam()
    placed = scene.add(made, "beam", position=(0.5, 0.0, 0.0), modes=6)
    scene.join(lf.Weld(placed.point("left"), scene.ground.at(0.0, 0.0, 0.0), name="root"))
    tip = placed.point("right")
    force, torque = np.array([0.0, 2e-4, -1e-4]), 1e-4
    scene.load(lf.Force(tip, tuple(force)))
    scene.load(lf.Torque(tip, (torque, 0.0, 0.0)))
    rest = lf.equilibrium(scene)
    (in_xz, in_xy), E = made.second_moments, 2.1e11
    moved = rest.point("beam", "right") - [1.0, 0.0, 0.0]
    assert moved[1] == pytest.approx(force[1] / (3.0 * E * in_xy), rel=1e-6)
    assert moved[2] == pytest.approx(force[2] / (3.0 * E * in_xz), rel=1e-6)
    root = rest.joint("root")
    assert root.force == pytest.approx(-force, rel=EXACT, abs=1e-8 * 2e-4)
    assert root.moment == pytest.approx([-torque, force[2], -force[1]], rel=1e-6)
    assert rest.stable
    assert rest.unique
    assert not rest.neutral


def test_clamp() -> None:
    """A screw, a spring of 1e5 N/m that is 1 mm too short, presses a jaw to a block, and that to the other jaw."""
    scene = lf.SpatialScene(gravity=DOWN)
    block = scene.add(lf.Cuboid(0.04, 0.04, 0.02, mass=0.2), "block", position=(0.0, 0.0, 0.01))
    jaw = scene.add(lf.Cuboid(0.06, 0.06, 0.01, mass=0.1), "jaw", position=(0.0, 0.0, 0.025))
    scene.join(lf.Prismatic(jaw.point("center"), scene.ground.at(0.0, 0.0, 0.0), axis=UP, name="slide"))
    scene.contact(block.surface(), scene.ground.plane((0.0, 0.0, 0.0), UP), friction=0.2, name="lower")
    scene.contact(jaw.surface(), block.surface(), friction=0.2, name="upper")
    scene.load(lf.Spring(jaw.point("center"), scene.ground.at(0.0, 0.0, -0.1), stiffness=1e5, length=0.124))
    scene.load(lf.Force(block.point("center"), (25.0, 0.0, 0.0)))
    rest = lf.equilibrium(scene)
    upper, lower = rest.contact("upper"), rest.contact("lower")
    assert upper.normal.sum() == pytest.approx(100.0 + 0.1 * G, rel=EXACT)
    assert lower.normal.sum() == pytest.approx(100.0 + 0.3 * G, rel=EXACT)
    assert upper.on("block")[0] + lower.on("block")[0] == pytest.approx(-25.0, rel=EXACT)
    assert upper.state == lower.state == "stick"
    assert rest.stable


def test_a_block_is_pulled_about_a_floor() -> None:
    """By a spring of 500 N/m behind a slider that goes round corners: the block follows it once the spring pulls with
    mu W, towards where the slider is, as far as that is the limit again: implicit Euler of Coulomb's law."""
    places = np.array([(0, 0), (12, 0), (30, 0), (30, 20), (20, 50), (20, 49), (-30, 20)]) * 1e-3
    times = np.arange(float(len(places)))
    scene = lf.SpatialScene(gravity=DOWN)
    block = scene.add(lf.Cuboid(0.4, 0.4, 0.2, mass=2.0), "block", position=(0.0, 0.0, 0.1))
    slider = scene.add(lf.Cuboid(0.1, 0.1, 0.1, mass=1.0), "slider", position=(0.0, 0.0, 0.1))
    place, hand = scene.ground.at(0.0, 0.0, 0.1), slider.point("center")
    scene.join(lf.Planar(hand, place, axis=UP, name="table"))
    scene.load(lf.TorsionSpring(hand, place, stiffness=1.0, axis=UP))
    for name, axis, values in (("x", (1.0, 0.0, 0.0), places[:, 0]), ("y", (0.0, 1.0, 0.0), places[:, 1])):
        scene.join(lf.DrivenDisplacement(hand, place, lf.Table(times, values), axis, name=name))
    scene.load(lf.Bushing(hand, block.point("center"), stiffness=(500.0, 500.0, 0.0)))
    scene.contact(block.surface(), scene.ground.plane((0.0, 0.0, 0.0), UP), friction=0.4, name="floor")
    limit, at, rest = 0.4 * 2.0 * G, np.zeros(2), None
    for time, goal in zip(times, places, strict=True):
        away = goal - at
        pull = 500.0 * float(np.hypot(*away))
        at = goal - away * min(1.0, limit / pull) if pull > 0.0 else at
        rest = lf.equilibrium(scene, initial=rest, time=float(time))
        assert rest.q[:2] == pytest.approx(at, abs=1e-9)
        assert rest.contact("floor").on("block")[:2] == pytest.approx(-500.0 * (goal - at), abs=EXACT * 2.0 * G)
        assert rest.contact("floor").state == ("slip" if pull > limit else "stick")


def test_what_slides_stays_at_its_limit_when_a_drive_stands_or_turns() -> None:
    """A block behind a spring of 500 N/m from a hand that goes forth and back, beyond its limit: as a play does."""
    scene = lf.SpatialScene(gravity=DOWN)
    block = scene.add(lf.Cuboid(0.4, 0.4, 0.2, mass=2.0), "block", position=(0.0, 0.0, 0.1))
    hand = scene.add(lf.Sphere(0.1, mass=1.0), "hand", position=(1.0, 0.0, 0.1)).point("center")
    place, axis = scene.ground.at(1.0, 0.0, 0.1), (1.0, 0.0, 0.0)
    scene.contact(block.surface(), scene.ground.plane((0.0, 0.0, 0.0), UP), friction=0.4, name="floor")
    scene.join(lf.Prismatic(hand, place, axis=axis, name="rail"))
    scene.join(lf.DrivenDisplacement(hand, place, 0.0, axis, name="pull"))
    scene.load(lf.Spring(block.point("center"), hand, stiffness=500.0, length=1.0))
    values = [0.03, 0.03, 0.03, 0.03, 0.04, 0.03, 0.04, 0.03, 0.04]
    limit = 0.4 * 2.0 * G
    back = limit - 500.0 * 0.01
    exact = [limit, limit, limit, limit, limit, back, limit, back, limit]
    assert lf.path(scene, "pull", values).force == pytest.approx(exact, abs=EXACT * 2.0 * G)


@pytest.mark.parametrize(("share", "buckles"), [(0.05, False), (0.5, False), (1.1, True)])
def test_a_column_that_buckles_is_unstable(share: float, buckles: bool) -> None:
    """Pressed by a share of pi^2 E I / 4 l^2, which its bending does not feel."""
    made = beam()
    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    placed = scene.add(made, "column", position=(0.5, 0.0, 0.0), modes=8)
    scene.join(lf.Weld(placed.point("left"), scene.ground.at(0.0, 0.0, 0.0), name="root"))
    critical = math.pi**2 * 2.1e11 * made.second_moments[0] / 4.0
    scene.load(lf.Force(placed.point("right"), (-share * critical, 0.0, 0.0)))
    rest = lf.equilibrium(scene)
    assert rest.stable is not buckles
    assert any("the load at which it buckles" in text for text in rest.unstable) is buckles
    assert any("the load at which it buckles" in text for text in rest.warnings) is (share == 0.5)


@pytest.mark.parametrize(("size", "mass"), [(1.0, 1.0), (1e3, 1e-3), (1e-3, 1e3), (1e3, 1e6)])
def test_a_beam_on_two_supports(size: float, mass: float) -> None:
    """Half the weight at each, 5 q l^4 / 384 E I in the middle, in several units of length and mass."""
    scene = lf.SpatialScene(gravity=(0.0, 0.0, -G * size))
    inertia = 0.02**4 / 12.0 * size**4
    material = (1000.0 * mass / size**3, 2e11 * mass / size, 0.3)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", lf.ModelWarning)  # of units
        made = lf.SpatialBeam(
            size, 4e-4 * size**2, (inertia, inertia), 1.6 * inertia, *material, shear_factor=None, elements=10
        )
        beam = scene.add(made, "beam", position=(0.0, 0.0, 0.02 * size), modes=6)
    floor = scene.ground.plane((0.0, 0.0, 0.0), UP)
    for side, x in (("left", -0.5), ("right", 0.5)):
        foot = beam.sphere((x * size, 0.0, 0.0), 0.01 * size)
        scene.contact(foot, floor, name=side)
        for y in (-1.0, 1.0):  # walls beside it, lest it roll
            scene.contact(foot, scene.ground.plane((0.0, -0.0101 * y * size, 0.0), (0.0, y, 0.0)), name=f"{side} {y}")
    rest = lf.equilibrium(scene)
    load = 1000.0 * 4e-4 * G
    sag = rest.point("beam", "left")[2] - rest.point("beam", "center")[2]
    assert sag / size == pytest.approx(5.0 * load / (384.0 * 2e11 * 0.02**4 / 12.0), rel=EXACT)
    for side in ("left", "right"):
        assert rest.contact(side).normal == pytest.approx([0.5 * load * mass * size], rel=EXACT)
    assert rest.stable


def linkage(size: float) -> lf.SpatialScene:
    """Three rods that hang from two pins: a ball between the first two, a Cardan joint between the last."""
    scene = lf.SpatialScene(gravity=(0.0, 0.0, -G * size))
    corners = size * np.array([(0.0, 0.0, 0.0), (0.2, 0.05, -0.3), (0.7, -0.05, -0.35), (0.8, 0.0, 0.0)])
    left, right = [], []
    for k, mass in enumerate((1.0, 2.0, 1.5)):
        along = corners[k + 1] - corners[k]
        length = float(np.linalg.norm(along))
        turned = Rotation.align_vectors([along], [[1.0, 0.0, 0.0]])[0]
        middle = tuple(0.5 * (corners[k] + corners[k + 1]))
        rod = lf.Cuboid(length, 0.02 * size, 0.03 * size, mass=mass)
        placed = scene.add(rod, f"rod {k}", position=middle, orientation=turned)
        left.append(placed.at(-0.5 * length, 0.0, 0.0))
        right.append(placed.at(0.5 * length, 0.0, 0.0))
    scene.join(lf.Revolute(left[0], scene.ground.at(*corners[0]), axis=(0.0, 1.0, 0.0), name="first"))
    scene.join(lf.Ball(right[0], left[1], name="ball"))
    scene.join(lf.Universal(right[1], left[2], axis=(0.0, 1.0, 0.0), axis_p=(0.0, 0.0, 1.0), name="cross"))
    scene.join(lf.Revolute(right[2], scene.ground.at(*corners[3]), axis=(0.0, 1.0, 0.0), name="last"))
    return scene


@pytest.mark.parametrize("size", [1e-6, 1.0, 1e6])
def test_a_linkage_hangs_alike_in_all_units(size: float) -> None:
    """Rows of joints that are angles are no lengths: how far one is off is not of the size of the scene."""
    rest = lf.equilibrium(linkage(size))
    weights = np.array([1.0, 2.0, 1.5]) * G * size
    first, ball, cross, last = (rest.joint(name).force for name in ("first", "ball", "cross", "last"))
    carried = np.array([first + ball, cross - ball, last - cross])
    assert carried[:, 2] == pytest.approx(weights, rel=EXACT)
    assert carried[:, :2] == pytest.approx(np.zeros((3, 2)), abs=EXACT * weights.max())
    known = lf.equilibrium(linkage(1.0))
    places = np.reshape(rest.q, (3, 7))[:, :3] / size
    assert places == pytest.approx(np.reshape(known.q, (3, 7))[:, :3], abs=1e-8)
    assert rest.stable
