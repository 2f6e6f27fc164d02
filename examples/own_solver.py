"""Bring your own solver: a loop written by hand, quantecon's Lemke and daqp, judged beside those of the library.

A solver is any function of (M, q) that returns z with 0 <= z _|_ M z + q >= 0. Here it is projected Gauss-Seidel in ten
lines, Lemke's algorithm of quantecon, which is such a function as it stands, and the quadratic program that daqp solves
(each of these two only where it is installed). The hand-written one drives a run of its own: a stack of four boxes is
pushed at 0.2 m/s without friction, `MoreauJean(solver=sweep)`. Then all of them solve the contact problems of that run.

The lesson: the library lends each solver copies and judges what comes back on the original numbers, so that a function
that stops too early is told, not believed. `hasty`, the same loop with three sweeps, returns a point for every problem,
and none of them is a solution: it stands last in the key of the chart, and in a run it would stop at its first wrong
step, with a sentence. Where a solver may hang, `cross_check(..., time_limit=)` runs it in a process that can be killed.
"""

from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

import lcpflex as lf
from lcpflex.solvers import UserSolver, replay
from lcpflex.solvers.benchmark.files import load_problems


def sweep(M: np.ndarray, q: np.ndarray, most: int = 20_000) -> np.ndarray:
    """Projected Gauss-Seidel, until nothing moves any more."""
    z = np.zeros_like(q)
    for _ in range(most):
        before = z.copy()
        for i in range(len(q)):
            z[i] = max(0.0, z[i] - (M[i] @ z + q[i]) / M[i, i])
        if np.abs(z - before).max() <= 1e-14 * np.abs(z).max():
            break
    return z


def by_daqp(daqp: Any, M: np.ndarray, q: np.ndarray) -> np.ndarray:
    """min 1/2 z.M z + q.z with z >= 0, whose conditions of optimality are the problem."""
    n = len(q)
    found = daqp.solve(M, q, np.eye(n), np.full(n, 1e30), np.zeros(n))
    return np.asarray(found[0])


def solvers() -> dict[str, Any]:
    """By hand, in haste, the library's own, and those of other packages that are installed."""
    found: dict[str, Any] = {
        "sweep (by hand)": sweep,
        "hasty (3 sweeps)": UserSolver(partial(sweep, most=3), takes="arrays"),
        "Auto": lf.Auto(),
        "Lemke": lf.Lemke(),
    }
    try:
        found["quantecon"] = import_module("quantecon.optimize").lcp_lemke
    except ImportError:
        print("quantecon is not installed, and left out: pip install quantecon")
    try:
        found["daqp"] = partial(by_daqp, import_module("daqp"))
    except ImportError:
        print("daqp is not installed, and left out: pip install daqp")
    return found


def stack() -> lf.Scene:
    scene = lf.Scene(gravity=(0.0, -9.81))
    for k in range(4):
        box = lf.Box(width=0.2, height=0.1, mass=1.0 + k)
        speed = 0.2 if k == 0 else 0.0
        scene.add(box, name=f"box {k + 1}", position=(0.01 * k, 0.05 + 0.1 * k), velocity=(speed, 0.0))
    scene.ground.half_plane((0.0, 0.0), (0.0, 1.0))
    scene.contact_all()
    return scene


def run(folder: Path = Path()) -> lf.Result:
    """The run by the hand-written solver, and the comparison as a table, a chart and a line for each problem."""
    path = folder / "problems_of_own_solver.npz"
    result = lf.simulate(
        stack(), 0.05, lf.MoreauJean(step=5e-4, solver=sweep), record_problems=lf.RecordProblems(path, every=5)
    )
    compared = replay(load_problems(path), solvers(), repeats=1)
    print(compared)
    assert not compared.contradictory
    sums = {row.solver: row for row in compared.rows}
    assert sums["sweep (by hand)"].solved == len(compared.names)
    assert sums["hasty (3 sweeps)"].solved < len(compared.names)
    (folder / "own_solver.csv").write_text(compared.problems_csv(), encoding="utf-8")
    compared.plot().savefig(folder / "own_solver.png", dpi=150)
    return result


if __name__ == "__main__":
    print(run().summary())
