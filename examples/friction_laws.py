"""A block on a spring under every friction law: who holds it where it stops?

A block of 1 kg lies on a rough floor (mu = 0.1, weight 10 N) and hangs on a spring of 1e4 N/m. Let go 0.85 mm off, it
swings to and fro and loses 2 mu m g / k = 0.2 mm at each half swing,

    0.85, -0.65, 0.45, -0.25, 0.05 mm,

and there friction holds it, since the spring pulls with 0.5 N and friction can take 1 N. So says Coulomb's law, which
the event-driven stepper solves as it is: a friction force that is whatever holds, up to mu N.

Under a continuous law friction is a function of the slip velocity. Laws without states know no force at rest: what
should be held creeps, here back to 0, the faster the larger their slip speed. Those that stay below mu N while it slips
(arctangent, Threlfall) let it swing farther, too. Bristles (LuGre, and those of Gonthier) bend before they slip, and
hold.
"""

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

import lcpflex as lf
from lcpflex import gallery, laws

SPEED = 1e-3  # [m/s] at which friction is about fully developed
DURATION = 0.4  # [s]
REST = 0.05e-3  # where Coulomb's law holds the block [m]

LAWS = {
    "tanh": laws.SmoothedCoulomb(SPEED),
    "arctangent": laws.ArctangentCoulomb(SPEED),
    "ramp": laws.RampCoulomb(SPEED),
    "Threlfall": laws.Threlfall(SPEED),
    "Ambrosio": laws.Ambrosio(0.1 * SPEED, SPEED),
    "Bengisu-Akay": laws.BengisuAkay(SPEED),
    "Brown-McPhee": laws.BrownMcPhee(SPEED),
    "LuGre": laws.LuGre(stiffness=1e5, damping=20.0, stribeck_speed=SPEED),
    "bristles": laws.Bristle(stiffness=1e5, damping=20.0, stribeck_speed=SPEED),
}

HOLDING = ("LuGre", "bristles")

NORMAL = laws.PowerLaw(1e6, exponent=1.0), laws.HysteresisDamping(restitution=0.5, guard_speed=1e-2)


def under(friction: Any) -> lf.Result:
    law = laws.ContactLaw(*NORMAL, friction)
    return lf.simulate(gallery.spring_block(), DURATION, lf.Smooth(law))


def run(folder: Path = Path()) -> lf.Result:
    truth = lf.simulate(gallery.spring_block(), DURATION, lf.EventDriven())
    results = {name: under(law) for name, law in LAWS.items()}
    assert abs(truth.q[-1, 0] - REST) < 1e-9
    for name, result in results.items():  # over the last half, long after the last stop
        moved = np.ptp(result.q[len(result.times) // 2 :, 0])
        assert moved < 1e-4 * REST if name in HOLDING else moved > 0.2 * REST

    figure = Figure(figsize=(11, 7), layout="constrained")
    motion, rest, force = figure.subplot_mosaic([["motion", "motion"], ["rest", "force"]]).values()

    def draw(result: lf.Result, style: str, width: float, label: str) -> None:
        time = 1e3 * result.times
        for axes in (motion, rest):
            axes.plot(time, 1e3 * result.q[:, 0], style, linewidth=width, label=label)
        force.plot(time, result.force[:, 0, 1], style, linewidth=width, label=label)

    for name, result in results.items():
        style = "-" if name in HOLDING else "--"
        draw(result, style, 1.2, name)
    draw(truth, "k:", 2.5, "Coulomb, event-driven")
    motion.set(title="A block on a spring comes to rest", xlim=(0, 200), ylabel="place [mm]")
    motion.legend(ncols=2)
    rest.set(title="Where it should stay", xlim=(110, 400), ylim=(-0.01, 0.1), ylabel="place [mm]")
    force.set(title="What friction does when it stops", xlim=(115, 150), ylabel="friction [N]")
    for axes in (motion, rest, force):
        axes.set_xlabel("time [ms]")
    figure.savefig(folder / "friction_laws.png", dpi=150)
    return truth


if __name__ == "__main__":
    print(run().summary())
