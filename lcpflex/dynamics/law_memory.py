"""Memory for contacts by a continuous force law in scenes where others are set-valued."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from lcpflex.contact.detection import BY_LAW, ContactTable, contact_table
from lcpflex.force_laws.history import ContactMemory, contact_memory
from lcpflex.force_laws.layout import LawRow
from lcpflex.force_laws.penalty import Penalty
from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.jit.struct import allocate, array, struct
from lcpflex.model.arrays import Contacts

__all__ = ["LawContacts", "law_contacts"]

SPARE = 64  # entries of the table beyond those that the slaves are expected to need


@struct
class LawContacts:
    """Contacts by law at the state last looked at, and what they remember; empty where there are none."""

    table: ContactTable  # of contacts by law alone
    memory: ContactMemory
    rows: FloatArray = array("rows", 2, "width")  # : joints; normal and tangential row of one contact at a time
    solved: FloatArray = array("rows", 2, "width")  # M^-1 rows
    row_body: IntArray  # (joint rows + 2, 2)
    bias: FloatArray = array(2, "joints")  # scratch
    G: FloatArray = array("unknowns", "unknowns")
    lower: FloatArray = array("joints", "joints")
    joint: FloatArray = array("joints")
    rate: FloatArray = array("contacts")  # of the gaps [m/s]
    inverse: FloatArray  # (capacity, capacity) G_NN, without joints until a contact begins; each row is one number
    p: FloatArray = array("contacts", 2)  # normal and tangential force [N]
    sticks: IntArray = array("contacts")  # 1: slips slower than the slip speed of the law
    last: FloatArray = array("contacts", 3)  # key, friction over normal force, sticking in the last step
    before: FloatArray = array("contacts", 2)  # key and friction over normal force of the entries of the last step
    missed: FloatArray = array("laws", 2)  # [N s] by how much friction is not that of the slip; mu times the normal one
    friction: FloatArray = array("ndof")  # generalised forces of friction
    free: FloatArray = array("ndof")  # velocities at the end of a step with the friction found so far
    push: FloatArray = array("ndof")  # scratch
    states: FloatArray = array(0, 2)  # of friction: laws with states of their own are refused
    stored: float  # energy [J]
    stiffest: float  # 2 / (step that bears stiffness and damping) [1/s]
    n_touching: int
    out_of_range: int  # a law out of its range, or -1
    too_small: int  # 1 where the table was once too small
    n_before: int  # entries of ``before``


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
    size = max(capacity, 2)  # smaller, the array would be contiguous: another type, for which all is compiled anew
    sizes = {"joints": n, "rows": n + 2, "unknowns": n + 1, "width": width, "ndof": ndof, "contacts": capacity}
    return allocate(
        LawContacts,
        sizes | {"laws": len(rows)},
        table=contact_table(capacity, n_surfaces if some else 0, by_law, BY_LAW),
        memory=contact_memory(contacts, rows),
        row_body=np.full((n + 2, 2), -1, dtype=np.int64),
        inverse=np.lib.stride_tricks.as_strided(np.zeros(size), (size, size), (8, 0)),
        out_of_range=-1,
    )


def _capacity(contacts: Contacts, by_law: Sequence[int]) -> int:
    """Entries that suffice: a slave touches few features, but looks at many."""
    slaves, features = 0, 0
    for a, b, law in zip(contacts.pass_slave, contacts.pass_feature, contacts.pass_law, strict=True):
        if by_law[law]:
            slaves += int(contacts.slave_start[a + 1] - contacts.slave_start[a])
            features = max(features, int(contacts.feature_start[b + 1] - contacts.feature_start[b]))
    return 4 * slaves + features + SPARE
