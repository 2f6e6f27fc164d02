"""Strikes that follow each other faster than the steps of Moreau-Jean, where their times decide.

A step strikes what closes by the velocities that it begins with; what that makes to close is struck in the next one. Of
three and more strikes in a row, each on a body of the one before, the times between them decide how often, and in which
order, contacts meet again: where these are shorter than a step, the step decides instead. Looked at are contacts with
restitution in runs that have stored each step.
"""

from __future__ import annotations

import numpy as np

from lcpflex.checks.struck_together import bodies_of_laws, neighbours, strikes
from lcpflex.results.result import Result

__all__ = ["strikes_in_turn"]

STEPS = 2  # from one strike to the next: within so many they are no farther apart than steps tell
MOST = 200  # strikes that are looked at, the first ones
PART = 0.1  # of the time between two, for the step that would tell


def strikes_in_turn(result: Result, step: float) -> tuple[str, ...]:
    """A warning where three strikes in a row took as many steps; none else."""
    if result.compiled is None or not result.stepper.startswith("MoreauJean(") or len(result.times) < 4:
        return ()
    gap, struck, closed = strikes(result)
    if not struck.any() or np.diff(result.times)[:-1].max() > 1.5 * step:
        return ()
    shared = neighbours(bodies_of_laws(result.compiled.model, gap.shape[1]))
    first: tuple[int, int, int] | None = None
    between = np.inf
    for i, a in np.argwhere(struck)[:MOST].tolist():
        for j, b in np.argwhere(struck[i : i + STEPS] & shared[a]).tolist():
            apart = gap[i, b]
            j += i
            if not apart > closed:
                continue
            after = struck[j : j + STEPS] & shared[b]
            after[: 1 if j == i else 0, a] = False
            if not after.any():
                continue
            speed = (gap[max(j - 1, 0) : j + 1, b] - gap[max(j - 1, 0) + 1 : j + 2, b]).max() / step
            if speed > 0.0:
                between = min(between, apart / speed)
                first = first or (i, a, b)
    if first is None or not between < STEPS * step:
        return ()
    i, a, b = first
    names, time = result.contact_names, result.times[i + 1]
    return (
        f"contacts {names[a]!r} and {names[b]!r} were struck within {STEPS} steps, and a third of their bodies with "
        f"them, first at t = {time:.6g} s: the order of strikes is that of steps, and may be another one; steps of at "
        f"most {PART * between:.2g} s tell (GeneralizedAlpha and EventDriven follow it at any step)",
    )
