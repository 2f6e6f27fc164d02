"""A block under a growing and fading pull: stick, slip, stick.

A block of 1 kg lies on a floor with mu = 0.3 and is pulled by F = 4 sin(2t) newton. Friction can hold mu m g
= 2.94 N, so

    it sticks while F < 2.94 N, slips from t = 0.4134 s on, and sticks again at t = 1.5528 s, 0.3327 m further.

It slips on long after F has fallen below 2.94 N again: it first has to lose its speed. Look at the friction
force in the chart: while sticking it is whatever balances the pull (it is found, not given), while slipping
it is mu times the normal force, and it jumps where slipping ends. Nothing tells the two apart but the
complementarity problem.
"""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import lcpflex as lf
from lcpflex import gallery


def run(folder: Path = Path()) -> lf.Result:
    case = gallery.scenes()["stick_slip"]
    result = lf.simulate(case.build(), case.duration, lf.EventDriven())

    moved = result.q[-1, 0] - result.q[0, 0]
    assert abs(moved - case.reference["displacement"]) < 1e-7

    figure = Figure(figsize=(8, 6), layout="constrained")
    force, motion = figure.subplots(2, 1, sharex=True)
    force.plot(result.times, -result.contact("floor").force[:, 1], label="friction, against the pull")
    force.plot(result.times, 4.0 * np.sin(2.0 * result.times), "--", color="gray", label="pull, 4 sin 2t")
    force.set_ylabel("force [N]")
    force.legend()
    motion.plot(result.times, result.q[:, 0], label="place [m]")
    motion.plot(result.times, result.u[:, 0], label="speed [m/s]")
    motion.set_xlabel("time [s]")
    motion.legend()
    for name in ("slip_time", "stick_time"):
        for axes in (force, motion):
            axes.axvline(case.reference[name], color="gray", linestyle=":")
    figure.savefig(folder / "stick_slip_block.png", dpi=150)
    return result


if __name__ == "__main__":
    print(run().summary())
