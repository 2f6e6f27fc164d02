"""A slider-crank whose flexible coupler falls on a flexible stop: no stiffness to choose, and none to be wrong about.

A coil spring (5 N m/rad) drives the crank from 0.29 rad towards the stretched position; before it arrives, at 0.1 rad,
the middle of the coupler meets the tip of a cantilever. Both bend, ring, part, meet again: dozens of short contacts
make one long push, which throws the mechanism back (after Chen, Liu & Hong 2015, section 3.4).

Spring, start, g = 9.8 m/s^2, no friction, a rigid crank and three flexible bodies are theirs; what the three are and
their dimensions are lost, those chosen are listed in ``lcpflex.gallery.mechanisms.slider_cranks``: slider B2, coupler
B3 and cantilever B4. Their text says of figures 12 and 13 what they show, the contact force between B3 and B4 and the
force of the joint between B2 and B3 in x and y, and no number. So there is nothing to agree with but this: what is
declared there can be, and all of it comes out.

The Lagrangian method (event-driven, e = 0) asks for no contact stiffness. A penalty law does: too soft a spring lets
the bodies through and changes the motion, and only a series of runs tells when it is stiff enough. Its motion ends
where the other has been from the start: deflection of the coupler at most 6.35 mm at 10^6 N/m, 6.37 at 10^7 and
6.37 without a spring. The massless boundary finds 6.70 mm with all ten modes of the coupler, for what is above them
has compliance without mass, and 7.00 with five. When each of the short contacts comes, to a millisecond, differs
between all three.

What the joints carry is a result, too, as in their figure 13: the force of the wrist pin on the coupler, in x and y.
Before the touch no component exceeds 6 N; then y follows the contact force, of whose impulse it bears two fifths, up
to 23 N, and x, with which the slider as it slows pulls the coupler on, turns round while the coupler is bent most. Its
impulse over the run is the same under the Lagrangian method as under the converged penalty, to 2 %.
"""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import lcpflex as lf
from lcpflex.gallery.mechanisms.slider_cranks import slider_crank_with_stop
from lcpflex.jit.kernel import FloatArray

WINDOW = 1e-3  # contact forces are shown as means over it [s]


def deflection(result: lf.Result) -> FloatArray:
    """Of the middle of the coupler, from the line between its ends, upwards [m]."""
    left, middle, right = (result.point("coupler", name) for name in ("left", "center", "right"))
    line = right - left
    across = np.column_stack([-line[:, 1], line[:, 0]]) / np.linalg.norm(line, axis=1)[:, None]
    return np.asarray(np.sum((middle - left) * across, axis=1))


def mean_force(result: lf.Result) -> tuple[FloatArray, FloatArray]:
    """Times [s] and contact force, its mean over ``WINDOW`` [N]: impulses count in it as forces do."""
    edges = np.arange(0.0, result.times[-1], WINDOW)
    impulse = np.interp(edges, result.times, result.contact("stop").impulse[:, 0])
    return 0.5 * (edges[1:] + edges[:-1]), np.diff(impulse) / WINDOW


def carried(result: lf.Result, joint: str) -> FloatArray:
    """Impulse of a joint since the start, x and y, that of its impacts included [N s]."""
    reaction = result.reaction(joint)
    steps = 0.5 * (reaction.force[1:] + reaction.force[:-1]) * np.diff(result.times)[:, None]
    return np.vstack([np.zeros(2), np.cumsum(np.nan_to_num(steps), axis=0)]) + reaction.impulse


def mean_reaction(result: lf.Result, joint: str) -> tuple[FloatArray, FloatArray]:
    """Times [s] and force of a joint, x and y, its mean over ``WINDOW`` [N]."""
    edges, impulse = np.arange(0.0, result.times[-1], WINDOW), carried(result, joint)
    ends = np.column_stack([np.interp(edges, result.times, impulse[:, k]) for k in range(2)])
    return 0.5 * (edges[1:] + edges[:-1]), np.diff(ends, axis=0) / WINDOW


def run(folder: Path = Path()) -> lf.Result:
    steppers = {
        "event-driven, e = 0": lf.EventDriven(rtol=1e-7, atol=1e-9),
        "massless boundary": lf.MasslessBoundary(step=1e-6, dynamic_modes=10),
        "penalty 10⁴ N/m": lf.Smooth(lf.Penalty(1e4)),
        "penalty 10⁶ N/m": lf.Smooth(lf.Penalty(1e6)),
    }
    results = {
        name: lf.simulate(slider_crank_with_stop(), 0.05, stepper, record=2e-5) for name, stepper in steppers.items()
    }

    lagrangian, converged = results["event-driven, e = 0"], results["penalty 10⁶ N/m"]
    assert abs(deflection(lagrangian).max() / deflection(converged).max() - 1.0) < 0.01
    pushed = [carried(result, "wrist pin")[-1] for result in (lagrangian, converged)]
    assert np.linalg.norm(pushed[0] - pushed[1]) < 0.02 * np.linalg.norm(pushed[1])

    figure = Figure(figsize=(10, 10), layout="constrained")
    drawing, force, bend, pin = figure.subplots(4, 1, height_ratios=(1.0, 1.2, 1.2, 1.2))
    lagrangian.draw(lagrangian.times[deflection(lagrangian).argmax()], axes=drawing)
    for (name, result), style in zip(results.items(), ("k-", "C0--", "C1:", "C1-"), strict=True):
        width = 1.8 if style == "k-" else 1.3
        times, mean = mean_force(result)
        force.plot(1e3 * times, mean, style, linewidth=width, label=name)
        bend.plot(1e3 * result.times, 1e3 * deflection(result), style, linewidth=width, label=name)
    force.set_ylabel(f"contact force,\nmean over {1e3 * WINDOW:g} ms [N]")
    bend.set(ylabel="deflection of the\nmiddle of the coupler [mm]")
    bend.legend(loc="upper left")
    for result, style, name in ((lagrangian, "-", "event-driven"), (converged, "--", "penalty 10⁶ N/m")):
        times, mean = mean_reaction(result, "wrist pin")
        for k, way in enumerate("xy"):
            pin.plot(1e3 * times, mean[:, k], f"C{k}{style}", label=f"{way}, {name}")
    pin.set(xlabel="time [ms]", ylabel=f"force on the coupler at its\nwrist pin, mean over {1e3 * WINDOW:g} ms [N]")
    pin.set_ylim(top=22.0)
    pin.legend(loc="upper left", ncols=4)
    for axes in (force, bend, pin):
        axes.set_xlim(20.0, 50.0)
        axes.grid(True, alpha=0.4)
    figure.savefig(folder / "slider_crank_with_flexible_stop.png", dpi=150)
    return lagrangian


if __name__ == "__main__":
    print(run().summary())
