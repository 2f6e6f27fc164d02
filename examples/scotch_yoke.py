"""A scotch yoke whose pin has 0.1 mm of play in a curved slot, under every law of line contact.

The slot has a mean radius of 60 mm (tracks of 68 and 52 mm, ends of 8 mm) over 120 degrees; the pin has 7.9 mm. Radii,
masses and inertias are those of the slotted joint in the review of Autiero et al. 2022; the length of the contact,
10 mm, is that of a solid steel pin of the mass given there. The rest is not stated there and is OUR choice, so that no
number of the review can be reproduced: the crank, 52 mm long, turns in a horizontal plane at 60 rad/s, from 31 degrees;
the slider is guided along x, and the centre of the arc lies behind it, on the side of the crank's bearing. So the
slider nearly rests while the pin runs along the middle of the slot (with a crank of 60 mm it would rest, and never come
around), and at the top and the bottom the pin reaches 0.04 mm into the ends. Nothing rubs. All is steel, and e = 0.5 by
the exact hysteresis damping.

The table of the review has a column of initial conditions with two entries: 31 degrees in the row of the frame, which
is taken for the angle of the crank at the start, and 0, without a unit, in that of the crank. If that is its angular
velocity, the yoke starts from rest, and what sets it in motion is a torque or a spin-up that is not printed. It is NOT
used here: the crank turns at its speed from the start on, and the first revolution differs from one from rest.

Each part of the slot has its own law, from its own radii: external contact at the inner track, internal at the outer
one and the ends. Laws that know internal contact only (ESDU, Liu, Persson) leave the inner track to Johnson's. Laws are
lenient: Pereira's is given for clearances up to 10 mm, and the outer track has 60.1 mm. Goldsmith's with m = 1 depends
on the units (here SI), Persson's is closed by the geometry of rigid circles, and one reading of ESDU is three times
softer than all others. Where the pin goes over the seam from a track to an end, two laws meet the same indentation with
different forces: the jump (from 2.8 to 4.9 kN by the softer ESDU, from 3.6 to 0.6 kN by Lankarani & Nikravesh) is a
defect of such models, and makes or takes energy. The contact that begins there, indented, takes its impact speed from
the energy that it finds.

The same motion without any law, by complementarity and Newton's impacts with the same e, is the reference. While the
pin lies on a track the mean force is the same for all, as the acceleration of the slider is: on the outer track it is
that of rigid bodies in closed form. How hard an impact is, is a matter of the law.
"""

import math
import warnings
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle

import lcpflex as lf
from lcpflex import laws

MIDDLE, WIDTH, PIN, LENGTH = 60e-3, 16e-3, 7.9e-3, 10e-3  # of the slot and its pin [m]
HALF = math.radians(60.0)  # of the arc on either side
CRANK, SPEED, START = 52e-3, 60.0, math.radians(31.0)  # [m], [rad/s], [rad]
RESTITUTION = 0.5
DURATION = 2.0 * math.pi / SPEED
STEEL = laws.Material(youngs_modulus=207e9, poissons_ratio=0.3)


def along(theta: float) -> float:
    """Where the centre of the arc is along the guide, with the pin on the middle line."""
    return CRANK * math.cos(theta) - math.sqrt(MIDDLE**2 - (CRANK * math.sin(theta)) ** 2)


def scene(law=None) -> lf.Scene:
    """The yoke; ``law`` makes the force law of a part from its pair of cylinders, None: by complementarity."""
    made = lf.Scene(gravity=(0.0, 0.0))
    tip = CRANK * np.array([math.cos(START), math.sin(START)])
    velocity = SPEED * np.array([-tip[1], tip[0]])
    crank = made.add(
        lf.RigidBody(0.090, 30.40e-6, points={"bearing": (-0.5 * CRANK, 0.0), "tip": (0.5 * CRANK, 0.0)}),
        "crank", 0.5 * tip, START, 0.5 * velocity, SPEED,
    )  # fmt: skip
    pin = made.add(lf.RigidBody(0.015, 0.48e-6), "pin", tip, velocity=velocity)
    h = 1e-6
    slip = SPEED * (along(START + h) - along(START - h)) / (2.0 * h)
    slider = made.add(lf.RigidBody(0.353, 3495.6e-6), "slider", (along(START), 0.0), velocity=(slip, 0.0))
    made.join(lf.Revolute(crank.point("bearing"), made.ground.at(0.0, 0.0), name="bearing"))
    made.join(lf.DrivenAngle(crank.point("bearing"), made.ground.at(0.0, 0.0), lf.Table([0.0, 1.0], [0.0, SPEED])))
    made.join(lf.Revolute(pin.point("center"), crank.point("tip"), name="pin"))
    made.join(lf.Prismatic(slider.point("center"), made.ground.at(0.0, 0.0), axis=(1.0, 0.0), name="guide"))
    disc = pin.circle("center", PIN)
    slot = slider.curved_slot("center", MIDDLE, WIDTH, -HALF, 2.0 * HALF)
    if law is None:
        made.contact_slot(disc, slot, restitution=RESTITUTION, name="slot")
        return made
    damping = laws.HysteresisDamping(RESTITUTION)
    pairs = [laws.CylinderPair.between(part, disc, LENGTH, STEEL) for part in slot.parts]
    made.contact_slot(
        disc, slot, name="slot", law=lf.SlotParts(*(laws.ContactLaw(law(pair), damping) for pair in pairs))
    )
    return made


