"""Films of results: the scene over its stored instants."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from lcpflex.basics import libs
from lcpflex.basics.whole_file import whole_file
from lcpflex.errors import ModelError, in_range, writable_path
from lcpflex.results.drawn_forces import FRONT, INK
from lcpflex.results.film_clock import Clock
from lcpflex.results.gif import Part, Pixels, palette_of, write_gif
from lcpflex.results.plot import picture_of, scene_of
from lcpflex.results.spatial.camera import look_of

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes

    from lcpflex.jit.kernel import FloatArray, IntArray
    from lcpflex.results.plot import PlanarPicture
    from lcpflex.results.result import Result
    from lcpflex.results.spatial.picture import SpatialPicture

__all__ = ["animate"]

RATES = 0.1, 1000.0  # least and most pictures a second of a film
MOST_FRAMES = 20_000
_FILM = 6.0  # length of a film whose slowdown is not given [s]
_DPI = 80
_SAMPLES = 6  # frames that the colours of a GIF are chosen from


def animate(
    result: Result,
    path: str | os.PathLike[str],
    fps: float = 25.0,
    slowdown: float | None = None,
    view: Any = None,
    frames: bool = False,
    scale: float = 1.0,
    pressure: bool = False,
) -> Path:
    """Film of the scene: GIF, or MP4 where ffmpeg is installed, by the ending of ``path``.

    ``slowdown`` is film time over simulated time; by default the film lasts six seconds. Frames show the stored
    instant nearest to theirs. One scale of forces holds for the whole film, set by their median, for impacts would make
    all others invisible; longer arrows are cut. view, frames, scale, pressure: of spatial scenes, as of
    :func:`lcpflex.results.plot.draw`; the camera stands still. Raises ModelError for another ending, a missing ffmpeg,
    or an unwritable path.
    """
    compiled = scene_of(result)
    look = look_of(view, frames, scale, pressure, compiled.spatial)
    target = writable_path("path", path)
    _check_ending(target)
    fps = in_range("fps", fps, *RATES)
    records, slower = _records(result, fps, slowdown)
    picture = picture_of(result, compiled, records, look, still=False)
    stage = _Stage(picture)
    words = f"s, {slower}{picture.words()}"
    with whole_file("path", target) as part:
        if target.suffix.lower() == ".gif":
            _write_gif(part, stage, Clock(stage.canvas, stage.axes, result.times[records], words), records, fps)
        else:
            _write_mp4(part, stage, result.times, words, records, fps)
    return target


def _check_ending(target: Path) -> None:
    ending = target.suffix.lower()
    if ending not in (".gif", ".mp4"):
        raise ModelError(f"path: {str(target)!r}; expected a name that ends in .gif or .mp4")
    if ending == ".mp4" and not libs.animation.FFMpegWriter.isAvailable():
        raise ModelError(f"path: {str(target)!r} needs ffmpeg, which is not installed; install it or expect .gif")


class _Stage:
    """Axes that are laid out and drawn once, and, for each frame, drawn anew where something moves."""

    def __init__(self, picture: PlanarPicture | SpatialPicture) -> None:
        self._picture = picture
        self.figure: Any = libs.Figure(figsize=picture.size(), dpi=_DPI, layout="constrained")
        canvas: Any = libs.FigureCanvasAgg(self.figure)
        self.canvas = canvas
        self.axes: Axes = self.figure.subplots()
        picture.set_out(self.axes)
        self.axes.set_title(" ", fontsize="medium", loc="left")  # room for the time
        canvas.draw()
        self.figure.set_layout_engine("none")
        picture.fit(self.axes)
        self._front = [(artist, self._place(artist)) for artist in self._in_front()]

    def keep(self) -> Pixels:
        """What has been drawn is what stands still."""
        self._empty = self.canvas.copy_from_bbox(self.figure.bbox)
        self._still = self.pixels().copy()
        return self._still

    def pixels(self) -> Pixels:
        """Those of the canvas, to be read and written."""
        return np.asarray(self.canvas.buffer_rgba()).view(np.uint32)[..., 0]

    def show(self, record: int) -> None:
        """Draw what moves onto what stands still; frame and key of the axes stay in front of it."""
        self.canvas.restore_region(self._empty)
        with self.passing(record) as drawn:
            for artist in sorted(drawn(), key=lambda a: a.get_zorder()):
                self.axes.draw_artist(artist)
        now = self.pixels()
        for artist, place in self._front:
            if not np.array_equal(now[place], self._still[place]):
                self.axes.draw_artist(artist)

    @contextmanager
    def passing(self, record: int) -> Iterator[Callable[[], list[Artist]]]:
        """An instant is painted inside this context, and gone at its end; gives a function that lists its artists."""
        before = {id(child) for child in self.axes.get_children()}

        def drawn() -> list[Artist]:
            return [child for child in self.axes.get_children() if id(child) not in before]

        self._picture.paint(self.axes, record)
        yield drawn
        for artist in drawn():
            artist.remove()

    def _in_front(self) -> list[Artist]:
        key = [artist for artist in self.axes.get_children() if artist.get_zorder() >= FRONT]
        return [*key, *(self.axes.spines.values() if self.axes.axison else ())]

    def _place(self, artist: Artist) -> Part:
        """Rows and columns of the pixels of an artist."""
        box = artist.get_window_extent(self.canvas.get_renderer()).padded(1.0)
        height = self.figure.bbox.height
        rows = slice(max(math.floor(height - box.y1), 0), max(math.ceil(height - box.y0), 0))
        return rows, slice(max(math.floor(box.x0), 0), max(math.ceil(box.x1), 0))


def _write_gif(target: Path, stage: _Stage, clock: Clock, records: IntArray, fps: float) -> None:
    still = stage.keep()

    def frame(k: int) -> Pixels:
        stage.show(int(records[k]))
        clock.show(stage.pixels(), k)
        return stage.pixels()

    samples = [frame(k).copy() for k in np.unique(np.linspace(0, len(records) - 1, _SAMPLES).astype(int))]
    with target.open("wb") as file:
        write_gif(file, still, map(frame, range(len(records))), palette_of(still, samples, ("#000000", INK)), 1.0 / fps)


def _write_mp4(target: Path, stage: _Stage, times: FloatArray, words: str, records: IntArray, fps: float) -> None:
    writer = libs.animation.FFMpegWriter(fps=fps)  # type: ignore[arg-type]
    with writer.saving(stage.figure, str(target), dpi=_DPI):
        for record in records.tolist():
            with stage.passing(record):
                stage.axes.set_title(f"t = {times[record]:.4f} {words}", fontsize="medium", loc="left")
                writer.grab_frame()


def _records(result: Result, fps: float, slowdown: float | None) -> tuple[IntArray, str]:
    """Records nearest to the frames of a film, and how fast it runs, in words."""
    times = result.times
    if slowdown is not None:
        slowdown = in_range("slowdown", slowdown, 0.0, math.inf, open_ends=True)
    if not times.size:
        raise ModelError("result: it holds no instant; expected at least one")
    span = float(np.ptp(times))
    count = _FILM * fps if slowdown is None else span * slowdown * fps
    if not count <= MOST_FRAMES:
        given = f"fps: {fps:g}" if slowdown is None else f"fps, slowdown: {fps:g} and {slowdown:g}"
        raise ModelError(f"{given} make a film of {count:.3g} pictures, expected at most {MOST_FRAMES}")
    if slowdown is None:
        slowdown = _FILM / span if span > 0.0 else 1.0
    moments = np.linspace(times[0], times[-1], max(2, round(span * slowdown * fps)))
    after = np.clip(np.searchsorted(times, moments), 1, max(len(times) - 1, 1))
    records = np.where(
        moments - times[after - 1] <= times[np.minimum(after, len(times) - 1)] - moments, after - 1, after
    )
    records = np.minimum(records, len(times) - 1)
    words = f"{slowdown:.3g} times slower" if slowdown >= 1.0 else f"{1.0 / slowdown:.3g} times faster"
    return records, words
