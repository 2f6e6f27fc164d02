"""A case with its quantities, and what each stepper makes of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TypeAlias

from lcpflex.gallery.acceptance.bounds import BOUNDS
from lcpflex.results.result import Result
from lcpflex.runs.case import Case
from lcpflex.runs.simulate import Stepper, simulate

__all__ = ["ROUNDING", "Absent", "Check", "Entries", "Entry", "Quantity", "Refused"]

ROUNDING = 1e-9  # errors below it are rounding, or the last printed digit of the reference: 0 in the table


@dataclass(frozen=True, slots=True)
class Quantity:
    """A number taken from a result, and what it must be.

    ``scale`` divides the error, |reference| where it is None; 0 is not allowed.
    """

    name: str
    reference: float
    unit: str
    measure: Callable[[Result], float]
    scale: float | None = None
    instant: bool = False  # one of the stored ones: known to their interval

    def error(self, result: Result) -> float:
        """|measured - reference| / scale."""
        return abs(self.measure(result) - self.reference) / (self.scale or abs(self.reference))


@dataclass(frozen=True, slots=True)
class Entry:
    """A stepper that applies, and why its errors are large where they are."""

    stepper: Stepper
    why: str = ""
    slow: bool = False  # seconds a run


@dataclass(frozen=True, slots=True)
class Refused:
    """A stepper that refuses the case with a ModelError that contains ``message``."""

    stepper: Stepper
    message: str
    why: str


@dataclass(frozen=True, slots=True)
class Absent:
    """A stepper that solves another problem here: the run warns with ``warning``, or nothing can be compared."""

    why: str
    stepper: Stepper | None = None
    warning: str = ""


Entries: TypeAlias = Mapping[str, Entry | Refused | Absent]


@dataclass(frozen=True, slots=True)
class Check:
    """One case of the gallery with its quantities, and what each stepper makes of it."""

    case: Case
    quantities: tuple[Quantity, ...]
    entries: Entries
    duration: float | None = None  # [s], that of the case if omitted
    record: float | None = None  # [s]
    name: str = field(default="")

    @property
    def label(self) -> str:
        """Name in the table."""
        return self.name or self.case.name

    def bounds(self, stepper: str) -> tuple[float, ...]:
        """What the errors of the quantities, in their order, must not exceed with the stepper of that label."""
        return BOUNDS[self.label, stepper]

    def floor(self, quantity: Quantity) -> float:
        """Error that rounding, or the interval between stored instants, may make."""
        interval = self.record if quantity.instant and self.record else 0.0
        return max(ROUNDING, 1.01 * interval / (quantity.scale or abs(quantity.reference)))

    def run(self, stepper: Stepper) -> Result:
        """The case with that stepper."""
        duration = self.case.duration if self.duration is None else self.duration
        return simulate(self.case.build(), duration, stepper, record=self.record, progress=False)
