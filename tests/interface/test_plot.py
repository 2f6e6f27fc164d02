"""Charts, pictures and films."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib import animation
from matplotlib.figure import Figure
from PIL import Image

from lcpflex.errors import ModelError
from lcpflex.result import Result


def test_chart_shows_forces_gaps_and_energies_with_units(swing: Result) -> None:
    figure = swing.plot()
    assert [ax.get_ylabel() for ax in figure.axes] == ["contact force [N]", "gap [m]", "energy [J]"]
    assert figure.axes[-1].get_xlabel() == "time [s]"
    line = next(line for line in figure.axes[0].lines if line.get_label() == "disc on floor, tangential")
    np.testing.assert_array_equal(line.get_ydata(), -2.0)


def test_chart_scales_units(bounce: Result) -> None:
    figure = replace(bounce, gap=1e-3 * bounce.gap, force=bounce.force + 5e4).plot()
    assert [ax.get_ylabel() for ax in figure.axes] == ["contact force [kN]", "gap [µm]", "energy [J]"]
    assert np.nanmax(np.asarray(figure.axes[0].lines[0].get_ydata())) == pytest.approx(50.0)


def test_legends_stand_beside_the_data(swing: Result) -> None:
    figure = swing.plot()
    figure.savefig("/dev/null", format="png")
    for ax in figure.axes:
        legend = ax.get_legend()
        assert legend is not None
        box = legend.get_window_extent()
        assert box.x0 >= ax.get_window_extent().x1
        assert box.x1 <= figure.bbox.x1


def test_picture_shows_the_deformed_outline(swing: Result) -> None:
    """The corner of the beam is drawn where it is at that instant, with equal axes."""
    figure = swing.draw(0.2)
    ax = figure.axes[0]
    assert ax.get_aspect() == 1.0
    corner = swing.point("pendulum", (0.7, 0.01))[20]
    distance = min(np.linalg.norm(np.column_stack(line.get_data()) - corner, axis=1).min() for line in ax.lines)
    assert distance < 1e-12
    ax_limits = (*ax.get_xlim(), *ax.get_ylim())
    assert ax_limits[0] < corner[0] < ax_limits[1]
    assert ax_limits[2] < corner[1] < ax_limits[3]


def test_picture_has_an_arrow_for_the_force(swing: Result) -> None:
    """Along N n + T t with n = (0, 1), t = (1, 0): 9.81 N up and 2 N to the left."""
    ax = swing.draw(0.2).axes[0]
    arrows = [text for text in ax.texts if getattr(text, "arrow_patch", None) is not None]
    assert len(arrows) == 1
    tip, foot = np.array(arrows[0].xy), np.array(arrows[0].xyann)  # type: ignore[attr-defined]
    np.testing.assert_allclose(foot, (0.5 + 0.2 * 0.2, -0.9), atol=1e-12)
    direction = (tip - foot) / np.linalg.norm(tip - foot)
    np.testing.assert_allclose(direction, np.array([-2.0, 9.81]) / math.hypot(2.0, 9.81), atol=1e-12)


def test_picture_into_given_axes(swing: Result) -> None:
    figure = Figure()
    ax = figure.subplots()
    assert swing.draw(0.0, ax) is figure


@pytest.mark.parametrize("t", [-0.1, 0.5, math.nan])
def test_picture_of_a_time_that_was_not_simulated(swing: Result, t: float) -> None:
    with pytest.raises(ModelError, match=r"expected a time within the result, 0 to 0\.4 s"):
        swing.draw(t)


def test_film_as_gif(swing: Result, tmp_path: Path) -> None:
    path = swing.animate(tmp_path / "film.gif", fps=10.0, slowdown=2.0)
    with Image.open(path) as film:
        assert film.n_frames == 8  # type: ignore[attr-defined]
        assert film.info["duration"] == 100


@pytest.mark.skipif(not animation.FFMpegWriter.isAvailable(), reason="ffmpeg is not installed")
def test_film_as_mp4(swing: Result, tmp_path: Path) -> None:
    path = swing.animate(tmp_path / "film.mp4", fps=10.0, slowdown=1.0)
    assert path.read_bytes()[4:8] == b"ftyp"


def test_film_without_ffmpeg(swing: Result, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(animation.FFMpegWriter, "isAvailable", classmethod(lambda cls: False))
    with pytest.raises(ModelError, match="needs ffmpeg"):
        swing.animate(tmp_path / "film.mp4")


@pytest.mark.parametrize(
    ("name", "options", "words"),
    [
        ("film.avi", {}, r"expected a name that ends in \.gif or \.mp4"),
        ("film.gif", {"fps": 0.0}, "fps: 0.0; expected a number > 0"),
        ("film.gif", {"slowdown": math.nan}, "slowdown: nan"),
        ("missing/film.gif", {}, "cannot write"),
    ],
)
def test_film_that_cannot_be(swing: Result, tmp_path: Path, name: str, options: dict[str, float], words: str) -> None:
    short = replace(swing, duration=0.4)
    with pytest.raises(ModelError, match=words):
        short.animate(tmp_path / name, **{"slowdown": 0.5, **options})


def test_systems_without_shapes_have_charts_but_no_pictures(bounce: Result) -> None:
    assert len(bounce.plot().axes) == 3
    with pytest.raises(ModelError, match="no shapes to draw"):
        bounce.draw(0.1)
