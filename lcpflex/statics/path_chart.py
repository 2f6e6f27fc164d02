"""Chart of a row of rests: force over travel, with arrows that go with the path."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from lcpflex.basics import libs
from lcpflex.basics.arguments import check_axes
from lcpflex.results.chart_words import told_apart
from lcpflex.results.words import prefix_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from lcpflex.jit.kernel import FloatArray
    from lcpflex.statics.equilibrium_path import EquilibriumPath

__all__ = ["plot_path"]

# Okabe and Ito's colours, told apart with any colour vision.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
WAYS = ((1.0, "-", "rising values"), (-1.0, "--", "falling values"))
EVERY = 0.12  # of the chart along the path: between two arrows
SMALLEST = 0.004  # of it: a step that is shorter has none
HEAD = 0.49, 0.51  # of a step: from where to where its arrow goes
SHOWN = len(COLOURS)  # contacts of a chart of scenes: those with the largest forces


def plot_path(path: EquilibriumPath, axes: Axes | None) -> Figure:
    """See :meth:`lcpflex.statics.equilibrium_path.EquilibriumPath.plot`."""
    check_axes(axes)
    if axes is None:
        axes = libs.Figure(figsize=(7.0, 4.6), layout="constrained").subplots()
    curve = path.curve()
    way, jumps = np.sign(np.diff(curve.values)), curve.jumps
    if path.force is not None:
        x, of_x = _scaled(curve.travel, path.units["travel"])
        y, of_y = _scaled(curve.force, path.units["force"])
        _draw(axes, x, y, way, jumps, COLOURS[:2], [words for _, _, words in WAYS])
        what = "rotation" if path.units["travel"] == "rad" else "travel"
        axes.set(
            xlabel=f"{what} of {path.drive} [{of_x}]",
            ylabel=f"force [{of_y}]" if what == "travel" else f"torque [{of_y}]",
        )
    else:
        _draw_contacts(axes, path)
    axes.grid(True, linewidth=0.4, alpha=0.5)
    axes.legend(frameon=False, fontsize="small")
    if not path.complete:
        axes.set_title(f"ends after {len(path)} of {len(path.asked)} values", fontsize="medium", loc="left")
    return axes.get_figure(root=True)  # type: ignore[return-value]


def _draw_contacts(axes: Axes, path: EquilibriumPath) -> None:
    """Normal forces of the contacts over the values of scenes."""
    forces = {one.name: path.contact(one.name).normal for one in path.rests[0].contacts}
    shown = sorted(forces, key=lambda name: -float(forces[name].max()))[:SHOWN]
    largest = max((float(forces[name].max()) for name in shown), default=0.0)
    factor, prefix = prefix_of(largest)
    way = np.sign(np.diff(path.values))
    for name, words, colour in zip(shown, told_apart(shown), COLOURS, strict=False):
        y = forces[name] / factor
        _draw(axes, path.values, y, way, np.zeros(len(way), bool), (colour, colour), [words, words])
    axes.set(xlabel="value", ylabel=f"normal force [{prefix}N]")
    axes.set_ylim(bottom=0.0)


def _scaled(values: FloatArray, unit: str) -> tuple[FloatArray, str]:
    """In a unit in which they read well; angles stay in rad."""
    factor, prefix = prefix_of(float(np.abs(values).max(initial=0.0))) if unit != "rad" else (1.0, "")
    return values / factor, f"{prefix}{unit}"


def _draw(
    axes: Axes,
    x: FloatArray,
    y: FloatArray,
    way: FloatArray,
    jumps: Any,
    colours: Sequence[str],
    labels: list[str],
) -> None:
    """A curve: solid where the values rise, dashed where they fall, dotted where it jumps; arrows go along it."""
    axes.plot(x[:1], y[:1], "o", color=colours[0], markersize=4)
    named: set[str] = set()
    for (sign, style, _), colour, label in zip(WAYS, colours, labels, strict=True):
        on = (way == sign) & ~jumps
        if on.any():
            dots: dict[str, Any] = {"marker": ".", "markersize": 4, "label": "" if label in named else label}
            axes.plot(*_pieces(x, y, on), style, color=colour, linewidth=1.4, **dots)
            named.add(label)
    if jumps.any():
        axes.plot(*_pieces(x, y, jumps), ":", color="#202020", linewidth=1.4, label="jump")
    step = np.hypot(np.diff(x) / (np.ptp(x) or 1.0), np.diff(y) / (np.ptp(y) or 1.0))
    along, due = 0.0, 0.5 * EVERY
    for k, length in enumerate(step.tolist()):
        along += length
        if along >= due and length > SMALLEST:
            due = along + EVERY
            ends = [(x[k] + share * (x[k + 1] - x[k]), y[k] + share * (y[k + 1] - y[k])) for share in HEAD]
            colour = "#202020" if jumps[k] else colours[0 if way[k] >= 0.0 else 1]
            head = {"arrowstyle": "-|>", "color": colour, "shrinkA": 0, "shrinkB": 0}
            axes.annotate("", xy=ends[1], xytext=ends[0], arrowprops=head)


def _pieces(x: FloatArray, y: FloatArray, on: Any) -> tuple[FloatArray, FloatArray]:
    """The steps that are ``on``, each with both ends, and nothing between them."""
    k = np.flatnonzero(on)
    none = np.full(len(k), np.nan)
    return np.column_stack([x[k], x[k + 1], none]).ravel(), np.column_stack([y[k], y[k + 1], none]).ravel()
