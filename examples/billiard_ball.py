"""A billiard ball that is struck off its centre: it slides on a curve, and then rolls on a straight line.

A ball of radius R starts with 2 m/s and (15, -30, 7) rad/s. Where it touches the cloth it slides with

    gamma = v - R omega x n,   |gamma| falls by 7/2 mu g a second, and its direction stays

so that friction is constant, the path a parabola, and rolling begins at 2 |gamma_0| / (7 mu g) = .4207 s with
v = v_0 - 2/7 gamma_0. The spin about the normal is touched by nothing: contact in a point has no torque about it. The
event-driven stepper finds the end of sliding; steps of Moreau-Jean pass over it, with errors of order h^2 here, where
the direction of sliding does not turn.
"""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import lcpflex as lf
from lcpflex import gallery

BALL = 0.028575  # radius [m]


def run(folder: Path = Path()) -> lf.Result:
    case = gallery.scenes()["billiard_ball"]
    result = lf.simulate(case.build(), 0.8, lf.EventDriven(), record=2e-3)
    rolls = case.reference["rolls"]
    late = result.times > rolls
    assert np.abs(result.u[late, 0] - case.reference["v_x"]).max() < 1e-6
    assert np.abs(result.u[late, 1] - case.reference["v_y"]).max() < 1e-6

    spin = result.angular_velocity("ball")
    slip = np.hypot(result.u[:, 0] - BALL * spin[:, 1], result.u[:, 1] + BALL * spin[:, 0])
    figure = Figure(figsize=(10, 4), layout="constrained")
    path, speeds = figure.subplots(1, 2)
    path.plot(result.q[:, 0], result.q[:, 1], label="slides")
    path.plot(result.q[late, 0], result.q[late, 1], linewidth=3, label="rolls")
    path.set(xlabel="x [m]", ylabel="y [m]", title="path of the centre, seen from above")
    path.legend()
    speeds.plot(result.times, result.u[:, 0], label="v_x")
    speeds.plot(result.times, result.u[:, 1], label="v_y")
    speeds.plot(result.times, slip, label="speed of sliding")
    speeds.axvline(rolls, color="gray", linestyle=":", label="closed form: rolls")
    speeds.set(xlabel="time [s]", ylabel="speed [m/s]")
    speeds.legend()
    figure.savefig(folder / "billiard_ball.png", dpi=150)
    return result


if __name__ == "__main__":
    print(run().summary())
