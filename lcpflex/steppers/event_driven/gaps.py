"""Gaps of open pairs within a step: which close first, and which close and open again between two looks.

What is open at two looks may have been closed between them: a corner that grazes a surface, a throw that just reaches
a ceiling. Such dips are sought where the speeds of the bodies leave room for one.
"""

from __future__ import annotations

import math

from lcpflex.contact.detection import ContactTable, detect
from lcpflex.contact.narrow_phase.feature import foot_margin, node_margin, refresh
from lcpflex.contact.narrow_phase.limits import SPAN_TOLERANCE
from lcpflex.contact.table import entry_of
from lcpflex.dynamics.workspace import Workspace
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.jit.leaf import in_space
from lcpflex.model.arrays import Model
from lcpflex.model.planar import N_RIGID
from lcpflex.steppers.event_driven.memory import EventMemory, EventSettings, within
from lcpflex.steppers.event_driven.root import asked, found, start, tell
from lcpflex.steppers.golden_section import LOOKS, begin_section, narrow, next_place

__all__ = [
    "CROSSED",
    "NARROW",
    "dip_of",
    "first_closing",
    "first_dip",
    "gap_above",
    "locate_gap",
]

SHALLOW = 1e-3  # of the gap tolerance: penetration that is an event if the pair approaches
NARROW = 4e-16  # width of a root [s], relative to the time
CROSSED = 2  # memory.hidden
END = 1e-4  # of what is between two looks: over which slopes at its ends are measured


@kernel
def gap_above(model: Model, settings: EventSettings, seen: ContactTable, k: int, q: FloatArray) -> float:
    """Gap of entry k of what was seen; positive where the node is beside its feature: it comes in from there."""
    refresh(model, q, seen, k)
    gap = seen.gap[k]
    margin = min(foot_margin(model, q, seen, k), node_margin(model, q, seen, k))
    if margin < -SPAN_TOLERANCE:
        return abs(gap) + settings.gap_tolerance
    return gap


@kernel
def locate_gap(
    model: Model,
    settings: EventSettings,
    memory: EventMemory,
    table: ContactTable,
    k: int,
    low: float,
    high: float,
    f_low: float,
    f_high: float,
) -> float:
    """Share of the step at which the gap of entry k of a table closes."""
    narrow = NARROW * (memory.time + memory.step_taken) / memory.step_taken
    start(memory.bracket, low, high, f_low, f_high, SHALLOW * settings.gap_tolerance, narrow)
    while asked(memory.bracket) >= 0.0:
        within(model, memory, asked(memory.bracket), memory.dipping)
        tell(memory.bracket, gap_above(model, settings, table, k, memory.dipping[: memory.nq]))
    return found(memory.bracket)


@kernel
def seen_before(model: Model, settings: EventSettings, memory: EventMemory, key: int) -> bool:
    """Whether the pair penetrates in the state before, too."""
    count = detect(model, memory.before[: memory.nq], -SHALLOW * settings.gap_tolerance, memory.near)
    present = count > len(memory.near.key)
    for i in range(min(count, len(memory.near.key))):
        present = present or memory.near.key[i] == key
    return present


@kernel
def first_closing(
    model: Model, settings: EventSettings, work: Workspace, memory: EventMemory, low: float, high: float
) -> float:
    """Earliest share in (low, high] at which a pair that was open closes; above high if none. State: before, at.

    A negative number: the table of what is seen must hold as many entries. memory.hidden tells of a pair that
    penetrates and did not come in through its feature: it has gone so far that another one is nearer by now.
    """
    memory.hidden = 0
    nq = memory.nq
    n = memory.n_contacts
    count = detect(model, memory.at[:nq], -SHALLOW * settings.gap_tolerance, memory.seen)
    if count > len(memory.seen.key):
        return -float(count)
    first = 2.0
    last = 0
    for i in range(count):
        present = entry_of(work.rows.table.key, n, memory.seen.key[i], last)
        if present >= 0:
            last = present + 1
            continue
        f_high = memory.seen.gap[i]
        f_low = gap_above(model, settings, memory.seen, i, memory.before[:nq])
        closing = f_high < f_low
        if f_high > -settings.gap_tolerance:  # so shallow it may be rounding: does it approach?
            back = 0.1 * (high - low)
            within(model, memory, high - back, memory.at)
            refresh(model, memory.at[:nq], memory.seen, i)
            fall = memory.seen.gap[i] - f_high
            closing = fall > settings.velocity_threshold * back * memory.step_taken + 1e-6 * settings.gap_tolerance
        if closing:
            first = min(first, locate_gap(model, settings, memory, memory.seen, i, low, high, f_low, f_high))
        elif f_high < -settings.gap_tolerance:
            if seen_before(model, settings, memory, memory.seen.key[i]):
                memory.deepest = max(memory.deepest, -f_high)
            else:
                memory.hidden = 1
    return first


