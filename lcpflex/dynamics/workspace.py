"""Memory that a stepper works in: allocated once, handed from step to step, grown when contacts outnumber it."""

from __future__ import annotations

import numpy as np

from lcpflex.contact.detection import ContactTable
from lcpflex.dynamics.compliant_contacts import CompliantContacts
from lcpflex.dynamics.inertia import Arrow
from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.jit.struct import allocate, array, struct
from lcpflex.solvers.contact.memory import ContactData, SolverMemory, contact_data, prepare

__all__ = ["DOUBTFUL_CONTACTS", "Rows", "Workspace", "workspace"]

DOUBTFUL_CONTACTS = 3  # of problems that are tested for several solutions
DOUBTFUL_KEPT, DOUBTFUL_SIZE = 32, 64


@struct
class Workspace:
    """Memory for a number of contacts; pairs: twice as many.

    rows = joint rows + pairs + 1 constraint rows, the last one scratch.
    """

    dof: IntArray  # (nb + 1,)
    external: FloatArray = array("slots", 3)  # values, rates, accelerations supplied by callbacks
    span: FloatArray = array(2)  # [s] before and after the time asked for over which forces in time are averaged
    table: ContactTable
    arrow: Arrow
    dense: FloatArray  # Cholesky factor of the matrix of a step; user-defined systems only
    middle: FloatArray = array("ndof")  # configuration at which the step is linearised
    ahead: FloatArray = array("ndof")  # configuration at which contacts are detected
    free_u: FloatArray = array("ndof")  # velocity without constraint impulses
    conservative: FloatArray = array("ndof")  # generalised forces by kind
    dissipative: FloatArray = array("ndof")
    driving: FloatArray = array("ndof")
    total: FloatArray = array("ndof")
    rows: FloatArray = array("rows", 2, "width")
    solved: FloatArray = array("rows", 2, "width")  # A^-1 rows
    row_body: IntArray  # (R, 2)
    rate: FloatArray = array("rows")  # partial time derivatives of the joint constraints
    bias: FloatArray = array("rows")
    residual: FloatArray = array("joints")  # phi
    G: FloatArray = array("rows", "rows")  # Delassus operator
    free: FloatArray = array("rows")
    lower: FloatArray = array("joints", "joints")
    share: FloatArray = array("pairs", "joints")
    mu: FloatArray = array("contacts")
    tangent: IntArray = array("contacts")  # the contact that each tangential row belongs to
    closed: IntArray = array("contacts")
    held_key: IntArray = array(2, "contacts")  # of the contacts that stayed closed over the last step; scratch
    held_gap: FloatArray = array(2, "contacts")  # and the gap, <= 0, that each is held at [m]
    drift: FloatArray = array("contacts")  # of closed contacts, from the gap that each is held at [m]; scratch
    problem: ContactData  # the contact problem of the rows
    solver: SolverMemory
    normal: FloatArray = array("contacts")  # forces where contacts give way [N]
    tangential: FloatArray = array("contacts")  # one for each tangential row
    p: FloatArray = array("rows")  # impulses or forces of all rows
    n_joint: int  # joint rows of this step
    n_contacts: int
    n_tangents: int  # tangential rows
    n_held: int  # contacts that stayed closed over the last step
    stopped: float  # fastest approach so far that was stopped, being slow, and not reflected [m/s]
    doubtful: FloatArray = array(DOUBTFUL_KEPT, DOUBTFUL_SIZE)  # problems that may have several solutions
    n_doubtful: int
    doubtful_kind: int  # of the present problem
    compliant: CompliantContacts  # beside the rigid contacts, in a table of their own


Rows = Workspace | CompliantContacts  # both hold a table, rows and factors, by the same names


def workspace(
    n_external: int,
    n_joint: int,
    table: ContactTable,
    compliant: CompliantContacts,
    solver: SolverMemory | None = None,
) -> Workspace:
    """Allocate for as many contacts as ``table``, beside the compliant ones, with their offsets and factors.

    ``solver``: of a smaller one, what it knows goes on.
    """
    capacity = len(table.key)
    dof = compliant.dof
    ndof = int(dof[-1])
    sizes = {
        "slots": n_external,
        "ndof": ndof,
        "rows": n_joint + 2 * capacity + 1,
        "width": int(np.max(np.diff(dof), initial=1)),
        "joints": n_joint,
        "contacts": capacity,
        "pairs": 2 * capacity,
    }
    return allocate(
        Workspace,
        sizes,
        dof=dof,
        table=table,
        arrow=compliant.arrow,
        dense=compliant.dense,
        row_body=np.full((sizes["rows"], 2), -1, dtype=np.int64),
        problem=contact_data(capacity),
        solver=prepare(capacity, solver),
        compliant=compliant,
    )
