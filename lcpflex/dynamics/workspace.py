"""Memory that a stepper works in: allocated once, handed from step to step, grown when contacts outnumber it."""

from __future__ import annotations

from typing import Any, cast

import numpy as np

from lcpflex.contact.detection import ContactTable
from lcpflex.dynamics.compliant_contacts import CompliantContacts
from lcpflex.dynamics.islands import islands
from lcpflex.dynamics.joint_factor import JointPattern, joint_factor
from lcpflex.dynamics.owners import FreeMotion, Impulses, Posed, Scratch
from lcpflex.dynamics.rows import Rows, SpatialRows
from lcpflex.jit.struct import allocate, spatial, struct
from lcpflex.solvers.contact.large.memory import BodyContacts, LargeMemory, grown, large_memory
from lcpflex.solvers.contact.memory import ContactData, contact_data, prepare
from lcpflex.solvers.contact.recollection import remembered

__all__ = ["DENSE", "DOUBTFUL_CONTACTS", "SpatialWorkspace", "Workspace", "workspace"]

NO_LIMIT = 2**40
DENSE = 20  # contacts of the largest island that is solved densely where another way is known
DOUBTFUL_CONTACTS = 3  # of problems that are tested for several solutions


@struct
class Workspace:
    """Memory for a number of contacts, by owner: who may write what is said in :mod:`lcpflex.dynamics.owners`.

    Dimensions are contacts; tangents: one of each, two in space; pairs: contacts and tangents; rows = joint rows +
    pairs + constraint rows of scratch at the end, one for each tangent of a contact. dense: as pairs, of the largest
    problem.
    """

    rows: Rows
    free: FreeMotion
    posed: Posed
    impulses: Impulses
    scratch: Scratch
    compliant: CompliantContacts  # beside the rigid contacts, in a table of their own


SpatialWorkspace = spatial(Workspace)


def workspace(
    n_external: int,
    nq: int,
    pattern: JointPattern,
    table: ContactTable,
    compliant: CompliantContacts,
    dense: int,
    before: Workspace | None = None,
) -> Workspace:
    """Allocate for as many contacts as ``table``, beside the compliant ones, with their offsets and factors.

    ``nq``: numbers of a configuration.
    ``dense``: contacts that one problem may have. ``before``: a smaller one; what its solver knows goes on.
    """
    capacity = len(table.key)
    dof = compliant.rows.dof
    ndof = int(dof[-1])
    in_space = not isinstance(table, ContactTable)
    each = 3 if in_space else 2  # rows of a contact
    joints = joint_factor(pattern, ndof, each * capacity)
    n_joint = len(joints.answer)
    sizes = {
        "slots": n_external,
        "nq": nq,
        "ndof": ndof,
        "rows": n_joint + each * (capacity + 1) - 1,
        "width": int(np.max(np.diff(dof), initial=1)),
        "joints": n_joint,
        "reaction": 6 if in_space else 3,
        "contacts": capacity,
        "tangents": (each - 1) * capacity,
        "pairs": each * capacity,
        "dense": each * dense,
        "bodies": len(dof) - 1,
    }
    most = 0 if before is None else max(before.impulses.largest, capacity // 2)  # room is twice what is needed
    large = before is not None and most > before.impulses.dense_limit
    sizes["white"] = sizes["rows"] if large else 0
    rows = allocate(
        SpatialRows if in_space else Rows,
        sizes,
        dof=dof,
        table=table,
        arrow=compliant.rows.arrow,
        dense=compliant.rows.dense,
        joints=joints,
        body=np.full((sizes["rows"], 2), -1, dtype=np.int64),
        across=each - 1,
    )
    free, problem = allocate(FreeMotion, sizes), _problem(dense, in_space)
    impulses = _impulses(sizes, rows, problem, in_space, before.impulses if before else None)
    return allocate(
        SpatialWorkspace if in_space else Workspace,
        sizes,
        rows=rows,
        free=free,
        posed=allocate(
            Posed,
            sizes,
            islands=islands(len(dof) - 1, capacity, n_joint),
            problem=problem,
            large=_large(sizes, rows, free, impulses),
        ),
        impulses=impulses,
        scratch=allocate(Scratch, sizes),
        compliant=compliant,
    )


def _problem(dense: int, in_space: bool) -> ContactData:
    """Room for a problem of so many contacts."""
    if not in_space:
        return contact_data(dense)
    from lcpflex.solvers.contact.cones.memory import cone_data

    own: Any = cone_data(dense)
    return cast(ContactData, own)


def _impulses(
    sizes: dict[str, int], rows: Rows, problem: ContactData, in_space: bool, before: Impulses | None
) -> Impulses:
    """Impulses of as many rows, and solvers; what those ``before`` know and want goes on."""
    capacity = sizes["contacts"]
    known: Any = before.solver if before else None
    recalled: Any = before.remembered if before else None
    solving: dict[str, Any]
    if in_space:
        from lcpflex.solvers.contact.cones.memory import cone_memory, remembered_cones
        from lcpflex.solvers.contact.operators.scene import scene_rows

        posed: Any = problem
        scene = scene_rows(capacity, rows=rows.J, solved=rows.solved, row_body=rows.body, dof=rows.dof)
        solving = {"solver": cone_memory(capacity, posed, scene, known)}
        solving |= {"remembered": remembered_cones(capacity, recalled)}
    else:
        dense = sizes["dense"] // 2
        solving = {"solver": prepare(dense, known), "remembered": remembered(capacity, recalled)}
    return allocate(
        Impulses,
        sizes,
        large_solver=_large_solver(sizes, before, 3 if in_space else 2),
        dense_limit=before.dense_limit if before else NO_LIMIT,
        strict_large=before.strict_large if before else 0,
        most=before.most if before else 0,
        largest=before.largest if before else 0,
        **solving,
    )


def _large(sizes: dict[str, int], rows: Rows, free: FreeMotion, impulses: Impulses) -> BodyContacts:
    """The problem of a large island, over the rows of the workspace."""
    room = 1 if sizes["white"] else 0
    own = {name: room * sizes[name] for name in ("contacts", "joints", "bodies")}
    group = getattr(impulses.solver, "group", None)  # in space
    return allocate(
        BodyContacts,
        own,
        dof=rows.dof,
        white=rows.white,
        row_body=rows.body,
        free=free.v,
        terms=free.terms,
        p=impulses.p,
        first_contact=sizes["joints"],
        slip=np.zeros(0) if group is None else group.slip,
    )


def _large_solver(sizes: dict[str, int], before: Impulses | None, rows: int) -> LargeMemory:
    """Its memory; what one before it knows and wants goes on."""
    room = 1 if sizes["white"] else 0
    units, bodies = room * (sizes["contacts"] + sizes["joints"]), room * sizes["bodies"]
    if before is None:
        return large_memory(sizes["bodies"], units, bodies, sizes["width"], rows)
    return grown(before.large_solver, {"units": units, "bodies": bodies})
