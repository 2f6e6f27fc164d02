"""A run that was broken off goes on from its checkpoint and ends with the bits it would have ended with."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.runs import checkpoint as checkpoints
from lcpflex.runs.checkpoint import Checkpoints, read
from lcpflex.runs.object_tree import freeze
from tests.unit.runs import checkpoint_runs
from tests.unit.runs.checkpoint_runs import RUNS, Breaks, assert_same_bits, heap, own_system, pushed, thrown

QUICK = (
    "moreau",
    "moreau adaptive",
    "alpha adaptive",
    "event-driven by law",
    "massless",
    "stiff",
    "own system",
    "sensors",
    "space, event-driven",
)


def missing(path: Path, build: Any, stepper: Any) -> dict[str, Any]:
    """What a file cannot hold."""
    given = {"scene": build, "stepper": lambda: stepper}
    return {name: given[name]() for name in read(path).structure["missing"]}


def no_two_share_memory(run: Any) -> None:
    arrays: dict[str, Any] = {}
    freeze(run, "run", arrays, {})
    spans = sorted((*np.lib.array_utils.byte_bounds(array), name) for name, array in arrays.items() if array.size)
    for (_, end, name), (begin, _, other) in pairwise(spans):
        assert end <= begin, (name, other)


@pytest.mark.parametrize("name", [pytest.param(name, marks=[pytest.mark.slow] * (name not in QUICK)) for name in RUNS])
def test_a_resumed_run_ends_with_the_same_bits(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Broken off three times; all that is in the result is the same but the timings, and so is the file's content."""
    build, duration, stepper = RUNS[name]
    whole = lf.simulate(build(), duration, stepper)
    path = tmp_path / "run.npz"
    breaks = Breaks(monkeypatch, {5, 12, 30})
    result = lf.simulate(build(), duration, stepper, checkpoint=path)
    parts = 0
    while not result.complete:
        assert result.message.startswith("interrupted")
        parts += 1
        result = lf.resume(path, **missing(path, build, stepper))
    assert parts == 3 or (parts >= 1 and breaks.chunks < 30)
    assert_same_bits(whole, result)
    assert result.wall_time > 0.0
    assert read(path).finished
    again = lf.resume(path, **missing(path, build, stepper))  # it had come to its end
    assert_same_bits(whole, again)
    assert [entry.name for entry in tmp_path.iterdir()] == ["run.npz"]


