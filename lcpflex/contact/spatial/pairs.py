"""Gaps, normals, rows and biases of contact pairs in space."""

from __future__ import annotations

import math

from lcpflex.contact.spatial.table import SpatialContactTable
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.kinematics.spatial.rotations import Vector
from lcpflex.model.spatial import SpatialModel

__all__ = ["contact_bias", "contact_point", "contact_rows", "foot_margin", "gap_rate", "node_margin", "refresh"]


@kernel
def refresh(model: SpatialModel, q: FloatArray, table: SpatialContactTable, k: int) -> None:
    """Gap, normal, tangent and foot of entry k at q, with its features kept."""


@kernel
def contact_bias(
    model: SpatialModel, q: FloatArray, u: FloatArray, table: SpatialContactTable, k: int
) -> tuple[float, float, float]:
    """w_N and w_T along both tangents of entry k [m/s^2]."""
    return 0.0, 0.0, 0.0


@kernel
def contact_rows(
    model: SpatialModel,
    q: FloatArray,
    table: SpatialContactTable,
    k: int,
    normal: FloatArray,
    first: FloatArray,
    second: FloatArray,
) -> None:
    """Rows of entry k, (2, width) each: blocks for body i and body j; a block on the ground stays 0."""


@kernel
def foot_margin(model: SpatialModel, q: FloatArray, table: SpatialContactTable, k: int) -> float:
    """How far the foot of entry k is inside its feature."""
    return math.inf


@kernel
def node_margin(model: SpatialModel, q: FloatArray, table: SpatialContactTable, k: int) -> float:
    """How far the foot of entry k is inside what its node is."""
    return math.inf


@kernel
def gap_rate(model: SpatialModel, q: FloatArray, u: FloatArray, table: SpatialContactTable, k: int) -> float:
    """Rate of the gap of entry k [m/s]."""
    return 0.0


@kernel
def contact_point(model: SpatialModel, q: FloatArray, table: SpatialContactTable, k: int) -> Vector:
    """Where entry k touches [m], world axes."""
    return 0.0, 0.0, 0.0
