"""Contact of reduced solids: cost at equal error against the whole mesh and Exudyn's penalties, and of a pair's step.

The scene of the comparison is a free aluminium bar that meets a fixed sphere of 20 mm with its middle at .4 m/s, with
144 contact nodes, of which about 32 close. What is compared:

- 20 free modes and static responses to normal forces at the contact nodes, massless and by Moreau and Jean's scheme;
- the unreduced mesh by Moreau and Jean's scheme;
- Exudyn's reduced body (ObjectFFRFreducedOrder) with the same matrices, basis and nodes, and penalty contact. Its own
  Hurty-Craig-Bampton basis has 432 static columns for these nodes, ours 144: it is given the cheaper one. With the free
  modes alone its steps are cheap, but then the penalty is all the local compliance there is: the best of some is told.

    error = max over time of |p - p_mesh| / p_mesh(end),   p: impulse up to then, of the mesh in converged steps

Of each contestant the run with least CPU time whose error is below 1 % counts. That time is of a whole ``simulate``
with its compilation and checks, but of Exudyn's solver alone; wall time of the steps alone is told besides.
"""

from __future__ import annotations

import importlib.util
import json
import subprocess
import sys
import time
from collections.abc import Callable, Mapping
from functools import cache, partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.bodies.fem.mesh import Mesh
from lcpflex.bodies.reduction.bases import loaded_basis
from lcpflex.jit.kernel import FloatArray
from tests.analytic.test_reduced_impact import ALUMINIUM, DURATION, GAP, RADIUS, SPEED
from tests.pressed_solids import grid_block

PEER = Path(__file__).parent / "peers" / "exudyn_bar.py"
MODES, PITCH = 20, 1.2e-4  # [m] between contact nodes
BOUND = 0.01
TIMES = np.linspace(0.0, DURATION, 301)
CONVERGED = 1e-7  # [s], of the reference
PAIR_STEP = 2e-7  # [s]; in twice of it generalised-alpha with friction on modes diverges, and says so
FIRST, LAST = 1e-5, 7e-5  # [s]: in between 25 to 33 nodes of the pair are closed
pytestmark = pytest.mark.filterwarnings("ignore::lcpflex.ModelWarning")


@cache
def bar(crown: float = 0.0) -> lf.Solid:
    """0.2 x 0.028 x 0.005 m on z = 0, of 4608 displacements. crown: radius of a bulge at the contact, 0: none."""
    near = PITCH * (np.arange(6) + 0.5)
    halves = [np.concatenate([near, far]) for far in ([1.1e-3, 3e-3, 9e-3, 0.03, 0.065, 0.1], [2e-3, 0.014])]
    lines = [*(np.concatenate([-half[::-1], half]) for half in halves), np.array([0.0, 2e-4, 1.2e-3, 5e-3])]
    mesh = grid_block("hexahedron", lines)
    nodes = np.flatnonzero((mesh.places[:, 2] == 0.0) & (np.abs(mesh.places[:, :2]).max(axis=1) < 6.0 * PITCH))
    if crown:
        places = mesh.places.copy()
        places[:, 2] += np.minimum((places[:, :2] ** 2).sum(axis=1), (10.0 * PITCH) ** 2) / (2.0 * crown)
        mesh = Mesh(mesh.kind, places, mesh.cells)
    return lf.Solid(mesh, sets={"contact": nodes}, **ALUMINIUM)


@cache
def reduced(rows: str = "normal", crown: float = 0.0) -> lf.SpatialBody:
    return bar(crown).reduce(MODES, contact="contact", rows=rows)


class Found(NamedTuple):
    """Of a run."""

    seconds: float  # CPU, of all of it
    marching: float  # wall time of the steps alone
    impulse: FloatArray  # at TIMES
    told: str

    def error(self, true: FloatArray) -> float:
        return float(np.abs(self.impulse - true).max() / true[-1])


def hit(body: lf.SpatialBody, stepper: Any, rounds: int = 4) -> Found:
    """The bar on the sphere; least times of some rounds."""
    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    placed = scene.add(body, "bar", body.origin, velocity=(0.0, 0.0, -SPEED))
    ball = scene.ground.sphere((0.0, 0.0, -RADIUS - GAP), RADIUS)
    scene.contact(placed.face("contact"), ball, points="nodes", name="hit")
    whole, marching = [], []
    for _ in range(rounds):
        began = time.process_time()
        result = lf.simulate(scene, DURATION, stepper, record=0.0, progress=False)
        whole.append(time.process_time() - began)
        marching.append(result.wall_time)
    impulse = np.interp(TIMES, result.times, result.impulse[:, 0, 0])
    return Found(min(whole), min(marching), impulse, f"{1e6 * stepper.step:g} us")


def cheapest(runs: list[Found], true: FloatArray) -> Found:
    return min((run for run in runs if run.error(true) < BOUND), key=lambda run: run.seconds)


