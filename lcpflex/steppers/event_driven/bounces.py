"""Bounces too low to be resolved: they are stopped, where they would go on for ever between roundings of the gap.

A pair that is pressed together with the acceleration a, as a flexible body on a support is, comes back from a bounce of
the height h with sqrt(2 a h): for a = 1e3 m/s^2 that is faster than the velocity threshold as long as h > 1e-15 m,
far below what its gap resolves. The height is known without forces: v / 4 times the time since the impact before.
"""

from __future__ import annotations

from lcpflex.dynamics.workspace import Workspace
from lcpflex.jit.kernel import kernel
from lcpflex.model.arrays import Model
from lcpflex.steppers.event_driven.memory import REMEMBERED, EventMemory, EventSettings

__all__ = ["note_strike", "too_low"]

LOWEST = 1e-5  # of the gap tolerance: lower bounces are not resolved


@kernel
def note_strike(memory: EventMemory, key: int) -> None:
    """Remember that a pair has been struck now, and when it was before this instant."""
    t = memory.time
    row = -1
    for i in range(min(memory.n_struck, REMEMBERED)):
        if memory.struck_key[i] == key:
            row = i
    if row < 0:
        row = memory.n_struck % REMEMBERED
        memory.n_struck += 1
        memory.struck_key[row] = key
        memory.struck_time[row, 0] = t
        memory.struck_time[row, 1] = t
    elif memory.struck_time[row, 0] != t:
        memory.struck_time[row, 1] = memory.struck_time[row, 0]
        memory.struck_time[row, 0] = t


@kernel
def too_low(model: Model, settings: EventSettings, work: Workspace, memory: EventMemory, k: int) -> bool:
    """Whether entry k of the table, which approaches, would bounce less high than a gap is resolved."""
    t = memory.time
    key = work.rows.table.key[k]
    e = model.contacts.restitution[work.rows.table.law[k]]
    for i in range(min(memory.n_struck, REMEMBERED)):
        if memory.struck_key[i] == key and e > 0.0:
            before = memory.struck_time[i, 0] if memory.struck_time[i, 0] != t else memory.struck_time[i, 1]
            if before != t:
                return -0.25 * e * e * memory.approach[k] * (t - before) < LOWEST * settings.gap_tolerance
    return False
