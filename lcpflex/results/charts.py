"""Charts of a result over time: forces, gaps and energies."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from lcpflex.basics import libs
from lcpflex.errors import ModelError
from lcpflex.jit.kernel import FloatArray, IntArray
from lcpflex.results.chart_words import stepper_words, told_apart
from lcpflex.results.motion_units import scene_size
from lcpflex.results.spatial.motion_panels import bodies_shown, plot_speeds, plot_spins
from lcpflex.results.summary import lost_in_contacts
from lcpflex.results.words import prefix_of, with_unit

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from lcpflex.results.result import Result

__all__ = ["plot", "shown_forces"]

# Okabe and Ito's colours, told apart with any colour vision.
_COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
_SHOWN = 6  # contacts drawn in a chart; of more, those with the largest impulses
_MANY = 5  # panels, from which on each is lower
_RARE = 0.05  # share of the instants with contact whose forces may be cut in a chart
_PEAK = 2.5  # times the largest of the others, from which on they are
_WIDE = 0.25  # of the largest force shown, from which on the band of its error is left out
_NOTHING = 1e-7  # a share of the peak that is no force beside it
_ROUNDING = 1e-9  # gaps below that share of the scene are not magnified


def plot(result: Result) -> Figure:
    """Chart of contact forces [N], gaps [m] and energies [J] over time [s].

    Of many contacts those with the largest normal impulses are shown, in space with the size of their friction. Of
    spatial scenes velocities [m/s] and angular velocities [rad/s], too: of one body their components, of several their
    magnitudes, of many those of the bodies with the largest kinetic energies.
    """
    if not result.times.size:
        raise ModelError("result: it holds no instant; expected at least one")
    order = np.argsort(-result.impulse[-1, :, 0], kind="stable")[:_SHOWN] if result.contact_names else np.zeros(0, int)
    panels = [(_plot_forces, order), (_plot_gaps, order)] if order.size else []
    left_out = [(len(result.contact_names) - order.size, "contacts with smaller impulses")]
    if result.compiled is not None and result.compiled.spatial:
        bodies = bodies_shown(result, _SHOWN)
        panels += [(_plot_speeds, bodies), (_plot_spins, bodies)]
        left_out += [(len(result.compiled.layout.bodies) - bodies.size, "bodies with smaller kinetic energies")]
    panels += [(_plot_energies, order)]
    figure = libs.Figure(figsize=(9.0, 1.2 + (2.5 if len(panels) < _MANY else 2.1) * len(panels)), layout="constrained")
    axes = figure.subplots(len(panels), 1, sharex=True, squeeze=False)[:, 0]
    for (panel, shown), ax in zip(panels, axes, strict=True):
        panel(ax, result, shown)
        if result.error is not None and not result.error.whole:
            _end(ax, result.error.horizon, float(result.times[-1]))
        ax.grid(True, linewidth=0.4, alpha=0.5)
        ax.margins(x=0.0)
        ax.legend(loc="upper left", bbox_to_anchor=(1.01, 1.0), borderaxespad=0.0, frameon=False, fontsize="small")
    axes[-1].set_xlabel("time [s]")
    title = stepper_words(result.stepper)
    if result.error is not None:
        title += "\nshaded: by how much a curve may be off, forces where no impact is near"
    hidden = " and ".join(f"{count} {what}" for count, what in left_out if count > 0)
    if hidden:
        title += f"\n{hidden} are not shown"
    axes[0].set_title(title, fontsize="medium", loc="left")
    return figure


def _end(ax: Axes, horizon: float, last: float) -> None:
    """Mark the time from which on the run may have parted from the motion of the scene."""
    ax.axvspan(horizon, last, color="#888888", alpha=0.15, linewidth=0.0)
    ax.axvline(horizon, color="#888888", linewidth=0.8, label="not known to hold\nfrom here on")


def _band(ax: Axes, result: Result, values: FloatArray, off: FloatArray | float, colour: str) -> None:
    """Shade by how much a curve may be off; ``off`` at the times of the error, or one number."""
    if result.error is None:
        return
    wide = np.interp(result.times, result.error.times, off) if isinstance(off, np.ndarray) else off
    ax.fill_between(result.times, values - wide, values + wide, color=colour, alpha=0.2, linewidth=0.0)


def _plot_speeds(ax: Axes, result: Result, order: IntArray) -> None:
    plot_speeds(ax, result, order, _COLOURS)


def _plot_spins(ax: Axes, result: Result, order: IntArray) -> None:
    plot_spins(ax, result, order, _COLOURS)


def _plot_forces(ax: Axes, result: Result, order: IntArray) -> None:
    forces = _told(result, order)
    limit, peaks = shown_forces(forces)
    what = "tangential" if result.force.shape[2] == 2 else "friction"
    factor, prefix = prefix_of(limit)
    for place, name in enumerate(_names(result, order)):
        colour = _COLOURS[place]
        normal, rubbing = forces[:, place].T / factor
        ax.plot(result.times, normal, color=colour, linewidth=1.2, label=f"{name}, normal")
        if result.error is not None:
            off = result.error.force.get(result.contact_names[order[place]], 0.0)
            # a wider one, as of a pile that rattles, would hide all else; where nothing presses there is none
            shown = np.where((normal > 0.0) & (off < _WIDE * limit), normal, np.nan)
            _band(ax, result, shown, off / factor, colour)
        if np.any(rubbing != 0.0):
            ax.plot(result.times, rubbing, color=colour, linewidth=1.2, ls=(0, (4, 2)), label=f"{name}, {what}")
    ax.set_ylabel(f"contact force [{prefix}N]")
    if peaks:
        _cut(ax, result, order, limit, factor)


def _told(result: Result, order: IntArray) -> FloatArray:
    """(m, k, 2) normal and tangential force of the contacts shown; in space the size of friction [N]."""
    forces = result.force[:, order]
    if forces.shape[2] == 2:
        return forces
    return np.stack([forces[..., 0], np.linalg.norm(forces[..., 1:], axis=-1)], axis=-1)


def _plot_gaps(ax: Axes, result: Result, order: IntArray) -> None:
    gaps = result.gap[:, order]
    largest = float(np.abs(gaps[np.isfinite(gaps)]).max(initial=0.0))
    smallest = _ROUNDING * (scene_size(result) or 0.0)
    factor, prefix = prefix_of(max(largest, smallest) if largest > 0.0 else 0.0)
    for place, (k, name) in enumerate(zip(order, _names(result, order), strict=True)):
        ax.plot(
            result.times,
            result.gap[:, k] / factor,
            color=_COLOURS[place],
            linewidth=1.2,
            label=name,
        )
        if result.error is not None:
            off = result.error.gap_curve.get(result.contact_names[k], np.zeros_like(result.error.times))
            _band(ax, result, result.gap[:, k] / factor, off / factor, _COLOURS[place])
    ax.axhline(0.0, color="black", linewidth=0.6)
    if 0.0 < largest < smallest:  # rounding, which is no motion
        ax.set_ylim(-smallest / factor, smallest / factor)
    ax.set_ylabel(f"gap [{prefix}m]")


def _plot_energies(ax: Axes, result: Result, order: IntArray) -> None:
    energies = result.energies
    curves = (
        ("kinetic", energies.kinetic, "-"),
        ("elastic", energies.elastic, "-"),
        ("potential, change", energies.potential - energies.potential[0], "-"),
        ("lost to friction", energies.friction, "--"),
        (lost_in_contacts(result), energies.impact, "--"),
        ("lost to damping", energies.damping, "--"),
        ("work of loads", energies.work, ":"),
    )
    factor, prefix = prefix_of(max(float(np.abs(values).max()) for _, values, _ in curves))
    for (label, values, style), colour in zip(curves, _COLOURS, strict=True):
        if np.any(values != 0.0):
            ax.plot(result.times, values / factor, color=colour, linestyle=style, linewidth=1.2, label=label)
    share = energies.relative_remainder
    ax.plot(
        result.times,
        energies.remainder / factor,
        color="#888888",
        linewidth=2.2,
        alpha=0.8,
        label=f"unexplained\n(at most {share:.1g} of the\nlargest stored energy)",
    )
    ax.set_ylabel(f"energy [{prefix}J]")


def shown_forces(force: FloatArray) -> tuple[float, int]:
    """Largest force that a chart of ``force`` (m, k, 2) shows [N], and how many instants lie beyond it.

    A time-stepping method reports an impact as an impulse over a step: a peak as high as the step is short, which would
    press all other forces onto the axis. Peaks that are rare and far above the others are cut.
    """
    sizes = np.abs(force).max(axis=(1, 2), initial=0.0)
    sizes = np.sort(sizes[sizes > 0.0])
    if not sizes.size:
        return 0.0, 0
    usual = float(sizes[int((1.0 - _RARE) * (sizes.size - 1))])
    if not _NOTHING * sizes[-1] < usual < sizes[-1] / _PEAK:
        return float(sizes[-1]), 0
    limit = 1.3 * usual
    return limit, int(np.sum(sizes > limit))


def _cut(ax: Axes, result: Result, order: IntArray, limit: float, factor: float) -> None:
    """Limit the axis, and mark and tell what lies beyond it."""
    forces = _told(result, order) / factor
    limit /= factor
    low, high = max(float(forces.min()), -limit), min(float(forces.max()), limit)
    room = 0.08 * (high - low)
    ax.set_ylim(low - room, high + room)
    for place in range(len(order)):
        for edge, mark, beyond in ((high, "^", forces[:, place] > limit), (low, "v", forces[:, place] < -limit)):
            times = result.times[np.any(beyond, axis=1)]
            ax.plot(times, np.full(len(times), edge + np.sign(edge) * 0.5 * room), mark, ms=4, color=_COLOURS[place])
    beyond = np.any(np.abs(forces) > limit, axis=(1, 2))
    largest = with_unit(float(f"{np.abs(forces).max() * factor:.2g}"), "N")
    words = f"beyond the axis: {np.sum(beyond)} of\n{len(beyond)} instants, up to {largest}\n(an impulse over a step)"
    ax.plot([], [], "^", ms=4, color="#606060", label=words)


def _names(result: Result, order: IntArray) -> list[str]:
    return told_apart([result.contact_names[k] for k in order])
