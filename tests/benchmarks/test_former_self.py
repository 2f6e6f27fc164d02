"""Steps of today's library against those of a former one, in turns: nothing gets slower.

The former library is a checkout of this repository, at the path in the environment variable ``LCPFLEX_FORMER``; each
of the two runs in a process of its own, which makes one run when it is asked to and answers with seconds per step.
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path

import pytest

TREE = Path(__file__).parents[2]
WORKER = Path(__file__).parent / "peers" / "former_self.py"
SLOWER = 1.03  # what is allowed
SLOWER_SOLVES = 1.05  # the same of solves by sweeps, a third of which lays memory out
BY_BLOCKS = 1.3  # steps of solids on many nodes, against the library before their contacts were solved by blocks
QUICKER = 10.0  # distances of graphs, against the library before they were sought in a tree


class Worker:
    """A process that makes runs with the library of one checkout."""

    def __init__(self, tree: Path, scene: str) -> None:
        environment = {**os.environ, "PYTHONPATH": str(tree)}
        self.process = subprocess.Popen(
            [sys.executable, str(WORKER), scene],
            env=environment,
            cwd=tree,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )

    def __call__(self) -> float:
        """Seconds of processor time a step."""
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        print("run", file=self.process.stdin, flush=True)
        return float(self.process.stdout.readline())

    def close(self) -> None:
        """End the process."""
        with self.process:  # closes its pipes, too
            self.process.terminate()


@pytest.fixture
def contestants(request: pytest.FixtureRequest) -> Iterator[Mapping[str, Worker]]:
    former = os.environ.get("LCPFLEX_FORMER")
    if not former:
        pytest.skip("LCPFLEX_FORMER names no checkout of a former version to compare with")
    scene: str = request.param
    workers = {f"former {scene}": Worker(Path(former), scene), f"{scene}": Worker(TREE, scene)}
    yield workers
    for worker in workers.values():
        worker.close()


@pytest.mark.parametrize(
    "contestants", ["pendulum", "incline", "bar", "event_driven", "generalized_alpha"], indirect=True
)
def test_no_slower_than_the_former_self(
    contestants: Mapping[str, Worker], interleave: Callable[..., Mapping[str, float]]
) -> None:
    former, now = contestants
    medians = interleave(contestants, rounds=21)
    assert medians[now] <= SLOWER * medians[former]


@pytest.mark.parametrize(
    "contestants",
    [
        f"{kind} {count} {storage}"
        for kind in ("plane", "space")
        for count in (4, 20, 100, 1000)
        for storage in ("dense", "sparse", "factor")
        if count < 1000 or storage != "dense"
    ],
    indirect=True,
)
def test_sweeps_over_contacts_are_no_slower(
    contestants: Mapping[str, Worker], interleave: Callable[..., Mapping[str, float]]
) -> None:
    """From the problem of the user to its certified answer, each matrix as it is stored."""
    former, now = contestants
    medians = interleave(contestants, rounds=21)
    assert medians[now] <= SLOWER_SOLVES * medians[former]


@pytest.mark.parametrize("contestants", ["late_wave", "near_wave"], indirect=True)
def test_distances_of_graphs_no_longer_take_seconds(
    contestants: Mapping[str, Worker], interleave: Callable[..., Mapping[str, float]]
) -> None:
    """For a former library in which the nearest point was sought along the graph, as it was up to 891607a."""
    former, now = contestants
    medians = interleave(contestants, rounds=5)
    assert QUICKER * medians[now] <= medians[former]


@pytest.mark.parametrize("contestants", ["solid", "rough_solid"], indirect=True)
def test_solids_on_many_nodes_no_longer_sweep_in_all_their_modes(
    contestants: Mapping[str, Worker], interleave: Callable[..., Mapping[str, float]]
) -> None:
    """For a former library that swept in the velocities of the bodies, as it did up to 60fdf261."""
    former, now = contestants
    medians = interleave(contestants, rounds=5)
    assert BY_BLOCKS * medians[now] <= medians[former]
