"""A bouncing ball: infinitely many impacts in a finite time.

A ball falls from 1 m on a floor with the restitution e = 0.5. Each bounce takes half as long as the one
before, so that they pile up (Zeno) at

    t = sqrt(2h/g) (1 + e)/(1 - e) = 1.354571 s,

after which the ball rests. The event-driven stepper locates each impact; it counts those slower than its
velocity threshold (1e-6 m/s) as plastic, and thereby passes the accumulation. Moreau-Jean's scheme knows no
events: it makes one step after the other and passes without noticing. Both leave the same picture.
"""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import lcpflex as lf
from lcpflex import gallery


def run(folder: Path = Path()) -> lf.Result:
    case = gallery.scenes()["bouncing_ball"]
    located = lf.simulate(case.build(), case.duration, lf.EventDriven())
    stepped = lf.simulate(case.build(), case.duration, lf.MoreauJean(step=1e-4))

    impacts = [event.time for event in located.events if event.kind == "impact"]
    assert abs(impacts[-1] - case.reference["rest_time"]) < 1e-6

    figure = Figure(figsize=(8, 6), layout="constrained")
    height, bounces = figure.subplots(2, 1)
    height.plot(located.times, located.q[:, 1] - 0.1, label="event-driven")
    height.plot(stepped.times, stepped.q[:, 1] - 0.1, "--", label="Moreau-Jean, h = 0.1 ms")
    height.axvline(case.reference["rest_time"], color="gray", linestyle=":", label="rest, closed form")
    height.set(xlabel="time [s]", ylabel="height above the floor [m]")
    height.legend()
    bounces.semilogy(np.arange(1, len(impacts)), np.diff(impacts), "o-", label="until the next impact")
    bounces.set(xlabel="impact", ylabel="time [s]")
    bounces.legend()
    figure.savefig(folder / "bouncing_ball.png", dpi=150)
    return located


if __name__ == "__main__":
    print(run().summary())
