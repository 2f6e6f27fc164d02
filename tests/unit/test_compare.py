"""``tests/compare.py``: equal checkouts are equal, and whatever differs is seen, named and ranked."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from tests.comparison.checkouts import Checkout, NoWorkerError
from tests.comparison.difference import ALIKE, compared
from tests.comparison.instants import in_both
from tests.comparison.main import main
from tests.comparison.pairs import AWAY, EITHER, GROUND, TOWARDS, pairs_of, totals
from tests.comparison.plan import STEPPERS, share_of
from tests.comparison.record import Record, died, file_of, kept, load, save
from tests.comparison.shares import SHARES, TOO_STIFF
from tests.comparison.table import exit_code, table

ROOT = Path(__file__).resolve().parents[2]

DYING = """
import os, time, types

class ModelError(Exception): ...
class StepError(Exception): ...

class MoreauJean:
    def __init__(self, step): ...

class Case:
    duration, stepper = 1.0, None
    def __init__(self, name): self.name = name
    def build(self): return self.name

class Smooth: ...

def simulate(scene, duration, stepper, **options):
    if scene == "dies":
        os.write(2, b"the last words")
        os._exit(3)
    if scene == "hangs":
        time.sleep(60)
    raise ModelError(f"{scene} is refused\\nfor a reason")

