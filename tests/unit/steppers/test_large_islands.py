"""Islands of many contacts: solved in the velocities of bodies, or told to be left with their best point."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.gallery.mechanisms.piles import brick_wall
from lcpflex.gallery.mechanisms.rigid import stack
from lcpflex.steppers.projection import lift_large_island

WEIGHT = 9.81
WORDS = "islands of many contacts were not solved"


def heap(count: int = 40, friction: float = 0.5, seed: int = 1, kg: float = 1.0, m: float = 1.0, s: float = 1.0):
    """Discs of scattered radii above each other in a box; falls and settles."""
    rng = np.random.default_rng(seed)
    scene = lf.Scene(gravity=(0.0, -WEIGHT * m / s**2))
    width, row = 1.4, 6
    for point, normal in (((0.0, 0.0), (0.0, 1.0)), ((0.0, 0.0), (1.0, 0.0)), ((width * m, 0.0), (-1.0, 0.0))):
        scene.ground.half_plane(point, normal)
    for k in range(count):
        radius = 0.1 * (1.0 - 0.02 * rng.uniform())
        place = (0.12 + 0.22 * (k % row) + 0.01 * rng.uniform(-1.0, 1.0), 0.12 + 0.21 * (k // row))
        scene.add(lf.Disc(radius * m, mass=kg), name=f"disc {k}", position=(place[0] * m, place[1] * m))
    scene.contact_all(friction=friction)
    return scene


def on_floor(result: lf.Result) -> float:
    floor = [k for k, name in enumerate(result.contact_names) if name.endswith("half_plane1")]
    return float(result.force[-1, floor, 0].sum())


@pytest.mark.parametrize("stepper", [lf.MoreauJean(1e-3), lf.GeneralizedAlpha(1e-3)], ids=["mj", "ga"])
def test_a_tall_tower_stands(stepper: Any) -> None:
    """Sixty contacts of which half are redundant; each box carries what is above."""
    result = lf.simulate(stack(boxes=15, friction=0.5), 0.1, stepper, progress=False)
    assert result.size.max() > 3 * 50
    assert np.abs(result.q - result.q[0]).max() < 1e-9
    assert on_floor(result) == pytest.approx(15 * WEIGHT, rel=1e-6)
    assert result.residual.max() <= 1e-9
    assert "NOT to be trusted" not in result.summary()


def test_a_large_island_moves_as_one_dense_problem() -> None:
    """The same steps by Lemke's method, which is given all contacts as one LCP."""
    scene = stack(boxes=8, top_mass=10.0)
    runs = [
        lf.simulate(scene, 0.05, lf.MoreauJean(1e-3, solver=solver), progress=False)
        for solver in (lf.Auto(), lf.Lemke())
    ]
    assert runs[0].q[-1] == pytest.approx(runs[1].q[-1], abs=1e-9)
    assert on_floor(runs[0]) == pytest.approx(on_floor(runs[1]), rel=1e-6)


def test_a_heap_keeps_its_laws() -> None:
    result = lf.simulate(heap(), 0.6, lf.MoreauJean(1e-3, projection=False), progress=False)
    assert result.energies.relative_remainder < 1e-12
    assert result.penetration.max() < 2e-3
    assert result.residual.max() <= 1e-9
    momentum = result.u[-1].reshape(-1, 3)[:, 1].sum()
    floor = [k for k, name in enumerate(result.contact_names) if name.endswith("half_plane1")]
    walls = [k for k, name in enumerate(result.contact_names) if name.endswith(("half_plane2", "half_plane3"))]
    # walls push up along their tangent (n_y, -n_x): down along the left one, up along the right one
    left = [k for k in walls if result.contact_names[k].endswith("half_plane2")]
    rubbed = result.impulse[-1, walls, 1].sum() - 2.0 * result.impulse[-1, left, 1].sum()
    pushed = result.impulse[-1, floor, 0].sum() + rubbed
    assert momentum == pytest.approx(pushed - 40 * WEIGHT * 0.6, abs=1e-6)


