"""The choice of fidelity levels of a body that is known by its modes: rigid, 1, 2, 4, ... of them, the full mesh."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from lcpflex.bodies.body import FidelityLevel
from lcpflex.bodies.reduction.damping import Damping, Rayleigh

__all__ = ["MOST_MODES", "STATIC", "ModeLevels", "counted"]

NEAR = 1.4  # the last level below the full mesh has fewer modes than that by this factor: else it is hardly cheaper
MOST_MODES = 128  # of the levels between rigid and the full mesh of a body that has very many
STATIC = ("interfaces", "contact", "boundary")  # options of reductions that add static shapes to the modes


@dataclass(frozen=True, slots=True, eq=False)
class ModeLevels:
    """Gives the levels rigid, then 1, 2, 4, ... and all ``available`` modes.

    Attributes
    ----------
    available : number of modes of the mesh
    reduce : makes the body with so many modes, that damping, and the options ``static``
    static : options of the body that is given by which it has static shapes besides: ``interfaces``, in space
        ``contact`` and ``boundary``, too
    damping : of the body that is given. Where it is a ratio for each of its modes, the levels end with these: of the
        damping of others nothing is known.
    residual : number of static shapes that every level between rigid and the full mesh has besides
    most : modes of the levels between
    ends : whether the levels end with the full mesh; with ``most`` modes of a mesh that is too large for it
    """

    available: int
    reduce: Callable[..., Any]  # a Body, or a SpatialBody
    static: Mapping[str, Any]
    damping: Damping | None
    residual: int = 0
    most: float = math.inf
    ends: bool = True

    def __call__(self) -> tuple[FidelityLevel, ...]:
        """The levels."""
        ratios = self._ratios()
        known = self.available if ratios is None else len(ratios)
        counts = [0]
        step = 1
        while NEAR * (step + self.residual) < known and step <= self.most:
            counts.append(step)
            step *= 2
        if self.ends or ratios is not None:
            counts.append(known)
        return tuple(self._level(modes) for modes in dict.fromkeys(counts))

    def _ratios(self) -> np.ndarray[Any, Any] | None:
        """One damping ratio for each mode, if it was given so."""
        if self.damping is None or isinstance(self.damping, Rayleigh) or np.ndim(self.damping) != 1:
            return None
        return np.asarray(self.damping, dtype=float)

    def _level(self, modes: int) -> FidelityLevel:
        between = 0 < modes < self.available
        name = self._between(modes) if between else "full mesh" if modes else "rigid"
        return FidelityLevel(name, modes + self.residual if between else modes, partial(self._body, modes, between))

    def _between(self, modes: int) -> str:
        if self.static.get("boundary") is None:
            return counted(modes, self.residual)
        return f"{counted(modes, 0)} and {self.residual} of the boundary"

    def _body(self, modes: int, between: bool) -> Any:
        ratios = self._ratios()
        own = self.damping if ratios is None else ratios[:modes]
        body = self.reduce(modes, own, **(self.static if between else {}))
        return replace(body, fidelity_levels=self)


def counted(modes: int, residual: int) -> str:
    """Free and residual modes in words."""
    if residual:
        return f"{modes} free and {residual} residual modes"
    return "1 mode" if modes == 1 else f"{modes} modes"
