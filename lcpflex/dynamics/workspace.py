"""Memory that a stepper works in: allocated once, handed from step to step, grown when contacts outnumber it."""

from __future__ import annotations

import numpy as np

from lcpflex.contact.detection import ContactTable
from lcpflex.dynamics.inertia import Arrow, arrow
from lcpflex.dynamics.law_memory import LawContacts
from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.jit.struct import allocate, array, struct
from lcpflex.solvers.auto import auto_workspace

__all__ = ["DOUBTFUL_CONTACTS", "Workspace", "workspace"]

DOUBTFUL_CONTACTS = 3  # of problems that are tested for several solutions
DOUBTFUL_KEPT, DOUBTFUL_SIZE = 32, 64


@struct
class Workspace:
    """Memory for a number of contacts; pairs: twice, lcp: three times as many.

    rows = joint rows + pairs + 1 constraint rows, the last one scratch.
    """

    dof: IntArray  # (nb + 1,)
    external: FloatArray = array("slots", 3)  # values, rates, accelerations supplied by callbacks
    span: FloatArray = array(2)  # [s] before and after the time asked for over which forces in time are averaged
    table: ContactTable
    arrow: Arrow
    dense: FloatArray = array("dense", "dense")  # Cholesky factor of the matrix of a step; user-defined systems only
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
    Gc: FloatArray = array("pairs", "pairs")  # condensed
    bc: FloatArray = array("pairs")
    mu: FloatArray = array("contacts")
    tangent: IntArray = array("contacts")  # the contact that each tangential row belongs to
    closed: IntArray = array("contacts")
    held_key: IntArray = array(2, "contacts")  # of the contacts that stayed closed over the last step; scratch
    held_gap: FloatArray = array(2, "contacts")  # and the gap, <= 0, that each is held at [m]
    M: FloatArray = array("lcp", "lcp")  # LCP
    q: FloatArray = array("lcp")
    z: FloatArray = array("lcp")
    terms: FloatArray = array("pairs")  # sum |W^T| |u_free| of each row, 0 where not known; of one solution
    alike: FloatArray = array("lcp", "lcp")  # the LCP in units of its contacts: see impulse.measure
    load: FloatArray = array("lcp")
    units: FloatArray = array("lcp")  # of its unknowns
    contact_units: FloatArray = array("contacts")
    tableau: FloatArray
    basis: IntArray
    normal: FloatArray = array("contacts")  # normal part of the solution
    tangential: FloatArray = array("contacts")  # one for each tangential row
    p: FloatArray = array("rows")  # impulses or forces of all rows
    n_joint: int  # joint rows of this step
    n_contacts: int
    n_tangents: int  # tangential rows
    lcp_size: int
    n_held: int  # contacts that stayed closed over the last step
    certified: float  # residual of the present step, in units of its contacts
    pivots: float
    relative_residual: float  # relative to the free velocity alone
    stopped: float  # fastest approach so far that was stopped, being slow, and not reflected [m/s]
    last_key: IntArray = array("contacts")  # keys of the contacts of the last solved problem
    last_basis: IntArray = array("contacts", 3)  # whether their lambda_N, lambda_R, xi_L were basic
    method: int  # LEMKE or AUTO
    n_remembered: int  # entries of last_key
    known: int  # what is known beforehand: see impulse.solve_lcp
    doubtful: FloatArray = array(DOUBTFUL_KEPT, DOUBTFUL_SIZE)  # problems that may have several solutions
    n_doubtful: int
    doubtful_kind: int  # of the present problem
    laws: LawContacts  # contacts by a continuous force law beside the others, in a table of their own


def workspace(
    dof: IntArray,
    n_external: int,
    n_joint: int,
    n_modes: int,
    table: ContactTable,
    laws: LawContacts,
    dense: bool = False,
    shortening: IntArray | None = None,
) -> Workspace:
    """Allocate for bodies with offsets ``dof`` and as many contacts as ``table``, beside those by law.

    ``shortening`` (nb,): modes of each body that gets shorter as it bends, 0 of others.
    """
    capacity = len(table.key)
    ndof = int(dof[-1])
    sizes = {
        "slots": n_external,
        "dense": ndof if dense else 0,
        "ndof": ndof,
        "rows": n_joint + 2 * capacity + 1,
        "width": int(np.max(np.diff(dof), initial=1)),
        "joints": n_joint,
        "contacts": capacity,
        "pairs": 2 * capacity,
        "lcp": 3 * capacity,
    }
    tableau, basis = auto_workspace(3 * capacity)
    return allocate(
        Workspace,
        sizes,
        dof=np.array(dof),
        table=table,
        arrow=arrow(len(dof) - 1, n_modes, shortening),
        row_body=np.full((sizes["rows"], 2), -1, dtype=np.int64),
        tableau=tableau,
        basis=basis,
        laws=laws,
    )
