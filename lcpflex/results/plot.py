"""Pictures of results: the scene at an instant.

No picture is opened on the screen and no global state of matplotlib is touched: functions return the figure,
which notebooks show and ``figure.savefig(path)`` writes.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from lcpflex.basics import libs
from lcpflex.basics.arguments import check_axes
from lcpflex.errors import ModelError, as_number, shown
from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.results.drawing import (
    View,
    added_surfaces,
    draw_bodies,
    draw_ground,
    draw_joints,
    draw_surfaces,
    stars,
    view_of,
)
from lcpflex.results.drawn_forces import arrow_tips, draw_forces, draw_key, usual_force, usual_length
from lcpflex.results.spatial.camera import Look, look_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from lcpflex.compile.compiled_scene import CompiledScene
    from lcpflex.results.result import Result
    from lcpflex.results.spatial.picture import SpatialPicture

__all__ = ["PlanarPicture", "draw", "picture_of", "scene_of"]


def draw(
    result: Result,
    t: float,
    axes: Axes | None = None,
    view: Any = None,
    frames: bool = False,
    scale: float = 1.0,
    pressure: bool = False,
) -> Figure:
    """Picture of the scene at the stored instant nearest to ``t`` [s].

    Bodies with their deformed outlines, joints, ground surfaces, and at each touching point an arrow for the force on
    the body (of two bodies: on the one added later). The median of all forces of the run sets the scale, which the key
    in the corner gives; an arrow that would be more than half as long again is cut and has its force beside it.
    ``axes`` draws into axes of your own.

    Spatial scenes are seen in parallel projection: bodies with light and a shadow straight below them, on a floor
    that is the highest level plane of the ground below them, and without one near them lies just under the lowest
    point and is no part of the scene; joints as circles, those with a sliding direction as squares, with a triangle
    below where they hold to the ground, fainter behind other bodies. A body without a shape and without surfaces is the
    homogeneous ellipsoid of its inertia; lines go from its mass centre to what holds it. Surfaces on bodies and, in
    grey, on the ground are drawn as they are, of what is much larger than the scene what is near; other planes of the
    ground are translucent. Arrows of forces are in front of all, and are shorter where they point to or from the
    camera. view: elevation and azimuth of the camera [deg]. frames: with the axes of all bodies, x red, y green, z
    blue. scale: times that deformations are drawn larger. pressure: the areas that forces act on
    (:meth:`lcpflex.results.contact_history.ContactHistory.pressure`) in colours of their pressures and in front of all,
    each about as large as it is; other forces stay arrows.

    Raises ModelError for a time outside the simulation, for systems without a scene, and for pressures of a run in
    which no force acts on an area.
    """
    compiled = scene_of(result)
    t, given = as_number(t), t
    look = look_of(view, frames, scale, pressure, compiled.spatial)
    check_axes(axes)
    if axes is not None and compiled.spatial and axes.name == "3d":
        raise ModelError("axes: 3-D axes were given; expected plain ones, the picture is a projection (view=)")
    if not (result.times.size and result.times[0] <= t <= result.times[-1]):
        reached = f"{result.times[0]:g} to {result.times[-1]:g} s" if result.times.size else "no instant"
        raise ModelError(f"t: {shown(given)} was given; expected a time within the result, {reached}")
    record = int(np.argmin(np.abs(result.times - t)))
    picture = picture_of(result, compiled, np.array([record]), look, still=True)
    if axes is None:
        axes = libs.Figure(figsize=picture.size(), layout="constrained").subplots()
    picture.set_out(axes)
    picture.paint(axes, record)
    axes.set_title(f"t = {result.times[record]:.6g} s{picture.words()}", fontsize="medium", loc="left")
    return axes.get_figure(root=True)  # type: ignore[return-value]


def picture_of(
    result: Result, compiled: CompiledScene, records: IntArray, look: Look, still: bool
) -> PlanarPicture | SpatialPicture:
    if compiled.spatial:
        from lcpflex.results.spatial.picture import SpatialPicture

        return SpatialPicture(result, compiled, records, look)
    return PlanarPicture(result, compiled, records, still)


class PlanarPicture:
    """A planar scene at its stored instants, all in one part of the plane; ``still``: with room for all arrows."""

    def __init__(self, result: Result, compiled: CompiledScene, records: IntArray, still: bool) -> None:
        self._result, self._compiled = result, compiled
        self._stars, self._added = stars(compiled), added_surfaces(compiled)
        self._scale = usual_force(result.contact_points)  # [N] the force whose arrow has the usual length
        self.view = view_of(result, compiled, records)
        if still:
            length = usual_length(result, compiled, self.view)
            self.view = _with_room(self.view, arrow_tips(result, compiled, int(records[0]), length, self._scale))
        self._length = usual_length(result, compiled, self.view)

    def size(self) -> tuple[float, float]:
        """Inches."""
        return _figure_size(self.view)

    def words(self) -> str:
        """Nothing is to be said behind the time."""
        return ""

    def set_out(self, ax: Axes) -> None:
        """What is the same at all instants: limits and names of the axes, the ground, the key."""
        _set_out(ax, self.view)
        draw_ground(ax, self._compiled, self.view)
        draw_key(ax, self.view, self._length, self._scale)

    def fit(self, ax: Axes) -> None:
        """Lines and areas need no pixels."""

    def paint(self, ax: Axes, record: int) -> None:
        """One instant."""
        q = self._result.q[record]
        draw_surfaces(ax, self._compiled, q, self.view, self._added)
        draw_bodies(ax, self._compiled, q, self._stars)
        draw_joints(ax, self._compiled, q)
        draw_forces(ax, self._result, self._compiled, record, self._length, self._scale)


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


def scene_of(result: Result) -> CompiledScene:
    if result.compiled is None:
        raise ModelError("result: a system of the user's own has no shapes to draw; expected the result of a Scene")
    return result.compiled


def _figure_size(view: View) -> tuple[float, float]:
    """Inches: the longer side of the picture six, and room for labels."""
    width, height = view[1] - view[0], view[3] - view[2]
    scale = 6.0 / max(width, height)
    return max(scale * width, 3.2) + 0.9, max(scale * height, 2.0) + 0.9
