"""Contact problems solved as well as rounding allows, and yet not to the tolerance: a run goes on, and says so.

Between wedged bodies, and where masses differ by many orders, large forces cancel in small velocities. What rounding
leaves of them may be more of the free velocity than a residual is allowed to be; no method then finds a better answer.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from lcpflex.jit.kernel import FloatArray
from lcpflex.solvers.certificate import ROUNDING, strict_residual, terms_residual
from lcpflex.solvers.contact.memory import ContactData, SolverMemory
from lcpflex.solvers.contact.posed import measured
from lcpflex.steppers.named import listed

__all__ = ["Wedged"]


class Wedged:
    """The answers that a run had to go on with: how many, since when, where, and how wrong."""

    def __init__(self) -> None:
        self.count, self.first, self.last = 0, math.nan, math.nan
        self.laws: list[int] = []
        self.strict, self.terms = 0.0, 0.0

    def best(
        self, data: ContactData, memory: SolverMemory, points: list[FloatArray], tolerance: float
    ) -> FloatArray | None:
        """The best of some points z (m,) for the LCP of a contact problem; None if no one is right by its terms."""
        chosen, least, terms = None, math.inf, 0.0
        for z, (worst, size, load) in zip(points, measured(data, memory, *points), strict=True):
            worst = max(worst, ROUNDING * size)  # w is not known any better
            strict = strict_residual(worst, load)
            if terms_residual(worst, size, load) <= tolerance and strict < least:
                chosen, least, terms = z, strict, worst / size
        if chosen is not None:
            self.strict, self.terms = max(self.strict, least), max(self.terms, terms)
        return chosen

    def note(self, data: ContactData, at: float) -> None:
        """Count the problem of the step or instant that begins at time ``at`` [s]."""
        self._count({int(law) for law in data.pair[: data.n_contacts]}, at)

    def note_light(self, data: ContactData, memory: Any, at: float) -> None:
        """The same, where what was found is right as a whole; named is the contact that has most of its load left."""
        self.strict, self.terms = max(self.strict, memory.missed), max(self.terms, memory.residual)
        self._count({int(data.pair[memory.behind])}, at)

    def _count(self, laws: set[int], at: float) -> None:
        if self.count == 0:
            self.first = at
            self.laws = sorted(laws)
        if at != self.last:
            self.count, self.last = self.count + 1, at

    def remarks(self, name: Callable[[int], str]) -> list[str]:
        """The warning, if there were any."""
        if not self.count:
            return []
        often = "one step" if self.count == 1 else f"{self.count:,} steps"
        return [
            f"in {often}, first at t = {self.first:.9g} s, the contact problem was solved as well as rounding allows "
            f"(to {self.terms:.1e} of the terms that cancel in it), which leaves up to {self.strict:.1e} of the "
            "velocity that its contacts would have without their forces: bodies are wedged, or their masses far apart "
            f"({listed(self.laws, name)})"
        ]
