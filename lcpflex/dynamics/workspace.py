"""Memory that a stepper works in: allocated once, handed from step to step, grown when contacts outnumber it."""

from __future__ import annotations

from typing import Any

import numpy as np

from lcpflex.contact.detection import ContactTable
from lcpflex.dynamics.compliant_contacts import CompliantContacts
from lcpflex.dynamics.inertia import Arrow
from lcpflex.dynamics.islands import Islands, islands
from lcpflex.dynamics.joint_factor import JointFactor, JointPattern, joint_factor
from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.jit.struct import allocate, array, spatial, struct
from lcpflex.solvers.contact.large.memory import BodyContacts, LargeMemory, grown, large_memory
from lcpflex.solvers.contact.memory import ContactData, Remembered, SolverMemory, contact_data, prepare
from lcpflex.solvers.contact.recollection import remembered

__all__ = ["DENSE", "DOUBTFUL_CONTACTS", "Rows", "SpatialWorkspace", "Workspace", "workspace"]

NO_LIMIT = 2**40
DENSE = 20  # contacts of the largest island that is solved densely where another way is known
DOUBTFUL_CONTACTS = 3  # of problems that are tested for several solutions
DOUBTFUL_KEPT, DOUBTFUL_SIZE = 32, 64
DOUBTFUL_KINDS = 16


@struct
class Workspace:
    """Memory for a number of contacts; tangents: one of each, two in space; pairs: contacts and tangents.

    rows = joint rows + pairs + constraint rows of scratch at the end, one for each tangent of a contact. dense: as
    pairs, of the largest problem.
    """

    dof: IntArray  # (nb + 1,)
    external: FloatArray = array("slots", 3)  # values, rates, accelerations supplied by callbacks
    span: FloatArray = array(2)  # [s] before and after the time asked for over which forces in time are averaged
    table: ContactTable
    arrow: Arrow
    dense: FloatArray  # Cholesky factor of the matrix of a step; user-defined systems only
    middle: FloatArray = array("nq")  # configuration at which the step is linearised
    ahead: FloatArray = array("nq")  # configuration at which contacts are detected
    free_u: FloatArray = array("ndof")  # velocity without constraint impulses
    conservative: FloatArray = array("ndof")  # generalised forces by kind
    dissipative: FloatArray = array("ndof")
    driving: FloatArray = array("ndof")
    total: FloatArray = array("ndof")
    rows: FloatArray = array("rows", 2, "width")
    solved: FloatArray = array("rows", 2, "width")  # A^-1 rows
    white: FloatArray = array("white", 2, "width")  # L^-1 rows, A = L L^T; where there may be large islands
    row_body: IntArray  # (R, 2)
    wrench: FloatArray = array("joints", "reaction")  # of a multiplier 1 of each joint row: force, moment on P's body
    rate: FloatArray = array("rows")  # partial time derivatives of the joint constraints
    bias: FloatArray = array("rows")
    residual: FloatArray = array("joints")  # phi
    joints: JointFactor
    islands: Islands
    part: IntArray = array("dense")  # contact rows of the present problem
    G: FloatArray = array("dense", "dense")  # of contact rows; scratch
    free: FloatArray = array("rows")
    terms: FloatArray = array("pairs")  # of each contact row, see ContactData
    mu: FloatArray = array("contacts")
    tangent: IntArray = array("tangents")  # the contact that each tangential row belongs to
    tangent_of: IntArray = array("contacts")  # tangential row of each contact, the first one in space; -1: none
    mode: IntArray = array("contacts")  # where ``on_sets`` counts; see lcpflex.solvers.contact.index_sets
    least: FloatArray = array("contacts")  # normal forces, where ``shifted`` counts
    counted: FloatArray = array("contacts")  # normal forces that ``free`` holds already, where ``lifted`` counts
    own: FloatArray = array("contacts")  # G_NN of each contact, of its island
    effect: FloatArray = array("contacts")  # its normal velocity (or acceleration, ...) without contact forces
    sunk: FloatArray = array("contacts")  # drift of each contact to be taken out, 0: none
    closed: IntArray = array("contacts")
    held_key: IntArray = array(2, "contacts")  # of the contacts that stayed closed over the last step; scratch
    held_gap: FloatArray = array(2, "contacts")  # and the gap, <= 0, that each is held at [m]
    drift: FloatArray = array("contacts")  # of closed contacts, from the gap that each is held at [m]; scratch
    problem: ContactData  # that of an island
    solver: SolverMemory
    remembered: Remembered
    large: BodyContacts  # the problem of an island that is not solved densely; its arrays are those of all rows
    large_solver: LargeMemory
    dense_limit: int  # contacts of the largest island that is solved densely at once
    strict_large: int  # 1: a large island that is not solved is an error
    unsolved_large: int  # 1: it was an error
    wants_start: int  # 1: a large island that nothing is remembered of was not solved: its start is to be sought
    has_start: int  # 1: the present large island begins from ``p`` as it is
    unsolved: int  # large islands of the present step that were not solved to the tolerance
    aside: FloatArray = array("white", 3)  # impulses, right-hand sides and their terms kept while others are sought
    marked: IntArray = array("bodies")  # of the present large island
    normal: FloatArray = array("contacts")  # forces where contacts give way [N]
    tangential: FloatArray = array("tangents")
    p: FloatArray = array("rows")  # impulses or forces of all rows
    recalled: FloatArray = array("joints")  # impulses of joint rows in the step before
    n_joint: int  # joint rows of this step
    n_contacts: int
    n_tangents: int  # tangential rows
    on_sets: int  # of the problems to be posed, see ContactData
    shifted: int
    lifted: int
    number: int  # why the last problem was not solved
    most: int  # contacts of the largest island so far that is solved densely
    largest: int  # and of all
    n_held: int  # contacts that stayed closed over the last step
    stopped: float  # fastest approach so far that was stopped, being slow, and not reflected [m/s]
    doubtful: FloatArray = array(DOUBTFUL_KEPT, DOUBTFUL_SIZE)  # problems that may have several solutions
    n_doubtful: int
    doubtful_kind: IntArray = array(DOUBTFUL_KINDS)  # of the last problem with a first contact of such a key
    compliant: CompliantContacts  # beside the rigid contacts, in a table of their own


