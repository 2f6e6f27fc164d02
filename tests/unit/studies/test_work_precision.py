"""Errors converge as they must, costs are those of the runs, and nothing is claimed that is not known."""

from __future__ import annotations

import csv
import math
from dataclasses import dataclass, replace

import numpy as np
import pytest

import lcpflex as lf
from lcpflex import gallery
from lcpflex.accuracy.outputs import Measured, Part, error_between, resolution
from lcpflex.accuracy.refinement import brief
from lcpflex.errors import ModelError, StepError
from lcpflex.studies import Output, WorkPoint, WorkPrecision, work_precision
from lcpflex.studies.convergence.points import SceneStudy
from lcpflex.studies.convergence.reference import Reference
from lcpflex.studies.trial import Trial, in_order, predicted
from tests.rates import assert_rate

STEPS = (1e-2, 3e-3, 1e-3, 3e-4, 1e-4)
MOREAU_JEAN = [lf.MoreauJean(step=h) for h in STEPS]
FALL = math.sqrt(2.0 / 9.81)  # the ball of the gallery touches after this time and again twice as late


def ball_speed(t: np.ndarray) -> np.ndarray:
    first, second = 9.81 * FALL * 0.5, 9.81 * FALL * 0.25
    return np.where(
        t < FALL, -9.81 * t, np.where(t < 2.0 * FALL, first - 9.81 * (t - FALL), second - 9.81 * (t - 2.0 * FALL))
    )


SPEED = {"speed": lambda result: result.u[:, 1]}


@pytest.fixture(scope="module")
def ball() -> WorkPrecision:
    """Bouncing ball against its exact velocity, with its two jumps."""
    return work_precision(
        gallery.bouncing_ball, {"Moreau-Jean": MOREAU_JEAN}, {"speed": ball_speed},
        outputs={"speed": lambda result: result.u[:, 1]}, duration=1.0, repeats=2,
    )  # fmt: skip


@pytest.fixture(scope="module")
def slip() -> WorkPrecision:
    """A block that sticks and slips; the reference is found by the study itself, and confirmed by another method."""
    methods = {"Moreau-Jean": MOREAU_JEAN[:4], "generalised-alpha": [lf.GeneralizedAlpha(step=h) for h in STEPS[:3]]}
    return work_precision(gallery.scenes()["stick_slip"], methods, repeats=1)


def test_a_first_order_scheme_converges_across_jumps_with_order_one(ball) -> None:
    assert_rate([1.0 / p.steps for p in ball.points], [p.errors["speed"] for p in ball.points], 1.0, within=0.15)
    assert ball.points[-1].errors["speed"] < 1e-3


def test_at_equal_times_the_same_errors_do_not_converge() -> None:
    errors = []
    for h in STEPS[:3]:
        result = lf.simulate(gallery.bouncing_ball(), 1.0, lf.MoreauJean(step=h), record=0.0, progress=False)
        errors.append(np.abs(result.u[:, 1] - ball_speed(result.times)).max())
    assert min(errors) > 1.0


def test_the_reference_says_how_well_its_samples_show_the_jumps(ball) -> None:
    own = ball.of().reference.error["speed"]
    assert 0.0 < own <= 2.0 / 20000.0 * 1.03  # every second one tells a jump to two intervals


def test_a_jump_that_is_stored_twice_is_known_exactly() -> None:
    output, grid = Output("y", lambda result: 0.0), np.linspace(0.0, 1.0, 101)
    times = np.sort(np.append(grid, [0.333, 0.333]))
    after = np.arange(103) > np.flatnonzero(times == 0.333)[0]
    exact = Measured(times, (Part("y", np.where(after, 1.0 - times, -times).reshape(-1, 1, 1)),), None)
    assert resolution(output, exact, 1.0) < 1e-12
    blurred = Measured(grid, (Part("y", np.where(grid > 0.333, 1.0 - grid, -grid).reshape(-1, 1, 1)),), None)
    assert 1e-3 < resolution(output, blurred, 1.0) < 2e-2


