"""Places of rest against closed forms, and runs that begin there."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.gallery.mechanisms.claws import LENGTH, claw, resting_force
from tests.scenes import floor_of

G = 9.81
EXACT = 1e-8


def detent(friction: float = 0.0) -> lf.Scene:
    """A ball of 10 mm, pressed by a spring beside its notch into it: planes of 30 and 45 degrees that meet at 0."""
    scene = lf.Scene(gravity=(0.0, 0.0))
    ball = scene.add(lf.Disc(0.01, mass=0.1), "ball", position=(0.003, 0.03))
    scene.load(lf.Spring(ball.point("center"), scene.ground.at(0.01, -0.1), 500.0, length=0.06))
    right, left = math.tan(math.radians(30.0)), math.tan(math.radians(45.0))
    notch = scene.ground.chain([(0.1, 0.1 * right), (0.0, 0.0), (-0.1, 0.1 * left)])
    scene.contact(ball.surface(), notch, friction=friction, name="notch")
    return scene


def stack(boxes: int = 4) -> lf.Scene:
    """Boxes of 1 kg, 2 kg, ... on each other, each a little to the side of that below it."""
    scene = lf.Scene(gravity=(0.0, -G))
    below = floor_of(scene)
    for k in range(boxes):
        box = scene.add(lf.Box(0.4, 0.2, mass=1.0 + k), f"box{k}", position=(0.03 * k, 0.1 + 0.2 * k))
        scene.contact(box.surface(), below, friction=0.4, name=f"contact{k}")
        below = box.surface()
    return scene


def ladder(friction: float, degrees: float = 60.0, ends: bool = True) -> lf.Scene:
    """A ladder of 2 m and 10 kg with its foot on a floor and its head at a smooth wall."""
    angle, length = math.radians(degrees), 2.0
    scene = lf.Scene(gravity=(0.0, -G))
    middle = (0.5 * length * math.cos(angle), 0.5 * length * math.sin(angle))
    body = scene.add(lf.Box(length, 0.04, mass=10.0), "ladder", position=middle, angle=math.pi - angle)
    foot, head = body.node(-0.5 * length, 0.0), body.node(0.5 * length, 0.0)
    scene.contact(foot, floor_of(scene), friction=friction, name="foot")
    scene.contact(head, scene.ground.half_plane((0.0, 0.0), (1.0, 0.0)), name="head")
    if ends:
        scene.contact(head, floor_of(scene), friction=friction, name="head on floor")
    return scene


def latch(x: float) -> lf.Scene:
    """A ball that a spring pulls into one of two notches, 100 mm apart, with a tooth between them."""
    scene = lf.Scene(gravity=(0.0, 0.0))
    ball = scene.add(lf.Disc(0.01, mass=0.1), "ball", position=(x, 0.02))
    scene.load(lf.Spring(ball.point("center"), scene.ground.at(0.01, -0.4), 100.0, length=0.2))
    teeth = scene.ground.chain([(0.2, 0.1), (0.05, -0.01), (0.0, 0.0), (-0.05, -0.02), (-0.2, 0.1)])
    scene.contact(ball.surface(), teeth, name="teeth")
    return scene


def beam(friction: float = 0.0) -> lf.Scene:
    """A steel strip of 1 m with 4 modes on two supports, its own weight and 0.5 N in the middle upon it."""
    scene = lf.Scene(gravity=(0.0, -G))
    strip = scene.add(lf.Beam(1.0, 0.02, 0.02, 1000.0, 2e11), "beam", modes=4)
    for x, name in ((0.0, "left"), (1.0, "right")):
        scene.contact(strip.node(x, 0.0), floor_of(scene), friction=friction, name=name)
    scene.load(lf.Force(strip.point("center"), (0.0, -0.5)))
    return scene


def in_notch(center: Any, planes: list[tuple[float, Any]], force: Any, radius: float = 0.01) -> None:
    """Check a ball at ``center``: its two planes, each an angle with a place on it, and forces on it from them."""
    normals = np.array([(-math.sin(a), math.cos(a)) for a, _ in planes])
    distances = [normals[k] @ (center - np.array(place)) for k, (_, place) in enumerate(planes)]
    assert np.abs(np.array(distances) - radius).max() < EXACT * radius
    assert (np.linalg.solve(normals.T, -force) > 0.0).all()


def spring_force(center: Any, anchor: Any, stiffness: float, length: float) -> Any:
    way = np.asarray(anchor) - center
    return stiffness * (np.hypot(*way) - length) * way / np.hypot(*way)


def two_forces(rest: lf.Rest, name: str, angles: list[float], force: Any) -> None:
    """Check the normal forces of a frictionless ball between two planes, whatever their order."""
    contact = rest.contact(name)
    exact = np.linalg.solve(np.array([(-math.sin(a), math.cos(a)) for a in angles]).T, -force)
    assert sorted(contact.normal) == pytest.approx(sorted(exact), rel=EXACT)
    assert contact.on("ball") == pytest.approx(-force, rel=EXACT)
    assert contact.states == ("slip", "slip")
    assert contact.unique.all()


def test_detent() -> None:
    """Between two planes, where they meet: place and forces by a system of two equations."""
    rest = lf.equilibrium(detent())
    angles = [math.radians(30.0), -math.radians(45.0)]
    center = rest.point("ball", "center")
    force = spring_force(center, (0.01, -0.1), 500.0, 0.06)
    in_notch(center, [(angle, (0.0, 0.0)) for angle in angles], force)
    two_forces(rest, "notch", angles, force)
    assert rest.stable
    assert rest.unique
    assert rest.neighbours == 0
    assert rest.residual < 1e-12
    assert len(rest.neutral) == 1
    assert "'ball' turns" in rest.neutral[0]


@pytest.mark.parametrize("start", [-0.01, 0.01])
def test_latch(start: float) -> None:
    """Which of two notches the ball rests in follows from the side that it starts on."""
    rest = lf.equilibrium(latch(start))
    if start > 0.0:
        angles, bottom = [math.atan2(0.11, 0.15), math.atan2(-0.01, 0.05)], (0.05, -0.01)
    else:
        angles, bottom = [math.atan2(-0.12, 0.15), math.atan2(0.02, 0.05)], (-0.05, -0.02)
    center = rest.point("ball", "center")
    force = spring_force(center, (0.01, -0.4), 100.0, 0.2)
    in_notch(center, [(angle, bottom) for angle in angles], force)
    two_forces(rest, "teeth", angles, force)
    assert rest.stable


def test_latch_goes_on_from_where_it_is() -> None:
    """``initial`` decides, not the start of the scene."""
    there = lf.equilibrium(latch(0.01))
    again = lf.equilibrium(latch(-0.01), initial=there)
    assert again.q == pytest.approx(there.q, abs=1e-12)
    assert again.travelled < 1e-12


def test_stack() -> None:
    """Each contact bears the weight above it, with the moment that its places make; corners share nothing sideways."""
    rest = lf.equilibrium(stack())
    mass = np.arange(1.0, 5.0)
    for k in range(4):
        contact = rest.contact(f"contact{k}")
        weight = G * mass[k:]
        assert contact.on(f"box{k}") == pytest.approx([0.0, weight.sum()], rel=EXACT, abs=1e-8)
        side = np.array([1.0 if pair[0] == f"box{k}" else -1.0 for pair in contact.bodies])
        moment = contact.place[:, 0] @ (side * contact.normal * contact.direction[:, 1])
        assert moment == pytest.approx(0.03 * np.arange(k, 4) @ weight, rel=EXACT)
        assert contact.state == "stick"
    assert rest.stable
    assert not rest.unique
    assert rest.neighbours == 4


LIMIT = 0.5 / math.tan(math.radians(60.0))


def test_ladder_below_its_limit() -> None:
    """It stays where it is leant: floor m g, wall m g / (2 tan a); so near its limit, and beyond it not."""
    rest = lf.equilibrium(ladder(LIMIT * (1.0 + 1e-6)))
    assert rest.contact("foot").normal == pytest.approx([10.0 * G], rel=EXACT)
    assert rest.contact("head").normal == pytest.approx([10.0 * G * LIMIT], rel=EXACT)
    assert rest.contact("foot").on("ladder") == pytest.approx([-10.0 * G * LIMIT, 10.0 * G], rel=EXACT)
    assert [contact.state for contact in rest.contacts] == ["stick", "slip", "open"]
    assert rest.stable
    assert rest.unique
    assert rest.neighbours == 1
    assert rest.travelled < 1e-9


def test_ladder_above_its_limit() -> None:
    """It slides down until it lies on the floor; without an end to that it says so."""
    rest = lf.equilibrium(ladder(LIMIT * (1.0 - 1e-3)))
    assert math.sin(rest.q[2]) == pytest.approx(0.0, abs=1e-9)
    assert rest.travelled > 0.5
    assert rest.contact("foot").normal == pytest.approx([5.0 * G], rel=EXACT)
    assert rest.contact("head on floor").normal == pytest.approx([5.0 * G], rel=EXACT)
    with pytest.raises(lf.SolverError, match="'ladder' turns counter-clockwise"):
        lf.equilibrium(ladder(LIMIT * (1.0 - 1e-3)), farthest=0.3)


@pytest.mark.parametrize("fingers", [1, 2])
def test_claw(fingers: int) -> None:
    """A lever on a sprung wall, F L cos a = T and F = k L sin a; two levers against each other."""
    rest = lf.equilibrium(claw(fingers=fingers))
    force = resting_force(fingers=fingers)
    for contact in rest.contacts:
        assert contact.normal == pytest.approx([force], rel=EXACT)
    if fingers == 1:
        assert rest.q[0] == pytest.approx(force / 50.0, rel=EXACT)
        assert math.sin(rest.q[5]) * LENGTH == pytest.approx(force / 50.0, rel=EXACT)
        assert rest.joint("left hinge").force == pytest.approx([force, 0.0], rel=EXACT, abs=1e-8)
    assert rest.stable
    assert rest.unique


@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_beam_on_two_supports(friction: float) -> None:
    """Half the load at each, and 5 q L^4 / 384 EI + P L^3 / 48 EI in the middle."""
    rest = lf.equilibrium(beam(friction))
    load, stiffness = 1000.0 * 0.02**2 * G, 2e11 * 0.02**4 / 12.0
    sag = (5.0 * load / 384.0 + 0.5 / 48.0) / stiffness
    middle, end = rest.point("beam", "center"), rest.point("beam", "left")
    assert end[1] - middle[1] == pytest.approx(sag, rel=EXACT)
    for name in ("left", "right"):
        assert rest.contact(name).on("beam")[1] == pytest.approx(0.5 * load + 0.25, rel=EXACT)
    assert rest.stable
    assert rest.unique
    assert bool(rest.neutral) == (friction == 0.0)  # free to slide along


@pytest.mark.parametrize("friction", [0.5, 2.0])
def test_shared_forces_of_least_norm(friction: float) -> None:
    """A disc in a right-angled notch: W/2 = N cos b + T sin b; T = N tan b is the least, where friction allows it."""
    scene = lf.Scene(gravity=(0.0, -G))
    ball = scene.add(lf.Disc(0.1, mass=2.0), "ball", position=(0.0, 0.15))
    notch = scene.ground.chain([(1.0, 1.0), (0.0, 0.0), (-1.0, 1.0)])
    scene.contact(ball.surface(), notch, friction=friction, name="notch")
    contact = lf.equilibrium(scene).contact("notch")
    slope = min(friction, 1.0)
    exact = G / (math.sqrt(0.5) * (1.0 + slope))
    assert contact.normal == pytest.approx([exact, exact], rel=EXACT)
    assert np.abs(contact.tangential) == pytest.approx(slope * contact.normal, rel=EXACT)
    assert contact.on("ball") == pytest.approx([0.0, 2.0 * G], rel=EXACT, abs=1e-8)
    assert not contact.unique.any()
    assert contact.state == "stick"


def test_redundant_hinges() -> None:
    """Two hinges of a bar share a weight; what they could press against each other is nothing at the least."""
    scene = lf.Scene(gravity=(0.0, -G))
    bar = scene.add(lf.Box(1.0, 0.1, mass=2.0), "bar")
    for name, x in (("left", -0.5), ("right", 0.5)):
        scene.join(lf.Revolute(bar.point(name), scene.ground.at(x, 0.0), name=name))
    rest = lf.equilibrium(scene)
    for name in ("left", "right"):
        assert rest.joint(name).force == pytest.approx([0.0, G], rel=EXACT, abs=1e-9)
        assert not rest.joint(name).unique
    assert not rest.unique
    assert rest.stable
    assert not rest.neutral


def test_upside_down() -> None:
    """A pendulum that stands on its head rests, but not stably; a little beside it, it goes down."""
    for angle, stable in ((0.5 * math.pi, False), (0.5 * math.pi - 1e-4, True)):
        scene = lf.Scene(gravity=(0.0, -G))
        place = (0.5 * math.cos(angle), 0.5 * math.sin(angle))
        bar = scene.add(lf.Box(1.0, 0.1, mass=2.0), "bar", position=place, angle=angle)
        scene.join(lf.Revolute(bar.point("left"), scene.ground.at(0.0, 0.0), name="hinge"))
        rest = lf.equilibrium(scene)
        assert rest.stable == stable
        assert bool(rest.unstable) != stable
        assert rest.q[1] == pytest.approx(-0.5 if stable else 0.5, abs=1e-9)
        assert rest.joint("hinge").force == pytest.approx([0.0, 2.0 * G], rel=EXACT, abs=1e-8)


def test_a_pin_does_not_leave_its_hole() -> None:
    """Steps are short against the clearance where that is what bends the path: the arm hangs, 1 mm lower."""
    scene = lf.Scene(gravity=(0.0, -G))
    arm = scene.add(lf.Box(1.0, 0.1, mass=1.0), "arm", position=(0.5, 0.0))
    ground = scene.ground.at(0.0, 0.0)
    name = scene.revolute_with_clearance(P=arm.point("left"), Q=ground, pin_radius=0.01, hole_radius=0.011)
    rest = lf.equilibrium(scene)
    assert rest.q == pytest.approx([0.0, -0.501, -0.5 * math.pi], abs=1e-9)
    assert rest.contact(name).on("arm") == pytest.approx([0.0, G], rel=EXACT, abs=1e-8)


def test_what_moves_is_said() -> None:
    """A ball without support beside one that lies; a box on a slope that is too steep for its friction."""
    scene = lf.Scene(gravity=(0.0, -G))
    lying = scene.add(lf.Disc(0.1, mass=1.0), "lying", position=(0.0, 0.1))
    scene.add(lf.Disc(0.1, mass=1.0), "falling", position=(1.0, 0.1))
    scene.contact(lying.surface(), floor_of(scene))
    with pytest.raises(lf.SolverError, match=r"rest within farthest = 2 m: 'falling' moves along \(0, -1\),"):
        lf.equilibrium(scene, farthest=2.0)
    angle = math.radians(20.0)
    normal = (math.sin(angle), math.cos(angle))
    slope = lf.Scene(gravity=(0.0, -G))
    place = (0.1 * normal[0], 0.1 * normal[1])
    box = slope.add(lf.Box(0.4, 0.2, mass=2.0), "box", position=place, angle=-angle)
    slope.contact(box.surface(), slope.ground.half_plane((0.0, 0.0), normal), friction=0.3)
    with pytest.raises(lf.SolverError, match=r"'box' moves along \(0.94, -0.34\)"):
        lf.equilibrium(slope, farthest=1.0)


SCENES = {
    "detent": detent,
    "rough detent": lambda: detent(0.4),
    "stack": stack,
    "ladder": lambda: ladder(0.5),
    "fallen ladder": lambda: ladder(0.1),
    "claw": claw,
    "latch": lambda: latch(0.01),
    "beam": beam,
    "rough beam": lambda: beam(0.3),
}


@pytest.mark.parametrize("name", SCENES)
def test_a_run_stays_there(name: str) -> None:
    """Ten seconds of Moreau-Jean move nothing by 1e-9 of the size; and nothing is warned of."""
    scene = SCENES[name]()
    rest = lf.equilibrium(scene)
    result = lf.simulate(scene, 10.0, lf.MoreauJean(1e-3), record=1.0, progress=False, initial=rest)
    assert np.abs(result.q - rest.q).max() < 1e-9 * rest.compiled.size
    assert not result.warnings
    assert any("place of rest" in note for note in result.notes)


@pytest.mark.parametrize("name", ["stack", "rough detent", "fallen ladder", "claw"])
def test_an_event_driven_run_stays_there(name: str) -> None:
    """The same of accelerations, integrated with error control."""
    scene = SCENES[name]()
    rest = lf.equilibrium(scene)
    result = lf.simulate(scene, 10.0, lf.EventDriven(), record=1.0, progress=False, initial=rest)
    assert np.abs(result.q - rest.q).max() < 1e-9 * rest.compiled.size
    assert not result.warnings


def check_notch(rest: lf.Rest, planes: Any, anchor: Any, spring: Any, radius: float = 0.01) -> None:
    """Place and forces of a frictionless ball between two planes, each an angle with a place on it."""
    center = rest.point("ball", "center")
    force = spring_force(center, anchor, *spring)
    in_notch(center, planes, force, radius)
    two_forces(rest, rest.contacts[0].name, [angle for angle, _ in planes], force)


@pytest.mark.slow
def test_latch_has_two_places() -> None:
    """Both are listed, each with its forces, that of the start first."""
    right = [(math.atan2(0.11, 0.15), (0.05, -0.01)), (math.atan2(-0.01, 0.05), (0.05, -0.01))]
    left = [(math.atan2(-0.12, 0.15), (-0.05, -0.02)), (math.atan2(0.02, 0.05), (-0.05, -0.02))]
    found = lf.equilibria(latch(0.01))
    assert len(found) == 2
    for rest, planes in zip(found, (right, left), strict=True):
        check_notch(rest, planes, (0.01, -0.4), (100.0, 0.2))
        assert rest.stable
    assert len(lf.equilibria(latch(0.01), most=1)) == 1


def grooves(x: float, friction: float = 0.0) -> lf.Scene:
    """A ball of 3 mm that a spring pulls onto a strip with three notches of 60 and 45 degrees, 20 mm apart."""
    scene = lf.Scene(gravity=(0.0, 0.0))
    ball = scene.add(lf.Disc(0.003, mass=0.1), "ball", position=(x, 0.02))
    scene.load(lf.Spring(ball.point("center"), scene.ground.at(0.0, -0.3), 200.0, length=0.1))
    steep, flat = math.sqrt(3.0), 1.0
    places = [(0.05, 0.0)]
    for middle in (0.02, 0.0, -0.02):
        places += [(middle + 0.005 / steep, 0.0), (middle, -0.005), (middle - 0.005 / flat, 0.0)]
    scene.contact(ball.surface(), scene.ground.chain([*places, (-0.05, 0.0)]), friction=friction, name="strip")
    return scene


@pytest.mark.slow
@pytest.mark.parametrize("friction", [0.0, 0.1])
def test_detent_of_three_grooves(friction: float) -> None:
    """All three, from any of them, with their forces; with a little friction as well, each once."""
    found = lf.equilibria(grooves(0.0, friction))
    sides = math.radians(60.0), -math.radians(45.0)
    half = 0.5 * (math.radians(180.0) - sides[0] + sides[1])  # of the angle at the bottom
    way = 0.5 * (sides[0] + sides[1]) + 0.5 * math.pi
    middle = [0.003 / math.sin(half) * math.cos(way), -0.005 + 0.003 / math.sin(half) * math.sin(way)]
    for rest in found:
        groove = round(float(rest.q[0] - middle[0]) / 0.02) * 0.02
        assert rest.q[:2] == pytest.approx([groove + middle[0], middle[1]], abs=1e-10)
        if not friction:
            check_notch(rest, [(side, (groove, -0.005)) for side in sides], (0.0, -0.3), (200.0, 0.1), 0.003)
    assert sorted(round(float(rest.q[0] - middle[0]) / 0.02) for rest in found) == [-1, 0, 1]


def test_one_place_of_rest() -> None:
    """What friction or a smooth floor leaves open is one place, wherever it is pushed."""
    for friction in (0.0, 0.3):
        scene = lf.Scene(gravity=(0.0, -G))
        disc = scene.add(lf.Disc(0.1, mass=1.0), "disc", position=(0.0, 0.1))
        scene.contact(disc.surface(), floor_of(scene), friction=friction)
        (rest,) = lf.equilibria(scene, reach=0.3)
        assert rest.contacts[0].normal == pytest.approx([G], rel=EXACT)


@pytest.mark.slow
def test_sides_of_a_box() -> None:
    """It is turned from side to side; the weight is on each."""
    scene = lf.Scene(gravity=(0.0, -G))
    box = scene.add(lf.Box(0.4, 0.2, mass=2.0), "box", position=(0.0, 0.1))
    scene.contact(box.surface(), floor_of(scene), friction=0.3, name="floor")
    found = lf.equilibria(scene)
    heights = sorted(float(rest.q[1]) for rest in found)
    assert heights == pytest.approx([0.1, 0.1, 0.2, 0.2], abs=1e-9)
    for rest in found:
        assert rest.contact("floor").on("box") == pytest.approx([0.0, 2.0 * G], rel=EXACT, abs=1e-8)
