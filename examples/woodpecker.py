"""The woodpecker toy: friction as a clockwork, and a system written in your own equations.

A sleeve with a little play slides down a pole; on it, by a spring, sits a woodpecker. The sleeve slips down,
tilts, jams (self-locking friction at two corners); the bird swings on, pecks the pole, swings back and
releases the sleeve. The cycle of 0.146 s feeds on gravity and is stable by itself: impacts and stick-slip are
what makes it run.

Three coordinates and three contacts need no scene of bodies: :class:`lcpflex.UserSystem` takes the mass
matrix, forces, gaps and contact directions as arrays or functions. See ``lcpflex.gallery.woodpecker`` for how
short that is. Numbers of Glocker & Studer 2005.
"""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import lcpflex as lf
from lcpflex import gallery


def run(folder: Path = Path()) -> lf.Result:
    case = gallery.scenes()["woodpecker"]
    result = lf.simulate(case.build(), 0.25, lf.MoreauJean(step=1e-4))

    beak = result.contact("beak")
    pecks = beak.times[1:][np.diff(beak.impulse[:, 0]) > 0.0]
    later = pecks[pecks > 0.15][0]
    assert abs((later - pecks[0]) - case.reference["period"]) < 1e-3

    figure = Figure(figsize=(10, 4.5), layout="constrained")
    height, phase = figure.subplots(1, 2)
    height.plot(result.times, 1e3 * result.q[:, 0])
    for k, peck in enumerate((pecks[0], later)):
        height.axvline(peck, color="C1", linestyle=":", label=None if k else "the beak strikes")
    height.set(xlabel="time [s]", ylabel="height of the sleeve [mm]")
    height.legend()
    phase.plot(np.degrees(result.q[:, 2]), result.u[:, 2], linewidth=0.8)
    phase.set(xlabel="angle of the bird [degrees]", ylabel="its rate [rad/s]")
    figure.savefig(folder / "woodpecker.png", dpi=150)
    return result


if __name__ == "__main__":
    print(run().summary())
