"""Impacts and reversals of slip that accumulate: bounces too low to be resolved end, too many events end earlier."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from lcpflex import gallery
from lcpflex.dynamics.impact_laws import Poisson, Stronge
from lcpflex.steppers.event_driven.memory import EVENT_KINDS, REVERSES, WINDOW, EventSettings
from lcpflex.steppers.event_driven.thresholds import Thresholds
from tests.run_warnings import of_the_run
from tests.scenes import disc_on_floor, floor_of


@pytest.mark.parametrize("impact", [lf.Newton(), Poisson(), Stronge()], ids=repr)
@pytest.mark.parametrize("restitution", [0.02, 0.2, 0.5])
@pytest.mark.parametrize(
    ("gravity", "height"), [(1e4, 1e-3), (1e6, 1e-2), (9810.0, 1.0)], ids=["pressed", "hard", "millimetres"]
)
def test_bounces_under_a_large_force_end(gravity: float, height: float, restitution: float, impact: Any) -> None:
    """At t1 (1 + e) / (1 - e), exactly; a ball that is pressed on went on to bounce in the last figures of its gap."""
    first = math.sqrt(2.0 * height / gravity)
    end = first * (1.0 + restitution) / (1.0 - restitution)
    result = lf.simulate(
        disc_on_floor(0.1 + height, gravity=gravity, restitution=restitution), 1.5 * end, lf.EventDriven(impact=impact)
    )
    impacts = [event.time for event in result.events if event.kind == "impact"]
    expected = [first * (1.0 + 2.0 * sum(restitution**k for k in range(1, n + 1))) for n in range(len(impacts))]
    assert impacts == pytest.approx(expected, abs=1e-6 * end)
    assert math.log(1e-8) / math.log(restitution) < 2 * len(impacts) < 2 + 2 * math.log(1e-10) / math.log(restitution)
    assert impacts[-1] == pytest.approx(end, abs=1e-5 * end)
    assert result.q[-1, 1] == pytest.approx(0.1, abs=1e-9)
    assert result.energies.relative_remainder < 1e-6
    assert not of_the_run(result)


def flexible_links(count: int, restitution: float, friction: float = 0.0, modes: int = 2) -> lf.Scene:
    """Steel strips on pins with play, released from rest in a row; the first one hangs on the ground."""
    scene = lf.Scene(gravity=(0.0, -9.81))
    strip = lf.Beam(0.1, 0.02, 0.005, density=7800, youngs_modulus=2.1e11).reduce(modes=modes)
    holder: Any = scene.ground.at(0.0, 0.0)
    for k in range(count):
        link = scene.add(strip, name=f"link{k + 1}", position=(0.1 * k, 0.0))
        scene.revolute_with_clearance(
            holder, link.point("left"), 5e-3, 5.2e-3, friction, restitution, name=f"joint{k + 1}"
        )
        holder = link.point("right")
    return scene


@pytest.mark.parametrize("friction", [0.0, 0.1])
def test_chain_with_clearances(friction: float) -> None:
    """The pin of the first joint falls through its play, and bounces six times on a strip that vibrates."""
    scene = flexible_links(2, 0.2, friction)
    result = lf.simulate(scene, 8e-3, lf.EventDriven(), record=1e-4)
    impacts = [event for event in result.events if event.kind == "impact"]
    assert impacts[0].time == pytest.approx(math.sqrt(2 * 2e-4 / 9.81), abs=1e-6)
    assert 6 <= len(impacts) <= 9
    (said,) = of_the_run(result)
    assert "does not set the rebound" in said
    assert result.energies.relative_remainder < 1e-6
    stepped = lf.simulate(scene, 8e-3, lf.MoreauJean(step=2e-7, gap_tolerance=1e-9), record=1e-4)
    rigid = [0, 1, 2, 5, 6, 7]
    moved = np.abs(stepped.q[-1, rigid] - stepped.q[0, rigid]).max()
    assert np.abs(result.q[-1, rigid] - stepped.q[-1, rigid]).max() < 5e-4 * moved
    fastest = np.abs(stepped.u[-1, rigid]).max()
    assert np.abs(result.u[-1, rigid] - stepped.u[-1, rigid]).max() < 5e-4 * fastest


@pytest.mark.parametrize(("modes", "told"), [(2, False), (4, True)])
def test_ten_links_go_on_with_a_word_where_they_rattle_too_fast(modes: int, told: bool) -> None:
    """With four modes a link, ten joints have more than a hundred thousand impacts a second."""
    stepper = lf.EventDriven(most_events=1e5)
    result = lf.simulate(flexible_links(10, 0.2, modes=modes), 0.05, stepper, record=1e-3)
    assert result.complete
    assert result.energies.relative_remainder < 1e-5
    assert "does not set the rebound" in of_the_run(result)[-1]
    if not told:
        assert len(of_the_run(result)) == 1
        return
    fastest = np.abs(result.u[:, 1 :: 3 + modes]).max()
    said, _ = of_the_run(result)
    assert "events accumulated faster than 100000 a second (most_events)" in said
    assert "'joint1'" in said
    stopped = float(said.split("approach slower than ")[1].split(" m/s")[0])
    assert 0.99e-5 * math.sqrt(9.81 * 0.1) / math.pi <= stopped <= 1e-2 * fastest  # ten thresholds


def test_thresholds_return_and_say_what_they_were() -> None:
    """A ball of e = 0.99 on a run that may see 500 events a second: it comes to rest a little earlier, and says so."""
    scene = gallery.bouncing_ball(height=2e-4, restitution=0.99)
    exact = lf.simulate(scene, 2.0, lf.EventDriven(velocity_threshold=1e-6), record=0.01)
    sooner = lf.simulate(scene, 2.0, lf.EventDriven(velocity_threshold=1e-6, most_events=500.0), record=0.01)
    assert not of_the_run(exact)
    (said,) = of_the_run(sooner)
    assert "approach slower than 1e-05 m/s was stopped" in said
    assert "once" in said
    rest = [next(e.time for e in result.events if e.kind == "touch-down") for result in (exact, sooner)]
    assert 0.0 < rest[0] - rest[1] < 2.0 * 1e-5 / (9.81 * 0.01)
    assert np.abs(exact.q[-1] - sooner.q[-1]).max() < 1e-9
    assert sooner.energies.relative_remainder < 1e-7


def settings() -> EventSettings:
    return EventSettings(1.0, 0.1, 1e-8, 1e-10, 1.0, 1e-9, 1e-6, 1e-9, 0, False, WINDOW / 1e5, 0.1, 1e-9, math.inf)


def test_the_threshold_that_rises_is_that_of_what_accumulates() -> None:
    """Reversals raise that of slip, impacts that of approach; none beyond a hundredth of what contacts have had."""
    slips = [(1e-6 * k, EVENT_KINDS[REVERSES], k % 2, 0.0) for k in range(WINDOW)]
    impacts = [(1e-6 * k, EVENT_KINDS[0], 0, 0.0) for k in range(WINDOW)]
    of_slip, of_impacts = Thresholds(settings()), Thresholds(settings())
    assert of_slip.rise(slips, 0.5, 1.0, 0.1)
    assert (of_slip.settings.slip_threshold, of_slip.settings.velocity_threshold) == pytest.approx((1e-7, 1e-6))
    assert of_impacts.rise(impacts, 0.5, 1.0, 2e-6)
    assert (of_impacts.settings.slip_threshold, of_impacts.settings.velocity_threshold) == pytest.approx((1e-9, 1e-5))
    assert of_impacts.settings.calm == pytest.approx(0.5 + 4.0 * 0.01)
    (said,) = of_slip.remarks(lambda law: f"'{law}'")
    assert "slip slower than 1e-07 m/s counted as none" in said
    assert "contacts '0', '1'" in said
    while of_slip.rise(slips, 0.6, 1.0, 0.1):
        pass
    assert of_slip.settings.slip_threshold == pytest.approx(1e-2)
    of_slip.fall()
    assert of_slip.settings == settings()
    assert not Thresholds(settings()).rise(impacts, 0.5, 1e-5, 2e-8)
    assert not Thresholds(settings()).rise(impacts, 0.5, 1.0, 2e-2)  # no threshold would end these
    assert not Thresholds(settings()).remarks(str)


def dominoes(count: int, height: float, width: float, gap: float, friction: float, restitution: float) -> lf.Scene:
    """A row of boxes on a floor, the first of which falls against the next at 3 rad/s."""
    scene = lf.Scene()
    floor = floor_of(scene)
    before = None
    for k in range(count):
        turned = {"velocity": (1.5 * height, -1.5 * width), "angular_velocity": -3.0} if k == 0 else {}
        place = (k * (gap + width), 0.5 * height)
        domino = scene.add(lf.Box(width, height, mass=0.01), name=f"domino{k + 1}", position=place, **turned)
        scene.contact(domino.surface(), floor, friction, restitution, name=f"floor{k + 1}")
        if before is not None:
            scene.contact(domino.surface(), before.surface(), friction, restitution, name=f"pair{k}")
        before = domino
    return scene


# Moreau-Jean comes no nearer with its step here: 5.7e-4 rad at 4e-5 s, 5.4e-4 at 2e-5, 1.3e-3 at 1e-5.
APART = pytest.mark.xfail(reason="strikes in the midst of chatter differ at any step", strict=False)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("height", "width", "gap", "friction", "restitution"),
    [
        (0.1, 0.02, 0.03, 0.3, 0.0),
        (0.1, 0.01, 0.03, 0.4, 0.0),
        pytest.param(0.05, 0.008, 0.02, 0.3, 0.2, marks=APART),
        (0.05, 0.008, 0.02, 0.5, 0.1),
    ],
)
def test_twenty_dominoes_fall_and_come_to_rest(
    height: float, width: float, gap: float, friction: float, restitution: float
) -> None:
    """Slip of those that lean spirals to rest in a million reversals, and ended the run before the row had settled."""
    result = lf.simulate(dominoes(20, height, width, gap, friction, restitution), 1.5, lf.EventDriven(), record=0.01)
    assert result.complete
    assert result.energies.relative_remainder < 1e-5
    assert np.nanmin(result.gap) > -1e-7
    assert (result.q[-1, 2::3] < -0.3).all()
    stepped = lf.simulate(dominoes(20, height, width, gap, friction, restitution), 1.5, lf.MoreauJean(step=1e-5))
    assert np.abs(result.q[-1, 2::3] - stepped.q[-1, 2::3]).max() < 1e-3  # [rad]: of order 1 in its step
    for said in of_the_run(result):
        assert "events accumulated faster than 45" in said  # 1e5 in the time in which they pass their height
        assert "slip slower than" in said or "approach slower than" in said


@pytest.mark.slow
def test_ten_links_for_half_a_second() -> None:
    """Hundreds of thousands of impacts; energy is kept, and the joints stay within their play."""
    result = lf.simulate(flexible_links(10, 0.2, modes=4), 0.5, lf.EventDriven(), record=1e-3)
    assert result.complete
    assert result.energies.relative_remainder < 5e-6  # rounding and tolerances of so many steps: 1.04e-6
    assert np.nanmin(result.gap) > -1e-8
