"""The ladder of fidelities of a body that is known by its modes: rigid, 1, 2, 4, ... of them, the full mesh."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from lcpflex.bodies.body import Body, Rung
from lcpflex.bodies.reduction import Damping, Rayleigh

__all__ = ["counted", "mode_ladder"]

NEAR = 1.4  # the last rung below the full mesh has fewer modes than that by this factor: else it is hardly cheaper


def mode_ladder(
    available: int, reduce: Callable[[int, Damping, bool], Body], damping: Damping, residual: int = 0
) -> tuple[Rung, ...]:
    """Rigid, then rungs with 1, 2, 4, ... and all ``available`` free modes.

    Parameters
    ----------
    available : number of modes of the mesh
    reduce : makes the body with so many free modes, that damping, and its residual modes or none of them
    damping : of the body that is given. Where it is a ratio for each of its modes, the ladder ends with these: of the
        damping of others nothing is known.
    residual : number of residual modes that every rung between rigid and the full mesh has besides
    """
    known = available
    ratios = None
    if not isinstance(damping, Rayleigh) and np.ndim(damping) == 1:
        ratios = np.asarray(damping, dtype=float)
        known = len(ratios)

    def rung(modes: int) -> Rung:
        between = 0 < modes < available
        name = counted(modes, residual) if between else "full mesh" if modes else "rigid"
        own = damping if ratios is None else ratios[:modes]
        total = modes + residual if between else modes
        return Rung(name, total, lambda: replace(reduce(modes, own, between), ladder=lambda: rungs))

    counts = [0]
    step = 1
    while NEAR * (step + residual) < known:
        counts.append(step)
        step *= 2
    rungs = tuple(rung(modes) for modes in dict.fromkeys([*counts, known]))
    return rungs


def counted(modes: int, residual: int) -> str:
    """Free and residual modes in words."""
    if residual:
        return f"{modes} free and {residual} residual modes"
    return "1 mode" if modes == 1 else f"{modes} modes"
