"""A slider-crank whose slider has play: a closed mechanism that is not closed.

The slider of an engine has 1 mm of play between its guides (Flores, Leine & Glocker 2010). Instead of a joint
there are four corners and two rough surfaces. The slider crosses the gap, strikes a guide with both corners
of one side at once, bounces (e = 0.4) until it settles, slides along, and crosses to the other guide when the
forces of the crank turn over.

The event-driven stepper locates the first impact at 2.6925 ms, where the rod turns back from -49.3 to -52.8
rad/s in no time. Between impacts it needs only a few dozen steps.
"""

from pathlib import Path

from matplotlib.figure import Figure

import lcpflex as lf
from lcpflex import gallery


def run(folder: Path = Path()) -> lf.Result:
    case = gallery.scenes()["slider_crank"]
    result = lf.simulate(case.build(), case.duration, lf.EventDriven())

    first = next(event.time for event in result.events if event.kind == "impact")
    assert abs(first - case.reference["first_impact"]) < 1e-8

    figure = Figure(figsize=(8, 6), layout="constrained")
    gaps, rates = figure.subplots(2, 1, sharex=True)
    for name, style in zip(result.contact_names, ("C0-", "C1--", "C2-", "C3--"), strict=True):
        gaps.plot(1e3 * result.times, 1e3 * result.contact(name).gap, style, label=name)
    gaps.set_ylabel("gap [mm]")
    gaps.legend()
    rates.plot(1e3 * result.times, result.u[:, 0], label="crank")
    rates.plot(1e3 * result.times, result.u[:, 1], label="rod")
    rates.axvline(1e3 * case.reference["first_impact"], color="gray", linestyle=":", label="first impact, reference")
    rates.set(xlabel="time [ms]", ylabel="rate [rad/s]")
    rates.legend()
    figure.savefig(folder / "slider_crank_with_clearance.png", dpi=150)
    return result


if __name__ == "__main__":
    print(run().summary())
