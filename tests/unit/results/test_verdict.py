"""The verdict of a result: its first word decides, its reasons say what to do, and no number takes a word back."""

from __future__ import annotations

import pickle
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.basics.alarm import Alarm
from lcpflex.results.doubts import doubts
from lcpflex.results.energy_balance import Energies
from lcpflex.results.heading import heading
from lcpflex.results.measured_error import MeasuredError
from lcpflex.results.result import Result

UNVERIFIED = (
    "Unverified: how accurate the steps are is not known; result.verify() measures it, for about six times the work of "
    "this run. Its checks pass (energy, contact problems, gaps, joints), which say nothing of that."
)
EXTENT = "of 50 mm, the largest extent or travel"


def measured(place: float = 0.012, turn: float = 0.0, speed: float = 0.03, **other: Any) -> MeasuredError:
    """An error in shares of 50 mm and of 2 m/s, at six times of which the last one is the first that it is found at."""
    late = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 1.0])[:, None]
    known: dict[str, Any] = {
        "times": np.linspace(0.0, 0.5, 6), "place_curve": 0.05 * place * late, "turn_curve": 0.05 * turn * late,
        "speed_curve": 2.0 * speed * late, "speed_rms": 2.0 * 0.004, "extent": 0.05, "fastest": 2.0, "horizon": 0.5,
        "whole": True, "parted": "", "bodies": ("ball",), "gap_curve": {}, "force": {}, "impulse": {},
        "touches": (("floor", (11, 11, 11)),), "reruns": (),
    }  # fmt: skip
    return MeasuredError(**known | other)


@pytest.fixture(params=[False, True], ids=["plane", "space"])
def run(request: pytest.FixtureRequest) -> Result:
    """A ball that falls on the floor."""
    radius, place = 0.05, 0.15
    if request.param:
        scene: Any = lf.SpatialScene(gravity=(0.0, 0.0, -9.81))
        ball = scene.add(lf.Sphere(radius, mass=1.0), name="ball", position=(0.0, 0.0, place))
        floor = scene.ground.plane((0, 0, 0), (0, 0, 1))
    else:
        scene = lf.Scene()
        ball = scene.add(lf.Disc(radius, mass=1.0), name="ball", position=(0.0, place))
        floor = scene.ground.half_plane((0, 0), (0, 1))
    scene.contact(ball.surface(), floor, name="floor")
    return lf.simulate(scene, 0.5, lf.MoreauJean(step=1e-3), progress=False)


def test_a_run_that_passes_its_checks_is_unverified(run: Result) -> None:
    verdict = run.verdict
    assert (verdict.word, verdict.level, verdict.reasons) == ("Unverified", 1, ())
    assert str(verdict) == UNVERIFIED
    assert run.summary().split("\n\n")[-1] == UNVERIFIED
    assert run.summary().splitlines()[0] == "ball; contact floor: MoreauJean, step 0.001 s"
    assert verdict.numbers["penetration"] == run.penetration.max() > 0.0
    assert verdict.numbers["unexplained"] == run.energies.relative_remainder
    assert set(verdict.numbers) == {"unexplained", "residual", "strict", "penetration", "drift"}


def test_warnings_are_named_and_change_no_word(run: Result) -> None:
    warned = replace(run, warnings=("a mesh is coarse",))
    assert (warned.verdict.word, warned.verdict.reasons) == ("Unverified", ("a mesh is coarse",))
    assert str(warned.verdict) == f"{UNVERIFIED} Read its warnings."
    trusted = replace(warned, error=measured())
    assert trusted.verdict.word == "Trusted"
    assert str(trusted.verdict).endswith(" Read its warnings.")


def test_a_measured_error_is_trusted_within_it(run: Result) -> None:
    verdict = replace(run, error=measured()).verdict
    assert (verdict.word, verdict.level) == ("Trusted", 2)
    assert str(verdict) == (
        f"Trusted within 1.2 % in positions (600 µm {EXTENT}), and 3 % of the largest speed in velocities between "
        "impacts (0.4 % on the average of all times). Touches in this run and its reruns: 'floor' 11, 11, 11."
    )
    assert verdict.numbers["place"] == pytest.approx(0.012)
    assert verdict.numbers["horizon"] == 0.5
    small = str(replace(run, error=measured(speed=1e-14)).verdict)
    assert "and less than 0.0001 % of the largest speed in velocities" in small


