"""A gap that jumps by more than the bodies could move is named where a run fails, or ends wrong, because of it."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import lcpflex as lf
from lcpflex.checks import measured_gaps
from lcpflex.checks.measured_gaps import GapsOfScene
from lcpflex.force_laws.elastic.hertz import Hertz

ADAPTIVE = lf.AdaptiveStep()
STEPPERS = [
    pytest.param(lf.MoreauJean(step=1e-3), id="moreau"),
    pytest.param(lf.EventDriven(), id="events"),
    pytest.param(lf.GeneralizedAlpha(step=1e-3), id="alpha"),
    pytest.param(lf.MoreauJean(step=1e-3, adaptive=ADAPTIVE), id="adaptive moreau", marks=pytest.mark.slow),
    pytest.param(lf.GeneralizedAlpha(step=1e-3, adaptive=ADAPTIVE), id="adaptive alpha", marks=pytest.mark.slow),
]


def behind_a_wall(scale: float = 1.0, by_rule: bool = False) -> lf.Scene:
    """A disc that slips past the end of a wall, which is one-sided, and is then inside it; without any force."""
    scene = lf.Scene(gravity=(0.0, 0.0))
    disc = scene.add(
        lf.Disc(0.05 * scale, mass=1.0), "disc", position=(-0.02 * scale, -0.06 * scale), velocity=(0.2 * scale, 0.0)
    )
    wall = scene.ground.chain([(scale, 0.0), (0.0, 0.0)])
    if by_rule:
        scene.contact_all(friction=0.3)
    else:
        scene.contact(disc.surface(), wall, friction=0.3, name="wall")
    return scene


def driven_behind_a_wall() -> lf.Scene:
    """The same, the disc driven, and slowly into the wall: no velocity meets drive and wall."""
    scene = lf.Scene(gravity=(0.0, 0.0))
    disc = scene.add(lf.Disc(0.05, mass=1.0), "disc", position=(-0.02, -0.06), velocity=(0.2, -0.01))
    there = scene.ground.at(-0.02, -0.06)
    for name, axis, speed in (("along", (1.0, 0.0), 0.2), ("into", (0.0, 1.0), -0.01)):
        motion = lambda t, speed=speed: (speed * t, speed, 0.0)  # noqa: E731
        scene.join(lf.DrivenDisplacement(disc.at(0, 0), there, motion, axis, name=name))
    scene.contact(disc.surface(), scene.ground.chain([(1.0, 0.0), (0.0, 0.0)]), name="wall")
    return scene


def own(jump: float, dimensions: int = 2, **more: Any) -> lf.UserSystem:
    """A point that slides along x on an outline which rises by ``jump`` at x = .1."""

    def gaps(q: Any) -> Any:
        return [q[-1] - (jump if q[0] > 0.1 else 0.0)]

    up = np.eye(dimensions)[:, -1:]
    across = np.eye(dimensions)[:, None, :-1] if dimensions > 2 else np.eye(2)[:, :1]
    weight, u = -9.81 * up[:, 0], np.eye(dimensions)[0]
    return lf.UserSystem(
        q=np.zeros(dimensions), u=u, mass=np.eye(dimensions), force=lambda t, q, u: weight, gaps=gaps, normals=up,
        tangents=across, names=("outline",), **more,
    )  # fmt: skip


def driven(jump: float, dimensions: int) -> lf.UserSystem:
    """The same, driven along x and slowly down."""
    way = np.eye(dimensions)[0] - 0.01 * np.eye(dimensions)[-1]
    made = own(jump, dimensions)
    return lf.UserSystem(
        q=0.01 * np.eye(dimensions)[-1], u=way, mass=made.mass, force=made.force, gaps=made.gaps,
        normals=made.normals, tangents=made.tangents, names=made.names,
        constraints=lambda t, q: q - 0.01 * np.eye(dimensions)[-1] - t * way, jacobian=lambda t, q: np.eye(dimensions),
        constraint_rate=lambda t, q: -way,
    )  # fmt: skip


def failure(scene: Any, duration: float, stepper: Any, **options: Any) -> str:
    with pytest.raises(lf.StepError) as caught:
        lf.simulate(scene, duration, stepper, progress=False, **options)
    return str(caught.value)


def doubts(scene: Any, duration: float, stepper: Any) -> list[str]:
    result = lf.simulate(scene, duration, stepper, progress=False)
    return [text for text in result.found_wrong if "jumps from" in text]


@pytest.mark.parametrize("stepper", STEPPERS)
def test_where_a_step_fails(stepper: Any) -> None:
    text = failure(driven_behind_a_wall(), 0.2, stepper)
    between = "'wall' between 'disc' and the ground"
    assert f"The gap of contact {between} jumps from more than 0.01 m to -0.111 m" in text
    assert "cannot be fulfilled" not in text  # the drive is not to blame
    assert "..." not in text


@pytest.mark.parametrize("dimensions", [2, 3])
@pytest.mark.parametrize("stepper", STEPPERS)
def test_where_a_function_of_the_user_jumps(stepper: Any, dimensions: int) -> None:
    text = failure(driven(0.05, dimensions), 0.2, stepper)
    assert "The gap of contact 'outline' jumps from 0.009 m to -0.041 m at t = 0.1" in text


@pytest.mark.parametrize("stepper", STEPPERS)
def test_a_run_that_goes_on_is_in_doubt(stepper: Any) -> None:
    """Without a drive nothing fails: the disc goes on inside of the wall, or is put outside."""
    (text,) = doubts(behind_a_wall(), 0.2, stepper)
    assert "contact 'wall' between 'disc' and the ground jumps from more than 0.01 m to -0.11 m at t = 0.1 s" in text


@pytest.mark.parametrize("scale", [1e-3, 1e3])
def test_in_other_units(scale: float) -> None:
    (text,) = doubts(behind_a_wall(scale), 0.2, lf.MoreauJean(step=1e-3))
    assert f"jumps from more than {0.01 * scale:.3g} m to {-0.11 * scale:.3g} m at t = 0.1 s" in text


def test_pairs_of_a_rule() -> None:
    (text,) = doubts(behind_a_wall(by_rule=True), 0.2, lf.MoreauJean(step=1e-3))
    assert "between 'disc' and the ground jumps" in text


@pytest.mark.parametrize("stepper", STEPPERS)
def test_an_outline_that_rises(stepper: Any) -> None:
    (text,) = doubts(own(0.05), 0.2, stepper)
    assert "contact 'outline' jumps from 0 m to -0.05 m at t = 0.1 s" in text


def test_an_outline_that_falls_away() -> None:
    """Time stepping falls after it; event-driven runs keep the contact closed, which is wrong."""
    assert not doubts(own(-0.05), 0.2, lf.MoreauJean(step=1e-3))
    (text,) = doubts(own(-0.05), 0.2, lf.EventDriven())
    assert "contact 'outline' jumps from 0 m to 0.05 m at t = 0.1 s" in text


def tip_behind_a_wall() -> lf.Scene:
    """A bar whose tip slips past the end of a wall, and is then inside it."""
    scene = lf.Scene(gravity=(0.0, 0.0))
    body = lf.Bar(1.0, 0.01, 1000.0, 1e7, elements=10).reduce(modes=None)
    bar = scene.add(body, "bar", position=(-0.9, -0.02), velocity=(0.0, 0.2))
    scene.contact(bar.node(1.0, 0.0), scene.ground.chain([(0.0, 1.0), (0.0, 0.0)]), name="wall")
    return scene


def test_a_massless_boundary() -> None:
    (text,) = doubts(tip_behind_a_wall(), 0.12, lf.MasslessBoundary(step=1e-4))
    between = "contact 'wall' between 'bar' and the ground"
    assert f"{between} jumps from more than 0.1 m to -0.1 m at t = 0.1 s" in text
    text = failure(tip_behind_a_wall(), 0.12, lf.MasslessBoundary(step=1e-3, substeps=False, safety=1.0))
    assert "too long for the system with the contacts that close now" in text
    assert f"The gap of {between} jumps from more than 0.1 m to -0.1 m at t = 0.1" in text


def test_a_law_beyond_its_range() -> None:
    scene = behind_a_wall()
    text = failure(scene, 0.2, lf.Smooth(lf.ContactLaw(elastic=Hertz(0.05, 1e6, 1e-2))))
    assert "its law is valid up to" in text
    assert "The gap of contact 'wall' between 'disc' and the ground jumps from more than 0.01 m" in text


def test_no_gap_is_named_that_only_bends() -> None:
    """A rough outline, of which a step passes two waves: its gap changes by more than slopes at both ends tell."""
    wave = 2e-3

    def gaps(q: Any) -> Any:
        return [q[1] - 0.01 * math.cos(2.0 * math.pi * q[0] / wave)]

    way = np.array([1.0, -0.1])
    system = lf.UserSystem(
        q=[0.0, 0.02], u=way, mass=np.eye(2), force=lambda t, q, u: np.zeros(2), gaps=gaps,
        normals=lambda q: np.array([[0.02 * math.pi / wave * math.sin(2.0 * math.pi * q[0] / wave)], [1.0]]),
        constraints=lambda t, q: q - [0.0, 0.02] - t * way, jacobian=lambda t, q: np.eye(2),
        constraint_rate=lambda t, q: -way,
    )  # fmt: skip
    for step in (0.51 * wave, 0.1 * wave):
        assert "jumps" not in failure(system, 0.5, lf.MoreauJean(step=step))


@pytest.mark.parametrize("space", [False, True], ids=["plane", "space"])
@pytest.mark.parametrize("speed", [1.0, 1e3])
def test_no_gap_is_named_where_none_jumps(space: bool, speed: float) -> None:
    """A drive pushes a body against a wall, and in a step of the fast one far into it."""
    if space:
        scene: Any = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
        box = scene.add(lf.Cuboid(0.1, 0.1, 0.1, mass=1.0), "box", velocity=(speed, 0.0, 0.0))
        wall, here, there = scene.ground.plane((0.06, 0, 0), (-1, 0, 0)), box.at(0, 0, 0), scene.ground.at(0, 0, 0)
        axis: Any = (1.0, 0.0, 0.0)
    else:
        scene = lf.Scene(gravity=(0.0, 0.0))
        box = scene.add(lf.Box(0.1, 0.1, mass=1.0), "box", velocity=(speed, 0.0))
        wall, here, there = scene.ground.half_plane((0.06, 0), (-1, 0)), box.at(0, 0), scene.ground.at(0, 0)
        axis = (1.0, 0.0)
    scene.contact(box.surface(), wall, name="wall")
    scene.join(lf.DrivenDisplacement(here, there, lambda t: (speed * t, speed, 0.0), axis, name="ram"))
    text = failure(scene, 0.1, lf.MoreauJean(step=1e-3))
    assert "was not solved" in text
    assert "jumps" not in text


def random_place(rng: np.random.Generator, in_space: bool) -> list[float]:
    turn = [*Rotation.random(rng=rng).as_quat(scalar_first=True)] if in_space else [rng.uniform(-4.0, 4.0)]
    return [*rng.uniform(-0.07, 0.07, 3 if in_space else 2), *turn]


@pytest.mark.parametrize("shapes", ["box-box", "disc-box", "Cuboid-Cuboid", "Cylinder-Cuboid", "Sphere-Capsule"])
def test_gaps_change_by_no_more_than_their_bodies_move(shapes: str) -> None:
    """Of bodies that are beside each other, or no farther inside than a run goes on with."""
    solids = {
        "box": lf.Box(0.1, 0.06, mass=1.0), "disc": lf.Disc(0.05, mass=1.0), "Sphere": lf.Sphere(0.05, mass=1.0),
        "Cuboid": lf.Cuboid(0.1, 0.08, 0.06, mass=1.0), "Cylinder": lf.Cylinder(0.05, 0.1, mass=1.0),
        "Capsule": lf.Capsule(0.03, 0.1, mass=1.0),
    }  # fmt: skip
    first, second = (solids[name] for name in shapes.split("-"))
    in_space = shapes[0].isupper()
    scene: Any = lf.SpatialScene(gravity=(0, 0, 0)) if in_space else lf.Scene(gravity=(0, 0))
    one, other = scene.add(first, "one"), scene.add(second, "other", position=(1.0, 1.0, 1.0)[: 3 if in_space else 2])
    scene.contact(one.surface(), other.surface(), name="pair")
    measured = GapsOfScene(scene.compiled())
    rng = np.random.default_rng(7)
    units = np.array([0.01, 0.01, 0.01, 0.1, 0.1, 0.1] * 2 if in_space else [0.01, 0.01, 0.1] * 2)
    seen = 0
    while seen < 40:
        q = np.array([*random_place(rng, in_space), *random_place(rng, in_space)])
        moved = measured.moved(q, units * rng.normal(size=len(units)), 1.0)
        before, after = measured.at(q).get(0, measured.beyond()), measured.at(moved).get(0, measured.beyond())
        if min(before, after) > -0.1 * measured.size and not before == after == measured.beyond():
            assert abs(after - before) <= measured.bound(0, q, moved) + measured.noise
            seen += 1


def test_runs_that_end_well_measure_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: Any) -> None:
        raise AssertionError("measured")

    monkeypatch.setattr(measured_gaps, "near", refuse)
    scene = lf.Scene(gravity=(0.0, -9.81))
    disc = scene.add(lf.Disc(0.05, mass=1.0), "disc", position=(0.0, 0.15), velocity=(1.0, 0.0))
    scene.contact(disc.surface(), scene.ground.half_plane((0, 0), (0, 1)), friction=0.3, restitution=0.5)
    for stepper in (lf.MoreauJean(step=1e-4), lf.GeneralizedAlpha(step=1e-4), lf.EventDriven()):
        assert not lf.simulate(scene, 0.4, stepper, progress=False).found_wrong
