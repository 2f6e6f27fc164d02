"""A spatial slider-crank in free motion: a crank above the rail, a rod with two ball joints.

The crank turns about x, .12 m above the rail; its pin is at (0, r cos, .12 + r sin), and the slider runs on the x axis.
The massless rod keeps its length, a distance joint. One angle says where all is, so that the energy

    E = J rate^2 / 2 + m xdot^2 / 2,   x^2 = l^2 - (r cos)^2 - (.12 + r sin)^2,   xdot = -.12 r cos(angle) rate / x

is enough for an equation of its own; its solution is the reference. The crank runs fast where the slider stands still,
and slows down where it has to be pushed. The force in the rod is the reaction of the joint.
"""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import lcpflex as lf
from lcpflex import gallery
from lcpflex.gallery.mechanisms.space import CRANK_HEIGHT, CRANK_INERTIA, CRANK_RADIUS, ROD, SLIDER


def rate_at(angle: np.ndarray, energy: float) -> np.ndarray:
    """Rate of the crank by its energy (m,) [rad/s]."""
    y, z = CRANK_RADIUS * np.cos(angle), CRANK_HEIGHT + CRANK_RADIUS * np.sin(angle)
    x = np.sqrt(ROD**2 - y**2 - z**2)
    lever = CRANK_HEIGHT * CRANK_RADIUS * np.cos(angle) / x
    return np.asarray(np.sqrt(2.0 * energy / (CRANK_INERTIA + SLIDER * lever**2)))


def run(folder: Path = Path()) -> lf.Result:
    case = gallery.scenes()["free_slider_crank"]
    result = lf.simulate(case.build(), case.duration, case.stepper, record=2e-3)
    angle = np.unwrap(2.0 * np.arctan2(result.q[:, 4], result.q[:, 3]))  # about x
    rate = result.angular_velocity("crank")[:, 0]
    assert abs(angle[-1] - case.reference["theta_5"]) < 1e-4
    assert np.abs(rate / rate_at(angle, float(result.energies.kinetic[0])) - 1.0).max() < 1e-5

    figure = Figure(figsize=(8, 8), layout="constrained")
    speed, place, force = figure.subplots(3, 1, sharex=True)
    speed.plot(result.times, rate, label="event-driven")
    speed.plot(
        result.times, rate_at(angle, float(result.energies.kinetic[0])), ":", color="black", label="by the energy"
    )
    speed.set(ylabel="rate of the crank [rad/s]")
    speed.legend(loc="upper right", bbox_to_anchor=(1.0, 1.22), ncols=2, frameon=False)
    place.plot(result.times, result.point("slider", (0.0, 0.0, 0.0))[:, 0])
    place.set(ylabel="place of the slider [m]")
    rod = result.reaction("rod").force
    force.plot(result.times, np.linalg.norm(rod, axis=1))
    force.set(xlabel="time [s]", ylabel="force in the rod [N]")
    figure.savefig(folder / "spatial_slider_crank.png", dpi=150)
    return result


if __name__ == "__main__":
    print(run().summary())
