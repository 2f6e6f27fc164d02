"""Contacts near a configuration, and their rows: for what is looked at once, outside of steppers."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from lcpflex.contact.detection import ContactTable, detect
from lcpflex.contact.rows import contact_rows
from lcpflex.contact.rule_pairs import rule_pairs
from lcpflex.contact.table import room_in_space, table_maker
from lcpflex.jit.kernel import FloatArray
from lcpflex.model.arrays import Contacts, Model
from lcpflex.model.layout import is_spatial

__all__ = ["near", "normal_row", "surfaces_of"]


def near(model: Any, q: FloatArray, margin: float) -> tuple[Any, int]:
    """Pairs with gaps up to ``margin`` [m], in a packed model, and how many they are."""
    capacity = 64
    pairs = rule_pairs(model.contacts)
    make, room = table_maker(is_spatial(model)), room_in_space(model.contacts)
    while True:
        table = make(capacity, len(model.contacts.surface_body), pairs=pairs, touching=-math.inf, **room)
        found = int(detect(model, q, margin, table))
        if found <= capacity:
            return table, found
        capacity = 2 * found


def surfaces_of(contacts: Contacts, key: int) -> tuple[int, int]:
    """Surfaces of the node and of the feature of an entry of a table, by its key."""
    node, feature = divmod(key, len(contacts.feature_kind))
    if node >= len(contacts.node_point):  # in space: an edge or rim instead
        sides = tuple((contacts.feature_start, index) for index in (node - len(contacts.node_point), feature))
    else:
        sides = ((contacts.node_start, node), (contacts.feature_start, feature))
    a, b = (int(np.searchsorted(start, index, side="right")) - 1 for start, index in sides)
    return a, b


def normal_row(model: Model, q: FloatArray, table: ContactTable, k: int) -> FloatArray:
    """w_N (ndof,) of entry k."""
    dof = model.bodies.dof
    rows = np.zeros((3 if is_spatial(model) else 2, 2, int(np.max(np.diff(dof)))))
    contact_rows(model, q, table, k, rows[0], rows[1:])
    row = np.zeros(int(dof[-1]))
    for side, b in enumerate(table.body[k]):
        if b >= 0:
            row[dof[b] : dof[b + 1]] += rows[0, side, : dof[b + 1] - dof[b]]
    return row