def test_steps_and_modes_are_told_together_the_larger_error_first(run: Result) -> None:
    turned = replace(run, error=measured(turn=0.02, modes=1e-4)).verdict
    assert str(turned).startswith(
        f"Trusted within 2.2 % in positions (1.1 mm {EXTENT}: steps 2 %, modes 0.2 %), and 3 %"
    )
    assert turned.numbers["modes"] == pytest.approx(2e-3)
    late = str(replace(run, error=measured(modes=1e-2, modes_horizon=0.125)).verdict)
    assert late == (
        f"Trusted up to 125 ms within 5 % in positions (2.5 mm {EXTENT}: steps less than 0.0001 %, modes 5 %), and "
        "less than 0.0001 % of the largest speed in velocities between impacts; after that positions may be off by "
        "20 % (10 mm): give the bodies more modes (the steps alone err by 1.2 % up to 500 ms). Touches in this run "
        "and its reruns: 'floor' 11, 11, 11."
    )


def test_notes_on_reruns_are_told(run: Result) -> None:
    verdict = replace(run, error=measured(notes=("few instants were compared", "no end " * 50))).verdict
    assert " Few instants were compared. No end no end" in str(verdict)
    assert len(str(verdict)) < 450
    assert verdict.reasons == ("few instants were compared", "no end " * 50)


def test_velocities_that_are_far_off_are_not_trusted_with_places(run: Result) -> None:
    wrong = str(replace(run, error=measured(speed=0.4, speed_rms=0.2)).verdict)
    assert wrong.startswith(
        f"Trusted within 1.2 % in positions (600 µm {EXTENT}), but 40 % of the largest speed in velocities between "
        "impacts (10 % on the average of all times)."
    )


def test_a_run_that_parts_is_trusted_up_to_there(run: Result) -> None:
    touches = (("floor", (11, 13, 21)), ("wall", (2, 2, 2)))
    parted = "from touch 2 of 'floor' on the runs part"
    curve = 0.05 * np.array([0.0, 0.0, 0.002, 0.002, 0.1, 0.4])[:, None]
    error = measured(whole=False, horizon=0.31, parted=parted, place_curve=curve, touches=touches)
    verdict = replace(run, error=error).verdict
    assert str(verdict) == (
        f"Trusted up to 310 ms within 0.2 % in positions (100 µm {EXTENT}), and less than 0.0001 % of the largest "
        "speed in velocities between impacts; after that, from touch 2 of 'floor' on, the reruns part from the run: a "
        "shorter step or tighter tolerances may carry farther. Touches in this run and its reruns: 'floor' 11, 13, 21; "
        "'wall' 2, 2, 2."
    )
    assert verdict.numbers["place"] == pytest.approx(0.4)
    early = replace(run, error=measured(0.01, whole=False, horizon=0.31, parted="the runs part")).verdict
    assert "; no rerun came farther." in str(early)
    assert "part" not in str(early)


def test_loads_that_are_shared_in_more_ways_are_told(run: Result) -> None:
    note = "contacts with friction share a load in more ways than one, as 'a' and 'b'"
    assert "another method may come to another motion" in str(replace(run, error=measured(), notes=(note,)).verdict)


@pytest.mark.parametrize("share", [0.4, np.nan])
def test_what_parts_from_the_beginning_is_not_trusted_at_all(run: Result, share: float) -> None:
    verdict = replace(run, error=measured(share, whole=False, horizon=0.004)).verdict
    assert (verdict.word, verdict.level) == ("NOT to be trusted", 0)
    assert "rusted within" not in str(verdict)
    (alarm,) = verdict.reasons
    assert isinstance(alarm, Alarm)
    assert (alarm.what, alarm.when) == ("accuracy", 0.004)
    assert alarm.advice.startswith("take a shorter step")