@pytest.mark.parametrize(
    ("series", "largest"),
    [(MOREAU_JEAN[:3], 5e-3), ([lf.EventDriven(rtol=r, atol=0.1 * r) for r in (1e-4, 1e-5, 1e-6)], 1e-9)],
)
def test_the_error_a_reference_owns_up_to_holds_its_true_one(series, largest: float) -> None:
    work = work_precision(gallery.bouncing_ball, {"a": series}, outputs=SPEED, duration=1.0, repeats=0)
    exact = work_precision(gallery.bouncing_ball, {"a": series[:1]}, {"speed": ball_speed}, outputs=SPEED,
                           duration=1.0, repeats=0).of().reference  # fmt: skip
    found = work.of().reference
    true = error_between(work.of().outputs[0], found.measured["speed"], exact.measured["speed"], 1.0)
    blur = exact.error["speed"]  # of the jumps, which its samples do not show twice
    assert true <= 1.02 * found.error["speed"] + blur
    assert found.error["speed"] < largest
    assert blur < 2e-4


def test_what_lies_between_the_instants_of_a_run_is_not_taken_for_its_error() -> None:
    work = work_precision(
        gallery.bouncing_ball, {"a": MOREAU_JEAN[2:]}, lf.EventDriven(), outputs=SPEED, duration=1.0, repeats=0,
        instants=300,
    )  # fmt: skip
    study = work.of()
    coarse, *_, fine = study.points
    assert study.reference.error["speed"] < 1e-6  # it stores both sides of impacts
    assert coarse.errors["speed"] > 1e-4
    assert fine.unseen["speed"] > 1e-3  # ten instants for the steps of three hundred
    assert study.limited(fine, "speed")
    assert study.cheapest(1e-3) is None
    sentence, witness = study.advice([1.1 * fine.errors["speed"]])
    assert witness == "reference: EventDriven(rtol=1e-08); a agrees to " + f"{study.reference.reach('speed'):.2g}"
    assert sentence.startswith("no method can be said to have reached")
    assert "all that is certain is" in sentence
    assert (
        "0.001 % in speed: the reference, EventDriven(rtol=1e-08), is confirmed only within" in study.advice([1e-5])[0]
    )
    assert "| <* " in next(line for line in work.table().splitlines() if "step=0.0001 " in line)


def test_a_run_that_failed_does_not_end_its_series() -> None:
    failed = Trial(lf.EventDriven(rtol=1e-2), 10, (1.0,), None, "it broke")
    assert predicted([failed], lf.EventDriven(rtol=1e-3)) == 0.0
    assert predicted([replace(failed, failure="")], lf.EventDriven(rtol=1e-3)) == pytest.approx(3.0)


def test_cost_is_that_of_the_runs(ball) -> None:
    assert [point.steps for point in ball.points] == [round(1.0 / h) + (h == 3e-3) + (h == 3e-4) for h in STEPS]
    for point in ball.points:
        assert 0.0 < point.fastest <= point.wall_time <= point.slowest
        assert point.repeats == 2


def test_without_a_reference_the_study_finds_one_and_owns_up_to_its_error(slip) -> None:
    study = slip.of()
    own = study.reference.error["trajectory"]
    assert "Moreau-Jean" in study.reference.source
    assert 0.0 < own < 1e-3
    assert study.points[0].errors["trajectory"] > own
    assert study.limited(study.points[-1], "trajectory") == (study.points[-1].errors["trajectory"] <= own)
    assert slip.cheapest(0.5 * own) is None
    assert "the reference itself is only within" in slip.advice([0.5 * own])


def test_the_reference_bounds_its_own_error(slip) -> None:
    """Displacement and switching times of this scene are known exactly."""
    case = gallery.scenes()["stick_slip"]
    exact = work_precision(
        case, {"Moreau-Jean": MOREAU_JEAN[:4]}, {"end": case.reference["displacement"]},
        outputs={"end": lambda result: result.q[-1, 0]}, repeats=0,
    )  # fmt: skip
    found = work_precision(
        case, {"Moreau-Jean": MOREAU_JEAN[:4]}, outputs={"end": lambda result: result.q[-1, 0]}, repeats=0
    )
    for known, estimated in zip(exact.points, found.points, strict=True):
        off = abs(known.errors["end"] - estimated.errors["end"])
        assert off <= found.of().reference.error["end"]


