"""Films: what is written of each frame, and the time above them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

import lcpflex as lf
from lcpflex.results.film_clock import Clock
from lcpflex.results.gif import Pixels, palette_of, write_gif
from tests import libs
from tests.scenes import floor_of

WHITE, BLUE, ORANGE = (255, 255, 255, 255), (0, 114, 178, 255), (213, 94, 0, 255)


def pixels_of(colours: npt.NDArray[np.uint8]) -> Pixels:
    return np.ascontiguousarray(colours).view(np.uint32)[..., 0]


def frames_of(path: Path, seconds: float) -> list[npt.NDArray[np.uint8]]:
    with libs.image.open(path) as film:
        count: int = film.n_frames
        found = []
        for k in range(count):
            film.seek(k)
            times = round(film.info["duration"] / seconds / 1000.0)  # frames that are equal are one, shown for longer
            found += times * [np.asarray(film.convert("RGB"))]
    return found


def test_frames_of_a_gif_are_what_was_drawn(tmp_path: Path) -> None:
    """A square that moves over a ground, comes to rest, and is gone; a colour that is in no sample is a named one."""
    ground = np.full((40, 60, 4), WHITE, np.uint8)
    ground[30:] = (244, 244, 242, 255)
    drawn = []
    for place, colour in ((5, BLUE), (20, BLUE), (20, BLUE), (40, ORANGE), (None, BLUE)):
        frame = ground.copy()
        if place is not None:
            frame[10:33, place : place + 9] = colour
        drawn.append(frame)
    path = tmp_path / "film.gif"
    palette = palette_of(pixels_of(ground), [pixels_of(drawn[0])], ("#D55E00",))
    with path.open("wb") as file:
        write_gif(file, pixels_of(ground), map(pixels_of, drawn), palette, 0.04)
    for frame, expected in zip(frames_of(path, 0.04), drawn, strict=True):
        np.testing.assert_allclose(frame.astype(int), expected[..., :3], atol=4)
    with libs.image.open(path) as opened:
        assert opened.info["duration"] == 40
        assert opened.info["loop"] == 0


def test_clock_writes_as_a_text_would() -> None:
    """At most a pixel aside: digits are put at whole pixels."""
    times = np.array([9.8765, 10.4321])
    figure = libs.Figure(figsize=(4, 3), dpi=80)
    canvas = libs.FigureCanvasAgg(figure)
    axes = figure.subplots()
    canvas.draw()  # type: ignore[no-untyped-call]
    clock = Clock(canvas, axes, times, "s, twice as slow")
    pixels = np.asarray(canvas.buffer_rgba()).view(np.uint32)[..., 0]  # type: ignore[no-untyped-call]
    clock.show(pixels, 1)
    axes.text(0.0, 1.01, "t = 10.4321 s, twice as slow", transform=axes.transAxes, va="bottom", fontsize="medium")
    written = pixels.copy()
    canvas.draw()  # type: ignore[no-untyped-call]
    expected = np.asarray(canvas.buffer_rgba())[..., 0] < 128  # type: ignore[no-untyped-call]
    ink = written.view(np.uint8).reshape(*written.shape, 4)[..., 0] < 128
    near = expected.copy()
    for axis in (0, 1):
        near |= np.roll(near, 1, axis) | np.roll(near, -1, axis)
    assert not (ink & ~near).any()
    assert ink.sum() == pytest.approx(expected.sum(), rel=0.05)


def test_film_shows_what_pictures_show(tmp_path: Path) -> None:
    """The last frame of a film, in pixels of a whole drawing: ground, body, force and key."""
    scene = lf.Scene()
    box = scene.add(lf.Box(width=0.2, height=0.1, mass=1.0), position=(0.0, 0.05), velocity=(1.0, 0.0))
    scene.contact(box.surface(), floor_of(scene), friction=0.3)
    result = lf.simulate(scene, 0.1, lf.MoreauJean(step=1e-3))
    *_, last = frames_of(result.animate(tmp_path / "film.gif", fps=5.0, slowdown=20.0), 0.2)
    orange = (last[..., 0].astype(int) - last[..., 2] > 150).sum()
    result.draw(0.1).savefig(tmp_path / "still.png", dpi=80)
    whole = np.asarray(libs.image.open(tmp_path / "still.png"))
    assert orange == pytest.approx((whole[..., 0].astype(int) - whole[..., 2] > 150).sum(), rel=0.25)
    assert {(217, 217, 217), (255, 255, 255)} <= {tuple(colour) for colour in last.reshape(-1, 3).tolist()}
