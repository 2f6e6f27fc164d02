"""Two spheres meet under every dissipative law: loops of force and indentation, and the restitution that comes out.

Steel spheres of 15 mm radius fly at each other with 1 m/s each, without friction and weight. The elastic law is that
of Hertz,

    F = (4/3) E* R^(1/2) delta^(3/2),   1/R = 1/R_1 + 1/R_2,

and for the three laws of linear springs one that takes up the same energy at the same indentation. All laws have
e = 0.5 prescribed; Kuwabara & Kono and Ristow, which know no e, the parameter with which 0.5 comes out. In a plane a
sphere is a disc with the mass of the sphere.

What comes out is e where a law was made for it exactly, and anything between 0.22 and 0.80 elsewhere. Damping that does
not end with the force is cut off where it would pull (Tsuji, Kuwabara-Kono, Ristow, Kelvin-Voigt): the law of Tsuji,
exact as an oscillator, gives 0.55. Points are impacts as simulated, lines what ``restitution_of`` says of them.
"""

import math
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure, SubFigure

import lcpflex as lf
from lcpflex.jit.kernel import FloatArray

Factor = lf.laws.HysteresisFactor
RADIUS, SPEED = 0.015, 1.0  # [m], [m/s] of each
MASS = 4.0 / 3.0 * math.pi * RADIUS**3 * 7850.0
REDUCED, CLOSING = 0.5 * MASS, 2.0 * SPEED
PRESCRIBED = 0.5
HERTZ = lf.laws.Hertz.spheres(RADIUS, RADIUS, lf.laws.Material(210e9, 0.3))
STIFFNESS = HERTZ.parameters[0]
DEEPEST = (1.25 * REDUCED * CLOSING**2 / STIFFNESS) ** 0.4  # without damping
LINEAR = lf.laws.PowerLaw(REDUCED * CLOSING**2 / DEEPEST**2, 1.0)
WITHOUT_E = (lf.laws.KuwabaraKono, lf.laws.Ristow)


@cache
def parameter(law: Any) -> float:
    """A' or g' with which 0.5 comes out."""
    return float(lf.laws.prescribed_restitution(law, PRESCRIBED))


def laws() -> dict[Any, lf.ContactLaw]:
    """The law of contact for each of the dissipative ones, by what ``restitution_of`` knows them as."""
    made: dict[Any, lf.ContactLaw] = {
        factor: lf.ContactLaw(LINEAR if factor.linear else HERTZ, lf.laws.HysteresisDamping(PRESCRIBED, factor))
        for factor in Factor
    }
    made[lf.laws.KelvinVoigt] = lf.ContactLaw(LINEAR, lf.laws.KelvinVoigt(PRESCRIBED))
    for law in (lf.laws.Tsuji, lf.laws.Jankowski, lf.laws.PermanentIndentation):
        made[law] = lf.ContactLaw(HERTZ, law(PRESCRIBED))
    relaxation = parameter(lf.laws.KuwabaraKono) * (REDUCED / STIFFNESS) ** 0.4 * CLOSING**-0.2
    rate = parameter(lf.laws.Ristow) * (STIFFNESS / REDUCED) ** 0.4 * CLOSING**0.2
    made[lf.laws.KuwabaraKono] = lf.ContactLaw(HERTZ, lf.laws.KuwabaraKono(relaxation))
    made[lf.laws.Ristow] = lf.ContactLaw(HERTZ, lf.laws.Ristow(rate))
    return made


def impact(law: lf.ContactLaw) -> lf.Result:
    """The spheres from 10 um before they touch until they are apart."""
    scene = lf.Scene(gravity=(0.0, 0.0))
    spheres = [
        scene.add(
            lf.Disc(radius=RADIUS, mass=MASS),
            position=(side * (RADIUS + 5e-6), 0.0),
            velocity=(-side * SPEED, 0.0),
            name=name,
        )
        for side, name in ((-1.0, "left"), (1.0, "right"))
    ]
    scene.contact(spheres[0].surface(), spheres[1].surface(), name="spheres")
    return lf.simulate(scene, 4e-4, lf.Smooth(law), record=2e-7)


def loop(result: lf.Result) -> tuple[FloatArray, FloatArray]:
    """Indentation [um] and force [kN] while the spheres overlap."""
    depth = 2.0 * RADIUS - (result.q[:, 3] - result.q[:, 0])
    inside = depth > 0.0
    return 1e6 * depth[inside], 1e-3 * result.force[inside, 0, 0]


def rebound(result: lf.Result) -> float:
    """Speed of parting over that of closing."""
    return float((result.u[-1, 3] - result.u[-1, 0]) / CLOSING)