def lenient(kind, **options):
    """The law of a part; the inner track has Johnson's where ``kind`` knows internal contact only."""

    def of(pair: laws.CylinderPair):
        outside_only = kind in (laws.Esdu78035, laws.Liu, laws.Persson) and not pair.is_internal
        return laws.Johnson(pair, lenient=True) if outside_only else kind(pair, lenient=True, **options)

    return of


def fitted(pair: laws.CylinderPair) -> laws.PowerLaw:
    """The power law nearest to Johnson's up to 3 kN."""
    return laws.fit_power_law(laws.Johnson(pair, lenient=True), (0.0, 3000.0)).law


LAWS = {
    "Johnson": lenient(laws.Johnson),
    "power law fitted to Johnson's": fitted,
    "Radzimovsky": lenient(laws.Radzimovsky),
    "Radzimovsky, handbook": lenient(laws.Radzimovsky, handbook=True),
    "Dubowsky & Freudenstein": lenient(laws.DubowskyFreudenstein),
    "Goldsmith, m = 1": lenient(laws.Goldsmith),
    'ESDU 78035, "pi"': lenient(laws.Esdu78035),
    'ESDU 78035, "review"': lenient(laws.Esdu78035, reading="review"),
    "Pereira et al.": lenient(laws.Pereira),
    "Liu et al.": lenient(laws.Liu),
    "Persson, closed by geometry": lenient(laws.Persson),
    "Lankarani & Nikravesh": lenient(laws.LankaraniNikraveshCylinder),
}
QUIET = np.radians([145.0, 235.0])  # crank angles between which the pin lies on the outer track


def degrees(result: lf.Result) -> np.ndarray:
    """Crank angle of the stored instants."""
    return np.degrees(START + SPEED * result.times)


def pin_force(result: lf.Result) -> np.ndarray:
    """Normal force of the part that the pin touches [N]; on a seam, where it touches two, the larger."""
    return np.max([result.contact(name).force[:, 0] for name in result.contact_names], axis=0)


def mean_force(result: lf.Result) -> float:
    """On the outer track, over the quiet part of the revolution [N]."""
    times = (QUIET - START) / SPEED
    impulse = np.interp(times, result.times, result.contact("slot.outer").impulse[:, 0])
    return float(np.diff(impulse)[0] / np.diff(times)[0])


def rigid_mean() -> float:
    """The same of a pin that keeps touching: m x'' / cos(phi), with phi the direction of the pin seen from the arc."""
    radius = MIDDLE + 0.5 * WIDTH - PIN
    theta = np.linspace(*QUIET, 2001)
    sine = CRANK * np.sin(theta) / radius
    cosine = np.sqrt(1.0 - sine**2)
    rate = CRANK * np.cos(theta) / (radius * cosine)  # dphi / dtheta
    turn = sine / cosine * (rate**2 - 1.0)
    x = -CRANK * np.cos(theta) + radius * (cosine * rate**2 + sine * turn)
    return float(np.trapezoid(0.353 * SPEED**2 * x / cosine, theta) / (QUIET[1] - QUIET[0]))


def first_impact(result: lf.Result) -> tuple[np.ndarray, np.ndarray]:
    """Time since the pin strikes the outer track for the first time [ms], and its force there [kN]."""
    force = result.contact("slot.outer").force[:, 0]
    touch = int(np.argmax(force > 0.0)) - 1
    return 1e3 * (result.times - result.times[touch]), 1e-3 * force


def deepest(result: lf.Result) -> float:
    """Largest indentation [um]."""
    return 1e6 * float(result.penetration.max())


def draw_mechanism(axes: Axes) -> None:
    """The slot at the start, with the crank and the pin, and the way of the pin about the bearing."""
    turn = np.linspace(-HALF, HALF, 200)
    x = 1e3 * along(START)
    for radius in (MIDDLE - 0.5 * WIDTH, MIDDLE + 0.5 * WIDTH):
        axes.plot(x + 1e3 * radius * np.cos(turn), 1e3 * radius * np.sin(turn), "k")
    for sign in (-1.0, 1.0):
        center = 1e3 * MIDDLE * np.array([math.cos(HALF), sign * math.sin(HALF)])
        cap = sign * (HALF + np.linspace(0.0, math.pi, 60))
        axes.plot(x + center[0] + 8.0 * np.cos(cap), center[1] + 8.0 * np.sin(cap), "k")
    tip = 1e3 * CRANK * np.array([math.cos(START), math.sin(START)])
    axes.plot(*(1e3 * CRANK * f(np.linspace(0.0, 2.0 * math.pi, 200)) for f in (np.cos, np.sin)), "C0:", linewidth=1)
    axes.plot([0.0, tip[0]], [0.0, tip[1]], "C0o-", markersize=4)
    axes.add_patch(Circle(tuple(tip), 7.9, color="C0", alpha=0.4))
    axes.plot([-70.0, 70.0], [0.0, 0.0], color="gray", linestyle="-.", linewidth=0.8)
    axes.text(-68.0, 3.0, "guide", color="gray", fontsize=8)
    axes.set(aspect="equal", xlabel="x [mm]", ylabel="y [mm]", title="slot, crank and pin at the start")


