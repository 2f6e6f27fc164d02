"""The table of near contacts: what detection fills, and steppers read."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.jit.struct import pack

__all__ = ["ALL", "BY_LAW", "SET_VALUED", "ContactTable", "contact_table"]

SET_VALUED, BY_LAW, ALL = range(3)  # contacts that a table collects


class ContactTable(NamedTuple):
    """Near contacts, one an entry, in the order of detection. Work arrays apart, the first length is the capacity."""

    key: IntArray  # slave and feature in one number, the same from call to call
    law: IntArray  # declared contact
    slave: IntArray  # material point P
    slave_radius: FloatArray  # [m]
    kind: IntArray  # of the feature: SEGMENT or ARC
    a: IntArray  # material points of the feature
    b: IntArray
    s: FloatArray  # foot on a segment, 0 at a and 1 at b
    radius: FloatArray  # of an arc, signed [m]
    sense: FloatArray  # of an arc: +1 solid inside, -1 hole
    span: FloatArray  # (., 2) of the feature
    body: IntArray  # (., 2) i of the slave, j of the feature; -1: ground
    gap: FloatArray  # [m]
    normal: FloatArray  # (., 2) from j to i
    bound: FloatArray  # (surfaces, 5) work: world centre, sway, and cosine and sine of the angle of its body
    frame: FloatArray  # (4,) work: cosine, sine, x, y of the slaves' body in the frame of the features' body
    by_law: IntArray  # (laws,) 1: has a continuous contact force, 0: is set-valued; (0,): of no matter
    collects: IntArray  # (1,) which of these two the table is for, or ALL


def contact_table(capacity: int, n_surfaces: int = 0, by_law: Sequence[int] = (), collects: int = ALL) -> ContactTable:
    """An empty table for ``capacity`` contacts between ``n_surfaces`` surfaces (those of the model it is used with)."""
    ints = np.int64
    table = ContactTable(
        key=np.zeros(capacity, ints),
        law=np.zeros(capacity, ints),
        slave=np.zeros(capacity, ints),
        slave_radius=np.zeros(capacity),
        kind=np.zeros(capacity, ints),
        a=np.zeros(capacity, ints),
        b=np.zeros(capacity, ints),
        s=np.zeros(capacity),
        radius=np.zeros(capacity),
        sense=np.zeros(capacity),
        span=np.zeros((capacity, 2)),
        body=np.zeros((capacity, 2), ints),
        gap=np.zeros(capacity),
        normal=np.zeros((capacity, 2)),
        bound=np.zeros((n_surfaces, 5)),
        frame=np.zeros(4),
        by_law=np.array(by_law, ints),
        collects=np.array([collects]),
    )
    return pack(table)
