"""A pile of flexible strips: bodies that bend under what lies on them.

Eight aluminium strips fall flat onto each other and onto two round supports, the next one to the right and to the left
in turn. Each has four modes and eleven places on either face that may touch. They sag between the supports by some
micrometres, and in the end the two supports carry the weight, however the strips share it.
"""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import lcpflex as lf
from lcpflex import gallery


def run(folder: Path = Path()) -> lf.Result:
    case = gallery.scenes()["strip_pile"]
    result = lf.simulate(case.build(), case.duration, case.stepper, record=1e-3)
    points = result.contact_points
    ground = np.isin(points.contact, [k for k, name in enumerate(result.contact_names) if "ground" in name])
    n = points.normal
    force = points.force[:, :1] * n + points.force[:, 1:] * np.column_stack([n[:, 1], -n[:, 0]])
    carried = np.abs(np.bincount(points.record[ground], force[ground, 1], len(result.times)))
    weight = case.reference["weight"]
    assert abs(carried[-1] / weight - 1.0) < 1e-6

    figure = Figure(figsize=(9, 7), layout="constrained")
    upper, lower = figure.subfigures(2, 1, height_ratios=(3, 2))
    result.draw(case.duration, axes=upper.subplots())
    chart, shape = lower.subplots(1, 2)
    chart.plot(1e3 * result.times, carried / weight)
    chart.axhline(1.0, color="gray", linestyle=":")
    chart.set(xlabel="time [ms]", ylabel="force of the supports / weight", ylim=(0, None))
    places = np.linspace(0.0, 0.5, 11)
    for name in ("strip 1", "strip 8"):
        line = np.array([result.point(name, (x, -0.0025))[-1] for x in places])
        sag = line[:, 1] - np.interp(0.25, places, np.linspace(line[0, 1], line[-1, 1], 11))
        shape.plot(line[:, 0], 1e6 * sag, "o-", markersize=3, label=name)
    shape.set(xlabel="x [m]", ylabel="height above its ends' middle [um]")
    shape.legend()
    figure.savefig(folder / "strip_pile.png", dpi=120)
    return result


if __name__ == "__main__":
    print(run().summary())