def by_exudyn(path: Path, runs: list[tuple[int, float, float]]) -> list[Found]:
    mesh = bar().finite_elements()
    nodes = mesh.sets["contact"]
    loads = np.zeros((len(mesh.dofs), len(nodes)))
    loads[3 * nodes + 2, np.arange(len(nodes))] = 1.0
    (_, basis), _ = loaded_basis(mesh, loads, MODES, None)
    matrices = {"mass": mesh.mass.tocsr(), "stiffness": mesh.stiffness.tocsr()}
    parts = {f"{a}_{b}": getattr(matrix, b) for a, matrix in matrices.items() for b in ("data", "indices", "indptr")}
    given = {"radius": RADIUS, "gap": GAP, "speed": SPEED, "duration": DURATION}
    np.savez(path, places=mesh.places, basis=basis, contact=nodes, **parts, **given)
    every = [(basis.shape[1] if columns < 0 else columns, penalty, step) for columns, penalty, step in runs]
    command = [sys.executable, "-W", "ignore", str(PEER), str(path), json.dumps(every)]
    shown = subprocess.run(command, capture_output=True, text=True, check=True).stdout.splitlines()[-1]
    found = []
    for (_, penalty, step), run in zip(runs, json.loads(shown), strict=True):
        if run:  # its solver came to the end
            impulse = np.interp(TIMES, run["times"], run["impulse"])
            told = f"{1e6 * step:g} us, {penalty:.3g} N/m a node"
            found.append(Found(run["seconds"], run["seconds"], impulse, told))
    return found


def test_bar_on_a_sphere_at_equal_error_of_the_impulse(
    benchmark: Any, report: Callable[[str], None], tmp_path: Path
) -> None:
    whole = bar().reduce(None)
    of_mesh = [hit(whole, lf.MoreauJean(step=h), rounds=1) for h in (CONVERGED, 2.5e-7, 5e-7)]
    true = of_mesh[0].impulse
    assert of_mesh[1].error(true) < 0.1 * BOUND  # it has converged
    runs = {
        "massless": [hit(reduced(), lf.MasslessBoundary(step=h)) for h in (1e-6, 2e-6, 4e-6, 8e-6)],
        "Moreau-Jean": [hit(reduced(), lf.MoreauJean(step=h)) for h in (2.5e-7, 5e-7, 1e-6, 2e-6)],
        "unreduced mesh": of_mesh,
    }
    assert max(run.error(true) for run in runs["massless"]) < BOUND
    if importlib.util.find_spec("exudyn") is None:
        report("exudyn is not installed (pip install exudyn)")
    else:
        grid = [(-1, k, h) for k in (3e7, 1e8, 3e8) for h in (1e-6, 2e-6, 4e-6, 8e-6)]
        alone = [(MODES, k, 1e-6) for k in (5e5, 7e5, 1e6, 1.4e6, 2e6, 1e8)]
        made = by_exudyn(tmp_path / "scene.npz", grid + alone)
        runs["Exudyn, penalties"] = made[: -len(alone)]
        for run in made[-len(alone) :]:
            report(f"Exudyn with {MODES} modes alone: {run.told}, error {run.error(true):.3f}, {run.seconds:.3f} s")
    chosen = {name: cheapest(some, true) for name, some in runs.items()}
    least = chosen["massless"]
    for name, run in chosen.items():
        ratios = f"{run.seconds / least.seconds:7.1f} x massless, steps alone {run.marching / least.marching:7.1f} x"
        report(f"{name:18s} {run.told:24s} error {run.error(true):.4f}, CPU {run.seconds:.3f} s, {ratios}")
    benchmark.extra_info["CPU over massless"] = {name: run.seconds / least.seconds for name, run in chosen.items()}
    benchmark.extra_info["errors"] = {name: run.error(true) for name, run in chosen.items()}
    benchmark.pedantic(partial(hit, reduced(), lf.MasslessBoundary(step=4e-6), rounds=1), rounds=3)


def pair(friction: float) -> lf.SpatialScene:
    """A bar with a bulge falls onto a flat one: 20 modes and 144 nodes of each of them."""
    rows = "all" if friction else "normal"
    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    upper, lower = reduced(rows, RADIUS), reduced(rows)
    above = scene.add(upper, "above", upper.origin, velocity=(0.1 * SPEED if friction else 0.0, 0.0, -SPEED))
    place = [0.37 * PITCH, 0.37 * PITCH, -lower.origin[2] - GAP]  # no node is above another
    below = scene.add(lower, "below", place, np.diag([1.0, -1.0, -1.0]))
    scene.contact(above.face("contact"), below.face("contact"), friction=friction, points="nodes", name="hit")
    return scene


def seconds_per_step(scene: lf.SpatialScene, stepper: Any) -> float:
    """CPU of the whole step while the contact is closed: what a longer run takes more than a short one."""
    taken, steps = [], []
    for duration in (FIRST, LAST):
        began = time.process_time()
        result = lf.simulate(scene, duration, stepper, record=duration, progress=False)
        taken.append(time.process_time() - began)
        steps.append(result.steps)
    assert result.contact("hit").normal_force[-1].sum() > 0.0
    return float(np.diff(taken)[0] / np.diff(steps)[0])


@pytest.mark.parametrize("friction", [0.0, 0.3], ids=["frictionless", "cones"])
def test_pair_of_solids(interleave: Callable[..., Mapping[str, float]], friction: float) -> None:
    """CPU of a step; nothing is asserted but that they touch."""
    scene, kind = pair(friction), "cones" if friction else "frictionless"
    steppers = {
        "massless": lf.MasslessBoundary(step=PAIR_STEP),
        "Moreau-Jean": lf.MoreauJean(step=PAIR_STEP),
        "generalised-alpha": lf.GeneralizedAlpha(step=PAIR_STEP),
    }
    interleave(
        {f"pair, {kind}: {name}": partial(seconds_per_step, scene, made) for name, made in steppers.items()}, rounds=3
    )
