"""Chart of the pressure over the patch of a contact at an instant."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from lcpflex.basics import libs
from lcpflex.basics.arguments import check_axes
from lcpflex.results.spatial.pressed_areas import cells_of, colours_of, draw_bar, draw_cells
from lcpflex.results.words import prefix_of, with_unit

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from lcpflex.jit.kernel import FloatArray
    from lcpflex.results.contact_history import ContactPoints

__all__ = ["plot_pressure"]

AXES = "x", "y", "z"
ALONG = 1e-3  # off an axis of the world by less, a direction has its name
ROOM = 0.06  # around the patch
WIDTH, SHARE = 6.0, 0.7  # inches of a figure, and how much of it the patch has
HEIGHTS, LABELS = (1.2, 4.2), 0.9  # inches of the patch, and of what is below and above it


class _Patch(NamedTuple):
    """Cells in their plane, from the centre of the force."""

    cells: list[FloatArray]  # (n, 2) each [m]
    plane: FloatArray  # (2, 3) directions to the right and up
    low: FloatArray  # (2,) of all with some room
    high: FloatArray


def plot_pressure(points: ContactPoints, name: str, t: float, axes: Axes | None) -> Figure:
    """Of touching points with areas; see :meth:`lcpflex.results.contact_history.ContactHistory.plot_pressure`."""
    check_axes(axes)
    patch = _patch_of(points) if len(points.area) else None
    if axes is None:
        axes = libs.Figure(figsize=(WIDTH, _height(patch)), layout="constrained").subplots()
    words = "no contact"
    if patch is None:
        axes.set_axis_off()
    else:
        axes.set_aspect("equal")
        _draw(axes, patch, np.asarray(points.force[:, 0] / points.area))
        pressed = points.force[:, 0] > 0.0
        total, area = float(points.force[pressed, 0].sum()), float(points.area[pressed].sum())
        words = f"{with_unit(total, 'N')} on {1e6 * area:.4g} mm²"
    axes.set_title(f"{name}, t = {t:.6g} s: {words}", fontsize="medium", loc="left")
    return axes.get_figure(root=True)  # type: ignore[return-value]


def _height(patch: _Patch | None) -> float:
    """Inches."""
    if patch is None:
        return 1.0
    width, height = patch.high - patch.low
    return float(np.clip(SHARE * WIDTH * height / width, *HEIGHTS)) + LABELS


def _patch_of(points: ContactPoints) -> _Patch:
    plane, centre = _plane_of(points), _mean(points, points.place)
    cells = [(cell - centre) @ plane.T for cell in cells_of(points.place, points.normal, points.area)]
    every = np.concatenate(cells)
    low, high = every.min(axis=0), every.max(axis=0)
    room = ROOM * float((high - low).max())
    return _Patch(cells, plane, low - room, high + room)


def _draw(axes: Axes, patch: _Patch, pressures: FloatArray) -> None:
    colours = colours_of(pressures)
    factor, prefix = prefix_of(float((patch.high - patch.low).max()))
    draw_cells(axes, [cell / factor for cell in patch.cells], pressures, colours)
    axes.set_xlim(patch.low[0] / factor, patch.high[0] / factor)
    axes.set_ylim(patch.low[1] / factor, patch.high[1] / factor)
    axes.set_xlabel(f"{_direction(patch.plane[0])} from the centre of the force [{prefix}m]")
    axes.set_ylabel(f"{_direction(patch.plane[1])} [{prefix}m]")
    draw_bar(axes, colours)


def _mean(points: ContactPoints, values: FloatArray) -> FloatArray:
    """(3,) of (k, 3), weighted by the size of the forces; by areas where there is none."""
    weight = np.abs(points.force[:, 0])
    largest = float(weight.max())
    weight = weight / largest if largest > 0.0 else points.area / points.area.max()
    return np.asarray(weight @ values / weight.sum())


def _plane_of(points: ContactPoints) -> FloatArray:
    """(2, 3) directions to the right and up, across the mean normal, along axes of the world as far as can be."""
    normal = _mean(points, points.normal)
    size = float(np.linalg.norm(normal))
    normal = normal / size if size > ALONG else points.normal[0]
    right = np.eye(3)[int(np.argmin(np.abs(normal).round(3)))]  # of two alike the first
    right = right - (right @ normal) * normal
    right /= np.linalg.norm(right)
    up = np.cross(normal, right)
    return np.array([right, up if up[np.argmax(np.abs(up))] > 0.0 else -up])


def _direction(along: FloatArray) -> str:
    """A direction in words."""
    main = int(np.argmax(np.abs(along)))
    if abs(along[main]) > 1.0 - ALONG**2:
        return AXES[main]
    return f"along ({', '.join(f'{part:.2g}' for part in along.round(3) + 0.0)})"
