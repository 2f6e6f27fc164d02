"""Work against precision on the contact problems of spheres that fall into a box: lcpflex, Siconos.

    python -m tests.benchmarks.cone_chart [SPHERES [FILE [STEP ...]]]

A run of lcpflex hands over the largest problem of each of the steps named, with the forces of the step before, from
which all contestants begin. Judged are the forces that they find, by one residual (STRICT: of the free velocity); CPU
time is that of the solver alone, from the problem in rows by body (lcpflex) and with the Delassus matrix made, by
blocks (Siconos). Siconos runs in an interpreter of its own, SICONOS_PYTHON.
"""

from __future__ import annotations

import json
import math
import os
import pickle
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray
from scipy.sparse import csr_matrix

import lcpflex as lf
import lcpflex.steppers.time_stepping as time_stepping
from lcpflex.solvers.contact.algebra import IN_SPACE
from lcpflex.solvers.contact.judging import judge
from lcpflex.solvers.contact.large.memory import large_memory
from lcpflex.solvers.contact.large.solving import ROOM, pack, solve_large
from lcpflex.solvers.contact.operators.sparse_factor import widen
from tests.benchmarks.sphere_chart import loose, scene_of

PEER = Path(__file__).parent / "peers" / "siconos_cones.py"
PYTHON = os.environ.get("SICONOS_PYTHON", "/usr/bin/python3")  # Debian's package serves the system's interpreter
STEP, TOLERANCE = 1e-3, 1e-9
BUDGETS = (1, 5, 20, 100)  # of lcpflex: factors
SWEEPS = (10, 40, 160, 640, 2560)  # of Siconos' Gauss-Seidel
FloatArray = NDArray[np.float64]


@dataclass
class Point:
    """What a contestant makes of all problems with one bound."""

    name: str
    milliseconds: FloatArray
    strict: FloatArray


def recorded(count: int, steps: Sequence[int], budget: int) -> list[tuple[Any, dict[str, int], int]]:
    """Of each step the largest problem with its slips and the sizes of its memory, from a run with that budget."""
    kept: dict[int, bytes] = {}
    largest: dict[int, int] = {}
    now = [0]

    def keep(problem: Any, memory: Any, like: Any) -> int:
        if now[0] in steps and problem.n_contacts > largest.get(now[0], 0):
            sizes = {"bodies": len(memory.local), "width": memory.op.J.shape[3]}
            largest[now[0]] = problem.n_contacts
            kept[now[0]] = pickle.dumps((problem, sizes, len(memory.scale)))
        return int(solve_large(problem, memory, like))

    hooks = time_stepping.solver_hooks
    time_stepping.solver_hooks = lambda *given: {**hooks(*given), solve_large: keep}
    try:
        places, width = loose(count)
        stepper = lf.MoreauJean(step=STEP, solver_tolerance=1e-6, budget=budget)
        run = stepper.start(scene_of(places, width).compiled().system(), 1e3, 1e3)
    finally:
        time_stepping.solver_hooks = hooks
    for k in range(max(steps) + 1):
        now[0] = k
        trouble = run.advance(1)
        assert not trouble, trouble
    return [pickle.loads(kept[k]) for k in sorted(kept)]


def solved(problem: tuple[Any, dict[str, int], int], budget: int) -> tuple[float, float]:
    """Milliseconds and residual of lcpflex, the order of the elimination found anew."""
    rows, sizes, units = problem
    memory = large_memory(sizes["bodies"], units, sizes["bodies"], sizes["width"], 3)
    memory.judged.tolerance, memory.search.factor_limit, memory.search.operation_limit = TOLERANCE, budget, math.inf
    start, slip, room = rows.p.copy(), rows.slip.copy(), True
    while room:
        rows.p[:] = start
        rows.slip[:] = slip
        memory.op.factor.known = 0
        began = time.process_time()
        room = solve_large(rows, memory, IN_SPACE) == ROOM
        spent = time.process_time() - began
        if room:
            widen(memory.op.factor)
    rows.p[:] = start
    return 1e3 * spent, float(memory.judged.strict)


def packed(problem: tuple[Any, dict[str, int], int]) -> Any:
    """The problem in units."""
    rows, sizes, units = problem
    memory = large_memory(sizes["bodies"], units, sizes["bodies"], sizes["width"], 3)
    pack(rows, memory, IN_SPACE)
    return memory


