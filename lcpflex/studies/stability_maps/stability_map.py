"""The map of a stability study: outcomes over one or two parameters, for each method."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from lcpflex.basics.arguments import check_axes, unknown
from lcpflex.basics.whole_file import write_rows
from lcpflex.errors import ModelError, shown
from lcpflex.jit.kernel import FloatArray
from lcpflex.solvers.benchmark.comparison import as_markdown
from lcpflex.studies.chart_style import axis_label
from lcpflex.studies.given_functions import check_curves
from lcpflex.studies.outcome import Outcome
from lcpflex.studies.stability_maps.chart import chart, draw_map

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    Objects = NDArray[np.object_]

__all__ = ["StabilityMap"]


@dataclass(frozen=True, slots=True, eq=False)
class StabilityMap:
    """Outcomes of k methods over the values of one or two axes, n1 and n2 of them.

    Attributes
    ----------
    methods
        Their labels, k.
    axes
        Values by the name of each parameter; the first runs along x in tables and charts.
    outcomes
        (k, n1, n2) of :class:`Outcome`; (k, n1) with one axis.
    messages
        Of the same shape: why, empty where there is nothing to say.
    seconds
        Of the same shape: time spent on each cell, compilation included [s].
    errors
        Of the same shape: error relative to the truth; NaN where none was taken, or the run did not end.
    notes
        What the runs were compared with, and what else a reader must know.
    """

    methods: tuple[str, ...]
    axes: Mapping[str, tuple[Any, ...]]
    outcomes: Objects
    messages: Objects
    seconds: FloatArray
    errors: FloatArray
    notes: tuple[str, ...] = ()

    @property
    def complete(self) -> bool:
        """False after an interruption by Ctrl-C."""
        return not np.any(self.outcomes == Outcome.NOT_RUN)

    def of(self, method: str) -> Objects:
        """Outcomes of one method, (n1, n2) or (n1,). Raises ModelError for an unknown one."""
        if not isinstance(method, str) or method not in self.methods:
            raise ModelError(f"method: {unknown(method, self.methods)}")
        found: Objects = self.outcomes[self.methods.index(method)]
        return found

    def largest_sound(self, method: str) -> FloatArray:
        """Largest value of the first axis up to which every cell is sound, for each value of the second: (n2,).

        A paradox that is named and resolved is a success, too; what was compared with no truth is none, for that see
        :meth:`largest_untroubled`. NaN where not even the smallest is. Raises ModelError where the values are no
        numbers.

        method: its label.
        """
        return self._largest(method, (Outcome.SOUND, Outcome.RESOLVED))

    def largest_untroubled(self, method: str) -> FloatArray:
        """The same of cells that are sound or show no sign of trouble.

        method: its label.
        """
        return self._largest(method, (Outcome.SOUND, Outcome.RESOLVED, Outcome.NO_TROUBLE))

    def _largest(self, method: str, kinds: tuple[Outcome, ...]) -> FloatArray:
        name, values = next(iter(self.axes.items()))
        if not all(_is_number(value) for value in values):
            raise ModelError(f"axes: the values of {shown(name)} are no numbers and have no order; expected numbers")
        order = np.argsort(values)
        cells = _is_one_of(self.of(method).reshape(len(values), -1)[order], kinds)
        whole = np.logical_and.accumulate(cells, axis=0).sum(axis=0)
        ordered = np.concatenate([[np.nan], np.asarray(values, dtype=float)[order]])
        return np.asarray(ordered[whole])

    def table(self) -> str:
        """A table of Markdown for each method: the first axis along the columns, the second along the rows.

        Each cell has the outcome and, where a truth was taken, the error relative to it.
        """
        return "\n\n".join(f"**{method}**\n\n{self._table(method)}" for method in self.methods)

    def _cell(self, place: tuple[int, ...]) -> str:
        """The outcome, with the error relative to the truth where there is one."""
        error = float(self.errors[place])
        return f"{self.outcomes[place].value}{f' ({_percent(error)})' if np.isfinite(error) else ''}"

    def _table(self, method: str) -> str:
        (first, columns), *second = self.axes.items()
        k = self.methods.index(method)
        corner = f"{second[0][0]} \\ {first}" if second else first
        head = (corner, *(axis_label(value) for value in columns))
        rows = second[0][1] if second else ("",)
        lines: list[tuple[str, ...]] = [head]
        for j, row in enumerate(rows):
            places = [(k, i, j) if second else (k, i) for i in range(len(columns))]
            lines.append((axis_label(row), *(self._cell(place) for place in places)))
        return as_markdown(lines)

    def csv(self, path: str | os.PathLike[str]) -> Path:
        """Write one line a cell: method, the values of the axes, outcome, error, message, seconds.

        path: of the file.
        """
        rows: list[tuple[Any, ...]] = [("method", *self.axes, "outcome", "error", "message", "seconds")]
        for place in np.ndindex(self.outcomes.shape):
            values = (axis[i] for axis, i in zip(self.axes.values(), place[1:], strict=True))
            error = f"{self.errors[place]:.6g}" if np.isfinite(self.errors[place]) else ""
            outcome: Any = self.outcomes[place]
            told = (outcome.value, error, self.messages[place], f"{self.seconds[place]:.6g}")
            rows.append((self.methods[place[0]], *values, *told))
        return write_rows(path, rows, "\n")

    def plot(self, curves: Mapping[str, tuple[Sequence[float], Sequence[float]]] | None = None) -> Figure:
        """One panel a method, each cell in the colour and with the letter of its outcome.

        ``curves`` are drawn over every panel: x and y values by label, such as an exact boundary. Axes are logarithmic
        where their values are spaced so. Raises ModelError for curves over values that are no numbers.
        """
        return chart(self, check_curves("curves", curves))

    def draw(
        self,
        axes: Axes,
        method: str,
        curves: Mapping[str, tuple[Sequence[float], Sequence[float]]] | None = None,
    ) -> None:
        """The panel of one method into axes of your own; :func:`outcome_legend` gives the handles of a legend.

        curves: by label the places (x, y) of lines to draw over the map.
        """
        check_axes(axes, needed=True)
        draw_map(axes, self, method, check_curves("curves", curves))

    def __str__(self) -> str:
        """The counts of each method, where along the first axis it is sound or without trouble, and the notes."""
        notes = [f"Note: {note}." for note in self.notes]
        return "\n".join([*(line for method in self.methods for line in self._words(method)), *notes])

    def _words(self, method: str) -> Iterator[str]:
        cells = self.of(method)
        counts = Counter(cells.ravel().tolist())
        found = [f"{counts[outcome]} {outcome.value}" for outcome in Outcome if counts[outcome]]
        yield f"{method}: {', '.join(found)} ({cells.size} cells)"
        successes = [outcome for outcome in counts if outcome.success]
        if successes or not counts[Outcome.NO_TROUBLE]:
            yield from self._where("sound", cells, successes)
        if counts[Outcome.NO_TROUBLE]:
            yield from self._where(Outcome.NO_TROUBLE.value, cells, [Outcome.NO_TROUBLE])

    def _where(self, words: str, cells: Objects, kinds: Sequence[Outcome]) -> Iterator[str]:
        """For which values of the first axis the outcome is one of ``kinds``, a line for equal rows."""
        (first, values), *second = self.axes.items()
        rows = second[0][1] if second else (None,)
        marked = _is_one_of(cells.reshape(len(values), -1), kinds)
        ranges = [(row, _ranges(values, marked[:, j])) for j, row in enumerate(rows)]
        for where, group in groupby(ranges, key=lambda entry: entry[1]):
            members = [row for row, _ in group]
            at = f" at {second[0][0]} {_span(members)}" if second and len(members) < len(rows) else ""
            yield f"  {words} for {first} {where}{at}"


def _is_one_of(cells: Objects, kinds: Sequence[Outcome]) -> NDArray[np.bool_]:
    return np.array([cell in kinds for cell in cells.ravel()], dtype=bool).reshape(cells.shape)


def _percent(value: float) -> str:
    return f"{100.0 * value:.2g} %"


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float, np.integer, np.floating)) and not isinstance(value, bool)


def _span(members: Sequence[Any]) -> str:
    if len(members) == 1:
        return axis_label(members[0])
    return f"{axis_label(members[0])} to {axis_label(members[-1])}"


def _ranges(values: Sequence[Any], sound: NDArray[np.bool_]) -> str:
    """Runs of sound values in words; "nowhere" and "everywhere" at the ends."""
    if sound.all():
        return "everywhere"
    if not sound.any():
        return "nowhere"
    runs, start = [], 0
    for good, group in groupby(sound.tolist()):
        end = start + len(list(group))
        if good and start == 0:
            runs.append(f"up to {axis_label(values[end - 1])}")
        elif good and end == len(values):
            runs.append(f"from {axis_label(values[start])} on")
        elif good:
            runs.append(_span(values[start:end]))
        start = end
    return " and ".join(runs)
