"""An elastic bar hits a wall: how an impact of a flexible body really goes, and what too few modes make of it.

A free elastic bar (length 10 m, wave speed 30 m/s, impedance Z = 30 N s/m) flies against a wall at 10 m/s. At
touch a compression wave starts into the bar; the wall feels the *constant* force Z v = 300 N until the wave
has come back from the free end, after 2L/c = 2/3 s. Then the bar leaves, undeformed, at exactly 10 m/s.

Nothing was said about restitution: e = 0 at the contact point, and yet the bar rebounds perfectly. Where a
body is flexible, its waves decide about the rebound and not a coefficient.

A bar described by N modes stops a finite effective mass, m/(2N + 1), at touch and loses its energy: a third
with one mode. Whoever reduces a model has to know that price.
"""

from pathlib import Path

from matplotlib.figure import Figure

import lcpflex as lf
from lcpflex import gallery


def run(folder: Path = Path()) -> lf.Result:
    cases = gallery.scenes()
    full, one = (
        lf.simulate(cases[name].build(), cases[name].duration, cases[name].stepper)
        for name in ("elastic_bar", "modal_bar_1")
    )

    assert abs(full.u[-1, 0] - cases["elastic_bar"].reference["rebound"]) < 0.1
    assert abs(one.u[-1, 0] - cases["modal_bar_1"].reference["rebound"]) < 0.01

    figure = Figure(figsize=(8, 6), layout="constrained")
    force, energy = figure.subplots(2, 1, sharex=True)
    force.plot(full.times, full.force[:, 0, 0], label="wall force, all 400 modes")
    force.plot(one.times, one.force[:, 0, 0], linewidth=1.0, label="one mode")
    force.plot([0, 0.5, 0.5, 7 / 6, 7 / 6, 1.5], [0, 0, 300, 300, 0, 0], "k:", label="exact")
    force.set(ylabel="force [N]", ylim=(-20, 480))
    force.legend()
    for result, words, style in ((full, "400 modes", "-"), (one, "one mode", "--")):
        energy.plot(result.times, result.energies.kinetic, f"C0{style}", label=f"kinetic, {words}")
        energy.plot(result.times, result.energies.elastic, f"C1{style}", label=f"elastic, {words}")
    energy.set(xlabel="time [s]", ylabel="energy [J]")
    energy.legend()
    figure.savefig(folder / "elastic_bar_on_wall.png", dpi=150)
    return full


if __name__ == "__main__":
    print(run().summary())
