"""Corners that leave a face at the instant at which they reach it: they strike nothing.

A body that slides over an edge of another one and tips has a face on that edge. Its own corner sinks towards the plane
of the other face as it comes to the edge, and is there when the edge has come to it: one leaves as the other arrives.
By rounding the corner is on the face a moment before, with a normal of which the motion knows nothing. The same holds
of the vertices of a face in space, and of the sides that cross there.
"""

from __future__ import annotations

import math

from lcpflex.contact.detection import ContactTable, detect
from lcpflex.contact.narrow_phase.feature import SEGMENT, foot_margin, refresh
from lcpflex.contact.narrow_phase.limits import SPAN_TOLERANCE
from lcpflex.contact.rows import gap_rate
from lcpflex.contact.table import entry_of
from lcpflex.dynamics.workspace import Workspace
from lcpflex.jit.kernel import kernel
from lcpflex.jit.leaf import in_space
from lcpflex.kinematics.configuration import rate
from lcpflex.model.arrays import Model
from lcpflex.steppers.event_driven.memory import EventMemory, EventSettings, copy_entry

__all__ = ["leave_passing", "move_on"]

PASSED = 10.0  # gap tolerances: what is no deeper where it leaves its face has not touched that


@in_space("lcpflex.steppers.spatial.sliding")
@kernel
def is_vertex(table: ContactTable, k: int) -> bool:
    """Whether entry k is a single point on a flat face."""
    return table.kind[k] == SEGMENT and table.node_radius[k] == 0.0


@in_space("lcpflex.steppers.spatial.sliding")
@kernel
def rises(model: Model, settings: EventSettings, memory: EventMemory, k: int) -> bool:
    """Whether a crossing over a face that was seen opens as it moves along its edge: there are crossings in space."""
    return False


@kernel
def move_on(model: Model, memory: EventMemory, time: float) -> None:
    """The configuration so little later [s] that velocities stay, to ``memory.dipping``."""
    nq = memory.nq
    rate(model, memory.y[:nq], memory.y[nq : nq + len(memory.u)], memory.slope)
    for i in range(nq):
        memory.dipping[i] = memory.y[i] + time * memory.slope[i]


@kernel
def leaving_time(model: Model, settings: EventSettings, memory: EventMemory, k: int) -> float:
    """Within how long the corner of entry k of what was seen leaves its face [s]; infinite if it strikes that before.

    A tilted face that slides over an edge rests on where the edge crosses its sides, in the plane on the edge itself.
    Its corners sink below the plane of the other face as they reach that edge, at an angle: each has a gap of 0 as it
    leaves, and strikes nothing.
    """
    nq, seen = memory.nq, memory.seen
    if not is_vertex(seen, k):
        return math.inf
    q, u = memory.y[:nq], memory.y[nq : nq + len(memory.u)]
    approach = -gap_rate(model, q, u, seen, k)
    if approach <= settings.velocity_threshold:
        return math.inf
    later = PASSED * settings.gap_tolerance / approach
    move_on(model, memory, later)
    copy_entry(seen, k, memory.near, 0)
    refresh(model, memory.dipping[:nq], memory.near, 0)
    return later if foot_margin(model, memory.dipping[:nq], memory.near, 0) < -SPAN_TOLERANCE else math.inf


@kernel
def leave_passing(model: Model, settings: EventSettings, work: Workspace, memory: EventMemory, found: int) -> int:
    """Corners that leave a face at this instant give way to what is there then; how many entries there are.

    They are of bodies that touch already. More than the table can hold: nothing is done yet.
    """
    seen, near, nq = memory.seen, memory.near, memory.nq
    last = 0.0
    kept = 0
    for k in range(found):
        law = seen.law[k]
        touches = False
        for i in range(memory.n_contacts):
            touches = touches or work.rows.table.law[i] == law
        later = leaving_time(model, settings, memory, k) if touches else math.inf
        if touches and rises(model, settings, memory, k):
            continue
        if later < math.inf:
            last = max(last, later)
        else:
            copy_entry(seen, k, seen, kept)
            kept += 1
    if last == 0.0:
        return kept
    move_on(model, memory, last)
    count = detect(model, memory.dipping[:nq], PASSED * settings.gap_tolerance, near)
    if max(count, kept + count) > len(seen.key):
        return kept + count
    for i in range(count):
        if entry_of(seen.key, kept, near.key[i], 0) >= 0:
            continue
        copy_entry(near, i, seen, kept)
        refresh(model, memory.y[:nq], seen, kept)
        touches = abs(seen.gap[kept]) <= settings.gap_tolerance
        kept += 1 if touches and not rises(model, settings, memory, kept) else 0
    return kept
