"""The ladder of fidelities of a body that is known by its modes: rigid, 1, 2, 4, ... of them, the full mesh."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from lcpflex.bodies.body import Body, Rung
from lcpflex.bodies.reduction import Damping, Rayleigh

__all__ = ["mode_ladder"]

NEAR = 1.4  # the last rung below the full mesh has fewer modes than that by this factor: else it is hardly cheaper


def mode_ladder(available: int, reduce: Callable[[int, Damping], Body], damping: Damping) -> tuple[Rung, ...]:
    """Rungs with 0, 1, 2, 4, ... and all ``available`` modes.

    Parameters
    ----------
    available : number of modes of the mesh
    reduce : makes the body with so many modes and that damping
    damping : of the body that is given. Where it is a ratio for each of its modes, the ladder ends with these: of the
        damping of others nothing is known.
    """
    known = available
    ratios = None
    if not isinstance(damping, Rayleigh) and np.ndim(damping) == 1:
        ratios = np.asarray(damping, dtype=float)
        known = len(ratios)

    def rung(modes: int) -> Rung:
        name = "rigid" if modes == 0 else "full mesh" if modes == available else _counted(modes)
        own = damping if ratios is None else ratios[:modes]
        return Rung(name, modes, lambda: replace(reduce(modes, own), ladder=lambda: rungs))

    counts = [0]
    step = 1
    while NEAR * step < known:
        counts.append(step)
        step *= 2
    rungs = tuple(rung(modes) for modes in dict.fromkeys([*counts, known]))
    return rungs


def _counted(modes: int) -> str:
    return "1 mode" if modes == 1 else f"{modes} modes"
