"""Memory that a stepper works in: allocated once, handed from step to step, grown when contacts outnumber it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from lcpflex.contact.detection import ContactTable
from lcpflex.dynamics.inertia import Arrow, arrow
from lcpflex.dynamics.law_memory import LawContacts
from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.jit.struct import pack
from lcpflex.solvers.auto import auto_workspace

__all__ = ["DOUBTFUL_CONTACTS", "Workspace", "workspace"]

DOUBTFUL_CONTACTS = 3  # of problems that are tested for several solutions
DOUBTFUL_KEPT, DOUBTFUL_SIZE = 32, 64


class Workspace(NamedTuple):
    """Arrays for ``capacity`` contacts and R = joint rows + 2 capacity + 1 constraint rows, the last one scratch."""

    dof: IntArray  # (nb + 1,)
    external: FloatArray  # (slots, 3) values, rates, accelerations supplied by callbacks
    span: FloatArray  # (2,) [s] before and after the time asked for over which forces in time are averaged
    table: ContactTable
    arrow: Arrow
    dense: FloatArray  # (n, n) Cholesky factor of the matrix of the step, user-defined systems only
    middle: FloatArray  # (ndof,) configuration at which the step is linearised
    ahead: FloatArray  # (ndof,) configuration at which contacts are detected
    free_u: FloatArray  # (ndof,) velocity without constraint impulses
    conservative: FloatArray  # (ndof,) generalised forces by kind
    dissipative: FloatArray
    driving: FloatArray
    total: FloatArray  # (ndof,)
    rows: FloatArray  # (R, 2, width)
    solved: FloatArray  # (R, 2, width) A^-1 rows
    row_body: IntArray  # (R, 2)
    rate: FloatArray  # (R,) partial time derivatives of the joint constraints
    bias: FloatArray  # (R,)
    residual: FloatArray  # (joint rows,) phi
    G: FloatArray  # (R, R) Delassus operator
    free: FloatArray  # (R,)
    lower: FloatArray  # (joint rows, joint rows)
    share: FloatArray  # (2 capacity, joint rows)
    Gc: FloatArray  # (2 capacity, 2 capacity) condensed
    bc: FloatArray  # (2 capacity,)
    mu: FloatArray  # (capacity,)
    tangent: IntArray  # (capacity,) the contact that each tangential row belongs to
    closed: IntArray  # (capacity,)
    held_key: IntArray  # (2, capacity) keys of the contacts that stayed closed over the last step; scratch
    held_gap: FloatArray  # (2, capacity) and the gap, <= 0, that each is held at [m]
    M: FloatArray  # (3 capacity, 3 capacity) LCP
    q: FloatArray  # (3 capacity,)
    z: FloatArray  # (3 capacity,)
    terms: FloatArray  # (2 capacity,) sum |W^T| |u_free| of each contact row, 0 where not known; of one solution
    alike: FloatArray  # (3 capacity, 3 capacity) the LCP in units of its contacts: see impulse.measure
    load: FloatArray  # (3 capacity,)
    units: FloatArray  # (3 capacity,) of its unknowns
    contact_units: FloatArray  # (capacity,)
    tableau: FloatArray
    basis: IntArray
    normal: FloatArray  # (capacity,) normal part of the solution
    tangential: FloatArray  # (capacity,) one for each tangential row
    p: FloatArray  # (R,) impulses or forces of all rows
    step_size: IntArray  # (5,) joint rows, contacts, tangential rows, LCP size of this step; contacts held
    certificate: FloatArray  # (3,) residual and pivots of the present step; the residual relative to the free velocity
    stopped: FloatArray  # (1,) fastest approach so far that was stopped, being slow, and not reflected [m/s]
    last_key: IntArray  # (capacity,) keys of the contacts of the last solved problem
    last_basis: IntArray  # (capacity, 3) whether their lambda_N, lambda_R, xi_L were basic
    solving: IntArray  # (3,) method; number of last_key; what is known beforehand: see impulse.solve_lcp
    doubtful: FloatArray  # (DOUBTFUL_KEPT, ...) problems that may have several solutions, see steppers.doubtful
    doubtful_kind: IntArray  # (2,) how many; the kind of the present one
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
    width = int(np.max(np.diff(dof), initial=1))
    n_rows = n_joint + 2 * capacity + 1
    tableau, basis = auto_workspace(3 * capacity)
    zeros = np.zeros
    arrays = Workspace(
        dof=np.array(dof),
        external=zeros((n_external, 3)),
        span=zeros(2),
        table=table,
        arrow=arrow(len(dof) - 1, n_modes, shortening),
        dense=zeros((ndof, ndof) if dense else (0, 0)),
        middle=zeros(ndof),
        ahead=zeros(ndof),
        free_u=zeros(ndof),
        conservative=zeros(ndof),
        dissipative=zeros(ndof),
        driving=zeros(ndof),
        total=zeros(ndof),
        rows=zeros((n_rows, 2, width)),
        solved=zeros((n_rows, 2, width)),
        row_body=np.full((n_rows, 2), -1, dtype=np.int64),
        rate=zeros(n_rows),
        bias=zeros(n_rows),
        residual=zeros(n_joint),
        G=zeros((n_rows, n_rows)),
        free=zeros(n_rows),
        lower=zeros((n_joint, n_joint)),
        share=zeros((2 * capacity, n_joint)),
        Gc=zeros((2 * capacity, 2 * capacity)),
        bc=zeros(2 * capacity),
        mu=zeros(capacity),
        tangent=np.zeros(capacity, dtype=np.int64),
        closed=np.zeros(capacity, dtype=np.int64),
        held_key=np.zeros((2, capacity), dtype=np.int64),
        held_gap=zeros((2, capacity)),
        M=zeros((3 * capacity, 3 * capacity)),
        q=zeros(3 * capacity),
        z=zeros(3 * capacity),
        terms=zeros(2 * capacity),
        alike=zeros((3 * capacity, 3 * capacity)),
        load=zeros(3 * capacity),
        units=zeros(3 * capacity),
        contact_units=zeros(capacity),
        tableau=tableau,
        basis=basis,
        normal=zeros(capacity),
        tangential=zeros(capacity),
        p=zeros(n_rows),
        step_size=np.zeros(5, dtype=np.int64),
        certificate=zeros(3),
        stopped=zeros(1),
        last_key=np.zeros(capacity, dtype=np.int64),
        last_basis=np.zeros((capacity, 3), dtype=np.int64),
        solving=np.zeros(3, dtype=np.int64),
        doubtful=zeros((DOUBTFUL_KEPT, DOUBTFUL_SIZE)),
        doubtful_kind=np.zeros(2, dtype=np.int64),
        laws=laws,
    )
    return pack(arrays)
