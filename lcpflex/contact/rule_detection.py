"""Contacts by the rule of a model: its near pairs of surfaces, in the order of the surfaces."""

from __future__ import annotations

from lcpflex.contact.bounds import near_surfaces
from lcpflex.contact.broad_phase import near_pairs
from lcpflex.contact.passes import detect_pass
from lcpflex.contact.rule_pairs import MORE_LAWS, is_barred, is_node_side, law_of_pair, may_meet, new_law
from lcpflex.contact.table import ContactTable
from lcpflex.jit.kernel import FloatArray, kernel, late_kernel
from lcpflex.model.arrays import Model

__all__ = ["detect_rule"]


@kernel
def detect_pair(model: Model, q: FloatArray, margin: float, table: ContactTable, i: int, j: int, n: int) -> int:
    """Contacts between two surfaces of the rule, i < j, from entry n on; the new count, or MORE_LAWS."""
    if is_barred(model, i, j):
        return n
    first = n
    known = law_of_pair(table.pairs, i, j)
    law = known if known >= 0 else model.contacts.rule_law[0]
    if is_node_side(model, i, j) and near_surfaces(model, table, i, j, margin):
        n = detect_pass(model, q, margin, table, i, j, law, n)
    if is_node_side(model, j, i) and near_surfaces(model, table, j, i, margin):
        n = detect_pass(model, q, margin, table, j, i, law, n)
    if known >= 0 or n == first or n > len(table.key):
        return n
    for k in range(first, n):
        if table.gap[k] <= table.touching:
            law = new_law(table.pairs, i, j)
            if law < 0:
                return MORE_LAWS
            for entry in range(first, n):
                table.law[entry] = law
            return n
    return n


@late_kernel
def detect_rule(model: Model, q: FloatArray, margin: float, table: ContactTable, n: int) -> int:
    """Contacts by the rule, from entry n on; the new count, or MORE_LAWS."""
    pairs = table.pairs
    found = near_pairs(model, table, margin)
    for k in range(found):
        n = detect_pair(model, q, margin, table, pairs.found[k, 0], pairs.found[k, 1], n)
        if n == MORE_LAWS:
            return n
    if found < 0:
        for i in range(len(model.contacts.rule_rank)):
            for j in range(i + 1, len(model.contacts.rule_rank)):
                if may_meet(model, i, j):
                    n = detect_pair(model, q, margin, table, i, j, n)
                    if n == MORE_LAWS:
                        return n
    return n
