"""The choice of fidelity levels of a body that is known by its modes: rigid, 1, 2, 4, ... of them, the full mesh."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from lcpflex.bodies.body import Body, FidelityLevel
from lcpflex.bodies.reduction.damping import Damping, Rayleigh
from lcpflex.bodies.reduction.interface import Interface

__all__ = ["ModeLevels", "counted"]

NEAR = 1.4  # the last level below the full mesh has fewer modes than that by this factor: else it is hardly cheaper


@dataclass(frozen=True, slots=True, eq=False)
class ModeLevels:
    """Gives the levels rigid, then 1, 2, 4, ... and all ``available`` free modes.

    Attributes
    ----------
    available : number of modes of the mesh
    reduce : makes the body with so many free modes, that damping, and residual modes for its ``interfaces=``
    interfaces : those of the body that is given
    damping : of the body that is given. Where it is a ratio for each of its modes, the levels end with these: of the
        damping of others nothing is known.
    residual : number of residual modes that every level between rigid and the full mesh has besides
    """

    available: int
    reduce: Callable[..., Body]
    interfaces: tuple[Interface, ...]
    damping: Damping
    residual: int = 0

    def __call__(self) -> tuple[FidelityLevel, ...]:
        """The levels."""
        ratios = self._ratios()
        known = self.available if ratios is None else len(ratios)
        counts = [0]
        step = 1
        while NEAR * (step + self.residual) < known:
            counts.append(step)
            step *= 2
        return tuple(self._level(modes) for modes in dict.fromkeys([*counts, known]))

    def _ratios(self) -> np.ndarray[Any, Any] | None:
        """One damping ratio for each mode, if it was given so."""
        if isinstance(self.damping, Rayleigh) or np.ndim(self.damping) != 1:
            return None
        return np.asarray(self.damping, dtype=float)

    def _level(self, modes: int) -> FidelityLevel:
        between = 0 < modes < self.available
        name = counted(modes, self.residual) if between else "full mesh" if modes else "rigid"
        return FidelityLevel(name, modes + self.residual if between else modes, partial(self._body, modes, between))

    def _body(self, modes: int, between: bool) -> Body:
        ratios = self._ratios()
        own = self.damping if ratios is None else ratios[:modes]
        body = self.reduce(modes, own, interfaces=self.interfaces if between else ())
        return replace(body, fidelity_levels=self)


def counted(modes: int, residual: int) -> str:
    """Free and residual modes in words."""
    if residual:
        return f"{modes} free and {residual} residual modes"
    return "1 mode" if modes == 1 else f"{modes} modes"
