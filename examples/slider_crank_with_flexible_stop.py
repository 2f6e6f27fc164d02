"""A slider-crank whose flexible coupler falls on a flexible stop: no stiffness to choose, and none to be wrong about.

A coil spring (5 N m/rad) drives the crank from 0.29 rad towards the stretched position; before it arrives, at 0.1 rad,
the middle of the coupler meets the tip of a cantilever. Both bend, ring, part, meet again: some dozen short contacts
make one long push, which throws the mechanism back (after Chen, Liu & Hong 2015).

Spring, start and g = 9.8 m/s^2 are theirs; their dimensions are not known, these are chosen: crank 0.15 x 0.02 x
0.01 m and coupler 0.5 x 0.02 x 0.005 m of aluminium (70 GPa, 2700 kg/m^3), slider 0.1 kg, stop 0.2 x 0.02 x 0.004 m
of steel (210 GPa, 7850 kg/m^3), noses of 8 mm radius where coupler and stop meet, modal damping 0.5 %.

The Lagrangian method (event-driven, e = 0) asks for no contact stiffness, nor does the massless boundary, whose
forces need no impulses. A penalty law does: too soft a spring lets the bodies through and changes the motion, and
only a series of runs tells when it is stiff enough. Its motion ends where that of the other two has been from the
start; when each of the short contacts comes, to a millisecond, differs between all three.

What the joints carry is a result, too: the force on the crank at its pin, in x and y. Pushes of the stop come through
the coupler as ringing of some ten newtons (theirs is a figure without numbers here). Its impulse over the run is the
same under the Lagrangian method as under the converged penalty, to 2 %.
"""

import math
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import lcpflex as lf
from lcpflex.jit.kernel import FloatArray

CRANK, COUPLER, STOP, NOSE = 0.15, 0.5, 0.2, 0.008  # lengths and radius [m]
START, TOUCH = 0.29, 0.1  # angles of the crank [rad]
WINDOW = 1e-3  # contact forces are shown as means over it [s]


def mechanism(coupler_modes: int = 10, stop_modes: int = 6) -> lf.Scene:
    """The slider-crank at rest, its crank at ``START``, above the stop that it meets at ``TOUCH``."""
    scene = lf.Scene(gravity=(0.0, -9.8))
    pin = (CRANK * math.cos(START), CRANK * math.sin(START))
    tilt = -math.asin(pin[1] / COUPLER)
    bar = lf.Beam(COUPLER, 0.02, 0.005, density=2700.0, youngs_modulus=7e10)
    leaf = lf.Beam(STOP, 0.02, 0.004, density=7850.0, youngs_modulus=2.1e11)
    arm = lf.Box(width=CRANK, height=0.01, mass=CRANK * 0.01 * 0.02 * 2700.0)
    crank = scene.add(arm, name="crank", position=(0.5 * pin[0], 0.5 * pin[1]), angle=START)
    coupler = scene.add(bar, "coupler", pin, tilt, modes=coupler_modes, damping=0.005)
    block = lf.Box(width=0.04, height=0.03, mass=0.1)
    slider = scene.add(block, name="slider", position=(pin[0] + COUPLER * math.cos(tilt), 0.0))
    middle = CRANK * math.cos(TOUCH) + 0.5 * COUPLER * math.cos(math.asin(CRANK * math.sin(TOUCH) / COUPLER))
    tip = (middle, 0.5 * CRANK * math.sin(TOUCH) - 2.0 * NOSE)
    stop = scene.add(leaf, "stop", (tip[0] - STOP, tip[1]), modes=stop_modes, damping=0.005)

    bearing = crank.at(-0.5 * CRANK, 0.0)
    scene.join(lf.Revolute(bearing, scene.ground.at(0.0, 0.0), name="main bearing"))
    scene.join(lf.Revolute(crank.at(0.5 * CRANK, 0.0), coupler.point("left"), name="crank pin"))
    scene.join(lf.Revolute(coupler.point("right"), slider.point("center"), name="wrist pin"))
    scene.join(lf.Prismatic(slider.point("center"), scene.ground.at(0.0, 0.0), name="guide"))
    scene.join(lf.Weld(stop.point("left"), scene.ground.at(tip[0] - STOP, tip[1]), name="clamp"))
    scene.load(lf.TorsionSpring(bearing, scene.ground.at(0.0, 0.0), stiffness=5.0, angle=0.0))
    scene.contact(coupler.circle("center", NOSE), stop.circle("right", NOSE), name="stop")
    return scene


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
        "massless boundary": lf.MasslessBoundary(step=1e-6, dynamic_modes=5),
        "penalty 10⁴ N/m": lf.Smooth(lf.Penalty(1e4)),
        "penalty 10⁶ N/m": lf.Smooth(lf.Penalty(1e6)),
    }
    results = {name: lf.simulate(mechanism(), 0.05, stepper, record=2e-5) for name, stepper in steppers.items()}

    lagrangian, converged = results["event-driven, e = 0"], results["penalty 10⁶ N/m"]
    assert abs(deflection(lagrangian).max() / deflection(converged).max() - 1.0) < 0.01
    pushed = [carried(result, "crank pin")[-1] for result in (lagrangian, converged)]
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
        times, mean = mean_reaction(result, "crank pin")
        for k, way in enumerate("xy"):
            pin.plot(1e3 * times, mean[:, k], f"C{k}{style}", label=f"{way}, {name}")
    pin.set(xlabel="time [ms]", ylabel=f"force on the crank at its pin,\nmean over {1e3 * WINDOW:g} ms [N]")
    pin.legend(loc="lower left")
    for axes in (force, bend, pin):
        axes.set_xlim(20.0, 50.0)
        axes.grid(True, alpha=0.4)
    figure.savefig(folder / "slider_crank_with_flexible_stop.png", dpi=150)
    return lagrangian


if __name__ == "__main__":
    print(run().summary())