def title(law: Any) -> str:
    """Name of a law, short."""
    if law is Factor.EXACT:
        return "exact factor"
    if isinstance(law, Factor):
        return " ".join(law.value.split()[:-1]).split(" et al.")[0]
    names = {
        lf.laws.KelvinVoigt: "Kelvin-Voigt",
        lf.laws.KuwabaraKono: "Kuwabara-Kono",
        lf.laws.PermanentIndentation: "permanent indent.",
    }
    return str(names.get(law, law.__name__))


def colour(law: Any) -> str:
    """One for each law within its picture of restitution."""
    if law in (Factor.EXACT, lf.laws.PermanentIndentation):
        return "black"
    family = [known for known in Factor if known.needs_rebound is getattr(law, "needs_rebound", None)]
    others = [lf.laws.KelvinVoigt, lf.laws.Tsuji, lf.laws.Jankowski, lf.laws.KuwabaraKono, lf.laws.Ristow]
    return f"C{(family.index(law) if law in family else others.index(law)) % 10}"


def style(law: Any) -> str:
    """Broken lines where one would hide another."""
    return "--" if law in (Factor.YE, lf.laws.KelvinVoigt) else "-"


def draw_parameters(axes: Axes, results: dict[Any, lf.Result]) -> None:
    """e_out of the laws without e, over their parameter, on the same scale."""
    numbers = np.linspace(0.0, 1.0, 21)
    for law in WITHOUT_E:
        name = "A'" if law is lf.laws.KuwabaraKono else "g'"
        axes.plot(
            numbers, lf.laws.restitution_of(law, numbers), ":", color=colour(law), label=f"{title(law)}, over {name}"
        )
        axes.plot(parameter(law), rebound(results[law]), "o", color=colour(law), markersize=4)
    axes.legend(fontsize=7.5, loc="lower right")
    axes.set_xlabel("e prescribed; parameter A', g'")


def draw_loops(figure: SubFigure, results: dict[Any, lf.Result]) -> None:
    """A small picture for each law, over the loop of the exact factor."""
    small = figure.subplots(3, 7, sharex=True, sharey=True)
    for axes, (law, result) in zip(small.flat, results.items(), strict=True):
        axes.fill(*loop(results[Factor.EXACT]), color="0.88")
        axes.plot(*loop(result), color=colour(law))
        axes.set_title(title(law), fontsize=8.5, color=colour(law))
        axes.text(0.05, 0.86, f"{rebound(result):.3f}", transform=axes.transAxes, fontsize=9)
        axes.tick_params(labelsize=7)
    figure.supxlabel("indentation [µm]", fontsize=10)
    figure.supylabel("force [kN]", fontsize=10)
    figure.suptitle("e = 0.5 prescribed: loops, and what comes out (grey: exact factor)", fontsize=11)


def draw_restitution(axes: Axes, chosen: list[Any], results: dict[Any, lf.Result]) -> None:
    """e_out over e_in as closed forms say, and the impact that was simulated."""
    e = np.linspace(0.01, 1.0, 100)
    axes.plot((0.0, 1.0), (0.0, 1.0), color="0.8", linewidth=4)
    for law in chosen:
        axes.plot(e, lf.laws.restitution_of(law, e), color=colour(law), linestyle=style(law), label=title(law))
        axes.plot(PRESCRIBED, rebound(results[law]), "o", color=colour(law), markersize=4)
    axes.set(xlabel="e prescribed", ylabel="e that comes out", xlim=(0.0, 1.0), ylim=(0.0, 1.0))
    axes.grid(True, alpha=0.4)
    axes.legend(fontsize=7.5, loc="upper left" if Factor.PANT in chosen else "lower right")


def run(folder: Path = Path()) -> lf.Result:
    made = laws()
    results = {law: impact(contact) for law, contact in made.items()}
    expected = {law: PRESCRIBED if law in WITHOUT_E else lf.laws.restitution_of(law, PRESCRIBED) for law in made}

    assert max(abs(rebound(results[law]) - expected[law]) for law in made) < 1e-4

    figure = Figure(figsize=(14, 12), layout="constrained")
    above, below = figure.subfigures(2, 1, height_ratios=(3, 2))
    draw_loops(above, results)
    left, middle, right = below.subplots(1, 3)
    draw_restitution(left, [law for law in Factor if not law.needs_rebound], results)
    draw_restitution(middle, [law for law in Factor if law.needs_rebound], results)
    draw_restitution(
        right, [lf.laws.Tsuji, lf.laws.KelvinVoigt, lf.laws.Jankowski, lf.laws.PermanentIndentation], results
    )
    draw_parameters(right, results)
    left.set_title("factors that are finite at e = 0", fontsize=10)
    middle.set_title("factors that grow like 1/e", fontsize=10)
    right.set_title("other laws", fontsize=10)
    figure.savefig(folder / "two_spheres.png", dpi=150)
    return results[Factor.EXACT]


if __name__ == "__main__":
    print(run().summary())
