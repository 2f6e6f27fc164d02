"""Contact problems of islands in space, solved in compiled steps: against posed ones, closed forms, each other."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import lcpflex as lf
from lcpflex.solvers.certificate import guarded_residual
from lcpflex.steppers.island_problems import shorten_forces
from lcpflex.steppers.spatial.projection import lift_island
from tests.cone_islands import GRAVITY, Laid, Touch, box_on_ground, tower

STEP = 1e-3


def falling(laid: Laid, direction: tuple[float, float, float] = (0.0, 0.0, -1.0)) -> np.ndarray:
    """The velocity after a step of gravity from rest."""
    u = np.zeros(len(laid.system.u))
    for d in laid.work.rows.dof[:-1]:
        u[d : d + 3] = GRAVITY * STEP * np.asarray(direction)
    return u


def random_heap(seed: int, bodies: int = 4, smooth: bool = False) -> tuple[Laid, np.ndarray]:
    """Balls and contacts at random between them and the ground, of masses from 0.01 to 100; and a free velocity."""
    rng = np.random.default_rng(seed)
    scene = lf.SpatialScene()
    places = rng.uniform(-0.3, 0.3, (bodies, 3)) + 0.4 * np.arange(bodies)[:, None] * [0.0, 0.0, 1.0]
    for b in range(bodies):
        scene.add(
            lf.Cuboid(*rng.uniform(0.1, 0.5, 3), mass=10.0 ** rng.uniform(-1, 1)),
            f"b{b}",
            places[b],
            Rotation.from_rotvec(rng.uniform(-1, 1, 3)),
        )
    touches = []
    for k in range(2 * bodies):
        i = int(rng.integers(bodies))
        j = int(rng.integers(-1, i)) if k else -1
        friction = 0.0 if smooth and k % 2 else rng.uniform(0.1, 0.8)
        place = places[i] + rng.uniform(-0.2, 0.2, 3)
        touches.append(Touch(i, j, place, [*rng.uniform(-0.4, 0.4, 2), 1.0], friction))
    laid = Laid(scene.compile().system(), touches)
    return laid, rng.standard_normal(len(laid.system.u))


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("smooth", [False, True])
def test_forces_solve_the_posed_problem(seed: int, smooth: bool) -> None:
    laid, u = random_heap(seed, smooth=smooth)
    assert laid.solve(u) == 0
    problem, forces = laid.problem(), laid.forces()
    assert guarded_residual(*problem.residual_parts(forces)) <= 1e-9  # as the run judges: all contacts together
    residual, strict = problem.residuals(forces)
    assert residual <= 1e-8  # each by its own load
    assert strict < 1e-6


def test_box_at_rest_carries_its_weight_and_stops() -> None:
    """Warm, the same step costs no sweep, and what is left of its velocity is rounding of g h."""
    laid = box_on_ground()
    u = falling(laid)
    assert laid.solve(u) == 0
    f = laid.forces().reshape(-1, 3)
    assert f[:, 0].sum() == pytest.approx(2.0 * GRAVITY * STEP, rel=1e-13)
    assert np.abs(laid.after(u)).max() < 1e-15
    assert laid.solve(u, warm=True) == 0
    assert laid.work.impulses.solver.iterations == 0.0
    assert np.array_equal(laid.forces().reshape(-1, 3)[:, 0], f[:, 0])


def test_forces_that_keep_a_box_still_are_found_and_serve() -> None:
    """A speed of rounding is not stopped and brought back by turns: 24 of 600 steps sweep, 116 where it was."""
    laid = box_on_ground(size=(0.2828, 0.1414, 0.08), tilt=Rotation.from_rotvec([0.02, 0.0, 0.3]))
    pull, u = falling(laid, (0.02, 0.05, -1.0)), np.zeros(6)
    assert laid.solve(pull) == 0
    u[2] = 3e-16
    swept = 0
    for _ in range(600):
        assert laid.solve(u + pull, warm=True) == 0
        swept += laid.work.impulses.solver.iterations > 0.0
        u = laid.after(u + pull)
    assert swept <= 40
    assert np.abs(u).max() < 1e-14


@pytest.mark.parametrize("mass", [1e-9, 1.0, 1e9])
def test_block_on_an_incline_slides_by_the_closed_form(mass: float) -> None:
    """g (sin - mu cos) h down the slope where tan > mu, nothing where it is less; on tilted axes, any mass."""
    mu, tilt = 0.3, Rotation.from_rotvec([0.2, -0.5, 0.9])
    for angle in (0.2, 0.5):
        laid = box_on_ground(mass, friction=mu, tilt=tilt)
        down = tilt.apply([np.sin(angle), 0.0, -np.cos(angle)])
        u = falling(laid, tuple(down))
        assert laid.solve(u) == 0
        speed = tilt.inv().apply(laid.after(u)[:3])
        expected = GRAVITY * STEP * max(0.0, np.sin(angle) - mu * np.cos(angle))
        assert speed == pytest.approx([expected, 0.0, 0.0], abs=1e-11 if expected else 1e-16)


@pytest.mark.parametrize("turn", [0.7, 2.0])
def test_forces_are_kept_as_vectors_of_the_world(turn: float) -> None:
    """Other tangents in the next step, where nothing slides: no sweep."""
    laid = box_on_ground()
    u = falling(laid, (0.3, 0.1, -1.0))
    assert laid.solve(u) == 0
    laid.turn = turn
    laid._rows()
    assert laid.solve(u, warm=True) == 0
    assert laid.work.impulses.solver.iterations == 0.0
    assert laid.after(u) == pytest.approx(np.zeros(6), abs=1e-15)


def test_islands_equal_the_whole() -> None:
    """Two boxes apart, posed one by one and together."""
    scene = lf.SpatialScene()
    touches = []
    for b, x in enumerate((0.0, 5.0)):
        scene.add(lf.Sphere(0.1, mass=1.0 + b), f"ball{b}", (x, 0.0, 0.1))
        touches.append(Touch(b, -1, np.array([x, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])))
    laid = Laid(scene.compile().system(), touches)
    u = np.arange(12.0) - 8.0
    assert laid.solve(u) == 0
    assert laid.work.posed.islands.count == 2
    assert laid.problem().residuals(laid.forces())[1] <= 1e-9


@pytest.mark.parametrize("held", [True, False])
def test_a_body_that_joints_hold_keeps_islands_apart(held: bool) -> None:
    """Two balls on a plate: welded to the ground it passes no impulse on, on a ball joint it does."""
    scene = lf.SpatialScene()
    plate = scene.add(lf.Cuboid(2.0, 1.0, 0.1, mass=3.0), "plate", (0.0, 0.0, -0.05))
    here = scene.ground.at(0.0, 0.0, -0.05)
    scene.join(lf.Weld(here, plate.at(0.0, 0.0, 0.0)) if held else lf.Ball(here, plate.at(0.0, 0.0, 0.0)))
    touches = []
    for b, x in ((1, -0.6), (2, 0.7)):
        scene.add(lf.Sphere(0.1, mass=1.0 + b), f"ball{b}", (x, 0.0, 0.1))
        touches.append(Touch(b, 0, np.array([x, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])))
    laid = Laid(scene.compile().system(), touches)
    u = np.concatenate([np.zeros(6), np.random.default_rng(1).standard_normal(12) - 2.0])
    assert laid.solve(u) == 0
    assert laid.work.posed.islands.count == (2 if held else 1)
    assert laid.problem().residuals(laid.forces())[0] <= 1e-9


def test_joints_are_condensed() -> None:
    """Two links on ball joints, their ends on the ground, against the posed problem."""
    scene = lf.SpatialScene()
    links = [scene.add(lf.Cuboid(0.4, 0.1, 0.1, mass=1.0 + b), f"link{b}", (0.4 * b, 0.0, 0.0)) for b in range(2)]
    scene.join(lf.Ball(links[0].at(0.2, 0.0, 0.0), links[1].at(-0.2, 0.0, 0.0)))
    up = np.array([0.0, 0.0, 1.0])
    touches = [Touch(b, -1, np.array([x, y, -0.05]), up) for b, x in ((0, -0.2), (1, 0.6)) for y in (-0.05, 0.05)]
    touches.append(Touch(1, -1, np.array([0.3, 0.0, -0.05]), up, 0.0))
    laid = Laid(scene.compile().system(), touches)
    for u in (falling(laid), np.random.default_rng(0).standard_normal(12)):
        assert laid.solve(u) == 0
        assert laid.problem().residuals(laid.forces())[0] <= 1e-9


def test_tower_carries_what_is_above() -> None:
    """Sums of normal forces of the floors, to rounding once warm steps have settled."""
    masses = [1.0, 2.0, 3.0]
    laid = tower(masses)
    u = falling(laid)
    for _ in range(3):
        assert laid.solve(u, warm=True) == 0
    f = laid.forces().reshape(3, 4, 3)[:, :, 0].sum(axis=1)
    assert f == pytest.approx([6.0 * GRAVITY * STEP, 5.0 * GRAVITY * STEP, 3.0 * GRAVITY * STEP], rel=1e-9)


def test_undetermined_forces_are_the_least_ones() -> None:
    """A box on four corners carries a quarter of its weight on each; also where it is pushed sideways."""
    for push in (0.0, 0.2):
        laid = box_on_ground()
        u = falling(laid, (push, 0.0, -1.0))
        assert laid.solve(u) == 0
        before = laid.after(u)
        assert shorten_forces(laid.work)
        f = laid.forces().reshape(4, 3)
        assert laid.after(u) == pytest.approx(before, abs=1e-14)
        assert (np.hypot(f[:, 1], f[:, 2]) <= 0.5 * f[:, 0] * (1.0 + 1e-12)).all()
        if push == 0.0:
            assert f[:, 0] == pytest.approx(np.full(4, 0.5 * GRAVITY * STEP), rel=1e-10)
            assert f[:, 1:] == pytest.approx(np.zeros((4, 2)), abs=1e-13)


@pytest.mark.parametrize("jointed", [False, True])
def test_sunk_contacts_are_lifted(jointed: bool) -> None:
    """W_N dq = depth for contacts that a box rests on, to what a sweep leaves."""
    laid = box_on_ground()
    if jointed:
        scene = lf.SpatialScene()
        boxes = [scene.add(lf.Cuboid(0.3, 0.2, 0.1, mass=2.0), f"b{i}", (0.3 * i, 0.0, 0.0)) for i in range(2)]
        scene.join(lf.Ball(boxes[0].at(0.15, 0.0, 0.0), boxes[1].at(-0.15, 0.0, 0.0)))
        up = np.array([0.0, 0.0, 1.0])
        laid = Laid(
            scene.compile().system(), [Touch(0, -1, np.array([x, y, -0.05]), up) for x, y in ((-0.1, 0.0), (0.1, 0.1))]
        )
    assert laid.solve(falling(laid)) == 0
    n = laid.work.rows.n_contacts
    laid.work.scratch.sunk[:n] = -1e-6 * np.array([1.0, 2.0, 2.0, 3.0])[:n]
    q = laid.q.copy()
    assert lift_island(laid.system.model, laid.work, 0, q)
    if jointed:  # what is left is the answer of the joints, which are projected afterwards
        G, lifts = laid.problem().dense()[::3, ::3], laid.work.scratch.multipliers[laid.work.rows.n_joint :][:n]
        assert G @ lifts == pytest.approx(-laid.work.scratch.sunk[:n], rel=1e-5)
        return
    for touch, depth in zip(laid.touches, -laid.work.scratch.sunk[:n], strict=True):
        before, after = (Rotation.from_quat(x[3:7], scalar_first=True) for x in (laid.q, q))
        arm = before.inv().apply(touch.place - laid.q[:3])
        moved = q[:3] + after.apply(arm) - touch.place
        assert moved[2] == pytest.approx(depth, rel=1e-4)
