"""A loose heap of spheres in a box, at rest and left to itself: what a step costs, how it is solved, what moves.

    python -m tests.benchmarks.sphere_heap [SPHERES [SEEDS [STEPS]]]

Radii are scattered by a tenth. The heap has come to rest in :mod:`tests.benchmarks.settling_spheres`, with less
friction than the run has. That knows no forces: its first steps find them, and some spheres, wedged between others
by forces that it does not find, roll on. They stop by kinetic damping (the velocity of a sphere goes to zero when its
speed falls), in the same run. Then it goes on as it is, undamped; nothing but its contacts holds a sphere.

A contact counts as closed up to a gap of g h^2, by which a sphere falls in a step. With gaps of rounding alone what
parts by a residual has no contact for a step, and falls: where a step is not solved, hundreds do, and the heap moves.
"""

from __future__ import annotations

import sys
import time
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

import lcpflex as lf
from tests.benchmarks.peers.spheres import GRAVITY, walls
from tests.benchmarks.settling_spheres import RADIUS, laid_to_rest

STEP, FRICTION, LESS = 1e-3, 0.5, 0.3  # LESS: friction of laying to rest
TOLERANCE = 1e-6
CLOSED = GRAVITY * STEP**2  # gap [m]
REST, CALM, MOST = 1e-6, 20, 4000  # speed of what rests [m/s], for so many steps; of at most MOST
KEPT = 0.95  # of the speed of a sphere that gets faster
FloatArray = NDArray[np.float64]


def box_of(places: FloatArray, radii: FloatArray, width: float) -> lf.SpatialScene:
    """Spheres of one density in a box that is open above; the largest has 1 kg."""
    scene = lf.SpatialScene(gravity=(0.0, 0.0, -GRAVITY))
    for place, normal in walls(width):
        scene.ground.plane(place, normal)
    for place, radius in zip(places, radii, strict=True):
        scene.add(lf.Sphere(radius, mass=(radius / RADIUS) ** 3), position=place)
    scene.contact_all(friction=FRICTION)
    return scene


@dataclass
class Rest:
    """What steps of a heap at rest cost [ms], how they were solved, and how far it moved."""

    ms: FloatArray
    strict: float  # worst
    unsolved: int
    contacts: int
    fastest: float  # [m/s], of a sphere with its surface, in all steps
    moved: float  # [m]

    def __str__(self) -> str:
        middle, most = np.percentile(self.ms, (50, 95))
        spent = f"{middle:.1f} ms, p95 {most:.1f}, worst {self.ms.max():.1f}"
        solved = f"STRICT up to {self.strict:.1e}, {self.unsolved} of {len(self.ms)} not solved"
        return f"{spent}; {self.contacts} contacts, {solved}; up to {self.fastest:.0e} m/s, moved {self.moved:.0e} m"


class Heap:
    """A run of spheres in a box."""

    def __init__(self, count: int, seed: int) -> None:
        places, self.radii, width, self.left = laid_to_rest(count, LESS, seed)
        stepper = lf.MoreauJean(step=STEP, solver_tolerance=TOLERANCE, gap_tolerance=CLOSED)
        self.run: Any = stepper.start(box_of(places, self.radii, width).compiled().system(), 1e3, 1e3)

    @property
    def places(self) -> FloatArray:
        """Of the centres."""
        return np.array(self.run.method.stepping.scheme.q).reshape(-1, 7)[:, :3]

    def speeds(self) -> FloatArray:
        """Of each sphere, |v| + r |omega| [m/s]."""
        u = np.array(self.run.method.stepping.scheme.u).reshape(-1, 6)
        return np.asarray(np.linalg.norm(u[:, :3], axis=1) + self.radii * np.linalg.norm(u[:, 3:], axis=1))

    def step(self) -> float:
        """One step; its CPU time [ms]."""
        began = time.process_time()
        trouble = self.run.advance(1)
        spent = time.process_time() - began
        assert not trouble, trouble
        return 1e3 * spent

    def stop(self) -> int:
        """Kinetic damping until nothing is faster than REST; in how many steps, -1 if something goes on."""
        last, calm = np.zeros(len(self.radii)), 0
        for k in range(MOST):
            self.step()
            now = self.speeds()
            slower = now < last
            u = self.run.method.stepping.scheme.u
            u[:] *= np.repeat(np.where(slower, 0.0, KEPT), 6)
            last = np.where(slower, 0.0, now)
            calm = calm + 1 if now.max() < REST else 0
            if calm == CALM:
                return k + 1
        return -1

    def rest(self, steps: int) -> Rest:
        """So many steps, left to itself."""
        counts = self.run.records.recorder.counts
        counts.unsolved, counts.worst_relative = 0.0, 0.0
        start, ms, fastest = self.places, np.zeros(steps), 0.0
        for k in range(steps):
            ms[k] = self.step()
            fastest = max(fastest, self.speeds().max())
        contacts = int(self.run.method.stepping.work.rows.n_contacts)
        moved = float(np.abs(self.places - start).max())
        return Rest(ms, float(counts.worst_relative), int(counts.unsolved), contacts, fastest, moved)


def main(count: int = 1000, seeds: int = 3, steps: int = 1000) -> None:
    """A line for each seed."""
    for seed in range(1, seeds + 1):
        began = time.process_time()
        heap = Heap(count, seed)
        laid = time.process_time() - began
        taken = heap.stop()
        print(
            f"{count} spheres, seed {seed}: laid to rest in {laid:.0f} s (up to {heap.left:.0e} m/s left), "
            f"stopped in {taken} steps"
        )
        print(f"    {heap.rest(steps)}", flush=True)


if __name__ == "__main__":
    main(*(int(value) for value in sys.argv[1:]))
