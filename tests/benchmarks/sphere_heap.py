"""A loose heap of spheres in a box, on its way to rest: what a step costs, how it is solved, how far it overlaps.

    python -m tests.benchmarks.sphere_heap [SPHERES [FILE]]

The spheres fall and pile up, then roll to where they stay in damped steps with less friction, and are left to
themselves with the friction that they fell with; FILE (.npz) keeps places and velocities of the end. Spheres have no
resistance to rolling: some go on for many seconds, and whether the heap rests in the end differs from motion to motion.
"""

from __future__ import annotations

import sys
import time
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

import lcpflex as lf
from tests.benchmarks.sphere_chart import FRICTION, GRAVITY, MASS, RADIUS, STEP, loose, overlap, scene_of

TOLERANCE = 1e-6
PART = 100  # steps of a line of the table
FloatArray = NDArray[np.float64]


@dataclass
class Stage:
    """Steps of one kind."""

    name: str
    steps: int
    budget: int  # factors a step
    keep: float = 1.0  # of each speed after a step
    friction: float = FRICTION


STAGES = (
    Stage("falls, piles up", 1000, 2),
    Stage("damped", 1200, 2, 0.98, 0.4),
    Stage("damped", 300, 2, 0.9, 0.4),
    Stage("left to itself", 2000, 6),
)


def kinetic(u: FloatArray) -> float:
    """Kinetic energy [J]."""
    return float(0.5 * MASS * (np.sum(u[:, :3] ** 2) + 0.4 * RADIUS**2 * np.sum(u[:, 3:] ** 2)))


class Heap:
    """Places and velocities, from stage to stage."""

    def __init__(self, count: int) -> None:
        self.places, self.width = loose(count)
        self.q: FloatArray | None = None
        self.u: FloatArray | None = None

    def start(self, stage: Stage) -> Any:
        """A run of lcpflex that goes on from where the heap is."""
        scene = scene_of(self.places, self.width, stage.friction)
        stepper = lf.MoreauJean(step=STEP, solver_tolerance=TOLERANCE, budget=stage.budget)
        run = stepper.start(scene.compiled().system(), 1e3, 1e3)
        if self.q is not None:
            run.method.stepping.scheme.q[:] = self.q
            run.method.stepping.scheme.u[:] = self.u
        return run

    def go_through(self, stage: Stage) -> None:
        """All steps of a stage, and a line of the table for each PART."""
        run = self.start(stage)
        milliseconds = []
        for k in range(stage.steps):
            began = time.process_time()
            trouble = run.advance(1)
            milliseconds.append(1e3 * (time.process_time() - began))
            assert not trouble, trouble
            stepping = run.method.stepping
            stepping.scheme.u[:] *= stage.keep
            if (k + 1) % PART == 0:
                self.q, self.u = np.array(stepping.scheme.q), np.array(stepping.scheme.u)
                counts = run.records.recorder.counts
                self.tell(stage, k + 1, milliseconds[-PART:], counts, stepping.work)
                counts.unsolved, counts.worst_relative = 0.0, 0.0

    def tell(self, stage: Stage, k: int, ms: list[float], counts: Any, work: Any) -> None:
        """A line of the table; the residual is the worst of all certificates of the part."""
        assert self.q is not None
        assert self.u is not None
        places, u = self.q.reshape(-1, 7)[:, :3], self.u.reshape(-1, 6)
        solved = f"STRICT up to {counts.worst_relative:.0e}, {counts.unsolved:.0f} unsolved"
        sunk = f"overlap {overlap(places, self.width):.1e} m"
        left = f"{kinetic(u):.1e} J, {np.abs(u[:, :3]).max():.0e} m/s"
        spent = f"{np.median(ms):6.1f} ms, worst {max(ms):5.0f}"
        print(f"{stage.name:16s} {k:5d}: {spent}; {work.n_contacts} contacts, {solved}; {sunk}, {left}", flush=True)


def main(count: int = 1000, path: str = "") -> None:
    """All stages."""
    heap = Heap(count)
    print(f"{count} spheres of {MASS} kg, {RADIUS} m, g = {GRAVITY} m/s^2, box {heap.width:.2f} m wide")
    for stage in STAGES:
        heap.go_through(stage)
        if path:
            np.savez(path, q=heap.q, u=heap.u, width=heap.width)


if __name__ == "__main__":
    main(*(kind(value) for kind, value in zip((int, str), sys.argv[1:], strict=False)))
