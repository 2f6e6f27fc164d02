"""A scene with other bodies is the scene that would have been written with them."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

import lcpflex as lf
from lcpflex import gallery
from lcpflex.errors import ModelError
from lcpflex.scene.scene import Scene

STEEL = {"width": 0.02, "thickness": 0.01, "density": 7800.0, "youngs_modulus": 2.1e11}


def strip(modes: int) -> lf.Body:
    return lf.Beam(length=0.5, elements=12, **STEEL).reduce(modes=modes)


def everything(modes: int, other: int = 3, modal: bool = False) -> Scene:
    """Every kind of part: made by name, by place, by points, on both bodies and on the ground."""
    scene = Scene()
    start = 1e-4 * np.arange(1.0, 1.0 + modes) if modal else None
    arm = scene.add(
        strip(modes), "arm", (0.1, 0.2), 0.3, (0.5, -0.2), 1.5, start, None if start is None else 30.0 * start
    )
    rod = scene.add(strip(other), "rod", (0.1, 0.5), velocity=(0.0, -1.0))
    box = scene.add(lf.Box(0.1, 0.1, mass=1.0), "box", (1.5, 0.3))
    scene.load(lf.Spring(arm.point("left"), scene.ground.at(0.0, 0.2), 500.0, 1.0))
    scene.load(lf.Spring(arm.at(0.2, 0.005), rod.point("left"), 100.0))
    scene.load(lf.Force(rod.point("right"), (lf.Harmonic(3.0, 40.0), 0.0), follower=True))
    scene.load(lf.TorsionSpring(arm.point("center"), rod.point("center"), 0.3))
    scene.join(lf.Distance(box.at(0.05, 0.0), scene.ground.at(1.5, 0.8), name="rope"))
    ball = arm.circle(arm.point("right"), 0.02)
    tip = rod.node(0.5, -0.005)
    arm.arc("center", 0.01, 0.0, math.pi)
    rod.hole((0.25, 0.0), 0.002)
    floor = scene.ground.half_plane((0.0, -0.05), (0.0, 1.0))
    edge = rod.chain([(0.1, -0.005), rod.at(0.3, -0.005)])
    scene.contact(ball, floor, friction=0.2, name="ball")
    scene.contact(arm.surface("top"), tip, friction=0.1)
    scene.contact_all(friction=0.3, exclude=[(box, arm), (edge, floor)])
    return scene


def motion(scene: Scene) -> tuple[np.ndarray, np.ndarray]:
    result = lf.simulate(scene, 0.2, lf.MoreauJean(step=2e-4), record=0.0, progress=False)
    return result.q, result.u


def test_an_equal_body_gives_the_same_motion_to_the_last_bit() -> None:
    given = everything(4, modal=True)
    again = given.with_bodies({"arm": strip(4), "rod": strip(3)})
    assert again is not given
    assert again.compiled().layout.contacts == given.compiled().layout.contacts
    for new, old in zip(motion(again), motion(given), strict=True):
        np.testing.assert_array_equal(new, old)


def test_another_body_gives_the_scene_written_with_it() -> None:
    changed = everything(4).with_bodies({"arm": strip(0), "rod": strip(6)})
    written = everything(0, other=6)
    assert changed.compiled().layout.contacts == written.compiled().layout.contacts
    for new, old in zip(motion(changed), motion(written), strict=True):
        np.testing.assert_array_equal(new, old)


def test_the_scene_that_was_given_stays_as_it_was() -> None:
    given = everything(4)
    before = motion(given)
    other = given.with_bodies({"arm": strip(8)})
    other.load(lf.Torque(other.body("box").at(0.0, 0.0), 1.0))
    for new, old in zip(motion(given), before, strict=True):
        np.testing.assert_array_equal(new, old)


def displaced(bar, x: float) -> float:
    """Where the material at x is along the bar at the start."""
    return float(bar.start[0][0] + x + bar.start[0][3:] @ bar.source.locate(x, 0.0).phi[:, 0])


def test_an_initial_deformation_is_carried_over() -> None:
    scene = gallery.prestressed_bar(elements=20)
    bar = scene.body("bar")
    places = np.linspace(0.0, 1.0, 21)
    wanted = np.array([displaced(bar, x) for x in places])
    finer = scene.with_bodies({"bar": lf.Bar(1.0, 1.0, 1.0, 1.0, elements=40).reduce(None)}).body("bar")
    found = np.array(
        [finer.start[0][0] + x + finer.start[0][3:] @ finer.source.locate(x, 0.0).phi[:, 0] for x in places]
    )
    np.testing.assert_allclose(found, wanted, atol=1e-12)  # its mesh holds the other one


def test_what_a_body_cannot_follow_by_deforming_it_follows_by_moving() -> None:
    """A deflection that is in part a rotation: the rigid body turns by that part and keeps the momenta."""
    scene = Scene(gravity=(0.0, 0.0))
    soft = strip(6)
    modal = np.array([1e-3, -2e-3, 5e-4, 0.0, 0.0, 1e-4])
    scene.add(soft, "arm", (0.3, 0.1), 0.4, (1.0, 2.0), 3.0, modal, 100.0 * modal)
    q, u = scene.with_bodies({"arm": strip(0)}).body("arm").start
    np.testing.assert_allclose(q, [0.3, 0.1, 0.4], atol=1e-12)  # free modes carry no motion of the frame
    np.testing.assert_allclose(u, [1.0, 2.0, 3.0], atol=1e-9)
    q, u = scene.with_bodies({"arm": strip(3)}).body("arm").start
    np.testing.assert_allclose(q[3:], modal[:3], atol=1e-12)
    np.testing.assert_allclose(u[3:], 100.0 * modal[:3], atol=1e-10)


@pytest.mark.parametrize(
    ("bodies", "message"),
    [
        ({"leg": strip(1)}, r"bodies: no body 'leg', expected one of 'arm', 'rod', 'box'"),
        ({"arm": 3}, r"bodies\['arm'\]: 3 was given, expected a Body"),
        ({"rod": lf.Disc(0.1, mass=1.0)}, "'rod' has no point"),
        ([strip(1)], "bodies: .* was given, expected a mapping from names"),
    ],
)
def test_bodies_that_cannot_be(bodies, message: str) -> None:
    with pytest.raises(ModelError, match=message):
        everything(2).with_bodies(bodies)


def test_motion_of_the_frame_in_a_shape_becomes_motion_of_the_frame() -> None:
    """Shapes with a share of translation, as of a body whose frame does not move with its mass."""
    shift = np.array([0.0, 2.0])  # of each mode [kg^-1/2]
    free = strip(2)

    def locate(x: float, y: float):
        point = free.locate(x, y)
        return replace(point, phi=point.phi + shift)

    scene = Scene(gravity=(0.0, 0.0))
    scene.add(replace(free, locate=locate), "arm", (0.3, 0.1), 0.5 * math.pi, (1.0, 2.0), 3.0, [1e-3, 0.0], [0.1, 0.0])
    q, u = scene.with_bodies({"arm": strip(1)}).body("arm").start
    np.testing.assert_allclose(q, [0.3 - 2e-3, 0.1, 0.5 * math.pi, 1e-3], atol=1e-12)
    np.testing.assert_allclose(u, [1.0 - 0.2, 2.0 - 3.0 * 2e-3, 3.0, 0.1], atol=1e-10)


def test_a_deformation_needs_the_distribution_of_mass() -> None:
    scene = Scene()
    scene.add(strip(1), "arm", modal=[1e-3])
    with pytest.raises(ModelError, match="project: this body has no known distribution of mass"):
        scene.with_bodies({"arm": lf.Box(0.5, 0.02, mass=1.0)})
