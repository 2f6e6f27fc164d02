"""What a stepper works with beside the rows, and who may write to it: :data:`WRITERS` names all of them.

``Rows`` are written by the mechanics, which lays them and factorises the matrix of a step; their table by the detection
of contacts, and by steppers where these leave some out. ``FreeMotion`` is written by the mechanics and by the schemes,
which lead a motion without constraint impulses each in its own way. ``Posed`` is written by those who pose problems;
solvers leave their answers in it, and steppers how far they have come. ``Impulses`` are written by those who solve, and
by the steppers that carry from step to step what solvers know. ``Scratch`` is for whoever deals with one problem.
"""

from __future__ import annotations

from lcpflex.dynamics.islands import Islands
from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.jit.struct import array, struct
from lcpflex.solvers.contact.large.memory import BodyContacts, LargeMemory
from lcpflex.solvers.contact.memory import ContactData, Remembered, SolverMemory

__all__ = ["WRITERS", "FreeMotion", "Impulses", "Posed", "Scratch"]

DOUBTFUL_KEPT, DOUBTFUL_SIZE = 32, 64
DOUBTFUL_KINDS = 16


@struct
class FreeMotion:
    """The motion without constraint impulses: forces by kind, velocities, and what rows would see of them."""

    external: FloatArray = array("slots", 3)  # values, rates, accelerations supplied by callbacks
    span: FloatArray = array(2)  # [s] before and after the time asked for over which forces in time are averaged
    middle: FloatArray = array("nq")  # configuration at which the step is linearised
    ahead: FloatArray = array("nq")  # configuration at which contacts are detected
    conservative: FloatArray = array("ndof")  # generalised forces by kind
    dissipative: FloatArray = array("ndof")
    driving: FloatArray = array("ndof")
    total: FloatArray = array("ndof")
    u: FloatArray = array("ndof")  # velocity (or acceleration, ...)
    v: FloatArray = array("rows")  # velocities (or accelerations, gaps, ...) of all rows, restitution and bias included
    terms: FloatArray = array("pairs")  # sum |J| |u| of each contact row, see ContactData


@struct
class Posed:
    """The contact problems of the rows: the islands they fall into, and the law that each contact obeys in its own."""

    islands: Islands
    part: IntArray = array("dense")  # contact rows of the present problem
    tangent_of: IntArray = array("contacts")  # tangential row of each contact, the first one in space; -1: none
    mode: IntArray = array("contacts")  # where ``on_sets`` counts; see lcpflex.solvers.contact.index_sets
    least: FloatArray = array("contacts")  # normal forces, where ``shifted`` counts
    counted: FloatArray = array("contacts")  # normal forces that ``free.v`` holds already, where ``lifted`` counts
    own: FloatArray = array("contacts")  # G_NN of each contact, of its island
    effect: FloatArray = array("contacts")  # its normal velocity (or acceleration, ...) without contact forces
    problem: ContactData  # that of an island
    large: BodyContacts  # the problem of an island that is not solved densely; its arrays are those of all rows
    on_sets: int  # of the problems to be posed, see ContactData
    shifted: int
    lifted: int


@struct
class Impulses:
    """The impulses found, the solvers that find them, and what both leave for the steps to come."""

    p: FloatArray = array("rows")  # impulses or forces of all rows
    recalled: FloatArray = array("joints")  # impulses of joint rows in the step before
    normal: FloatArray = array("contacts")  # forces where contacts give way [N]
    tangential: FloatArray = array("tangents")
    solver: SolverMemory
    large_solver: LargeMemory
    remembered: Remembered
    dense_limit: int  # contacts of the largest island that is solved densely at once
    strict_large: int  # 1: a large island that is not solved is an error
    unsolved_large: int  # 1: it was an error
    wants_start: int  # 1: a large island that nothing is remembered of was not solved: its start is to be sought
    has_start: int  # 1: the present large island begins from ``p`` as it is
    unsolved: int  # large islands of the present step that were not solved to the tolerance
    number: int  # why the last problem was not solved
    most: int  # contacts of the largest island so far that is solved densely
    largest: int  # and of all
    stopped: float  # fastest approach so far that was stopped, being slow, and not reflected [m/s]
    held_key: IntArray = array(2, "contacts")  # of the contacts that stayed closed over the last step; scratch
    held_gap: FloatArray = array(2, "contacts")  # and the gap, <= 0, that each is held at [m]
    n_held: int  # contacts that stayed closed over the last step
    doubtful: FloatArray = array(DOUBTFUL_KEPT, DOUBTFUL_SIZE)  # problems that may have several solutions
    n_doubtful: int
    doubtful_kind: IntArray = array(DOUBTFUL_KINDS)  # of the last problem with a first contact of such a key


