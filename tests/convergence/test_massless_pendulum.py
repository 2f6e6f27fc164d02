"""A hinged solid rod swings against a sphere: the massless boundary at steps of which sixteen differ little."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest

import lcpflex as lf
from lcpflex.gallery.mechanisms.solid_strip import hinged_solid, solid_on_hemisphere
from lcpflex.runs.setup import Stepper
from tests import libs
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


FINEST, LONGEST = 1.5e-4, 7e-3  # [m] of elements: the radius of contact is 2.5 times, the shortest wave 6 times theirs
LONG, FAR = 0.7, 0.28
MODES = 80  # up to 25 kHz; with 40, half of which bend the wide way or twist, the peak is 7 % higher
PHASES = 8


def graded(place: float, low: float, high: float, fine: int, longest: float) -> npt.NDArray[np.float64]:
    """Places from ``low`` to ``high``: ``fine`` steps of FINEST beside one of them, then each twice the one before."""
    found = [place]
    for sign, room in ((1.0, high - place), (-1.0, place - low)):
        way, step, k = 0.0, FINEST, 0
        while room - way > 1e-9:
            step = step if k < fine else min(2.0 * step, longest)
            way = room if room - way < 1.6 * step else way + step
            found.append(place + sign * way)
            k += 1
    return np.unique(np.round(found, 12))


@pytest.fixture(scope="module")
def long_rod() -> lf.SpatialBody:
    """0.7 m in aluminium. Data: Shi, Hong & Liu 2013; a Poisson's ratio of 0.33, which they do not print."""
    mesh = libs.skfem.MeshHex.init_tensor(
        graded(FAR, -0.35, 0.35, 3, LONGEST),
        graded(0.0, -0.014, 0.014, 3, LONGEST),
        graded(-2.5e-3, -2.5e-3, 2.5e-3, 2, LONGEST),
    )
    x, y, z = mesh.p
    near = (np.abs(z + 2.5e-3) < 1e-9) & (np.hypot(x - FAR, y) < 3.01 * FINEST)
    sets = {"left": np.flatnonzero(x < -0.3499), "patch": np.flatnonzero(near)}
    solid = lf.Solid(mesh, density=2700.0, youngs_modulus=6.9e10, poissons_ratio=0.33, sets=sets)
    return hinged_solid(solid, MODES)


def swung(rod: lf.SpatialBody, points: str, step: float, duration: float, phase: float = 0.0) -> lf.Result:
    """Onto a sphere of 20 mm, a radius that is not printed, at 0.4 m/s, after 0.25 us and a part of a step."""
    scene = solid_on_hemisphere(rod, 0.5 * LONG + FAR, 0.02, 0.4, gap=0.4 * (2.5e-7 + phase * step), points=points)
    return lf.simulate(scene, duration, lf.MasslessBoundary(step=step), record=step)


def test_collisions_of_a_long_rod(long_rod: lf.SpatialBody) -> None:
    """As 17 000 nodes of half of it have them, in another program, by this scheme at 0.2 us."""
    result = swung(long_rod, "nodes", 5e-7, 6e-4)
    force = result.force[:, 0, 0]
    times = result.times[np.flatnonzero(np.diff(force > 0.0))]
    assert times[1:5] == pytest.approx([153e-6, 246e-6, 410e-6, 547e-6], rel=0.01)
    assert force.max() == pytest.approx(259.0, rel=0.01)
    assert force[result.times > 2e-4].max() == pytest.approx(163.0, rel=0.01)


@pytest.mark.parametrize("points", ["nodes", "areas"])
def test_impulse_of_a_long_rod(long_rod: lf.SpatialBody, points: str) -> None:
    fine = swung(long_rod, points, 2.5e-7, 1.9e-4).impulse[-1, 0, 0]
    for phase in (0.0, 0.5):
        coarse = swung(long_rod, points, 4e-6, 1.96e-4, phase)
        assert coarse.impulse[-1, 0, 0] == pytest.approx(fine, rel=5e-4)
        assert abs(coarse.energies.stored[-1] / coarse.energies.stored[0] - 1.0) < 3e-4


def energies_of_a_long_rod(rod: lf.SpatialBody, points: str, step: float) -> npt.NDArray[np.float64]:
    """(2, PHASES) how energy, and what leapfrog steps keep of free modes, have changed after the collision.

    H + h^2/12 v.K v - h^2/24 |K q|^2, on average H (1 + (omega h)^2/24), with masses of one.
    """
    changes = []
    square = rod.frequencies()[:MODES] ** 2
    for k in range(PHASES):
        result = swung(rod, points, step, 1.9e-4, k / PHASES)
        start, end = result.energies.stored[[0, -1]]
        q, u = result.q[-1, 7 : 7 + MODES], result.u[-1, 6 : 6 + MODES]
        kept = end + step**2 * float(square @ u**2 / 12.0 - square**2 @ q**2 / 24.0)
        changes.append([float(end / start) - 1.0, float(kept / start) - 1.0])
    return np.array(changes).T


@pytest.mark.parametrize(("points", "bound"), [("nodes", 1e-5), ("areas", 3e-5)])
def test_energy_of_a_long_rod(long_rod: lf.SpatialBody, points: str, bound: float) -> None:
    """Of the modes leapfrog steps leave 1e-5 out at 1 us; what closes or opens within a step adds less, either way."""
    energy, kept = energies_of_a_long_rod(long_rod, points, 1e-6)
    finer, _ = energies_of_a_long_rod(long_rod, points, 5e-7)
    assert np.abs(kept).max() < bound
    assert abs(kept.mean()) < 1e-6
    assert np.abs(energy).max() < bound + 1e-5
    assert np.abs(finer).max() < 1e-5
    assert_rate([5e-7, 1e-6], [-finer.mean(), -energy.mean()], 2.0, 0.2)
