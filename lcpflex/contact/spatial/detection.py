"""What touches between spatial bodies: nothing yet, as spatial scenes take no contacts."""

from __future__ import annotations

import math

from lcpflex.contact.table import ContactTable
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.model.spatial import SpatialModel

__all__ = [
    "contact_bias",
    "contact_point",
    "contact_rows",
    "detect",
    "foot_margin",
    "gap_rate",
    "node_margin",
    "refresh",
]


@kernel
def detect(model: SpatialModel, q: FloatArray, margin: float, table: ContactTable) -> int:
    """How many contacts have a gap <= margin [m]: none."""
    return len(model.contacts.pass_node)


@kernel
def refresh(model: SpatialModel, q: FloatArray, table: ContactTable, k: int) -> None:
    """Renew the gap and normal of contact k."""


@kernel
def contact_bias(model: SpatialModel, q: FloatArray, u: FloatArray, table: ContactTable, k: int) -> tuple[float, float]:
    """w_N and w_T of contact k."""
    return 0.0, 0.0


@kernel
def contact_rows(
    model: SpatialModel, q: FloatArray, table: ContactTable, k: int, normal: FloatArray, tangent: FloatArray
) -> None:
    """Rows of contact k."""


@kernel
def foot_margin(model: SpatialModel, q: FloatArray, table: ContactTable, k: int) -> float:
    """How far the foot of contact k is inside its feature."""
    return math.inf


@kernel
def node_margin(model: SpatialModel, q: FloatArray, table: ContactTable, k: int) -> float:
    """How far the foot of contact k is inside what its node is."""
    return math.inf


@kernel
def gap_rate(model: SpatialModel, q: FloatArray, u: FloatArray, table: ContactTable, k: int) -> float:
    """Rate of the gap of contact k [m/s]."""
    return 0.0


@kernel
def contact_point(model: SpatialModel, q: FloatArray, table: ContactTable, k: int) -> tuple[float, float]:
    """Where contact k touches."""
    return 0.0, 0.0
