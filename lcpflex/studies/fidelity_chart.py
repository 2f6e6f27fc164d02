"""The picture of a study of fidelity: error against cost."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from lcpflex.studies.fidelity_report import FidelityRun, RightSize

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["chart"]

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
MARKERS = "osD^vP"
GOOD = "#E3F1E3"
LEAST = 1e-8  # smallest error drawn


def chart(study: RightSize) -> Figure:
    """Estimated error of each output against wall time; the band holds what is within the tolerance."""
    from matplotlib.figure import Figure
    from matplotlib.ticker import LogFormatter

    figure = Figure(figsize=(9.0, 5.2), layout="constrained")
    ax = figure.subplots()
    ax.set(
        xscale="log", yscale="log", xlabel="wall time of a run [ms]", ylabel="estimated error, relative to full mesh"
    )
    sound = [run for run in study.runs if run.errors and math.isfinite(run.estimate)]
    low, high = _range(study, sound)
    ceiling = high * (high / low) ** 0.1
    ax.set_ylim(low, ceiling)
    ax.axhspan(low, study.tolerance, color=GOOD, zorder=0.5, linewidth=0.0)
    ax.axhline(study.tolerance, color="#5B9A5B", linewidth=1.0, zorder=1.0)
    outputs = tuple(dict.fromkeys(name for run in sound for name in run.errors))
    for k, name in enumerate(outputs):
        points = sorted((1e3 * run.wall_time, max(run.errors[name], low)) for run in sound if name in run.errors)
        ax.plot(
            *zip(*points, strict=True), linestyle="none", markersize=6.5, label=name, zorder=3.0,
            color=COLOURS[k % len(COLOURS)], marker=MARKERS[k % len(MARKERS)],
        )  # fmt: skip
    for run in study.runs:
        if run.failure and math.isfinite(run.wall_time):
            ax.plot(1e3 * run.wall_time, high, "x", color="#666666", markersize=8.0, markeredgewidth=1.8, zorder=3.0)
    _name(ax, study, sound, low)
    if math.isfinite(study.full):
        known = "measured" if study.full_was_run else "predicted"
        ax.axvline(1e3 * study.full, color="#999999", linewidth=1.0, linestyle=":", label=f"full mesh, {known}")
    if any(run.failure for run in study.runs):
        ax.plot([], [], "x", color="#666666", label="failed")
    ax.grid(True, which="major", linewidth=0.4, alpha=0.6)
    ax.text(0.01, study.tolerance, f" tolerance {100.0 * study.tolerance:.2g} %", transform=ax.get_yaxis_transform(),
            va="bottom", fontsize="small", color="#3B7A3B")  # fmt: skip
    bodies = " / ".join(study.runs[0].rungs)
    ax.legend(loc="upper right", fontsize="small", title=f"labels: modes of {bodies}", title_fontsize="small")
    for axis in (ax.xaxis.set_major_formatter, ax.xaxis.set_minor_formatter):
        axis(LogFormatter(minor_thresholds=(2.0, 0.5)))
    ax.set_title("\n".join(_wrapped(study.sentence())), fontsize="medium", loc="left")
    return figure


def _range(study: RightSize, sound: list[FidelityRun]) -> tuple[float, float]:
    values = [error for run in sound for error in run.errors.values() if LEAST < error < math.inf]
    known = [*values, study.tolerance]
    return 10.0 ** math.floor(math.log10(0.5 * min(known))), 10.0 ** math.ceil(math.log10(1.5 * max(known)))


def _name(ax: Axes, study: RightSize, sound: list[FidelityRun], low: float) -> None:
    """Rungs over the worst error of each run; the chosen one is marked."""
    for run in sound:
        at = (1e3 * run.wall_time, max(run.estimate, low))
        if run.chosen:
            ax.plot(*at, "o", markersize=17.0, markerfacecolor="none", markeredgecolor="#000000", zorder=4.0)
        ax.annotate(
            " / ".join(_short(rung) for rung in run.rungs.values()), at, xytext=(3.0, 10.0 if run.chosen else 6.0),
            textcoords="offset points", fontsize="x-small", rotation=35.0, rotation_mode="anchor",
            fontweight="bold" if run.chosen else "normal",
        )  # fmt: skip


def _short(rung: str) -> str:
    return rung.removesuffix(" modes").removesuffix(" mode").removesuffix(" mesh")


def _wrapped(text: str) -> list[str]:
    import textwrap

    return textwrap.wrap(text, 95)
