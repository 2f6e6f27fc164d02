"""A flexible pendulum touches a bump: one impact that is really several.

An aluminium strip of 0.7 x 0.028 x 0.005 m is let go horizontally and meets, at 0.4 m/s, a small hemisphere
under it (bar, release and speed of Shi, Hong & Liu 2013). A rigid bar would bounce or stay. The flexible bar
does neither: the point that touches is stopped, the rest of the bar swings on and pulls it off again, and
within a few milliseconds the contact opens and closes several times. A single coefficient of restitution
cannot tell this; here it is 0, and all that bounces is the bar's own bending.

The time of first touch is that of a rigid bar, 29.4 ms, within a few per cent: let go without support the
strip bends a little while it falls.
"""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import lcpflex as lf
from lcpflex import gallery


def run(folder: Path = Path()) -> lf.Result:
    case = gallery.scenes()["hemisphere"]
    result = lf.simulate(case.build(), case.duration, case.stepper, record=1e-5)

    bump = result.contact("hemisphere")
    assert bump.first_touch is not None
    assert abs(bump.first_touch / case.reference["first_touch"] - 1.0) < 0.05

    figure = Figure(figsize=(11, 6), layout="constrained")
    left, right = figure.subfigures(1, 2)
    impulse, gap = left.subplots(2, 1, sharex=True)
    shown = np.abs(result.times - bump.first_touch - 2e-3) < 3e-3
    since = 1e3 * (result.times[shown] - bump.first_touch)
    impulse.plot(since, 1e3 * bump.impulse[shown, 0])
    impulse.set_ylabel("normal impulse so far [mN s]")
    gap.plot(since, 1e6 * bump.gap[shown])
    gap.set(xlabel="time since first touch [ms]", ylabel="gap [µm]")
    for axes in (impulse, gap):
        axes.grid(True, alpha=0.4)
    scene = right.subplots()
    result.draw(result.times[np.argmax(result.energies.elastic)], axes=scene)
    figure.savefig(folder / "flexible_pendulum_on_hemisphere.png", dpi=150)
    return result


if __name__ == "__main__":
    print(run().summary())