@pytest.mark.parametrize(
    "name", ["moreau", "alpha", "event-driven by law", "massless", "verlet", "moreau adaptive", "sensors"]
)
def test_no_two_arrays_of_a_run_share_memory(name: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """They are kept apart, so that one that is a part of another would not be so after the run was resumed."""
    build, duration, stepper = RUNS[name]
    seen = []
    begins = Checkpoints.chunk_begins

    def look(keeper: Checkpoints) -> None:
        if len(seen) < 3:
            no_two_share_memory(keeper._run)
            seen.append(1)
        begins(keeper)

    monkeypatch.setattr(Checkpoints, "chunk_begins", look)
    lf.simulate(build(), duration, stepper, checkpoint=tmp_path / "run.npz")
    assert seen


@pytest.mark.parametrize("name", ["moreau", "verlet", "moreau adaptive", "alpha"])
def test_results_do_not_depend_on_how_many_steps_are_made_at_a_time(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """As they would on a slow machine: the bits are the same ones."""
    build, duration, stepper = RUNS[name]
    whole = lf.simulate(build(), duration, stepper)
    monkeypatch.setattr(sys.modules["lcpflex.runs.simulate"], "CHUNK_SECONDS", 0.0)
    assert_same_bits(whole, lf.simulate(build(), duration, stepper))


def test_contact_problems_are_recorded_as_without_a_break(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from lcpflex.solvers.benchmark.files import load_problems

    build, duration, stepper = RUNS["moreau"]
    wanted, found = (lf.RecordProblems(tmp_path / f"{name}.npz", hardest=5) for name in ("wanted", "found"))
    lf.simulate(build(), duration, stepper, record_problems=wanted)
    path = tmp_path / "run.npz"
    Breaks(monkeypatch, {20})
    assert not lf.simulate(build(), duration, stepper, record_problems=found, checkpoint=path).complete
    with pytest.raises(lf.ModelError, match=r"record_problems: None was given, expected RecordProblems"):
        lf.resume(path)
    assert lf.resume(path, record_problems=found).complete
    for one, other in zip(load_problems(wanted.path), load_problems(found.path), strict=True):
        assert one.name == other.name
        np.testing.assert_array_equal(one.problem.delassus, other.problem.delassus)


CHILD = """
import importlib
import sys
sys.path[:0] = [sys.argv[1]]
import lcpflex as lf
from lcpflex.runs import checkpoint
from tests.unit.runs.checkpoint_runs import (Breaks, broken_off, heap)
from pathlib import Path
checkpoint.SHARE = 10.0  # a slow disk does not make them few: the run must not end before it is killed
importlib.import_module("lcpflex.runs.simulate").CHUNK_SECONDS = 0.01
path = Path(sys.argv[2])
if path.exists():
    lf.resume(path)
else:
    lf.simulate(heap(), float(sys.argv[3]), lf.MoreauJean(1e-4), record=1e-2, checkpoint=path, every=0.02)
"""


def killed(path: Path, duration: float, rewritten: int, later: float) -> bool:
    """Begin or go on with a run in a process of its own, and kill it in the midst of it; whether it was there yet."""
    here = str(Path(checkpoint_runs.__file__).parents[3])
    child = subprocess.Popen([sys.executable, "-c", CHILD, here, str(path), str(duration)])
    try:
        last, seen = (path.stat().st_ino if path.exists() else None), 0
        while seen < rewritten and child.poll() is None:
            now = path.stat().st_ino if path.exists() else None
            seen, last = seen + (now != last), now
            time.sleep(2e-3)
        time.sleep(later)
        return child.poll() is None
    finally:
        child.kill()
        child.wait()


def assert_killed_runs_end_alike(path: Path, duration: float, kills: int) -> None:
    random = np.random.default_rng(15)
    whole = lf.simulate(heap(), duration, lf.MoreauJean(1e-4), record=1e-2)
    reached = 0.0
    for _ in range(kills):
        assert killed(path, duration, int(random.integers(2, 5)), float(random.uniform(0.0, 0.05)))
        assert read(path).structure["at"][0] > reached  # what is there is whole, and further on
        reached = read(path).structure["at"][0]
    result = lf.resume(path)
    assert result.complete
    assert_same_bits(whole, result)


@pytest.mark.slow
def test_a_run_that_is_killed_twice(tmp_path: Path) -> None:
    assert_killed_runs_end_alike(tmp_path / "run.npz", 4.0, kills=2)


@pytest.mark.slow
def test_a_run_that_is_killed_at_ten_random_instants(tmp_path: Path) -> None:
    assert_killed_runs_end_alike(tmp_path / "run.npz", 12.0, kills=10)


def test_a_full_disk_is_told_once_and_loses_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    path = tmp_path / "run.npz"
    write, calls = np.savez, [0]

    def savez(file: Any, **arrays: Any) -> None:
        calls[0] += 1
        if calls[0] > 2:
            file.write(b"half")
            raise OSError(28, "No space left on device")
        write(file, **arrays)

    whole = lf.simulate(heap(), 0.05, lf.MoreauJean(1e-3))
    monkeypatch.setattr(np, "savez", savez)
    monkeypatch.setattr(checkpoints, "SHARE", np.inf)
    monkeypatch.setattr(sys.modules["lcpflex.runs.simulate"], "CHUNK_SECONDS", 0.0)
    result = lf.simulate(heap(), 0.05, lf.MoreauJean(1e-3), checkpoint=path, every=0.0)
    assert caplog.text.count("No space left") == 1
    assert calls[0] > 3
    assert_same_bits(whole, result)
    assert [entry.name for entry in tmp_path.iterdir()] == ["run.npz"]
    monkeypatch.setattr(np, "savez", write)
    assert_same_bits(whole, lf.resume(path))  # from the last one that was written


def test_writing_takes_a_small_share_of_the_time(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    """Where it is slow, checkpoints are farther apart, and that is told once."""
    clock = [0.0]
    writes = []

    def write(keeper: Checkpoints) -> None:
        writes.append(clock[0])
        clock[0] += 1.0

    def chunk(keeper: Checkpoints) -> None:
        clock[0] += 0.5

    monkeypatch.setattr(Checkpoints, "_write", write)
    monkeypatch.setattr(Checkpoints, "chunk_begins", chunk)
    monkeypatch.setattr(checkpoints.time, "perf_counter", lambda: clock[0])
    monkeypatch.setattr(checkpoints, "described", lambda setup, arrays: {})
    keeper = Checkpoints(tmp_path / "run.npz", 10.0)
    nothing: Any = None
    keeper.begin(nothing, nothing, nothing, (0.0, 0.0), False)
    for _ in range(2000):
        keeper.chunk_begins()
        keeper.chunk_ends()
    assert caplog.text.count("a checkpoint takes 1 s") == 1
    assert len(writes) / clock[0] < 0.0225
    assert len(writes) > 15


def test_a_second_interruption_does_not_wait(tmp_path: Path) -> None:
    """For a function that never returns: what was written before is there."""

    def force(t: float, q: Any, u: Any) -> Any:
        if t > 0.05 and u[1] != 1.0:  # not before the run, when it is asked how fast it changes in time
            signal.raise_signal(signal.SIGINT)  # to this thread, at once
            signal.raise_signal(signal.SIGINT)  # in the same step: between two, the run may be whole
        return np.array([-9.81, 0.0])

    path = tmp_path / "run.npz"
    system = replace(own_system(), force=force)
    result = lf.simulate(system, 0.3, lf.MoreauJean(1e-3), checkpoint=path)
    assert result.message.startswith("interrupted")
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    assert read(path).structure["at"][0] <= 0.06  # of the start: nothing was due since


def test_the_last_state_of_a_result_begins_another_run() -> None:
    """Where nothing else is remembered, as without a break; the notes say so."""
    scene, free = thrown(), lf.Scene()
    free.add(lf.Box(0.3, 0.1, mass=1.0), position=(0.0, 1.0), velocity=(1.0, 2.0), angular_velocity=3.0)
    for stepper in (lf.MoreauJean(2.0**-10), lf.Smooth(lf.Penalty(1e4), integrator=lf.Verlet(2.0**-10))):
        whole = lf.simulate(free, 0.25, stepper)
        first = lf.simulate(free, 0.125, stepper)
        second = lf.simulate(free, 0.125, stepper, initial=first)
        np.testing.assert_array_equal(second.q[-1], whole.q[-1])
        np.testing.assert_array_equal(second.u[-1], whole.u[-1])
        assert any("as without a break" in note for note in second.notes)
    first = lf.simulate(scene, 0.125, lf.EventDriven())
    second = lf.simulate(thrown(), 0.125, lf.EventDriven(), initial=first)
    np.testing.assert_array_equal(second.q[0], first.q[-1])
    np.testing.assert_array_equal(second.compiled.q, first.q[-1])
    assert any("chosen anew" in note for note in second.notes)
    np.testing.assert_allclose(second.q[-1], lf.simulate(scene, 0.25, lf.EventDriven()).q[-1], rtol=0, atol=1e-6)


def test_a_result_of_other_coordinates_begins_no_run() -> None:
    first = lf.simulate(thrown(), 0.01, lf.MoreauJean(1e-3))
    with pytest.raises(lf.ModelError, match=r"initial: .*ball \(3\), box \(3\).*expected those of the scene, body1"):
        lf.simulate(heap(), 0.01, lf.MoreauJean(1e-3), initial=first)
    own = lf.simulate(own_system(), 0.01, lf.MoreauJean(1e-3))
    with pytest.raises(lf.ModelError, match=r"initial: .*q \(2\)"):
        lf.simulate(heap(), 0.01, lf.MoreauJean(1e-3), initial=own)
    second = lf.simulate(own_system(), 0.01, lf.MoreauJean(1e-3), initial=own)
    np.testing.assert_array_equal(second.q[0], own.q[-1])


def test_a_run_from_a_result_is_resumed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    first = lf.simulate(pushed(), 0.02, lf.MoreauJean(1e-3))
    whole = lf.simulate(pushed(), 0.1, lf.MoreauJean(1e-3), initial=first)
    path = tmp_path / "run.npz"
    with monkeypatch.context() as patch:
        Breaks(patch, {5})
        assert not lf.simulate(pushed(), 0.1, lf.MoreauJean(1e-3), initial=first, checkpoint=path).complete
    assert_same_bits(whole, lf.resume(path, pushed()))
