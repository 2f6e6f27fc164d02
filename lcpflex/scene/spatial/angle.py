"""The angle about an axis, as drives prescribe it and torsion springs resist it."""

from __future__ import annotations

import numpy as np

from lcpflex.scene.functions_of_time import Motion
from lcpflex.scene.spatial.axes import across, vector
from lcpflex.scene.spatial.relative import SpatialRelative, Way

__all__ = ["angle_about", "carried"]


def angle_about(axis: Way, angle: float | None, motion: Motion | None = None) -> SpatialRelative:
    """The angle of P about an axis at Q: since the start, or the relative one where ``angle`` is given."""
    x, _ = across(axis)
    return SpatialRelative("angle", axis, on_p=None, on_q=x, rest=angle, motion=motion, like=x)


def carried(x: Way, axis: Way, axis_p: Way) -> Way | None:
    """x after the shortest rotation that takes one axis to the other; None where they are opposite."""
    a, b = np.array(axis), np.array(axis_p)
    cos = float(a @ b)
    if cos < -1.0 + 1e-9:
        return None
    normal = np.cross(a, b)
    return vector(x + np.cross(normal, x) + np.cross(normal, np.cross(normal, x)) / (1.0 + cos))
