"""Which surfaces of space are near each other, and what touches between them.

Bounding spheres come first, widened by the most that the present modal coordinates can move a point of either surface;
then what one surface has with the other (:mod:`lcpflex.contact.spatial.passes`). Declared contacts are looked at one
after the other, pairs of surfaces under a rule are found by where they are.
"""

from __future__ import annotations

from lcpflex.bodies.spatial.surface import EDGES
from lcpflex.contact.rule_pairs import MORE_LAWS
from lcpflex.contact.spatial.bounds import bound, near_surfaces
from lcpflex.contact.spatial.passes import detect_pass
from lcpflex.contact.spatial.rule_detection import detect_rule
from lcpflex.contact.spatial.table import SpatialContactTable
from lcpflex.contact.spatial.twice import drop_twice
from lcpflex.contact.table import ALL, COMPLIANT
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.model.spatial import SpatialModel

__all__ = ["detect"]


@kernel
def detect_declared(
    model: SpatialModel, q: FloatArray, margin: float, table: SpatialContactTable, first: int, last: int, n: int
) -> int:
    """Contacts of the passes first..last, from entry n on; returns the new count."""
    c = model.contacts
    before = n  # of the first pass of a contact
    for w in range(first, last):
        law = c.pass_law[w]
        a = c.pass_node[w]
        b = c.pass_feature[w]
        again = w > first and c.pass_law[w - 1] == law and c.pass_mode[w] != EDGES
        start = n
        if not again:
            before = n
        if table.collects != ALL and table.compliant[law] != table.collects:
            continue
        if near_surfaces(model, q, table, a, b, margin):
            n = detect_pass(model, q, margin, table, a, b, law, c.pass_mode[w], n)
            if again and start < n <= len(table.key):
                n = drop_twice(model, q, table, a, b, before, start, n)
    return n


@kernel
def detect(model: SpatialModel, q: FloatArray, margin: float, table: SpatialContactTable) -> int:
    """All contacts with gap <= margin [m] at q, in the order of passes, nodes and features.

    Pairs of a rule come where the rule stands among the passes, in the order of their surfaces. Those that touch for
    the first time in a table that gives them a law get the next one.

    Returns how many there are, or at least as many if that exceeds the capacity: entries then mean nothing; MORE_LAWS
    (:mod:`lcpflex.contact.rule_pairs`) where there is none left for a pair.
    """
    bound(model, q, table)
    c = model.contacts
    n, begin = 0, 0
    if len(c.rule_rank) > 0:
        begin = c.rule_pass[0]
        n = detect_declared(model, q, margin, table, 0, begin, n)
        if table.collects != COMPLIANT:
            n = detect_rule(model, q, margin, table, n)
            if n == MORE_LAWS:
                return n
    return detect_declared(model, q, margin, table, begin, len(c.pass_node), n)
