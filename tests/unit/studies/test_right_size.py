"""The study of fidelity: its law of errors, what it refuses, and what it says when it cannot say much."""

from __future__ import annotations

import argparse
import csv
import math
from dataclasses import replace

import numpy as np
import pytest

import lcpflex as lf
from lcpflex import gallery
from lcpflex.accuracy.outputs import error_between
from lcpflex.cli.right_size import add_right_size
from lcpflex.errors import ModelError
from lcpflex.scene.scene import Scene
from lcpflex.scene.substitution import settled
from lcpflex.studies import right_size
from lcpflex.studies.model_order.report import FidelityRun, RightSize
from lcpflex.studies.model_order.scenes import comparable, of_scene
from lcpflex.studies.model_order.search import Search
from lcpflex.studies.model_order.verdict import scatter
from tests.unit.studies.fidelity_scenes import strip

STEP = lf.MoreauJean(step=2e-3)


def wall(elements: int = 40) -> Scene:
    return gallery.elastic_bar(elements=elements)


@pytest.fixture(scope="module")
def found() -> RightSize:
    """A bar strikes a wall, tolerance 5 %."""
    return right_size(wall, tolerance=0.05, duration=1.5, stepper=STEP, verify=False, progress=False)


def test_the_bar_needs_modes_and_says_how_many(found) -> None:
    assert found.within
    assert found.complete
    assert not found.full_was_run
    assert set(found.errors) == {"motion", "impulses"}
    assert max(found.errors.values()) <= 0.05
    assert found.chosen.levels == found.levels
    assert found.scene.body("bar").source.modes == int(found.levels["bar"].split()[0])
    poorer = [run for run in found.runs if run.coordinates < found.chosen.coordinates]
    assert poorer
    assert not any(run.within for run in poorer)
    sentence = found.sentence()
    assert sentence.startswith(f"{found.levels['bar']} for the bar: motion within ")
    assert "of the full mesh" in sentence
    (more,) = found.next
    assert more.error < max(found.errors.values())
    assert f"| bar: {int(found.levels['bar'].split()[0]) * 2} modes " in found.table()


def test_the_error_of_the_step_is_told_apart() -> None:
    """It falls with the step, while that of the bodies stays, and covers the difference to a run without steps."""
    fidelities = of_scene(wall)
    (motion,) = outputs = comparable(fidelities, "motion")

    def at(stepper) -> Search:
        search = Search(fidelities, outputs, 0.05, 1.5, lambda scene: stepper, 60.0)
        search.run((2,))
        search.reference = (2,)
        return search

    exact = at(lf.EventDriven(rtol=1e-10)).trials[2,].measured["motion"]
    errors = []
    for step in (4e-3, 1e-3):
        search = at(lf.MoreauJean(step))
        found = search.claim((2,), outputs, 2)
        true = error_between(motion, search.trials[2,].measured["motion"], exact, 1.5)
        assert true <= found.largest <= 2.5 * true
        assert [one.what for one in found.reruns] == ["a quarter of the step", "another method"]
        assert len(search.claim((2,), outputs, 1).reruns) == 1
        search.tolerance = 0.5 * true
        assert len(search.claim((2,), outputs, 2).reruns) == 1  # the first says all that there is to say
        errors.append(found.largest)
    assert 0.0 < errors[1] < 0.5 * errors[0]


def test_the_scene_that_is_returned_runs_as_it_did(found) -> None:
    result = lf.simulate(found.scene, 1.5, STEP, progress=False)
    assert result.impulse[-1].sum() == pytest.approx(200.0, rel=0.1)


def test_a_smaller_tolerance_climbs_to_the_full_mesh() -> None:
    whole = right_size(lambda: wall(8), tolerance=1e-4, duration=1.5, stepper=STEP, progress=False)
    assert whole.proved
    assert whole.levels == {"bar": "full mesh"}
    assert whole.full_was_run
    assert whole.step_error > 1e-4
    assert not whole.within  # the steps of the full mesh itself are off by more than that
    assert whole.sentence().startswith("Nothing is promised: the steps leave an error of ")
    assert (
        "with full mesh for the bar, by reruns: at this tolerance they decide more than the bodies" in whole.sentence()
    )
    assert "is needed" not in whole.sentence()


