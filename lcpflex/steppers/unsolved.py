"""Steps that went on with the best point of a large contact problem, in words."""

from __future__ import annotations

import math
from collections.abc import Callable

from lcpflex.dynamics.workspace import Workspace
from lcpflex.steppers.named import listed
from lcpflex.steppers.recorder import Counts

__all__ = ["lagging_remarks", "unsolved_large", "unsolved_remarks"]


def unsolved_remarks(counts: Counts, steps: int | None) -> list[str]:
    """The warning of a run in which large islands were not solved to the tolerance; empty where there was none.

    ``steps``: how many there were, each made once; None under error control, which makes them in halves.
    """
    islands = int(counts.unsolved_islands)
    if not islands:
        return []
    typical = math.exp(counts.typical_unsolved / islands)
    often = f"{int(counts.unsolved):,} " + ("steps or halves of steps" if steps is None else f"of {steps:,} steps")
    return [
        f"in {often}, islands of many contacts were not solved to the tolerance within their budget, and the step went "
        f"on with the best point: residuals up to {counts.worst_unsolved:.1e} of the terms that cancel, up to "
        f"{counts.worst_unsolved_strict:.1e} and typically {typical:.1e} of the velocity that contacts would have "
        "without their forces (a shorter step, or a larger budget, may solve them)"
    ]


def lagging_remarks(counts: Counts, name: Callable[[int], str]) -> list[str]:
    """The warning of a run in which large islands were solved as a whole alone; name: of a declared contact."""
    if not counts.lagging:
        return []
    times = "once" if counts.lagging == 1.0 else f"{int(counts.lagging):,} times"
    return [
        f"{times}, an island of many contacts was solved to the tolerance as a whole, and yet up to "
        f"{counts.worst_lag:.1e} is left of the velocity that a contact of it would have without its force: bodies "
        f"there are far lighter than others, and may go astray ({listed([int(counts.lag_law)], name)})"
    ]


def unsolved_large(work: Workspace, tolerance: float) -> str:
    """Why a run ends that is not to go on with the best point."""
    solver = work.impulses.large_solver
    return (
        f"the contact problem of an island of {work.posed.large.n_contacts} contacts was not solved in "
        f"{solver.newton.factors} sparse factors and {solver.search.sweeps} sweeps: natural-map residual "
        f"{solver.judged.residual:.3g} (tolerance {tolerance:g})"
    )
