"""Planes of the ground in the picture of a spatial scene: translucent patches, as large as what moves over them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from lcpflex.basics import libs
from lcpflex.contact.spatial.kinds import PLANE

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from lcpflex.jit.kernel import FloatArray
    from lcpflex.model.spatial import SpatialModel
    from lcpflex.results.spatial.camera import Camera

__all__ = ["draw_patches", "patches"]

_LEVEL = 1e-9  # 1 - cosine of the angle to the floor of a plane that the floor stands for
_ROOM = 0.08  # around what moves, relative to its extent
_FACE, _BORDER = "#8C8C86", "#6E6E69"


def patches(model: SpatialModel, places: FloatArray, up: FloatArray) -> list[FloatArray]:
    """Corners (4, 3) of a patch of each plane of the ground below or beside ``places`` (k, 3), world axes.

    Planes that are level are not among them: the floor of the picture, whose normal is ``up`` (3,), stands for them.
    """
    c, found = model.contacts, []
    for s in np.flatnonzero(c.surface_body < 0).tolist():
        f = int(c.feature_start[s])
        if f == c.feature_start[s + 1] or c.feature_kind[f] != PLANE:
            continue
        o, a, b = model.points.place[c.feature_point[f]]
        axes = np.array([a - o, b - o])
        axes /= np.linalg.norm(axes, axis=1, keepdims=True)
        if np.cross(*axes) @ up > 1.0 - _LEVEL:
            continue
        along = (places - o) @ axes.T
        low, high = along.min(axis=0), along.max(axis=0)
        room = _ROOM * float((high - low).max())
        (x0, y0), (x1, y1) = low - room, high + room
        found.append(o + np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]]) @ axes)
    return found


def draw_patches(ax: Axes, found: list[FloatArray], camera: Camera) -> None:
    """Behind the bodies, in front of the floor."""
    for corners in found:
        seen = camera.seen(corners)[:, :2]
        ax.add_patch(libs.Polygon(seen, facecolor=_FACE, edgecolor="none", alpha=0.25, zorder=0.4))
        ax.add_patch(libs.Polygon(seen, fill=False, edgecolor=_BORDER, linewidth=0.8, zorder=0.5))