def test_what_is_not_proved_is_said_to_be_so() -> None:
    best = right_size(lambda: wall(8), tolerance=1e-4, duration=1.5, stepper=STEP, verify=False, progress=False)
    assert not best.within
    assert not best.full_was_run
    assert best.sentence().startswith(
        "No level is proved to be within 0.01 % of the full mesh: the best that was run, "
    )
    assert best.scene is not None


def test_a_mesh_that_cannot_be_run_is_extrapolated_to() -> None:
    """Levels without the last one, as of a very large mesh: its richest level is not taken for the truth."""
    scene = wall()
    bar = scene.body("bar").source
    cut = scene.with_bodies({"bar": replace(bar, fidelity_levels=lambda: bar.fidelity_levels()[:-1])})
    part = right_size(cut, tolerance=0.05, duration=1.5, stepper=STEP, progress=False)
    assert part.reference == {"bar": "16 modes"}
    assert not part.full_was_run
    assert math.isnan(part.full)
    last = part.runs[-1]
    assert last.reference
    assert not last.full
    assert last.estimate > 0.004  # of N modes about 1/4N is lacking
    assert "too large to be run" in part.table()
    assert part.plot() is not None
    exact = right_size(scene, tolerance=1e-9, duration=1.5, stepper=STEP, progress=False)  # climbs to the full mesh
    true = next(run.estimate for run in exact.runs if run.levels == {"bar": "16 modes"})
    assert 0.2 <= true / last.estimate <= 5.0


def test_runs_that_would_take_too_long_are_left_out() -> None:
    short = right_size(wall, tolerance=1e-9, duration=1.5, stepper=lf.MoreauJean(step=1e-4), limit=1e-6, progress=False)
    assert not short.within
    assert not short.full_was_run
    assert any("the budget of" in run.failure for run in short.runs)


COARSE = lf.MoreauJean(step=1e-4)  # far too long a step for the strip: contacts create energy with rich bodies


@pytest.mark.slow
def test_runs_that_cannot_be_trusted_are_shown_and_not_chosen() -> None:
    coarse = right_size(strip, "motion", 0.05, duration=0.03, stepper=COARSE, progress=False)
    assert not coarse.within
    failed = [run for run in coarse.runs if run.failure]
    assert failed
    assert not any(run.within or run.errors for run in failed)
    assert "failed: contact impulses created energy" in coarse.table()
    (note,) = coarse.notes
    assert "full mesh cannot be trusted" in note
    assert coarse.full_was_run  # for its time
    assert type(coarse.better).__name__ == "GeneralizedAlpha"
    assert coarse.sentence().endswith("use that, or give none.")
    whole = strip().body("pendulum").source.fidelity_levels()[-1].make()
    assert not lf.simulate(strip().with_bodies({"pendulum": whole}), 0.03, coarse.better, progress=False).warnings


@pytest.mark.slow
def test_the_stepper_of_a_case_is_exchanged_where_it_cannot_be_trusted() -> None:
    case = gallery.Case("strip", "a strip", strip, 0.03, COARSE)
    found = right_size(case, "motion", 0.05, progress=False)
    assert found.within
    assert type(found.stepper).__name__ == "GeneralizedAlpha"
    assert found.better is None
    assert found.notes[0].startswith("MoreauJean(step=0.0001) was given up: pendulum: full mesh cannot be trusted")
    kept = right_size(gallery.Case("bar", "a bar", wall, 1.5, STEP), tolerance=0.05, progress=False)
    assert kept.stepper is STEP
    assert not kept.notes


