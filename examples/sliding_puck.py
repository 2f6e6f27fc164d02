"""Pucks that slide: friction in space has a direction, which turns.

Left: a puck starts across a slope of 25 degrees with mu = tan(25 degrees). Friction turns it downhill; the speed and
the part of it down the slope have a constant sum, so that in the end it slides down with half of its speed. Right: a
puck on three feet that also spins stops sliding and spinning in the same instant. With facets in the place of the
cone the direction of friction is off by up to half the angle between two of them; here it is not.
"""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import lcpflex as lf
from lcpflex import gallery


def run(folder: Path = Path()) -> lf.Result:
    known = gallery.scenes()
    across = lf.simulate(gallery.sliding_puck(), 1.5, lf.EventDriven(), record=5e-3)
    case = known["puck"]
    spinning = lf.simulate(case.build(), case.duration, lf.EventDriven(), record=5e-3)
    speed = np.hypot(across.u[:, 0], across.u[:, 1])
    assert np.abs(speed - across.u[:, 1] - 1.0).max() < 1e-6
    assert abs(spinning.q[-1, 0] - case.reference["x"]) < 1e-6

    figure = Figure(figsize=(10, 4), layout="constrained")
    left, right = figure.subplots(1, 2)
    left.plot(across.times, across.u[:, 0], label="across the slope")
    left.plot(across.times, -across.u[:, 1], label="down the slope")
    left.plot(across.times, speed - across.u[:, 1], ":", color="gray", label="speed + part down the slope")
    left.set(xlabel="time [s]", ylabel="velocity [m/s]", title="across a slope, mu = tan(slope)")
    left.legend(loc="center right")
    right.plot(spinning.times, np.hypot(spinning.u[:, 0], spinning.u[:, 1]), label="speed [m/s]")
    right.plot(spinning.times, 0.1 * spinning.u[:, 5], label="R omega [m/s]")
    right.axvline(case.reference["stops"], color="gray", linestyle=":", label="equations of motion: stops")
    right.set(xlabel="time [s]", title="three feet: slides and spins")
    right.legend(loc="upper right")
    figure.savefig(folder / "sliding_puck.png", dpi=150)
    return spinning


if __name__ == "__main__":
    print(run().summary())