def test_a_heap_in_other_units() -> None:
    """The same steps, and as good a residual: the motion itself is as sensitive as that of a billiard."""
    times = 0.25
    plain = lf.simulate(heap(), times, lf.MoreauJean(1e-3), progress=False)
    for kg, m, s in ((1e-3, 1e3, 1.0), (1.0, 1.0, 1e3), (1e3, 1e-3, 1e-3)):
        other = lf.simulate(heap(kg=kg, m=m, s=s), times * s, lf.MoreauJean(1e-3 * s), progress=False)
        assert other.residual.max() <= 1e-9
        places, own = (np.array(r.q[-1]).reshape(-1, 3)[:, :2] for r in (other, plain))
        assert places / m == pytest.approx(own, abs=1e-4)


def test_two_runs_are_equal_to_the_bit() -> None:
    runs = [lf.simulate(heap(), 0.4, lf.MoreauJean(1e-3), progress=False) for _ in range(2)]
    assert np.array_equal(runs[0].q, runs[1].q)
    assert np.array_equal(runs[0].force, runs[1].force)


def test_what_is_not_solved_is_told_or_an_error() -> None:
    """With a budget of one factor, a heap that falls together is left with what can be found."""
    stepper = lf.MoreauJean(1e-3, budget=1)
    result = lf.simulate(heap(150), 0.4, stepper, progress=False)
    assert result.complete
    [told] = [text for text in result.warnings if WORDS in text]
    assert "typically" in told
    assert result.residual.max() > 1e-9
    with pytest.raises(lf.StepError, match=r"an island of \d+ contacts was not solved in \d+ sparse factors"):
        lf.simulate(heap(150), 0.4, replace(stepper, on_unsolved="raise"), progress=False)


@pytest.mark.slow
@pytest.mark.parametrize("stepper", [lf.MoreauJean(1e-3, budget=1), lf.GeneralizedAlpha(1e-3, budget=1)])
def test_steps_that_are_told_of_are_those_with_a_residual(stepper: Any) -> None:
    """Once each, however many problems of a step were not solved."""
    result = lf.simulate(heap(150), 0.36, stepper, record=1e-3, progress=False)
    count = np.count_nonzero(result.residual > stepper.solver_tolerance)
    assert count > 5
    [told] = [text for text in result.warnings if WORDS in text]
    assert told.startswith(f"in {count} of 360 steps, ")


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("on_unsolved", "ignore", 'expected "continue" or "raise"'),
        ("on_unsolved", None, 'expected "continue" or "raise"'),
        ("budget", 0, "a whole number >= 1, of factors, or None"),
        ("budget", 1.5, "a whole number >= 1, of factors, or None"),
        ("budget", True, "a whole number >= 1, of factors, or None"),
        ("budget", np.timedelta64(3, "s"), "a whole number >= 1, of factors, or None"),
    ],
)
def test_bad_choices_are_refused(name: str, value: object, words: str) -> None:
    for stepper in (lf.MoreauJean, lf.GeneralizedAlpha):
        with pytest.raises(lf.ModelError, match=f"{name}: .*{words}"):
            stepper(1e-3, **{name: value})


def test_what_holds_a_pile_at_rest_feels_its_weight_as_a_force() -> None:
    """No impact: contacts between bodies that rest approach by no more than a solver leaves."""
    scene = lf.Scene(gravity=(0.0, -WEIGHT))
    below = plank = scene.add(lf.Box(width=1.0, height=0.1, mass=1.0), name="plank", position=(0.0, 0.05))
    scene.join(lf.Weld(plank.at(0.0, 0.0), scene.ground.at(0.0, 0.05), name="weld"))
    for k in range(12):
        box = scene.add(lf.Box(width=0.2, height=0.1, mass=1.0), name=f"box {k}", position=(0.0, 0.15 + 0.1 * k))
        scene.contact(box.surface(), below.surface(), friction=0.5)
        below = box
    carried = lf.simulate(scene, 0.1, lf.MoreauJean(1e-3), record=0.02, progress=False).reaction("weld")
    assert carried.force[1:, 1] == pytest.approx(np.full(5, 13 * WEIGHT), rel=1e-6)
    assert not carried.impulse.any()


