"""What the benchmarks share: interleaved runs, ratios of their medians, and a report of them at the end.

Speeds are compared as ratios within one run of the tests, never with numbers of seconds: machines differ, and their
load changes from minute to minute.
"""

from __future__ import annotations

import json
import os
import statistics
import subprocess
import time
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.solvers import ContactProblem, Lcp, Solution
from tests.scenes import floor_of

REPORT = pytest.StashKey[list[str]]()

Medians = Mapping[str, float]
Interleave = Callable[..., Medians]


class Delegate:
    """Lemke's method behind an object that is not known to be compiled: the loop of a stepper is then Python's."""

    def solve(self, problem: Lcp, guess: Solution | None = None) -> Solution:
        return lf.Lemke().solve(problem, guess)


@pytest.fixture
def delegate() -> Delegate:
    """A solver that makes steppers take their Python driver."""
    return Delegate()


def _resting_strip(modes: int = 4, pull: Any = None) -> lf.Scene:
    strip = lf.Beam(length=0.7, width=0.028, thickness=0.005, density=2700.0, youngs_modulus=6.9e10)
    scene = lf.Scene(gravity=(0.0, -9.81))
    body = scene.add(strip.reduce(modes=modes, damping=0.02), name="strip", position=(0.0, 0.0025))
    floor = floor_of(scene)
    for name, x in (("left", 0.0), ("right", 0.7)):
        scene.contact(body.node(x, -0.0025), floor, friction=0.5, name=name)
    if pull is not None:
        scene.load(lf.Force(body.point("left"), (pull, 0.0)))
    return scene


@pytest.fixture
def resting_strip() -> Callable[..., lf.Scene]:
    """Builder of a strip with ``modes`` modes that lies on its two ends, with friction, and is pulled by ``pull``."""
    return _resting_strip


@pytest.fixture
def report(request: pytest.FixtureRequest) -> Iterator[Callable[[str], None]]:
    """Adds lines to the report that ends the run."""
    lines: list[str] = []
    yield lines.append
    request.config.stash.setdefault(REPORT, []).extend(lines)


@pytest.fixture
def interleave(benchmark: Any, report: Callable[[str], None]) -> Interleave:
    """Median seconds of several contestants that run in turns, A B C A B C ...; pytest-benchmark times the first one.

    Each contestant makes its run and returns the seconds of what is compared, such as those per step.
    """

    def run(contestants: Mapping[str, Callable[[], float]], rounds: int = 7) -> Medians:
        first, *others = contestants
        seconds: dict[str, list[float]] = {name: [] for name in contestants}
        for contestant in contestants.values():
            contestant()  # compiles, fills caches

        def rest() -> None:
            for name in others:
                seconds[name].append(contestants[name]())

        benchmark.pedantic(lambda: seconds[first].append(contestants[first]()), setup=rest, rounds=rounds)
        medians = {name: statistics.median(values) for name, values in seconds.items()}
        for name, median in medians.items():
            ratio = f"{median / medians[first]:8.1f} x {first}" if name != first else ""
            report(f"{name:42s} {1e6 * median:11.2f} us {ratio}")
        benchmark.extra_info["microseconds"] = {name: 1e6 * median for name, median in medians.items()}
        return medians

    return run


@pytest.fixture(scope="session")
def scattered() -> Callable[[int, int], ContactProblem]:
    """Contacts at random points of as many random planar bodies and the ground, each with a friction of its own."""

    def make(contacts: int, seed: int) -> ContactProblem:
        rng = np.random.default_rng([seed, contacts])
        bodies = max(2, contacts)
        mass, size = rng.uniform(0.5, 2.0, bodies), rng.uniform(0.2, 1.0, bodies)
        root = np.sqrt(np.column_stack([1.0 / mass, 1.0 / mass, 6.0 / (mass * size**2)])).ravel()
        rows = np.zeros((2 * contacts, 3 * bodies))
        for k in range(contacts):
            angle, other = rng.uniform(0.0, 2.0 * np.pi), int(rng.integers(bodies))
            for body, sign in {k % bodies: 1.0, other: -1.0}.items():
                if (sign < 0.0 and rng.random() < 0.3) or (sign > 0.0 and body == other):
                    continue  # against the ground
                x, y = size[body] * rng.uniform(-1.0, 1.0, 2)
                for row, turn in ((k, 0.0), (contacts + k, 0.5 * np.pi)):
                    c, s = np.cos(angle + turn), np.sin(angle + turn)
                    rows[row, 3 * body : 3 * body + 3] = sign * np.array([c, s, x * s - y * c])
        factor = rows * root
        delassus = factor @ factor.T + 1e-8 * np.eye(2 * contacts)
        return ContactProblem(delassus, rows @ rng.standard_normal(3 * bodies), rng.uniform(0.1, 1.0, contacts))

    return make


@pytest.fixture(scope="session")
def per_call() -> Callable[[Callable[[], object], float], float]:
    """Seconds of one call: least of five loops of about ``span`` seconds each, which leaves out what others took."""

    def measure(call: Callable[[], object], span: float = 2e-3) -> float:
        began = time.perf_counter()
        call()
        repeats = max(1, int(span / max(time.perf_counter() - began, 1e-7)))
        least = np.inf
        for _ in range(5):
            began = time.perf_counter()
            for _ in range(repeats):
                call()
            least = min(least, (time.perf_counter() - began) / repeats)
        return least

    return measure


@pytest.fixture(scope="session")
def siconos_solver(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., list[dict[str, Any]]]:
    """Runs a solver of Siconos in the interpreter that has it: seconds per call, and the points it found."""
    python = os.environ.get("SICONOS_PYTHON", "/usr/bin/python3")
    peer = Path(__file__).parent / "peers" / "siconos_solvers.py"
    try:
        subprocess.run([python, "-c", "import siconos.numerics"], check=True, capture_output=True)
    except (OSError, subprocess.CalledProcessError):
        pytest.skip(f"no siconos in {python} (Debian: apt install python3-siconos; or set SICONOS_PYTHON)")

    def run(solver: str, tolerance: float, **arrays: Any) -> list[dict[str, Any]]:
        path = tmp_path_factory.mktemp("siconos") / "problems.npz"
        np.savez(path, **arrays)
        command = [python, str(peer), solver, str(tolerance), str(path)]
        shown = subprocess.run(command, capture_output=True, text=True, check=True).stdout
        found: list[dict[str, Any]] = json.loads(shown.splitlines()[-1])
        return found

    return run


def pytest_terminal_summary(terminalreporter: Any, config: pytest.Config) -> None:
    lines = config.stash.get(REPORT, [])
    if lines:
        terminalreporter.section("measured ratios")
        for line in lines:
            terminalreporter.write_line(line)