def draw_revolution(axes: Axes, reference: lf.Result, result: lf.Result) -> None:
    """Pin force over one turn of the crank, and where the pin is."""
    axes.semilogy(degrees(result), np.maximum(pin_force(result), 1.0), "C0", linewidth=0.6, label="Johnson's law")
    axes.semilogy(
        degrees(reference), np.maximum(pin_force(reference), 1.0), "k", linewidth=1.2, label="complementarity"
    )
    places = ((65, "inner track"), (93, "end"), (190, "outer track"), (270, "end"), (325, "inner track"))
    for angle, place in places:
        axes.text(angle, 9e3, place, ha="center", va="center", fontsize=8)
    axes.set(xlim=(31, 391), ylim=(5, 1.5e4), xlabel="crank angle [deg]", ylabel="pin force [N]")
    axes.set_xticks(range(60, 391, 30))
    axes.set_title("one turn: impacts after each change of sides, the same force in between")
    axes.legend(loc="lower center", ncols=2, fontsize=8)


def draw_impacts(panels: Sequence[Axes], results: dict[str, lf.Result]) -> None:
    """The first impact on the outer track, one law a panel, all others behind it."""
    pulses = {name: first_impact(result) for name, result in results.items()}
    for axes, (name, (time, force)) in zip(panels, pulses.items(), strict=True):
        for other in pulses.values():
            axes.plot(*other, color="lightgray", linewidth=0.7)
        axes.plot(time, force, "C0", linewidth=1.6)
        axes.set_title(name, fontsize=9)
        peak = force[(time >= 0.0) & (time < 0.6)].max()
        axes.text(0.97, 0.9, f"{peak:.2f} kN", transform=axes.transAxes, ha="right", va="top", fontsize=9)
        axes.set(xlim=(-0.02, 0.6), ylim=(0.0, 7.0))
        axes.label_outer()


def draw_spread(panels: Sequence[Axes], reference: lf.Result, results: dict[str, lf.Result]) -> None:
    """What all agree on, and what they do not."""
    names = list(results)
    rows = np.arange(len(names))[::-1]
    exact = mean_force(reference)
    numbers = (
        ([1e-3 * pin_force(result).max() for result in results.values()], "largest pin force [kN]"),
        ([deepest(result) for result in results.values()], "deepest indentation [um]"),
        (
            [abs(mean_force(result) / exact - 1.0) for result in results.values()],
            f"mean force, 145 to 235 deg, relative to the\n{exact:.2f} N by complementarity, less 1",
        ),
    )
    for axes, (values, label) in zip(panels, numbers, strict=True):
        axes.plot(values, rows, "C0o")
        axes.set(yticks=rows, xlabel=label)
        axes.grid(axis="y", color="lightgray")
        axes.set_xlim(left=0.0, right=1.15 * max(values))
    panels[0].set_yticklabels(names, fontsize=8)
    for axes in panels[1:]:
        axes.set_yticklabels([])
    panels[2].set_xscale("log")
    panels[2].set_xlim(1e-6, 1e-3)


def picture(reference: lf.Result, results: dict[str, lf.Result]) -> Figure:
    """Mechanism and one turn; one impact by each law; the spread."""
    figure = Figure(figsize=(12, 14), layout="constrained")
    top, middle, bottom = figure.subfigures(3, 1, height_ratios=(1.0, 1.9, 0.9))
    left, right = top.subplots(1, 2, width_ratios=(1.0, 2.2))
    draw_mechanism(left)
    draw_revolution(right, reference, results["Johnson"])
    panels = middle.subplots(3, 4, sharex=True, sharey=True).ravel()
    draw_impacts(panels, results)
    middle.suptitle("first impact on the outer track, by each law (gray: all others; *: beyond its range of validity)")
    middle.supxlabel("time since touch [ms]", fontsize=10)
    middle.supylabel("pin force [kN]", fontsize=10)
    draw_spread(bottom.subplots(1, 3), reference, results)
    return figure


def run(folder: Path = Path()) -> lf.Result:
    reference = lf.simulate(scene(), DURATION, lf.EventDriven(), record=2e-5)
    stepper = lf.Smooth(laws.ContactLaw(laws.PowerLaw(1e8)))  # no contact is left to this law
    results = {}
    for name, law in LAWS.items():
        with warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always", lf.ModelWarning)
            yoke = scene(law)
        result = lf.simulate(yoke, DURATION, stepper, record=5e-6)
        beyond = told or any("beyond" in warning for warning in result.warnings)
        results[f"{name} *" if beyond else name] = result
    assert abs(mean_force(reference) / rigid_mean() - 1.0) < 1e-6
    picture(reference, results).savefig(folder / "scotch_yoke.png", dpi=130)
    return reference


if __name__ == "__main__":
    print(run().summary())