def test_no_reference_claims_to_be_without_error(slip) -> None:
    assert slip.of().reference.error["peak force"] > 0.0  # the weight, in every run
    assert all(slip.of().limited(point, "peak force") for point in slip.points)
    assert "< 0.0e+00" not in slip.table()


def test_a_stepper_as_reference_is_run_twice() -> None:
    work = work_precision(
        gallery.scenes()["stick_slip"], {"Moreau-Jean": MOREAU_JEAN[:2]}, lf.MoreauJean(step=2e-4), repeats=0
    )
    study = work.of()
    assert study.reference.source == "MoreauJean(step=0.0002)"
    assert 0.0 < study.reference.error["trajectory"] < study.points[1].errors["trajectory"]


def test_outputs_that_never_were_are_left_out() -> None:
    work = work_precision(gallery.bouncing_ball, {"a": MOREAU_JEAN[:2]}, duration=0.2, repeats=0)
    assert [output.name for output in work.of().outputs] == ["trajectory", "energy"]
    assert not work.of().notes


@dataclass(frozen=True)
class Skewed:
    """A scheme that converges to another motion, refuses the scene, or breaks off."""

    step: float
    factor: float = 1.0
    refuse: bool = False
    stop: bool = False

    def start(self, system, duration, interval):
        if self.refuse:
            raise ModelError("scene: too round, expected corners")
        if self.stop:
            raise StepError("at t = 0.1 s: stuck", time=0.1, step=7)
        return lf.MoreauJean(step=self.step).start(replace(system, u=self.factor * system.u), duration, interval)


def test_failures_are_kept_and_never_recommended() -> None:
    methods = {
        "good": MOREAU_JEAN[:3],
        "stopping": [Skewed(1e-2, stop=True), Skewed(1e-3)],
        "refusing": [Skewed(1e-2, refuse=True)],
    }
    work = work_precision(gallery.block_on_incline, methods, duration=0.5, repeats=0)
    study = work.of()
    by_method = {label: [p for p in work.points if p.method == label] for label in methods}
    assert [bool(p.failure) for p in by_method["stopping"]] == [True, False]
    assert "stuck" in by_method["stopping"][0].failure
    assert by_method["stopping"][0].errors == {}
    assert study.methods == ("good", "stopping")
    assert study.refusals == {"refusing": "scene: too round, expected corners"}
    text = str(work)
    assert "failed: at t = 0.1 s: stuck" in text
    assert "refusing does not apply: scene: too round, expected corners" in text
    figure = work.plot()
    crosses = [
        line for ax in figure.axes[:2] for line in ax.lines if line.get_marker() == "x" and len(line.get_xdata())
    ]
    assert not crosses  # it has no time and no steps
    assert "refusing: does not apply" in figure.axes[3].get_legend().get_title().get_text()


def test_what_gains_energy_is_a_failure_unless_accepted() -> None:
    case, methods = gallery.scenes()["double_pendulum"], {"Moreau-Jean": MOREAU_JEAN[2:4]}
    height = {"height": lambda result: result.q[-1, 1]}
    warned = work_precision(case, methods, {"height": -0.1}, outputs=height, repeats=0)
    assert all("created energy" in point.failure for point in warned.points)
    assert warned.cheapest(1e9) is None
    figure = warned.plot()
    assert all(any(line.get_marker() == "x" for line in ax.lines) for ax in figure.axes[:3:2])
    accepted = work_precision(
        case, methods, {"height": -0.1}, outputs=height, repeats=0, energy_growth=lf.EnergyGrowth.ACCEPT
    )
    assert not any(point.failure for point in accepted.points)


def test_a_method_that_converges_elsewhere_is_named() -> None:
    methods = {"good": MOREAU_JEAN[:4], "skewed": [Skewed(h, 1.05) for h in STEPS[:3]]}
    work = work_precision(gallery.block_on_incline, methods, duration=0.5, repeats=0)
    good = [point.errors["trajectory"] for point in work.points if point.method == "good"]
    assert good[-1] < 1e-2
    assert any(note.startswith("skewed converges elsewhere") for note in work.of().reference.notes)


