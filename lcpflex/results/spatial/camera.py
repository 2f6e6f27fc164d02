"""From where a spatial scene is seen: parallel projection, upwards against gravity."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from lcpflex.basics.arguments import array_of, flag
from lcpflex.errors import ModelError, in_range
from lcpflex.jit.kernel import FloatArray, IntArray

__all__ = ["Camera", "Look", "camera_of", "look_of"]

USUAL = 22.0, -60.0  # elevation, azimuth [deg]
MOST = 1e6  # times that a deformation is drawn larger
ALONG = 1e-6  # of gravity, that may be across an axis for "up" to be this axis


class Look(NamedTuple):
    """Options of a picture."""

    view: tuple[float, float]  # elevation, azimuth [deg]
    frames: bool  # of the bodies
    scale: float  # times that deformations are drawn larger
    pressure: bool = False  # areas in colours in the place of arrows


class Camera(NamedTuple):
    """Directions of the picture and of the floor in world axes."""

    right: FloatArray  # (3,)
    upward: FloatArray  # (3,)
    towards: FloatArray  # (3,) to the viewer
    floor: FloatArray  # (3, 3) rows: two axes of the world along the floor and the vertical, right-handed
    axes: IntArray  # (3,) the axes of the world that these rows are: 0 x, 1 y, 2 z
    sign: float  # of the vertical along its axis

    def seen(self, places: FloatArray) -> FloatArray:
        """(..., 3) right, up and towards the viewer [m], of places (..., 3) in world axes."""
        return np.asarray(places @ np.stack([self.right, self.upward, self.towards], axis=1))


def look_of(view: Any, frames: Any, scale: Any, pressure: Any, spatial: bool) -> Look:
    """Options as a user gives them. Raises ModelError for what cannot be, and for those of space in the plane."""
    shown, coloured = flag("frames", frames), flag("pressure", pressure)
    times = in_range("scale", scale, 0.0, MOST)
    if not spatial:
        others = ("frames", shown), ("scale", times != 1.0), ("pressure", coloured)
        for name, given in (("view", view is not None), *others):
            if given:
                raise ModelError(f"{name}: it is for pictures of a SpatialScene, expected none with a planar result")
        return Look(USUAL, False, 1.0)
    if view is None:
        return Look(USUAL, shown, times, coloured)
    elevation, azimuth = array_of("view", view, (2,))
    return Look((in_range("view[0]", elevation, -90.0, 90.0), float(azimuth)), shown, times, coloured)


def camera_of(view: tuple[float, float], gravity: FloatArray) -> Camera:
    """Camera at an elevation over the floor and an azimuth about the vertical, from the first floor axis [deg].

    Up is against gravity where that is along an axis of the world, and else z.
    """
    weight = float(np.linalg.norm(gravity))
    main = int(np.argmax(np.abs(gravity)))
    vertical = weight > 0.0 and abs(gravity[main]) > (1.0 - ALONG) * weight
    up, sign = (main, -float(np.sign(gravity[main]))) if vertical else (2, 1.0)
    pair = [(up + 1) % 3, (up + 2) % 3]
    axes = np.array([*(pair if sign > 0.0 else pair[::-1]), up])
    floor = np.eye(3)[axes] * np.array([1.0, 1.0, sign])[:, None]
    elevation, azimuth = np.radians(view)
    ahead = np.cos(azimuth) * floor[0] + np.sin(azimuth) * floor[1]
    right = -np.sin(azimuth) * floor[0] + np.cos(azimuth) * floor[1]
    towards = np.cos(elevation) * ahead + np.sin(elevation) * floor[2]
    return Camera(right, np.cross(towards, right), towards, floor, axes, sign)
