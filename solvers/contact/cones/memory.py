"""The contact problem of an island in space, and the memory that compiled cone solvers work in.

Contact velocities are u = G r + free, rows in the order (n, t1, t2) of each contact in turn; contacts without friction
have three rows as well, the last two of which count for nothing.
"""

from __future__ import annotations

from typing import Any, cast

from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.jit.struct import allocate, array, struct
from lcpflex.solvers.contact.cones.mixed_problem import MixedProblem, mixed_problem
from lcpflex.solvers.contact.cones.newton import ConeWork, cone_work
from lcpflex.solvers.contact.cones.shares import Shares, shares
from lcpflex.solvers.contact.recollection import fill_slots

__all__ = [
    "COMPILED",
    "NOTHING_KNOWN",
    "OF_A_PAIR",
    "POSED",
    "SOLUTION_KNOWN",
    "SpatialContactData",
    "SpatialRemembered",
    "SpatialSolverMemory",
    "WEDGED_KNOWN",
    "cone_data",
    "cone_memory",
    "remembered_cones",
]

COMPILED, POSED = 0, 1  # methods: POSED, each problem with its Delassus operator, for solvers that are not compiled in
NOTHING_KNOWN, SOLUTION_KNOWN, WEDGED_KNOWN = 0, 1, 2  # of a problem: ``force`` is to be judged, the last by its terms
TOLERANCE = 1e-9  # of residuals, where nobody tells
OF_A_PAIR = 64  # contacts of one pair of bodies whose load can be divided in an island that is not posed, at least


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
    begun: int  # 1: the forces of the next island to be solved are those to begin from
    size: int
    residual: float  # in units of the contacts
    strict: float  # relative to the free velocity alone
    missed: float  # the largest part of its own load that is left of a contact
    behind: int  # that contact
    iterations: float
    tolerance: float  # of the residual
    load: float  # size of the free velocities
    worst: float  # absolute residual of the present point
    terms: float  # size of what cancels in its velocities
    sliding: int  # 1: some contact slips at it
    polished: int  # 1: forces were polished in the last step, and behind the solution: in this one
    # what event-driven kernels of the plane read, which no contact of space comes to yet
    normal: FloatArray = array("contacts")
    tangential: FloatArray = array("contacts")
    force: FloatArray = array("triples")
    aside: FloatArray = array("triples")  # forces to go back to
    velocity: FloatArray = array("triples")
    sums: FloatArray = array("triples")  # sum |G_ij r_j| + |free_i|
    slip: FloatArray = array("contacts")  # |u_T| / |r_T| of each contact in the last solution [m/s over N s]
    own: FloatArray = array("contacts", 6)  # block of each contact in G: nn, n1, n2, 11, 12, 22
    unit: FloatArray = array("contacts")  # d = 1 / sqrt(max G_kk) of each contact
    tangent_row: IntArray = array("contacts")  # the first of its two rows in the scene; -1: without friction
    change: FloatArray = array("ndof")  # of the velocities of bodies by the forces
    alike: FloatArray = array("rows", "rows")  # G, free velocities and forces in units of the contacts
    alike_free: FloatArray = array("rows")
    alike_force: FloatArray = array("rows")
    newton: ConeWork
    shares: Shares
    held: MixedProblem  # of an island that begins to slide, and may be held


@struct
class SpatialRemembered:
    """What is kept of all contacts of a step for the next one: their forces as world vectors."""

    now: int  # row of the last step; the other one is that of the present step
    n: int  # contacts of the last step that counts
    n_next: int  # of the present one, so far
    key: IntArray = array(2, "contacts")
    force: FloatArray = array(2, "contacts", 5)  # normal, friction (3, world axes), slip
    carried: IntArray = array(2, "contacts")  # 1: there was a force in the step before, too
    polished: IntArray = array(2, "contacts")  # 1: forces of its island were polished, and not in the step before
    place: IntArray = array("contacts")  # of each contact of the present step in the last one, -1: new
    before: FloatArray = array("contacts")  # its normal force there
    slot: IntArray = array("slots")  # 1 + place in ``key`` by the remainder of the key


def cone_data(capacity: int) -> SpatialContactData:
    """Room for the problem of so many contacts."""
    return allocate(SpatialContactData, {"contacts": capacity, "rows": 3 * capacity})


def cone_memory(
    capacity: int, before: SpatialSolverMemory | None = None, dense: int | None = None, ndof: int = 0
) -> SpatialSolverMemory:
    """Memory for problems of so many contacts; what a smaller one knows goes on.

    dense: of the largest that is posed with its Delassus operator, all if left out; ndof: velocities of the bodies.
    """
    rows = 3 * (capacity if dense is None else dense)
    sizes = {"contacts": capacity, "triples": 3 * capacity, "rows": rows, "ndof": ndof}
    pair = max(rows, 3 * min(capacity, OF_A_PAIR))
    own = {"newton": cone_work(rows // 3), "shares": shares(capacity, pair, ndof), "held": mixed_problem(pair // 3)}
    memory = allocate(SpatialSolverMemory, sizes, **own)
    memory.tolerance = TOLERANCE
    if before is not None:
        memory.method, memory.known, memory.tolerance = before.method, before.known, before.tolerance
        memory.shares.told = before.shares.told
    return memory


def remembered_cones(capacity: int, before: SpatialRemembered | None = None) -> SpatialRemembered:
    """Room for so many contacts; what a smaller one holds goes on."""
    memory: Any = allocate(SpatialRemembered, {"contacts": capacity, "slots": 2 * capacity + 1})
    if before is not None:
        memory.n, memory.now = before.n, before.now
        for name in ("key", "force", "carried", "polished"):
            getattr(memory, name)[:, : before.key.shape[1]] = getattr(before, name)
        for name in ("place", "before"):
            getattr(memory, name)[: len(before.place)] = getattr(before, name)
        fill_slots(memory)
    return cast(SpatialRemembered, memory)