def delassus(memory: Any) -> csr_matrix:
    """J J^T of a problem in units, by blocks."""
    n, width = memory.group.n, memory.op.J.shape[3]
    row, column, value = [], [], []
    for side in range(2):
        k = np.flatnonzero(memory.op.body[:n, side] >= 0)
        at = memory.op.pos[memory.op.body[k, side]]
        row.append(np.broadcast_to(3 * k[:, None, None] + np.arange(3)[:, None], (len(k), 3, width)).ravel())
        column.append(np.broadcast_to(at[:, None, None] + np.arange(width), (len(k), 3, width)).ravel())
        value.append(memory.op.J[k, side].ravel())
    shape = (3 * n, memory.op.n_unknowns)
    J = csr_matrix((np.concatenate(value), (np.concatenate(row), np.concatenate(column))), shape)
    blocks = (J @ J.T).tobsr(blocksize=(3, 3))
    blocks.sort_indices()
    return blocks


def of_siconos(problems: list[Any]) -> dict[str, list[Point]]:
    """All its methods; empty where it is not installed."""
    stored: dict[str, FloatArray] = {}
    memories = [packed(problem) for problem in problems]
    for i, memory in enumerate(memories):
        n = memory.group.n
        G, s = delassus(memory), memory.scale[:n]
        pairs = s[np.repeat(np.arange(n), np.diff(G.indptr))] * s[G.indices]
        stored |= {f"first_{i}": G.indptr, f"column_{i}": G.indices, f"block_{i}": G.data / pairs[:, None, None]}
        stored |= {f"q_{i}": (memory.group.free[:n] / s[:, None]).ravel(), f"mu_{i}": memory.group.mu[:n]}
        stored[f"start_{i}"] = (memory.group.p[:n] * s[:, None]).ravel()
    with tempfile.TemporaryDirectory() as folder:
        np.savez(Path(folder) / "problems.npz", **stored)
        command = [PYTHON, str(PEER), str(Path(folder) / "problems.npz"), *map(str, SWEEPS)]
        clean = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
        try:
            out = subprocess.run(command, capture_output=True, text=True, check=True, env=clean).stdout
        except (OSError, subprocess.CalledProcessError):
            print(f"no siconos in {PYTHON} (Debian: apt install python3-siconos; or set SICONOS_PYTHON)")
            return {}
    points: dict[str, list[Point]] = {}
    runs: dict[tuple[str, int], list[tuple[float, float]]] = {}
    for found in json.loads(out.strip().rsplit("\n", 1)[-1]):
        memory = memories[found["problem"]]
        n = memory.group.n
        memory.group.p[:n] = np.reshape(found["force"], (n, 3)) / memory.scale[:n, None]
        strict = judge(memory.op, memory.group, memory.judged, memory.group.p, IN_SPACE) / memory.judged.load
        runs.setdefault((found["method"], found["bound"]), []).append((1e3 * found["seconds"], strict))
    for (method, bound), pairs_of in runs.items():
        spent, strict = np.transpose(pairs_of)
        points.setdefault(f"Siconos, {method}", []).append(Point(str(bound), spent, strict))
    return points


def main(count: int = 128, path: str = "cone_chart.png", *steps: int) -> None:
    """Record, run, print a table and draw."""
    problems = recorded(count, steps or (200, 300, 400, 500, 600, 700, 800), 20 if count < 500 else 2)
    sizes = [problem[0].n_contacts for problem in problems]
    print(f"{len(problems)} problems of {sizes} contacts")
    solved(problems[0], 1)  # compiles
    series = {"lcpflex": []}
    for budget in BUDGETS:
        spent, strict = np.transpose([solved(problem, budget) for problem in problems])
        series["lcpflex"].append(Point(str(budget), spent, strict))
    series |= of_siconos(problems)
    figure = Figure(figsize=(7, 5), layout="constrained")
    axes = figure.subplots()
    for label, points in series.items():
        for p in points:
            print(
                f"{label:18s} {p.name:5s} {np.median(p.milliseconds):9.2f} ms, STRICT {np.median(p.strict):.0e}", end=""
            )
            print(f", worst {p.strict.max():.0e}; " + " ".join(f"{r:.0e}" for r in p.strict), flush=True)
        x, y = [np.median(p.milliseconds) for p in points], [np.median(p.strict) for p in points]
        axes.loglog(x, y, "o-", label=label)
        for p, a, b in zip(points, x, y, strict=True):
            axes.annotate(p.name, (a, b), fontsize=7, xytext=(3, 3), textcoords="offset points")
    axes.set(xlabel="CPU time of a problem, median [ms]", ylabel="residual, STRICT, median")
    axes.set_title(f"contact problems of {count} spheres that fall into a box")
    axes.legend(fontsize=8)
    figure.savefig(Path(path), dpi=120)


if __name__ == "__main__":
    arguments = sys.argv[1:]
    main(*(kind(value) for kind, value in zip((int, str), arguments, strict=False)), *map(int, arguments[2:]))