@pytest.mark.slow
def test_a_default_step_is_shortened_until_it_decides_less_than_the_bodies() -> None:
    few = strip(elements=16)
    found = right_size(few, "motion", 5e-4, duration=0.004, progress=False)
    assert "was given up: its steps leave an error of" in found.notes[0]
    assert found.step_error <= 5e-4
    assert "they decide" not in found.sentence()


class Flat(Search):
    """A search that takes every run for as expensive as the next."""

    def usual_cost(self, state) -> float:
        return 1.0


def test_a_search_ends_where_it_costs_more_than_it_saves(found) -> None:
    fidelities = of_scene(wall)
    search = Flat(fidelities, comparable(fidelities, "motion"), 1e-3, 1.5, lambda scene: STEP, 60.0)
    assert search.find() == fidelities.top
    assert search.exhausted
    assert len(search.trials) == 3  # a rerun costs two more
    run = replace(found.chosen, levels={"bar": "full mesh"}, full=True)
    ended = replace(found, levels=run.levels, runs=(run,), exhausted=True)
    assert "to look for more would have cost more than it saves" in ended.sentence()
    assert "Less may do, but" in replace(found, exhausted=True).sentence()


def test_a_choice_by_chance_is_said_to_be_one(found) -> None:
    """Errors that do not fall: a level in the middle that is good where richer ones are not."""
    fidelities = of_scene(wall)
    search = Search(fidelities, comparable(fidelities, "motion"), 0.0, 1.5, lambda scene: STEP, 60.0)
    for level in (0, 2, 3, fidelities.top[0]):
        search.run((level,))
    search.reference = fidelities.top
    search.tolerance = search.estimate((3,)) * 0.99
    assert "off by up to" in scatter(search, (2,))[0]
    search.tolerance = search.estimate((3,)) * 1.01
    assert scatter(search, (2,)) == []
    assert not found.notes


def test_the_full_mesh_proves_where_it_is_as_cheap_as_to_do_without() -> None:
    """To do without takes the richest level below and two more, and proves nothing at small tolerances."""
    whole = right_size(wall, tolerance=0.01, duration=1.5, stepper=STEP, progress=False)
    assert whole.reference == {"bar": "full mesh"}
    assert whole.within
    assert whole.levels["bar"] != "full mesh"
    assert len(whole.runs) <= 6
    assert whole.runs[-1].estimate == 0.0
    without = right_size(wall, tolerance=0.01, duration=1.5, stepper=STEP, verify=False, progress=False)
    assert not without.full_was_run


def test_explicit_steps_that_fall_with_the_modes_do_without_the_full_mesh() -> None:
    found = right_size(gallery.scenes()["sphere_on_rod"], progress=False)
    assert found.within
    assert not found.full_was_run
    assert found.runs[-1].steps > 2 * found.runs[0].steps
    full = {"rod": gallery.sphere_on_rod().body("rod").source.fidelity_levels()[-1].make()}
    result = lf.simulate(gallery.sphere_on_rod().with_bodies(full), found.duration, found.stepper, progress=False)
    mine = lf.simulate(found.scene, found.duration, found.stepper, progress=False)
    true = abs(mine.impulse[-1, 0, 0] / result.impulse[-1, 0, 0] - 1.0)
    assert true <= found.errors["impulses"] <= found.tolerance


def stretched() -> Scene:
    """A bar, welded to a wall on its right, that is pulled to the left end: a rigid one cannot start so."""
    scene = Scene(gravity=(0.0, 0.0))
    bar = lf.Bar(length=1.0, area=1e-4, density=7800.0, youngs_modulus=2.1e11, elements=20).reduce(12)
    body = scene.add(bar, "bar", modal=[1e-3, -2e-4, 1e-4] + [0.0] * 9)
    scene.join(lf.Weld(body.point("right"), scene.ground.at(1.0, 0.0)))
    return settled(scene)


