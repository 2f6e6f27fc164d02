"""Motions that Coulomb's law admits at an instant in space, against closed forms, planar twins and a fine grid."""

from __future__ import annotations

import math

import numpy as np
import pytest

import lcpflex as lf
from lcpflex import gallery
from lcpflex.studies import Outcome, acceleration_level, stability
from lcpflex.studies.stability_maps.admissible_accelerations import ContactFate, Count, admissible_accelerations
from lcpflex.studies.stability_maps.spatial_accelerations import _directions

G = 9.81
AZIMUTH = 0.7  # [rad] of the vertical plane in which the rod moves


def rod(friction: float = 1.4, degrees: float = 60.0, spin: float = 0.0, slip: float = -1.0) -> lf.SpatialScene:
    """Painleve's rod of the gallery in a vertical plane of space: mass 1, length 2, gravity 1, slender."""
    phi, (c, s) = math.radians(degrees), (math.cos(AZIMUTH), math.sin(AZIMUTH))
    along = np.array([c * math.cos(phi), s * math.cos(phi), math.sin(phi)])
    out = np.array([s, -c, 0.0])  # of the plane: turns from forth to up are about it
    axes = np.column_stack([along, out, np.cross(along, out)])
    scene = lf.SpatialScene(gravity=(0.0, 0.0, -1.0))
    omega = spin * out
    centre = along.copy()
    velocity = slip * np.array([c, s, 0.0]) + np.cross(omega, along)
    body = scene.add(
        lf.SpatialRigidBody(1.0, np.diag([1e-6, 1.0 / 3.0, 1.0 / 3.0])), "rod", position=centre, orientation=axes,
        velocity=velocity, angular_velocity=omega,
    )  # fmt: skip
    floor = scene.ground.plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    scene.contact(body.node(body.at(-1.0, 0.0, 0.0)), floor, friction=friction, restitution=0.0)
    return scene


@pytest.mark.parametrize(
    ("friction", "degrees", "spin"), [(0.5, 60.0, 0.0), (1.4, 60.0, 0.0), (1.4, 60.0, 1.2), (2.0, 30.0, 0.0)]
)
def test_painleves_rod_is_that_of_the_plane(friction: float, degrees: float, spin: float) -> None:
    flat = admissible_accelerations(gallery.painleve_rod(friction, degrees, spin))
    found = admissible_accelerations(rod(friction, degrees, spin))
    assert found.count is flat.count
    assert len(found.solutions) == len(flat.solutions)
    for here, there in zip(
        *(sorted(one.solutions, key=lambda one: one.force[0, 0]) for one in (found, flat)), strict=True
    ):
        assert here.force[0, 0] == pytest.approx(there.force[0, 0], abs=1e-9)
        assert here.contact_acceleration[0, 0] == pytest.approx(there.contact_acceleration[0, 0], abs=1e-9)
        pulled = here.force[0, 1:] @ found.tangents[0]
        wanted = friction * here.force[0, 0] * np.array([math.cos(AZIMUTH), math.sin(AZIMUTH), 0.0])
        assert pulled == pytest.approx(wanted, abs=1e-9)
        assert here.fate == (ContactFate.SEPARATES if here.force[0, 0] == 0.0 else ContactFate.SLIDES,)


def test_the_map_of_painleves_rod_has_its_boundary() -> None:
    """mu > (1 + 3 cos^2) / (3 sin cos), closed, on a map of angles and frictions."""
    axes = {"degrees": np.linspace(25.0, 85.0, 7), "friction": np.linspace(0.5, 3.0, 9)}
    found = stability(rod, {"acceleration level": acceleration_level}, axes)
    phi = np.radians(axes["degrees"])
    exact = (1.0 + 3.0 * np.cos(phi) ** 2) / (3.0 * np.sin(phi) * np.cos(phi))
    wanted = axes["friction"] < exact[:, None]
    assert 5 < wanted.sum() < wanted.size - 5
    cells = found.of("acceleration level")
    assert (cells == np.where(wanted, Outcome.SOUND, Outcome.NO_SOLUTION)).all()


def ball(friction: float, degrees: float = 0.0, push: tuple[float, float] = (0.0, 0.0)) -> lf.SpatialScene:
    """A ball at rest on a plane, in gravity that leans by an angle, towards a direction askew."""
    lean, (c, s) = math.radians(degrees), (math.cos(AZIMUTH), math.sin(AZIMUTH))
    scene = lf.SpatialScene(gravity=G * np.array([c * math.sin(lean), s * math.sin(lean), -math.cos(lean)]))
    body = scene.add(lf.Sphere(0.1, density=1000.0), "ball", position=(0.0, 0.0, 0.1))
    scene.contact(body.surface(), scene.ground.plane((0, 0, 0), (0, 0, 1)), friction=friction, restitution=0.0)
    return scene


@pytest.mark.parametrize("degrees", [10.0, 40.0, 70.0])
@pytest.mark.parametrize("share", [0.9, 1.1])
def test_a_ball_rolls_or_slips_down_a_slope(degrees: float, share: float) -> None:
    """It rolls, 5/7 g sin, where mu > 2/7 tan; else it slips, g (sin - mu cos)."""
    lean = math.radians(degrees)
    friction = share * 2.0 / 7.0 * math.tan(lean)
    found = admissible_accelerations(ball(friction, degrees))
    (one,) = found.solutions
    gained = 5.0 / 7.0 * G * math.sin(lean) if share > 1.0 else G * (math.sin(lean) - friction * math.cos(lean))
    down = np.array([math.cos(AZIMUTH), math.sin(AZIMUTH), 0.0])
    assert one.acceleration[:3] == pytest.approx(gained * down, rel=1e-9, abs=1e-9)
    assert one.fate == (ContactFate.STICKS if share > 1.0 else ContactFate.SLIDES,)
    assert found.forces_unique


