"""Penalty against complementarity: what a growing stiffness converges to, how fast, and what it costs.

Two scenes under the same Runge-Kutta steps of the same tolerance, once with a contact spring of the stiffness k, once
with a multiplier (event-driven), which has no stiffness.

*An elastic bar meets a wall.* Bar and spring are in series, and the force rises within some tau = Z/k, Z the impedance
of the bar. Contact then lasts longer by x tau, with 2 (1 + x) exp(-x) = 1, x = 1.678, and the impulse is short by
0.052 Z v tau: errors go with 1/k. The peak force converges, too, to Z v: a wave limits it. All this holds for springs
softer than one element (EA/l). A stiffer one no longer meets the bar but the mass of its last node, which bounces: the
peak grows with sqrt(k), and time and impulse stay at the error of the mesh. A finer mesh moves that on.

*A pendulum meets a stop.* A rigid body stays for half a period of mass and spring, pi sqrt(m/k), and is late by so much
ever after: displacements converge with 1/sqrt(k) to those of an impact with e = 1 (the spring loses nothing), the
impulse, too. The peak force v sqrt(m k) does not converge at all: an impact has an impulse, and no force. With one
mode, the pendulum strikes twice, at the same rate; with three modes six times, where each contact inherits the error of
the one before, and no rate shows before 1e9 N/m. On the softest spring, the rigid one passes through the stop.
"""

import math
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import lcpflex as lf
from lcpflex import gallery
from lcpflex.gallery.mechanisms.flexible import aluminium_strip
from lcpflex.jit.kernel import FloatArray

IMPEDANCE, SPEED, TOUCH, STAY = 30.0, 10.0, 0.5, 2.0 / 3.0  # of the bar [N s/m], [m/s], and its contact: when, how long
LATE = 1.6783470  # 2 (1 + x) exp(-x) = 1
SOFT = np.geomspace(300.0, 3e6, 13)  # stiffnesses under the bar [N/m]
HARD = np.geomspace(1e4, 1e10, 13)  # and under the pendulum [N/m]
SEEN = 11  # so many of them have contacts longer than what is stored
END = 0.45  # of the swing [s]
FINE = lf.ExplicitRungeKutta(rtol=1e-9, atol=1e-12)


def bar(stepper: object, elements: int) -> lf.Result:
    return lf.simulate(gallery.elastic_bar(elements), 1.4, stepper, record=5e-4)


def swing(stepper: object, modes: int) -> lf.Result:
    scene = gallery.pendulum(friction=0.0, restitution=float(isinstance(stepper, lf.EventDriven)))
    strip = aluminium_strip(0.7, 0.028, 0.005).reduce(modes)  # free modes alone: as few masses at the contact
    return lf.simulate(scene.with_bodies({"pendulum": strip}), END, stepper, record=1e-5)


def stay(result: lf.Result) -> float:
    """Duration of contact of the bar [s]."""
    last = int(np.flatnonzero(result.force[:, 0, 0] > 0.0)[-1])
    t, gap = result.times[last : last + 2], result.gap[last : last + 2, 0]
    return float(t[0] - gap[0] * (t[1] - t[0]) / (gap[1] - gap[0]) - TOUCH)


def far(result: lf.Result, exact: lf.Result) -> float:
    """Between the tips of two pendulums, at the end [m]."""
    here, there = (r.point("pendulum", "right")[-1] for r in (result, exact))
    return float(np.hypot(*(here - there)))


def short(result: lf.Result, impulse: float) -> float:
    """Error of the impulse up to the end [N s]."""
    return abs(float(result.impulse[-1, 0, 0]) - impulse)


def slope(stiffness: FloatArray, errors: list[float]) -> float:
    """Exponent of the power law through the points."""
    return float(np.polyfit(np.log(stiffness), np.log(errors), 1)[0])


def draw_rate(axes: Axes, stiffness: FloatArray, errors: list[float], part: slice, colour: str, words: str) -> float:
    """Errors against stiffness, a line through ``part`` of them, and its slope in words."""
    rate = slope(stiffness[part], errors[part])
    axes.loglog(stiffness, errors, "o", color=colour, markersize=5, label=f"{words}: slope {rate:+.2f}")
    fit = np.exp(np.mean(np.log(errors[part])) + rate * (np.log(stiffness) - np.mean(np.log(stiffness[part]))))
    axes.loglog(stiffness[part], fit[part], color=colour, linewidth=1.2)
    return rate


def shade(part: float) -> tuple[float, float, float]:
    """From light orange (soft) to dark brown (hard)."""
    return 0.95 - 0.5 * part, 0.7 - 0.55 * part, 0.3 - 0.2 * part