def test_a_users_own_system_of_many_contacts() -> None:
    """Thirty masses on springs between two sheets each: one block of coordinates, sixty contacts with friction."""
    n = 30
    stiffness = 1e3 * (2.0 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1))
    normals = np.zeros((2 * n, n))
    normals[np.arange(n), np.arange(n)] = 1.0  # q holds heights, then places along the sheet
    tangents = np.zeros((2 * n, n))
    tangents[n + np.arange(n), np.arange(n)] = 1.0
    rest = np.zeros(2 * n)
    own = lf.UserSystem(
        q=rest,
        u=np.concatenate([np.zeros(n), np.linspace(-1.0, 1.0, n)]),
        mass=np.eye(2 * n),
        force=lambda t, q, u: np.concatenate([-10.0 - stiffness @ q[:n] * 0.0, -stiffness @ q[n:]]),
        gaps=lambda q: q[:n],
        normals=normals,
        tangents=tangents,
        friction=0.3,
    )
    runs = [lf.simulate(own, 0.02, lf.MoreauJean(1e-3, solver=solver)) for solver in (lf.Auto(), lf.Lemke())]
    assert runs[0].size.max() == 3 * n
    assert runs[0].q == pytest.approx(runs[1].q, abs=1e-10)
    assert runs[0].residual.max() <= 1e-9


def chained(count: int) -> lf.Scene:
    """A chain of hinged boxes dropped flat on the floor: contacts and joints in one island."""
    scene = lf.Scene(gravity=(0.0, -WEIGHT))
    floor = scene.ground.half_plane((0.0, 0.0), (0.0, 1.0))
    before = None
    for k in range(count):
        box = scene.add(lf.Box(width=0.1, height=0.02, mass=1.0 + k % 3), name=f"link {k}", position=(0.1 * k, 0.03))
        scene.contact(box.surface(), floor, friction=0.4)
        if before is not None:
            scene.join(lf.Revolute(before.at(0.05, 0.0), box.at(-0.05, 0.0), name=f"hinge {k}"))
        before = box
    return scene


def test_a_chain_lies_on_the_floor() -> None:
    """All its links, two contacts each, hinges between them: as one dense problem, and in the velocities of bodies."""
    runs = [
        lf.simulate(chained(16), 0.2, lf.MoreauJean(1e-3, solver=solver), progress=False)
        for solver in (lf.Auto(), lf.Lemke())
    ]
    assert runs[0].size.max() == 96
    assert runs[0].q[-1] == pytest.approx(runs[1].q[-1], abs=1e-7)
    weight = WEIGHT * sum(1.0 + k % 3 for k in range(16))
    assert runs[0].force[-1, :, 0].sum() == pytest.approx(weight, rel=1e-6)
    assert runs[0].joint_drift.max() < 1e-10
    assert runs[0].residual.max() <= 1e-9


def test_accelerations_and_positions_of_large_islands() -> None:
    """Under generalised-alpha all three problems of a step: at rest, and with discs that fall on each other."""
    result = lf.simulate(stack(boxes=25), 0.05, lf.GeneralizedAlpha(1e-3), progress=False)
    assert result.size.max() > 3 * 90
    assert np.abs(result.q - result.q[0]).max() < 1e-9
    assert on_floor(result) == pytest.approx(25 * WEIGHT, rel=1e-6)
    falling = lf.simulate(heap(), 0.3, lf.GeneralizedAlpha(1e-3), progress=False)
    assert falling.size.max() > 3 * 20
    assert falling.penetration.max() < 1e-9
    assert falling.residual.max() <= 1e-9


def test_forces_of_a_large_island_are_the_least() -> None:
    """A tower: both corners of a box carry the same, and rub no more than they must."""
    scene = stack(boxes=12)
    result = lf.simulate(scene, 0.02, lf.MoreauJean(1e-3), progress=False)
    points = result.contact_points
    last = points.record == points.record.max()
    assert np.abs(points.force[last, 1]).max() < 1e-6 * WEIGHT
    for name in result.contact_names:
        law = result.contact_names.index(name)
        corners = points.force[last & (points.contact == law), 0]
        assert corners == pytest.approx(np.full(len(corners), corners.mean() if len(corners) else 0.0), rel=1e-5)


