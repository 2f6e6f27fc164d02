"""Each touch of a contact: a bouncing ball in closed form, blocks that stick and slip, and what is not located."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.results.contact_history import ContactHistory
from lcpflex.results.result import Result

G, HEIGHT, E, MASS = 9.81, 0.5, 0.6, 2.0
FALL = math.sqrt(2.0 * HEIGHT / G)


def ball(e: float = E) -> lf.Scene:
    scene = lf.Scene(gravity=(0, -G))
    disc = scene.add(lf.Disc(0.1, mass=MASS), "ball", position=(0.0, 0.1 + HEIGHT))
    scene.contact(disc.surface(), scene.ground.half_plane((0, 0), (0, 1)), restitution=e, name="floor")
    return scene


def run(scene: lf.Scene, stepper: Any, duration: float, record: float | None = None) -> Result:
    return lf.simulate(scene, duration, stepper, record=record, progress=False)


def bounces(count: int) -> tuple[np.ndarray[Any, Any], np.ndarray[Any, Any]]:
    """Times of the impacts, and their impulses m v (1 + e) of approaches v e^k."""
    k = np.arange(count)
    speed = G * FALL * E**k
    flights = np.concatenate([[0.0], np.cumsum(2.0 * FALL * E ** k[1:])])
    return FALL + flights, MASS * speed * (1.0 + E)


def test_a_bouncing_ball_event_by_event() -> None:
    """Each impact is one instant, however far apart instants were stored; what the ball rests on is the last touch."""
    end = FALL * (1.0 + E) / (1.0 - E)
    for record in (0.01, 10.0):
        result = run(ball(), lf.EventDriven(), end + 0.2, record)
        floor = result.contact("floor")
        windows = floor.windows()
        times, impulses = bounces(12)
        for window, time, impulse in zip(windows[:12], times, impulses, strict=True):
            assert window.begin == window.end == pytest.approx(time, abs=1e-8)
            assert window.impulse == pytest.approx([impulse, 0.0], rel=1e-7)
            assert math.isnan(window.peak_force)
            assert (window.by, window.from_start, window.to_end) == ("events", False, False)
        last = windows[-1]
        assert last.to_end
        assert last.end == result.times[-1]
        assert last.begin == pytest.approx(end, abs=1e-5)
        assert last.peak_force == pytest.approx(MASS * G, rel=1e-9)
        assert sum(w.impulse[0] for w in windows) == pytest.approx(MASS * G * (end + 0.2), rel=1e-6)
        impacts = [event for event in floor.events if event.kind == "impact"]
        assert len(impacts) >= len(windows) - 1
        assert floor.events == tuple(event for event in result.events if event.contact == "floor")
        assert floor.events[0].time == windows[0].begin == floor.first_touch


def test_a_bouncing_ball_step_by_step() -> None:
    """All of a touch lies between its ends, which are steps; and between stored instants where only some are."""
    times, impulses = bounces(3)
    for record, by, apart in ((0.0, "steps", 1e-3), (1e-3, "steps", 1e-3), (0.02, "instants", 0.02)):
        windows = run(ball(), lf.MoreauJean(1e-3), times[2] + 0.05, record).contact("floor").windows()
        assert len(windows) == 3
        for window, time, impulse in zip(windows, times, impulses, strict=True):
            assert window.by == by
            assert window.begin - 3e-3 <= time <= window.end + 3e-3
            assert window.duration == pytest.approx(apart, rel=1e-6)
            assert window.impulse[0] == pytest.approx(impulse, rel=2e-2)
            if by == "steps":
                assert window.peak_force == pytest.approx(window.impulse[0] / 1e-3, rel=1e-9)


@pytest.mark.parametrize(
    "stepper",
    [lf.EventDriven(), lf.Smooth(lf.Penalty(1e5)), lf.Smooth(lf.Penalty(1e5), integrator=lf.Stiff())],
    ids=["EventDriven", "explicit", "implicit"],
)
def test_no_touch_is_missed_and_none_told_twice(stepper: Any) -> None:
    """Instants are 0.1 s apart: touches of a spring, of T = 14 ms, fall between them, and have m (2 v + g T) each."""
    omega, speed = math.sqrt(1e5 / MASS), G * FALL
    lasts = 2.0 / omega * (math.pi - math.atan(speed * omega / G)) if type(stepper) is lf.Smooth else 0.0
    windows = run(ball(1.0), stepper, 2.0, 0.1).contact("floor").windows()
    assert len(windows) == 3
    for k, window in enumerate(windows):
        begins = FALL * (1 + 2 * k) + k * lasts
        assert window.begin <= begins + 1e-7
        assert window.end >= begins + lasts - 1e-7
        assert window.duration <= (0.2 if lasts else 0.0) + 1e-9
        assert window.impulse[0] == pytest.approx(MASS * (2.0 * speed + G * lasts), rel=1e-5)
        assert window.by == ("instants" if lasts else "events")


def test_stick_and_slip() -> None:
    """A block thrown on a floor slides for v / (mu g), then sticks; a contact that never was has no touch."""
    mu, speed = 0.3, 1.0
    for stepper, rough in ((lf.EventDriven(), 1e-6), (lf.MoreauJean(1e-3), 2e-3)):
        scene = lf.Scene(gravity=(0, -G))
        block = scene.add(lf.Box(0.4, 0.1, mass=1.0), "block", position=(0.0, 0.05), velocity=(speed, 0.0))
        other = scene.add(lf.Disc(0.1, mass=1.0), "other", position=(0.0, 5.0))
        scene.contact(block.surface(), scene.ground.half_plane((0, 0), (0, 1)), friction=mu, name="floor")
        scene.contact(block.surface(), other.surface(), name="apart")
        result = run(scene, stepper, 0.5)
        (window,) = result.contact("floor").windows()
        slides = speed / (mu * G) / 0.5
        assert (window.slip, window.stick, window.creep) == pytest.approx((slides, 1.0 - slides, 0.0), abs=rough)
        assert (window.from_start, window.to_end) == (True, True)
        assert np.abs(window.impulse) == pytest.approx([G * 0.5, speed], rel=1e-3)
        assert result.contact("apart").windows() == ()


def history(state: list[int], impulse: list[float], times: list[float], located: str) -> ContactHistory:
    m = len(times)
    force = np.where(np.array(state) != 0, 5.0, 0.0)
    return ContactHistory(
        "c", np.array(times, dtype=float), np.column_stack([force, 0 * force]),
        np.column_stack([impulse, np.zeros(m)]), np.array(state, np.int8), np.zeros(m), np.zeros(m, np.int64),
        math.inf, located=located,
    )  # fmt: skip


def test_what_belongs_together() -> None:
    """Touches by events that follow each other without time between are one; stored open instants part others."""
    state, impulse, times = [0, 0, 2, 0, 1, 0], [0, 1, 2, 2, 3, 3], [0, 0, 1, 1, 1, 2]
    (window,) = history(state, impulse, times, "events").windows()  # type: ignore[arg-type]
    assert (window.begin, window.end, window.impulse[0]) == (0.0, 1.0, 3.0)
    parted = history([0, 0, 0], [0, 1, 2], [0, 1, 2], "instants").windows()  # type: ignore[arg-type]
    assert [(w.begin, w.end, w.impulse[0]) for w in parted] == [(0.0, 1.0, 1.0), (1.0, 2.0, 1.0)]
    assert all(math.isnan(w.slip) and math.isnan(w.peak_force) for w in parted)
    assert history([], [], [], "events").windows() == ()
    (point,) = history([0, 1, 0], [0, 0, 0], [0, 1, 2], "steps").windows()  # type: ignore[arg-type]
    assert (point.begin, point.end, point.stick, point.peak_force) == (1.0, 1.0, 1.0, 5.0)
    assert str(point) == "1 s (by steps): 0 N s normal, at most 5 N"


def test_impulses_of_all_windows_are_that_of_the_contact() -> None:
    """Of any history of states and impulses: a random one, with all kinds of coincidences."""
    rng = np.random.default_rng(1)
    for located in ("events", "instants"):
        for _ in range(200):
            m = int(rng.integers(1, 12))
            gained = rng.integers(0, 2, m) * rng.random(m)
            gained[0] = 0.0
            given = history(
                rng.integers(0, 4, m).tolist(), np.cumsum(gained).tolist(), np.cumsum(rng.integers(0, 2, m)).tolist(),
                located,
            )  # fmt: skip
            windows = given.windows()
            total = given.impulse[-1] - given.impulse[0]
            assert sum((w.impulse for w in windows), np.zeros(2)) == pytest.approx(total, abs=1e-12)
            assert all(a.end <= b.begin for a, b in pairwise(windows))


def test_a_made_result_keeps_its_words(bounce: Result) -> None:
    """Of steps of which some are stored: the touch is between two instants, and the force of none is known."""
    (window,) = bounce.contact("floor").windows()
    assert (window.by, window.begin) == ("instants", pytest.approx(0.315))
    assert math.isnan(window.peak_force)
    (all_of_them,) = replace(bounce, steps=100).contact("floor").windows()
    assert all_of_them.by == "steps"
