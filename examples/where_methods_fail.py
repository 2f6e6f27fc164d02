"""Where methods fail: four traps of contact dynamics, each mapped over two parameters and checked by its theory.

*Painleve's rod.* A rod slides on its lower end. Above a friction of 4/3 there are angles at which no contact
force obeys Coulomb's law and rigid bodies: no integrator is to blame, the model has no solution. The boundary
that the library finds lies on the exact one, mu = (1 + 3 cos^2 phi) / (3 sin phi cos phi).

*Penalty springs with fixed explicit steps.* A disc is pressed onto the floor. Springs that are too soft let it
sink; stiffer ones demand shorter steps, and above h = 2/omega, omega = sqrt(k/m), the motion explodes.

*Newmark's rule with contact.* The trapezoidal rule is the classic for structures. Give it a contact that is
enforced on positions (``newmark`` below), and an elastic bar comes off the wall with several times the energy
it had; shorter steps do not help. Nonsmooth generalised-alpha keeps the energy with steps a hundred times longer.

*Kane's double pendulum.* Newton's law of impact with friction creates energy, 59 percent for mu = e = 0.5.
Poisson's law, which reflects impulses instead of velocities, loses 46 percent there, and gains nowhere.
"""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import lcpflex as lf
from lcpflex import gallery
from lcpflex.dynamics.impact_laws import Newton, Poisson
from lcpflex.force_laws.penalty import Penalty
from lcpflex.steppers.generalized_alpha.stepper import GeneralizedAlpha
from lcpflex.steppers.smooth.stepper import Smooth, Verlet
from lcpflex.studies import Criteria, Outcome, StabilityMap, Verdict, acceleration_level, outcome_legend, stability

NEWMARK, ALPHA = "Newmark, contact on positions", "nonsmooth generalised-alpha"


def run(folder: Path = Path()) -> lf.Result:
    rod, spring, bar, kane = painleve(), penalty(), elastic_bar(), double_pendulum()

    newton, poisson = (lf.simulate(gallery.double_pendulum(), 1e-3, law) for law in impact_laws().values())
    assert abs(energy_gain(newton) - 0.5875) < 1e-4
    assert abs(energy_gain(poisson) + 0.4551) < 1e-4
    assert not np.any(kane.of("Poisson's law") == Outcome.GAINING)
    assert bar.of(ALPHA)[-1, -1] is Outcome.NO_TROUBLE  # a hundred times the limit: stable; how accurate, nobody asked
    assert bar.of(NEWMARK)[0, -1] is not Outcome.NO_TROUBLE  # the shortest

    figure = Figure(figsize=(14.5, 8.8), layout="constrained")
    panels = figure.subplots(2, 3)
    degrees = np.linspace(20.0, 85.0, 200)
    exact = [gallery.painleve_friction(angle) for angle in degrees]
    rod.draw(panels[0, 0], "acceleration level", {"exact": (degrees, exact)})
    stiffness = np.array(spring.axes["stiffness"])
    spring.draw(panels[0, 1], "penalty", {"exact": (stiffness, 2.0 / np.sqrt(stiffness))})
    kane.draw(panels[0, 2], "Newton's law")
    bar.draw(panels[1, 0], NEWMARK)
    bar.draw(panels[1, 1], ALPHA)
    kane.draw(panels[1, 2], "Poisson's law")
    titles = (
        ("rod sliding on its end: does a contact force exist?", "angle from the floor [degrees]", "friction"),
        ("disc on a penalty spring, explicit steps", "contact stiffness [N/m]", "step [s]"),
        ("Kane's pendulum, Newton's law of impact", "restitution", "friction"),
        ("elastic bar on a wall, Newmark's rule", "step [s]", "elements"),
        ("the same bar, nonsmooth generalised-alpha", "step [s]", "elements"),
        ("Kane's pendulum, Poisson's law of impact", "restitution", "friction"),
    )
    for ax, (title, x, y) in zip(panels.ravel(), titles, strict=True):
        ax.set_title(title, fontsize="large", loc="left")
        ax.set(xlabel=x, ylabel=y)
    handles = outcome_legend(rod, spring, bar, kane, curves=["exact limit"])
    figure.legend(handles=handles, loc="outside lower center", ncols=len(handles), frameon=False, fontsize="large")
    figure.savefig(folder / "where_methods_fail.png", dpi=110)
    return newton


