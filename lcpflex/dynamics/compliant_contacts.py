"""Compliant contacts: those whose force is a continuous law of the indentation, as against rigid, set-valued ones."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from lcpflex.contact.detection import COMPLIANT
from lcpflex.contact.table import table_maker
from lcpflex.dynamics.inertia import Arrow
from lcpflex.dynamics.joint_factor import JointPattern, joint_factor, no_joints
from lcpflex.dynamics.rows import Rows, SpatialRows
from lcpflex.force_laws.history import ContactMemory
from lcpflex.force_laws.layout import LawRow
from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.jit.struct import allocate, array, spatial, struct
from lcpflex.model.arrays import Contacts

__all__ = ["CompliantContacts", "SpatialCompliantContacts", "compliant_contacts", "sufficient_capacity"]

SPARE = 64  # entries of the table beyond those that the nodes are expected to need


@struct
class CompliantContacts:
    """Compliant contacts at the state last asked for, their rows and forces, and their history; empty where none is."""

    rows: Rows  # of compliant contacts alone
    history: ContactMemory
    rate: FloatArray = array("contacts")  # of the gaps [m/s]
    slip: FloatArray = array("tangents")  # [m/s], of contacts; in space of tangential rows
    inverse: FloatArray = array("contacts")  # G_NN where a contact begins [1/kg]
    p: FloatArray = array("contacts", "forces")  # normal and tangential force, of which there are two in space [N]
    elastic: FloatArray = array("contacts")  # part of the normal force that stores energy [N]
    sticks: IntArray = array("contacts")  # 1: slips slower than the slip speed of the law
    last: FloatArray = array("contacts", "lasting")  # key, friction over normal force, sticking in the last step
    before: FloatArray = array("contacts", "known")  # key, friction over normal force of the entries of the last step
    missed: FloatArray = array("laws", 2)  # [N s] by how much friction is not that of the slip; mu times the normal one
    friction: FloatArray = array("ndof")  # generalised forces of friction
    free: FloatArray = array("ndof")  # velocities at the end of a step with the friction found so far
    push: FloatArray = array("ndof")  # scratch
    states: FloatArray = array(0, "states")  # none of friction: a stepper that advances some has them in its own state
    stiffest: float  # 2 / (step that bears stiffness and damping) [1/s]
    out_of_range: int  # a law out of its range, or -1
    needed: int  # entries that the table lacked room for, 0 if it had it
    n_before: int  # entries of ``before``


SpatialCompliantContacts = spatial(CompliantContacts)


def compliant_contacts(
    laws: Sequence[LawRow | None],
    history: ContactMemory,
    dof: IntArray,
    pattern: JointPattern,
    surfaces: tuple[int, dict[str, Any]],
    factors: Arrow,
    dense: FloatArray,
    capacity: int,
    in_space: bool = False,
) -> CompliantContacts:
    """Allocate for ``capacity`` of the declared contacts with these ``laws``; None: rigid.

    surfaces: how many there are, and what a table has for them besides (:func:`lcpflex.contact.table.room_in_space`).
    """
    compliant = [int(law is not None) for law in laws]
    ndof, width = (int(dof[-1]), int(np.max(np.diff(dof), initial=1))) if any(compliant) else (0, 1)
    joints = joint_factor(pattern if any(compliant) else no_joints(len(dof) - 1), ndof, 0)
    n = len(joints.answer)
    each = 3 if in_space else 2  # rows of a contact
    sizes = {"joints": n, "rows": n + each * (capacity + 1) - 1, "width": width, "contacts": capacity}
    sizes |= {"reaction": 6 if in_space else 3}
    vector = 3 if in_space else 1  # numbers of a friction force that are kept from step to step: world axes
    sizes |= {"tangents": (each - 1) * capacity, "forces": each, "known": 1 + vector, "lasting": 2 + vector}
    sizes |= {"states": 4 if in_space else 2}
    n_surfaces, room = surfaces if any(compliant) else (0, {})
    table: Any = table_maker(in_space)(capacity, n_surfaces, compliant, COMPLIANT, **room)
    rows = allocate(
        SpatialRows if in_space else Rows,
        sizes | {"white": 0},
        dof=dof,
        table=table,
        arrow=factors,
        dense=dense,
        joints=joints,
        body=np.full((sizes["rows"], 2), -1, dtype=np.int64),
        n_joint=n,
        across=each - 1,
    )
    return allocate(
        SpatialCompliantContacts if in_space else CompliantContacts,
        sizes | {"laws": len(laws), "ndof": ndof},
        rows=rows,
        history=history,
        out_of_range=-1,
    )


def sufficient_capacity(contacts: Contacts, laws: Sequence[object]) -> int:
    """Entries that suffice: a node touches few features, but looks at many. 0 where no contact has a law."""
    if not any(laws):
        return 0
    nodes, features = 0, 0
    for a, b, law in zip(contacts.pass_node, contacts.pass_feature, contacts.pass_law, strict=True):
        if laws[law] is not None:
            nodes += int(contacts.node_start[a + 1] - contacts.node_start[a])
            features = max(features, int(contacts.feature_start[b + 1] - contacts.feature_start[b]))
    return 4 * nodes + features + SPARE