def test_a_series_ends_where_a_run_would_take_too_long() -> None:
    endless = [*MOREAU_JEAN[:2], lf.MoreauJean(step=1e-9)]  # half a milliard of them
    work = work_precision(gallery.block_on_incline, {"a": endless}, duration=0.5, repeats=0, limit=20.0)
    assert [point.steps for point in work.points] == [50, 167]
    assert "MoreauJean(step=1e-09) left out: about" in work.table()


def test_parameters_of_the_builder_make_lines_of_their_own() -> None:
    work = work_precision(
        gallery.elastic_bar, {"MJ": [lf.MoreauJean(step=h) for h in (2e-3, 1e-3)]}, duration=1.0, repeats=0,
        modes=[1, 4], elements=[20],
    )  # fmt: skip
    assert work.of().methods == ("MJ, modes=1, elements=20", "MJ, modes=4, elements=20")
    coarse, fine = (p for p in work.points if p.stepper == lf.MoreauJean(step=0.001))
    assert coarse.errors["trajectory"] > 2.0 * fine.errors["trajectory"]


def test_two_points_of_each_body_see_it_turn_and_bend() -> None:
    def tilted(angle: float = 0.0) -> lf.Scene:
        scene = lf.Scene(gravity=(0.0, 0.0))
        scene.add(lf.Box(width=1.0, height=1.0, mass=1.0), name="box", angular_velocity=1.0 + angle)
        return scene

    work = work_precision(tilted, {"a": [lf.MoreauJean(step=1e-2)]}, lf.MoreauJean(step=1e-2), duration=1.0, repeats=0)
    assert work.points[0].errors["trajectory"] < 1e-12
    work = work_precision(
        tilted, {"a": [lf.MoreauJean(step=1e-2)]}, lf.MoreauJean(step=1e-2), duration=1.0, repeats=0, angle=[0.1, 0.0]
    )
    assert work.points[0].errors["trajectory"] > 0.05


def study(scene: str = "scene", own: float = 1e-4) -> SceneStudy:
    """Two methods of known costs and errors."""
    output = Output("end", len, scale=1.0)
    points = tuple(
        WorkPoint(scene, method, lf.MoreauJean(step=0.1**k), 10**k, wall, wall, wall, 3, {"end": error}, failure)
        for k, (method, wall, error, failure) in enumerate(
            [
                ("fast", 1e-3, 5e-3, ""),
                ("fast", 1e-2, 2e-3, ""),
                ("slow", 2e-3, 5e-4, ""),
                ("slow", 1e-1, 1e-6, ""),
                ("bad", 1e-9, 1e-9, "wrong"),
            ]
        )
    )
    measured = {"end": Measured(np.zeros(1), (), 1.0)}
    return SceneStudy(scene, 1.0, (output,), Reference("exact", measured, {"end": own}), points)


def test_the_cheapest_is_certain_within_the_tolerance() -> None:
    work = WorkPrecision((study(),))
    assert [work.cheapest(tolerance).wall_time for tolerance in (1e-2, 1e-3, 5e-4)] == [1e-3, 2e-3, 1e-1]
    assert work.cheapest(1e-4) is None  # the reference is no better known
    assert work.advice().splitlines() == [
        "cheapest method for 1 % in end: fast, MoreauJean(step=1) (1 ms, 1 steps, within 0.51 %)",
        "cheapest method for 0.1 % in end: slow, MoreauJean(step=0.01) (2 ms, 100 steps, within 0.06 %)",
        "no method can be said to have reached 0.01 % in end: the reference itself is only within 0.01 %",
    ]
    assert WorkPrecision((study(own=0.0),)).advice([1e-7]) == "no method reached 1e-05 % in end"
    assert "error of the reference is not known" in WorkPrecision((study(own=math.nan),)).advice([1e-2])


