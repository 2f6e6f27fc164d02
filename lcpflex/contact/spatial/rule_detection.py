"""Contacts by the rule of a model of space: its near pairs of surfaces, in the order of the surfaces."""

from __future__ import annotations

import numpy as np

from lcpflex.bodies.spatial.surface import (
    ALL_FEATURES,
    BORE,
    CAPSULE,
    CONVEX,
    CYLINDER,
    EDGED,
    EDGES,
    FACE,
    FACES,
    MESH,
    MESHES,
    NO_POINTS,
    PIN,
    POLYHEDRON,
    TOUCHES,
    TWO_SIDED,
)
from lcpflex.contact.rule_pairs import MORE_LAWS, is_barred, law_of_pair, new_law
from lcpflex.contact.spatial.bounds import near_surfaces
from lcpflex.contact.spatial.broad_phase import may_meet, near_pairs
from lcpflex.contact.spatial.mesh_pairs import are_meshes, deforms
from lcpflex.contact.spatial.passes import detect_pass, nearest_features
from lcpflex.contact.spatial.table import SpatialContactTable
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.model.spatial import SpatialModel

__all__ = ["detect_rule"]

EDGED_KINDS = np.array(EDGED)


@kernel
def detect_face(
    model: SpatialModel, q: FloatArray, margin: float, table: SpatialContactTable, a: int, b: int, law: int, n: int
) -> int:
    """The same of two surfaces of which one is a face, or both: then that with more nodes touches the other."""
    c = model.contacts
    if c.surface_kind[a] != FACE:
        a, b = b, a
    other = c.surface_kind[b]
    if other == FACE and c.node_start[b + 1] - c.node_start[b] > c.node_start[a + 1] - c.node_start[a]:
        a, b = b, a
    mode = FACES if other in (FACE, POLYHEDRON, MESH) else ALL_FEATURES
    return detect_pass(model, q, margin, table, a, b, law, mode, n)


@kernel
def detect_between(
    model: SpatialModel, q: FloatArray, margin: float, table: SpatialContactTable, a: int, b: int, law: int, n: int
) -> int:
    """Contacts between two surfaces, from entry n on; the new count: passes as ``SpatialSurface.passes`` has them."""
    c = model.contacts
    if c.rule_rank[b] < c.rule_rank[a]:
        a, b = b, a
    kind_a, kind_b = c.surface_kind[a], c.surface_kind[b]
    if not near_surfaces(model, q, table, a, b, margin):
        return n
    if kind_a == FACE or kind_b == FACE:
        return detect_face(model, q, margin, table, a, b, law, n)
    if kind_a in (CYLINDER, POLYHEDRON) and kind_b in (CYLINDER, POLYHEDRON):
        return detect_pass(model, q, margin, table, a, b, law, CONVEX, n)
    if are_meshes(model, a, b):
        return detect_pass(model, q, margin, table, a, b, law, MESHES, n)
    if not TOUCHES[kind_a, kind_b]:
        return detect_pass(model, q, margin, table, b, a, law, ALL_FEATURES, n)
    if (kind_a == PIN and kind_b == BORE) or (kind_a == BORE and kind_b == PIN):
        n = detect_pass(model, q, margin, table, a, b, law, ALL_FEATURES, n)
        return detect_pass(model, q, margin, table, b, a, law, ALL_FEATURES, n)
    if kind_a == CAPSULE and kind_b == CYLINDER:
        n = detect_pass(model, q, margin, table, a, b, law, ALL_FEATURES, n)
        return detect_pass(model, q, margin, table, a, b, law, EDGES, n)
    if not (TOUCHES[kind_b, kind_a] and EDGED_KINDS[kind_a] and EDGED_KINDS[kind_b]):
        return detect_pass(model, q, margin, table, a, b, law, ALL_FEATURES, n)
    if deforms(model, a) or deforms(model, b):
        nodes_a, nodes_b = c.node_start[a + 1] - c.node_start[a], c.node_start[b + 1] - c.node_start[b]
        if nodes_a >= nodes_b:
            return detect_pass(model, q, margin, table, a, b, law, ALL_FEATURES, n)
        return detect_pass(model, q, margin, table, b, a, law, ALL_FEATURES, n)
    mode = NO_POINTS if kind_a == CAPSULE else TWO_SIDED
    return nearest_features(model, q, margin, table, a, b, law, mode, n)


@kernel
def detect_pair(
    model: SpatialModel, q: FloatArray, margin: float, table: SpatialContactTable, i: int, j: int, n: int
) -> int:
    """Contacts between two surfaces of the rule, i < j, from entry n on; the new count, or MORE_LAWS."""
    if is_barred(model, i, j):  # type: ignore[arg-type]  # it reads what both models have
        return n
    first = n
    known = law_of_pair(table.pairs, i, j)
    law = known if known >= 0 else model.contacts.rule_law[0]
    n = detect_between(model, q, margin, table, i, j, law, n)
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


@kernel
def detect_rule(model: SpatialModel, q: FloatArray, margin: float, table: SpatialContactTable, n: int) -> int:
    """Contacts by the rule, from entry n on; the new count, or MORE_LAWS."""
    pairs = table.pairs
    found = near_pairs(model, q, table, margin)
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
