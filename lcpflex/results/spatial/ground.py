"""The ground in the picture of a spatial scene: level planes are its floor, others translucent patches, solids solid.

Planes are shown as large as what moves over them, and solids as far as they are near it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from lcpflex.basics import libs
from lcpflex.contact.spatial.kinds import PLANE
from lcpflex.results.spatial.surfaces import clipped, cut

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from lcpflex.jit.kernel import FloatArray
    from lcpflex.model.spatial import SpatialModel
    from lcpflex.results.spatial.camera import Camera
    from lcpflex.results.spatial.facets import Facets

__all__ = ["GROUND_COLOUR", "draw_patches", "level_under", "near_solids", "patches"]

_LEVEL = 1e-9  # 1 - cosine of the angle to the floor of a plane that the floor stands for
_ROOM = 0.08  # around what moves, relative to its extent
FAR = 5.0  # extents of what moves, below which a floor is too far
SUNK = 0.05  # extents, by which what moves may reach below its floor
NEAR = 3.0  # extents, beyond which a surface of the ground is not shown
WHOLE = 8.0  # extents, up to which a surface of the ground is shown as a whole
GROUND_COLOUR = np.array([186.0, 184.0, 176.0])  # of its surfaces, in bytes
_FACE, _BORDER = "#8C8C86", "#6E6E69"


def level_under(model: SpatialModel, places: FloatArray, up: FloatArray) -> float | None:
    """Height along ``up`` (3,) of the highest level plane of the ground that ``places`` (k, 3) are above [m].

    None where there is none, or where it is so far below that they would be small in a picture with it.
    """
    low, extent = float((places @ up).min()), float(np.ptp(places, axis=0).max())
    heights = [float(o @ up) for o, axes in _planes(model) if _is_level(axes, up)]
    near = [height for height in heights if low - FAR * extent <= height <= low + SUNK * extent]
    return max(near, default=None)


def patches(model: SpatialModel, places: FloatArray, up: FloatArray, floor: float | None) -> list[FloatArray]:
    """Corners (c, 3) of a patch of each plane of the ground below or beside ``places`` (k, 3), world axes.

    The level plane at the height ``floor`` is not among them, and nothing of the others that is below it.
    """
    found = []
    for o, axes in _planes(model):
        if floor is not None and _is_level(axes, up) and float(o @ up) <= floor:
            continue
        along = (places - o) @ axes.T
        low, high = along.min(axis=0), along.max(axis=0)
        room = _ROOM * float((high - low).max())
        (x0, y0), (x1, y1) = low - room, high + room
        corners = o + np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]]) @ axes
        seen = corners if floor is None else cut(corners, corners @ up - floor)
        if len(seen):
            found.append(seen)
    return found


def _planes(model: SpatialModel) -> list[tuple[FloatArray, FloatArray]]:
    """A place (3,) and two directions (2, 3) of each plane of the ground."""
    c, found = model.contacts, []
    for s in np.flatnonzero(c.surface_body < 0).tolist():
        f = int(c.feature_start[s])
        if f < c.feature_start[s + 1] and c.feature_kind[f] == PLANE:
            o, a, b = model.points.place[c.feature_point[f]]
            axes = np.array([a - o, b - o])
            found.append((o, axes / np.linalg.norm(axes, axis=1, keepdims=True)))
    return found


def _is_level(axes: FloatArray, up: FloatArray) -> bool:
    return bool(np.cross(*axes) @ up > 1.0 - _LEVEL)


def near_solids(solids: list[Facets], places: FloatArray) -> list[Facets]:
    """What of surfaces of the ground is near ``places`` (k, 3): the whole of those that are not much larger."""
    low, high = places.min(axis=0), places.max(axis=0)
    extent = float((high - low).max())
    found = []
    for solid in solids:
        first, last = solid.vertices.min(axis=0), solid.vertices.max(axis=0)
        apart = np.maximum(first - high, low - last).max() > NEAR * extent
        small = float((last - first).max()) <= WHOLE * extent
        rest = solid if small else clipped(solid, low - extent, high + extent)
        if rest is not None and not apart:
            found.append(rest)
    return found


def draw_patches(ax: Axes, found: list[FloatArray], camera: Camera) -> None:
    """Behind the bodies, in front of the floor."""
    for corners in found:
        seen = camera.seen(corners)[:, :2]
        ax.add_patch(libs.Polygon(seen, facecolor=_FACE, edgecolor="none", alpha=0.25, zorder=0.4))
        ax.add_patch(libs.Polygon(seen, fill=False, edgecolor=_BORDER, linewidth=0.8, zorder=0.5))
