"""One scene under every stepper: what the idea of contact changes, and what it does not.

A flexible aluminium strip swings down onto a hemisphere, with friction, as in ``flexible_pendulum_on_hemisphere``. Four
ideas of contact meet the same strip:

*Rigid contact with impacts* (event-driven, Moreau-Jean, nonsmooth generalised-alpha): each touch is an impact without
restitution, in which the modes at the contact lose their energy at once. Three schemes of very different kinds find
the same impulses and the same motion, to the error of their steps.

*Massless boundary*: the highest modes of the strip are its compliance at the contact and have no mass, so that nothing
is lost in an impact. Its motion goes on with all its energy.

*Penalty springs*: soft ones store the energy and give it back, too; how much of the motion is the strip's own and how
much that of the spring depends on a stiffness that somebody has to choose.

The impulse up to the end differs by some ten per cent between these models, the small one of friction even in its
sign; within rigid contact the normal impulse agrees to half a per cent. A peak force means little there: an impulse is
shared out over one step, or over no time at all.
"""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import lcpflex as lf
from lcpflex import gallery

STEP = 2e-6  # [s]
FINE = lf.AdaptiveStep(rtol=1e-6, atol=1e-8)

STEPPERS = {
    "event-driven": lf.EventDriven(),
    "Moreau-Jean": lf.MoreauJean(step=STEP),
    "Moreau-Jean, adaptive": lf.MoreauJean(step=STEP, adaptive=FINE),
    "generalised-alpha": lf.GeneralizedAlpha(step=STEP),
    "massless boundary": lf.MasslessBoundary(step=STEP),
    "massless boundary, 8 of 15 modes": lf.MasslessBoundary(step=STEP, dynamic_modes=8),
    "springs of 1e8 N/m": lf.Smooth(lf.Penalty(1e8)),
    "springs of 1e6 N/m": lf.Smooth(lf.Penalty(1e6)),
    "springs of 1e6 N/m, stiff steps": lf.Smooth(lf.Penalty(1e6), integrator=lf.Stiff()),
}


def run(folder: Path = Path()) -> lf.Result:
    results = {
        name: lf.simulate(gallery.hemisphere_pendulum(modes=15), 0.06, stepper, record=1e-5)
        for name, stepper in STEPPERS.items()
    }
    exact = results["event-driven"]
    for name in ("Moreau-Jean", "Moreau-Jean, adaptive", "generalised-alpha"):  # the same model, other schemes
        assert abs(impulse(results[name]) / impulse(exact) - 1.0) < 0.01
    assert all(result.complete for result in results.values())
    warned = [name for name, result in results.items() if result.warnings]
    assert all("massless" in name for name in warned)  # of energy that steps make, and of too few modes
    print(table(results), "\n")

    figure = Figure(figsize=(12, 5.5), layout="constrained")
    pressed, tip = figure.subplots(1, 2)
    styles = ["-", "--", ":", "-.", "-", "--", "-", "--", ":"]
    colours = ["C0", "C0", "C0", "C0", "C1", "C1", "C2", "C2", "C2"]
    for (name, result), style, colour in zip(results.items(), styles, colours, strict=True):
        since = 1e3 * (result.times - 0.0292)
        look = {"color": colour, "linestyle": style, "label": name}
        pressed.plot(since, 1e3 * result.contact("hemisphere").impulse[:, 0], **look)
        tip.plot(since, 1e3 * result.point("pendulum", "right")[:, 1], **look)
    pressed.set(xlim=(-1.0, 31.0), xlabel="time since the first touch [ms]", ylabel="normal impulse so far [mN s]")
    tip.set(xlim=(-1.0, 31.0), xlabel="time since the first touch [ms]", ylabel="height of the tip [mm]", ylim=(-7, -3))
    for axes in (pressed, tip):
        axes.grid(True, alpha=0.4)
    pressed.legend(frameon=False, fontsize="small")
    figure.savefig(folder / "many_laws.png", dpi=150)
    return exact


def impulse(result: lf.Result) -> float:
    return float(result.impulse[-1, 0, 0])


def table(results: dict[str, lf.Result]) -> str:
    """What each stepper finds, and what it costs."""
    heads = ("stepper", "first touch", "impulse", "friction", "peak force", "tip at the end", "energy", "steps", "time")
    units = ("", "ms", "mN s", "mN s", "N", "mm", "mJ lost", "", "ms")
    rows = [heads, units]
    for name, result in results.items():
        contact = result.contact("hemisphere")
        lost = result.energies.stored[0] - result.energies.stored[-1]
        numbers = (
            f"{1e3 * (contact.first_touch or np.nan):.3f}",
            f"{1e3 * contact.impulse[-1, 0]:.2f}",
            f"{1e3 * contact.impulse[-1, 1]:.2f}",
            f"{contact.peak_force:.0f}",
            f"{1e3 * result.point('pendulum', 'right')[-1, 1]:.2f}",
            f"{1e3 * lost:.3f}",
            f"{result.steps}",
            f"{1e3 * result.wall_time:.0f}",
        )
        rows.append((name, *numbers))
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return "\n".join(
        "  ".join(
            text.ljust(width) if k == 0 else text.rjust(width)
            for k, (text, width) in enumerate(zip(row, widths, strict=True))
        )
        for row in rows
    )


if __name__ == "__main__":
    print(run(Path()).summary())