def test_a_doubt_outweighs_a_measured_error(run: Result) -> None:
    e = run.energies
    grown = Energies.audit(e.kinetic * 1.5, e.elastic, e.potential, e.friction, e.impact, e.damping, e.work)
    doubtful = replace(run, energies=grown, error=measured())
    assert doubtful.verdict.word == "NOT to be trusted"
    (alarm,) = doubts(doubtful)
    assert str(doubtful.verdict) == f"NOT to be trusted: {alarm}."
    assert alarm.what == "energy"
    assert alarm.when == doubtful.times[np.argmax(np.abs(grown.remainder))]
    assert alarm.amount == pytest.approx(grown.remainder.max())
    two = replace(doubtful, residual=np.full(len(run.times), 1e-3)).verdict
    assert len(two.reasons) == 2
    lines = str(two).splitlines()
    assert lines[0] == "NOT to be trusted, for 2 reasons:"
    assert lines[1:] == [f"  {alarm}." for alarm in two.reasons]
    assert "an be trusted" not in str(two)


def test_every_alarm_of_a_run_says_what_to_do(run: Result) -> None:
    """And when, of those that happen at a time."""
    last = np.arange(len(run.times)) == len(run.times) - 1
    broken = replace(
        run,
        complete=False,
        message="a callback raised",
        duration=2.0,
        q=np.where(last[:, None], np.nan, run.q),
        residual=np.where(last, 1.0, 0.0),
        joint_drift=np.where(last, 1.0, 0.0),
    )
    found = doubts(broken)
    assert {alarm.what for alarm in found} == {"end", "numbers", "contact problem", "joint drift"}
    for alarm in found:
        assert alarm.when == run.times[-1]
        assert alarm.advice
        assert str(alarm) == alarm.text == f"{alarm.clause}: {alarm.advice}"


def test_an_alarm_keeps_its_parts(run: Result, tmp_path: Path) -> None:
    """In copies and in files; what older files hold as a text is an alarm without them."""
    alarm = Alarm("contact 'lock' is broken", "lock", "contact 'lock'", 0.25, 1e-2, "mend it")
    assert alarm == "contact 'lock' is broken: mend it"
    wrong = replace(run, found_wrong=(alarm, "the ball went through the floor"))
    stored = Result.load(wrong.save(tmp_path / "wrong.npz"))
    for again in (pickle.loads(pickle.dumps(wrong)), stored):
        kept, text = again.found_wrong
        assert vars(kept) == vars(alarm)
        assert text == "the ball went through the floor"
        assert doubts(again) == (alarm, text)
        assert doubts(again)[1].what == text
        assert again.verdict == wrong.verdict


def test_a_user_system_has_a_verdict_and_a_heading(bounce: Result) -> None:
    assert str(bounce.verdict) == UNVERIFIED
    assert heading(bounce) == "a system of 1 coordinate; contact floor: MoreauJean, step 0.001 s"
    assert "Trusted within 1.2 % in positions (of their ranges), and 3 %" in str(
        replace(bounce, error=measured()).verdict
    )


def test_an_event_driven_run_is_verified_at_less_cost(bounce: Result) -> None:
    assert "for about twice the work of this run" in str(replace(bounce, stepper=repr(lf.EventDriven())).verdict)


def test_many_bodies_and_contacts_are_counted() -> None:
    scene = lf.Scene()
    for k in range(5):
        disc = scene.add(lf.Disc(0.1, mass=1.0), position=(k, 1.0))
        scene.contact(disc.surface(), scene.ground.half_plane((0, 0), (0, 1)))
    result = lf.simulate(scene, 0.01, lf.MoreauJean(1e-3, adaptive=lf.AdaptiveStep(rtol=1e-4)), progress=False)
    told = result.summary().splitlines()[0]
    assert told == "5 bodies; 5 contacts: MoreauJean, step 0.001 s, adaptive AdaptiveStep (rtol 0.0001)"
