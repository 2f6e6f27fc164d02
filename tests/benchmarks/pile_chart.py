"""Work against precision of a heap that falls into its box: lcpflex, body Gauss-Seidel, MuJoCo.

    python -m tests.benchmarks.pile_chart [DISCS [STEPS [FILE]]]

All start from the same places at rest and make the same number of steps of 1 ms. What is measured needs no more than
their places and velocities: the largest overlap of two discs or of a disc and the box, and the energy that is lost,
against that of a run with a quarter of the step. The residual (STRICT) belongs to methods that solve the same problem;
MuJoCo, whose contacts give way, has none. Where a contestant is to the left of and below lcpflex, it is ahead.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import lcpflex as lf
from tests.benchmarks.peers import mujoco_piles
from tests.benchmarks.peers.body_gauss_seidel import Discs
from tests.benchmarks.piles import (
    FRICTION,
    GRAVITY,
    STEP,
    FloatArray,
    box_of_discs,
    heap_of,
    overlap,
    own_steps,
    sweeping_steps,
)

FACTORS = (1, 5, 20, 100, 600)
SWEEPS = (10, 40, 160, 640)


@dataclass
class Point:
    """One run of a contestant."""

    name: str
    milliseconds: float
    overlap: float  # [m]
    lost: float  # [J]
    residual: float  # median of the steps


def energy(q: FloatArray, u: FloatArray, radius: FloatArray) -> float:
    """Kinetic and potential, of discs of 1 kg [J]."""
    return float(np.sum(0.5 * (u[:, 0] ** 2 + u[:, 1] ** 2) + 0.25 * (radius * u[:, 2]) ** 2 + GRAVITY * q[:, 1]))


def of_lcpflex(q: FloatArray, radius: FloatArray, width: float, steps: int, factors: int, h: float = STEP) -> Point:
    """With a budget of so many factors a step."""
    scene, stepper = box_of_discs(q, radius, width), lf.MoreauJean(step=h, budget=factors)
    count = round(steps * STEP / h)
    seconds = own_steps(scene, count, stepper=stepper).seconds
    result = lf.simulate(scene, steps * STEP, stepper, record=STEP, progress=False)
    ends = [[values[-1].reshape(-1, 3) for values in (result.q, result.u)]]
    places = result.q.reshape(len(result.times), -1, 3)
    worst = max(overlap(place, radius, width) for place in places[::10])
    lost = energy(q, 0.0 * q, radius) - energy(*ends[0], radius)
    assert result.strict is not None
    touched = result.strict[result.size > 0]
    return Point(f"{factors}", 1e3 * float(seconds.mean()), worst, lost, float(np.median(touched)))


def of_sweeps(q: FloatArray, radius: FloatArray, width: float, steps: int, most: int) -> Point:
    """With at most so many sweeps a step."""
    heap, worst, taken, left = Discs(q, radius, width, FRICTION, STEP), 0.0, [], []
    for _ in range(0, steps, 10):
        found = sweeping_steps(heap, 10, most=most)
        taken.append(found.seconds)
        left.append(found.residual)
        worst = max(worst, overlap(heap.q, radius, width))
    lost = energy(q, 0.0 * q, radius) - energy(heap.q, heap.u, radius)
    residual = np.concatenate(left)
    return Point(f"{most}", 1e3 * float(np.mean(taken)), worst, lost, float(np.median(residual[residual > 0.0])))


def of_mujoco(q: FloatArray, radius: FloatArray, width: float, steps: int, parts: int, stiff: bool) -> Point:
    """With so many steps in one, and contacts as stiff as these allow or as by default; time of them all."""
    h = STEP / parts
    constant = 2.0 * h if stiff else 0.02
    made = mujoco_piles.model(mujoco_piles.discs(q, radius), h, FRICTION, width, constant)
    data, taken, worst = None, [], 0.0
    for _ in range(0, steps, 10):
        seconds, data = mujoco_piles.seconds_of(made, 10 * parts, data)
        taken.append(parts * seconds.mean())
        worst = max(worst, overlap(data.qpos.reshape(-1, 3) + q, radius, width))
    assert data is not None
    lost = energy(q, 0.0 * q, radius) - energy(data.qpos.reshape(-1, 3) + q, data.qvel.reshape(-1, 3), radius)
    name = ("stiff" if stiff else "default") + (f", {parts} parts" if parts > 1 else "")
    return Point(name, 1e3 * float(np.mean(taken)), worst, lost, float("nan"))


def main(count: int = 100, steps: int = 500, path: str = "pile_chart.png") -> None:
    """Run, print a table and draw."""
    q, radius, width = heap_of(count)
    q[:, 2] = 0.0
    sweeping_steps(Discs(q, radius, width, FRICTION, STEP), 200, most=4)  # compiles
    own_steps(box_of_discs(q, radius, width), 200)
    exact = of_lcpflex(q, radius, width, steps, 600, STEP / 4.0)
    series = {
        "lcpflex, factors a step": [of_lcpflex(q, radius, width, steps, factors) for factors in FACTORS],
        "body Gauss-Seidel, sweeps a step": [of_sweeps(q, radius, width, steps, most) for most in SWEEPS],
    }
    try:
        series["MuJoCo"] = [
            of_mujoco(q, radius, width, steps, parts, stiff)
            for parts, stiff in ((1, False), (1, True), (4, True), (10, True))
        ]
    except ImportError:
        print("MuJoCo is not installed (pip install mujoco)")
    print(f"a quarter of the step: {exact.lost:.2f} J lost, overlap {exact.overlap:.1e} m")
    figure = Figure(figsize=(12, 4), layout="constrained")
    axes = figure.subplots(1, 3)
    for label, points in series.items():
        for point in points:
            lost = f"energy lost {point.lost:8.2f} J ({point.lost / exact.lost - 1.0:+.1%})"
            solved = f"STRICT {point.residual:.0e}, overlap {point.overlap:.1e} m"
            print(f"{label:34s} {point.name:16s} {point.milliseconds:8.3f} ms, {solved}, {lost}")
        time = [point.milliseconds for point in points]
        off = [max(abs(point.lost / exact.lost - 1.0), 1e-5) for point in points]
        for place, values in zip(axes, ([p.residual for p in points], [p.overlap for p in points], off), strict=True):
            place.loglog(time, values, "o-", label=label)
            for x, y, point in zip(time, values, points, strict=True):
                place.annotate(point.name, (x, y), fontsize=7)
    for place, title in zip(
        axes, ("median residual, STRICT", "largest overlap [m]", "error of the energy lost"), strict=True
    ):
        place.set(xlabel="CPU time of a step [ms]", ylabel=title)
    axes[0].legend(fontsize=8)
    figure.suptitle(f"{count} discs fall into a box, {steps} steps of {1e3 * STEP:g} ms")
    figure.savefig(Path(path), dpi=120)


if __name__ == "__main__":
    main(*(kind(value) for kind, value in zip((int, int, str), sys.argv[1:], strict=False)))
