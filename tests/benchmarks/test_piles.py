"""Heaps, towers, walls, chains and strips: what a step costs beside body Gauss-Seidel and MuJoCo, and how it grows.

CPU time of one process, contestants one after the other in one run. MuJoCo's contacts give way: it solves another
problem, and has no residual of this one. ``python -m tests.benchmarks.pile_chart`` draws work against precision.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from lcpflex import gallery
from tests.benchmarks.peers import mujoco_piles
from tests.benchmarks.peers.body_gauss_seidel import Discs
from tests.benchmarks.piles import (
    FRICTION,
    STEP,
    FloatArray,
    Steps,
    box_of_discs,
    boxes_at,
    exponent,
    heap_of,
    own_steps,
    strict_of,
    sweeping_boxes,
    sweeping_steps,
    tower_of,
    wall_of,
)
from tests.benchmarks.settling import laid_to_rest

Report = Callable[[str], None]
TURNS = 20  # of laying a heap to rest, at most
SETTLING, RESTING = 800, 2400  # steps after which heaps of 30 to 100 settle, and lie


@pytest.fixture(autouse=True)
def _compiled() -> None:
    """Kernels of all contestants are there before a clock runs."""
    q, radius, width = heap_of(9)
    own_steps(box_of_discs(q, radius, width), 100)
    sweeping_steps(Discs(q, radius, width, FRICTION, STEP), 100)


def mujoco_of(bodies: list[dict[str, Any]], width: float | None, steps: int, skip: int = 0) -> Steps | None:
    """Steps of MuJoCo, where it is installed."""
    try:
        made = mujoco_piles.model(bodies, STEP, FRICTION, width)
    except ImportError:
        return None
    return Steps(mujoco_piles.seconds_of(made, skip + steps)[0][skip:])


def compared(report: Report, scene: str, contestants: dict[str, Steps | None]) -> None:
    """A line each, with the ratio of the means to that of lcpflex."""
    own = next(iter(contestants.values()))
    assert own is not None
    for name, steps in contestants.items():
        if steps is not None:
            report(f"{scene:28s} {name:16s} {steps.seconds.mean() / own.seconds.mean():7.2f} x  {steps}")


@pytest.mark.parametrize("count", [30, 100])
@pytest.mark.parametrize("build", [tower_of, wall_of])
def test_boxes_at_rest_are_solved_in_each_step(report: Report, build: Callable[[int], FloatArray], count: int) -> None:
    """To 1e-8 STRICT, from the first step on."""
    places = build(count)
    own = own_steps(boxes_at(places), 100)
    own.residual = strict_of(boxes_at(places), 100)
    sweeps: dict[str, Steps | None] = {f"{most} sweeps": sweeping_boxes(places, 100, most) for most in (40, 2000)}
    peer = mujoco_of(mujoco_piles.boxes(places, 0.2, 0.1), None, 100)
    compared(report, f"{build.__name__} {count}".replace("_", " "), {"lcpflex": own, **sweeps, "MuJoCo": peer})
    assert own.residual.max() <= 1e-8


@pytest.mark.parametrize(("count", "phase", "skip"), [
    (30, "settling", SETTLING), (30, "at rest", RESTING), (100, "settling", SETTLING), (100, "at rest", RESTING),
])  # fmt: skip
def test_heap(report: Report, count: int, phase: str, skip: int) -> None:
    """Means of 200 steps."""
    q, radius, width = heap_of(count)
    own = own_steps(box_of_discs(q, radius, width), 200, skip)
    own.residual = strict_of(box_of_discs(q, radius, width), skip + 200)[skip:]
    contestants: dict[str, Steps | None] = {"lcpflex": own}
    for most in (40, 2000):
        heap = Discs(q, radius, width, FRICTION, STEP)
        sweeping_steps(heap, skip, most=most)
        contestants[f"{most} sweeps"] = sweeping_steps(heap, 200, most=most)
    contestants["MuJoCo"] = mujoco_of(mujoco_piles.discs(q, radius), width, 200, skip)
    compared(report, f"heap of {count}, {phase}", contestants)
    assert np.median(own.residual) <= 1e-8


def test_heaps_at_rest_grow_slower_than_their_size_to_the_power_of_one_and_a_half(report: Report) -> None:
    """Laid to rest beforehand, with less friction, so that nothing is about to slide.

    The first step, which nothing is remembered for, is not one of those that count.
    """
    sizes = [100, 300, 1000]
    seconds = []
    for count in sizes:
        q, radius, width, _ = laid_to_rest(count, 0.8 * FRICTION, TURNS)
        scene = box_of_discs(q, radius, width)
        steps = own_steps(scene, 60, 5)
        steps.residual = strict_of(scene, 65)[5:]
        report(f"{f'heap of {count}, laid to rest':28s} lcpflex            {steps}")
        seconds.append(float(np.median(steps.seconds)))
        assert steps.residual.max() <= 1e-8
    slope = exponent(sizes, seconds)
    report(f"heaps at rest grow with size^{slope:.2f}")
    assert slope < 1.5


def test_chains_grow_with_their_links(report: Report) -> None:
    """In free flight and on a floor they have a factor without fill."""
    sizes = [30, 100, 300, 1000]
    seconds = []
    for links in sizes:
        steps = own_steps(gallery.link_chain(links, height=5.0), 100)
        report(f"{f'chain of {links}':28s} lcpflex            {steps}")
        seconds.append(float(np.median(steps.seconds)))
    slope = exponent(sizes[1:], seconds[1:])
    report(f"chains grow with links^{slope:.2f}")
    assert slope < 1.2


@pytest.mark.parametrize("name", ["Moreau-Jean", "event-driven"])
def test_independent_discs_cost_what_they_cost_alone(report: Report, name: str) -> None:
    stepper = lf.MoreauJean(step=STEP) if name == "Moreau-Jean" else lf.EventDriven(max_step=STEP)
    sizes, seconds = [30, 100, 300], []
    for count in sizes:
        scene = lf.Scene(gravity=(0.0, -9.81))
        floor = scene.ground.half_plane((0.0, 0.0), (0.0, 1.0))
        for k in range(count):
            disc = scene.add(lf.Disc(0.1, mass=1.0), name=f"disc {k}", position=(k, 0.1))
            scene.contact(disc.surface(), floor, friction=FRICTION)
        lf.simulate(scene, 5.0 * STEP, stepper, progress=False)
        run = stepper.start(scene.compiled().system(), 1e3, 1e3)
        assert not run.advance(20)
        began = time.process_time()
        assert not run.advance(200)
        seconds.append((time.process_time() - began) / 200.0)
        report(f"{f'{count} discs apart':28s} {name:16s} {1e3 * seconds[-1]:.4f} ms a step")
    slope = exponent(sizes, seconds)
    report(f"independent discs grow with number^{slope:.2f}, {name}")
    assert slope < 1.2


def test_strips(report: Report) -> None:
    """30 flexible strips of 8 modes that fall onto each other."""
    scene = gallery.strip_pile(30, modes=8)
    small = lf.MoreauJean(step=1e-4)
    steps = own_steps(scene, 50, 400, small)
    report(f"{'30 strips of 8 modes':28s} lcpflex            {steps}")
    result = lf.simulate(scene, 0.045, small, record=1e-3, progress=False)
    assert result.strict is not None
    report(f"{'':28s} STRICT median {np.nanmedian(result.strict):.0e}, largest {np.nanmax(result.strict):.0e}")
    assert np.nanmedian(result.strict) <= 1e-8
