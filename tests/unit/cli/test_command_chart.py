"""``lcpflex chart``: what it prints and writes, and what it refuses before anything is run."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

import lcpflex as lf
from lcpflex import gallery, studies
from lcpflex.cli.chart import add_chart
from lcpflex.cli.reading import check_picture, load_named
from lcpflex.errors import ModelError

MINE = """
import lcpflex as lf
from dataclasses import dataclass

@dataclass
class Kept:
    value: float

def reach(result):
    return result.q[:, 0]

def coarse_to_fine():
    return [lf.MoreauJean(step=h) for h in (3e-2, 1e-2)]

two = {"mine": coarse_to_fine(), "event-driven": lf.EventDriven(rtol=1e-6)}
one = lf.MoreauJean(step=1e-2)
nothing = []
number = 3.0

def broken():
    return 1 / 0
"""


assert studies.work_precision is not None  # loads the modules that are replaced below
assert studies.standard_methods is not None


@pytest.fixture
def chart(monkeypatch: pytest.MonkeyPatch) -> Callable[..., int]:
    """The command on a block that sticks and slips, with few steps."""
    short = {
        "Moreau-Jean": [lf.MoreauJean(step=h) for h in (1e-2, 3e-3, 1e-3)],
        "event-driven": [lf.EventDriven(rtol=r) for r in (1e-5, 1e-7)],
    }
    for module in ("cli.later", "studies.convergence.work_precision"):  # who asks for them
        monkeypatch.setattr(sys.modules[f"lcpflex.{module}"], "standard_methods", lambda duration: short)
    monkeypatch.setattr(sys.modules["lcpflex.studies.convergence.work_precision"], "MOST", 2000)  # instants: quick
    parser = argparse.ArgumentParser()
    case = gallery.scenes()["stick_slip"]
    add_chart(parser.add_subparsers(), lambda text: (case.build(), case.duration, case.stepper))

    def run(*more: str) -> int:
        request = parser.parse_args(["chart", "stick_slip", "--repeats", "1", *more])
        return int(request.command(request))

    return run


@pytest.fixture
def mine(tmp_path: Path) -> Path:
    path = tmp_path / "my_study.py"
    path.write_text(MINE)
    return path


def test_it_prints_and_writes(chart, tmp_path, capsys) -> None:
    picture, table = tmp_path / "chart.png", tmp_path / "runs.csv"
    assert chart("--output", str(picture), "--csv", str(table), "--quantity", "motion") == 0
    assert picture.stat().st_size > 10_000
    assert table.read_text().count("\n") == 6
    assert "1 % in motion: " in capsys.readouterr().out


@pytest.mark.parametrize("quantity", ["energy", "peak force", "motion", "impulses"])
def test_every_quantity_of_the_help_can_be_asked_for(chart, capsys, quantity) -> None:
    assert chart("--quantity", quantity, "--method", "moreau-jean") == 0
    assert f"in {quantity}" in capsys.readouterr().out


@pytest.mark.slow
def test_outputs_and_methods_of_ones_own(chart, mine, capsys) -> None:
    assert chart("--quantity", f"{mine}:reach", "--method", f"{mine}:two", "--method", "Moreau-Jean") == 0
    printed = capsys.readouterr().out
    assert "in reach" in printed
    assert all(f"| {label} " in printed for label in ("mine", "event-driven", "Moreau-Jean"))


@pytest.mark.slow
@pytest.mark.parametrize("name", ["coarse_to_fine", "one"])
def test_a_series_of_ones_own_is_called_as_it_is(chart, mine, capsys, name) -> None:
    assert chart("--method", f"{mine}:{name}", "--method", "event-driven") == 0
    assert f"| {name} " in capsys.readouterr().out


WRONG = [
    (("--quantity", "colour"), "--quantity: 'colour'; expected file.py:name or one of trajectory"),
    (("--quantity", "{mine}:number"), "is 3.0; expected a function of a Result"),
    (("--quantity", "{mine}:reech"), "has no function 'reech' (did you mean 'reach'?); expected one of"),
    (("--quantity", "absent.py:reach"), "--quantity: no file 'absent.py'"),
    (("--method", "colour"), "--method: 'colour'; expected file.py:name or one of Moreau-Jean"),
    (("--method", "{mine}:nothing"), "--method: "),
    (("--method", "{mine}:number"), "expected a stepper, or several"),
    (("--method", "{mine}:broken"), "raised ZeroDivisionError: division by zero"),
    (("--output", "chart.txt"), "--output: 'chart.txt'; expected a name that ends in .png, .pdf, .svg"),
    (("--output", "/no/folder/chart.png"), "--output"),
    (("--csv", "/no/folder/runs.csv"), "--csv"),
    (("--duration", "0"), "--duration: 0.0"),
    (("--duration", "nan"), "--duration: nan"),
    (("--limit", "0"), "--limit: 0.0"),
    (("--repeats", "0"), "--repeats: 0; expected at least 1"),
    (("--repeats", "-3"), "--repeats: -3; expected at least 1"),
]


@pytest.mark.parametrize(("options", "words"), WRONG)
def test_what_cannot_be_is_refused_before_the_run(chart, mine, monkeypatch, options, words) -> None:
    def never(*_: object, **__: object) -> None:
        raise AssertionError

    monkeypatch.setattr(sys.modules["lcpflex.studies.convergence.work_precision"], "work_precision", never)
    with pytest.raises(ModelError) as raised:
        chart(*(option.format(mine=mine) for option in options))
    assert words in str(raised.value)
    assert len(str(raised.value)) < 500


def test_a_file_is_run_once_however_often_it_is_named_and_again_when_it_changed(tmp_path) -> None:
    path = tmp_path / "counted.py"
    path.write_text("value = object()")
    assert load_named("X", f"{path}:value") is load_named("X", f"{path}:value")
    before = load_named("X", f"{path}:value")
    os.utime(path, (1.0, 1.0))
    assert load_named("X", f"{path}:value") is not before


@pytest.mark.parametrize("name", ["x.xyz", "x", "x.PNG.gz", ".png/"])
def test_pictures_of_other_kinds_are_refused(name) -> None:
    with pytest.raises(ModelError, match="--plot"):
        check_picture("--plot", Path(name))
