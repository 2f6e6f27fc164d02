"""Contacts of a user's own system with two tangential directions each, in place of the kernels of space.

The directions of its W_T are t1 and t2; as no axes of a world belong to them, t1, t2 and the normal count as x, y, z.
"""

from __future__ import annotations

import math

import numpy as np

from lcpflex.contact import detection, rows as kinematics
from lcpflex.contact.narrow_phase import feature
from lcpflex.contact.spatial.table import SpatialContactTable
from lcpflex.dynamics import mechanics
from lcpflex.dynamics.spatial.inertia import RowsOfSpace
from lcpflex.dynamics.user_mechanics import Mechanics
from lcpflex.jit.dispatch import Hooks
from lcpflex.jit.kernel import FloatArray
from lcpflex.model.spatial import SpatialModel

__all__ = ["cone_hooks"]


def cone_hooks(system: Mechanics) -> Hooks:
    """Replacements of the kernels of contacts that know two directions of friction."""

    def detect(model: SpatialModel, q: FloatArray, margin: float, table: SpatialContactTable) -> int:
        gaps = system.gaps(q)
        near = np.flatnonzero(gaps <= margin)
        for k, law in enumerate(near[: len(table.key)]):
            table.key[k] = table.law[k] = law
            table.gap[k] = gaps[law]
            table.weight[k] = 1.0
            table.body[k] = (0, -1)
            table.normal[k] = (0.0, 0.0, 1.0)
            table.tangent[k] = (1.0, 0.0, 0.0)
        return len(near)

    def contact_point(
        model: SpatialModel, q: FloatArray, table: SpatialContactTable, k: int
    ) -> tuple[float, float, float]:
        return np.nan, np.nan, np.nan

    def within_bounds(model: SpatialModel, q: FloatArray, table: SpatialContactTable, k: int) -> float:
        return math.inf  # there are no features to leave: a contact is closed where its gap is

    def fill_contact_rows(model: SpatialModel, q: FloatArray, n: int, n_joint: int, rows: RowsOfSpace) -> int:
        if n == 0:
            return 0
        laws = rows.table.law[:n]
        rows.mu[:n] = system.friction[laws]
        rough = np.flatnonzero(rows.mu[:n] > 0.0)
        n_tangents = 2 * len(rough)
        last = n_joint + n + n_tangents
        rows.tangent[:n_tangents] = np.repeat(rough, 2)
        rows.J[n_joint : n_joint + n, 0] = system.normals(q)[:, laws].T
        if n_tangents:
            across = system.tangents(q)[:, laws[rough]]
            rows.J[n_joint + n : last, 0] = across.reshape(system.n, n_tangents).T
        rows.body[n_joint:last] = (0, -1)
        return n_tangents

    def contact_biases(
        model: SpatialModel, q: FloatArray, u: FloatArray, n: int, n_tangent: int, n_joint: int, rows: RowsOfSpace
    ) -> None:
        if n == 0:
            return
        w_n, w_t = system.biases(q, u)
        laws = rows.table.law[:n]
        rows.bias[n_joint : n_joint + n] = w_n[laws]
        rough = rows.tangent[:n_tangent:2]
        rows.bias[n_joint + n : n_joint + n + n_tangent] = w_t[laws[rough]].reshape(-1)

    return {
        detection.detect: detect,
        kinematics.contact_point: contact_point,
        feature.foot_margin: within_bounds,
        feature.node_margin: within_bounds,
        mechanics.fill_contact_rows: fill_contact_rows,
        mechanics.contact_biases: contact_biases,
    }
