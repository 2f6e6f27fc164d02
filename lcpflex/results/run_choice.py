"""How a run to a tolerance was chosen: what was tried, what it cost, what bears it out.

See ``tolerance=`` of :func:`lcpflex.simulate`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

__all__ = ["RunChoice", "RunTrial"]

HEADS = ("method", "modes", "steps", "events", "work", "apart", "from", "remark")


@dataclass(frozen=True, slots=True)
class RunTrial:
    """One run that was made.

    Attributes
    ----------
    stepper
        Its ``repr``, without what is as by default.
    modes
        Modes of all bodies that were chosen, without the residual ones that follow from what acts on them.
    steps, events
        Made in all.
    work
        Steps and events, each times what one costs and in proportion to the coordinates, and what a run takes to begin:
        about the number of steps of ``MoreauJean`` that take as long. Counted: the same on every machine.
    difference
        To the run that it was compared with, in the measure of the choice; None where it was compared with none.
    other
        Number of that run, from 1; 0: none.
    ended
        Why it stopped before the end; empty where it did not.
    """

    stepper: str
    modes: int
    steps: int
    events: int
    work: float
    difference: float | None = None
    other: int = 0
    ended: str = ""


@dataclass(frozen=True, slots=True)
class RunChoice:
    """What a run to a tolerance has tried, and why it ended with the run that it returned; ``str()`` is a table.

    Attributes
    ----------
    tolerance
        Asked for.
    measure
        What differences are relative to, in words.
    claimed
        Error that the run returned may have, in that measure: at most the tolerance, or larger in a run that an error
        carries.
    modes
        Part of it that is due to modes; None where none was varied.
    outputs
        By name of an output, what was found of it; empty where places are measured.
    trials
        Every run, in order.
    chosen
        Number of the run returned, from 1; 0: none.
    why
        Why it is this one.
    confirmed
        Which method confirms it, and how closely.
    notes
        What is to be known beside: how closely functions of time were looked at, what was left as it is.
    """

    tolerance: float
    measure: str
    claimed: float
    modes: float | None
    trials: tuple[RunTrial, ...]
    chosen: int
    why: str
    confirmed: str
    outputs: Mapping[str, float] = field(default_factory=dict)
    notes: tuple[str, ...] = ()

    @property
    def work(self) -> float:
        """Of all runs."""
        return sum(one.work for one in self.trials)

    @property
    def modes_tried(self) -> tuple[int, ...]:
        """Numbers of modes, from the fewest on."""
        return tuple(sorted({one.modes for one in self.trials}))

    def __str__(self) -> str:
        rows = [HEADS, *(_row(number, one, number == self.chosen) for number, one in enumerate(self.trials, 1))]
        widths = [max(len(row[k]) for row in rows) for k in range(len(HEADS))]
        lines = []
        for number, row in enumerate(rows):
            line = "  ".join(
                text.ljust(width) if k in (0, len(HEADS) - 1) else text.rjust(width)
                for k, (text, width) in enumerate(zip(row, widths, strict=True))
            )
            lines.append(f"{number if number else ' ':>2} {line}".rstrip())
        asked = f"{self.tolerance:.3g} asked for, {self.claimed:.2g} claimed, of {self.measure}"
        for name, value in self.outputs.items():
            asked += f"; {name} {value:.2g}"
        if self.modes is not None:
            asked += f"; modes {self.modes:.2g} of it"
        told = (asked, f"why: {self.why}" if self.why else "", self.confirmed, *self.notes)
        return "\n".join([*lines, *(text for text in told if text)])


def _row(number: int, one: RunTrial, chosen: bool) -> tuple[str, ...]:
    apart = "" if one.difference is None else f"{one.difference:.2g}"
    remark = "returned" if chosen else one.ended[:60]
    other = str(one.other) if one.other else ""
    return one.stepper, str(one.modes), str(one.steps), str(one.events), f"{one.work:.0f}", apart, other, remark
