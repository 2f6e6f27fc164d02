"""Memory of an event-driven run: the state with its quadratures, the stages of a step, what is watched for events.

The vector y holds q (nq numbers), u (ndof), then accumulated: energy lost to friction, to damping, work of loads and
drives [J], and the normal and tangential impulse of each declared contact, in space the latter as a vector [N s].
Last of all, beyond what error control looks at, stands what of the damping is that of compliant contacts [J].
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from lcpflex.contact.detection import ContactTable
from lcpflex.dynamics.acceleration import ContactSets, contact_sets
from lcpflex.dynamics.impact_laws import SEGMENTS
from lcpflex.jit.kernel import FloatArray, IntArray, kernel
from lcpflex.jit.leaf import in_space
from lcpflex.jit.struct import allocate, array, lengthen, shapes_of, spatial, struct
from lcpflex.kinematics.configuration import normalise
from lcpflex.model.arrays import Model
from lcpflex.model.layout import is_spatial, sums_of_contacts
from lcpflex.solvers.contact.several_motions import Trials, trials
from lcpflex.steppers.event_driven.root import Bracket
from lcpflex.steppers.golden_section import Section
from lcpflex.steppers.runge_kutta import STAGES, interpolate
from lcpflex.steppers.system import System

__all__ = [
    "EVENT_KINDS",
    "EventMemory",
    "EventSettings",
    "copy_entry",
    "event_memory",
    "more_impulses",
    "note_event",
    "within",
]

EVENT_KINDS = (
    "impact", "touch-down", "lift-off", "stick", "slip", "slip reversal", "impact without collision",
)  # fmt: skip
IMPACT, TOUCH_DOWN, LIFT_OFF, STICKS, SLIPS, REVERSES, JAMS_UP = range(7)
EVENT_CAPACITY = 256
WINDOW = 1000  # events over which their rate is measured
REMEMBERED = 64  # pairs whose last impact is remembered

# watched functions of a maintained contact, all positive while its sets hold
PRESSURE, CONE, SLIDING, SPAN = 0, 1, 2, 3
CLOSING = 4  # the gap of an open pair


class EventSettings(NamedTuple):
    """Numbers of the scheme, as the compiled loop takes them."""

    duration: float
    interval: float  # between stored instants [s]; 0: the end of each step; negative: its middle and its end
    rtol: float
    atol: FloatArray  # (ny,)
    max_step: float
    gap_tolerance: float
    velocity_threshold: float
    tolerance: float
    law: int  # of impact
    sequential: bool
    least_window: float  # [s] that WINDOW events take at least
    margin: float  # compliant contacts farther apart are not looked at [m]
    slip_threshold: float  # slower slip counts as none [m/s]
    calm: float  # time at which raised thresholds return to what they were [s]


@struct
class EventMemory:
    """Work arrays for ``capacity`` contacts, ny = nq + ndof + 4 + 2 laws, in space 4 laws."""

    y: FloatArray = array("ny")  # state at the start of the step
    end: FloatArray = array("ny")  # at its end
    slopes: FloatArray = array(STAGES, "ny")
    at: FloatArray = array("ny")  # state on the dense output
    before: FloatArray = array("ny")  # state at the sample before
    slope: FloatArray = array("ny")
    u: FloatArray = array("ndof")  # velocity before an impact
    reflected: FloatArray = array("ndof")  # velocity that restitution reflects
    approach: FloatArray = array("contacts")  # normal velocities when last looked at
    segments: FloatArray = array(SEGMENTS, 2)  # impulses of the phases of an impact
    trials: Trials  # of choices of sets for several motions
    recent: FloatArray = array(WINDOW)  # times of the last events
    sets: ContactSets
    seen: ContactTable  # what detection finds; the maintained contacts are in the table of the workspace
    near: ContactTable  # what may have touched between two looks
    dipping: FloatArray = array("ny")  # state between them
    section: Section  # where a gap is lowest
    value: FloatArray = array(4, "contacts")  # watched functions at the last evaluation
    old_value: FloatArray = array(4, "contacts")  # at the sample before
    bracket: Bracket  # of the root finder
    force: float  # scale of the contact forces [N]
    law_state: IntArray = array(3, "laws")  # of each contact before and after an event; whether, how it was hit
    taken: IntArray = array("laws")  # state where several motions were possible for the first time; -1: not closed
    tied: IntArray = array(2)  # declared contacts of the first tie, the one that was struck first
    law_work: FloatArray = array("laws")  # work of its impulses [J]
    struck_key: IntArray = array(REMEMBERED)  # pairs struck last
    struck_time: FloatArray = array(REMEMBERED, 2)  # when each was, and at the instant before [s]
    events: FloatArray = array("events", 4)  # time, kind, law, energy change
    nq: int  # where velocities begin in y
    n_contacts: int
    phase: int  # where the loop is
    steps: int
    n_events: int
    stuck: int  # events in a row without time between them
    hits: int
    cause: int
    stored: int
    kind: int
    which: int
    n_found: int
    # impacts: see lcpflex.steppers.event_driven.impacts
    round: int
    stage: int
    alone: int
    target: int
    jamming: int
    nudging: int
    # counts, of the run but nudges
    jams: int
    nudges: int
    several: int
    several_now: int
    cuts: int
    located: int
    looks: int  # steps left at whose ends contacts are sought that began where another one left, of no extent then
    too_many: int
    stopping: int  # of contacts that approach slower than the threshold: 1 while, 2 after
    ties: int  # impacts one after another whose order was arbitrary
    hidden: int  # whether a pair penetrates that came in where it was not looked for
    n_struck: int  # pairs noted as struck, also those forgotten since
    low: int  # 1 while an impact whose bounces are too low to be resolved is stopped
    spared: int  # 1 + declared contact that rests and carries nothing, others sharing its load
    time: float  # [s]
    step: float  # to try next [s]
    step_taken: float  # [s]
    share: float  # of it up to the event
    error: float
    last_event: float  # [s]
    number: float  # explains what a loop returned
    gained: float  # energy [J]
    first_jam: float  # [s]
    first_several: float  # [s]
    first_tie: float  # [s]
    deepest: float  # [m]
    fastest: float  # largest normal or tangential velocity of a closed contact so far [m/s]
    gentlest: float  # approach of the slowest impact since events were last counted anew [m/s]


SpatialEventMemory = spatial(EventMemory)


def event_memory(system: System, capacity: int, near: int, dense: int) -> EventMemory:
    """Allocate for ``system``, at its initial state.

    ``near``: pairs that may have touched between two looks; ``dense``: contacts of the largest island.
    """
    nq, ndof = len(system.q), len(system.u)
    laws = system.n_laws
    in_space = is_spatial(system.model)
    ny = nq + ndof + 4 + sums_of_contacts(system.model) * laws
    memory = allocate(
        SpatialEventMemory if in_space else EventMemory,
        {"ny": ny, "ndof": ndof, "laws": laws, "contacts": capacity, "events": EVENT_CAPACITY + 3 * laws},
        trials=trials(),
        sets=contact_sets(capacity, dense, in_space),
        seen=system.table(capacity),
        near=system.table(near, touching=-math.inf),
        bracket=allocate(Bracket, {}),
        section=allocate(Section, {}),
        taken=np.full(laws, -1, dtype=np.int64),
        nq=nq,
    )
    system.tell_surfaces(memory.seen)
    memory.y[:nq] = system.q
    memory.y[nq : nq + ndof] = system.u
    return memory


def more_impulses(memory: EventMemory, components: int) -> None:
    """Room for so many impulses more; what compliant contacts have lost stays the last number of a state."""
    before = len(memory.y)
    lengthen(memory, "ny", before, before + components)
    for name, shape in shapes_of(EventMemory).items():
        if shape[-1] == "ny":
            values = getattr(memory, name)
            values[..., -1] = values[..., before - 1]
            values[..., before - 1] = 0.0


@kernel
def within(model: Model, memory: EventMemory, share: float, out: FloatArray) -> None:
    """out = state at the ``share`` (0 ... 1) of the step, with the numbers of a configuration."""
    interpolate(memory.y, memory.slopes, memory.step_taken, share, out)
    normalise(model, out[: memory.nq])


@in_space("lcpflex.contact.spatial.table")
@kernel
def copy_entry(source: ContactTable, i: int, target: ContactTable, j: int) -> None:
    """Entry i of one table becomes entry j of another (or the same)."""
    target.key[j] = source.key[i]
    target.law[j] = source.law[i]
    target.node[j] = source.node[i]
    target.node_radius[j] = source.node_radius[i]
    target.kind[j] = source.kind[i]
    target.a[j] = source.a[i]
    target.b[j] = source.b[i]
    target.s[j] = source.s[i]
    target.radius[j] = source.radius[i]
    target.sense[j] = source.sense[i]
    target.gap[j] = source.gap[i]
    for c in range(2):
        target.span[j, c] = source.span[i, c]
        target.body[j, c] = source.body[i, c]
        target.normal[j, c] = source.normal[i, c]


@kernel
def note_event(memory: EventMemory, t: float, kind: int, law: int, change: float) -> None:
    """Write down an event."""
    row = memory.n_events
    if row < len(memory.events):
        memory.events[row, 0] = t
        memory.events[row, 1] = kind
        memory.events[row, 2] = law
        memory.events[row, 3] = change
        memory.n_events = row + 1
