"""Continuous contact forces in a hollow of spatial surfaces, where one node touches several facets at once."""

from __future__ import annotations

from lcpflex.contact.concave_corners import SHALLOW, YIELDED
from lcpflex.contact.spatial.table import NODE_FACET, SpatialContactTable
from lcpflex.jit.kernel import kernel

__all__ = ["yield_to_deeper"]


@kernel
def yield_to_deeper(table: SpatialContactTable, n: int) -> None:
    """In a shallow hollow, leave a node the deeper of its indentations in two facets: see the plane."""
    deepest = 0
    for k in range(1, n):
        turn = 0.0
        for c in range(3):
            turn += table.normal[k, c] * table.normal[deepest, c]
        one_hollow = (
            table.node[k] == table.node[deepest]
            and table.law[k] == table.law[deepest]
            and table.kind[k] == NODE_FACET
            and table.kind[deepest] == NODE_FACET
            and table.body[k, 1] == table.body[deepest, 1]
            and turn > SHALLOW
        )
        if one_hollow and table.gap[k] >= table.gap[deepest]:
            table.gap[k] = max(table.gap[k], YIELDED)
            continue
        if one_hollow:
            table.gap[deepest] = max(table.gap[deepest], YIELDED)
        deepest = k
