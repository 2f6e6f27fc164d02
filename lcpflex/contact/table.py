"""The table of near contacts: what detection fills, and steppers read."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from lcpflex.contact.rule_pairs import RulePairs, no_pairs
from lcpflex.contact.spatial.kinds import AROUND, CAP
from lcpflex.jit.kernel import FloatArray, IntArray, kernel
from lcpflex.jit.leaf import in_space
from lcpflex.jit.struct import allocate, array, struct

__all__ = [
    "ALL",
    "COMPLIANT",
    "RIGID",
    "ContactTable",
    "contact_table",
    "entry_of",
    "most_corners",
    "room_in_space",
    "table_maker",
    "weight_of",
]

RIGID, COMPLIANT, ALL = range(3)  # contacts that a table collects: rigid ones, compliant ones, all


@struct
class ContactTable:
    """Near contacts, one an entry, in the order of detection. Work arrays apart, the first length is the capacity."""

    key: IntArray = array("contacts")  # node and feature in one number, the same from call to call
    law: IntArray = array("contacts")  # declared contact
    node: IntArray = array("contacts")  # material point P of the node
    node_radius: FloatArray = array("contacts")  # [m]
    kind: IntArray = array("contacts")  # of the feature
    a: IntArray = array("contacts")  # material points of the feature
    b: IntArray = array("contacts")
    s: FloatArray = array("contacts")  # foot on a segment, 0 at a and 1 at b
    radius: FloatArray = array("contacts")  # of an arc, signed [m]
    sense: FloatArray = array("contacts")  # of an arc: +1 solid inside, -1 hole
    span: FloatArray = array("contacts", 2)  # of the feature
    body: IntArray = array("contacts", 2)  # i of the node, j of the feature; -1: ground
    gap: FloatArray = array("contacts")  # [m]
    normal: FloatArray = array("contacts", 2)  # from j to i
    bound: FloatArray = array(
        "surfaces", 5
    )  # work: world centre, deflection, and cosine and sine of the angle of its body
    frame: FloatArray = array(4)  # work: cosine, sine, x, y of the nodes' body in the frame of the features' body
    compliant: IntArray = array("laws")  # 1: compliant, has a continuous contact force, 0: rigid; none: of no matter
    collects: int  # which of these two the table is for, or ALL
    pairs: RulePairs  # of the rule of the model
    touching: float  # gap up to which a pair of the rule gets a law of its own [m]; -inf: none does here


def contact_table(
    capacity: int,
    n_surfaces: int = 0,
    compliant: Sequence[int] = (),
    collects: int = ALL,
    pairs: RulePairs | None = None,
    touching: float = math.inf,
    corners: int = 0,
    faces: Any = None,
) -> ContactTable:
    """An empty table for ``capacity`` contacts between ``n_surfaces`` surfaces (those of the model it is used with).

    pairs: of the rule of that model, where it has one. corners, faces: of what there is in space alone.
    """
    sizes = {"contacts": capacity, "surfaces": n_surfaces}
    return allocate(
        ContactTable,
        sizes,
        compliant=np.array(compliant, np.int64),
        collects=collects,
        pairs=no_pairs() if pairs is None else pairs,
        touching=touching,
    )


def room_in_space(contacts: Any) -> dict[str, Any]:
    """What a table of a model has besides, by the names that :func:`table_maker` takes; nothing in the plane."""
    if not hasattr(contacts, "sample_start"):
        return {}
    from lcpflex.contact.spatial.faces.memory import face_sizes

    nodes = int(np.max(np.diff(contacts.node_start), initial=0)) if len(contacts.node_shape) else 0
    return {"corners": most_corners(contacts), "faces": face_sizes(contacts), "nodes": nodes}


def most_corners(contacts: Any) -> int:
    """How many corners a patch of two faces, or of flat ends of cylinders, has at most; none in the plane.

    A circle crosses each side of a polygon twice.
    """
    sides = int(np.max(np.diff(getattr(contacts, "side_start", ())), initial=0))
    if not hasattr(contacts, "side_start") or CAP not in contacts.feature_kind:
        return 2 * sides
    return 3 * max(sides, AROUND) + AROUND + 2  # of each rim the lowest place, too


def table_maker(in_space: bool) -> Any:
    """The function that makes a table of contacts in the plane, or in space, where its module is loaded."""
    if not in_space:
        return contact_table
    from lcpflex.contact.spatial.table import spatial_contact_table

    return spatial_contact_table


@kernel
def entry_of(keys: IntArray, n: int, key: int, start: int) -> int:
    """Which of the first n keys a key is, -1: none. Looked for from ``start`` on, and then before it.

    Contacts come in one order, whatever they are looked for: behind the one that was found last is the next one.
    """
    for k in range(start, n):
        if keys[k] == key:
            return k
    for k in range(min(start, n)):
        if keys[k] == key:
            return k
    return -1


@in_space("lcpflex.contact.spatial.table")
@kernel
def weight_of(table: ContactTable, k: int) -> float:
    """Share of entry k in what its law does: 1 but for corners of patches in space, which come and go."""
    return 1.0
