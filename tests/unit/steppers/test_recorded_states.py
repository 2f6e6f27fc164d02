"""STICK and SLIP of touching points as they are stored: by the cone of the contact, not by a speed of rounding."""

import numpy as np
import pytest

import lcpflex as lf
from lcpflex import gallery
from lcpflex.model.arrays import SLIP, STICK
from lcpflex.results.result import Result
from lcpflex.steppers.recorded_contacts import friction_state
from tests.solids import box_with_surface

STEPPERS = (lf.MoreauJean(step=1e-3), lf.MoreauJean(step=1e-3, theta=1.0), lf.GeneralizedAlpha(step=1e-3))


def held_block(friction: float, modes: int = 6) -> lf.SpatialScene:
    """A flexible block above the ground that a jaw presses against a wall."""
    material = {"density": 1000.0, "youngs_modulus": 2e10}
    body = box_with_surface((0.2, 0.2, 0.1), (8, 8, 4), modes, 0.3, **material)
    scene, place = lf.SpatialScene(gravity=(0.0, 0.0, -9.81)), (-0.11, 0.0, 0.3)
    block = scene.add(body, position=(0.0, 0.0, 0.3))
    jaw = scene.add(lf.Cuboid(0.02, 0.3, 0.2, mass=0.5), position=place)
    scene.join(lf.Prismatic(jaw.at(0, 0, 0), scene.ground.at(*place), axis=(1, 0, 0)))
    scene.load(lf.Force(jaw.at(0, 0, 0), (4e3, 0.0, 0.0)))
    scene.contact(block.surface(), jaw.surface(), friction=friction)
    scene.contact(block.surface(), scene.ground.plane((0.1, 0, 0), (-1, 0, 0)), friction=friction)
    return scene


def inside(result: Result, friction: float, share: float) -> np.ndarray:
    """Which touching points have |F_T| below ``share`` mu F_N."""
    points = result.contact_points
    size = np.linalg.norm(points.friction_force, axis=1)
    return np.asarray(size < share * friction * points.force[:, 0])


@pytest.mark.parametrize(
    ("tangential", "slip", "state"),
    [(0.0, 1.0, STICK), (2.99, 1e-3, STICK), (3.0, 1e-3, SLIP), (3.0, 1e-10, STICK), (3.0 - 1e-9, 1e-3, SLIP)],
)
def test_a_contact_inside_of_its_cone_sticks_and_one_on_it_by_its_speed(
    tangential: float, slip: float, state: int
) -> None:
    assert friction_state(10.0, tangential, 0.3, slip, 1e-9) == state
    assert friction_state(10.0, 0.0, 0.0, 1.0, 1e-9) == SLIP  # there is nothing that could hold it


@pytest.mark.parametrize("stepper", STEPPERS[:2], ids=["theta = 1/2", "theta = 1"])
def test_a_held_flexible_block_sticks_at_all_points(stepper: lf.MoreauJean) -> None:
    """Of 90 points of a block between a wall and a jaw 74 were stored as slipping: 1e-9 m/s is what a solver leaves."""
    result = lf.simulate(held_block(friction=0.5), 0.03, stepper, record=0.01, progress=False)
    assert result.contact_points.force.shape[0] > 250
    assert (result.state[1:] == STICK).all()
    assert (result.contact_points.state[inside(result, 0.5, 0.95)] == STICK).all()


def test_a_held_flexible_block_stays_held_under_generalised_alpha() -> None:
    """At 7e-9 m/s, what its solver had left, 69 of 73 contacts did not count as resting, and 11 J came from nowhere."""
    result = lf.simulate(held_block(0.5, modes=1), 0.015, STEPPERS[2], record=0.0, progress=False)
    assert result.energies.kinetic.max() < 1e-12
    assert result.energies.growth < 1e-6
    assert (result.contact_points.state[inside(result, 0.5, 0.95)] == STICK).all()


@pytest.mark.parametrize("stepper", STEPPERS, ids=["theta = 1/2", "theta = 1", "generalised-alpha"])
def test_what_slides_slips_in_space(stepper: lf.MoreauJean | lf.GeneralizedAlpha) -> None:
    scene = lf.SpatialScene(gravity=(0.0, 0.0, -9.81))
    box = scene.add(lf.Cuboid(0.2, 0.1, 0.1, mass=1.0), position=(0.0, 0.0, 0.05), velocity=(0.01, 0.002, 0.0))
    scene.contact(box.surface(), scene.ground.plane((0, 0, 0), (0, 0, 1)), friction=0.3)
    result = lf.simulate(scene, 0.01, stepper, record=0.0, progress=False)
    moving = np.hypot(result.u[:, 0], result.u[:, 1]) > 1e-6
    assert moving.sum() > 2
    assert (result.state[1:, 0][moving[1:]] == SLIP).all()
    assert (result.state[~moving, 0] == STICK).all()


def test_a_block_that_rocks_in_the_plane_sticks_where_its_friction_is_inside_of_the_cone() -> None:
    """Rows are laid elsewhere once a step has lifted what sank: 986 of 999 points were stored as slipping."""
    case = gallery.scenes()["rocking_block"]
    result = lf.simulate(case.build(), 0.2, lf.MoreauJean(step=1e-3), record=0.0, progress=False)
    assert result.compiled is not None
    friction = float(result.compiled.model.contacts.friction[0])
    assert len(result.contact_points.force) > 150
    assert (result.contact_points.state[inside(result, friction, 0.95)] == STICK).all()