SpatialWorkspace = spatial(Workspace)
Rows = Workspace | CompliantContacts  # both hold a table, rows and factors, by the same names


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
    dof = compliant.dof
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
    most = 0 if before is None else max(before.largest, capacity // 2)  # room is twice what is needed
    large = before is not None and most > before.dense_limit
    sizes["white"] = sizes["rows"] if large else 0
    laid = {
        "rows": np.zeros((sizes["rows"], 2, sizes["width"])),
        "solved": np.zeros((sizes["rows"], 2, sizes["width"])),
    }
    shared: dict[str, Any] = {
        "white": np.zeros((sizes["white"], 2, sizes["width"])),
        "row_body": np.full((sizes["rows"], 2), -1, dtype=np.int64),
        "free": np.zeros(sizes["rows"]),
        "p": np.zeros(sizes["rows"]),
        "terms": np.zeros(sizes["pairs"]),
    }
    known: Any = before.solver if before else None
    recalled: Any = before.remembered if before else None
    solving: dict[str, Any]
    if in_space:
        from lcpflex.solvers.contact.cones.memory import cone_data, cone_memory, remembered_cones
        from lcpflex.solvers.contact.operators.scene import scene_rows

        posed = cone_data(dense)
        scene = scene_rows(capacity, row_body=shared["row_body"], dof=dof, **laid)
        cones = {"problem": posed, "solver": cone_memory(capacity, posed, scene, known)}
        solving = {**cones, "remembered": remembered_cones(capacity, recalled)}
    else:
        pairs = {"problem": contact_data(dense), "solver": prepare(dense, known)}
        solving = {**pairs, "remembered": remembered(capacity, recalled)}
    return allocate(
        SpatialWorkspace if in_space else Workspace,
        sizes,
        dof=dof,
        table=table,
        arrow=compliant.arrow,
        dense=compliant.dense,
        joints=joints,
        islands=islands(len(dof) - 1, capacity, n_joint),
        large=_large(sizes, solving["solver"].group.slip if in_space else np.zeros(0), dof=dof, **shared),
        large_solver=_large_solver(sizes, before, each),
        dense_limit=before.dense_limit if before else NO_LIMIT,
        strict_large=before.strict_large if before else 0,
        most=before.most if before else 0,
        largest=before.largest if before else 0,
        compliant=compliant,
        **solving,
        **laid,
        **shared,
    )


def _large(sizes: dict[str, int], slip: FloatArray, **shared: Any) -> BodyContacts:
    """The problem of a large island, over the rows of the workspace."""
    room = 1 if sizes["white"] else 0
    own = {name: room * sizes[name] for name in ("contacts", "joints", "bodies")}
    return allocate(BodyContacts, own, first_contact=sizes["joints"], slip=slip, **shared)


def _large_solver(sizes: dict[str, int], before: Workspace | None, rows: int) -> LargeMemory:
    """Its memory; what one before it knows and wants goes on."""
    room = 1 if sizes["white"] else 0
    units, bodies = room * (sizes["contacts"] + sizes["joints"]), room * sizes["bodies"]
    if before is None:
        return large_memory(sizes["bodies"], units, bodies, sizes["width"], rows)
    return grown(before.large_solver, {"units": units, "bodies": bodies})
