"""A slider-crank of solids falls on a flexible stop: contact force and joint force, figures 12 and 13 in space.

The mechanism of ``slider_crank_with_flexible_stop`` (after Chen, Liu & Hong 2015, section 3.4), made of meshes:
coupler, slider and stop are hexahedra, the crank is rigid, a coil spring of 5 N m/rad drives it from 0.29 rad, gravity
is 9.8 m/s^2, and nothing rubs. That is what is printed; lengths, materials and which body is which are lost, and
chosen as in the plane (``lcpflex.gallery.mechanisms.solid_slider_cranks``). Their text says what the two figures show,
the contact force between B3 and B4 and the joint's force between B2 and B3 in x and y, and no number.

Without a spring in the contact there is one answer: over a massless boundary and by Moreau's steps the coupler deflects
by at most 6.37 and 6.38 mm, and the stop gives it 0.742 N s. A penalty law comes there as its spring stiffens: 6.34 mm
and 0.767 N s at 10^5 N/m, 6.36 and 0.738 at 10^7. The beams of the planar mechanism found 6.37 mm. The force of the
wrist pin on the coupler turns as it does there: x is a pull of up to 8 N before and after the push and a small one back
while the coupler is bent most, y bears two fifths of the contact's impulse, with up to 21 N. By the stiffest penalty
the impulse of the pin is the same within 2 %. When each of the short contacts comes differs between all of them.
"""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import lcpflex as lf
from lcpflex.gallery.mechanisms.solid_slider_cranks import solid_slider_crank
from lcpflex.jit.kernel import FloatArray

WINDOW = 1e-3  # forces are shown as means over it [s]
DURATION = 0.05  # [s]
VIEW = (12.0, 0.0)  # of the camera [deg]: the mechanism moves in x and y
MULTIPLIERS, PENALTY = "multipliers, massless boundary", "penalty 10⁷ N/m"
STEPPERS = {
    MULTIPLIERS: (None, lf.MasslessBoundary(step=2e-6)),
    "multipliers, Moreau-Jean": (None, lf.MoreauJean(step=1e-6, theta=0.55)),
    "penalty 10⁵ N/m": (lf.Penalty(1e5), lf.MoreauJean(step=2e-6, theta=0.55)),
    PENALTY: (lf.Penalty(1e7), lf.MoreauJean(step=1e-6, theta=0.55)),
}


def mean_rate(result: lf.Result, values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Times [s], and the mean rate over ``WINDOW`` of quantities at the instants of a result, one a column."""
    edges = np.arange(0.0, result.times[-1], WINDOW)
    ends = np.column_stack([np.interp(edges, result.times, column) for column in values.T])
    return 0.5 * (edges[1:] + edges[:-1]), np.diff(ends, axis=0) / WINDOW


def carried(result: lf.Result, joint: str) -> FloatArray:
    """Impulse of a joint since the start, x, y and z, that of its impacts included [N s]."""
    reaction = result.reaction(joint)
    steps = 0.5 * (reaction.force[1:] + reaction.force[:-1]) * np.diff(result.times)[:, None]
    return np.vstack([np.zeros(3), np.cumsum(np.nan_to_num(steps), axis=0)]) + reaction.impulse


def deflection(result: lf.Result) -> FloatArray:
    """Of the middle of the coupler, from the line between its ends, upwards [m]."""
    left, middle, right = (result.point("coupler", name) for name in ("left", "middle", "right"))
    line = right - left
    return np.asarray(np.cross(line, middle - left)[:, 2] / np.linalg.norm(line, axis=1))


def run(folder: Path = Path()) -> lf.Result:
    results = {
        name: lf.simulate(solid_slider_crank(law=law), DURATION, stepper, record=1e-5)
        for name, (law, stepper) in STEPPERS.items()
    }
    exact, converged = results[MULTIPLIERS], results[PENALTY]
    for name, result in results.items():
        assert abs(deflection(result).max() / deflection(exact).max() - 1.0) < 0.01, name
    pushed = [carried(result, "wrist pin")[-1] for result in (exact, converged)]
    assert np.linalg.norm(pushed[0] - pushed[1]) < 0.02 * np.linalg.norm(pushed[1])

    figure = Figure(figsize=(10, 11), layout="constrained")
    drawing, force, pin, bend = figure.subplots(4, 1, height_ratios=(1.0, 1.2, 1.2, 1.2))
    styles = ("k-", "C0--", "C1:", "C1-")
    for (name, result), style in zip(results.items(), styles, strict=True):
        look = {"linewidth": 1.8 if style == "k-" else 1.3, "label": name}
        times, mean = mean_rate(result, result.contact("stop").impulse[:, :1])
        force.plot(1e3 * times, mean[:, 0], style, **look)
        bend.plot(1e3 * result.times, 1e3 * deflection(result), style, **look)
    for name, style in ((MULTIPLIERS, "-"), (PENALTY, "--")):
        times, mean = mean_rate(results[name], carried(results[name], "wrist pin"))
        for k, way in enumerate("xy"):
            pin.plot(1e3 * times, mean[:, k], f"C{k}{style}", label=f"{way}, {name}")
    force.set_ylabel(f"contact force,\nmean over {1e3 * WINDOW:g} ms [N]")
    pin.set_ylabel(f"force on the coupler at its\nwrist pin, mean over {1e3 * WINDOW:g} ms [N]")
    bend.set(xlabel="time [ms]", ylabel="deflection of the\nmiddle of the coupler [mm]")
    for axes in (force, pin, bend):
        axes.set_xlim(20.0, 1e3 * DURATION)
        axes.grid(True, alpha=0.4)
    bend.legend(loc="upper left")
    pin.legend(loc="lower left", ncols=2)
    pin.set_ylim(bottom=-42.0)
    exact.draw(exact.times[deflection(exact).argmax()], axes=drawing, view=VIEW)
    figure.savefig(folder / "solid_slider_crank.png", dpi=130)
    return exact


if __name__ == "__main__":
    print(run().summary())