@struct
class Scratch:
    """Arrays whose content counts only while one contact problem, or one correction of positions, is dealt with."""

    G: FloatArray = array("dense", "dense")  # of contact rows
    residual: FloatArray = array("joints")  # phi
    multipliers: FloatArray = array("rows")
    velocity: FloatArray = array("ndof")  # or a momentum
    sunk: FloatArray = array("contacts")  # drift of each contact to be taken out, 0: none
    closed: IntArray = array("contacts")
    drift: FloatArray = array("contacts")  # of closed contacts, from the gap that each is held at [m]
    aside: FloatArray = array("white", 3)  # impulses, right-hand sides and their terms kept while others are sought
    marked: IntArray = array("bodies")  # of the present large island


# Who may write to all fields of an owner, and who besides to one: modules, or packages with all in them. A function
# that is handed a whole owner stands in one of them; where a field is handed over, either side may be the writer. The
# sources are tested against this.
WRITERS: dict[str, tuple[str, ...]] = {
    "Rows": (
        "lcpflex.dynamics.contact_forces",
        "lcpflex.dynamics.mechanics",
        "lcpflex.dynamics.spatial.contact_forces",
        "lcpflex.dynamics.spatial.mechanics",
        "lcpflex.dynamics.user_cones",
        "lcpflex.dynamics.user_mechanics",
        "lcpflex.statics.stiffness_columns",  # rows of contacts of one body, at places beside the one looked at
    ),
    "Rows.table": (
        "lcpflex.contact",
        "lcpflex.dynamics.acceleration",
        "lcpflex.dynamics.contact_forces_history",
        "lcpflex.steppers",  # which of the contacts found count is theirs to say
    ),
    "Rows.joints": (  # the factor of their matrix, and what they answer
        "lcpflex.dynamics.contact_forces_friction",
        "lcpflex.dynamics.contact_problem",
        "lcpflex.dynamics.impulse",
        "lcpflex.dynamics.joint_response",
        "lcpflex.dynamics.least_reactions",
        "lcpflex.dynamics.spatial.contact_forces_friction",
        "lcpflex.dynamics.spatial.gyroscopic",
        "lcpflex.dynamics.spatial.redundancy",
    ),
    "Rows.arrow": (
        "lcpflex.dynamics.spatial.contact_blocks",
        "lcpflex.dynamics.spatial.gyroscopic",
        "lcpflex.dynamics.stable_step",
        "lcpflex.steppers.spatial.massless_momenta",
    ),
    "Rows.solved": ("lcpflex.dynamics.delassus", "lcpflex.dynamics.stable_step"),  # by a matrix of their own
    "FreeMotion": (
        "lcpflex.dynamics.acceleration",
        "lcpflex.dynamics.contact_forces",
        "lcpflex.dynamics.impulse",
        "lcpflex.dynamics.mechanics",
        "lcpflex.dynamics.spatial.gyroscopic",
        "lcpflex.dynamics.spatial.mechanics",
        "lcpflex.dynamics.user_mechanics",
        "lcpflex.steppers.event_driven.impacts",
        "lcpflex.steppers.generalized_alpha",
        "lcpflex.steppers.massless_boundary",
        "lcpflex.steppers.moreau_jean",
        "lcpflex.steppers.smooth",
        "lcpflex.steppers.user_hooks",
    ),
    "FreeMotion.external": ("lcpflex.studies.turning_axes",),
    "FreeMotion.u": ("lcpflex.dynamics.stable_step", "lcpflex.steppers.spatial.massless_momenta"),
    "FreeMotion.v": (
        "lcpflex.dynamics.large_island",
        "lcpflex.dynamics.spatial.delassus",
        "lcpflex.steppers.projection",  # for a lift alone: it puts back what was there
    ),
    "FreeMotion.terms": ("lcpflex.dynamics.spatial.delassus", "lcpflex.steppers.projection"),
    "FreeMotion.span": ("lcpflex.steppers.fixed_steps", "lcpflex.steppers.time_stepping"),
    "Posed": (
        "lcpflex.dynamics.acceleration",
        "lcpflex.dynamics.contact_problem",
        "lcpflex.dynamics.large_island",
        "lcpflex.dynamics.spatial.acceleration",
        "lcpflex.dynamics.spatial.contact_problem",
        "lcpflex.steppers.event_driven.impacts",
        "lcpflex.steppers.generalized_alpha.position",
        "lcpflex.steppers.generalized_alpha.velocity",
        "lcpflex.steppers.moreau_jean.strikes",
    ),
    "Posed.islands": ("lcpflex.dynamics.islands", "lcpflex.steppers"),  # the latter, how far they have come with them
    "Posed.large": (
        "lcpflex.solvers",  # the answer
        "lcpflex.steppers.projection",  # the problem of a lift
        "lcpflex.steppers.spatial.island_problems",
    ),
    "Posed.part": ("lcpflex.solvers.contact.cones.normals", "lcpflex.steppers.spatial.projection"),
    "Posed.problem": (
        "lcpflex.dynamics.contact_compliance",
        "lcpflex.dynamics.position",
        "lcpflex.solvers",
        "lcpflex.steppers.driver",
    ),
    "Impulses": (
        "lcpflex.dynamics.impulse",
        "lcpflex.dynamics.position",
        "lcpflex.dynamics.spatial.position",
        "lcpflex.steppers.backup",
        "lcpflex.steppers.cold_islands",
        "lcpflex.steppers.generalized_alpha",
        "lcpflex.steppers.island_problems",
        "lcpflex.steppers.massless_boundary",
        "lcpflex.steppers.moreau_jean",
        "lcpflex.steppers.projection",
        "lcpflex.steppers.spatial.island_problems",
        "lcpflex.steppers.time_stepping",
    ),
    "Impulses.p": (  # whoever else solves for forces
        "lcpflex.dynamics.acceleration",
        "lcpflex.dynamics.contact_problem",
        "lcpflex.dynamics.joint_response",
        "lcpflex.dynamics.large_island",
        "lcpflex.dynamics.spatial",
        "lcpflex.solvers",
        "lcpflex.steppers.smooth",
        "lcpflex.steppers.spatial.alpha",
        "lcpflex.steppers.spatial.wide_islands",
        "lcpflex.steppers.strike_order",
    ),
    "Impulses.solver": (
        "lcpflex.dynamics.spatial",  # in space a problem is posed in the memory of its solver
        "lcpflex.solvers",
        "lcpflex.steppers.driver",
        "lcpflex.steppers.event_driven.stepper",
        "lcpflex.steppers.spatial",
    ),
    "Impulses.large_solver": ("lcpflex.solvers",),
    "Impulses.remembered": ("lcpflex.dynamics.spatial.gyroscopic", "lcpflex.solvers", "lcpflex.steppers.spatial.alpha"),
    "Impulses.most": ("lcpflex.dynamics.contact_problem", "lcpflex.steppers.spatial.wide_islands"),
    "Impulses.number": ("lcpflex.steppers.spatial.sets",),
    "Impulses.unsolved_large": ("lcpflex.steppers.spatial.alpha",),
    "Impulses.doubtful": ("lcpflex.steppers.doubtful",),
    "Impulses.doubtful_kind": ("lcpflex.steppers.doubtful",),
    "Impulses.n_doubtful": ("lcpflex.steppers.doubtful", "lcpflex.steppers.several_motions"),
    "Scratch": (
        "lcpflex.dynamics.contact_compliance",
        "lcpflex.dynamics.contact_problem",
        "lcpflex.dynamics.delassus",
        "lcpflex.dynamics.joint_response",
        "lcpflex.dynamics.large_island",
        "lcpflex.dynamics.spatial.gyroscopic",
        "lcpflex.dynamics.spatial.turning_slip",
        "lcpflex.dynamics.stable_step",
        "lcpflex.kinematics.joint_rows",
        "lcpflex.solvers",
        "lcpflex.steppers.island_problems",
        "lcpflex.steppers.massless_boundary.step",
        "lcpflex.steppers.projection",
        "lcpflex.steppers.spatial.massless_momenta",
        "lcpflex.steppers.spatial.projection",
    ),
}
