"""The command ``stability``, as typed."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import pytest

from lcpflex import ModelError, gallery
from lcpflex.studies.commands_stability import add_stability


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
    assert "moreau-jean: 2 sound, 4 drifting (6 cells)" in printed  # penetrates by h v / 2 at touch
    assert "| friction \\ step | 0.001 | 0.01 | 0.1 |" in printed
    assert chart.read_bytes()[1:4] == b"PNG"
    lines = cells.read_text().splitlines()
    assert lines[0] == "method,step,friction,outcome,message,seconds"
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
    assert "moreau-jean: 3 sound (3 cells)" in printed  # with the step of the case, 1e-3
    assert "| drifting | energy unexplained | diverged |" in printed  # soft, h omega = 1.7, h omega = 170


def test_every_scheme_can_be_asked_for(capsys: pytest.CaptureFixture[str]) -> None:
    methods = ["moreau-jean", "event-driven", "generalized-alpha", "massless-boundary", "penalty", "acceleration-level"]
    asked = [word for label in methods for word in ("--method", label)]
    assert run("modal_bar_3", *asked, "--x", "dynamic_modes=1,2", "--duration", "1e-4") == 0
    printed = capsys.readouterr().out
    assert all(f"{label}: 2 " in printed for label in methods)
    assert "refused" not in printed


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
        (["oblique", "--duration", "1", "--plot", "no_folder/map.png"], "--plot: cannot write"),
        (["oblique", "--duration", "1", "--plot", "map.txt"], "--plot: 'map.txt'; expected a name that ends in .png"),
    ],
)
def test_impossible_requests(arguments: list[str], words: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(ModelError) as caught:
        run(*arguments)
    assert words in str(caught.value)
    assert capsys.readouterr().out == ""
