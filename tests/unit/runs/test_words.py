"""What a run says while it works, how often it comes back to Python, and how it ends when its budget is spent."""

from __future__ import annotations

import ctypes
import logging
import math
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numba
import numpy as np
import pytest

import lcpflex as lf
from lcpflex.basics import progress, pulse
from lcpflex.basics.pulse import BEATS
from lcpflex.basics.stopwatch import Budget
from lcpflex.steppers.run import Run
from tests.scenes import disc_on_floor, floor_of

SPAN = 0.02


def bouncing(law: Any = None) -> lf.Scene:
    """Two discs that bounce on the floor, one of them often."""
    scene = lf.Scene(gravity=(0.0, -9.81))
    for name, height in (("high", 0.5), ("low", 0.1001)):
        disc = scene.add(lf.Disc(0.1, mass=1.0), name, position=(0.3 if name == "high" else 0.0, height))
        restitution = {} if law else {"restitution": 0.5}
        scene.contact(disc.surface(), floor_of(scene), friction=0.2, law=law, name=f"{name} on floor", **restitution)
    return scene


def in_space() -> lf.SpatialScene:
    scene = lf.SpatialScene(gravity=(0.0, 0.0, -9.81))
    ball = scene.add(lf.Sphere(0.1, mass=1.0), "ball", position=(0.0, 0.0, 0.1001))
    scene.contact(ball.surface(), scene.ground.plane((0, 0, 0), (0, 0, 1)), friction=0.2, name="ball on floor")
    return scene


PENALTY = lf.Penalty(1e5)
RUNS: dict[str, tuple[Callable[[], Any], Any]] = {
    "fixed": (bouncing, lf.MoreauJean(step=1e-4)),
    "adaptive": (bouncing, lf.MoreauJean(step=1e-5, adaptive=lf.AdaptiveStep(rtol=1e-7))),
    "generalised-alpha": (bouncing, lf.GeneralizedAlpha(step=1e-4)),
    "event-driven": (bouncing, lf.EventDriven(max_step=1e-4)),
    "smooth": (lambda: bouncing(PENALTY), lf.Smooth(integrator=lf.ExplicitRungeKutta(max_step=1e-4))),
    "Verlet": (lambda: bouncing(PENALTY), lf.Smooth(integrator=lf.Verlet(1e-4))),
    "stiff": (lambda: bouncing(PENALTY), lf.Smooth(integrator=lf.Stiff(max_step=1e-4))),
    "space": (in_space, lf.MoreauJean(step=1e-4)),
    "space, event-driven": (in_space, lf.EventDriven(max_step=1e-4)),
}
every_run = pytest.mark.parametrize("kind", RUNS)


@every_run
def test_a_run_says_how_far_it_is(kind: str, always: pytest.LogCaptureFixture) -> None:
    scene, stepper = RUNS[kind]
    result = lf.simulate(scene(), SPAN, stepper)
    lines = [line for line in always.messages if "t = " in line]
    assert lines
    assert lines[0].startswith("simulate after 0 s: t = ")
    assert all("of 0.02 s" in line and " steps, " in line for line in lines)
    assert f"{result.steps} steps" in lines[-1]
    assert f"t = {SPAN:g} s of" in lines[-1]
    assert all(record.name == "lcpflex" and record.levelno == logging.INFO for record in always.records)


def test_the_contact_that_makes_most_events(always: pytest.LogCaptureFixture) -> None:
    lf.simulate(bouncing(), 0.05, lf.EventDriven())
    lines = [line for line in always.messages if "events a second" in line]
    assert lines
    assert all("of them at contact 'low on floor'" in line for line in lines)


def test_a_minute_goes_by_between_lines(monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture) -> None:
    """By the clock that is asked."""
    caplog.set_level(logging.INFO, "lcpflex")
    clock = [0.0]
    monkeypatch.setattr(progress, "now", lambda: clock[0])
    with progress.Progress(None, lambda: "here", what="work"):
        for _ in range(1000):
            clock[0] += 0.5
            progress.look()
    assert caplog.messages == [f"work after {60 * k} s: here" for k in range(1, 9)]


