"""The Dzhanibekov effect: a free body that is spun about its middle axis turns over and back, again and again.

The principal moments are 1, 2 and 3 kg m^2. A spin of 5 rad/s about the middle axis with .01 rad/s about the others is
not stable: the disturbance grows, the body turns over, and comes back. In a full turn over and back passes

    T = 4 K(k) / W,   k^2 = (I2 - I1)(2 E I3 - L^2) / ((I3 - I2)(L^2 - 2 E I1)),
                      W^2 = (I3 - I2)(L^2 - 2 E I1) / (I1 I2 I3)  =  10.0519 s

(E: energy, L: angular momentum). Nothing acts on the body, so that its energy and its angular momentum in world axes
stay as they are. Moreau-Jean takes the gyroscopic torque w x J w at the velocity in the middle of a step, corrected
once: of second order, where the torque at the start of a step would give energy to the body step by step.
"""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from scipy.special import ellipk

import lcpflex as lf
from lcpflex import gallery

MOMENTS = np.array([1.0, 2.0, 3.0])


def period(omega: np.ndarray) -> float:
    """Time in which the angular velocity (3,) in body axes comes back [s]."""
    low, middle, high = MOMENTS
    twice, square = float(MOMENTS @ omega**2), float(((MOMENTS * omega) ** 2).sum())
    k2 = (middle - low) * (twice * high - square) / ((high - middle) * (square - twice * low))
    rate = np.sqrt((high - middle) * (square - twice * low) / (low * middle * high))
    return float(4.0 * ellipk(k2) / rate)


def run(folder: Path = Path()) -> lf.Result:
    case = gallery.scenes()["dzhanibekov"]
    back = case.reference["period"]
    located = lf.simulate(case.build(), 2.0 * back, lf.EventDriven(rtol=1e-10))
    stepped = lf.simulate(case.build(), 2.0 * back, lf.MoreauJean(step=5e-3))
    assert abs(period(located.angular_velocity("body", "body")[0]) - back) < 1e-9
    turned = located.angular_velocity("body", "body")
    assert np.abs(turned[-1] - turned[0]).max() < 1e-4  # after two periods: a saddle magnifies what is wrong

    figure = Figure(figsize=(8, 7), layout="constrained")
    spins, kept = figure.subplots(2, 1, sharex=True)
    for i, (axis, color) in enumerate(zip(("first", "middle", "last"), ("C0", "C1", "C2"), strict=True)):
        label = f"about the {axis} axis, J = {MOMENTS[i]:g} kg m²"
        spins.plot(located.times, turned[:, i], color=color, label=label)
        spins.plot(stepped.times, stepped.angular_velocity("body", "body")[:, i], ":", color="black", linewidth=1.0)
    spins.plot([], [], ":", color="black", label="Moreau-Jean, h = 5 ms")
    for k in range(3):
        spins.axvline(k * back, color="gray", linewidth=0.8)
    spins.set(ylabel="angular velocity, body axes [rad/s]", title="A body spun about its middle axis")
    spins.legend(loc="upper center", bbox_to_anchor=(0.5, -0.02), ncols=2, frameon=False)
    for result, label in ((located, "event-driven (Runge-Kutta), rtol 1e-10"), (stepped, "Moreau-Jean, h = 5 ms")):
        change = np.abs(result.energies.kinetic / result.energies.kinetic[0] - 1.0)
        kept.semilogy(result.times, np.maximum(change, 1e-17), label=label)
    kept.set(xlabel="time [s]", ylabel="relative change of the energy")
    kept.legend()
    figure.savefig(folder / "dzhanibekov.png", dpi=150)
    return located


if __name__ == "__main__":
    print(run().summary())