gallery = types.SimpleNamespace(scenes=lambda: {name: Case(name) for name in ("first", "dies", "hangs", "last")})
"""


@pytest.fixture(scope="module")
def run() -> Record:
    """A box that slides on the ground: one short run, kept as compare.py keeps it."""
    scene = lf.Scene(gravity=(0.0, -9.81))
    box = scene.add(lf.Box(width=0.2, height=0.1, mass=1.0), name="box", position=(0.0, 0.05), velocity=(1.0, 0.0))
    scene.contact(box.surface(), scene.ground.half_plane((0, 0), (0, 1)), friction=0.3, name="floor")
    result = lf.simulate(scene, 0.02, lf.MoreauJean(step=1e-3), record=0)
    return kept(result, "0.02 s", lambda result: pairs_of(result, {}))


def _with(record: Record, **arrays: Any) -> Record:
    """The record with other arrays."""
    return replace(record, arrays=dict(record.arrays) | {name.replace("__", "."): a for name, a in arrays.items()})


def _changed(record: Record, name: str, at: tuple[int, ...], by: float) -> Record:
    values = record.arrays[name].copy()
    values[at] += by
    return replace(record, arrays=dict(record.arrays) | {name: values})


def _saying(record: Record, **words: Any) -> Record:
    return replace(record, words=dict(record.words) | words)


def test_a_checkout_is_equal_to_itself(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    asked = ["--scenes", "three_balls,incline_sticks", "--steppers", "moreau-jean,massless-boundary"]
    assert main([str(ROOT), str(ROOT), *asked, "--keep", str(tmp_path)]) == 0
    told, progress = capsys.readouterr()
    assert told.splitlines()[-1] == "4 runs: 2 equal bits, 2 refused alike"
    assert [line.split()[:2] for line in told.splitlines()[1:3]] == [
        ["incline_sticks", "moreau-jean"],
        ["three_balls", "moreau-jean"],
    ]
    assert progress.count("\n") == 8
    one = load(file_of(tmp_path / "new", "three_balls", "moreau-jean"))
    assert one.numbers["steps"] == 500
    assert one.arrays["q"].shape == (251, 9)  # every second step
    assert one.names["pairs"] == [["ball 1", "ball 2", AWAY], ["ball 2", "ball 3", AWAY]] or one.names["pairs"] == [
        ["ball 1", "ball 2", TOWARDS],
        ["ball 2", "ball 3", TOWARDS],
    ]
    other = _changed(one, "u", (200, 0), 1e-3)
    save(other, file_of(tmp_path, "three_balls", "other"))
    assert compared(one, load(file_of(tmp_path, "three_balls", "other"))).status == "differs"


def test_equal_records_survive_their_file(run: Record, tmp_path: Path) -> None:
    path = file_of(tmp_path, "box", "own")
    save(run, path)
    assert compared(run, load(path)).status == "equal bits"
    assert run.names["pairs"] == [("box", GROUND, TOWARDS)]


def test_a_motion_that_differs_is_named_with_place_and_time(run: Record) -> None:
    outcome = compared(run, _changed(run, "q", (7, 1), 1e-3))
    assert outcome.status == "differs"
    places = next(size for size in outcome.sizes if size.what == "places")
    assert places.share == pytest.approx(1e-3 / run.size)
    assert (places.where, places.when) == ("box.y", run.arrays["times"][7])
    assert "first at t = 0.007" in outcome.text
    assert "other bits: q" in outcome.text


def test_rounding_is_told_from_differences(run: Record) -> None:
    assert compared(run, _changed(run, "q", (7, 1), 1e-15)).status == "equal to 1e-12"
    assert compared(run, _changed(run, "residual", (7,), 1e-3)).status == "equal to 1e-12"
    assert compared(run, _changed(run, "q", (7, 1), 1e-12)).status == "differs"
    assert compared(run, _changed(run, "energies.friction", (7,), 1e-3)).status == "differs"


def test_minus_zero_and_no_number_are_bits(run: Record) -> None:
    zeros, nans = run.arrays["gap"] * 0.0, run.arrays["gap"] * np.nan
    assert compared(_with(run, gap=zeros), _with(run, gap=-zeros)).status == "equal to 1e-12"
    assert compared(_with(run, gap=nans), _with(run, gap=nans.copy())).status == "equal bits"
    lost = _changed(run, "u", (7, 1), np.nan)
    assert compared(lost, lost).status == "equal bits"
    outcome = compared(run, lost)
    assert outcome.status == "differs"
    assert np.isinf(next(size.share for size in outcome.sizes if size.what == "speeds"))
    assert compared(_changed(lost, "q", (9, 1), 1e-15), lost).status == "equal to 1e-12"


def test_a_force_that_is_split_otherwise_among_points_of_a_pair_is_equal(run: Record) -> None:
    """Two corners of the box on the floor: what one carries less, and two others at the same places more."""
    points = {name: a for name, a in run.arrays.items() if name.startswith("contact_points.")}
    at = points["contact_points.record"] == 5
    assert np.count_nonzero(at) == 2
    more = {name: np.concatenate([a, a[at]]) for name, a in points.items()}
    quarter = more["contact_points.force"].copy()
    quarter[: len(at)][at] *= 0.25
    quarter[len(at) :] *= 0.75
    other = replace(run, arrays=dict(run.arrays) | more | {"contact_points.force": quarter})
    assert compared(run, other).status == "equal to 1e-12"


def test_a_total_force_and_a_moment_that_differ_are_told_apart(run: Record) -> None:
    """As much more on one corner as less on the other: the same force, another moment."""
    first, second = np.flatnonzero(run.arrays["contact_points.record"] == 5).tolist()
    moved = _changed(_changed(run, "contact_points.force", (first, 0), 1.0), "contact_points.force", (second, 0), -1.0)
    outcome = compared(run, moved)
    share = {size.what: size.share for size in outcome.sizes}
    assert outcome.status == "differs"
    assert share["total force"] < 1e-12 < 1e-2 < share["total moment"]
    more = compared(run, _changed(run, "contact_points.force", (first, 0), 1.0))
    named = next(size for size in more.sizes if size.what == "total force")
    assert (named.where, named.when) == (f"box|{GROUND}", run.arrays["times"][5])
    assert named.share == pytest.approx(1.0 / np.hypot(10.81, 0.3 * 9.81), rel=1e-6)


def test_both_sides_of_polygons_act_on_the_same_body() -> None:
    """Nodes of either box touch the other: their normals are opposite, and the force on the first body is one."""
    scene = lf.Scene(gravity=(0.0, -9.81))
    for k in range(2):
        scene.add(lf.Box(width=0.2, height=0.1, mass=1.0), name=f"box {k}", position=(0.05 * k, 0.05 + 0.1 * k))
    scene.ground.half_plane((0, 0), (0, 1))
    scene.contact_all(friction=0.3)
    result = lf.simulate(scene, 0.01, lf.MoreauJean(step=1e-3), record=0)
    one = kept(result, "", lambda result: pairs_of(result, {}))
    assert ("box 0", "box 1", EITHER) in one.names["pairs"]
    assert len(np.unique(np.sign(one.arrays["contact_points.normal"][:, 1]))) == 2
    sums = totals(one, np.zeros(2))
    force, _ = sums["box 0|box 1"]
    np.testing.assert_allclose(force[5], (0.0, -9.81), atol=1e-9)
    np.testing.assert_allclose(sums[f"box 0|{GROUND}"][0][5], (0.0, 2 * 9.81), atol=1e-9)
    np.testing.assert_allclose(sums["box 0|box 1"][1][5], -0.05 * 9.81, atol=1e-9)


def test_forces_in_space_are_summed_by_pairs_of_bodies() -> None:
    case = lf.gallery.scenes()["puck"]
    result = lf.simulate(case.build(), 0.02, lf.MoreauJean(step=1e-3), record=0)
    one = kept(result, "", lambda result: pairs_of(result, {}))
    assert one.names["pairs"] == [(GROUND, "puck", AWAY)] * 3 or one.names["pairs"] == [(GROUND, "puck", TOWARDS)] * 3
    ((name, (force, _)),) = totals(one, np.zeros(3)).items()
    assert name == f"{GROUND}|puck"
    change = np.diff(result.momentum().linear, axis=0)
    np.testing.assert_allclose(-np.diff(one.arrays["impulse"][:, :, 0].sum(axis=1))[5:], 1e-3 * force[6:, 2], rtol=1e-6)
    assert np.abs(change[5:, :2] + 1e-3 * force[6:, :2]).max() < 1e-6 * np.abs(force).max()


def test_a_user_system_is_compared_by_its_contacts() -> None:
    case = lf.gallery.scenes()["slider_crank"]
    result = lf.simulate(case.build(), 0.3 * case.duration, lf.MoreauJean(step=case.duration / 100), record=0)
    one = kept(result, "", lambda result: pairs_of(result, {}))
    assert set(totals(one, np.zeros(2))) == set(result.contact_names)
    assert compared(one, _changed(one, "force", (5, 0, 0), 1.0)).status == "differs"


@pytest.mark.parametrize(
    ("words", "status", "named"),
    [
        ({"verdict": "NOT to be trusted: the motion is bad."}, "verdict changed", "NOT to be trusted"),
        ({"warnings": ["a body gives way by 3 %"]}, "says otherwise", "a body gives way"),
        ({"notes": ["a step was divided"]}, "says otherwise", "a step was divided"),
    ],
)
def test_other_words_are_seen(run: Record, words: Mapping[str, Any], status: str, named: str) -> None:
    outcome = compared(run, _saying(run, **words))
    assert (outcome.status, named in outcome.text) == (status, True)


def test_reasons_of_a_verdict_count_and_their_numbers_do_not(run: Record) -> None:
    def doubt(text: str) -> Record:
        return _saying(run, verdict=f"NOT to be trusted: {text}.")

    one = doubt("a contact penetrates by 1.2 mm at t = 1 s")
    assert compared(one, doubt("a contact penetrates by 900 µm at t = 1 s")).status == "says otherwise"
    assert compared(one, doubt("a joint has drifted by 1.2 mm at t = 1 s")).status == "verdict changed"


def test_another_end_is_seen(run: Record) -> None:
    failed = replace(run, how="failed", error="StepError: at t = 0.02 s, after 20 steps: no solution")
    assert compared(run, failed).status == "end changed"
    assert compared(failed, failed).status == "failed alike, equal bits"
    later = replace(failed, error="StepError: at t = 0.03 s, after 30 steps: no solution")
    assert compared(failed, later).status == "says otherwise"
    refused, other = (Record("refused", f"ModelError: {text}") for text in ("step: bad", "step: worse"))
    assert compared(refused, refused).status == "refused alike"
    assert compared(refused, other).status == "end changed"
    assert compared(run, refused).status == "end changed"
    assert compared(run, died("its process ended")).status == "died"


def test_another_case_is_seen(run: Record) -> None:
    outcome = compared(run, replace(run, asked="0.03 s"))
    assert (outcome.status, "0.03 s" in outcome.text) == ("asked differently", True)


def test_more_steps_differ(run: Record) -> None:
    outcome = compared(run, replace(run, numbers=dict(run.numbers) | {"steps": 21}))
    assert (outcome.status, "20 -> 21 steps" in outcome.text) == ("differs", True)


def test_an_array_that_is_gone_is_seen(run: Record) -> None:
    less = replace(run, arrays={name: a for name, a in run.arrays.items() if name != "strict"})
    for one, other, side in ((run, less, "old"), (less, run, "new")):
        outcome = compared(one, other)
        assert outcome.status not in ALIKE
        assert f"strict (only in {side})" in outcome.text


def test_the_table_has_differences_first_and_counts(run: Record) -> None:
    outcomes = {
        ("b", "own"): compared(run, run),
        ("c", "own"): compared(run, _changed(run, "q", (7, 1), 1e-3)),
        ("a", "own"): compared(run, _changed(run, "q", (7, 1), 1e-2)),
    }
    lines = table(outcomes, {"old": ["gone"], "new": []}).splitlines()
    assert [line.split()[0] for line in lines] == ["scene", "a", "c", "b", "only", "3"]
    assert lines[-2:] == ["only in old: gone", "3 runs: 2 differs, 1 equal bits"]
    assert exit_code(outcomes) == 1
    assert exit_code({("b", "own"): compared(run, run)}) == 0


def test_instants_are_met_by_time() -> None:
    old, new = np.array([0.0, 0.1, 0.15, 0.15, 0.2, 0.3]), np.array([0.0, 0.1, 0.2 + 1e-13, 0.25, 0.25, 0.3])
    i, j = in_both(old, new)
    assert (i.tolist(), j.tolist()) == ([0, 1, 4, 5], [0, 1, 2, 5])


def test_a_run_that_dies_or_hangs_takes_no_other_with_it(tmp_path: Path) -> None:
    folder = tmp_path / "checkout"
    (folder / "lcpflex" / "solvers").mkdir(parents=True)
    (folder / "lcpflex" / "__init__.py").write_text(DYING, encoding="utf-8")
    (folder / "lcpflex" / "solvers" / "__init__.py").write_text("", encoding="utf-8")
    side = Checkout("old", folder, sys.executable, tmp_path, 2.0)
    assert side.scenes() == ("first", "dies", "hangs", "last")
    told: list[str] = []
    side.make([(scene, "moreau-jean") for scene in side.scenes()], told.append)
    ends = {scene: load(file_of(tmp_path, scene, "moreau-jean")) for scene in side.scenes()}
    assert [end.how for end in ends.values()] == ["refused", "died", "died", "refused"]
    assert ends["first"].error == "ModelError: first is refused"
    assert "3" in ends["dies"].error
    assert "the last words" in ends["dies"].error
    assert ends["hangs"].error == "no end after 2 s"
    assert len(told) == 4


def test_a_checkout_that_cannot_be_imported_is_told(tmp_path: Path) -> None:
    (tmp_path / "lcpflex").mkdir()
    (tmp_path / "lcpflex" / "__init__.py").write_text("import no_such_module", encoding="utf-8")
    with pytest.raises(NoWorkerError, match="no_such_module"):
        Checkout("old", tmp_path, sys.executable, tmp_path, 60.0).scenes()


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["nowhere", str(ROOT)], ("OLD", "'nowhere'", "folder of a checkout")),
        ([str(ROOT), str(ROOT), "--jobs", "0"], ("--jobs", "'0'", "whole number >= 1")),
        ([str(ROOT), str(ROOT), "--seconds", "nan"], ("--seconds", "'nan'", "number of seconds > 0")),
        ([str(ROOT), str(ROOT), "--steppers", ","], ("--steppers", "','", "names with commas")),
        ([str(ROOT), str(ROOT), "--steppers", "euler"], ("--steppers", "'euler'", "moreau-jean")),
        ([str(ROOT), str(ROOT), "--scenes", "moon", "--steppers", "own"], ("--scenes", "'moon'", "pendulum")),
        ([str(ROOT), str(ROOT), "--old-python", "no"], ("--old-python", "'no'", "path of a python")),
    ],
)
def test_arguments_that_cannot_be_are_named(
    arguments: list[str], said: tuple[str, ...], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(arguments) == 2
    error = capsys.readouterr().err
    assert all(words in error for words in said)


def test_shares_are_of_scenes_and_steppers_that_there_are() -> None:
    cases = lf.gallery.scenes()
    assert set(SHARES) | set(TOO_STIFF) <= set(cases)
    kinds = {*STEPPERS, "events", "controlled"}
    assert all(set(shares) <= kinds and all(0.0 < s < 1.0 for s in shares.values()) for shares in SHARES.values())
    assert share_of(cases["pendulum"], "event-driven-poisson") == SHARES["pendulum"]["events"]
    assert share_of(cases["pendulum"], "own") == 1.0
