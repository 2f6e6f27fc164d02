"""Memory of a run by the nonsmooth generalised-alpha scheme: what a step needs of the last one, and its iterates."""

from __future__ import annotations

from lcpflex.contact.detection import ContactTable
from lcpflex.dynamics.acceleration import ContactSets, contact_sets
from lcpflex.jit.kernel import FloatArray, IntArray, kernel
from lcpflex.jit.leaf import in_space
from lcpflex.jit.struct import allocate, array, copy_parts, struct
from lcpflex.model.layout import is_spatial
from lcpflex.steppers.event_driven.memory import copy_entry
from lcpflex.steppers.strike_order import StrikeOrder, strike_order
from lcpflex.steppers.system import System

__all__ = ["AlphaScheme", "EndForces", "Held", "alpha_scheme", "hold", "larger", "match", "note_overrun"]

RESTART, SMOOTH, POSITION, VELOCITY = 0, 1, 2, 3  # AlphaScheme.phase: what is solved next
MIXED = 5  # passes that are combined at most


@struct
class Held:
    """Contacts that carry something, with what they carry."""

    table: ContactTable
    count: int
    load: FloatArray = array("contacts", "parts")  # normal and tangential; in space friction in world axes
    mode: IntArray = array("contacts")  # of the sets SMOOTH, STICKING, SLIDE_FORTH, SLIDE_BACK
    taken: IntArray = array("contacts")  # 1 where an entry of a table has been found to be it


@struct
class EndForces:
    """Smooth forces at one end of a step: generalised ones that do work, and those of each declared contact."""

    friction: FloatArray = array("ndof")
    normal: FloatArray = array("ndof")
    damping: FloatArray = array("ndof")
    drive: FloatArray = array("ndof")
    conservative: FloatArray = array("ndof")
    contact: FloatArray = array("laws", "parts")  # as sums of a record are: normal and tangential [N]


@struct
class Mixing:
    """Passes of Newton's method so far (:mod:`lcpflex.steppers.generalized_alpha.mixing`)."""

    count: int  # differences of passes that were used; 0 as long as it converges fast
    fault: FloatArray = array("ndof")  # change that the last pass asked for
    answer: FloatArray = array("ndof")  # what it came to
    faults: FloatArray = array(MIXED, "ndof")  # differences of these from pass to pass
    answers: FloatArray = array(MIXED, "ndof")
    weighted: FloatArray = array(MIXED, "ndof")  # M times those of faults
    products: FloatArray = array(MIXED, MIXED)
    factor: FloatArray = array(MIXED, MIXED)
    share: FloatArray = array(MIXED)


@struct
class AlphaScheme:
    """Numbers of the scheme, its state, and work arrays for a number of contacts."""

    step: float  # that the recursive acceleration belongs to
    alpha_m: float
    alpha_f: float
    gamma: float
    beta: float
    gap_tolerance: float
    velocity_threshold: float
    tolerance: float
    rebound: float  # slower approach is stopped, not reflected [m/s]
    settle: float  # and so is one that is slower than so many times what this step adds to it
    sunk: float  # penetration that is told where it is lifted without an impulse [m]
    q: FloatArray = array("nq")
    u: FloatArray = array("ndof")
    a: FloatArray = array("ndof")  # the recursive acceleration of the scheme
    w: FloatArray = array("ndof")  # udot at the start of the step
    a_new: FloatArray = array("ndof")
    w_new: FloatArray = array("ndof")  # iterate of udot at its end
    q_new: FloatArray = array("nq")  # configuration at its end
    v_new: FloatArray = array("ndof")  # velocity at its end without impulses
    momentum: FloatArray = array("ndof")  # a product with M
    mean: FloatArray = array("ndof")  # a velocity over the step
    sets: ContactSets
    resting: Held  # contacts of the smooth motion with their forces [N]
    pressed: Held  # contacts that carry something in the present pass of the position problem [N s]
    matched: IntArray = array("contacts")  # the resting contact that each one of the table is, or -1
    total: FloatArray = array("contacts")  # nu of each contact of the table [N s]
    recursive: FloatArray = array("laws", "parts")  # share of the smooth contact forces in a [N]
    deep: FloatArray = array("laws")  # how deep contacts that did not rest were before they were lifted [m]
    start: EndForces
    end: EndForces
    mixing: Mixing
    order: StrikeOrder
    change: float  # last one of an acceleration
    numerical: float  # energy lost to numerical damping in this step [J]
    lifted: float  # deepest penetration that a position problem has taken out [m]
    approach: float  # fastest one of a pair that closed [m/s]
    struck_at: float  # how deep it was [m]
    stopped: float  # fastest approach stopped [m/s]
    overrun: float  # farthest way by which the smooth motion goes on with a slip that has ended [m]
    left: float  # speed of contacts that the last velocity problem was to stop, in space [m/s]
    phase: int  # RESTART, SMOOTH, POSITION or VELOCITY: what is solved next
    turn: int  # passes of the present problem
    skip: int
    n_found: int
    warm: int
    unsettled: int


