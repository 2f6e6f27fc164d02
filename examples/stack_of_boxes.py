"""A stack of boxes: many contacts at once, more forces than equations.

Ten boxes stand on each other, the top one a hundred times as heavy. Every face rests on two corners: how much
each of them carries, and with which friction, is not unique (two corners may press against each other as they
like). Unique are the sums, which are the weight above, and the motion, and that is *none*: the stack does not
sink, creep or hum. A stiff spring in each contact would do all three, the more so under the heavy box.

The arrows show one of the many admissible distributions, the one the solver found; the chart their sums.
"""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import lcpflex as lf
from lcpflex import gallery


def run(folder: Path = Path()) -> lf.Result:
    case = gallery.scenes()["heavy_stack"]
    result = lf.simulate(case.build(), 0.25, case.stepper)

    drift = np.abs(result.q - result.q[0]).max()
    assert abs(drift - case.reference["drift"]) < 1e-9

    figure = Figure(figsize=(8, 6), layout="constrained")
    scene, chart = figure.subplots(1, 2)
    result.draw(0.25, axes=scene)
    carried = np.sort(result.force[-1, :, 0][result.force[-1, :, 0] > 0.0])
    chart.barh(np.arange(10), carried[::-1], height=0.6, label="normal force, sum of both corners")
    weights = 9.81 * (100.0 + np.arange(9, -1, -1))
    chart.plot(weights, np.arange(10), "k|", markersize=14, label="weight above")
    chart.set(
        xlabel="force [N]",
        ylabel="under box",
        xlim=(900, 1130),
        ylim=(-0.7, 10.7),
        yticks=range(10),
        yticklabels=range(1, 11),
    )
    chart.legend(loc="upper right")
    figure.savefig(folder / "stack_of_boxes.png", dpi=150)
    return result


if __name__ == "__main__":
    print(run().summary())