def painleve() -> StabilityMap:
    """Of the start alone: no time stepping."""
    axes = {"degrees": np.linspace(20.0, 85.0, 20), "friction": np.linspace(0.6, 3.0, 18)}
    return stability(gallery.painleve_rod, {"acceleration level": acceleration_level}, axes)


def pressed_disc() -> lf.Scene:
    """The force grows so slowly that the disc stays on the floor."""
    scene = lf.Scene(gravity=(0.0, 0.0))
    disc = scene.add(lf.Disc(radius=0.1, mass=1.0), name="disc", position=(0.0, 0.1))
    scene.contact(disc.surface(), scene.ground.half_plane((0.0, 0.0), (0.0, 1.0)), name="floor")
    scene.load(lf.Force(disc.point("center"), (0.0, lf.Table([0.0, 0.5, 1.0], [0.0, -10.0, -10.0]))))
    return scene


def penalty() -> StabilityMap:
    def method(step: float, stiffness: float) -> Smooth:
        return Smooth(Penalty(stiffness=stiffness), integrator=Verlet(step))

    axes = {"stiffness": np.geomspace(1e3, 1e7, 17), "step": np.geomspace(1e-4, 1e-1, 13)}
    swings = Criteria(
        growth=0.3, remainder=0.3
    )  # close to its limit, the energy of the scheme swings about the true one
    return stability(pressed_disc, {"penalty": method}, axes, duration=1.0, criteria=swings)


def elastic_bar() -> StabilityMap:
    methods = {NEWMARK: newmark, ALPHA: lambda step: GeneralizedAlpha(step=step, rho_inf=0.8)}
    axes = {"step": np.geomspace(1e-4, 1e-2, 7), "elements": [10, 20, 40, 80, 160]}
    return stability(gallery.elastic_bar, methods, axes, duration=1.5, criteria=Criteria(drift=0.02))


def newmark(step: float, elements: int, duration: float = 1.5) -> Verdict:
    """The bar of the gallery by the trapezoidal rule (gamma = 1/2, beta = 1/4), with u_0 >= 0 after every step.

    M a+ + K u+ = e_0 lambda,   u+ = u + h v + h^2 (a + a+)/4,   v+ = v + h (a + a+)/2,   0 <= u+_0  _|_  lambda >= 0
    """
    length = 10.0 / elements
    mass, stiffness = np.zeros((2, elements + 1, elements + 1))
    for k in range(elements):
        element = slice(k, k + 2)
        mass[element, element] += length / 6.0 * np.array([[2.0, 1.0], [1.0, 2.0]])
        stiffness[element, element] += 900.0 / length * np.array([[1.0, -1.0], [-1.0, 1.0]])
    share = 0.25 * step**2
    inverse = np.linalg.inv(mass + share * stiffness)
    u, v, a = np.full(elements + 1, 5.0), np.full(elements + 1, -10.0), np.zeros(elements + 1)
    start = largest = 0.5 * v @ mass @ v
    for _ in range(round(duration / step)):
        u += step * v + share * a
        v += 0.5 * step * a
        a = -inverse @ (stiffness @ u)
        a += inverse[:, 0] * max(0.0, -(u[0] + share * a[0]) / (share * inverse[0, 0]))
        u += share * a
        v += 0.5 * step * a
        largest = max(largest, 0.5 * (v @ mass @ v + u @ stiffness @ u))
    grown = largest / start
    outcome = Outcome.DIVERGED if grown > 11.0 else Outcome.GAINING if grown > 1.01 else Outcome.NO_TROUBLE
    return Verdict(outcome, f"the energy grew to {grown:.3g} of that at the start")


def impact_laws() -> dict[str, lf.EventDriven]:
    return {"Newton's law": lf.EventDriven(impact=Newton()), "Poisson's law": lf.EventDriven(impact=Poisson())}


def double_pendulum() -> StabilityMap:
    axes = {"restitution": np.linspace(0.0, 1.0, 11), "friction": np.linspace(0.0, 1.0, 11)}
    return stability(gallery.double_pendulum, impact_laws(), axes, duration=1e-3)


def energy_gain(result: lf.Result) -> float:
    """Of the first impact, relative to the kinetic energy before it."""
    impact = next(event for event in result.events if event.kind == "impact")
    return impact.energy_change / float(result.energies.kinetic[0])


if __name__ == "__main__":
    print(run().summary())
