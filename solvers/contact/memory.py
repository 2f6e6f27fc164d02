"""What a contact problem is made of, and the memory that compiled solvers work in: structs that kernels share.

Contact velocities (or accelerations, or gaps) are v = G lambda + free, rows ordered [normals; tangents of the
frictional contacts]. A stepper fills :class:`ContactData` and reads forces back from :class:`SolverMemory`; how the
problem is posed in between, as an LCP of three unknowns a contact or otherwise, is the business of solvers alone.
"""

from __future__ import annotations

from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.jit.struct import allocate, array, struct
from lcpflex.solvers.auto import auto_workspace

__all__ = [
    "BASIS_KNOWN",
    "NOTHING_KNOWN",
    "SOLUTION_KNOWN",
    "WEDGED_KNOWN",
    "ContactData",
    "Remembered",
    "SolverMemory",
    "contact_data",
    "prepare",
]

NOTHING_KNOWN, BASIS_KNOWN, SOLUTION_KNOWN, WEDGED_KNOWN = 0, 1, 2, 3  # SolverMemory.known


@struct
class ContactData:
    """A contact problem; contacts: capacity, pairs: twice as many rows."""

    n_contacts: int
    n_tangents: int  # tangential rows
    on_sets: int  # 1: ``mode`` tells what each contact does; 0: Coulomb's law decides at all of them
    shifted: int  # 1: normal forces are at least ``least``; 0: at least 0
    delassus: FloatArray = array("pairs", "pairs")  # G, joints condensed
    free: FloatArray = array("pairs")  # without contact forces
    terms: FloatArray = array("pairs")  # sum |W^T| |u_free| of each row, 0 where not known; counts for one solution
    friction: FloatArray = array("contacts")  # coefficients [-]
    tangent: IntArray = array("contacts")  # the contact that each tangential row belongs to, ascending
    mode: IntArray = array("contacts")  # see lcpflex.solvers.contact.index_sets
    least: FloatArray = array("contacts")
    key: IntArray = array("contacts")  # of each contact, the same in the next problem
    pair: IntArray = array("contacts")  # the declared contact that each belongs to, for messages


@struct
class SolverMemory:
    """Solution of a contact problem, what is known of the next one, and the LCP in between; lcp: 3 x contacts."""

    method: int  # see lcpflex.solvers.contact.compiled
    known: int  # what is known of the next problem; counts once
    size: int  # unknowns of the LCP
    n_stick: int  # contacts that have a tangential unknown
    residual: float  # in units of the contacts
    strict: float  # relative to the free velocity alone
    iterations: float
    normal: FloatArray = array("contacts")  # forces of the solution
    tangential: FloatArray = array("contacts")  # of the contacts ``stick``
    stick: IntArray = array("contacts")
    tangent_of: IntArray = array("contacts")  # tangential row of each contact, -1: none
    M: FloatArray = array("lcp", "lcp")
    q: FloatArray = array("lcp")
    z: FloatArray = array("lcp")
    alike: FloatArray = array("lcp", "lcp")  # the LCP in units of its contacts
    load: FloatArray = array("lcp")
    units: FloatArray = array("lcp")  # of its unknowns
    contact_units: FloatArray = array("contacts")
    tableau: FloatArray
    basis: IntArray
    first: IntArray = array("lcp")  # of least forces: row of each unknown
    second: IntArray = array("lcp")  # row that it has a part in by sliding friction
    ratio: FloatArray = array("lcp")  # that part


@struct
class Remembered:
    """What is kept of all contacts of a step, for the next one; see :mod:`lcpflex.solvers.contact.recollection`."""

    now: int  # row of the last step; the other one is that of the present step
    n: int  # contacts of the last step that counts
    n_next: int  # of the present one, so far
    key: IntArray = array(2, "contacts")  # of the last step and of the present one, see ``now``
    basis: IntArray = array(2, "contacts", 3)  # whether their lambda_N, lambda_R, xi_L were basic
    force: FloatArray = array(2, "contacts", 2)  # lambda_N, lambda_T
    slot: IntArray = array("slots")  # 1 + place in ``key`` by the remainder of the key, or of what was in its way


def contact_data(capacity: int) -> ContactData:
    """Room for the problem of so many contacts."""
    return allocate(ContactData, {"contacts": capacity, "pairs": 2 * capacity})


def prepare(capacity: int, before: SolverMemory | None = None) -> SolverMemory:
    """Memory for problems of so many contacts; what a smaller one knows goes on."""
    tableau, basis = auto_workspace(3 * capacity)
    memory = allocate(SolverMemory, {"contacts": capacity, "lcp": 3 * capacity}, tableau=tableau, basis=basis)
    if before is not None:
        memory.method, memory.known = before.method, before.known
    return memory
