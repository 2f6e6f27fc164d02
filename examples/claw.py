"""A claw closes on a wall that gives way: contact forces by multiplier, and by a stiff law.

One finger, turned by 1.6 N m, strikes a wall of 1 kg on a spring (10, 50 or 200 N/m) and a damper (5 N s/m), and
presses on it; or two, with the wall between them, of which the second comes later. Restitution is 0 or 0.5. After Silva
et al., who print torque, wall, damper, e = 0, the spring of 10 N/m and fingers of 1 m; chosen here: fingers are bars of
0.75 kg, let go at rest, opened by 30 and 60 degrees from where they meet the wall at its place of rest; no gravity, no
friction. Their own model, with gravity and both fingers in step, is in ``claw_in_step.py``.

*By multiplier* (event-driven): an impact takes no time, and its law is Newton's. *By a law* (smooth): Hertz' force,
1e7 N/m^1.5, with hysteresis damping of the exact factor, so that the prescribed e = 0.5 comes out. The motion is the
same but for the impacts themselves, where the law finds 800 N for 2.4 ms, and the multiplier an impulse. For e = 0
there is no such factor: it is infinite. The law has e = 0.05 instead, with a peak of 1550 N, and small bounces.

The wall by the law is within 0.7 mm of that by multiplier with one finger, and within 1.1 mm with two, between which it
is struck again and again: the order of impacts then depends on the few milliseconds that the contacts of the law last
(``tests/convergence/test_penalty_to_complementarity.py`` has the rate at which that vanishes with the stiffness).

What must come out: at rest, one finger presses with F = T/(L cos a) = k L sin a, two with T/L each on any spring.
"""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import lcpflex as lf
from lcpflex import gallery
from lcpflex.gallery.mechanisms.claws import resting_force
from lcpflex.jit.kernel import FloatArray

STIFFNESSES = (10.0, 50.0, 200.0)  # of the wall's spring [N/m]
COLOURS = ("C0", "C1", "C2")
SHOWN, END = 2.0, 6.0  # [s]
WINDOW = 0.02  # contact forces are shown as means over it [s]
TEXT = f"mean over {1e3 * WINDOW:g} ms: impacts go beyond\ngrey: at rest, closed form"
CASES = ((1, 0.0), (1, 0.5), (2, 0.0), (2, 0.5))  # fingers, restitution


def law(restitution: float) -> lf.ContactLaw:
    return lf.ContactLaw(
        lf.laws.PowerLaw(1e7, exponent=1.5), lf.laws.HysteresisDamping(restitution=max(restitution, 0.05))
    )


def mean_force(result: lf.Result, contact: str) -> tuple[FloatArray, FloatArray]:
    """Times [s] and contact force, its mean over ``WINDOW`` [N]: impulses count in it as forces do."""
    edges = np.arange(0.0, SHOWN, 0.25 * WINDOW)
    impulse = [np.interp(edges + shift, result.times, result.contact(contact).impulse[:, 0]) for shift in (0.0, WINDOW)]
    return edges + 0.5 * WINDOW, (impulse[1] - impulse[0]) / WINDOW


def angle(result: lf.Result, finger: str) -> FloatArray:
    """Of a finger, from the perpendicular to the guide [degrees]."""
    tip, hinge = (result.point(finger, name) for name in ("bottom", "top"))
    across, down = (tip - hinge).T * np.array([[1.0], [-1.0]])
    return np.degrees(np.arctan2(across, down))


def draw(column: np.ndarray, results: tuple[lf.Result, lf.Result], case: tuple[int, float, int]) -> None:
    """Angles and wall in the panels of all springs, the force in that of its spring."""
    fingers, _, spring = case
    for result, style in zip(results, (f"{COLOURS[spring]}-", "k:"), strict=True):
        for name in ("left", "right")[:fingers]:
            column[0].plot(result.times, angle(result, f"{name} finger"), style, linewidth=1.6)
        column[1].plot(result.times, 1e3 * result.point("wall", "center")[:, 0], style, linewidth=1.6)
        column[2 + spring].plot(*mean_force(result, "left"), style, linewidth=1.6)
    column[2 + spring].axhline(resting_force(STIFFNESSES[spring], fingers), color="grey", linewidth=0.8)


def run(folder: Path = Path()) -> lf.Result:
    figure = Figure(figsize=(16, 14), layout="constrained")
    panels = figure.subplots(5, 4, sharex=True, sharey="row", height_ratios=(1.2, 1.2, 1, 1, 1))
    for column, (fingers, restitution) in zip(panels.T, CASES, strict=True):
        for spring, stiffness in enumerate(STIFFNESSES):
            scene = gallery.claw(stiffness, restitution, fingers)
            results = tuple(
                lf.simulate(scene, END, stepper, record=1e-3)
                for stepper in (lf.EventDriven(), lf.Smooth(law(restitution)))
            )
            for result in results:
                assert abs(result.force[-1, 0, 0] / resting_force(stiffness, fingers) - 1.0) < 1e-3
            draw(column, results, (fingers, restitution, spring))
        column[0].set_title(f"{('one finger', 'two fingers')[fingers - 1]}, e = {restitution:g}")
        column[-1].set(xlabel="time [s]", xlim=(0.3, SHOWN))

    for stiffness, colour in zip(STIFFNESSES, COLOURS, strict=True):
        panels[0, 0].plot([], [], colour, label=f"multiplier, spring {stiffness:g} N/m")
    panels[0, 0].plot([], [], "k:", linewidth=1.6, label="stiff law, the same")
    panels[0, 0].legend(loc="upper right")
    panels[0, 0].set(ylabel="angle of the fingers [degrees]", ylim=(-15.0, 45.0))
    panels[1, 0].set_ylabel("displacement of the wall [mm]")
    for axes, stiffness in zip(panels[2:, 0], STIFFNESSES, strict=True):
        axes.set(ylabel=f"force of the left finger [N],\nspring {stiffness:g} N/m", ylim=(0.0, 9.0))
    panels[2, 0].text(0.98, 0.92, TEXT, transform=panels[2, 0].transAxes, ha="right", va="top", fontsize="small")
    for axes in panels.ravel():
        axes.grid(True, alpha=0.4)
    figure.savefig(folder / "claw.png", dpi=100)
    return results[0]


if __name__ == "__main__":
    print(run().summary())
