"""The contact problem of an island in space, and the memory that compiled cone solvers work in.

Contact velocities are u = G r + free, rows in the order (n, t1, t2) of each contact in turn; contacts without friction
have three rows as well, the last two of which count for nothing.
"""

from __future__ import annotations

import numpy as np

from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.jit.struct import allocate, array, struct
from lcpflex.solvers.contact.best import Best
from lcpflex.solvers.contact.cones.mixed_problem import MixedProblem, mixed_problem
from lcpflex.solvers.contact.cones.shares import Shares, shares
from lcpflex.solvers.contact.group import Group
from lcpflex.solvers.contact.judging import Judged
from lcpflex.solvers.contact.operators.dense import Dense
from lcpflex.solvers.contact.operators.scene import SceneRows, scene_rows
from lcpflex.solvers.contact.proximal_newton import NewtonWork
from lcpflex.solvers.contact.recollection import enlarged
from lcpflex.solvers.contact.strategy import POSED_CONTACTS, Attempts, Search, search_parts
from lcpflex.solvers.contact.sweeping import Sweeping

__all__ = [
    "COMPILED",
    "OF_A_PAIR",
    "POSED",
    "SpatialContactData",
    "SpatialRemembered",
    "SpatialSolverMemory",
    "cone_data",
    "cone_memory",
    "remembered_cones",
]

COMPILED, POSED = 0, 1  # methods: POSED, each problem with its Delassus operator, for solvers that are not compiled in
TOLERANCE = 1e-9  # of residuals, where nobody tells
LOOK = 8  # sweeps between two judgements
CRAWLING = 0.7  # of the residual left by LOOK sweeps: too much to go on for its sake
POLISH = 40  # sweeps at most beyond the tolerance
TOUCHED = 9  # points of one side of a contact: of a facet of nine nodes
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
class Sides:
    """What both sides of contacts have of the Delassus operator, for the mechanics that make it of blocks."""

    touched: IntArray = array("contacts", 2, 2 + TOUCHED)  # body, how many points of it (0: it is rigid), and these
    share: FloatArray = array("contacts", 2, TOUCHED)  # their weights
    along: FloatArray = array("contacts", 2, 3, 3)  # directions of the rows, body axes
    frame: FloatArray = array("contacts", 2, 3, 6)  # what forces along them do to the frame


@struct
class SpatialSolverMemory:
    """Solution of a contact problem, and what is known of it."""

    method: int
    known: int  # as in the plane: forces are to be judged, those of wedged bodies by their terms
    begun: int  # 1: the forces of the next island to be solved are those to begin from
    # what is told of the last solve
    size: int
    residual: float  # in units of the contacts
    strict: float  # relative to the free velocity alone
    missed: float  # the largest part of its own load that is left of a contact
    behind: int  # that contact
    iterations: float
    # the contacts of an island
    group: Group
    scene: SceneRows  # without joints, or as if there were none
    sides: Sides
    dense: Dense  # posed
    judged: Judged
    sweeping: Sweeping
    best: Best  # of a search by Newton's method; sweeps of few contacts keep none
    newton: NewtonWork  # of posed contacts
    search: Search
    attempts: Attempts
    basis: IntArray = array("marks")  # of exchanges, where there is no friction
    # what event-driven kernels of the plane read, which no contact of space comes to yet
    normal: FloatArray = array("contacts")
    tangential: FloatArray = array("contacts")
    aside: FloatArray = array("contacts", 3)  # forces to go back to
    moved: FloatArray = array("contacts", 3)  # what forces do
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
    capacity: int,
    posed: SpatialContactData,
    scene: SceneRows | None = None,
    before: SpatialSolverMemory | None = None,
) -> SpatialSolverMemory:
    """Memory for problems of so many contacts; what a smaller one knows goes on.

    posed: room for the largest that is posed with its Delassus operator; scene: rows of all, where they are in bodies.
    """
    scene = scene_rows(capacity) if scene is None else scene
    rows, ndof = len(posed.free), len(scene.x)
    pair = max(rows, 3 * min(capacity, OF_A_PAIR))
    searched = {"units": rows // 3, "rows": 3, "block": 9, "unknowns": rows}
    memory = allocate(
        SpatialSolverMemory,
        {"contacts": capacity, "rows": rows, "marks": 3 * rows + 1},
        group=allocate(Group, {"units": capacity, "rows": 3, "block": 9}),
        scene=scene,
        sides=allocate(Sides, {"contacts": capacity}),
        dense=allocate(
            Dense,
            {"matrix": rows, "unknowns": rows},
            symmetric=1,
            columns=posed.delassus,
            free=posed.free,
            row=np.arange(rows, dtype=np.int64).reshape(-1, 3),
        ),
        sweeping=allocate(Sweeping, {}, look=LOOK, crawling=CRAWLING, polish=POLISH),
        **search_parts(searched, POSED_CONTACTS),
        shares=shares(capacity, pair, ndof),
        held=mixed_problem(pair // 3),
    )
    memory.judged.tolerance = TOLERANCE
    if before is not None:
        memory.method, memory.known = before.method, before.known
        memory.judged.tolerance = before.judged.tolerance
        memory.shares.told = before.shares.told
    return memory


def remembered_cones(capacity: int, before: SpatialRemembered | None = None) -> SpatialRemembered:
    """Room for so many contacts; what a smaller one holds goes on."""
    return enlarged(SpatialRemembered, capacity, before)
