"""What is said of a run while it is under way."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from time import perf_counter
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from lcpflex.runs.setup import Run

__all__ = ["RunWords"]

NAMED = 60  # characters of the name of a contact


class RunWords:
    """How far a run has come, how fast it goes, and which contact keeps it busy: of the time since the words before.

    name: of a declared contact by its number.
    """

    def __init__(self, run: Run, duration: float, name: Callable[[int], str]) -> None:
        self._run, self._duration, self._name = run, duration, name
        self._mark()

    def __call__(self) -> str:
        """In one line."""
        run, (clock, time, steps, events) = self._run, self._before
        self._mark()
        spent = max(self._before[0] - clock, 1e-9)
        rate = (run.time - time) / spent
        left = f", {(self._duration - run.time) / rate:.2g} s to go at this rate" if rate > 0.0 else ""
        share = 100.0 * run.time / self._duration
        at = f"t = {run.time:.6g} s of {self._duration:g} s ({share:.2g} %){left}"
        made = f"{run.steps} steps, {(run.steps - steps) / spent:.3g} a second"
        return f"{at}; {made}; {self._contacts(events, spent)}"

    def _mark(self) -> None:
        """What the next words count from."""
        run = self._run
        self._before = perf_counter(), run.time, run.steps, len(run.events)

    def _contacts(self, first: int, spent: float) -> str:
        """Of the events since the ``first`` one; of a run that locates none, how many contacts are closed."""
        new = self._run.events[first:]
        count = Counter(law for _, _, law, _ in new if law >= 0)
        if not count:
            touching = len(self._run.touching)
            return f"{touching} contact{'' if touching == 1 else 's'} closed" if not new else f"{len(new)} events"
        law, most = count.most_common(1)[0]
        busiest = f"{100.0 * most / len(new):.0f} % of them at contact {self._name(law)[:NAMED]!r}"
        return f"{len(new) / spent:.3g} events a second, {busiest}"
