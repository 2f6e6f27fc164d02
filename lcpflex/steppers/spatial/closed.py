"""Which contacts in space a time stepper takes for closed: those of flush faces together."""

from __future__ import annotations

from lcpflex.contact.spatial.detection import detect
from lcpflex.contact.spatial.table import (
    EDGE_CAP,
    EDGE_FACET,
    NODE_CAP,
    NODE_FACET,
    SpatialContactTable,
    copy_entry,
)
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.model.spatial import SpatialModel

__all__ = ["find_closed"]

FLUSH = 1e3  # tolerances: 1e-6 of the length, which a turn of a few 1e-8 rad makes, as of a float32


@kernel
def is_flat(table: SpatialContactTable, k: int) -> bool:
    """Whether entry k is one over a flat face, which has others beside it."""
    return table.kind[k] in (NODE_FACET, NODE_CAP, EDGE_FACET, EDGE_CAP)


@kernel
def closes_with(table: SpatialContactTable, k: int, first: int, last: int, tolerance: float) -> bool:
    """Whether one of the entries first..last is of the same two faces as entry k, and closed."""
    found = False
    for i in range(first, last):
        same = is_flat(table, i) and table.law[i] == table.law[k]
        found = found or (same and table.gap[i] <= tolerance)
    return found


@kernel
def find_closed(model: SpatialModel, q: FloatArray, tolerance: float, table: SpatialContactTable) -> int:
    """Contacts with gap <= tolerance [m], and those of the same pairs that are hardly wider; how many, as ``detect``.

    A face that is turned by 1e-8 rad against another one stands on one corner. If the others were open in a step, the
    body would tip about that by what a step takes, a thousand times as far as it is open.
    """
    n = detect(model, q, FLUSH * tolerance, table)
    if n > len(table.key):
        return n
    m = 0
    for k in range(n):
        kept = table.gap[k] <= tolerance
        if not kept and is_flat(table, k):
            kept = closes_with(table, k, 0, m, tolerance) or closes_with(table, k, k + 1, n, tolerance)
        if kept:
            if m != k:
                copy_entry(table, k, table, m)
            m += 1
    return m
