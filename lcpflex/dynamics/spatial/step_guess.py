"""What the guess of a step knows of space: see :mod:`lcpflex.dynamics.step_guess`."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from lcpflex.dynamics.spatial.static_modes import FLAT, frame_axes, normal_of
from lcpflex.dynamics.static_modes import shapes_at
from lcpflex.jit.kernel import FloatArray
from lcpflex.model.spatial import SpatialModel

__all__ = ["ends_of", "unit_motions"]


def unit_motions(model: Any, q: FloatArray, p: int, moving: npt.NDArray[np.bool_]) -> tuple[FloatArray, FloatArray]:
    """What unit forces at point p of a body, in its axes, and torques do on it (6 + n, 3); ``moving`` (n,)."""
    phi, _ = shapes_at(model, p)
    x, y, z = model.points.place[p]
    arm = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    rows = np.vstack([frame_axes(model, q, int(model.points.body[p])), arm, moving[:, None] * phi])
    psi = model.points.psi[model.points.start[p] : model.points.start[p + 1]]
    return rows, np.vstack([np.zeros((3, 3)), np.eye(3), moving[:, None] * psi])


def ends_of(model: SpatialModel, f: int) -> list[tuple[int, FloatArray]]:
    """Points of a feature, each with the normal of a flat one, or zeros, in the frame of its body."""
    flat = int(model.contacts.feature_kind[f]) in FLAT
    normal = normal_of(model, f, np.eye(3)) if flat else np.zeros(3)
    return [(p, normal) for p in sorted(set(model.contacts.feature_point[f].tolist()))]
