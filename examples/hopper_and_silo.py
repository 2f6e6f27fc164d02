"""What friction does to grains: a hopper that clogs, and a silo whose walls carry its content.

Forty discs leave a hopper through a mouth 2.6 diameters wide. Without friction they all run out. With mu = 0.8 a few
of them meet over the mouth when the first one has left, and form an arch that carries the rest: the flow stops for
good. Where the sides are steeper, or the mouth is wider, chance decides when.

In a silo the bottom is lowered slowly, so that all discs slide down the rough walls, which hold them back. By Janssen
(1895) the force on the bottom does not grow with the filling, but saturates: F = F_inf (1 - exp(-W / F_inf)), with the
weight W that was filled in. Few discs scatter about the curve.
"""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import lcpflex as lf
from lcpflex import gallery

STEP = lf.MoreauJean(step=1e-3)
FILLINGS = (8, 16, 32, 48)


def inside(result: lf.Result) -> np.ndarray:
    """Number of discs that are still in the hopper."""
    return (result.q[:, 1::3] > 0.0).sum(axis=1)


def bottom_force(discs: int) -> float:
    """Mean force on the bottom of a silo while it sinks [N]."""
    result = lf.simulate(gallery.silo(discs), 3.0, STEP, record=0.02)
    own = [k for k, name in enumerate(result.contact_names) if "bottom" in name]
    impulse = result.impulse[:, own, 0].sum(axis=1)
    sinking = np.flatnonzero(result.times >= 1.9)[[0, -1]]
    return float(np.diff(impulse[sinking])[0] / np.diff(result.times[sinking])[0])


def run(folder: Path = Path()) -> lf.Result:
    rough = lf.simulate(gallery.hopper(), 3.5, STEP, record=0.02)
    smooth = lf.simulate(gallery.hopper(friction=0.0), 3.5, STEP, record=0.02)
    assert inside(rough)[-1] >= 3
    assert inside(smooth)[-1] <= 2

    weights = 9.81 * np.array(FILLINGS)
    forces = np.array([bottom_force(discs) for discs in FILLINGS])
    limits = np.linspace(50.0, 1500.0, 1000)
    curves = limits[:, None] * -np.expm1(-weights / limits[:, None])
    best = int(np.argmin(((curves / forces - 1.0) ** 2).sum(axis=1)))
    assert np.abs(curves[best] / forces - 1.0).max() < 0.5
    assert forces[-1] < 0.8 * weights[-1]

    figure = Figure(figsize=(9, 8), layout="constrained")
    axes = figure.subplots(2, 2)
    for result, place, title in ((rough, axes[0, 0], "mu = 0.8"), (smooth, axes[0, 1], "no friction")):
        result.draw(3.5, axes=place)
        place.set_title(title, loc="right")
    axes[1, 0].plot(rough.times, inside(rough), label="mu = 0.8")
    axes[1, 0].plot(smooth.times, inside(smooth), "--", label="no friction")
    axes[1, 0].set(xlabel="time [s]", ylabel="discs in the hopper", ylim=(0, None))
    axes[1, 0].legend()
    line = np.linspace(1.0, 1.2 * weights[-1], 200)
    axes[1, 1].plot(weights, forces, "o", label="silo")
    axes[1, 1].plot(line, limits[best] * -np.expm1(-line / limits[best]), label="Janssen, one constant fitted")
    axes[1, 1].plot(line, line, "k:", label="all the weight")
    axes[1, 1].set(xlabel="weight filled in [N]", ylabel="force on the bottom [N]")
    axes[1, 1].legend()
    figure.savefig(folder / "hopper_and_silo.png", dpi=120)
    return rough


if __name__ == "__main__":
    print(run().summary())