def draw_bar(row: list[Axes]) -> float:
    force, peak, error, cost = row
    exact = bar(lf.EventDriven(), 100)
    fine = [bar(lf.Smooth(lf.Penalty(k), integrator=lf.Verlet(verlet_step(k, 400))), 400) for k in SOFT]
    coarse = [bar(lf.Smooth(lf.Penalty(k)), 100) for k in SOFT]
    for k, word in ((0, "300"), (3, "3000"), (6, "30 000")):
        result = fine[k]
        force.plot(result.times, result.force[:, 0, 0], color=shade(k / 6), linewidth=1.2, label=f"k = {word} N/m")
    force.plot(
        [0.4, 0.5, 0.5, 7 / 6, 7 / 6, 1.4], [0, 0, 300, 300, 0, 0], "k-", linewidth=1.8, label="rigid wall, exact"
    )
    force.set(xlim=(0.4, 1.4), ylim=(0.0, 620.0), ylabel="contact force [N]", title="elastic bar on a wall")
    force.legend(loc="upper right")
    for runs, elements, colour in ((coarse, 100, "C0"), (fine, 400, "C3")):
        peak.loglog(
            SOFT, [r.contact("wall").peak_force for r in runs], "o-", color=colour, label=f"{elements} elements"
        )
        peak.axvline(900.0 * elements / 10.0, color=colour, linestyle=":")
    peak.axhline(IMPEDANCE * SPEED, color="black", linewidth=1.8, label="rigid wall: Z v")
    peak.set(ylabel="peak force [N]", title="dotted: stiffness EA/l of one element", ylim=(200.0, 9e3))
    steps = [r.steps for r in coarse]
    cost.loglog(SOFT, steps, "o-", color="C0", label="penalty, 100 elements")
    cost.axhline(exact.steps, color="black", linewidth=1.8, label="event-driven, 100 elements")
    times = [abs(stay(r) - STAY) for r in fine]
    rate = draw_rate(error, SOFT, times, slice(0, 5), "C3", "time [s]")
    draw_rate(error, SOFT, [short(r, 200.0) for r in fine], slice(0, 4), "C4", "impulse [N s]")
    error.loglog(
        SOFT,
        [abs(stay(r) - STAY) for r in coarse],
        "o",
        color="C0",
        alpha=0.5,
        markersize=4,
        label="time, 100 elements",
    )
    error.loglog(SOFT, LATE * IMPEDANCE / SOFT, "k--", linewidth=1.0, label="1.678 Z/k")
    error.set(ylabel="error of contact time and impulse")
    return rate


def verlet_step(stiffness: float, elements: int) -> float:
    """Below the limit of the mesh, and of the last node on the spring [s]."""
    length = 10.0 / elements
    fastest = math.sqrt(12.0) * 30.0 / length
    return 1.2 / math.hypot(fastest, math.sqrt(stiffness / (0.25 * length)))


def draw_pendulum(row: list[Axes]) -> tuple[float, lf.Result]:
    force, peak, error, cost = row
    exact = {modes: swing(lf.EventDriven(rtol=1e-9, atol=1e-12), modes) for modes in (0, 1, 3)}
    runs = {modes: [swing(lf.Smooth(lf.Penalty(k), integrator=FINE), modes) for k in HARD] for modes in exact}
    touch = exact[0].events[0].time
    for k, word in ((2, "10⁵"), (4, "10⁶"), (6, "10⁷")):
        result = runs[0][k]
        force.plot(
            1e3 * (result.times - touch), 1e-3 * result.force[:, 0, 0], color=shade(k / 6), label=f"k = {word} N/m"
        )
    impulse = float(exact[0].impulse[-1, 0, 0])
    force.axvline(0.0, color="black", linewidth=1.8, label=f"rigid stop: {impulse:.3f} N s at once")
    force.set(
        xlim=(-0.2, 3.5),
        xlabel="time since the touch [ms]",
        ylabel="contact force [kN]",
        title="rigid pendulum on a stop",
    )
    force.legend(loc="upper right")
    rates = {}
    names = ("rigid", "one mode", "", "three modes")
    for (modes, results), colour in zip(runs.items(), ("C0", "C2", "C1"), strict=True):
        name = names[modes]
        peaks = [r.contact("stop").peak_force for r in results[:SEEN]]
        peak.loglog(HARD[:SEEN], peaks, "o-", color=colour, label=f"{name}: slope {slope(HARD[:SEEN], peaks):+.2f}")
        errors = [far(r, exact[modes]) for r in results]
        if modes < 3:
            rates[modes] = draw_rate(error, HARD, errors, slice(3, None), colour, f"tip [m], {name}")
        else:
            error.loglog(HARD, errors, "o", color=colour, markersize=5, label=f"tip [m], {name}")
        cost.loglog(HARD, [r.steps for r in results], "o-", color=colour, label=f"penalty, {name}")
        cost.axhline(exact[modes].steps, color=colour, linestyle="--", linewidth=1.8)
    cost.plot([], [], "k--", label="event-driven, the same")
    errors = [short(r, impulse) for r in runs[0]]
    draw_rate(error, HARD, errors, slice(3, None), "C4", "impulse [N s], rigid")
    peak.set(ylabel="peak force [N]", title="no limit: v (m k)$^{1/2}$")
    error.set(ylabel="error of tip at the end, and of impulse")
    return rates[0], exact[1]


def run(folder: Path = Path()) -> lf.Result:
    figure = Figure(figsize=(17, 8.5), layout="constrained")
    panels = figure.subplots(2, 4)
    elastic = draw_bar(list(panels[0]))
    rigid, result = draw_pendulum(list(panels[1]))
    assert abs(elastic + 1.0) < 0.03
    assert abs(rigid + 0.5) < 0.01

    panels[0, 0].set_xlabel("time [s]")
    for axes in panels[:, 1:].ravel():
        axes.set_xlabel("stiffness k [N/m]")
        axes.legend(fontsize="small")
    panels[0, 2].set_title("what converges, and how fast")
    panels[0, 3].set_title("cost: steps of six right-hand sides")
    for axes in panels[:, 3]:
        axes.set_ylabel("accepted steps")
    for axes in panels.ravel():
        axes.grid(True, alpha=0.4)
    figure.savefig(folder / "penalty_against_complementarity.png", dpi=110)
    return result


if __name__ == "__main__":
    print(run().summary())