def alpha_scheme(system: System, capacity: int, **numbers: float) -> AlphaScheme:
    """Allocate for ``system``, before its first step."""
    in_space = is_spatial(system.model)
    sizes = {"nq": len(system.q), "ndof": len(system.u), "contacts": capacity, "laws": system.n_laws}
    sizes |= {"parts": 4 if in_space else 2}
    return allocate(
        AlphaScheme,
        sizes,
        q=system.q.copy(),
        u=system.u.copy(),
        start=allocate(EndForces, sizes),
        end=allocate(EndForces, sizes),
        mixing=allocate(Mixing, sizes),
        order=strike_order(system, capacity),
        sets=contact_sets(capacity, capacity if in_space else 0, in_space),
        resting=allocate(Held, sizes, table=system.held(capacity)),
        pressed=allocate(Held, sizes, table=system.held(capacity)),
        **numbers,
    )


def larger(system: System, old: AlphaScheme, capacity: int) -> AlphaScheme:
    """The same content with room for ``capacity`` contacts."""
    new = alpha_scheme(system, capacity)
    copy_parts(old, new)
    return new


@in_space("lcpflex.steppers.spatial.alpha")
@kernel
def same_node(table: ContactTable, k: int, other: ContactTable, i: int) -> bool:
    """Whether entry k of a table is of the same node as entry i of another one, whatever they touch."""
    return bool(table.node[k] == other.node[i])


@kernel
def match(table: ContactTable, n: int, held: Held, out: IntArray) -> None:
    """Which of the held contacts each of the first n entries of the table is; -1 for none.

    The same pair of node and feature, or the same node where it has passed from one feature of a surface to the next.
    Each held contact is one entry at most: a node that rests in one feature and touches another one beside it carries
    nothing there.
    """
    for i in range(held.count):
        held.taken[i] = 0
    guess = 0
    for k in range(n):
        out[k] = -1
        for step in range(held.count):
            i = guess + step
            if i >= held.count:
                i -= held.count
            if held.taken[i] == 0 and held.table.key[i] == table.key[k]:
                out[k] = i
                held.taken[i] = 1
                guess = i + 1
                break
    for k in range(n):
        if out[k] >= 0:
            continue
        for i in range(held.count):
            if held.taken[i] == 0 and held.table.law[i] == table.law[k] and same_node(table, k, held.table, i):
                out[k] = i
                held.taken[i] = 1
                break


@kernel
def hold(table: ContactTable, k: int, normal: float, mode: int, held: Held) -> None:
    """Add entry k of the table with its normal load, and no friction yet."""
    i = held.count
    copy_entry(table, k, held.table, i)
    held.load[i, 0] = normal
    for part in range(1, held.load.shape[1]):
        held.load[i, part] = 0.0
    held.mode[i] = mode
    held.count = i + 1


@kernel
def note_overrun(scheme: AlphaScheme, back: float, change: float) -> None:
    """Keep how far a slip went on after its end, by what is taken from its speed and its change in the step [m/s].

    At a steady acceleration it was over for ``back / change`` of the step, at half of that speed in the mean.
    """
    if change > 0.0:
        scheme.overrun = max(scheme.overrun, 0.5 * scheme.step * back * min(1.0, back / change))
