"""Makes a run of one scene for each line of input, and prints the seconds of processor time that a step has taken.

Or, of two graphs, the seconds that one corner takes of the time for their distance; or those of a solve by sweeps over
contacts in the plane or in space.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from functools import partial

import numpy as np
import scipy.sparse

import lcpflex as lf
from lcpflex import gallery
from lcpflex.solvers import BlockGaussSeidel, ContactProblem, SpatialContactProblem
from lcpflex.studies import graph_distance


def pressed_solid(friction: float = 0.0) -> lf.SpatialScene:
    """A steel block of 20 modes whose 49 nodes below ring on a plane that 10^4 times its weight drives it to."""
    steel = {"density": 7800.0, "youngs_modulus": 2.1e11, "poissons_ratio": 0.3}
    solid = lf.Solid.box((0.02, 0.02, 0.01), elements=(6, 6, 2), **steel)
    rows = "all" if friction else "normal"
    scene = lf.SpatialScene(gravity=(0.0, 0.0, -1e5))
    block = scene.add(solid.reduce(20, contact="bottom", rows=rows), "block", position=(0.0, 0.0, 0.005))
    scene.contact(block.surface(), scene.ground.plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0)), friction=friction)
    return scene


SCENES: dict[str, tuple[Callable[[], lf.Scene | lf.SpatialScene], float, object]] = {
    "pendulum": (gallery.pendulum, 0.6, lf.MoreauJean(step=1e-5)),
    "incline": (gallery.block_on_incline, 1.0, lf.MoreauJean(step=2e-5)),
    "bar": (lambda: gallery.elastic_bar(elements=30), 1.5, lf.MoreauJean(step=1e-4)),
    "event_driven": (gallery.stick_slip_block, 1.9, lf.EventDriven(max_step=1e-3)),
    "generalized_alpha": (gallery.pendulum, 0.6, lf.GeneralizedAlpha(step=2e-5)),
    "solid": (pressed_solid, 8e-4, lf.MoreauJean(step=4e-7)),
    "rough_solid": (partial(pressed_solid, 0.3), 4e-4, lf.MoreauJean(step=4e-7)),
}
GRAPHS = {"late_wave": 200.5, "near_wave": 200.0}  # half a turn behind at the end; the same, one part in 1e5 apart
CORNERS = 20_001


def distance(frequency: float) -> None:
    """Answer with the seconds a corner for the distance of a wave to another."""
    t = np.linspace(0.0, 1.0, CORNERS)
    one, other = np.sin(200.0 * t), np.sin(frequency * t) + 1e-5
    graph_distance(t[:9], one[:9], t[:9], other[:9])
    for _ in sys.stdin:
        began = time.process_time()
        graph_distance(t, one, t, other)
        print((time.process_time() - began) / CORNERS, flush=True)


def contacts(kind: str, count: str, storage: str) -> None:
    """Answer with the seconds of a solve of so many contacts, of bodies that each touch some others."""
    random, n, rows = np.random.default_rng(1), int(count), 2 if kind == "plane" else 3
    factor = scipy.sparse.random_array((rows * n, 3 * n), density=min(1.0, 12.0 / n), rng=random, format="csr")
    factor = scipy.sparse.csr_array(scipy.sparse.hstack([scipy.sparse.eye_array(rows * n), factor]))
    matrix = None if storage == "factor" else factor @ factor.T
    matrix = matrix.toarray() if storage == "dense" else matrix
    free, friction = random.standard_normal(rows * n), np.full(n, 0.4)
    make = ContactProblem if rows == 2 else SpatialContactProblem
    repeats = 1 + 2000 // n
    for _ in sys.stdin:
        began = time.process_time()
        for _ in range(repeats):
            BlockGaussSeidel().solve(make(matrix, free, friction, factor=factor if matrix is None else None))
        print((time.process_time() - began) / repeats, flush=True)


def main() -> None:
    if sys.argv[1].count(" ") == 2:
        contacts(*sys.argv[1].split())
        return
    if sys.argv[1] in GRAPHS:
        distance(GRAPHS[sys.argv[1]])
        return
    build, duration, stepper = SCENES[sys.argv[1]]
    lf.simulate(build(), duration, stepper, record=duration, progress=False)
    for _ in sys.stdin:
        scene = build()
        began = time.process_time()
        result = lf.simulate(scene, duration, stepper, record=duration, progress=False)
        print((time.process_time() - began) / result.steps, flush=True)


main()
