"""Memory for contacts by a continuous force law in scenes where others are set-valued."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from lcpflex.contact.detection import BY_LAW, ContactTable, contact_table
from lcpflex.force_laws.history import ContactMemory, contact_memory
from lcpflex.force_laws.layout import LawRow
from lcpflex.force_laws.penalty import Penalty
from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.jit.struct import pack
from lcpflex.model.arrays import Contacts

__all__ = ["LawContacts", "law_contacts"]

SPARE = 64  # entries of the table beyond those that the slaves are expected to need


class LawContacts(NamedTuple):
    """Contacts by law at the state last looked at, and what they remember; empty where there are none."""

    table: ContactTable  # of contacts by law alone
    memory: ContactMemory
    rows: FloatArray  # (joint rows + 2, 2, width): joints; normal and tangential row of one contact at a time
    solved: FloatArray  # (joint rows + 2, 2, width) M^-1 rows
    row_body: IntArray  # (joint rows + 2, 2)
    bias: FloatArray  # (2, joint rows) scratch
    G: FloatArray  # (joint rows + 1, joint rows + 1)
    lower: FloatArray  # (joint rows, joint rows)
    joint: FloatArray  # (joint rows,)
    rate: FloatArray  # (capacity,) of the gaps [m/s]
    inverse: FloatArray  # (capacity, capacity) G_NN, without joints until a contact begins; each row is one number
    p: FloatArray  # (capacity, 2) normal and tangential force [N]
    sticks: IntArray  # (capacity,) 1: slips slower than the slip speed of the law
    last: FloatArray  # (capacity, 3) key, friction over normal force and sticking of the entries of the last step
    before: FloatArray  # (capacity, 2) key and friction over normal force of the entries of the last step
    missed: (
        FloatArray  # (laws, 2) impulses [N s]: by how much friction is not that of the slip; mu times the normal one
    )
    friction: FloatArray  # (ndof,) generalised forces of friction
    free: FloatArray  # (ndof,) velocities at the end of a step with the friction found so far
    push: FloatArray  # (ndof,) scratch
    states: FloatArray  # (0, 2) of friction: laws with states of their own are refused
    stored: FloatArray  # (2,) energy stored [J]; 2 / (step that bears stiffness and damping)
    found: IntArray  # (4,) touching entries; law out of its range, or -1; 1: table once too small; entries of before


def law_contacts(
    contacts: Contacts, laws: Sequence[LawRow | None], dof: IntArray, n_joint: int, n_surfaces: int
) -> LawContacts:
    """Allocate for the declared contacts with these ``laws``; None: set-valued."""
    by_law = [int(law is not None) for law in laws]
    some = any(by_law)
    none = Penalty(1.0).row()  # stands in for those that are not by law, and remembers nothing
    rows = [law or none for law in laws]
    capacity = _capacity(contacts, by_law) if some else 0
    n, ndof, width = (n_joint, int(dof[-1]), int(np.max(np.diff(dof), initial=1))) if some else (0, 0, 1)
    zeros = np.zeros
    size = max(capacity, 2)  # smaller, the array would be contiguous: another type, for which all is compiled anew
    inverse = np.lib.stride_tricks.as_strided(zeros(size), (size, size), (8, 0))
    arrays = LawContacts(
        table=contact_table(capacity, n_surfaces if some else 0, by_law, BY_LAW),
        memory=contact_memory(contacts, rows),
        rows=zeros((n + 2, 2, width)),
        solved=zeros((n + 2, 2, width)),
        row_body=np.full((n + 2, 2), -1, dtype=np.int64),
        bias=zeros((2, n)),
        G=zeros((n + 1, n + 1)),
        lower=zeros((n, n)),
        joint=zeros(n),
        rate=zeros(capacity),
        inverse=inverse,
        p=zeros((capacity, 2)),
        sticks=np.zeros(capacity, dtype=np.int64),
        last=zeros((capacity, 3)),
        before=zeros((capacity, 2)),
        missed=zeros((len(rows), 2)),
        friction=zeros(ndof),
        free=zeros(ndof),
        push=zeros(ndof),
        states=zeros((0, 2)),
        stored=zeros(2),
        found=np.array([0, -1, 0, 0]),
    )
    return pack(arrays)


def _capacity(contacts: Contacts, by_law: Sequence[int]) -> int:
    """Entries that suffice: a slave touches few features, but looks at many."""
    slaves, features = 0, 0
    for a, b, law in zip(contacts.pass_slave, contacts.pass_feature, contacts.pass_law, strict=True):
        if by_law[law]:
            slaves += int(contacts.slave_start[a + 1] - contacts.slave_start[a])
            features = max(features, int(contacts.feature_start[b + 1] - contacts.feature_start[b]))
    return 4 * slaves + features + SPARE
