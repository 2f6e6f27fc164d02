"""A block pushed up a slope: Coulomb's two answers, sliding back and staying.

A block starts up a slope of 30 degrees at v = 2 m/s. While it slides up, gravity and friction both brake it,

    a = g (sin 30 + mu cos 30),    so that it stops after v/a seconds and v^2/(2a) metres.

Then friction turns over and has to hold the block. With mu = 0.4 < tan 30 it cannot, and the block slides
back with g (sin 30 - mu cos 30). With mu = 0.7 > tan 30 it can: the block stays where it is, to the last bit;
a friction law that is smoothed over v = 0 would let it creep down for ever.

The event-driven stepper integrates up to the very instant of the stop and notes it as an event, the reversal
of slip.
"""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import lcpflex as lf
from lcpflex import gallery


def run(folder: Path = Path()) -> lf.Result:
    case = gallery.scenes()["incline"]
    slides = lf.simulate(gallery.block_on_incline(friction=0.4), case.duration, lf.EventDriven())
    sticks = lf.simulate(gallery.block_on_incline(friction=0.7), case.duration, lf.EventDriven())

    stop = next(event.time for event in slides.events if event.kind == "slip reversal")
    assert abs(stop - case.reference["stop_time"]) < 1e-6  # the digits of the reference

    figure = Figure(figsize=(9, 4), layout="constrained")
    chart, scene = figure.subplots(1, 2)
    uphill = np.array([np.cos(np.pi / 6), np.sin(np.pi / 6)])
    for result, words in ((slides, "μ = 0.4 slides back"), (sticks, "μ = 0.7 stays")):
        chart.plot(result.times, (result.q[:, :2] - result.q[0, :2]) @ uphill, label=words)
    chart.axvline(case.reference["stop_time"], color="gray", linestyle=":", label="stop, closed form (μ = 0.4)")
    chart.set(xlabel="time [s]", ylabel="distance up the slope [m]")
    chart.legend()
    sticks.draw(case.duration, axes=scene)
    figure.savefig(folder / "block_on_incline.png", dpi=150)
    return slides


if __name__ == "__main__":
    print(run().summary())
