"""The command ``stability``, as typed."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import pytest

from lcpflex import ModelError, gallery
from lcpflex.cli.stability import add_stability


def find(text: str) -> Any:
    known = {"oblique": gallery.oblique_bounce, "bar": gallery.elastic_bar, "number": 3, **gallery.scenes()}
    return known[text]


def run(*arguments: str) -> int:
    parser = argparse.ArgumentParser()
    add_stability(parser.add_subparsers(), find)
    request = parser.parse_args(["stability", *arguments])
    return int(request.command(request))


def test_map_with_chart_and_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    chart, cells = tmp_path / "map.png", tmp_path / "map.csv"
    methods = ["--method", "moreau-jean", "--x", "step=1e-3:1e-1:3", "--y", "friction=0,0.2"]
    assert run("oblique", *methods, "--duration", "0.5", "--plot", str(chart), "--csv", str(cells)) == 0
    printed = capsys.readouterr().out
    assert "moreau-jean: 2 no sign of trouble, 4 drifting (6 cells)" in printed  # penetrates by h v / 2 at touch
    assert "| friction \\ step | 0.001 | 0.01 | 0.1 |" in printed
    assert chart.read_bytes()[1:4] == b"PNG"
    lines = cells.read_text().splitlines()
    assert lines[0] == "method,step,friction,outcome,error,message,seconds"
    assert len(lines) == 7


def test_whole_numbers_stay_whole(capsys: pytest.CaptureFixture[str]) -> None:
    assert run("bar", "--x", "elements=4:8:3", "--duration", "1e-3") == 0
    assert "| elements | 4 | 6 | 8 |" in capsys.readouterr().out


def test_steps_are_the_default_axis(capsys: pytest.CaptureFixture[str]) -> None:
    assert run("three_balls", "--duration", "0.1") == 0
    assert "| step | 0.0001 | 0.0003162 | 0.001 | 0.003162 | 0.01 | 0.03162 | 0.1 |" in capsys.readouterr().out


def test_paradoxes_without_time_stepping(capsys: pytest.CaptureFixture[str]) -> None:
    axes = ["--x", "degrees=30,60", "--y", "friction=0.5:1.4:2"]
    assert run("painleve_rod", "--method", "acceleration-level", *axes) == 0
    assert "| 1.4 | sound | no solution |" in capsys.readouterr().out


def test_methods_side_by_side(capsys: pytest.CaptureFixture[str]) -> None:
    methods = ["--method", "moreau-jean", "--method", "penalty"]
    assert run("three_balls", *methods, "--x", "stiffness=1e2:1e10:3", "--duration", "0.1") == 0
    printed = capsys.readouterr().out
    assert "moreau-jean: 3 no sign of trouble (3 cells)" in printed  # with the step of the case, 1e-3
    assert "| drifting | energy unexplained | diverged |" in printed  # soft, h omega = 1.7, h omega = 170


def test_every_scheme_can_be_asked_for(capsys: pytest.CaptureFixture[str]) -> None:
    methods = ["moreau-jean", "event-driven", "generalized-alpha", "massless-boundary", "penalty", "acceleration-level"]
    asked = [word for label in methods for word in ("--method", label)]
    assert run("modal_bar_3", *asked, "--x", "dynamic_modes=1,2", "--duration", "1e-4") == 0
    printed = capsys.readouterr().out
    assert all(f"{label}: 2 " in printed for label in methods)
    assert "refused" not in printed


OWN = """
import lcpflex as lf
fixed = lf.EventDriven()
def coarse(step=1e-2): return lf.MoreauJean(step=step)
def height(result): return float(result.q[:, 1].max())
"""


def test_truth_and_methods_of_a_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "mine.py"
    file.write_text(OWN)
    asked = ["--method", f"{file}:coarse", "--method", f"{file}:fixed", "--x", "step=1e-3,0.09", "--duration", "0.5"]
    truth = ["--truth", "own", "--tolerance", "0.02", "--quantity", "motion", "--quantity", f"{file}:height"]
    table = tmp_path / "map.csv"
    assert run("oblique", *asked, *truth, "--csv", str(table)) == 0
    printed = capsys.readouterr().out
    assert "fixed: 2 sound (2 cells)" in printed
    assert "Note: sound is an error below 2 %, relative to EventDriven(" in printed
    assert "confirms to" in printed
    cells = [line.split(",") for line in table.read_text().splitlines()]
    errors = [float(cell[cells[0].index("error")]) for cell in cells[1:]]
    assert errors[0] < 0.02 < errors[1]  # of coarse, with the short step and the long one
    assert run("oblique", "--x", "step=1e-3", "--duration", "0.5", "--truth", "event-driven") == 0
    assert "moreau-jean: 1 sound (1 cells)" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["number"], "SCENE: 'number' is 3"),
        (["oblique"], "--duration: not given"),
        (["oblique", "--duration", "1", "--x", "step"], "--x: 'step'; expected NAME=START:STOP:COUNT"),
        (["oblique", "--duration", "1", "--x", "step=1:2"], "--x: 'step=1:2'"),
        (["oblique", "--duration", "1", "--x", "step=1:2:0"], "--x: 'step=1:2:0'"),
        (["oblique", "--duration", "1", "--x", "step=nan,1"], "--x: 'step=nan,1'"),
        (["oblique", "--duration", "1", "--x", "step=1,2", "--y", "step=1,2"], "--y: 'step' was given twice"),
        (["oblique", "--duration", "1", "--y", "frition=0:1:3"], "nothing takes 'frition'"),
        (["oblique", "--duration", "1", "--x", "step=1e-4:1e-1:100000000"], "expected at most 10000 values"),
        (["oblique", "--duration", "1", "--x", f"step=1e-4:1e-1:{'9' * 5000}"], "expected at most 10000 values"),
        (["oblique", "--duration", "1", "--x", "step=1:2:200", "--y", "friction=0:1:200"], "40000 cells"),
        (["oblique", "--duration", "1", "--method", "moreu-jean"], "(did you mean 'moreau-jean'?)"),
        (["oblique", "--duration", "1", "--truth", "event-drven"], "(did you mean 'event-driven'?)"),
        (["oblique", "--duration", "1", "--quantity", "motion"], "--quantity: given without --truth"),
        (["oblique", "--duration", "1", "--tolerance", "0.1"], "--tolerance: given without --truth"),
        (["oblique", "--duration", "1", "--truth", "own", "--tolerance", "2"], "--tolerance: 2.0 was given"),
        (["oblique", "--duration", "1", "--truth", "own", "--quantity", "mtion"], "(did you mean 'motion'?)"),
        (["oblique", "--duration", "0"], "--duration: 0.0 was given"),
        (["oblique", "--duration", "1", "--time-limit", "-1"], "--time-limit: -1.0 was given"),
        (["oblique", "--duration", "1", "--method", "nowhere.py:mine"], "--method: no file 'nowhere.py'"),
        (["oblique", "--duration", "1", "--plot", "no_folder/map.png"], "--plot: cannot write"),
        (["oblique", "--duration", "1", "--plot", "map.txt"], "--plot: 'map.txt'; expected a name that ends in .png"),
    ],
)
def test_impossible_requests(arguments: list[str], words: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(ModelError) as caught:
        run(*arguments)
    assert words in str(caught.value)
    assert capsys.readouterr().out == ""
