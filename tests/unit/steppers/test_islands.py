"""Independent bodies move as each would alone, and cost what each costs alone; islands join and part."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.steppers.run import Run

STEPPERS: dict[str, Any] = {
    "Moreau-Jean": lf.MoreauJean(1e-3),
    "generalised-alpha": lf.GeneralizedAlpha(1e-3),
    "event-driven": lf.EventDriven(),
    "adaptive Moreau-Jean": lf.MoreauJean(1e-3, adaptive=lf.AdaptiveStep(rtol=1e-3)),
}


def bouncing(count: int, order: int = 1, restitution: float = 0.5) -> lf.Scene:
    """Discs far from each other, each thrown at the floor with spin."""
    scene = lf.Scene(gravity=(0.0, -9.81))
    floor = scene.ground.half_plane((0.0, 0.0), (0.0, 1.0))
    for k in range(count)[::order]:
        disc = scene.add(
            lf.Disc(0.1, mass=1.0 + k), name=f"disc {k}", position=(k, 0.15), velocity=(1.0, -1.0),
            angular_velocity=-30.0,
        )  # fmt: skip
        scene.contact(disc.surface(), floor, friction=0.3, restitution=restitution, name=f"contact {k}")
    return scene


def started(scene: lf.Scene, stepper: Any) -> Any:
    run: Run = stepper.start(scene.compiled().system(), 10.0, 10.0)
    return run


@pytest.mark.parametrize("stepper", STEPPERS)
def test_bodies_far_apart_move_as_each_alone(stepper: str) -> None:
    """To the bit under steps of one length; error control sees all bodies, and steps with the worst of them."""
    alone = lf.simulate(bouncing(1), 0.3, STEPPERS[stepper], progress=False)
    for count in (2, 25):  # more than the tables hold at first
        several = lf.simulate(bouncing(count), 0.3, STEPPERS[stepper], progress=False)
        first = several.q[-1, :3]
        if stepper in ("Moreau-Jean", "generalised-alpha"):
            assert np.array_equal(first, alone.q[-1])
        assert first == pytest.approx(alone.q[-1], abs=1e-3 if "adaptive" in stepper else 1e-7)
        assert several.q[-1, 3:6] - [1.0, 0.0, 0.0] == pytest.approx(first, abs=1e-9)


@pytest.mark.parametrize("stepper", STEPPERS)
def test_the_order_in_which_bodies_are_added_does_not_matter(stepper: str) -> None:
    forth = lf.simulate(bouncing(5), 0.2, STEPPERS[stepper], progress=False)
    back = lf.simulate(bouncing(5, -1), 0.2, STEPPERS[stepper], progress=False)
    assert forth.q[-1].reshape(5, 3) == pytest.approx(back.q[-1].reshape(5, 3)[::-1], abs=1e-9)


def test_problems_are_those_of_islands() -> None:
    """Forty discs on the floor are forty problems; the memory of a dense problem does not grow with them."""
    run = started(bouncing(40, restitution=0.0), lf.MoreauJean(1e-3))
    assert run.advance(200) == ""
    work = run.method.stepping.work
    assert work.posed.islands.count == work.rows.n_contacts == 40
    assert len(work.posed.problem.friction) == 16
    assert work.impulses.solver.M.shape == (48, 48)


def bridge(held: bool, drive: Callable[[float], float] | None = None) -> lf.Scene:
    """Two boxes on a plank above the floor: free on two posts, or held by the ground."""
    scene = lf.Scene(gravity=(0.0, -9.81))
    plank = scene.add(lf.Box(width=2.0, height=0.1, mass=5.0), name="plank", position=(0.0, 0.05))
    if held:
        scene.join(lf.Weld(plank.at(0.0, 0.0), scene.ground.at(0.0, 0.05), name="weld"))
    else:
        scene.contact(plank.surface(), scene.ground.half_plane((0.0, 0.0), (0.0, 1.0)), friction=0.5, name="floor")
    for k, x in enumerate((-0.7, 0.7)):
        box = scene.add(lf.Box(width=0.2, height=0.2, mass=1.0), name=f"box {k}", position=(x, 0.2))
        scene.contact(box.surface(), plank.surface(), friction=0.5, name=f"box {k} on plank")
    return scene


@pytest.mark.parametrize("held", [False, True])
def test_a_body_joins_what_stands_on_it_unless_the_ground_holds_it(held: bool) -> None:
    run = started(bridge(held), lf.MoreauJean(1e-3))
    assert run.advance(50) == ""
    assert run.method.stepping.work.posed.islands.count == (2 if held else 1)
    result = lf.simulate(bridge(held), 0.2, lf.MoreauJean(1e-3), progress=False)
    assert np.abs(result.q - result.q[0]).max() < 1e-9
    names = list(result.contact_names)
    for k in range(2):
        assert result.force[-1, names.index(f"box {k} on plank"), 0] == pytest.approx(9.81, rel=1e-9)


@pytest.mark.parametrize("stepper", ["Moreau-Jean", "generalised-alpha", "event-driven"])
def test_islands_join_and_part(stepper: str) -> None:
    """A ball falls between two discs at rest, touches both, and is thrown up again: momentum is what gravity gives."""
    scene = lf.Scene(gravity=(0.0, -9.81))
    floor = scene.ground.half_plane((0.0, 0.0), (0.0, 1.0))
    discs = [
        scene.add(lf.Disc(0.1, mass=1.0), name=f"disc {k}", position=(x, 0.1)) for k, x in enumerate((-0.12, 0.12))
    ]
    ball = scene.add(lf.Disc(0.05, mass=0.5), name="ball", position=(0.0, 0.4), velocity=(0.0, -1.0))
    for k, disc in enumerate(discs):
        scene.contact(disc.surface(), floor, friction=0.3, name=f"floor {k}")
        scene.contact(ball.surface(), disc.surface(), friction=0.3, restitution=0.8, name=f"ball {k}")
    result = lf.simulate(scene, 0.4, STEPPERS[stepper], progress=False)
    left, right = result.q[-1, :3], result.q[-1, 3:6]
    assert left[0] == pytest.approx(-right[0], abs=1e-6)  # it stays symmetric, though nothing asks for it
    assert result.u[-1, 6] == pytest.approx(0.0, abs=1e-6)
    names = list(result.contact_names)
    normal = sum(result.impulse[-1, names.index(f"floor {k}"), 0] for k in range(2))
    momentum = 1.0 * (result.u[-1, 1] + result.u[-1, 4]) + 0.5 * result.u[-1, 7]
    assert momentum == pytest.approx(-0.5 + normal - 2.5 * 9.81 * 0.4, abs=1e-9)
    assert abs(left[0]) > 0.121  # they were pushed apart


def bars(count: int) -> lf.Scene:
    """Elastic bars dropped on the floor side by side."""
    scene = lf.Scene(gravity=(0.0, -9.81))
    floor = scene.ground.half_plane((0.0, 0.0), (0.0, 1.0))
    for k in range(count):
        body = lf.Bar(1.0, 1e-4, 7800.0, 2e9, elements=4).reduce(modes=None)
        bar = scene.add(body, name=f"bar {k}", position=(k, 0.01), angle=0.5 * np.pi)
        scene.contact(bar.node(0.0, 0.0), floor, name=f"foot {k}")
    return scene


def test_many_bars_under_a_massless_boundary() -> None:
    """More contacts than the tables hold at first."""
    alone, many = (lf.simulate(bars(n), 0.06, lf.MasslessBoundary(), record=0.01, progress=False) for n in (1, 20))
    assert alone.impulse[-1, 0, 0] > 0.0
    assert many.impulse[-1, :, 0] == pytest.approx(np.full(20, alone.impulse[-1, 0, 0]), rel=1e-6)
