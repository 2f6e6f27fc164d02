"""Kane's double pendulum: an impact law that creates energy.

The tip of a double pendulum strikes a rough floor (mu = 0.5). Newton's law prescribes the ratio e of the
normal velocities, Coulomb's law bounds the friction impulse, and each is plausible alone. Together they make
the kinetic energy of this mechanism *grow by 59 percent* for e = 0.5: the tip turns its slip around during
the impact, and through the inertia of the rods the friction impulse feeds the rebound.

No integrator can mend a law; what a program can do is not to be silent about it. Read the warnings of the
result. With e = 0 the same impact loses energy, as it must.
"""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import lcpflex as lf
from lcpflex import gallery


def run(folder: Path = Path()) -> lf.Result:
    case = gallery.scenes()["double_pendulum"]
    result = lf.simulate(case.build(), case.duration, case.stepper)

    assert abs(energy_gain(result) - case.reference["energy_gain"]) < 1e-4
    assert any("created energy" in text for text in result.warnings)

    restitutions = np.linspace(0.0, 1.0, 11)
    gains = [energy_gain(lf.simulate(gallery.double_pendulum(restitution=e), 1e-3, case.stepper)) for e in restitutions]
    figure = Figure(figsize=(9, 5), layout="constrained")
    scene, chart = figure.subplots(1, 2)
    result.draw(0.0, axes=scene)
    chart.plot(restitutions, [1.0 + gain for gain in gains], "o-")
    chart.axhline(1.0, color="gray", linestyle=":")
    chart.set(xlabel="Newton's coefficient of restitution", ylabel="kinetic energy after / before the impact")
    figure.savefig(folder / "kanes_pendulum.png", dpi=150)
    return result


def energy_gain(result: lf.Result) -> float:
    """Of the first impact, relative to the kinetic energy before it."""
    impact = next(event for event in result.events if event.kind == "impact")
    return impact.energy_change / float(result.energies.kinetic[0])


if __name__ == "__main__":
    print(run().summary())
