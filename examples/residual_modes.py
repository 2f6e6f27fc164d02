"""Residual modes where a body is struck: a few free modes then tell what many would.

An aluminium strip turns about its hinge onto a hemisphere, as in ``flexible_pendulum_on_hemisphere``, and strikes it
several times within a millisecond. How it gives way at the contact decides when it comes back, and free modes know that
slowly: each of them adds its own small part. The static response to a force at the contact,

    G b - Phi Omega^-2 Phi^T b        b: the force,  G: flexibility of the free strip,  Phi: the free modes kept

is one mode more, and holds all of what is missing there at rest. ``scene.add(strip, modes=8)`` adds such modes for
joints, loads and the points that are declared to touch; here they are asked for by hand, to compare both.

Reference: all modes of the strip. Both series go to the same history of the impulse over the first millisecond; with a
residual mode at the contact it is about twice as near, or takes half as many free modes.
"""

import math
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import lcpflex as lf
from lcpflex.jit.kernel import FloatArray

COUNTS = (4, 8, 12, 16, 24, 32)
SHOWN = (4, 8, 16)
LENGTH, HALF = 0.7, 0.0025  # length of the strip, and half of its thickness [m]
STRIP = lf.Beam(LENGTH, 0.028, 2.0 * HALF, density=2700.0, youngs_modulus=6.9e10, elements=60)
REACH, RADIUS, SPEED = 0.65, 0.01, 0.4  # where it is struck [m], the hemisphere [m], and how fast [m/s]
BEFORE, WINDOW = 5e-5, 1.1e-3  # [s] from the start to the first touch, and how long the impulse is looked at
HINGE = lf.Interface("left", moment=False, contact=False)
CONTACT = lf.Interface((REACH, -HALF), along=(0.0, 1.0), moment=False)


def strip_on_hemisphere(modes: int | None, contact: bool) -> lf.Scene:
    """The strip is straight and turns, and lies level where it meets the hemisphere."""
    interfaces = [] if modes is None else [HINGE, CONTACT] if contact else [HINGE]
    scene = lf.Scene()
    rate = SPEED / REACH
    strip = scene.add(STRIP.reduce(modes, interfaces=interfaces), "strip", angle=rate * BEFORE, angular_velocity=-rate)
    scene.join(lf.Revolute(strip.point("left"), scene.ground.at(0.0, 0.0)))
    bump = scene.ground.arc((REACH, -HALF - RADIUS), RADIUS, start=0.0, extent=math.pi)
    scene.contact(strip.surface("bottom"), bump, friction=0.3, name="hemisphere")
    return scene


def history(modes: int | None, contact: bool) -> tuple[lf.Result, FloatArray]:
    """The run, and its normal impulse at 1101 instants from the first touch on [N s]."""
    result = lf.simulate(strip_on_hemisphere(modes, contact), BEFORE + WINDOW, lf.MoreauJean(step=1e-7), record=1e-6)
    return result, np.interp(BEFORE + 1e-6 * np.arange(1101), result.times, result.impulse[:, 0, 0])


def run(folder: Path = Path()) -> lf.Result:
    result, exact = history(None, contact=False)
    series = {
        "free modes alone": {n: history(n, contact=False)[1] for n in COUNTS},
        "a residual mode at the contact": {n: history(n, contact=True)[1] for n in COUNTS},
    }
    off = {
        name: [float(np.abs(impulse - exact).max() / exact[-1]) for impulse in found.values()]
        for name, found in series.items()
    }
    print(f"{'free modes':>10}  " + "  ".join(f"{name:>30}" for name in off))
    for k, n in enumerate(COUNTS):
        print(f"{n:>10}  " + "  ".join(f"{100.0 * errors[k]:>28.1f} %" for errors in off.values()))
    alone, held = off.values()
    assert all(few < 0.6 * many for few, many in zip(held[:3], alone[:3], strict=True))

    figure = Figure(figsize=(13, 4.6), layout="constrained")
    *panels, errors = figure.subplots(1, 3)
    since = 1e-3 * np.arange(1101)
    for axes, (name, found) in zip(panels, series.items(), strict=True):
        axes.plot(since, 1e3 * exact, color="black", linewidth=2.5, alpha=0.35, label="all modes")
        for n, colour in zip(SHOWN, ("C3", "C1", "C0"), strict=True):
            axes.plot(since, 1e3 * found[n], color=colour, label=f"{n} free modes")
        axes.set(title=name, xlabel="since the first touch [ms]", ylabel="impulse of the hemisphere [mN s]")
        axes.set_ylim(0.0, 1.25e3 * exact[-1])
        axes.legend(loc="lower right")
    for (name, values), marker in zip(off.items(), "os", strict=True):
        errors.loglog(COUNTS, [100.0 * value for value in values], marker=marker, label=name)
    errors.set(title="largest error of the impulse", xlabel="free modes", ylabel="% of the impulse at the end")
    errors.set_xticks(COUNTS, [str(n) for n in COUNTS])
    errors.set_yticks([5, 10, 20, 50], ["5", "10", "20", "50"])
    errors.minorticks_off()
    errors.legend()
    figure.savefig(folder / "residual_modes.png", dpi=120)
    return result


if __name__ == "__main__":
    print(run(Path()).summary())
