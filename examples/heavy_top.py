"""A heavy top on a ball joint: steady precession, and nodding when it is released.

A top of 1 kg spins at 100 rad/s about its axis, .1 m long to the mass centre, which leans by 30 degrees. With the
moments J1 = .013 kg m^2 (about the pivot, across the axis) and J3 = .004 it precesses steadily at the roots W of

    J1 cos(lean) W^2 - J3 w3 W + m g l = 0:   2.650 and 32.879 rad/s.

Released without precession it nods between 30 and 35.7 degrees in .2379 s, and the axis draws a row of cusps. The spin
about its axis is conserved, as is the vertical part of the angular momentum: no torque acts about either.
"""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import lcpflex as lf
from lcpflex import gallery


def lean(result: lf.Result) -> np.ndarray:
    """Angle between the axis of the top and the vertical (m,) [rad]."""
    axis = result.orientation("top").apply([0.0, 0.0, 1.0])
    return np.arctan2(np.hypot(axis[:, 0], axis[:, 1]), axis[:, 2])


def run(folder: Path = Path()) -> lf.Result:
    known = gallery.scenes()
    released, steady = known["released_top"], known["heavy_top"]
    nod = released.reference["period"]
    nodding = lf.simulate(released.build(), 5.0 * nod, lf.EventDriven(), record=nod / 100.0)
    precessing = lf.simulate(steady.build(), 5.0 * nod, lf.EventDriven(), record=nod / 100.0)
    assert abs(lean(nodding).max() - released.reference["largest_lean"]) < 1e-4
    assert np.abs(lean(precessing) - steady.reference["lean"]).max() < 1e-5

    figure = Figure(figsize=(10, 4.5), layout="constrained")
    path, angle = figure.subplots(1, 2)
    for result, label in ((nodding, "released without precession"), (precessing, "in steady precession, 2.650 rad/s")):
        tip = result.orientation("top").apply([0.0, 0.0, 1.0])
        path.plot(tip[:, 0], tip[:, 1], label=label)
        angle.plot(result.times, np.degrees(lean(result)), label=label)
    path.plot(0.0, 0.0, "k+", markersize=10)
    path.set(aspect="equal", xlabel="x of the axis", ylabel="y of the axis", title="the axis seen from above")
    angle.axhline(np.degrees(released.reference["largest_lean"]), color="gray", linestyle=":", label="quadrature")
    angle.set(xlabel="time [s]", ylabel="lean of the axis [degrees]")
    angle.legend(loc="upper center", bbox_to_anchor=(0.5, 1.16), ncols=3, frameon=False, fontsize="small")
    figure.savefig(folder / "heavy_top.png", dpi=150)
    return nodding


if __name__ == "__main__":
    print(run().summary())