def test_poor_bodies_start_on_their_joints() -> None:
    scene = stretched()
    with pytest.raises(ModelError, match="initial position violates"):
        scene.with_bodies({"bar": scene.body("bar").source.fidelity_levels()[0].make()}).compiled()
    found = right_size(scene, "motion", 0.2, duration=1e-3, stepper=lf.GeneralizedAlpha(step=1e-6), progress=False)
    assert not any(run.failure for run in found.runs)
    assert found.within
    assert found.runs[0].estimate > 0.5  # rigid: it does not move
    found.scene.compiled()


def test_outputs_of_the_users_own() -> None:
    own = right_size(
        wall, {"rebound": lambda result: float(result.u[-1, 0])}, 0.1, duration=1.5,
        stepper=lambda scene: STEP, progress=False,
    )  # fmt: skip
    assert list(own.errors) == ["rebound"]
    result = lf.simulate(own.scene, 1.5, STEP, progress=False)
    exact = lf.simulate(wall(), 1.5, STEP, progress=False)
    assert result.u[-1, 0] == pytest.approx(exact.u[-1, 0], rel=0.1)


def test_motion_is_compared_at_the_same_places() -> None:
    """Velocities of the ends, of the rigid bar, too: not of places that suit a rigid body."""
    ends = right_size(wall, "trajectory", 0.5, duration=1.5, stepper=STEP, progress=False)
    rigid = next(run for run in ends.runs if run.levels == {"bar": "rigid"})
    assert 0.05 < rigid.errors["trajectory"] < 2.0


def test_a_default_step_is_found() -> None:
    default = right_size(wall, tolerance=0.1, duration=1.2, progress=False)
    assert type(default.stepper).__name__ == "GeneralizedAlpha"
    assert default.within


def interrupting(count: int):
    """An output that raises what Ctrl-C does when it is asked for the ``count``-th time."""
    calls = []

    def output(result):
        calls.append(result)
        if len(calls) == count:
            raise KeyboardInterrupt
        return float(result.u[-1, 0])

    return output


def test_ctrl_c_keeps_what_was_measured() -> None:
    part = right_size(wall, {"last": interrupting(3)}, 0.1, duration=1.5, stepper=STEP, progress=False)
    assert not part.complete
    assert len(part.runs) == 2
    assert part.sentence().startswith("Nothing can be said")
    assert "Interrupted" in part.table()
    assert part.plot() is not None
    with pytest.raises(KeyboardInterrupt):
        right_size(wall, {"last": interrupting(1)}, 0.1, duration=1.5, stepper=STEP, progress=False)


def boxes() -> Scene:
    scene = Scene()
    scene.add(lf.Box(1.0, 1.0, mass=1.0))
    return scene


@pytest.mark.parametrize(
    ("scene", "changed", "message"),
    [
        (boxes, {}, "scene: none of its bodies has fidelity levels"),
        (3, {}, "scene: 3 was given, expected a Scene"),
        (wall, {"duration": None}, "duration: not given"),
        (wall, {"duration": -1.0}, "duration: -1.0 was given"),
        (wall, {"tolerance": 0.0}, "tolerance: 0.0 was given"),
        (wall, {"tolerance": 2.0}, "tolerance: 2.0 was given"),
        (wall, {"limit": 0.0}, "limit: 0.0 was given"),
        (wall, {"outputs": "colour"}, "outputs: no output 'colour'; expected one of motion, trajectory"),
        (wall, {"outputs": 3}, "outputs: 3 was given"),
        (wall, {"stepper": 3}, "stepper: 3 was given, expected a stepper"),
        (wall, {"stepper": lf.MoreauJean}, "stepper: .* was given, expected a stepper"),
        (wall, {"stepper": lambda scene: 3}, "stepper: the function made 3"),
    ],
)
def test_what_cannot_be_asked(scene, changed: dict, message: str) -> None:
    arguments = {"duration": 1.5, "stepper": STEP, "progress": False, **changed}
    with pytest.raises(ModelError, match=message):
        right_size(scene, **arguments)


