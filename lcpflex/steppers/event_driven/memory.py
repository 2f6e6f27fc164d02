"""Memory of an event-driven run: the state with its quadratures, the stages of a step, what is watched for events.

The vector y holds q, u, then accumulated: energy lost to friction, to damping, work of loads and drives [J], and the
normal and tangential impulse of each declared contact [N s].
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from lcpflex.contact.detection import ContactTable
from lcpflex.dynamics.acceleration import ContactSets, contact_sets
from lcpflex.dynamics.impact import SEGMENTS
from lcpflex.jit.kernel import FloatArray, IntArray, kernel
from lcpflex.jit.struct import pack
from lcpflex.solvers.lcp.enumeration import enumeration_workspace
from lcpflex.steppers.event_driven.root import BRACKET
from lcpflex.steppers.runge_kutta import STAGES
from lcpflex.steppers.system import System

__all__ = ["EVENT_KINDS", "EventMemory", "EventSettings", "copy_entry", "event_memory", "note_event"]

EVENT_KINDS = (
    "impact", "touch-down", "lift-off", "stick", "slip", "slip reversal", "impact without collision",
)  # fmt: skip
IMPACT, TOUCH_DOWN, LIFT_OFF, STICKS, SLIPS, REVERSES, JAMS_UP = range(7)
EVENT_CAPACITY = 256
WINDOW = 1000  # events over which their rate is measured
TESTED = 6  # unknowns: choices of sets up to this size are tested for several motions
SEVERAL_KEPT = 8
REMEMBERED = 64  # pairs whose last impact is remembered

# watched functions of a maintained contact, all positive while its sets hold
PRESSURE, CONE, SLIDING, SPAN = 0, 1, 2, 3
CLOSING = 4  # the gap of an open pair


class EventSettings(NamedTuple):
    """Numbers of the scheme, as the compiled loop takes them."""

    duration: float
    interval: float
    rtol: float
    atol: FloatArray  # (ny,)
    max_step: float
    gap_tolerance: float
    velocity_threshold: float
    tolerance: float
    law: int  # of impact
    sequential: bool
    least_window: float  # [s] that WINDOW events take at least
    margin: float  # contacts by law farther apart are not looked at [m]
    slip_threshold: float  # slower slip counts as none [m/s]
    calm: float  # time at which raised thresholds return to what they were [s]


class EventMemory(NamedTuple):
    """Work arrays for ``capacity`` contacts, ny = 2 ndof + 3 + 2 laws."""

    y: FloatArray  # (ny,) state at the start of the step
    end: FloatArray  # (ny,) at its end
    slopes: FloatArray  # (7, ny)
    at: FloatArray  # (ny,) state on the dense output
    before: FloatArray  # (ny,) state at the sample before
    slope: FloatArray  # (ny,)
    u: FloatArray  # (ndof,) velocity before an impact
    reflected: FloatArray  # (ndof,) velocity that restitution reflects
    approach: FloatArray  # (capacity,) normal velocities when last looked at
    least: FloatArray  # (capacity,) least normal impulses of an expansion
    segments: FloatArray  # (SEGMENTS, 2) impulses of the phases of an impact
    found: FloatArray  # (SEVERAL_KEPT, TESTED) solutions of a choice of sets; work arrays of the enumeration
    codes: IntArray
    singular: IntArray
    tried: FloatArray
    order: IntArray
    recent: FloatArray  # (WINDOW,) times of the last events
    sets: ContactSets
    seen: ContactTable  # what detection finds; the maintained contacts are in the table of the workspace
    near: ContactTable  # what may have touched between two looks
    dipping: FloatArray  # (ny,) state between them
    value: FloatArray  # (4, capacity) watched functions at the last evaluation
    old_value: FloatArray  # (4, capacity) at the sample before
    bracket: FloatArray  # (BRACKET,) of the root finder
    force: FloatArray  # (1,) scale of the contact forces [N]
    law_state: IntArray  # (3, laws) state of each declared contact before and after an event; whether, how it was hit
    taken: IntArray  # (laws,) state where several motions were possible for the first time; -1: not closed
    tied: IntArray  # (2,) declared contacts of the first tie, the one that was struck first
    law_work: FloatArray  # (laws,) work of its impulses [J]
    struck_key: IntArray  # (REMEMBERED,) pairs struck last
    struck_time: FloatArray  # (REMEMBERED, 2) when each was, and at the instant before [s]
    events: FloatArray  # (EVENT_CAPACITY, 4) time, kind, law, energy change
    number: IntArray  # see the names below
    clock: FloatArray


# number
CONTACTS, PHASE, STEPS, EVENTS, STUCK, HITS, CAUSE, STORED, KIND, WHICH, FOUND = range(11)
ROUND, STAGE, ALONE, TARGET, JAMMING, NUDGING = range(11, 17)  # of impacts: see event_impacts
JAMS, NUDGES, SEVERAL, SEVERAL_NOW, CUTS, LOCATED, TOO_MANY = range(17, 24)  # counts, of the run but NUDGES
STOPPING = 24  # of contacts that approach slower than the threshold: 1 while, 2 after
TIES = 25  # impacts one after another whose order was arbitrary
HIDDEN = 26  # whether a pair penetrates that came in where it was not looked for
STRUCK = 27  # pairs noted as struck, also those forgotten since
LOW = 28  # 1 while an impact whose bounces are too low to be resolved is stopped
SPARED = 29  # 1 + declared contact that rests and carries nothing, others sharing its load
# clock
TIME, STEP, TAKEN, SHARE, ERROR, LAST_EVENT, DETAIL, GAINED, FIRST_JAM, FIRST_SEVERAL, FIRST_TIE, DEEPEST = range(12)
FASTEST = 12  # largest normal or tangential velocity of a closed contact so far [m/s]
GENTLEST = 13  # approach of the slowest impact since events were last counted anew [m/s]


def event_memory(system: System, capacity: int, near: int) -> EventMemory:
    """Allocate for ``system``, at its initial state; ``near``: pairs that may have touched between two looks."""
    ndof = len(system.q)
    laws = system.n_laws
    ny = 2 * ndof + 3 + 2 * laws
    zeros = np.zeros
    tried, order = enumeration_workspace(TESTED)
    arrays = EventMemory(
        y=zeros(ny),
        end=zeros(ny),
        slopes=zeros((STAGES, ny)),
        at=zeros(ny),
        before=zeros(ny),
        slope=zeros(ny),
        u=zeros(ndof),
        reflected=zeros(ndof),
        approach=zeros(capacity),
        least=zeros(capacity),
        segments=zeros((SEGMENTS, 2)),
        found=zeros((SEVERAL_KEPT, TESTED)),
        codes=np.zeros(SEVERAL_KEPT, dtype=np.int64),
        singular=np.zeros(1, dtype=np.int64),
        tried=tried,
        order=order,
        recent=zeros(WINDOW),
        sets=contact_sets(capacity),
        seen=system.table(capacity),
        near=system.table(near),
        dipping=zeros(ny),
        value=zeros((4, capacity)),
        old_value=zeros((4, capacity)),
        bracket=zeros(BRACKET),
        force=zeros(1),
        law_state=np.zeros((3, laws), dtype=np.int64),
        taken=np.full(laws, -1, dtype=np.int64),
        tied=np.zeros(2, dtype=np.int64),
        law_work=zeros(laws),
        struck_key=np.zeros(REMEMBERED, dtype=np.int64),
        struck_time=zeros((REMEMBERED, 2)),
        events=zeros((EVENT_CAPACITY + 3 * laws, 4)),
        number=np.zeros(30, dtype=np.int64),
        clock=zeros(14),
    )
    memory = pack(arrays)
    memory.y[:ndof] = system.q
    memory.y[ndof : 2 * ndof] = system.u
    return pack(memory)


@kernel
def copy_entry(source: ContactTable, i: int, target: ContactTable, j: int) -> None:
    """Entry i of one table becomes entry j of another (or the same)."""
    target.key[j] = source.key[i]
    target.law[j] = source.law[i]
    target.slave[j] = source.slave[i]
    target.slave_radius[j] = source.slave_radius[i]
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
    row = memory.number[EVENTS]
    if row < len(memory.events):
        memory.events[row, 0] = t
        memory.events[row, 1] = kind
        memory.events[row, 2] = law
        memory.events[row, 3] = change
        memory.number[EVENTS] = row + 1
