"""Work against precision of spheres that fall into a box in space: lcpflex, MuJoCo, Drake, Siconos.

    python -m tests.benchmarks.sphere_chart [SPHERES [STEPS [FILE]]]

All start from the same places at rest, and are at the same instants where they are compared. What is measured needs no
more than places and velocities: the largest overlap of two spheres or of one and the box, and the energy that is lost,
against that of lcpflex with a quarter of the step (of large heaps: half of it). The residual (STRICT) belongs to the
method that solves the problem of rigid contacts; those of MuJoCo and Drake give way, and Siconos has another residual
(see cone_chart). Who is to the left of and below another is ahead of it. Siconos runs in an interpreter of its own,
SICONOS_PYTHON.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

import lcpflex as lf
from tests.benchmarks.peers.spheres import GRAVITY, MASS, Drake, MuJoCo, walls

STEP, RADIUS, FRICTION = 1e-3, 0.05, 0.5
BUDGETS = ((1, 1), (5, 1), (20, 1), (100, 1), (20, 4))  # of lcpflex: factors a step, and steps in STEP
LARGE = 500  # spheres: above, fewer runs
LARGE_BUDGETS = ((1, 1), (5, 1), (1, 4))
EVERY = 10  # steps between two looks
PEER = Path(__file__).parent / "peers" / "siconos_spheres.py"
PYTHON = os.environ.get("SICONOS_PYTHON", "/usr/bin/python3")  # Debian's package serves the system's interpreter


@dataclass
class Point:
    """One run of a contestant."""

    name: str
    milliseconds: float  # CPU time of STEP
    overlap: float  # [m]
    lost: float  # [J]
    residual: float  # median of the steps


def loose(count: int) -> tuple[NDArray[np.float64], float]:
    """Places of spheres that are apart by a fifth of their radius at least, and the width of the box."""
    side = round((count / 2.0) ** (1.0 / 3.0))
    rng, pitch = np.random.default_rng(7), 2.4 * RADIUS
    grid = np.array([(x, y, z) for z in range(count) for y in range(side) for x in range(side)][:count], dtype=float)
    return pitch * (grid + 0.5) + rng.uniform(-0.1, 0.1, (count, 3)) * RADIUS, side * pitch


def scene_of(places: NDArray[np.float64], width: float, friction: float = FRICTION) -> lf.SpatialScene:
    """The same for lcpflex."""
    scene = lf.SpatialScene(gravity=(0.0, 0.0, -GRAVITY))
    for place, normal in walls(width):
        scene.ground.plane(place, normal)
    for place in places:
        scene.add(lf.Sphere(RADIUS, mass=MASS), position=place)
    scene.contact_all(friction=friction)
    return scene


def overlap(places: NDArray[np.float64], width: float) -> float:
    """The largest one [m]."""
    near = cKDTree(places).query_pairs(2.0 * RADIUS, output_type="ndarray")
    pairs = 2.0 * RADIUS - np.linalg.norm(places[near[:, 0]] - places[near[:, 1]], axis=1)
    sides = np.concatenate([RADIUS - (places - np.array(p)) @ np.array(n) for p, n in walls(width)])
    return float(max(pairs.max(initial=0.0), sides.max(), 0.0))


def energy(places: NDArray[np.float64], v: NDArray[np.float64], omega: NDArray[np.float64]) -> float:
    """Kinetic and potential [J]."""
    turning = 0.4 * RADIUS**2 * np.sum(omega**2)
    return float(MASS * (0.5 * (np.sum(v**2) + turning) + GRAVITY * np.sum(places[:, 2])))


def of_lcpflex(places: NDArray[np.float64], width: float, steps: int, budget: int, parts: int = 1) -> Point:
    """With so many factors a step, and so many steps in STEP."""
    stepper = lf.MoreauJean(step=STEP / parts, budget=budget)
    began = time.process_time()
    result = lf.simulate(scene_of(places, width), steps * STEP, stepper, record=EVERY * STEP, progress=False)
    seconds = time.process_time() - began - result.compile_time
    q = result.q.reshape(len(result.times), -1, 7)
    u = result.u[-1].reshape(-1, 6)
    worst = max(overlap(one[:, :3], width) for one in q)
    lost = energy(places, 0.0 * places, 0.0 * places) - energy(q[-1, :, :3], u[:, :3], u[:, 3:])
    assert result.strict is not None
    touched = result.strict[result.size > 0]
    name = f"{budget}" + (f", {parts} parts" if parts > 1 else "")
    return Point(name, 1e3 * seconds / steps, worst, lost, float(np.median(touched)))


def of_peer(peer: Any, name: str, places: NDArray[np.float64], width: float, steps: int, parts: int) -> Point:
    """With so many steps in one of lcpflex."""
    worst, seconds = 0.0, 0.0
    for _ in range(0, steps, EVERY):
        seconds += peer.advance(EVERY * parts)
        worst = max(worst, overlap(peer.state()[0], width))
    lost = energy(places, 0.0 * places, 0.0 * places) - energy(*peer.state())
    return Point(name, 1e3 * seconds / steps, worst, lost, float("nan"))


def of_siconos(places: NDArray[np.float64], width: float, steps: int, sweeps: int) -> Point | None:
    """Its own Moreau-Jean steps with so many sweeps of Gauss-Seidel; None where it is not installed."""
    points, normals = zip(*walls(width), strict=True)
    with tempfile.TemporaryDirectory() as folder:
        file = str(Path(folder) / "scene.npz")
        np.savez(
            file, places=places, radius=RADIUS, friction=FRICTION, step=STEP, gravity=GRAVITY, points=points,
            normals=normals,
        )  # fmt: skip
        clean = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
        command = [PYTHON, str(PEER), file, str(steps), str(EVERY), str(sweeps), "1e-9"]
        try:
            out = subprocess.run(command, capture_output=True, text=True, check=True, env=clean).stdout
        except (OSError, subprocess.CalledProcessError):
            return None
    found = json.loads(out.strip().rsplit("\n", 1)[-1])
    states = np.array(found["states"])
    worst = max(overlap(state[:, :3], width) for state in states)
    last = states[-1]
    lost = energy(places, 0.0 * places, 0.0 * places) - energy(last[:, :3], last[:, 3:6], last[:, 6:])
    return Point(f"{sweeps} sweeps", 1e3 * found["seconds"] / steps, worst, lost, float("nan"))


def of_mujoco(places: NDArray[np.float64], width: float, steps: int, parts: int, stiff: bool) -> Point:
    """As it comes, or with contacts as stiff as its step allows."""
    h = STEP / parts
    made = MuJoCo(places, RADIUS, width, FRICTION, h, 2.0 * h if stiff else 0.02)
    name = ("stiff" if stiff else "default") + (f", {parts} parts" if parts > 1 else "")
    return of_peer(made, name, places, width, steps, parts)


def of_drake(places: NDArray[np.float64], width: float, steps: int, parts: int) -> Point:
    """With so many steps in one of lcpflex."""
    made = Drake(places, RADIUS, width, FRICTION, STEP / parts)
    return of_peer(made, f"{parts} parts" if parts > 1 else "SAP", places, width, steps, parts)


def contestants(places: NDArray[np.float64], width: float, steps: int) -> Iterator[tuple[str, Point]]:
    """The points of each that is installed, as they are found."""
    large = len(places) > LARGE
    for budget in LARGE_BUDGETS if large else BUDGETS:
        yield "lcpflex, factors a step", of_lcpflex(places, width, steps, *budget)
    try:
        for parts, stiff in ((1, False), (1, True), (4, True), (10, True)):
            yield "MuJoCo", of_mujoco(places, width, steps, parts, stiff)
    except ImportError:
        print("MuJoCo is not installed (pip install mujoco)")
    for sweeps in () if large else (25, 100, 400):  # a step of 1000 spheres takes it seconds, most of them elsewhere
        point = of_siconos(places, width, steps, sweeps)
        if point is None:
            print(f"no siconos in {PYTHON} (Debian: apt install python3-siconos; or set SICONOS_PYTHON)")
            break
        yield "Siconos", point
    try:
        for parts in (1,) if large else (1, 4):
            yield "Drake", of_drake(places, width, steps, parts)
    except ImportError:
        print("Drake is not installed (pip install drake)")


def main(count: int = 128, steps: int = 400, path: str = "sphere_chart.png") -> None:
    """Run, print a table and draw."""
    places, width = loose(count)
    of_lcpflex(places, width, 150, 5)  # compiles
    exact = of_lcpflex(places, width, steps, *((5, 2) if count > LARGE else (600, 4)))
    print(
        f"the reference: {exact.lost:.2f} J lost, overlap {exact.overlap:.1e} m, {exact.residual:.0e} STRICT",
        flush=True,
    )
    series: dict[str, list[Point]] = {}
    for label, point in contestants(places, width, steps):
        series.setdefault(label, []).append(point)
        lost = f"energy lost {point.lost:8.2f} J ({point.lost / exact.lost - 1.0:+.1%})"
        solved = f"STRICT {point.residual:.0e}, overlap {point.overlap:.1e} m"
        print(f"{label:26s} {point.name:16s} {point.milliseconds:8.3f} ms, {solved}, {lost}", flush=True)
    from matplotlib.figure import Figure  # tests take runs from here, and no chart
    from matplotlib.ticker import NullFormatter

    figure = Figure(figsize=(13, 4.5), layout="constrained")
    axes = figure.subplots(1, 3)
    for label, points in series.items():
        spent = [point.milliseconds for point in points]
        off = [max(abs(point.lost / exact.lost - 1.0), 1e-5) for point in points]
        for place, values in zip(axes, ([p.residual for p in points], [p.overlap for p in points], off), strict=True):
            place.loglog(spent, values, "o-", label=label)
            for x, y, point in zip(spent, values, points, strict=True):
                place.annotate(point.name, (x, y), fontsize=7, xytext=(3, 3), textcoords="offset points")
    titles = ("median residual, STRICT", "largest overlap [m]", "error of the energy lost")
    for place, title in zip(axes, titles, strict=True):
        place.set(xlabel="CPU time of 1 ms of motion [ms]", ylabel=title)
        place.xaxis.set_minor_formatter(NullFormatter())
    axes[1].legend(fontsize=8)
    figure.suptitle(f"{count} spheres fall into a box, {steps} ms")
    figure.savefig(Path(path), dpi=120)


if __name__ == "__main__":
    main(*(kind(value) for kind, value in zip((int, int, str), sys.argv[1:], strict=False)))
