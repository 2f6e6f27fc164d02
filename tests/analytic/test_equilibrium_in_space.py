"""Places of rest in space against closed forms, and runs that begin there."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import lcpflex as lf

G = 9.81
EXACT = 1e-8
DOWN = (0.0, 0.0, -G)
UP = (0.0, 0.0, 1.0)


def tripod(slope: float, friction: float, size: float = 1.0, mass: float = 2.0, g: float = G) -> lf.SpatialScene:
    """Three feet on a circle of 0.2 m about the axis of a body, its mass centre 0.3 m above a slope that falls to x."""
    normal = np.array([math.sin(slope), 0.0, math.cos(slope)])
    scene = lf.SpatialScene(gravity=(0.0, 0.0, -g))
    inertia = mass * 0.01 * size**2
    body = lf.SpatialRigidBody(mass, (inertia, inertia, 1.5 * inertia))
    turned = Rotation.from_rotvec([0.0, slope, 0.0])
    placed = scene.add(body, "tripod", position=tuple(0.3 * size * normal), orientation=turned)
    floor = scene.ground.plane((0.0, 0.0, 0.0), tuple(normal))
    for k in range(3):
        angle = 0.3 + 2.0 * math.pi * k / 3.0
        center = size * np.array([0.2 * math.cos(angle), 0.2 * math.sin(angle), -0.28])
        scene.contact(placed.sphere(tuple(center), 0.02 * size), floor, friction=friction, name=f"foot {k}")
    return scene


def pressures(slope: float) -> np.ndarray[Any, Any]:
    """Of the feet, of the weight: equal parts, and a moment W h sin(slope) about y, 3 r^2 / 2 being the sum of x^2."""
    angle = 0.3 + 2.0 * math.pi * np.arange(3) / 3.0
    return math.cos(slope) / 3.0 + 0.3 * math.sin(slope) * 0.2 * np.cos(angle) / (1.5 * 0.2**2)


@pytest.mark.parametrize("slope", [0.0, 0.15, 0.38])
def test_tripod_on_a_slope(slope: float) -> None:
    """Normal forces are determined, friction is in sum: W sin(slope), up the slope; beyond atan(0.4) it slides."""
    rest = lf.equilibrium(tripod(slope, 0.4))
    weight = 2.0 * G
    normal = np.array([contact.normal[0] for contact in rest.contacts])
    friction = np.array([contact.tangential[0] for contact in rest.contacts])
    assert normal == pytest.approx(weight * pressures(slope), rel=EXACT)
    uphill = -math.sin(slope) * np.array([math.cos(slope), 0.0, -math.sin(slope)])
    assert friction.sum(axis=0) == pytest.approx(weight * uphill, abs=EXACT * weight)
    assert (np.linalg.norm(friction, axis=1) <= 0.4 * normal * (1.0 + EXACT)).all()
    assert sum(contact.on("tripod") for contact in rest.contacts) == pytest.approx([0, 0, weight], abs=EXACT * weight)
    assert rest.stable
    assert not rest.unique
    assert rest.neighbours == 3


def test_tripod_beyond_its_limit() -> None:
    with pytest.raises(lf.SolverError, match=r"does not come to rest .*: 'tripod' moves along \(0.92, 0, -0.39\), and"):
        lf.equilibrium(tripod(0.4, 0.4))


@pytest.mark.parametrize("size", [1e-6, 1e-3, 1e6])
@pytest.mark.parametrize("mass", [1e-6, 1.0, 1e6])
def test_units_do_not_matter(size: float, mass: float) -> None:
    """The same tripod with lengths, masses and times in other units."""
    scale = 2.0 * mass * G * size
    rest = lf.equilibrium(tripod(0.15, 0.4, size, 2.0 * mass, G * size))
    assert [contact.normal[0] / scale for contact in rest.contacts] == pytest.approx(pressures(0.15), rel=EXACT)
    assert rest.stable
    assert rest.neighbours == 3


def test_least_friction_of_a_tripod() -> None:
    """On the level no friction is asked for; of all that is possible the least is none."""
    for contact in lf.equilibrium(tripod(0.0, 0.4)).contacts:
        assert contact.state == "stick"
        assert np.abs(contact.tangential).max() <= EXACT * contact.normal[0]


def ladder(angle: float, friction: float) -> lf.SpatialScene:
    """3 m, two feet on a rough floor, two ends at a smooth wall, which a sphere of 0.02 m is at all four."""
    scene = lf.SpatialScene(gravity=DOWN)
    cos, sin = math.cos(angle), math.sin(angle)
    body = lf.SpatialRigidBody(10.0, (0.2, 7.5, 7.6))
    turned = Rotation.from_rotvec([0.0, angle, 0.0])
    placed = scene.add(body, "ladder", position=(-1.5 * cos, 0.0, 1.5 * sin + 0.02), orientation=turned)
    floor = scene.ground.plane((0.0, 0.0, 0.0), UP)
    wall = scene.ground.plane((-3.0 * cos - 0.02, 0.0, 0.0), (1.0, 0.0, 0.0))
    for side, y in (("left", -0.25), ("right", 0.25)):
        top = placed.sphere((-1.5, y, 0.0), 0.02)
        scene.contact(placed.sphere((1.5, y, 0.0), 0.02), floor, friction=friction, name=f"{side} foot")
        scene.contact(top, wall, name=f"{side} end")
        scene.contact(top, floor, friction=friction, name=f"{side} end on the floor")
    return scene


def leaning(angle: float) -> float:
    """Force of the wall over the weight: moments about the feet."""
    return 1.5 * math.cos(angle) / (3.0 * math.sin(angle) + 0.02)


def limit_angle(friction: float) -> float:
    """Where the wall takes as much as the friction of the floor."""
    low, high = 0.1, 1.5
    for _ in range(80):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if leaning(middle) > friction else (low, middle)
    return high


@pytest.mark.parametrize("above", [1e-6, 0.1])
def test_ladder_above_its_limit(above: float) -> None:
    angle = limit_angle(0.3) + above
    rest = lf.equilibrium(ladder(angle, 0.3))
    weight = 10.0 * G
    for side in ("left", "right"):
        end, foot = rest.contact(f"{side} end"), rest.contact(f"{side} foot")
        assert end.normal == pytest.approx([0.5 * weight * leaning(angle)], rel=EXACT)
        assert foot.normal == pytest.approx([0.5 * weight], rel=EXACT)
        assert foot.state == "stick"
        assert rest.contact(f"{side} end on the floor").state == "open"
    along = sum(rest.contact(f"{side} foot").tangential[0, 0] for side in ("left", "right"))
    assert along == pytest.approx(-weight * leaning(angle), rel=EXACT)
    assert rest.stable
    assert rest.travelled < 1e-9


def test_ladder_below_its_limit() -> None:
    """It slides down to the floor."""
    rest = lf.equilibrium(ladder(limit_angle(0.3) - 1e-4, 0.3))
    assert rest.travelled > 1.0
    for side in ("left", "right"):
        assert rest.contact(f"{side} end on the floor").normal == pytest.approx([2.5 * G], rel=EXACT)
        assert rest.contact(f"{side} foot").normal == pytest.approx([2.5 * G], rel=EXACT)


def stack(yaw: float, friction: float, gap: float, masses: tuple[float, ...] = (2.0, 2.0, 2.0)) -> lf.SpatialScene:
    """Equal boxes, each turned by ``yaw`` against the one below, ``gap`` above it."""
    scene = lf.SpatialScene(gravity=DOWN)
    below = scene.ground.plane((0.0, 0.0, 0.0), UP)
    for k, mass in enumerate(masses):
        box = lf.Cuboid(0.4, 0.2, 0.1, mass=mass)
        height = 0.05 + gap + (0.1 + gap) * k
        turned = Rotation.from_rotvec([0.0, 0.0, k * yaw])
        placed = scene.add(box, f"box {k}", position=(0.0, 0.0, height), orientation=turned)
        scene.contact(placed.surface(), below, friction=friction, name=f"below {k}")
        below = placed.surface()
    return scene


@pytest.mark.parametrize("gap", [0.0, 0.01])
@pytest.mark.parametrize("yaw", [0.0, 1e-9, 1e-4, 0.3])
@pytest.mark.parametrize("friction", [0.0, 0.4])
def test_stack(friction: float, yaw: float, gap: float) -> None:
    """Each face bears what is above it, by corners that balance does not tell apart; nothing is shifted."""
    rest = lf.equilibrium(stack(yaw, friction, gap))
    for k, contact in enumerate(rest.contacts):
        weight = 2.0 * G * (3 - k)
        assert contact.normal.sum() == pytest.approx(weight, rel=EXACT)
        assert contact.normal @ contact.place[:, :2] == pytest.approx([0.0, 0.0], abs=EXACT * weight)
        assert np.abs(contact.tangential).max() <= EXACT * weight
        assert contact.state == ("stick" if friction else "slip")
        assert not contact.unique.any()
    places = np.reshape(rest.q, (3, 7))[:, :3]
    assert places == pytest.approx(np.array([[0, 0, 0.05], [0, 0, 0.15], [0, 0, 0.25]]), abs=1e-9)
    assert rest.stable
    assert not rest.unique


@pytest.mark.parametrize("yaw", [0.0, 0.3])
def test_least_forces_of_a_stack(yaw: float) -> None:
    """The corners of a face share evenly, by symmetry."""
    for contact in lf.equilibrium(stack(yaw, 0.4, 0.0)).contacts:
        assert contact.normal == pytest.approx(np.full(len(contact.normal), contact.normal.mean()), rel=EXACT)


@pytest.mark.parametrize("masses", [(1e3, 1.0, 1e-3), (1e-3, 1.0, 1e3)])
def test_stack_of_unlike_masses(masses: tuple[float, ...]) -> None:
    rest = lf.equilibrium(stack(0.0, 0.4, 0.0, masses))
    for k, contact in enumerate(rest.contacts):
        assert contact.normal.sum() == pytest.approx(G * sum(masses[k:]), rel=EXACT)
    assert rest.stable


def test_a_ball_in_a_trough() -> None:
    """Two walls of 45 degrees bear W / sqrt(2) each; along the trough and about itself the ball is free."""
    scene = lf.SpatialScene(gravity=DOWN)
    ball = scene.add(lf.Sphere(0.1, mass=2.0), "ball", position=(0.02, 0.01, 0.3))
    for side, x in (("left", 1.0), ("right", -1.0)):
        scene.contact(ball.surface(), scene.ground.plane((0, 0, 0), (x, 0.0, 1.0)), name=side)
    rest = lf.equilibrium(scene)
    assert rest.q[:3] == pytest.approx([0.0, 0.01, 0.1 * math.sqrt(2.0)], abs=1e-12)
    for name in ("left", "right"):
        assert rest.contact(name).normal == pytest.approx([2.0 * G / math.sqrt(2.0)], rel=EXACT)
    assert rest.stable
    assert rest.unique
    assert len(rest.neutral) == 4
    assert sum("moves along" in words for words in rest.neutral) == 1
    assert any("turns about (0, 0, 1) through (0, 0.01, 0.141) m" in words for words in rest.neutral)


def test_a_hill_is_unstable() -> None:
    """A ball on the top of another one, which a spring does not hold."""
    scene = lf.SpatialScene(gravity=DOWN)
    ball = scene.add(lf.Sphere(0.1, mass=2.0), "ball", position=(0.0, 0.0, 0.3))
    scene.contact(ball.surface(), scene.ground.sphere((0.0, 0.0, 0.0), 0.2), name="hill")
    rest = lf.equilibrium(scene)
    assert not rest.stable
    assert len(rest.unstable) == 2
    assert rest.contact("hill").normal == pytest.approx([2.0 * G], rel=EXACT)


def jaws(friction: float, fingers: int) -> lf.SpatialScene:
    """A box of 1 kg that fingers about it, on slides with springs of 1000 N/m, press with 25 N each."""
    scene = lf.SpatialScene(gravity=DOWN)
    box = scene.add(lf.Cylinder(0.05, 0.1, mass=1.0), "load", position=(0.0, 0.0, 0.0))
    for k in range(fingers):
        angle = 2.0 * math.pi * k / fingers
        out = np.array([math.cos(angle), math.sin(angle), 0.0])
        finger = scene.add(lf.Sphere(0.01, mass=0.1), f"finger {k}", position=tuple(0.06 * out))
        rail = scene.ground.at(*(0.06 * out))
        scene.join(lf.Prismatic(finger.point("center"), rail, axis=tuple(out), name=f"rail {k}"))
        spring = lf.Spring(finger.point("center"), scene.ground.at(*(0.2 * out)), stiffness=1000.0, length=0.165)
        scene.load(spring)
        scene.contact(box.surface(), finger.surface(), friction=friction, name=f"grip {k}")
    return scene


@pytest.mark.parametrize("fingers", [2, 3])
def test_grip(fingers: int) -> None:
    """Springs of 25 N press, friction bears a part of the weight at each; moments tell the rest of it."""
    rest = lf.equilibrium(jaws(0.3, fingers))
    for k in range(fingers):
        contact = rest.contact(f"grip {k}")
        assert contact.normal == pytest.approx([25.0], rel=EXACT)
        assert contact.on("load")[2] == pytest.approx(G / fingers, rel=EXACT)
        assert contact.state == "stick"
        rail = rest.joint(f"rail {k}").force
        assert rail[2] == pytest.approx(0.1 * G + G / fingers, rel=EXACT)
    assert rest.stable
    assert rest.point("load", "center") == pytest.approx([0.0, 0.0, 0.0], abs=1e-10)


def test_grip_that_slips() -> None:
    words = r"does not come to rest .*'load' moves along \(0, 0, -1\).*or a larger farthest$"
    with pytest.raises(lf.SolverError, match=words):
        lf.equilibrium(jaws(0.19, 2), farthest=0.5)


@pytest.mark.parametrize(
    "scene",
    [
        pytest.param(lambda: tripod(0.3, 0.4), id="tripod"),
        pytest.param(lambda: ladder(limit_angle(0.3) + 0.01, 0.3), id="ladder"),
        pytest.param(lambda: stack(0.0, 0.4, 0.0), id="stack"),
        pytest.param(lambda: stack(0.3, 0.4, 0.0), id="turned stack"),
        pytest.param(lambda: jaws(0.3, 3), id="grip"),
    ],
)
def test_a_run_stays_there(scene: Callable[[], lf.SpatialScene]) -> None:
    """5 s of a run that begins at rest: bodies stay where they are to 1e-9 of the size of the scene."""
    made = scene()
    rest = lf.equilibrium(made)
    result = lf.simulate(made, 5.0, lf.MoreauJean(step=2e-3), initial=rest)
    assert result.complete
    assert np.abs(result.q - rest.q).max() < 1e-9


def test_an_event_driven_run_stays_there() -> None:
    for made in (tripod(0.3, 0.4), stack(0.0, 0.4, 0.0), jaws(0.3, 3)):
        rest = lf.equilibrium(made)
        result = lf.simulate(made, 1.0, lf.EventDriven(), initial=rest)
        assert result.complete
        assert np.abs(result.q - rest.q).max() < 1e-9


def test_order_of_bodies_and_of_contacts_does_not_matter() -> None:
    """A heap of four balls, declared both ways."""
    heights = []
    for order in ((0, 1, 2, 3), (3, 1, 0, 2)):
        scene = lf.SpatialScene(gravity=DOWN)
        places = [(0.0, 0.0, 0.05), (0.102, 0.0, 0.05), (0.051, 0.09, 0.05), (0.051, 0.03, 0.14)]
        balls = {k: scene.add(lf.Sphere(0.05, mass=1.0), f"ball {k}", position=places[k]) for k in order}
        floor = scene.ground.plane((0.0, 0.0, 0.0), UP)
        for k in order[:: 1 if order[0] else -1]:
            scene.contact(balls[k].surface(), floor, friction=0.5, name=f"floor {k}")
        scene.contact_all(friction=0.5)
        rest = lf.equilibrium(scene)
        heights.append(rest.point("ball 3", "center"))
        assert sum(rest.contact(f"floor {k}").normal.sum() for k in order) == pytest.approx(4.0 * G, rel=EXACT)
        assert rest.stable
    assert heights[0] == pytest.approx(heights[1], abs=1e-7)


@pytest.mark.parametrize("beyond", [-1e-6, 1e-4])
def test_a_tall_box_tips_where_its_weight_passes_its_edge(beyond: float) -> None:
    """0.2 x 0.2 x 0.6 m on a slope: at tan = 1/3 all is on the lower edge; beyond it lies down on its side."""
    slope = math.atan(1.0 / 3.0) + beyond
    normal = np.array([math.sin(slope), 0.0, math.cos(slope)])
    scene = lf.SpatialScene(gravity=DOWN)
    turned = Rotation.from_rotvec([0.0, slope, 0.0])
    box = scene.add(lf.Cuboid(0.2, 0.2, 0.6, mass=2.0), "box", position=tuple(0.3 * normal), orientation=turned)
    scene.contact(box.surface(), scene.ground.plane((0.0, 0.0, 0.0), tuple(normal)), friction=0.8, name="slope")
    rest = lf.equilibrium(scene)
    contact, weight = rest.contact("slope"), 2.0 * G
    assert contact.normal.sum() == pytest.approx(weight * math.cos(slope), rel=EXACT)
    assert contact.on("box") == pytest.approx([0.0, 0.0, weight], abs=EXACT * weight)
    assert rest.q[:3] @ normal == pytest.approx(0.3 if beyond < 0.0 else 0.1, abs=1e-9)
    moment = contact.normal @ (contact.place - rest.q[:3]) @ [math.cos(slope), 0.0, -math.sin(slope)]
    height = float(rest.q[:3] @ normal)
    assert moment == pytest.approx(weight * height * math.sin(slope), rel=EXACT)
    assert rest.stable


@pytest.mark.parametrize("masses", [(1.0, 1e-6), (1e-6, 1.0), (1e-6, 1.0, 1e-6)])
@pytest.mark.parametrize("gap", [0.001, 0.01])
def test_a_feather_and_a_weight(gap: float, masses: tuple[float, ...]) -> None:
    """Gaps of 1e-10 m that rounding leaves ask for more than what a feather weighs."""
    rest = lf.equilibrium(stack(0.1, 0.4, gap, masses))
    for k, contact in enumerate(rest.contacts):
        assert contact.normal.sum() == pytest.approx(G * sum(masses[k:]), rel=EXACT)
    assert rest.stable


def test_a_box_that_floats_rests_where_it_is() -> None:
    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    scene.add(lf.Cuboid(0.1, 0.1, 0.1, mass=1.0), "box", position=(1.0, 2.0, 3.0))
    rest = lf.equilibrium(scene)
    assert rest.q == pytest.approx([1.0, 2.0, 3.0, 1.0, 0.0, 0.0, 0.0])
    assert rest.stable
    assert len(rest.neutral) == 6
