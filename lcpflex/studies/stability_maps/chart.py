"""The picture of a stability map."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from lcpflex.basics import libs
from lcpflex.basics.arguments import sequence_of, text
from lcpflex.errors import ModelError
from lcpflex.jit.kernel import FloatArray
from lcpflex.studies.chart_style import axis_label
from lcpflex.studies.outcome import Outcome

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from lcpflex.studies.stability_maps.stability_map import StabilityMap

__all__ = ["chart", "draw_map", "outcome_legend"]

# After Okabe and Ito, told apart with any colour vision; the letters say the same without colours.
COLOURS = {
    Outcome.SOUND: "#5DBB7B",
    Outcome.RESOLVED: "#009E73",
    Outcome.NO_TROUBLE: "#D6F0DF",
    Outcome.WARNED: "#FBD9A0",
    Outcome.DRIFTING: "#F0E442",
    Outcome.UNEXPLAINED: "#E69F00",
    Outcome.GAINING: "#D55E00",
    Outcome.DIVERGED: "#222222",
    Outcome.WRONG: "#CC79A7",
    Outcome.SOLVER_FAILED: "#0072B2",
    Outcome.NO_SOLUTION: "#7B3294",
    Outcome.NOT_UNIQUE: "#56B4E9",
    Outcome.STOPPED: "#8C564B",
    Outcome.REFUSED: "#BBBBBB",
    Outcome.TOO_SLOW: "#E5E5E5",
    Outcome.NOT_RUN: "#FFFFFF",
}
DARK = (Outcome.GAINING, Outcome.DIVERGED, Outcome.SOLVER_FAILED, Outcome.NO_SOLUTION, Outcome.STOPPED)
MANY = 1000  # curves of a chart
LETTERED = 26  # cells along an axis up to which every cell carries its letter
NAMED = 6  # values of an axis up to which each has its tick
CURVES: tuple[Any, ...] = ("-", "--", ":", "-.")


def chart(chosen: StabilityMap, curves: Mapping[str, tuple[Sequence[float], Sequence[float]]]) -> Figure:
    """One panel a method side by side, and one legend."""
    count = len(chosen.methods)
    columns = min(count, 3)
    rows = math.ceil(count / columns)
    figure = libs.Figure(figsize=(1.0 + 4.2 * columns, 1.2 + 3.4 * rows), layout="constrained")
    panels = figure.subplots(rows, columns, squeeze=False, sharex=True, sharey=True)
    for ax in panels.ravel()[count:]:
        ax.set_visible(False)
    for k, (method, ax) in enumerate(zip(chosen.methods, panels.ravel(), strict=False)):
        draw_map(ax, chosen, method, curves)
        ax.label_outer()
        if k + columns >= count:  # the lowest of its column
            ax.tick_params(labelbottom=True)
            ax.set_xlabel(next(iter(chosen.axes)))
    figure.legend(handles=outcome_legend(chosen, curves=curves), loc="outside lower center", ncols=4, frameon=False)
    return figure


def draw_map(
    ax: Axes,
    chosen: StabilityMap,
    method: str,
    curves: Mapping[str, tuple[Sequence[float], Sequence[float]]] | None = None,
) -> None:
    """The cells of one method into axes of your own, with ``curves`` above them."""
    (first, columns), *second = chosen.axes.items()
    cells = chosen.of(method).reshape(len(columns), -1)
    kinds = list(Outcome)
    codes = np.array([[kinds.index(cell) for cell in row] for row in cells]).T
    x = _Scale(columns)
    y = _Scale(second[0][1] if second else ("",))
    x.prepare(ax.xaxis)
    y.prepare(ax.yaxis)
    colours = libs.ListedColormap([COLOURS[kind] for kind in kinds])
    fine = max(cells.shape) > LETTERED
    ax.pcolormesh(
        x.edges, y.edges, codes, cmap=colours, vmin=-0.5, vmax=len(kinds) - 0.5,
        edgecolors="none" if fine else "white", linewidth=0.0 if fine else 0.6,
    )  # fmt: skip
    if not fine:
        _letter(ax, cells, x.centers, y.centers)
    if curves and not (x.numeric and y.numeric):
        raise ModelError("curves: an axis of the map has values that are no numbers; expected no curves")
    for k, (across, up) in enumerate((curves or {}).values()):
        ax.plot(across, up, "k", linestyle=CURVES[k % len(CURVES)], linewidth=2.0)
    ax.set_xlim(x.edges[0], x.edges[-1])
    ax.set_ylim(y.edges[0], y.edges[-1])
    ax.set_xlabel(first)
    ax.set_ylabel(second[0][0] if second else "")
    ax.set_title(method, fontsize="medium", loc="left")


def outcome_legend(*maps: StabilityMap, curves: Iterable[str] = ()) -> list[Any]:
    """Handles for ``figure.legend``: a patch for each outcome that occurs in the maps, a line for each curve.

    curves: labels of lines that were drawn over the maps.
    """
    curves = sequence_of(
        "curves", list(curves) if isinstance(curves, Mapping) else curves, "a sequence of labels", MANY
    )
    curves = [text(f"curves[{i}]", label) for i, label in enumerate(curves)]
    present = {outcome for one in maps for outcome in one.outcomes.ravel().tolist()}
    handles: list[Any] = [
        libs.Patch(facecolor=COLOURS[kind], edgecolor="#666666", label=f"{kind.letter}  {kind.value}")
        for kind in Outcome
        if kind in present
    ]
    for k, label in enumerate(curves):
        handles.append(libs.Line2D([], [], color="k", linestyle=CURVES[k % len(CURVES)], linewidth=2.0, label=label))
    return handles


def _letter(ax: Axes, cells: Any, x: FloatArray, y: FloatArray) -> None:
    size = 9.0 if max(cells.shape) <= 14 else 6.5
    for i, j in np.ndindex(cells.shape):
        kind = cells[i, j]
        colour = "white" if kind in DARK else "black"
        ax.text(float(x[i]), float(y[j]), kind.letter, ha="center", va="center", fontsize=size, color=colour)


class _Scale:
    """Places of the values along an axis: their own where they are numbers in order, else 0, 1, 2, ..."""

    def __init__(self, values: Sequence[Any]) -> None:
        self.values = values
        self.numeric = all(isinstance(v, (int, float, np.number)) and not isinstance(v, bool) for v in values)
        places = np.asarray(values, dtype=float) if self.numeric else np.arange(len(values), dtype=float)
        steps = np.diff(places)
        self.numeric = self.numeric and len(values) > 1 and bool(np.all(steps > 0) or np.all(steps < 0))
        if not self.numeric:
            places = np.arange(len(values), dtype=float)
        self.log = self.numeric and spaced_logarithmically(places)
        self.centers = places
        self.edges = np.exp(_edges(np.log(places))) if self.log else _edges(places)

    def prepare(self, axis: Any) -> None:
        """Scale and ticks."""
        if self.log:
            axis.axes.set(**{f"{axis.axis_name}scale": "log"})
        if not self.numeric or len(self.centers) <= NAMED:
            axis.set_ticks([], minor=True)
            axis.set_ticks(self.centers, [axis_label(value) for value in self.values])


def spaced_logarithmically(values: FloatArray) -> bool:
    """Whether positive values spread more evenly in their logarithms."""
    if len(values) < 3 or values.min() <= 0.0:
        return bool(values.min() > 0.0 and values.max() / values.min() >= 10.0)
    linear, logarithmic = np.abs(np.diff(values)), np.abs(np.diff(np.log(values)))
    return bool(np.ptp(logarithmic) / logarithmic.mean() < np.ptp(linear) / linear.mean())


def _edges(places: FloatArray) -> FloatArray:
    """Borders of the cells: halfway between neighbours."""
    if len(places) == 1:
        return np.array([places[0] - 0.5, places[0] + 0.5])
    middle = 0.5 * (places[1:] + places[:-1])
    return np.concatenate([[2.0 * places[0] - middle[0]], middle, [2.0 * places[-1] - middle[-1]]])