@pytest.mark.parametrize("stepper", [lf.MoreauJean(1e-3), lf.GeneralizedAlpha(1e-3)], ids=["mj", "ga"])
def test_neither_motion_nor_forces_depend_on_which_instants_are_stored(stepper: Any) -> None:
    """To the bit: least forces are sought in a pattern of their own, in memory of their own, and once."""
    duration = 0.06 if isinstance(stepper, lf.MoreauJean) else 0.01
    scene = brick_wall(5, 3, speed=3.0)
    often, seldom = (lf.simulate(scene, duration, stepper, record=each, progress=False) for each in (1e-3, 5e-3))
    assert often.size.max() > 3 * 60
    assert np.array_equal(often.q[::5], seldom.q)
    assert np.array_equal(often.u[::5], seldom.u)
    assert often.contact_names == seldom.contact_names
    assert np.array_equal(often.force[::5], seldom.force)


def made_exactly(run: Any, steps: int) -> None:
    target = run.steps + steps
    while run.steps < target:  # it returns now and then, as a clock has it
        assert run.advance(target - run.steps) == ""


def started(scene: lf.Scene, steps: int) -> Any:
    run: Any = lf.MoreauJean(1e-3).start(scene.compiled().system(), 1.0, 1.0)
    made_exactly(run, steps)
    return run


def test_what_was_posed_stays_as_it_was_while_sunk_contacts_are_lifted() -> None:
    stepping = started(stack(boxes=15), 3).method.stepping
    work = stepping.work
    assert work.rows.n_contacts > 50
    kept = [np.array(values) for values in (work.free.terms, work.free.v, work.impulses.p)]
    work.scratch.closed[:2], work.scratch.drift[:2] = (0, 5), -1e-6
    moved = np.zeros(len(work.free.u))
    assert lift_large_island(stepping.system.model, work, 0, 2, moved)
    assert np.abs(moved).max() > 1e-7
    for values, before in zip((work.free.terms, work.free.v, work.impulses.p), kept, strict=True):
        assert np.array_equal(values, before)
    assert work.free.terms[: work.rows.n_contacts].min() > 0.0


def test_joints_of_a_large_island_begin_with_the_impulses_of_the_step_before() -> None:
    """Boxes welded in pairs carry each other: at rest nothing is left to be solved."""
    scene = lf.Scene(gravity=(0.0, -WEIGHT))
    below: Any = scene.ground
    for k in range(24):
        box = scene.add(lf.Box(width=0.2, height=0.1, mass=1.0), name=f"box {k}", position=(0.0, 0.05 + 0.1 * k))
        if k % 2:
            scene.join(lf.Weld(below.at(0.0, 0.05), box.at(0.0, -0.05), name=f"weld {k}"))
        else:
            under = below.surface() if k else scene.ground.half_plane((0.0, 0.0), (0.0, 1.0))
            scene.contact(under, box.surface(), friction=0.5)
        below = box
    run = started(scene, 2)
    work = run.method.stepping.work
    assert work.rows.n_contacts > work.impulses.dense_limit
    for _ in range(5):
        made_exactly(run, 1)
        assert (work.impulses.large_solver.newton.factors, work.impulses.large_solver.search.sweeps) == (0, 0)
        assert work.impulses.large_solver.judged.residual <= 1e-9
    assert np.abs(run.method.stepping.scheme.u).max() < 1e-9


@pytest.mark.parametrize("friction", [0.5, 0.0])
def test_an_island_that_nothing_is_remembered_of_is_given_a_start(friction: float) -> None:
    """A wall at rest whose forces the compiled solver does not find from nothing, with a factor or none."""
    wall = brick_wall(courses=8, bricks=12, friction=friction)
    result = lf.simulate(wall, 0.02, lf.MoreauJean(1e-3, budget=1, on_unsolved="raise"), progress=False)
    assert result.size.max() > 2 * 128
    assert result.strict.max() <= 1e-8
    assert np.abs(result.q - result.q[0]).max() < 1e-9
    assert on_floor(result) == pytest.approx(8 * 12 * WEIGHT, rel=1e-6)