@in_space("lcpflex.steppers.spatial.speeds")
@kernel
def room(model: Model, memory: EventMemory, y: FloatArray) -> float:
    """Twice the largest speed of a material point [m/s]: no gap changes faster. Infinite where bodies are unknown."""
    largest = math.inf if len(model.bodies.mass) == 0 else 0.0
    size = 0.0
    c = model.contacts
    for s in range(len(c.surface_extent)):
        if c.surface_body[s] >= 0 and c.surface_extent[s] < math.inf:  # from the frame: a tip is far, and a point
            size = max(size, c.surface_extent[s] + math.hypot(c.surface_center[s, 0], c.surface_center[s, 1]))
    ndof = len(memory.u)
    for b in range(len(model.bodies.mass)):
        d = ndof + model.bodies.dof[b]
        end = ndof + (model.bodies.dof[b + 1] if b + 1 < len(model.bodies.mass) else ndof)
        modal = 0.0
        for i in range(d + N_RIGID, end):
            modal += y[i] ** 2
        # M_ff = I: shapes are of the size 1 / sqrt(m), and twice that at free ends
        speed = math.hypot(y[d], y[d + 1]) + 2.0 * size * abs(y[d + 2])
        largest = max(largest, speed + 2.0 * math.sqrt(modal / model.bodies.mass[b]))
    return 2.0 * largest


@kernel
def dip_of(model: Model, settings: EventSettings, memory: EventMemory, k: int, low: float, high: float) -> float:
    """Share in (low, high) at which the gap of entry k of what is near is closed, by golden sections; high if none."""
    nq = memory.nq
    begin_section(memory.section, low, high)
    for _ in range(LOOKS):
        share = next_place(memory.section)
        within(model, memory, share, memory.dipping)
        gap = gap_above(model, settings, memory.near, k, memory.dipping[:nq])
        if gap < -settings.gap_tolerance:
            return share
        narrow(memory.section, gap)
    return high


@kernel
def first_dip(
    model: Model, settings: EventSettings, work: Workspace, memory: EventMemory, low: float, high: float
) -> float:
    """A share in (low, high) at which a pair is closed that is open before and after; high if there is none.

    And at which one closes that has gone so far by ``high`` that it is not detected there: memory.hidden = CROSSED.
    State: before, at. A negative number: the table of what is near must hold as many entries.
    """
    memory.hidden = 0
    nq = memory.nq
    h = memory.step_taken
    tolerance = settings.gap_tolerance
    reach = max(room(model, memory, memory.before), room(model, memory, memory.at)) * (high - low) * h
    count = detect(model, memory.before[:nq], reach, memory.near)
    if count > len(memory.near.key):
        return -float(count)
    least = high
    last = 0
    for i in range(count):
        present = entry_of(work.rows.table.key, memory.n_contacts, memory.near.key[i], last)
        if present >= 0:
            last = present + 1
            continue
        f_low = gap_above(model, settings, memory.near, i, memory.before[:nq])
        f_high = gap_above(model, settings, memory.near, i, memory.at[:nq])
        if f_low < -tolerance or f_low + f_high >= reach:
            continue
        if f_high < -tolerance:
            share = locate_gap(model, settings, memory, memory.near, i, low, high, f_low, f_high)
            if share < least:
                least = share
                memory.hidden = CROSSED
            continue
        part = END * (high - low)
        within(model, memory, high - part, memory.dipping)
        if gap_above(model, settings, memory.near, i, memory.dipping[:nq]) >= f_high:
            continue
        within(model, memory, low + part, memory.dipping)
        if gap_above(model, settings, memory.near, i, memory.dipping[:nq]) > f_low:
            continue
        share = dip_of(model, settings, memory, i, low, high)
        if share < least:
            least = share
            memory.hidden = 0
    return least
