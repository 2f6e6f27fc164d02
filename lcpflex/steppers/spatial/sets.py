"""Index sets of contacts in space, as the event-driven stepper chooses them."""

from __future__ import annotations

from lcpflex.dynamics.spatial.inertia import SpatialWork
from lcpflex.jit.kernel import kernel
from lcpflex.steppers.event_driven.memory import EventMemory, EventSettings

__all__ = ["note_paradox"]


@kernel
def note_paradox(settings: EventSettings, work: SpatialWork, memory: EventMemory) -> None:
    """Nothing: several motions are not looked for."""
