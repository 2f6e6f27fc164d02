"""Panels of the chart of a spatial run: speeds and angular velocities of the bodies."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from lcpflex.kinematics.places import velocity
from lcpflex.results.chart_words import told_apart

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from lcpflex.jit.kernel import FloatArray, IntArray
    from lcpflex.results.result import Result

__all__ = ["bodies_shown", "plot_speeds", "plot_spins"]

STYLES = ("-", (0, (5, 2)), (0, (1, 1.5)))  # of components, which may lie on each other


def bodies_shown(result: Result, most: int) -> IntArray:
    """Of many bodies, those with the largest kinetic energy of a rigid body over the run, in their order."""
    assert result.compiled is not None
    bodies = result.compiled.model.bodies
    largest = []
    for b, d in enumerate(bodies.dof[:-1].tolist()):
        v, omega = result.u[:, d : d + 3], result.u[:, d + 3 : d + 6]
        inertia = np.trace(bodies.second[b]) * np.eye(3) - bodies.second[b]
        energy = bodies.mass[b] * np.sum(v * v, axis=1) + np.einsum("ti,ij,tj->t", omega, inertia, omega)
        largest.append(float(np.nanmax(energy, initial=0.0)))
    return np.sort(np.argsort(-np.array(largest), kind="stable")[:most])


def plot_speeds(ax: Axes, result: Result, shown: IntArray, colours: tuple[str, ...]) -> None:
    """Velocities of the undeformed mass centres; of a single body its components in world axes."""
    assert result.compiled is not None
    model = result.compiled.model
    motions = []
    for b in shown.tolist():
        n = int(model.bodies.dof[b + 1] - model.bodies.dof[b]) - 6
        centre = model.bodies.moment[b] / model.bodies.mass[b]
        motions.append(velocity(model, result.q, result.u, b, centre, np.zeros((n, 3))))
    _plot(ax, result, shown, motions, "world axes", colours)
    ax.set_ylabel("velocity [m/s]" if len(shown) == 1 else "speed [m/s]")


def plot_spins(ax: Axes, result: Result, shown: IntArray, colours: tuple[str, ...]) -> None:
    """Angular velocities of the frames; of a single body its components in body axes."""
    assert result.compiled is not None
    offsets = result.compiled.model.bodies.dof
    spins = [result.u[:, offsets[b] + 3 : offsets[b] + 6] for b in shown]
    _plot(ax, result, shown, spins, "body axes", colours)
    ax.set_ylabel("angular velocity\n[rad/s]" if len(shown) == 1 else "angular speed\n[rad/s]")


def _plot(
    ax: Axes, result: Result, shown: IntArray, vectors: list[FloatArray], axes: str, colours: tuple[str, ...]
) -> None:
    """Vectors (m, 3), by their lengths unless there is one of them."""
    assert result.compiled is not None
    names = told_apart([result.compiled.layout.bodies[b] for b in shown])
    if len(shown) == 1:
        for k, style in enumerate(STYLES):
            label = f"{names[0]}, {'xyz'[k]}" + (f"\n({axes})" if k == 2 else "")
            ax.plot(result.times, vectors[0][:, k], color=colours[k], linewidth=1.2, linestyle=style, label=label)
        return
    for name, vector, colour in zip(names, vectors, colours, strict=False):
        ax.plot(result.times, np.linalg.norm(vector, axis=1), color=colour, linewidth=1.2, label=name)
    ax.set_ylim(bottom=0.0)
