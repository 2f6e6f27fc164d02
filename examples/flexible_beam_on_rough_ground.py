"""A flexible beam falls and slides on rough ground: contacts that come and go along a moving, bending body.

An aluminium strip of 1 m arrives at 2 m/s, slanting, over wavy ground (crests 0.2 m apart, mu = 0.3). One end
strikes, the beam starts to vibrate, the other end follows, then it slides over several crests at once, each
of which meets another place of the beam from step to step. Nothing of this is declared: the scene names two
surfaces, and the broad phase, the index sets and one complementarity problem per step find who touches, who
sticks and who slips.

There is no closed solution to compare with. What can be checked is the balance: all energy that the beam had
is still in it or was lost to friction, impacts and damping; what nobody can explain must be next to nothing.
"""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import lcpflex as lf
from lcpflex import gallery


def run(folder: Path = Path()) -> lf.Result:
    case = gallery.scenes()["sliding_beam"]
    result = lf.simulate(case.build(), 0.8, lf.MoreauJean(step=1e-4))

    assert result.energies.relative_remainder < 1e-3

    figure = Figure(figsize=(9, 9), layout="constrained")
    scene, points, energy = figure.subplots(3, 1, height_ratios=(1.4, 1, 1))
    touching = np.bincount(result.contact_points.record, minlength=len(result.times))
    result.draw(result.times[np.argmax(touching)], axes=scene)
    points.plot(result.times, touching, drawstyle="steps-post")
    points.set_ylabel("touching points")
    for name in ("kinetic", "elastic", "friction", "impact", "damping"):
        words = name if name in ("kinetic", "elastic") else f"lost to {name}"
        energy.plot(result.times, getattr(result.energies, name), label=words)
    energy.set(xlabel="time [s]", ylabel="energy [J]")
    energy.legend(loc="upper right", ncols=3)
    points.sharex(energy)
    figure.savefig(folder / "flexible_beam_on_rough_ground.png", dpi=150)
    return result


if __name__ == "__main__":
    print(run().summary())
