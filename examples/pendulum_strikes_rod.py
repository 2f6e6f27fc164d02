"""A pendulum strikes a rod: how stiff must a contact spring be? As stiff as it takes; without one, nobody asks.

Both bodies are meshes, reduced by Craig-Bampton: the nodes of the contact region and of the hinge stay, modes stand
for the rest. The contact is made of nodes on segments, none of which knows Hertz' law: the local deformation is that
of the mesh. A penalty law puts a spring between each pair, and its force, impulse and pairs depend on that spring until
it is stiff enough, which only a series of runs tells. The Lagrangian method (event-driven, e = 0) and the massless
boundary have no such number: each is one line in the picture, and the series ends on it (after Chen, Liu & Hong 2015).

Their dimensions are lost, these are chosen: rod of aluminium (69 GPa, 0.33, 2700 kg/m^3), 0.6 x 0.02 x 0.02 m, its
end face a cylinder of radius 0.3 m; pendulum of steel (210 GPa, 0.3, 7800 kg/m^3), 0.4 x 0.012 x 0.02 m, hung at its
upper end, striking at 1.4 m/s with its flat side 0.36 m below the hinge; plane stress. Elements are linear
quadrilaterals, 6 mm long or less in the rod and 3.5 mm in the pendulum, so that both bend less than 5 % too stiffly
(waves of c = 5 km/s and f = 30 kHz would do with c/(20 f) = 8.4 mm), and 0.3 mm in the contact region: 11 pairs touch
at the peak.

How many modes? 20 a body put a false ripple of 80 kHz on the force, and the impulse is wrong by 5 % at its worst; with
40 modes by 0.5 % (``tests/convergence/test_pendulum_and_rod.py``). So reduced, a strike took a 350th of the time of the
whole meshes (3000 coordinates, same method and step) at an impulse that differed by 0.4 %
(``tests/benchmarks/test_reduction.py``).
"""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import lcpflex as lf
from lcpflex.gallery.mechanisms.strikers import FINE, pendulum_and_rod, pendulum_with_hammer, rod_with_crown
from lcpflex.jit.kernel import FloatArray

WINDOW = 1e-5  # forces are shown as means over it [s]


def mean_force(result: lf.Result) -> tuple[FloatArray, FloatArray]:
    """Times [s] and contact force, its mean over ``WINDOW`` [N]: impulses count in it as forces do."""
    times = np.linspace(0.0, result.times[-1] - WINDOW, 400)
    impulse = result.contact("strike").impulse[:, 0]
    before, after = (np.interp(at, result.times, impulse) for at in (times, times + WINDOW))
    return times + 0.5 * WINDOW, (after - before) / WINDOW


def run(folder: Path = Path(), modes: int = 40, fine: float = FINE) -> lf.Result:
    """``modes`` of each body besides the nodes that stay; elements ``fine`` [m] long in the contact region."""
    scene = pendulum_and_rod(
        rod_with_crown(fine),
        pendulum_with_hammer(fine),
        lambda mesh, kept: lf.craig_bampton(mesh, kept, modes=modes, damping=lf.Rayleigh(0.0, 1e-9)),
    )
    highest = np.sqrt(max(scene.body(name).source.stiffness.max() for name in ("rod", "pendulum")))

    def simulate(stepper: object) -> lf.Result:
        return lf.simulate(scene, 1.8e-4, stepper, record=2e-7)

    lagrangian = simulate(lf.EventDriven(rtol=1e-4, atol=1e-7))
    massless = simulate(lf.MasslessBoundary(step=1e-7))
    springs = np.geomspace(1e7, 1e10, 4)
    penalty = {
        k: simulate(lf.Smooth(lf.Penalty(k), integrator=lf.Verlet(min(1.8, 0.95 * np.sqrt(1e10 / k)) / highest)))
        for k in springs
    }
    exact = lagrangian.contact("strike").impulse[-1, 0]

    assert abs(penalty[springs[-1]].contact("strike").impulse[-1, 0] / exact - 1.0) < 1e-3

    figure = Figure(figsize=(11, 7), layout="constrained")
    grid = figure.add_gridspec(2, 2, width_ratios=(1.0, 1.5))
    peak, impulse, force = (figure.add_subplot(place) for place in (grid[0, 0], grid[1, 0], grid[:, 1]))
    colours = [(0.95 - 0.17 * k, 0.7 - 0.2 * k, 0.3 - 0.05 * k) for k in range(4)]
    for (k, result), colour, exponent in zip(penalty.items(), colours, ("⁷", "⁸", "⁹", "¹⁰"), strict=True):
        times, mean = mean_force(result)
        force.plot(1e6 * times, mean, color=colour, linewidth=1.2, label=f"penalty 10{exponent} N/m")
        peak.semilogx(k, mean.max(), "o", color=colour)
        impulse.semilogx(k, 1e3 * result.contact("strike").impulse[-1, 0], "o", color=colour)
    ours = {"event-driven, e = 0": (lagrangian, "black", "-"), "massless boundary": (massless, "C0", "--")}
    for words, (result, colour, style) in ours.items():
        times, mean = mean_force(result)
        force.plot(1e6 * times, mean, style, color=colour, linewidth=1.8, label=words)
        peak.axhline(mean.max(), color=colour, linestyle=style, label=words)
        impulse.axhline(1e3 * result.contact("strike").impulse[-1, 0], color=colour, linestyle=style)
    peak.set_ylabel("peak force [N]")
    peak.legend(loc="lower right")
    impulse.set(xlabel="stiffness of each pair [N/m]", ylabel="impulse in 180 µs [mN s]")
    force.set(xlabel="time [µs]", ylabel=f"contact force, mean over {1e6 * WINDOW:g} µs [N]")
    force.legend()
    for axes in (peak, impulse, force):
        axes.grid(True, alpha=0.4)
    figure.savefig(folder / "pendulum_strikes_rod.png", dpi=150)
    return lagrangian


if __name__ == "__main__":
    print(run().summary())
