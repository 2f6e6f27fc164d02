"""The command line, as typed."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from lcpflex import __version__
from lcpflex.__main__ import main
from lcpflex.results.result import Result

SCENE = """
import lcpflex as lf

def ball():
    scene = lf.Scene()
    ball = scene.add(lf.Disc(radius=0.05, mass=1.0), name="ball", position=(0.0, 0.06))
    scene.contact(ball.surface(), scene.ground.half_plane((0.0, 0.0), (0.0, 1.0)), name="floor")
    return scene

def of_mass(mass):
    return ball()

def broken():
    return 1 / 0

number = 3
"""


@pytest.fixture
def scene_file(tmp_path: Path) -> Path:
    path = tmp_path / "my_scene.py"
    path.write_text(SCENE)
    return path


def test_python_m_lcpflex_prints_the_version() -> None:
    printed = subprocess.run([sys.executable, "-m", "lcpflex", "--version"], capture_output=True, text=True, check=True)
    assert printed.stdout == f"lcpflex {__version__}\n"


def test_without_a_command_it_explains_itself(capsys: pytest.CaptureFixture[str]) -> None:
    assert main([]) == 0
    printed = capsys.readouterr().out
    assert all(command in printed for command in ("demo", "gallery", "run", "chart", "stability", "warmup"))


def test_gallery_lists_every_scene(capsys: pytest.CaptureFixture[str]) -> None:
    from lcpflex.gallery import scenes

    assert main(["gallery"]) == 0
    printed = capsys.readouterr().out
    assert all(f"{name} " in printed and case.title in printed for name, case in scenes().items())


def test_run_a_scene_of_ones_own(scene_file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    saved, chart = scene_file.with_name("ball.npz"), scene_file.with_name("ball.png")
    scene = f"{scene_file}:ball"
    options = ["--step", "1e-3", "--duration", "0.1", "--save", str(saved), "--plot", str(chart)]
    assert main(["run", scene, "--stepper", "moreau-jean", *options]) == 0
    printed = capsys.readouterr().out
    assert "100 steps" in printed
    assert "floor: first seen touching at 0.04" in printed
    assert str(saved) in printed
    assert chart.read_bytes()[1:4] == b"PNG"
    result = Result.load(saved)
    assert result.times[-1] == pytest.approx(0.1)
    assert result.point("ball", (0.0, 0.0))[-1, 1] == pytest.approx(0.05, abs=2.3e-4)  # closed within a step: h v / 2


@pytest.mark.parametrize(
    ("options", "named"),
    [
        (["moreau-jean"], "MoreauJean, step 0.0002 s"),
        (["event-driven", "--step", "0.01"], "max step 0.01 s"),
        (["generalized-alpha", "--step", "1e-3"], "GeneralizedAlpha, step 0.001 s"),
        (["smooth", "--stiffness", "1e5"], "Penalty (stiffness 100000.0)"),
    ],
)
def test_run_by_every_stepper(
    scene_file: Path, capsys: pytest.CaptureFixture[str], options: list[str], named: str
) -> None:
    assert main(["run", f"{scene_file}:ball", "--duration", "0.1", "--stepper", *options]) == 0
    assert named in capsys.readouterr().out


def test_run_without_a_stepper(scene_file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", f"{scene_file}:ball", "--duration", "0.1"]) == 0
    assert "stepper chosen: EventDriven(rtol=1e-06)" in " ".join(capsys.readouterr().out.split())
    assert main(["run", f"{scene_file}:ball", "--duration", "0.1", "--step", "1e-3"]) == 0
    assert "MoreauJean, step 0.001 s" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["stabilty", "pendulum"], "'stabilty' (did you mean 'stability'?); expected one of demo"),
        (["rightsize", "pendulum"], "(did you mean 'right-size'?)"),
        (["run", "pendulum", "--sttep", "1"], "'--sttep' (did you mean '--step'?)"),
        (["stability", "pendulum", "--plott=x.png"], "'--plott=x.png' (did you mean '--plot'?)"),
        (["chart", "pendulum", "--reapets", "3"], "'--reapets' (did you mean '--repeats'?)"),
        (["run", "pendulum", "--stepper", "moreau"], "'moreau' (did you mean 'moreau-jean'?); expected one of"),
        (["run", "pendulum", "--colour", "1"], "unrecognized arguments: '--colour', '1'"),
    ],
)
def test_the_nearest_name_of_a_typing_error(
    capsys: pytest.CaptureFixture[str], arguments: list[str], words: str
) -> None:
    with pytest.raises(SystemExit) as caught:
        main(arguments)
    assert caught.value.code == 2
    assert words in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["run", "{file}:ball", "--duration", "1", "--stepper", "smooth"], "--stiffness: not given"),
        (["run", "{file}:ball", "--duration", "1", "--stiffness", "1"], "--stiffness: given without"),
        (["run", "{file}:ball", "--duration", "1", "--stepper", "massless-boundary"], "MoreauJean"),
        (["run", "no such scene"], "no scene 'no such scene'; expected file.py:function or one of"),
        (["run", "bouncing_bal"], "no scene 'bouncing_bal' (did you mean 'bouncing_ball'?); expected"),
        (["run", "bouncing-ball"], "(did you mean 'bouncing_ball'?)"),
        (["chart", "pendulm"], "(did you mean 'pendulum'?)"),
        (["stability", "penduulum"], "(did you mean 'pendulum'?)"),
        (["right-size", "hemispher"], "(did you mean 'hemisphere'?)"),
        (["right-size", "hemisphere", "--quantity", "mtion"], "--quantity: 'mtion' (did you mean 'motion'?)"),
        (["right-size", "hemisphere", "--tolerance", "0"], "--tolerance: 0.0 was given"),
        (["right-size", "hemisphere", "--limit", "0"], "--limit: 0.0 was given"),
        (["right-size", "hemisphere", "--step", "-1"], "--step: -1.0 was given"),
        (["right-size", "hemisphere", "--stepper", "{file}:number"], "--stepper: "),
        (["right-size", "hemisphere", "--stepper", "event-driven"], "expected file.py:name"),
        (["chart", "pendulum", "--quantity", "peek force"], "(did you mean 'peak force'?)"),
        (["chart", "pendulum", "--method", "event-drivn"], "(did you mean 'event-driven'?)"),
        (["stability", "pendulum", "--method", "event-drivn"], "(did you mean 'event-driven'?)"),
        (["stability", "pendulum", "--x", "stpe=1,2"], "(did you mean 'step'?)"),
        (["stability", "pendulum", "--plot", "x.xyz"], "--plot: 'x.xyz'; expected a name that ends in .png"),
        (["run", "{file}:ball", "--duration", "1", "--plot", "x.xyz"], "--plot: 'x.xyz'; expected a name that ends"),
        (["cross-check", "x.npz", "--plot", "x.xyz"], "--plot: 'x.xyz'; expected a name that ends in .png"),
        (["run", "missing.py:ball"], "no file 'missing.py'"),
        (["run", "{file}:bal"], "has no function 'bal'"),
        (["run", "{file}:number"], "has no function 'number'"),
        (["run", "{file}:of_mass"], "missing 1 required positional argument: 'mass'"),
        (["chart", "{file}:broken", "--duration", "1"], "raised ZeroDivisionError: division by zero"),
        (["run", "{file}:ball"], "--duration: not given"),
        (["run", "{file}:ball", "--duration", "-1"], "--duration: -1.0; expected a number of seconds > 0"),
        (["run", "{file}:ball", "--duration", "1", "--step", "nan"], "--step: nan"),
        (["run", "{file}:ball", "--duration", "1", "--save", "no_folder/x.npz"], "no_folder"),
        (["demo", "--folder", "no_folder"], "no_folder"),
    ],
)
def test_impossible_requests(
    scene_file: Path, capsys: pytest.CaptureFixture[str], arguments: list[str], words: str
) -> None:
    assert main([text.format(file=scene_file) for text in arguments]) == 2
    captured = capsys.readouterr()
    assert words in captured.err
    assert captured.out == ""


@pytest.mark.slow
def test_demo_writes_picture_chart_and_film(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["demo", "--folder", str(tmp_path)]) == 0
    printed = capsys.readouterr().out
    for name in ("lcpflex-demo.png", "lcpflex-demo.chart.png", "lcpflex-demo.gif"):
        assert (tmp_path / name).stat().st_size > 5000
        assert str(tmp_path / name) in printed


def test_run_to_a_tolerance_shows_what_was_tried(scene_file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    request = ["run", f"{scene_file}:ball", "--duration", "0.1"]
    assert main([*request, "--tolerance", "0.05"]) == 0
    printed = capsys.readouterr().out
    assert "Trusted within" in printed
    assert "0.05 asked for" in printed
    assert main([*request, "--tolerance", "0.05", "--step", "1e-3"]) == 2
    assert "given with --tolerance" in capsys.readouterr().err
    assert main([*request, "--tolerance", "2"]) == 2
    assert "tolerance: 2.0 was given" in capsys.readouterr().err
