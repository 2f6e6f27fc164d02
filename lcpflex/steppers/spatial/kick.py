"""The kick of Verlet's method in space."""

from __future__ import annotations

from typing import Any

from lcpflex.dynamics.workspace import Workspace
from lcpflex.jit.kernel import kernel
from lcpflex.steppers.smooth.memory import SmoothMemory
from lcpflex.steppers.smooth.slope import slope

__all__ = ["kick_again"]


@kernel
def kick_again(model: Any, h: float, work: Workspace, memory: SmoothMemory) -> None:
    """Make the kick of a step of length h anew, with the mean of the velocities before and behind the first one.

    omega x J omega at the velocity before it alone gains energy and is of order 1; so it is of order 2.
    """
    base = memory.nq + len(work.free_u)
    for i in range(len(memory.end)):
        memory.at[i] = memory.end[i]
    for i in range(memory.nq, base):
        memory.at[i] = 0.5 * (memory.y[i] + memory.end[i])
    slope(model, memory.time + 0.5 * h, memory.at, work, memory, memory.slope)  # with tables that are large enough
    for i in range(memory.nq, memory.states):
        memory.end[i] = memory.y[i] + h * memory.slope[i]
