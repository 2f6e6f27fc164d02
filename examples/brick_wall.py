"""A brick wall, at rest and hit by a ball: what is unique among hundreds of forces.

24 bricks and half bricks stand in running bond without mortar, each on up to four corners. How these share the load is
not unique; that each course carries exactly what is above it is. Then a ball of 5 kg arrives at 6 m/s. While it passes
its momentum on, nothing but friction on the ground takes any of it away: the impulse of the ground, added to the
momentum of all bodies, is what the ball came with, at every instant.
"""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import lcpflex as lf
from lcpflex import gallery

SPEED, BALL = 6.0, 5.0


def run(folder: Path = Path()) -> lf.Result:
    step = lf.MoreauJean(step=1e-3)
    resting = lf.simulate(gallery.brick_wall(), 0.1, step)
    assert np.abs(resting.q - resting.q[0]).max() < 1e-9
    supports = [k for k, name in enumerate(resting.contact_names) if "ground" in name]
    assert abs(resting.force[-1, supports, 0].sum() / (24.0 * 9.81) - 1.0) < 1e-8

    result = lf.simulate(gallery.brick_wall(speed=SPEED, ball=BALL), 0.6, step, record=5e-3)
    bodies = result.compiled.layout.bodies
    ends = [f"brick {course}.{k}" for course in (2, 4, 6) for k in (1, 5)]
    mass = np.array([BALL if name == "ball" else 0.5 if name in ends else 1.0 for name in bodies])
    ball = BALL * result.u[:, 3 * bodies.index("ball")]
    total = result.u[:, 0::3] @ mass
    supports = [k for k, name in enumerate(result.contact_names) if "ground" in name]
    ground = result.impulse[:, supports, 1].sum(axis=1)  # along t = (1, 0) of the floor
    assert np.abs(total - ground - BALL * SPEED).max() < 1e-8 * BALL * SPEED

    figure = Figure(figsize=(11, 7.5), layout="constrained")
    axes = figure.subplots(2, 2)
    for t, place in zip((0.0, 0.1, 0.6), axes.flat[:3], strict=True):
        result.draw(t, axes=place)
    chart = axes[1, 1]
    chart.plot(result.times, total, label="all bodies")
    chart.plot(result.times, ball, "--", label="the ball")
    chart.plot(result.times, -ground, ":", label="given to the ground")
    chart.plot(result.times, total - ground, "k", linewidth=0.8, label="all bodies and ground")
    chart.set(xlabel="time [s]", ylabel="momentum to the right [N s]")
    chart.legend()
    figure.savefig(folder / "brick_wall.png", dpi=120)
    return result


if __name__ == "__main__":
    print(run().summary())
