"""Continuous contact forces in a hollow, where one node touches two segments at once."""

from __future__ import annotations

from lcpflex.contact.narrow_phase.feature import SEGMENT
from lcpflex.contact.table import ContactTable
from lcpflex.jit.kernel import kernel
from lcpflex.jit.leaf import in_space

__all__ = ["YIELDED", "yield_to_deeper"]

SHALLOW = 0.98  # cosine of 0.2 rad: of two segments that meet in a hollow of less turn, one holds a node at a time
YIELDED = 1e-300  # [m] gap of the other one: it does not touch


@in_space("lcpflex.contact.spatial.concave_corners")
@kernel
def yield_to_deeper(table: ContactTable, n: int) -> None:
    """In a shallow hollow of two segments, leave a node the deeper of its two indentations: the other one ends.

    A node comes over the second segment when it is already below it. Both forces together would begin there with a
    jump, and the second spring would be found compressed by nobody. The deeper of two indentations has no jumps.
    """
    deepest = 0
    for k in range(1, n):
        one_hollow = (
            table.node[k] == table.node[deepest]
            and table.law[k] == table.law[deepest]
            and table.kind[k] == SEGMENT
            and table.kind[deepest] == SEGMENT
            and table.normal[k, 0] * table.normal[deepest, 0] + table.normal[k, 1] * table.normal[deepest, 1] > SHALLOW
        )
        if one_hollow and table.gap[k] >= table.gap[deepest]:
            table.gap[k] = max(table.gap[k], YIELDED)
            continue
        if one_hollow:
            table.gap[deepest] = max(table.gap[deepest], YIELDED)
        deepest = k
