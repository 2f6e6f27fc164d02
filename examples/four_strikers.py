"""Four meshes of the same two bodies: what a contact needs a fine mesh for, and what not.

The pendulum and the rod of ``pendulum_strikes_rod.py`` (dimensions: there), with four meshes of the contact region of
both: elements of 2.4, 1.2 and 0.3 mm with linear quadrilaterals and 0.6 mm with quadratic triangles; elsewhere at
most 6 mm (rod) and 3.5 mm (pendulum). No law of contact is given: what is local about the contact is in the meshes or
nowhere.

The impulse, and how long bodies touch, come from waves: 1 pair of nodes, which knows nothing of a contact patch, gets
them right within 3 %. The patch itself is another matter. With 1 or 3 pairs the pressure is what the mesh says it is;
with 9 it is that of a cylinder on a plane by Hertz,

    p = 2 F/(pi a b) sqrt(1 - y^2/a^2),   a^2 = 4 F R/(pi E* b),   1/E* = 1/E_1 + 1/E_2 in plane stress,

smoothly so with linear elements; nodes amid the edges of quadratic ones take less and those at their corners more than
their share. Nine pairs are what the library asks for: results with fewer say so, and how much finer elements should be.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

import lcpflex as lf
from lcpflex.gallery.mechanisms.strikers import pendulum_and_rod, pendulum_with_hammer, rod_with_crown
from lcpflex.jit.kernel import FloatArray

RADIUS, DEPTH, MODULUS = 0.3, 0.02, 1.0 / (1.0 / 69e9 + 1.0 / 210e9)  # of the contact: R, b [m], E* [Pa]
WINDOW = 1e-5  # forces are shown as means over it [s]


def quadratic_triangles(mesh: Any) -> Any:
    """Each quadrilateral as two triangles with nodes amid their edges."""
    return lf.meshes.quadratic(mesh.to_meshtri())


def strike(fine: float, remake: Callable[[Any], Any] | None) -> lf.Result:
    """The strike with elements ``fine`` [m] in the contact region of both bodies."""
    scene = pendulum_and_rod(
        rod_with_crown(fine, remake=remake),
        pendulum_with_hammer(fine, remake=remake),
        lambda mesh, kept: lf.craig_bampton(mesh, kept, modes=60, damping=lf.Rayleigh(0.0, 1e-9)),
    )
    return lf.simulate(scene, 2.2e-4, lf.MasslessBoundary(step=1e-7, dynamic_modes=40), record=2e-7)


def mean_force(result: lf.Result) -> tuple[FloatArray, FloatArray]:
    """Times [s] and contact force, its mean over ``WINDOW`` [N]."""
    times = np.linspace(0.0, result.times[-1] - WINDOW, 400)
    impulse = result.contact("strike").impulse[:, 0]
    before, after = (np.interp(at, result.times, impulse) for at in (times, times + WINDOW))
    return times + 0.5 * WINDOW, (after - before) / WINDOW


def pressure(result: lf.Result, spacing: float) -> tuple[FloatArray, FloatArray]:
    """Places of nodes across the rod [m], and force a node by ``spacing`` and depth [Pa], mean over ``WINDOW``."""
    touching = result.contact_points
    near = np.abs(result.times - 15e-6) < 0.5 * WINDOW
    chosen = near[touching.record]
    node, where = np.unique(np.rint(touching.place[chosen, 1] / spacing), return_inverse=True)
    force = np.bincount(where, touching.force[chosen, 0]) / np.count_nonzero(near)
    return spacing * node, force / (spacing * DEPTH)


def hertz(force: float) -> tuple[float, float]:
    """Half width [m] and greatest pressure [Pa] of the patch."""
    half = float(np.sqrt(4.0 * force * RADIUS / (np.pi * MODULUS * DEPTH)))
    return half, 2.0 * force / (np.pi * half * DEPTH)


def run(folder: Path = Path()) -> lf.Result:
    kinds = {
        "2.4 mm, linear": (2.4e-3, None, "C1", "o"),
        "1.2 mm, linear": (1.2e-3, None, "C2", "s"),
        "0.6 mm, quadratic": (6e-4, quadratic_triangles, "C0", "^"),
        "0.3 mm, linear": (3e-4, None, "black", "."),
    }
    figure = Figure(figsize=(11, 5.5), layout="constrained")
    left, right = figure.subplots(1, 2)
    for name, (fine, remake, colour, marker) in kinds.items():
        result = strike(fine, remake)
        history = result.contact("strike")
        pairs = int(history.pairs.max())
        times, mean = mean_force(result)
        words = f"{name}: {pairs} pair{'s' if pairs > 1 else ''}"
        left.plot(1e6 * times, mean, color=colour, label=words)
        place, pressed = pressure(result, 0.5 * fine if remake else fine)
        right.plot(1e3 * place, 1e-6 * pressed, marker, color=colour, label=words)
        for warning in result.warnings:
            print(f"{name}: {warning}")
    force = float(np.interp(15e-6, times, mean))
    half, highest = hertz(force)

    assert abs(pressed.max() / highest - 1.0) < 0.03

    y = np.linspace(-half, half, 200)
    right.plot(1e3 * y, 1e-6 * highest * np.sqrt(np.maximum(0.0, 1.0 - (y / half) ** 2)), "k:", label="Hertz")
    left.set(xlabel="time [µs]", ylabel=f"contact force, mean over {1e6 * WINDOW:g} µs [N]")
    right.set(xlabel="place across the rod [mm]", ylabel="contact pressure at 15 µs [MPa]")
    for axes in (left, right):
        axes.legend()
        axes.grid(True, alpha=0.4)
    figure.savefig(folder / "four_strikers.png", dpi=150)
    return result


if __name__ == "__main__":
    print(run().summary())
