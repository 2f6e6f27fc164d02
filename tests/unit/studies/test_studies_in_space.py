"""Studies of spatial scenes against motions that are known otherwise: maps, work and precision, the command line."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import lcpflex as lf
from lcpflex.__main__ import main
from lcpflex.studies import Outcome, stability, work_precision

G, LEAN, SPEED, DURATION = 9.81, math.radians(20.0), 1.0, 0.5

SCENES = """
import lcpflex as lf

def slide(friction: float = 0.3):
    scene = lf.SpatialScene(gravity=(0.0, 0.0, -9.81))
    box = scene.add(lf.Cuboid(0.2, 0.2, 0.02, density=2700.0), "box", position=(0, 0, 0.01), velocity=(1, 0.5, 0))
    scene.contact(box.surface(), scene.ground.plane((0, 0, 0), (0, 0, 1)), friction=friction, restitution=0.0)
    return scene

def plucked():
    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    beam = lf.SpatialBeam(1.0, 1e-2, (1e-5, 2e-5), 1e-5, 1.0, 100.0, poissons_ratio=0.3, elements=3)
    scene.add(beam.reduce(None), "beam", modal=[1e-3] + 17 * [0.0], angular_velocity=(0.0, 0.0, 1.0))
    return scene
"""


def slide(friction: float = 0.3) -> lf.SpatialScene:
    """A flat box slides across a slope: its friction turns with its slip, and it turns down."""
    scene = lf.SpatialScene(gravity=G * np.array([math.sin(LEAN), 0.0, -math.cos(LEAN)]))
    box = scene.add(
        lf.Cuboid(0.2, 0.2, 0.02, density=2700.0), "box", position=(0.0, 0.0, 0.01), velocity=(0.0, SPEED, 0.0)
    )
    plane = scene.ground.plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    scene.contact(box.surface(), plane, friction=friction, restitution=0.0)
    return scene


def path(friction: float, times: np.ndarray) -> np.ndarray:
    """(k, 2) places of a point that slides so, rddot = g sin e_x - mu g cos v / |v|, and never stops: mu < tan."""

    def rate(t: float, y: np.ndarray) -> np.ndarray:
        drag = friction * G * math.cos(LEAN) * y[2:] / np.linalg.norm(y[2:])
        return np.concatenate([y[2:], [G * math.sin(LEAN), 0.0] - drag])

    found = solve_ivp(rate, (0.0, DURATION), [0.0, 0.0, 0.0, SPEED], t_eval=times, rtol=1e-11, atol=1e-13)
    return found.y[:2].T


def error_of(friction: float, stepper: object) -> float:
    """Largest distance of a run, straight between its instants, from the path, of the largest range."""
    result = lf.simulate(slide(friction), DURATION, stepper, progress=False)
    times = np.linspace(0.0, DURATION, 1001)
    exact = path(friction, times)
    there = np.stack([np.interp(times, result.times, result.q[:, k]) for k in range(2)], axis=1)
    return float(np.linalg.norm(there - exact, axis=1).max() / np.linalg.norm(np.ptp(exact, axis=0)))


def test_a_map_says_of_sliding_what_its_path_says() -> None:
    """Moreau-Jean, of first order where friction turns, is right below a step that falls with friction."""
    axes = {"friction": [0.1, 0.2, 0.3], "step": [1e-3, 2e-2, 5e-2]}

    def moreau(step: float) -> lf.MoreauJean:
        return lf.MoreauJean(step=step)

    found = stability(slide, {"Moreau-Jean": moreau}, axes, DURATION, truth=True, progress=False)
    cells = found.of("Moreau-Jean")
    errors = np.array([[error_of(mu, moreau(h)) for h in axes["step"]] for mu in axes["friction"]])
    assert set(cells.ravel()) == {Outcome.SOUND, Outcome.WRONG}
    clear = np.abs(errors / 0.01 - 1.0) > 0.2  # of different scales and norms of the two errors
    assert clear.sum() >= 7
    assert (cells[clear] == np.where(errors[clear] <= 0.01, Outcome.SOUND, Outcome.WRONG)).all()


def test_work_and_precision_of_sliding_are_those_by_its_path() -> None:
    steps = [1e-2, 5e-3, 2.5e-3]
    study = work_precision(
        slide, {"MJ": [lf.MoreauJean(h) for h in steps], "GA": [lf.GeneralizedAlpha(h) for h in steps]},
        duration=DURATION, outputs={"place": lambda result: result.q[:, :2]}, repeats=1, progress=False,
        reference=lf.EventDriven(rtol=1e-10),
    )  # fmt: skip
    for method, order, make in (("MJ", 1.0, lf.MoreauJean), ("GA", 2.0, lf.GeneralizedAlpha)):
        points = [point for point in study.points if point.method == method]
        errors = [point.at_equal_times["place"].largest for point in points]
        rates = np.log2(np.divide(errors[:-1], errors[1:]))
        assert rates == pytest.approx([order] * 2, abs=0.15)
        exact = [error_of(0.3, make(h)) for h in steps]
        assert errors == pytest.approx(exact, rel=0.1)  # at other times


def pendulum() -> lf.SpatialScene:
    """A box on a hinge of the ground that is askew to gravity."""
    scene = lf.SpatialScene(gravity=(0.0, 0.0, -G))
    box = scene.add(lf.Cuboid(0.1, 0.2, 0.5, density=1000.0), "box", position=(0.3, 0.0, 0.0), orientation=TURNED)
    scene.join(lf.Revolute(box.at(0.0, 0.0, 0.3), scene.ground.at(0.0, 0.0, 0.0), axis=(0, 1, 0)))
    return scene


TURNED = [[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]]


def test_work_and_precision_of_a_pendulum_are_those_by_its_period() -> None:
    """It falls from the horizontal: its angle is that of theta'' = m g l / J cos theta."""
    box = lf.Cuboid(0.1, 0.2, 0.5, density=1000.0)
    rate = box.mass * G * 0.3 / (box.inertia[1, 1] + box.mass * 0.3**2)
    steps = [1e-2, 5e-3, 2.5e-3]
    study = work_precision(
        pendulum, {"MJ": [lf.MoreauJean(h) for h in steps]}, duration=0.5, repeats=1, progress=False,
        outputs={"end": lambda result: float(np.arctan2(-result.q[-1, 2], result.q[-1, 0]))},
        reference=lf.EventDriven(rtol=1e-10),
    )  # fmt: skip
    found = solve_ivp(lambda t, y: [y[1], rate * math.cos(y[0])], (0.0, 0.5), [0.0, 0.0], rtol=1e-11, atol=1e-13)
    exact = found.y[0, -1]
    assert study.studies[0].reference.measured["end"].number == pytest.approx(exact, rel=1e-8)
    errors = [point.errors["end"] for point in study.points]
    assert np.divide(errors[:-1], errors[1:]) == pytest.approx([4.0, 4.0], rel=0.05)


def test_the_command_line_maps_and_sizes_spatial_scenes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "scenes.py"
    file.write_text(SCENES)
    chart = tmp_path / "map.png"
    code = main(
        ["stability", f"{file}:slide", "--x", "step=1e-3,1e-2", "--y", "friction=0.1,0.3", "--duration", "0.1",
         "--truth", "own", "--plot", str(chart)]
    )  # fmt: skip
    assert code == 0
    assert "moreau-jean: 4 sound (4 cells)" in capsys.readouterr().out
    assert chart.stat().st_size > 1000
    assert main(["stability", f"{file}:slide", "--method", "acceleration-level", "--x", "friction=0.1,0.3"]) == 0
    assert "2 sound" in capsys.readouterr().out
    code = main(["right-size", f"{file}:plucked", "--duration", "1.0", "--quantity", "motion", "--step", "5e-3"])
    told = capsys.readouterr().out
    assert code == 0
    assert "beam: 1 mode" in told or "1 mode for the beam" in told
