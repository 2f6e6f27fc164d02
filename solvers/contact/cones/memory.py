"""The contact problem of an island in space, and the memory that compiled cone solvers work in.

Contact velocities are u = G r + free, rows in the order (n, t1, t2) of each contact in turn; contacts without friction
have three rows as well, the last two of which count for nothing.
"""

from __future__ import annotations

from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.jit.struct import allocate, array, struct

__all__ = [
    "SpatialContactData",
    "SpatialRemembered",
    "SpatialSolverMemory",
    "cone_data",
    "cone_memory",
    "remembered_cones",
]


@struct
class SpatialContactData:
    """A contact problem; contacts: capacity, rows: three times as many."""

    n_contacts: int
    n_tangents: int
    on_sets: int
    shifted: int
    delassus: FloatArray = array("rows", "rows")  # G, joints condensed
    free: FloatArray = array("rows")  # without contact forces
    terms: FloatArray = array("rows")  # sum |W^T| |u_free| of each row
    friction: FloatArray = array("contacts")  # coefficients [-]
    tangent: IntArray = array("contacts")
    mode: IntArray = array("contacts")
    least: FloatArray = array("contacts")
    key: IntArray = array("contacts")
    pair: IntArray = array("contacts")  # the declared contact that each belongs to, for messages


@struct
class SpatialSolverMemory:
    """Solution of a contact problem, and what is known of it."""

    method: int
    known: int
    size: int
    residual: float  # in units of the contacts
    strict: float  # relative to the free velocity alone
    iterations: float
    normal: FloatArray = array("contacts")
    tangential: FloatArray = array("contacts")
    force: FloatArray = array("rows")
    slip: FloatArray = array("contacts")  # |u_T| / |r_T| of each contact in the last solution [m/s over N s]


@struct
class SpatialRemembered:
    """What is kept of all contacts of a step for the next one: their forces as world vectors."""

    now: int  # row of the last step; the other one is that of the present step
    n: int  # contacts of the last step that counts
    n_next: int  # of the present one, so far
    key: IntArray = array(2, "contacts")
    force: FloatArray = array(2, "contacts", 5)  # normal, friction (3, world axes), slip
    slot: IntArray = array("slots")  # 1 + place in ``key`` by the remainder of the key


def cone_data(capacity: int) -> SpatialContactData:
    """Room for the problem of so many contacts."""
    return allocate(SpatialContactData, {"contacts": capacity, "rows": 3 * capacity})


def cone_memory(capacity: int, before: SpatialSolverMemory | None = None) -> SpatialSolverMemory:
    """Memory for problems of so many contacts; what a smaller one knows goes on."""
    memory = allocate(SpatialSolverMemory, {"contacts": capacity, "rows": 3 * capacity})
    if before is not None:
        memory.method, memory.known = before.method, before.known
    return memory


def remembered_cones(capacity: int, before: SpatialRemembered | None = None) -> SpatialRemembered:
    """Room for so many contacts; what a smaller one holds goes on."""
    memory = allocate(SpatialRemembered, {"contacts": capacity, "slots": 2 * capacity + 1})
    if before is not None:
        memory.n, memory.now = before.n, before.now
        for name in ("key", "force"):
            getattr(memory, name)[:, : before.key.shape[1]] = getattr(before, name)
    return memory