def test_scenes_are_joined() -> None:
    both = WorkPrecision((study(),)) + WorkPrecision((study(),))
    assert [one.scene for one in both.studies] == ["scene", "scene (2)"]
    assert both.points[-1].scene == "scene (2)"
    assert both.advice([1e-2]).splitlines()[1].startswith("scene (2): cheapest")
    assert len(both.plot().axes) == 8


def test_csv_holds_every_run(slip, tmp_path) -> None:
    slip.csv(tmp_path / "runs.csv")
    with (tmp_path / "runs.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [float(row["error of trajectory"]) for row in rows] == [p.errors["trajectory"] for p in slip.points]
    assert [int(row["steps"]) for row in rows] == [p.steps for p in slip.points]


def test_the_table_is_markdown_with_a_row_for_each_run(slip) -> None:
    rows = [line for line in slip.table().splitlines() if line.startswith("|")]
    assert len(rows) == 2 + len(slip.points)
    assert len({row.count("|") for row in rows}) == 1


def test_the_chart_shows_every_sound_run(slip, tmp_path) -> None:
    figure = slip.plot("energy")
    shown = [x for line in figure.axes[2].lines if line.get_linestyle() == "None" for x in line.get_xdata()]
    assert sorted(shown) == sorted(float(p.steps) for p in slip.points)
    figure.savefig(tmp_path / "chart.png", dpi=50)


def test_long_labels_and_bars_stay_in_their_places() -> None:
    label = "Moreau-Jean | with Newton's law of impact and a name of many words"
    work = work_precision(gallery.scenes()["stick_slip"], {label: MOREAU_JEAN[:2]}, repeats=0)
    table = [line for line in work.table().splitlines() if line.startswith("|")]
    assert len({line.count("|") for line in table}) == 1
    figure = work.plot()
    figure.canvas.draw()
    legend = figure.axes[3].get_legend()
    assert legend.get_window_extent().x1 <= figure.bbox.x1


def test_steppers_are_told_briefly_and_run_from_coarse_to_fine() -> None:
    assert brief(lf.MoreauJean(step=1e-3)) == "MoreauJean(step=0.001)"
    assert brief(lf.EventDriven(rtol=1e-5)) == "EventDriven(rtol=1e-05)"
    adaptive = lf.MoreauJean(step=1.0, adaptive=lf.AdaptiveStep(rtol=1e-3))
    assert brief(adaptive) == "MoreauJean(step=1, adaptive=AdaptiveStep(rtol=0.001))"
    assert in_order(MOREAU_JEAN[::-1]) == MOREAU_JEAN


def test_runs_claim_no_less_than_they_are_off_by(tmp_path) -> None:
    """A disc bounces: what the reruns of each run say is at least its true error, and at most a few times it."""

    def dropped() -> lf.Scene:
        scene = lf.Scene()
        disc = scene.add(lf.Disc(radius=0.05, mass=1.0), name="disc", position=(0.0, 0.3))
        floor = scene.ground.half_plane((0.0, 0.0), (0.0, 1.0))
        scene.contact(disc.surface(), floor, restitution=0.5, name="floor")
        return scene

    work = work_precision(
        {"disc": dropped},
        {"steps": [lf.MoreauJean(step=h) for h in (4e-3, 1e-3)], "events": lf.EventDriven(rtol=1e-4)},
        lf.EventDriven(rtol=1e-10), outputs="motion", duration=0.4, repeats=0, claims=True, progress=False,
    )  # fmt: skip
    steps = [point for point in work.points if point.method == "steps"]
    for point in steps:
        assert point.errors["motion"] <= point.claims["motion"] <= 3.0 * point.errors["motion"]
    assert "| claimed |" in work.table()
    work.csv(tmp_path / "runs.csv")
    assert "claimed error of motion" in (tmp_path / "runs.csv").read_text().splitlines()[0]
    _, _, claimed, _ = work.plot().axes
    assert claimed.get_title(loc="left") == "claimed against true"
    drawn = [line for line in claimed.get_lines() if line.get_marker() not in ("None", "")]
    assert sum(len(line.get_xdata()) for line in drawn) >= len(steps)
    assert len(work.plot(panels=("error", "steps")).axes) == 3
    with pytest.raises(ModelError, match="panels"):
        work.plot(panels=("colour",))