@pytest.fixture
def unheard(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Nobody has set up logging."""
    monkeypatch.setattr(progress.LOGGER, "hasHandlers", lambda: False)
    monkeypatch.setattr(progress, "EVERY", 0.0)
    monkeypatch.setattr(progress, "now", lambda: 0.0)
    yield
    progress.LOGGER.setLevel(logging.NOTSET)


@pytest.mark.usefixtures("unheard")
@pytest.mark.parametrize(
    ("shown", "level", "spoken"),
    [(None, logging.NOTSET, True), (False, logging.NOTSET, False), (None, logging.ERROR, False)],
)
def test_where_logging_is_not_set_up(
    shown: bool | None, level: int, spoken: bool, capsys: pytest.CaptureFixture[str]
) -> None:
    """What stderr shows is seen by default, not with progress=False, and not where the logger is to be quiet."""
    progress.LOGGER.setLevel(level)
    lf.simulate(bouncing(), SPAN, lf.MoreauJean(1e-3), progress=shown)
    assert ("lcpflex: simulate after 0 s: t = " in capsys.readouterr().err) == spoken


@pytest.mark.usefixtures("unheard")
def test_a_terminal_keeps_its_bar(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr(progress, "_on_terminal", lambda: True)
    lf.simulate(bouncing(), SPAN, lf.MoreauJean(1e-3))
    assert "t = " not in capsys.readouterr().err
    lf.simulate(bouncing(), SPAN, lf.MoreauJean(1e-3), progress=True)
    told = capsys.readouterr().err
    assert "t = " not in told
    assert "/0.02 s [" in told  # tqdm's


def silent(time: float) -> float:
    """0."""
    return 0.0


def beating(time: float) -> float:
    """0, and a beat of the pulse."""
    BEATS[0] += 1
    return 0.0


def pulled(kind: str, called: Callable[[float], float]) -> lf.Scene | lf.SpatialScene:
    """The scene of a run under a force that is 0, from a compiled function that calls a Python function."""
    pull = ctypes.CFUNCTYPE(ctypes.c_double, ctypes.c_double)(called)
    scene = RUNS[kind][0]()
    if isinstance(scene, lf.SpatialScene):
        scene.load(lf.Force(scene.body("ball").at(0.0, 0.0, 0.0), numba.njit(lambda time: (pull(time), 0.0, 0.0))))
    else:
        scene.load(lf.Force(scene.body("low").at(0.0, 0.0), numba.njit(lambda time: (pull(time), 0.0))))
    return scene


@pytest.mark.parametrize("kind", [kind for kind in RUNS if kind != "stiff"])  # whose loop is Python's
def test_compiled_loops_return_when_the_pulse_beats(kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """After each step in which it beats: so Ctrl-C waits for no more than one. The result has the same bits.

    Steps of the shortest length ask for no force in time.
    """
    returns = [0]
    towards = Run._towards

    def counted(run: Run, target: int) -> str:
        returns[0] += 1
        return towards(run, target)

    monkeypatch.setattr(Run, "_towards", counted)
    often = lf.simulate(pulled(kind, beating), SPAN, RUNS[kind][1])
    assert often.steps > 50
    assert returns[0] > (0.5 if kind == "adaptive" else 0.99) * often.steps
    returns[0] = 0
    seldom = lf.simulate(pulled(kind, silent), SPAN, RUNS[kind][1])
    for name in ("times", "q", "u", "force", "impulse"):
        assert np.array_equal(getattr(often, name), getattr(seldom, name), equal_nan=True), name


@every_run
def test_a_run_ends_where_its_budget_is_spent(kind: str) -> None:
    scene, stepper = RUNS[kind]
    result = lf.simulate(scene(), 100.0, stepper, budget=1e-9)
    assert not result.complete
    assert result.message.startswith("the budget of 1e-09 s of computing is spent at t = ")
    assert len(result.times) > 0
    assert "stopped early" in result.summary()
    enough = lf.simulate(scene(), SPAN, stepper, budget=1e6)
    assert enough.complete


def test_functions_in_python_and_systems_of_the_user() -> None:
    """Their loop is Python, and makes a step before computing begins."""
    scene = disc_on_floor(0.11)
    scene.load(lf.Force(scene.body("disc").at(0.0, 0.0), lambda t: (math.sin(t), 0.0)))
    for system in (scene, lf.UserSystem(np.zeros(1), np.ones(1), lambda q: np.eye(1), lambda t, q, u: -q)):
        result = lf.simulate(system, 1.0, lf.MoreauJean(1e-3), budget=1e-9)
        assert (result.complete, result.message[:13]) == (False, "the budget of")


@pytest.mark.parametrize("kind", ["fixed", "adaptive", "event-driven", "smooth"])
def test_a_run_goes_on_with_another_budget(kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """From its checkpoint, and ends with the bits that it would have ended with."""
    scene, stepper = RUNS[kind]
    asked = [0]

    def spent(budget: Budget) -> bool:
        asked[0] += budget.seconds is not None
        return budget.seconds is not None and asked[0] % 2 == 0

    whole = lf.simulate(scene(), SPAN, stepper)
    monkeypatch.setattr(Budget, "is_spent", property(spent))
    path = tmp_path / "run.npz"
    part = lf.simulate(scene(), SPAN, stepper, checkpoint=path, budget=1.0)
    parts = 1
    while not part.complete:
        assert parts < 100
        assert part.times[-1] < SPAN
        assert "the budget of 1 s of computing is spent at t = " in part.message
        part, parts = lf.resume(path, budget=1.0), parts + 1
    assert parts > 1
    for name in ("times", "q", "u", "force", "impulse"):
        assert np.array_equal(getattr(part, name), getattr(whole, name), equal_nan=True), name


@pytest.mark.parametrize("budget", [0.0, -1.0, math.nan, "a minute", True])
def test_a_budget_that_is_none(budget: Any, tmp_path: Path) -> None:
    with pytest.raises(lf.ModelError, match=r"budget: .* was given, expected"):
        lf.simulate(bouncing(), SPAN, lf.MoreauJean(1e-3), budget=budget)
    path = tmp_path / "run.npz"
    lf.simulate(bouncing(), SPAN, lf.MoreauJean(1e-3), checkpoint=path)
    with pytest.raises(lf.ModelError, match=r"budget: .* was given, expected"):
        lf.resume(path, budget=budget)


def test_a_run_of_a_study_that_takes_too_long_is_an_error() -> None:
    from lcpflex.runs.simulate import given_up_after

    with pytest.raises(lf.StepError, match="the budget of 1e-09 s of computing is spent") as caught:
        given_up_after(1e-9, bouncing(), 100.0, lf.MoreauJean(1e-4))
    assert caught.value.result is not None
    assert not caught.value.result.complete


def test_nothing_beats_once_the_last_run_has_ended() -> None:
    """Whoever makes steps by himself, as a test does, makes as many as he asks for, whatever ran before."""
    with pulse.beating():
        pass
    before = int(BEATS[0])
    time.sleep(2.0 * pulse.PERIOD)
    assert int(BEATS[0]) == before
