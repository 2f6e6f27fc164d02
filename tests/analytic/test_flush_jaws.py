"""A cube between flush jaws on guides: which corners carry is nobody's law, and the cube stays where friction holds it.

Guides take any moment, so that both jaws may press at one and the same corner, about which a cube would then turn
under a load that all corners hold together.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import lcpflex as lf
from lcpflex.jit.kernel import FloatArray

STEPPERS = {
    "moreau-jean": lf.MoreauJean(step=1e-3),
    "generalised-alpha": lf.GeneralizedAlpha(step=1e-3),
    "event-driven": lf.EventDriven(),
}
every_stepper = pytest.mark.parametrize("name", STEPPERS)
N, MU = 20.0, 0.5  # of a jaw [N], and friction: two jaws hold 2 MU N = 20 N
TURNED = Rotation.from_rotvec((0.3, -1.1, 0.7))
LEAST = 1e-11  # [sizes of the cube] of drift: rounding, and what is left of the first step


def held(
    load: FloatArray | tuple[float, float, float],
    *,
    at: Any = (0.0, 0.0, 0.0),
    size: float = 0.1,
    mass: float = 1.0,
    jaws: int = 2,
    aside: float = 0.0,
    spring: float = 0.0,
    velocity: Any = (0.0, 0.0, 0.0),
    gravity: Any = (0.0, 0.0, 0.0),
    turn: Rotation | None = None,
    unit: float = 1.0,
    flat: bool = True,
) -> lf.SpatialScene:
    """The cube under a load ``at`` a place, jaws along x (four: y too), ``aside`` of its middle [sizes of the cube].

    unit: of length, 1e3 of millimetres; flat: jaws are plates and no cylinders.
    """
    turn = Rotation.identity() if turn is None else turn
    force, edge = unit, size * unit
    scene = lf.SpatialScene(gravity=tuple(unit * turn.apply(gravity)))
    cube = scene.add(
        lf.Cuboid(edge, edge, edge, mass=mass),
        name="cube",
        orientation=turn,
        velocity=tuple(unit * turn.apply(velocity)),
    )
    for k in range(jaws):
        along = np.eye(3)[k // 2] * (-1.0, 1.0)[k % 2]
        place = turn.apply(0.6 * edge * along + aside * edge * np.roll(np.abs(along), 1))
        if flat:
            body: Any = lf.Cuboid(*(edge * (0.5 - 0.3 * np.abs(along))), mass=0.1)
            facing = turn
        else:
            body, facing = lf.Cylinder(0.3 * edge, 0.2 * edge, mass=0.1), turn * Rotation.from_euler("y", 0.5 * np.pi)
        jaw = scene.add(body, name=f"jaw{k}", position=tuple(place), orientation=facing)
        axis, tied = turn.apply(along), scene.ground.at(*place)
        scene.join(lf.Prismatic(jaw.point("center"), tied, axis=tuple(axis)))
        if spring:
            behind = scene.ground.at(*(place + edge * axis))
            scene.load(lf.Spring(jaw.point("center"), behind, stiffness=spring, length=edge + force * N / spring))
        else:
            scene.load(lf.Force(jaw.point("center"), tuple(-force * N * axis)))
        scene.contact(jaw.surface(), cube.surface(), friction=MU, name=f"jaw{k}")
    scene.load(lf.Force(cube.at(*(edge * np.asarray(at))), tuple(force * turn.apply(load))))
    return scene


def moved(scene: lf.SpatialScene, name: str, duration: float = 0.03) -> tuple[FloatArray, FloatArray, lf.Result]:
    """How far the cube gets, its turn as a vector, and the run."""
    result = lf.simulate(scene, duration, STEPPERS[name], progress=False)
    turn = result.orientation("cube")
    place = result.point("cube", "center")
    return place[-1] - place[0], (turn[-1] * turn[0].inv()).as_rotvec(), result


HELD = {
    "across": {"load": (0.0, 5.0, 0.0)},
    "nearly all": {"load": (0.0, 19.5, 0.0)},
    "out of centre": {"load": (0.0, 5.0, 0.0), "at": (0.0, 0.0, 0.4)},
    "on an arm": {"load": (0.0, 0.0, 8.0), "at": (0.0, 0.5, 0.0)},
    "weight": {"load": (0.0, 0.0, 0.0), "gravity": (0.0, 0.0, -9.81)},
    "turned": {"load": (0.0, 5.0, 3.0), "turn": TURNED},
    "jaws aside": {"load": (0.0, 5.0, 0.0), "aside": 0.4},
    "springs": {"load": (0.0, 5.0, 0.0), "spring": 1e4},
    "four jaws": {"load": (0.0, 0.0, 25.0), "jaws": 4},
    "millimetres": {"load": (0.0, 5.0, 0.0), "unit": 1e3},
    "heavy": {"load": (0.0, 5.0, 0.0), "mass": 100.0},
    "32 contacts": {"load": (0.0, 5.0, 0.0), "flat": False},
}


@pytest.mark.parametrize("case", HELD)
@pytest.mark.parametrize("name", ["moreau-jean", "generalised-alpha"])
def test_what_friction_holds_stays(name: str, case: str) -> None:
    way, turn, result = moved(held(**HELD[case]), name)
    assert np.abs(way).max() < LEAST * 0.1 * HELD[case].get("unit", 1.0)
    assert np.abs(turn).max() < LEAST
    assert not result.found_wrong
    assert not result.notes


@every_stepper
def test_a_box_does_not_tilt_about_a_corner_of_each_jaw(name: str) -> None:
    """Narrow jaws at different places, and a load out of the middle: one corner of each, and the others would open."""
    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    box = scene.add(lf.Cuboid(0.083, 0.085, 0.124, mass=1.56), name="cube")
    for k, (sides, y, z) in enumerate((((0.022, 0.016, 0.078), 0.0, 0.036), ((0.022, 0.012, 0.032), 0.004, -0.024))):
        x = (-0.0525, 0.0525)[k]
        jaw = scene.add(lf.Cuboid(*sides, mass=0.2), name=f"jaw{k}", position=(x, y, z))
        scene.join(lf.Prismatic(jaw.point("center"), scene.ground.at(x, y, z), axis=(1.0, 0.0, 0.0)))
        scene.load(lf.Force(jaw.point("center"), (-math.copysign(26.0, x), 0.0, 0.0)))
        scene.contact(jaw.surface(), box.surface(), friction=0.44)
    scene.load(lf.Force(box.at(0.0047, -0.0116, 0.0204), (0.0, 7.2, 5.86)))
    way, turn, _ = moved(scene, name)
    assert np.abs(way).max() < 0.1 * LEAST
    assert np.abs(turn).max() < LEAST


@every_stepper
@pytest.mark.parametrize("flat", [True, False])
def test_what_friction_cannot_hold_slides_without_turning(name: str, flat: bool) -> None:
    """22 N on 20 N of friction, whichever corners carry."""
    way, turn, _ = moved(held((0.0, 22.0, 0.0), flat=flat), name)
    assert way == pytest.approx([0.0, 0.5 * 2.0 * 0.03**2, 0.0], rel=1e-6, abs=1e-8)
    assert np.abs(turn).max() < 1e-6


@every_stepper
def test_a_moment_turns_the_cube_about_the_jaws(name: str) -> None:
    """A couple of .8 N m on 2 MU N r = .7071 N m of all corners, r = .025 sqrt(2): (.8 - .7071) / (m s^2 / 6)."""
    scene = held((0.0, 0.0, 0.0))
    scene.load(lf.Torque(scene.body("cube").point("center"), (0.8, 0.0, 0.0)))
    way, turn, _ = moved(scene, name)
    rate = (0.8 - 2.0 * MU * N * 0.025 * 2.0**0.5) / (0.1**2 / 6.0)
    assert turn == pytest.approx([0.5 * rate * 0.03**2, 0.0, 0.0], rel=1e-4, abs=1e-6)
    assert np.abs(way).max() < 1e-7


@every_stepper
def test_a_load_that_grows_moves_the_cube_when_friction_is_used_up(name: str) -> None:
    """400 t N: from t = .05 s on vdot = 400 (t - .05), which makes 400 .01^3 / 6 by t = .06; a step of 1 ms at most."""
    scene = held((0.0, 0.0, 0.0))
    scene.load(lf.Force(scene.body("cube").point("center"), (0.0, lf.Table([0.0, 0.1], [0.0, 40.0]), 0.0)))
    way, turn, _ = moved(scene, name, 0.06)
    assert 400.0 * 0.009**3 / 6.0 < way[1] < 400.0 * 0.0115**3 / 6.0
    assert np.abs(turn).max() < 1e-6


@pytest.mark.parametrize("name", ["moreau-jean", "event-driven"])
def test_a_cube_that_slides_stops_and_stays(name: str) -> None:
    """.3 m/s under 5 N against 20 N: v^2 / (2 15) = 3 mm, then rest."""
    scene = held((0.0, 5.0, 0.0), velocity=(0.0, 0.3, 0.0))
    result = lf.simulate(scene, 0.04, STEPPERS[name], progress=False)
    place = result.point("cube", "center")
    assert place[-1] == pytest.approx([0.0, 3e-3, 0.0], abs=1e-5)
    assert np.abs(place[-1] - place[np.searchsorted(result.times, 0.03)]).max() < 1e-10


@every_stepper
def test_a_box_slides_off_a_cube_that_is_held(name: str) -> None:
    """Its friction on the cube is what the jaws hold beside the weights, and no reason to let go."""
    scene = held((0.0, 0.0, 0.0), gravity=(0.0, 0.0, -9.81))
    box = scene.add(lf.Cuboid(0.05, 0.05, 0.05, mass=0.5), name="box", position=(0.0, 0.0, 0.075))
    scene.contact(box.surface(), scene.body("cube").surface(), friction=MU, name="top")
    scene.load(lf.Force(box.point("center"), (0.0, 4.0, 0.0)))
    way, turn, result = moved(scene, name)
    assert np.abs(way).max() < 1e-10
    assert np.abs(turn).max() < 1e-9
    slid = result.point("box", "center")[-1] - (0.0, 0.0, 0.075)
    assert slid == pytest.approx([0.0, 0.5 * (8.0 - MU * 9.81) * 0.03**2, 0.0], rel=1e-2, abs=1e-9)


@every_stepper
@pytest.mark.parametrize("jointed", [False, True])
def test_walls_do_not_clamp_by_themselves(name: str, jointed: bool) -> None:
    """A cube that fits between two walls and leans on one falls: friction is mu of what presses, not of what could."""
    scene = lf.SpatialScene(gravity=(1.0, 0.0, -9.81))
    cube = scene.add(lf.Cuboid(0.1, 0.1, 0.1, mass=1.0), name="cube")
    if jointed:
        scene.join(lf.Planar(cube.point("center"), scene.ground.at(0.0, 0.0, 0.0), axis=(0.0, 1.0, 0.0)))
    for x in (-0.05, 0.05):
        scene.contact(cube.surface(), scene.ground.plane((x, 0.0, 0.0), (-x, 0.0, 0.0)), friction=MU)
    way, _, result = moved(scene, name)
    assert way == pytest.approx([0.0, 0.0, -0.5 * (9.81 - MU) * 0.03**2], rel=4e-2, abs=1e-9)
    assert not result.found_wrong
