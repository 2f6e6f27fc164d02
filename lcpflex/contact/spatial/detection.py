"""Which surfaces of space are near each other, and what touches between them."""

from __future__ import annotations

from lcpflex.contact.spatial.table import SpatialContactTable
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.model.spatial import SpatialModel

__all__ = ["detect"]


@kernel
def detect(model: SpatialModel, q: FloatArray, margin: float, table: SpatialContactTable) -> int:
    """How many contacts have a gap <= margin [m]: none, as scenes declare none yet."""
    return len(model.contacts.pass_node)
