"""What equilibrium() refuses, what a place of rest tells, and that units do not matter."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.statics.refinement import sets_of
from lcpflex.statics.shared_forces import shared_forces
from tests.scenes import box_on_floor, disc_on_floor, disc_on_spring, floor_of


def driven(rate: float) -> lf.Scene:
    scene = lf.Scene(gravity=(0.0, 0.0))
    arm = scene.add(lf.Box(1.0, 0.1, mass=1.0), "arm", position=(0.5, 0.0))
    scene.join(lf.Revolute(arm.point("left"), scene.ground.at(0.0, 0.0), name="hinge"))
    scene.join(lf.DrivenAngle(arm.point("left"), scene.ground.at(0.0, 0.0), lf.Harmonic(0.3, rate / 0.3), name="cam"))
    return scene


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"scene": 3}, "scene: 3 was given, expected a Scene"),
        ({"initial": 3}, "initial: 3 was given, expected a Result or a Rest"),
        ({"farthest": 0.0}, "farthest: 0.0 was given"),
        ({"time": math.nan}, "time: nan was given"),
        ({"budget": 0.0}, "budget: 0.0 was given"),
        ({"scene": driven(2.0)}, "joint 'cam': its drive moves at t = 0 with 2 a second"),
        ({"scene": disc_on_floor(law=lf.Penalty(1e5))}, "contacts by a force law .'floor'., expected rigid contacts"),
        ({"scene": disc_on_floor(height=0.05)}, "its surfaces penetrate by 0.05 m at the start"),
    ],
)
def test_refused(given: dict[str, Any], words: str) -> None:
    with pytest.raises(lf.ModelError, match=words):
        lf.equilibrium(**{"scene": disc_on_floor(), **given})


def test_a_place_of_other_bodies_is_refused() -> None:
    """As a start of a path, and of a run."""
    box = lf.equilibrium(box_on_floor())
    with pytest.raises(lf.ModelError, match="initial: a state of the bodies 'box' was given"):
        lf.equilibrium(disc_on_floor(), initial=box)
    with pytest.raises(lf.ModelError, match=r"initial: a Rest with the coordinates box \(3\) was given"):
        lf.simulate(disc_on_floor(), 0.01, lf.MoreauJean(1e-3), initial=box)


def test_a_drive_that_stands() -> None:
    """Its torque holds a weight."""
    scene = driven(0.0)
    scene.load(lf.Force(scene.body("arm").point("right"), (0.0, -3.0)))
    rest = lf.equilibrium(scene)
    assert rest.joint("cam").moment == pytest.approx(3.0, rel=1e-12)
    assert rest.joint("hinge").force == pytest.approx([0.0, 3.0], abs=1e-12)


def test_asked_for_what_is_not_there() -> None:
    rest = lf.equilibrium(box_on_floor(friction=0.3))
    for ask in (
        lambda: rest.contact("flor"),
        lambda: rest.joint(3),  # type: ignore[arg-type]
        lambda: rest.point("bx", "center"),
        lambda: rest.point("box", "centre"),
        lambda: rest.contact("floor").on("bo"),
    ):
        with pytest.raises(lf.ModelError, match=r"expected|no "):
            ask()
    assert rest.point("box", "center") == pytest.approx([0.0, 0.1], abs=1e-12)
    assert rest.contact("floor").on("ground") == pytest.approx([0.0, -9.81])
    for words in ("contact 'floor': stick, 9.81 N in 2 places", "stable", "least norm", "1 dimension"):
        assert words in str(rest)


def test_an_open_contact_bears_nothing() -> None:
    scene = disc_on_spring(100.0)
    scene.contact(scene.body("disc").surface(), scene.ground.half_plane((0.0, -5.0), (0.0, 1.0)), name="far")
    rest = lf.equilibrium(scene)
    assert rest.contact("far").state == "open"
    assert not rest.contact("far").on("disc").any()
    assert math.hypot(*rest.point("disc", "center")) == pytest.approx(1.0, rel=1e-9)


def test_touching_without_a_force() -> None:
    scene = disc_on_floor(gravity=0.0)
    rest = lf.equilibrium(scene)
    assert rest.contact("floor").states == ("touch",)
    assert rest.contact("floor").normal == pytest.approx([0.0])
    assert len(rest.neutral) == 3
    assert rest.stable


def test_from_a_result() -> None:
    """The path begins where a run ended."""
    scene = disc_on_floor(friction=0.3, velocity=(1.0, 0.0))
    run = lf.simulate(scene, 0.1, lf.MoreauJean(1e-3), progress=False)
    rest = lf.equilibrium(scene, initial=run)
    assert rest.q[0] == pytest.approx(run.q[-1, 0])
    assert run.q[-1, 0] > 0.05


@pytest.mark.parametrize("unit", [1e-3, 1e3])
def test_units_do_not_matter(unit: float) -> None:
    """A box that tips over on a floor, in metres and in other lengths: the same path, step by step."""

    def tipped(length: float) -> lf.Rest:
        scene = lf.Scene(gravity=(0.0, -9.81 * length))
        box = scene.add(lf.Box(0.4 * length, 0.2 * length, mass=2.0), "box", position=(0.0, 0.5 * length), angle=0.4)
        scene.contact(box.surface(), floor_of(scene), friction=0.3, name="floor")
        return lf.equilibrium(scene)

    one, other = tipped(1.0), tipped(unit)
    assert other.steps == one.steps
    assert other.q[:2] == pytest.approx(one.q[:2] * unit, rel=1e-6, abs=1e-6 * unit)
    assert other.contact("floor").normal == pytest.approx(one.contact("floor").normal * unit, rel=1e-6)


def test_loads_by_python_functions_of_the_state() -> None:
    """Their stiffness counts: a spring that is a function."""
    scene = lf.Scene(gravity=(0.0, 0.0))
    disc = scene.add(lf.Disc(0.1, mass=1.0), "disc", position=(0.3, 0.0))
    scene.load(lf.Force(disc.point("center"), lambda t, s: (-50.0 * (s.q[0] - 0.1) - 3.0, 2.0 - 20.0 * s.q[1])))
    rest = lf.equilibrium(scene)
    assert rest.point("disc", "center") == pytest.approx([0.04, 0.1], rel=1e-12)
    assert rest.stable
    assert len(rest.neutral) == 1


def test_a_scene_off_its_joints_is_assembled() -> None:
    """By equilibrium() and by the run that begins there."""
    scene = lf.Scene(gravity=(0.0, -9.81))
    bar = scene.add(lf.Box(1.0, 0.1, mass=1.0), "bar", position=(0.55, 0.03))
    scene.join(lf.Revolute(bar.point("left"), scene.ground.at(0.0, 0.0), name="hinge"))
    rest = lf.equilibrium(scene)
    assert rest.point("bar", "left") == pytest.approx([0.0, 0.0], abs=1e-12)
    result = lf.simulate(scene, 0.01, lf.MoreauJean(1e-3), progress=False, initial=rest)
    assert np.abs(result.q - rest.q).max() < 1e-12


def test_an_unstable_start_is_told() -> None:
    scene = lf.Scene(gravity=(0.0, -9.81))
    bar = scene.add(lf.Box(1.0, 0.1, mass=1.0), "bar", position=(0.0, 0.5), angle=0.5 * math.pi)
    scene.join(lf.Revolute(bar.point("left"), scene.ground.at(0.0, 0.0)))
    rest = lf.equilibrium(scene)
    result = lf.simulate(scene, 0.01, lf.MoreauJean(1e-3), progress=False, initial=rest)
    assert "not stable: 'bar' turns" in result.notes[-1]


def test_shared_forces_against_all_corners() -> None:
    """The least norm of a box on four frictional points, one of them held by a wall: no other set has less."""
    from lcpflex.statics.balance import Balance
    from lcpflex.statics.scales import scales_of

    scene = lf.Scene(gravity=(3.0, -9.81))
    box = scene.add(lf.Box(0.4, 0.2, mass=2.0), "box", position=(0.0, 0.1))
    scene.contact(box.surface(), floor_of(scene), friction=0.2)
    scene.contact(box.node(0.2, -0.05), scene.ground.half_plane((0.2, 0.0), (-1.0, 0.0)), friction=0.5)
    compiled = scene.compile()
    balance = Balance(compiled)
    at = balance.look(compiled.q.copy(), 1e-3)
    scales = scales_of(balance.model, at.q, compiled.size)
    same = np.full(len(at.q), 20.0)
    found = shared_forces(at, scales, at.gap < 1e-9, np.ones(len(at.rows)), 20.0, lambda p: same)
    assert found is not None
    n = at.n_contacts
    assert at.rows.T @ found.p == pytest.approx(-at.force, abs=1e-9)
    rng = np.random.default_rng(1)
    sets = sets_of(at, np.ones(n, bool), np.zeros(n), np.ones(n, bool))
    null = np.linalg.svd(sets.push.T)[2][3:]
    tried = 0
    for scale in (1e-4, 1e-2, 1.0):
        for y in scale * rng.normal(size=(2000, len(null))):
            p = found.p + sets.spread @ (y @ null)
            if (p[:n] >= 0.0).all() and (np.abs(p[n:]) <= at.friction * p[:n]).all():
                tried += 1
                assert np.linalg.norm(p) >= np.linalg.norm(found.p) * (1.0 - 1e-9)
    assert tried > 10


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"bodies": ("disc", "ball")}, r"bodies.1.: no body 'ball'"),
        ({"bodies": 3}, "bodies: 3 was given"),
        ({"reach": -1.0}, "reach: -1.0 was given"),
        ({"most": 0}, "most: 0 was given"),
    ],
)
def test_refused_by_equilibria(given: dict[str, Any], words: str) -> None:
    with pytest.raises(lf.ModelError, match=words):
        lf.equilibria(disc_on_floor(), **given)


def test_too_large_or_too_slow() -> None:
    """More coordinates than dense matrices are for, and a search whose time is up, are named with their numbers."""
    scene = lf.Scene()
    for k in range(1334):
        scene.add(lf.Disc(0.1, mass=1.0), position=(0.3 * k, 0.0))
    with pytest.raises(lf.ModelError, match="scene: it has 4002 coordinates, expected at most 4000"):
        lf.equilibrium(scene)
    message = r"within budget = 1e-06 s and 0 steps .unbalanced 1 of.*: 3 coordinates and 0 near contacts"
    with pytest.raises(lf.SolverError, match=message):
        lf.equilibrium(disc_on_floor(height=1.0), budget=1e-6)


def test_overlaps_of_a_run_are_closed_in_steps() -> None:
    """Ten discs in a column, each a millimetre in the next: together more than the path may go in a step."""
    scene = lf.Scene()
    below = floor_of(scene)
    for k in range(10):
        disc = scene.add(lf.Disc(0.02, mass=1.0), position=(0.0, 0.02 + 0.04 * k))
        scene.load(lf.Spring(disc.point("center"), scene.ground.at(0.0, 0.5), 10.0, length=0.0))
        scene.contact(disc.surface(), below, friction=0.3)
        below = disc.surface()
    run = lf.simulate(scene, 1e-3, lf.MoreauJean(1e-3), progress=False)
    sunk = run.q.copy()
    sunk[-1, 1::3] -= 1e-3 * np.arange(1, 11)
    rest = lf.equilibrium(scene, initial=replace(run, q=sunk))
    assert rest.q[1::3] == pytest.approx(0.02 + 0.04 * np.arange(10), abs=1e-9)
