"""Pictures of results: the scene at an instant, and films of it.

No picture is opened on the screen and no global state of matplotlib is touched: functions return the figure,
which notebooks show and ``figure.savefig(path)`` writes.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from lcpflex.basics import libs
from lcpflex.basics.arguments import check_axes
from lcpflex.basics.whole_file import whole_file
from lcpflex.errors import ModelError, as_number, in_range, shown, writable_path
from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.results.drawing import View, draw_bodies, draw_joints, draw_surfaces, view_of
from lcpflex.results.drawn_forces import arrow_tips, draw_forces, usual_force
from lcpflex.results.spatial.camera import Look, look_of
from lcpflex.results.spatial.picture import SpatialPicture

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from lcpflex.compile.compiled_scene import CompiledScene
    from lcpflex.results.result import Result

__all__ = ["animate", "draw"]

RATES = 0.1, 1000.0  # least and most pictures a second of a film
MOST_FRAMES = 20_000
_FILM = 6.0  # length of a film whose slowdown is not given [s]


def draw(
    result: Result, t: float, axes: Axes | None = None, view: Any = None, frames: bool = False, scale: float = 1.0
) -> Figure:
    """Picture of the scene at the stored instant nearest to ``t`` [s].

    Bodies with their deformed outlines, joints, ground surfaces, and at each touching point an arrow for the force on
    the body (of two bodies: on the one added later). The median of all forces of the run sets the scale, which the key
    in the corner gives; an arrow that would be more than half as long again is cut and has its force beside it.
    ``axes`` draws into axes of your own.

    Spatial scenes are seen in parallel projection: bodies with light and a shadow straight below them, on a floor
    that lies just under the lowest point and is no part of the scene; joints as circles, those with a sliding
    direction as squares, with a triangle below where they hold to the ground, fainter behind other bodies. A body
    without a shape is the homogeneous ellipsoid of its inertia, with lines to what holds it. Planes of the ground
    that are not level are translucent. Arrows of forces are in front of all, and are shorter where they point to or
    from the camera. view: elevation and azimuth of the camera [deg]. frames: with the axes of all bodies, x red, y
    green, z blue. scale: times that deformations are drawn larger.

    Raises ModelError for a time outside the simulation and for systems without a scene.
    """
    compiled = _scene_of(result)
    t, given = as_number(t), t
    look = look_of(view, frames, scale, compiled.spatial)
    check_axes(axes)
    if axes is not None and compiled.spatial and axes.name == "3d":
        raise ModelError("axes: 3-D axes were given; expected plain ones, the picture is a projection (view=)")
    if not (result.times.size and result.times[0] <= t <= result.times[-1]):
        reached = f"{result.times[0]:g} to {result.times[-1]:g} s" if result.times.size else "no instant"
        raise ModelError(f"t: {shown(given)} was given; expected a time within the result, {reached}")
    record = int(np.argmin(np.abs(result.times - t)))
    picture = _picture(result, compiled, np.array([record]), look, still=True)
    if axes is None:
        axes = libs.Figure(figsize=picture.size(), layout="constrained").subplots()
    picture.paint(axes, record)
    picture.set_out(axes)
    axes.set_title(f"t = {result.times[record]:.6g} s{picture.words()}", fontsize="medium", loc="left")
    return axes.get_figure(root=True)  # type: ignore[return-value]


def animate(
    result: Result,
    path: str | os.PathLike[str],
    fps: float = 25.0,
    slowdown: float | None = None,
    view: Any = None,
    frames: bool = False,
    scale: float = 1.0,
) -> Path:
    """Film of the scene: GIF, or MP4 where ffmpeg is installed, by the ending of ``path``.

    ``slowdown`` is film time over simulated time; by default the film lasts six seconds. Frames show the stored
    instant nearest to theirs. One scale of forces holds for the whole film, set by their median, for impacts would make
    all others invisible; longer arrows are cut. view, frames, scale: of spatial scenes, as of :func:`draw`; the camera
    stands still. Raises ModelError for another ending, a missing ffmpeg, or an unwritable path.
    """
    compiled = _scene_of(result)
    look = look_of(view, frames, scale, compiled.spatial)
    target = writable_path("path", path)
    ending = target.suffix.lower()
    if ending not in (".gif", ".mp4"):
        raise ModelError(f"path: {str(target)!r}; expected a name that ends in .gif or .mp4")
    if ending == ".mp4" and not libs.animation.FFMpegWriter.isAvailable():
        raise ModelError(f"path: {str(target)!r} needs ffmpeg, which is not installed; install it or expect .gif")
    fps = in_range("fps", fps, *RATES)
    if slowdown is not None:
        slowdown = in_range("slowdown", slowdown, 0.0, math.inf, open_ends=True)
    if not result.times.size:
        raise ModelError("result: it holds no instant; expected at least one")
    count = _FILM * fps if slowdown is None else float(np.ptp(result.times)) * slowdown * fps
    if not count <= MOST_FRAMES:
        given = f"fps: {fps:g}" if slowdown is None else f"fps, slowdown: {fps:g} and {slowdown:g}"
        raise ModelError(f"{given} make a film of {count:.3g} pictures, expected at most {MOST_FRAMES}")
    records, slower = _frames(result.times, fps, slowdown)
    picture = _picture(result, compiled, records, look, still=False)
    figure = libs.Figure(figsize=picture.size(), dpi=80, layout="constrained")
    canvas: Any = libs.FigureCanvasAgg(figure)
    axes = figure.subplots()
    picture.set_out(axes)
    axes.set_title(" ", fontsize="medium", loc="left")  # room for the time
    canvas.draw()  # laid out once, for all frames
    figure.set_layout_engine("none")
    picture.fit(axes)

    def paint(record: int) -> None:
        picture.paint(axes, record)
        words = f"t = {result.times[record]:.4f} s, {slower}{picture.words()}"
        axes.text(0.0, 1.01, words, transform=axes.transAxes, va="bottom", fontsize="medium")

    with whole_file("path", target) as part:
        if ending == ".gif":
            _write_gif(part, canvas, axes, records, fps, paint, picture.colours)
        else:
            writer = libs.animation.FFMpegWriter(fps=fps)  # type: ignore[arg-type]
            with writer.saving(figure, str(part), dpi=80):
                for record in records:
                    with _passing(axes):
                        paint(int(record))
                        writer.grab_frame()
    return target


def _picture(
    result: Result, compiled: CompiledScene, records: IntArray, look: Look, still: bool
) -> PlanarPicture | SpatialPicture:
    if compiled.spatial:
        return SpatialPicture(result, compiled, records, look)
    return PlanarPicture(result, compiled, records, still)


class PlanarPicture:
    """A planar scene at its stored instants, all in one part of the plane; ``still``: with room for all arrows."""

    colours = 64  # of a GIF

    def __init__(self, result: Result, compiled: CompiledScene, records: IntArray, still: bool) -> None:
        self._result, self._compiled = result, compiled
        self._scale = usual_force(result)  # [N] the force whose arrow has the usual length
        self.view = view_of(result, compiled, records)
        if still:
            tips = arrow_tips(result, compiled, int(records[0]), self.view, self._scale)
            self.view = _with_room(self.view, tips)

    def size(self) -> tuple[float, float]:
        """Inches."""
        return _figure_size(self.view)

    def words(self) -> str:
        """Nothing is to be said behind the time."""
        return ""

    def set_out(self, ax: Axes) -> None:
        """Limits and names of the axes."""
        _set_out(ax, self.view)

    def fit(self, ax: Axes) -> None:
        """Lines and areas need no pixels."""

    def paint(self, ax: Axes, record: int) -> None:
        """One instant."""
        _draw_record(ax, self._result, self._compiled, record, self.view, self._scale)


def _write_gif(
    target: Path,
    canvas: Any,
    axes: Axes,
    records: IntArray,
    fps: float,
    paint: Callable[[int], None],
    colours: int,
) -> None:
    """Draw the axes once and on a copy of them, for each frame, only what moves: five times as fast as whole frames."""
    empty = canvas.copy_from_bbox(canvas.figure.bbox)
    frames = []
    for record in records:
        canvas.restore_region(empty)
        with _passing(axes) as drawn:
            paint(int(record))
            frame = axes.spines.values() if axes.axison else ()
            for artist in [*sorted(drawn(), key=lambda a: a.get_zorder()), *frame]:
                axes.draw_artist(artist)
        picture = libs.image.fromarray(np.asarray(canvas.buffer_rgba())).convert("RGB")
        frames.append(picture.quantize(colours, method=libs.image.Quantize.FASTOCTREE, dither=libs.image.Dither.NONE))
    frames[0].save(target, save_all=True, append_images=frames[1:], duration=round(1000.0 / fps), loop=0)


@contextmanager
def _passing(axes: Axes) -> Iterator[Callable[[], list[Artist]]]:
    """What is drawn into the axes inside this context is taken out at its end; gives a function that lists it."""
    before = {id(child) for child in axes.get_children()}

    def drawn() -> list[Artist]:
        return [child for child in axes.get_children() if id(child) not in before]

    yield drawn
    for artist in drawn():
        artist.remove()


def _draw_record(ax: Axes, result: Result, compiled: CompiledScene, record: int, view: View, scale: float) -> None:
    """One instant into ``ax``; ``scale`` [N] is the force whose arrow has the usual length."""
    q = result.q[record]
    draw_surfaces(ax, compiled, q, view)
    draw_bodies(ax, compiled, q)
    draw_joints(ax, compiled, q)
    draw_forces(ax, result, compiled, record, view, scale)


def _with_room(view: View, tips: FloatArray) -> View:
    """The view with a margin around the tips of arrows."""
    room = 0.04 * max(view[1] - view[0], view[3] - view[2])
    xs, ys = tips[:, 0], tips[:, 1]
    left, low = xs.min(initial=np.inf) - room, ys.min(initial=np.inf) - room
    right, high = xs.max(initial=-np.inf) + room, ys.max(initial=-np.inf) + room
    return min(view[0], left), max(view[1], right), min(view[2], low), max(view[3], high)


def _set_out(ax: Axes, view: View) -> None:
    ax.set_aspect("equal")
    ax.set_xlim(view[0], view[1])
    ax.set_ylim(view[2], view[3])
    ax.set_xlabel("x [m]")
    ax.set_ylabel("y [m]")


def _scene_of(result: Result) -> CompiledScene:
    if result.compiled is None:
        raise ModelError("result: a system of the user's own has no shapes to draw; expected the result of a Scene")
    return result.compiled


def _frames(times: FloatArray, fps: float, slowdown: float | None) -> tuple[IntArray, str]:
    """Records nearest to the frames of a film, and how fast it runs, in words."""
    span = float(times[-1] - times[0])
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


def _figure_size(view: View) -> tuple[float, float]:
    """Inches: the longer side of the picture six, and room for labels."""
    width, height = view[1] - view[0], view[3] - view[2]
    scale = 6.0 / max(width, height)
    return max(scale * width, 3.2) + 0.9, max(scale * height, 2.0) + 0.9
