"""Performance profiles: how often a solver is within a factor of the fastest, over many problems at once.

rho_s(tau) = |{p : t_ps <= tau min_s t_ps}| / n_p, with t_ps = inf where solver s neither solved problem p
nor proved that nothing does (Dolan & More, "Benchmarking optimization software with performance profiles", Math.
Program. 91, 2002). At tau = 1 it is the share of problems on which s is fastest, for large tau the share it solves.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from lcpflex.basics import libs
from lcpflex.basics.arguments import check_axes
from lcpflex.errors import ModelError
from lcpflex.jit.kernel import FloatArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["draw_profile", "performance_profile"]

# Okabe and Ito's colours, told apart with any colour vision; the order of the lines, their strokes and their markers
# tell them apart without any.
_COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
_STROKES: tuple[Any, ...] = ("-", (0, (6, 2)), (0, (2, 1)), (0, (6, 2, 1, 2)), (0, (10, 3)))
_MARKERS = "os^Dv<>PX*"


def performance_profile(times: npt.ArrayLike, factors: npt.ArrayLike) -> FloatArray:
    """rho (solvers, k): the share of problems each solver solves within the ``factors`` (k,) >= 1 of the fastest.

    times (solvers, problems) [s], inf where it was not solved; what nobody solved counts against all. Raises
    ModelError for other shapes, no problem at all, and times that are NaN or not positive.
    """
    measured, tau = np.asarray(times, dtype=float), np.asarray(factors, dtype=float)
    if measured.ndim != 2 or not measured.size:
        raise ModelError(f"times has shape {measured.shape}: expected (solvers, problems), at least one of each")
    if not (measured > 0.0).all():
        raise ModelError("times holds numbers that are NaN or <= 0: expected seconds > 0, inf where it was not solved")
    if tau.ndim != 1 or not (tau >= 1.0).all():
        raise ModelError(f"factors is {tau}: expected numbers >= 1, shape (k,)")
    within: FloatArray = np.mean(_ratios(measured)[:, :, None] <= tau, axis=1)
    return within


def _ratios(times: FloatArray) -> FloatArray:
    """t_ps / min_s t_ps, inf where it was not solved."""
    ratios = np.full_like(times, np.inf)
    np.divide(times, times.min(axis=0), out=ratios, where=np.isfinite(times))
    return ratios


def draw_profile(names: Sequence[str], times: npt.ArrayLike, axes: Axes | None = None) -> Figure:
    """Draw the profiles of ``times`` (solvers, problems) [s] over tau, the axis logarithmic to base 2.

    The key beside the chart lists the solvers from the best (largest area below the line) to the worst, with the share
    they solved; those that solved nothing are named at its end. axes: draw into these. Raises ModelError as
    :func:`performance_profile` does, and for another number of names than rows.
    """
    check_axes(axes)
    measured = np.asarray(times, dtype=float)
    performance_profile(measured, np.ones(1))
    if len(names) != len(measured):
        raise ModelError(f"names has {len(names)} entries: expected {len(measured)}, one for each row of times")
    if axes is None:
        axes = libs.Figure(figsize=(9.0, 4.5), layout="constrained").subplots()
    ratios = _ratios(measured)
    known = ratios[np.isfinite(ratios)]
    largest = 1.3 * max(2.0, float(known.max(initial=1.0)))
    areas = [_area(row, largest) for row in ratios]
    order = [int(s) for s in np.argsort(-np.array(areas), kind="stable") if np.isfinite(ratios[s]).any()]
    for place, s in enumerate(order):
        _draw_line(axes, ratios[s], largest, names[s], s, (place + 0.5) / len(order))
    _set_out(axes, largest, [names[s] for s in range(len(names)) if s not in order])
    return axes.get_figure(root=True)  # type: ignore[return-value]


def _area(ratios: FloatArray, largest: float) -> float:
    """Below the profile, over log tau."""
    return float(np.log(largest / np.minimum(ratios, largest)).mean())


def _draw_line(axes: Axes, ratios: FloatArray, largest: float, name: str, look: int, height: float) -> None:
    """The line of one solver. look: number of its style, the same in every chart of these solvers."""
    solved = np.sort(ratios[np.isfinite(ratios)])
    # Lines often lie on top of each other: each shows its marker on its rise and beyond where no other line has one.
    spots = np.array([solved[int(height * len(solved))], largest ** (0.4 + 0.6 * height)])
    tau = np.unique(np.concatenate([[1.0, largest], solved, spots]))
    share = np.searchsorted(solved, tau, side="right") / len(ratios)
    axes.step(
        tau,
        share,
        where="post",
        label=f"{name}, {100.0 * share[-1]:.0f} %",
        color=_COLOURS[look % len(_COLOURS)],
        linestyle=_STROKES[look % len(_STROKES)],
        marker=_MARKERS[look % len(_MARKERS)],
        markevery=[int(k) for k in np.unique(np.searchsorted(tau, spots)) if share[k] > 0.0],
        markersize=6.5,
        linewidth=1.8,
        zorder=4.0 - height,
        clip_on=False,
    )


def _set_out(axes: Axes, largest: float, without: Sequence[str]) -> None:
    axes.set_xscale("log", base=2)
    axes.set(xlim=(1.0, largest), ylim=(0.0, 1.02))
    axes.set_xlabel(r"time, in multiples $\tau$ of the fastest solver's")
    axes.set_ylabel(r"share of problems solved within $\tau$")
    axes.yaxis.set_major_formatter(lambda value, _: f"{100.0 * value:.0f} %")
    axes.xaxis.set_major_formatter(lambda value, _: f"{value:g}")
    axes.grid(True, linewidth=0.4, alpha=0.5)
    handles = axes.get_legend_handles_labels()[0]
    if without:
        handles.append(libs.Line2D([], [], linestyle="none", label="nothing:\n" + ",\n".join(without)))
    axes.legend(
        handles=handles,
        loc="upper left",
        bbox_to_anchor=(1.02, 1.0),
        borderaxespad=0.0,
        frameon=False,
        title="solved, best first",
        alignment="left",
        handlelength=4.0,
    )
