"""A hinged solid rod swings against a sphere: the massless boundary at steps of which sixteen differ little."""

from __future__ import annotations

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.runs.setup import Stepper
from tests.rates import assert_rate

pytestmark = pytest.mark.slow
LENGTH, HEIGHT, RADIUS = 0.1, 0.01, 0.2
PLACE = np.array([0.03, 0.0, -HEIGHT / 2.0])  # of the contact, 0.08 m from the hinge


@pytest.fixture(scope="module")
def rod() -> lf.SpatialBody:
    """Elements of 1.2 mm about the contact, whose radius is 1.5 mm; normal forces alone have residual modes."""
    solid = lf.Solid.box(
        (LENGTH, 0.02, HEIGHT), size=0.012, near={"contact": (tuple(PLACE), 1.2e-3, 2.6e-3)}, density=2700.0,
        youngs_modulus=6.9e10, poissons_ratio=0.33,
    )  # fmt: skip
    places = solid.finite_elements().places
    under = np.abs(places[:, 2] - PLACE[2]) < 1e-9
    nodes = np.flatnonzero(under & (np.linalg.norm(places - PLACE, axis=1) < 4.2e-3)).tolist()
    return solid.reduce(15, contact=nodes, rows="normal", interfaces=[lf.Interface("left", contact=False)])


def first_collision(rod: lf.SpatialBody, points: str, stepper: Stepper) -> tuple[float, float, float]:
    """Impulse [N s], and how the energy has changed at the end and at most, relative to that of the start; 1 m/s."""
    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    spin = 1.0 / (LENGTH / 2.0 + PLACE[0])
    body = scene.add(rod, name="rod", angular_velocity=(0.0, spin, 0.0), velocity=(0.0, 0.0, -spin * LENGTH / 2.0))
    hinge = scene.ground.at(-LENGTH / 2.0, 0.0, 0.0)
    scene.join(lf.Revolute(body.point("left"), hinge, axis=(0.0, 1.0, 0.0), name="hinge"))
    ball = scene.ground.sphere((PLACE[0], 0.0, PLACE[2] - RADIUS - 1e-7), RADIUS)
    scene.contact(body.face("contact"), ball, points=points, name="hit")
    result = lf.simulate(scene, 6.4e-5, stepper, record=3.2e-6)
    assert result.force[-1, 0, 0] == 0.0
    change = result.energies.stored / result.energies.stored[0] - 1.0
    return float(result.impulse[-1, 0, 0]), float(change[-1]), float(np.abs(change).max())


@pytest.mark.parametrize("points", ["nodes", "areas"])
def test_impulse_and_energy_of_a_solid_pendulum(rod: lf.SpatialBody, points: str) -> None:
    """A contact of 48 us: the impulse at 1.6 us is that at .1 us, energy is kept with the square of the step."""
    fine, _, kept = first_collision(rod, points, lf.MasslessBoundary(step=1e-7))
    assert kept < 3e-5
    middle, _, coarser = first_collision(rod, points, lf.MasslessBoundary(step=4e-7))
    coarse, end, _ = first_collision(rod, points, lf.MasslessBoundary(step=1.6e-6))
    assert middle == pytest.approx(fine, rel=5e-5)
    assert coarse == pytest.approx(fine, rel=1e-4)
    assert abs(end) < 1.5e-3
    assert_rate([1e-7, 4e-7], [kept, coarser], 2.0, 0.5)


def test_moreau_jean_comes_to_the_same_impulse(rod: lf.SpatialBody) -> None:
    fine = first_collision(rod, "nodes", lf.MasslessBoundary(step=1e-7))[0]
    assert first_collision(rod, "nodes", lf.MoreauJean(step=1e-7))[0] == pytest.approx(fine, rel=5e-4)
