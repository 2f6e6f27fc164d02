"""Which surfaces are near each other, and what touches between them.

Bounding circles come first, widened by the most that the present modal coordinates can move a point of either surface;
then nodes against features one by one (:mod:`lcpflex.contact.passes`). Declared contacts are looked at one after the
other, pairs of surfaces under a rule are found by where they are (:mod:`lcpflex.contact.broad_phase`).
"""

from __future__ import annotations

from lcpflex.contact.bounds import bound, near_surfaces
from lcpflex.contact.passes import detect_pass
from lcpflex.contact.rule_detection import detect_rule
from lcpflex.contact.table import ALL, COMPLIANT, RIGID, ContactTable, contact_table
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.jit.leaf import in_space
from lcpflex.model.arrays import Model

__all__ = ["ALL", "COMPLIANT", "RIGID", "ContactTable", "bound", "contact_table", "detect"]


@kernel
def detect_declared(
    model: Model, q: FloatArray, margin: float, table: ContactTable, first: int, last: int, n: int
) -> int:
    """Contacts of the passes first..last, from entry n on; returns the new count."""
    c = model.contacts
    for w in range(first, last):
        law = c.pass_law[w]
        if table.collects != ALL and table.compliant[law] != table.collects:
            continue
        a = c.pass_node[w]
        b = c.pass_feature[w]
        if near_surfaces(model, table, a, b, margin):
            n = detect_pass(model, q, margin, table, a, b, law, n)
    return n


@in_space("lcpflex.contact.spatial.detection")
@kernel
def detect(model: Model, q: FloatArray, margin: float, table: ContactTable) -> int:
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
    return detect_declared(model, q, margin, table, begin, len(c.pass_node), n)