@pytest.mark.parametrize("share", [0.9, 1.1])
def test_a_ball_that_is_pushed_by_another_one_rolls_or_slips(share: float) -> None:
    """By one without friction behind it: it rolls, 5/6 g sin, where mu > 1/3 tan; else g sin - mu g cos / 2."""
    lean = math.radians(40.0)
    friction = share / 3.0 * math.tan(lean)
    scene = ball(friction, 40.0)
    down = np.array([math.cos(AZIMUTH), math.sin(AZIMUTH), 0.0])
    behind = scene.add(lf.Sphere(0.1, density=1000.0), "behind", position=np.array([0.0, 0.0, 0.1]) - 0.2 * down)
    scene.contact(behind.surface(), scene.ground.plane((0, 0, 0), (0, 0, 1)), friction=0.0, restitution=0.0)
    scene.contact(behind.surface(), scene.body("ball").surface(), friction=0.0, restitution=0.0)
    found = admissible_accelerations(scene)
    (one,) = found.solutions
    gained = 5.0 / 6.0 * G * math.sin(lean) if share > 1.0 else G * (math.sin(lean) - 0.5 * friction * math.cos(lean))
    assert one.acceleration[:3] == pytest.approx(gained * down, rel=1e-9, abs=1e-9)
    assert one.acceleration[6:9] == pytest.approx(gained * down, rel=1e-9, abs=1e-9)
    fates = {ContactFate.TOUCHES, ContactFate.STICKS if share > 1.0 else ContactFate.SLIDES}
    assert set(one.fate) == fates


def test_a_ball_at_rest_stays_whichever_way_it_might_slip() -> None:
    found = admissible_accelerations(ball(0.3))
    assert (found.count, len(found.solutions)) == (Count.UNIQUE, 1)
    assert found.solutions[0].fate == (ContactFate.STICKS,)
    assert found.solutions[0].acceleration == pytest.approx(np.zeros(6), abs=1e-12)


def leaning(friction: float, speed: float = 0.0) -> lf.SpatialScene:
    """The rod at rest on the floor, or with a spin that keeps its point there: it may stick, slip or lift."""
    return rod(friction, 60.0, speed, slip=0.0)


@pytest.mark.parametrize(("friction", "spin"), [(0.2, 0.0), (0.6, 0.0), (1.4, 0.0), (0.3, 1.5), (2.0, 1.5)])
def test_a_rod_at_rest_is_that_of_the_plane(friction: float, spin: float) -> None:
    flat = admissible_accelerations(gallery.painleve_rod(friction, 60.0, spin, slip=0.0))
    found = admissible_accelerations(leaning(friction, spin))
    assert found.count is flat.count
    heights = [sorted(one.contact_acceleration[0, 0] for one in many.solutions) for many in (found, flat)]
    assert heights[0] == pytest.approx(heights[1], abs=1e-9)
    forces = [sorted(one.force[0, 0] for one in many.solutions) for many in (found, flat)]
    assert forces[0] == pytest.approx(forces[1], abs=1e-9)


def test_what_stands_on_several_contacts_that_may_stick_is_refused() -> None:
    scene = lf.SpatialScene(gravity=(0.0, 0.0, -G))
    box = scene.add(lf.Cuboid(0.2, 0.1, 0.1, density=1000.0), "box", position=(0.0, 0.0, 0.05))
    scene.contact(box.surface(), scene.ground.plane((0, 0, 0), (0, 0, 1)), friction=0.3, restitution=0.0)
    with pytest.raises(lf.ModelError, match="4 contacts touch that may stick, expected at most one in space"):
        admissible_accelerations(scene)


def test_a_box_that_slides_on_four_corners_has_one_motion() -> None:
    scene = lf.SpatialScene(gravity=(0.0, 0.0, -G))
    box = scene.add(
        lf.Cuboid(0.2, 0.1, 0.02, density=1000.0), "box", position=(0.0, 0.0, 0.01), velocity=(0.3, 0.4, 0.0)
    )
    scene.contact(box.surface(), scene.ground.plane((0, 0, 0), (0, 0, 1)), friction=0.3, restitution=0.0)
    found = admissible_accelerations(scene)
    assert found.count is Count.UNIQUE
    assert not found.forces_unique
    assert found.solutions[0].acceleration == pytest.approx([-0.6 * 0.3 * G, -0.8 * 0.3 * G, 0, 0, 0, 0], abs=1e-9)


def test_an_impact_comes_first() -> None:
    scene = ball(0.3)
    with pytest.raises(lf.ModelError, match="approaches at 1 m/s: an impact comes first"):
        admissible_accelerations(scene, u=[0.0, 0.0, -1.0, 0.0, 0.0, 0.0])


def test_all_directions_are_found() -> None:
    """Sign changes of F x d on a fine grid, of random F: each has its root."""
    rng = np.random.default_rng(7)
    t = np.linspace(0.0, 2.0 * np.pi, 20001)
    parts = np.array([np.ones_like(t), np.cos(t), np.sin(t)])
    counts = []
    for _ in range(200):
        F = rng.normal(size=(2, 3)) * np.array([1.0, *(2 * [rng.choice([0.1, 1.0, 10.0])])])
        x, y = F @ parts
        across = x * parts[2] - y * parts[1]
        changes = t[:-1][np.sign(across[:-1]) != np.sign(across[1:])]
        found = np.sort(list(_directions(F)))
        counts.append(len(found))
        assert len(found) == len(changes)
        assert np.abs(np.sort(changes % (2 * np.pi)) - found).max(initial=0.0) < 1e-3
    assert set(counts) == {0, 2, 4}