def test_table_chart_and_file(found, tmp_path) -> None:
    found.csv(tmp_path / "runs.csv")
    with (tmp_path / "runs.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == len(found.runs)
    assert [row["bar"] for row in rows if row["chosen"] == "True"] == [found.levels["bar"]]
    assert float(rows[0]["error of impulses"]) == pytest.approx(0.5, abs=0.05)  # rigid: no rebound
    found.plot().savefig(tmp_path / "chart.png")
    assert (tmp_path / "chart.png").stat().st_size > 10_000


def test_the_chart_draws_no_error_where_there_is_none() -> None:
    whole = right_size(wall, tolerance=0.01, duration=1.5, stepper=STEP, progress=False)
    (ax,) = whole.plot().axes
    lines = {line.get_label(): line for line in ax.get_lines()}
    for name in ("motion", "impulses"):
        assert len(lines[name].get_ydata()) == len(whole.runs) - 1  # all but the full mesh
        assert min(lines[name].get_ydata()) > ax.get_ylim()[0]
    assert "no error, by definition or in effect" in lines
    names = {text.get_text() for text in ax.texts}
    assert {"full", whole.levels["bar"].split()[0]} <= names


def test_names_do_not_lie_on_each_other_in_the_chart(found) -> None:
    same = [replace(run, wall_time=1.0, errors={"motion": 0.01}) for run in found.runs]
    (ax,) = replace(found, runs=tuple(same)).plot().axes
    assert len(ax.texts) == 2  # one of them, and the tolerance


def test_the_command(tmp_path, capsys) -> None:
    parser = argparse.ArgumentParser()
    add_right_size(parser.add_subparsers(), lambda text: (wall(), 1.5, STEP))

    def run(*more: str) -> int:
        request = parser.parse_args(["right-size", "wall", *more])
        return request.command(request)

    picture, table = tmp_path / "chart.png", tmp_path / "runs.csv"
    assert run("--tolerance", "0.05", "--output", str(picture), "--csv", str(table), "--quantity", "impulses") == 0
    assert picture.stat().st_size > 10_000
    assert table.read_text().startswith("bar,coordinates,steps,wall_time,error of impulses")
    assert "for the bar: impulses within" in capsys.readouterr().out
    assert run("--limit", "1e-6", "--step", "1e-4") == 1
    assert "Nothing can be said" in capsys.readouterr().out
    wrongs = ("--quantity", "colour"), ("--output", "chart.txt"), ("--csv", "/no/folder/runs.csv"), ("--duration", "0")
    for wrong in wrongs:
        with pytest.raises(ModelError, match=wrong[0].strip("-")):
            run(*wrong)


def test_a_sentence_names_what_may_be_rigid() -> None:
    run = FidelityRun({"pendulum": "4 modes", "rod": "rigid"}, 10, 100, 0.01, {"peak force": 0.008}, True, True)
    study = RightSize(
        scene=None, proved=True, tolerance=0.01, levels=run.levels, errors=run.errors, runs=(run,), next=(),
        reference={}, stepper=STEP, duration=1.0, spent=0.5, full=0.3, full_was_run=True,
    )  # fmt: skip
    assert study.sentence() == (
        "4 modes for the pendulum, the rod may be rigid: peak force within 0.8 % of the full mesh, 30 times cheaper."
    )
    assert np.isclose(study.speedup, 30.0)
    assert replace(study, full=1.38).sentence().endswith(" 140 times cheaper.")
    assert (
        "the best that was run, the rod may be rigid, has estimated errors"
        in replace(
            study, proved=False, levels={"rod": "rigid"}, runs=(replace(run, levels={"rod": "rigid"}),)
        ).sentence()
    )
    rigid = replace(study, levels=dict.fromkeys(("pendulum", "rod", "stop"), "rigid"))
    assert (
        replace(rigid, runs=(replace(run, levels=rigid.levels),))
        .sentence()
        .startswith("The pendulum, the rod and the stop may be rigid: ")
    )
