"""What the guess of a step knows of space: see :mod:`lcpflex.dynamics.step_guess`."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from lcpflex.dynamics.spatial.held_modes import motions_of
from lcpflex.dynamics.spatial.static_modes import FLAT, frame_axes, normal_of
from lcpflex.jit.kernel import FloatArray
from lcpflex.model.spatial import N_RIGID, SpatialModel

__all__ = ["ends_of", "unit_motions"]


def unit_motions(model: Any, q: FloatArray, p: int, moving: npt.NDArray[np.bool_]) -> tuple[FloatArray, FloatArray]:
    """What unit forces at point p of a body, in its axes, and torques do on it (6 + n, 3); ``moving`` (n,)."""
    push, twist = (motion.T.copy() for motion in motions_of(model.points, p))
    push[:3] = frame_axes(model, q, int(model.points.body[p]))  # velocities of frames are in world axes
    for motion in (push, twist):
        motion[N_RIGID:] *= moving[:, None]
    return push, twist


def ends_of(model: SpatialModel, f: int) -> list[tuple[int, FloatArray]]:
    """Points of a feature, each with the normal of a flat one, or zeros, in the frame of its body."""
    flat = int(model.contacts.feature_kind[f]) in FLAT
    normal = normal_of(model, f, np.eye(3)) if flat else np.zeros(3)
    return [(p, normal) for p in sorted(set(model.contacts.feature_point[f].tolist()))]
