"""A heap settles: a hundred discs fall into a box and come to rest with their weight.

While they fall and rearrange, islands of discs that touch form, join and part from step to step, and each poses a
contact problem of its own. The box feels their momentum: its forces are several times the weight at first, and the
weight when all is at rest. Two residuals judge each step, one relative to the free velocity (strict), one relative to
all terms that cancel; both belong to the result.
"""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import lcpflex as lf
from lcpflex import gallery

DISCS = 100


def run(folder: Path = Path()) -> lf.Result:
    result = lf.simulate(gallery.heap(discs=DISCS), 3.0, lf.MoreauJean(step=1e-3), record=0.02)
    floor = [k for k, name in enumerate(result.contact_names) if name.endswith("ground.half_plane1")]
    walls = [k for k, name in enumerate(result.contact_names) if name.endswith(("half_plane2", "half_plane3"))]
    sign = [-1.0 if result.contact_names[k].endswith("half_plane2") else 1.0 for k in walls]  # t points down at x = 0
    upward = result.impulse[:, floor, 0].sum(axis=1) + result.impulse[:, walls, 1] @ np.array(sign)
    weight = DISCS * 9.81
    momentum = result.u[:, 1::3].sum(axis=1)  # 1 kg each
    assert np.abs(upward - weight * result.times - momentum).max() < 1e-8 * upward[-1]

    figure = Figure(figsize=(9, 6.5), layout="constrained")
    axes = figure.subplots(2, 2)
    for t, place in zip((0.3, 3.0), axes[0], strict=True):
        result.draw(t, axes=place)
    middle = 0.5 * (result.times[1:] + result.times[:-1])
    axes[1, 0].plot(middle, np.diff(upward) / np.diff(result.times) / weight)
    axes[1, 0].axhline(1.0, color="gray", linestyle=":")
    axes[1, 0].set(xlabel="time [s]", ylabel="upward force of the box / weight")
    axes[1, 1].semilogy(result.times, np.maximum(result.strict, 1e-17), ".", label="relative to the free velocity")
    axes[1, 1].semilogy(result.times, np.maximum(result.residual, 1e-17), ".", label="relative to all terms")
    axes[1, 1].set(xlabel="time [s]", ylabel="largest residual in 20 steps")
    axes[1, 1].legend()
    figure.savefig(folder / "settling_heap.png", dpi=120)
    return result


if __name__ == "__main__":
    print(run().summary())
