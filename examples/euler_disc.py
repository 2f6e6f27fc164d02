"""A thin disc that rolls on its rim: around its own centre, and upright.

Left: with its centre at rest, a disc that leans by a rolls so that its point of contact goes around at
W = sqrt(4 g / (R sin a)); the steps keep the inclination. Right: a disc that rolls upright at v is stable above
sqrt(g R / 3) = .572 m/s; a lean of 1e-4 rad/s at the start grows below that speed, and stays small above it.
"""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import lcpflex as lf
from lcpflex import gallery


def lean(result: lf.Result) -> np.ndarray:
    """Angle between the axis of the disc and the vertical (m,) [degrees]."""
    axis = result.orientation("disc").apply([0.0, 0.0, 1.0])
    return np.degrees(np.arctan2(np.hypot(axis[:, 0], axis[:, 1]), axis[:, 2]))


def run(folder: Path = Path()) -> lf.Result:
    case = gallery.scenes()["euler_disc"]
    around = lf.simulate(case.build(), case.duration, lf.EventDriven(), record=5e-3)
    assert np.abs(lean(around) - 60.0).max() < 1e-6
    upright = {
        speed: lf.simulate(gallery.rolling_disc(speed=speed), 1.5, lf.EventDriven(), record=5e-3)
        for speed in (0.5, 0.65)
    }
    assert np.abs(lean(upright[0.5]) - 90.0).max() > 0.3
    assert np.abs(lean(upright[0.65]) - 90.0).max() < 0.0012

    figure = Figure(figsize=(10, 4), layout="constrained")
    left, right = figure.subplots(1, 2)
    axis = around.orientation("disc").apply([0.0, 0.0, 1.0])
    left.plot(axis[:, 0], axis[:, 1])
    left.set(aspect="equal", xlabel="x of the axis", ylabel="y of the axis", title="centre at rest, a = 60 degrees")
    for speed, result in upright.items():
        right.semilogy(result.times[1:], np.abs(lean(result)[1:] - 90.0), label=f"v = {speed} m/s")
    right.set(xlabel="time [s]", ylabel="lean [degrees]", title="upright: stable above .572 m/s")
    right.legend()
    figure.savefig(folder / "euler_disc.png", dpi=150)
    return around


if __name__ == "__main__":
    print(run().summary())
