"""A tippe top: it spins on its round side, turns over and goes on spinning on its stem.

Two spheres on one axis, the mass centre below the centre of the large one (data of Leine & Glocker, 2003). Friction at
the point of contact turns the axis over against gravity, which slows the spin down. Whatever the law of friction,
Jellett's number, the angular momentum along the arm from the mass centre to the point of contact,

    L . (a_1 e_3 - r_1 e_z)

is constant as long as the large sphere alone touches: it tells how good the steps are. A top that spins about its own
axis in the beginning, not about the vertical, is caught by rolling before it turns over.
"""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import lcpflex as lf
from lcpflex import gallery

INERTIA = np.array([8e-7, 8e-7, 7e-7])
ARM, RADIUS = 0.003, 0.015  # place of the large sphere on the axis, and its radius [m]


def jellett(result: lf.Result) -> np.ndarray:
    """Jellett's number (m,) [kg m^3/s]."""
    turned = result.orientation("top")
    axis = turned.apply([0.0, 0.0, 1.0])
    momentum = turned.apply(INERTIA * result.u[:, 3:6])
    return np.einsum("mi,mi->m", momentum, ARM * axis - RADIUS * np.array([0.0, 0.0, 1.0]))


def run(folder: Path = Path()) -> lf.Result:
    case = gallery.scenes()["tippe_top"]
    result = lf.simulate(case.build(), case.duration, lf.EventDriven(), record=5e-3)
    axis = result.orientation("top").apply([0.0, 0.0, 1.0])
    lean = np.degrees(np.arccos(axis[:, 2]))
    assert lean.max() > 90.0
    number = jellett(result)
    alone = result.force[:, result.contact_names.index("small"), 0].cumsum() == 0.0
    assert np.abs(number[alone] / number[0] - 1.0).max() < 1e-8

    figure = Figure(figsize=(10, 4), layout="constrained")
    angle, kept = figure.subplots(1, 2)
    angle.plot(result.times, lean)
    angle.axhline(90.0, color="gray", linestyle=":")
    angle.set(xlabel="time [s]", ylabel="lean of the axis [degrees]", title="the top turns over")
    kept.semilogy(result.times[1:], np.abs(number[1:] / number[0] - 1.0))
    touched = result.times[~alone]
    if len(touched):
        kept.axvline(touched[0], color="gray", linestyle=":", label="the stem touches")
        kept.legend()
    kept.set(xlabel="time [s]", ylabel="change of Jellett's number", title="constant while one sphere touches")
    figure.savefig(folder / "tippe_top.png", dpi=150)
    return result


if __name__ == "__main__":
    print(run().summary())
