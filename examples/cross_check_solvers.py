"""All solvers on the same contact problems: who solves them, how well, how fast, and do they agree?

A tower of six boxes, the lowest of which is knocked away at 2 m/s, is simulated twice, with friction and without.
Every tenth contact problem of each run is kept (`RecordProblems`) and solved again by every solver there is.

The tables show that all who solve a problem find the same motion, though not the same forces: the corners of a box
share its weight as they like. The chart is a performance profile: follow a line from the left, where it is the
fastest, to the right, where you are patient; its height is the share of problems solved by then. Solvers that
refuse a problem do not solve it: friction makes the matrix unsymmetric, which quadratic programs and principal
pivoting do not take, and enumeration stops at 16 unknowns.
"""

from pathlib import Path

from matplotlib.figure import Figure

import lcpflex as lf
from lcpflex.solvers.benchmark.files import load_problems
from lcpflex.solvers.benchmark.replays import Replay, replay


def tower(friction: float) -> lf.Scene:
    scene = lf.Scene(gravity=(0.0, -9.81))
    for k in range(6):
        scene.add(
            lf.Box(width=0.2, height=0.1, mass=1.0),
            name=f"box {k + 1}",
            position=(0.0, 0.05 + 0.1 * k),
            velocity=(2.0 if k == 0 else 0.0, 0.0),
        )
    scene.ground.half_plane((0.0, 0.0), (0.0, 1.0))
    scene.contact_all(friction=friction)
    return scene


def compare(folder: Path, name: str, friction: float) -> tuple[lf.Result, Replay]:
    path = folder / f"problems_{name}.npz"
    record = lf.RecordProblems(path, every=10)
    result = lf.simulate(tower(friction), 0.4, lf.MoreauJean(step=5e-4), record_problems=record)
    compared = replay(load_problems(path), repeats=1)
    assert not compared.contradictory
    return result, compared


def run(folder: Path = Path()) -> lf.Result:
    """Both comparisons as tables and a chart; returns the run with friction."""
    result, rough = compare(folder, "with_friction", 0.5)
    _, smooth = compare(folder, "without_friction", 0.0)
    figure = Figure(figsize=(9, 8), layout="constrained")
    for axes, compared, title in zip(
        figure.subplots(2, 1), (rough, smooth), ("with friction, mu = 0.5", "without friction"), strict=True
    ):
        print(f"{title}\n\n{compared}\n")
        compared.plot(axes)
        axes.set_title(f"{title}: {len(compared.names)} problems", loc="left", fontsize="medium")
    figure.savefig(folder / "cross_check_solvers.png", dpi=150)
    return result


if __name__ == "__main__":
    print(run().summary())
