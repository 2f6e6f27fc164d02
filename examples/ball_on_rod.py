"""A steel ball strikes an aluminium rod: from two meshes to a coefficient of restitution that nobody put in.

The ball (radius 15 mm, 0.3 m/s) meets the end of a rod of 1 m; half sections of both are meshed, finest where they
touch. No law of contact stiffness and no coefficient of restitution is given: nodes of the ball may not enter the face
of the rod, that is all. Each body keeps its 20 lowest modes, the others are the static compliance of its contact nodes
(residual compliance, massless boundary). Waves in the rod keep half of the energy.

The reference is Hertz' law with one-dimensional waves, the scene ``sphere_on_rod`` of the gallery: 193.57 us, 467.78 N,
an apparent restitution of 0.64225.
Three meshes show what the advice of nine pairs in contact is worth: with fewer, the force comes in steps, node by node.
"""

import math
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import lcpflex as lf
from lcpflex import gallery
from lcpflex.checks import resolution_rules as advice

SPEED, DURATION = 0.3, 2.5e-4  # [m/s], [s]
MESHES = (4e-4, 1e-4, 5e-5)  # finest elements [m]
PUBLISHED = {"contact time": 193.57e-6, "peak force": 467.78, "restitution": 0.64225}


def told() -> advice.ContactAdvice:
    """What is known before anything is meshed."""
    modulus = advice.effective_modulus((210e9, 0.3), (69e9, 0.33))
    mass = 4.0 / 3.0 * math.pi * 0.015**3 * 7780.0  # the rod is long: its end moves as that of an infinite one
    speeds = (advice.wave_speed(69e9, 2700.0), advice.wave_speed(210e9, 7780.0))
    return advice.contact_advice(mass, 0.015, modulus, SPEED, *speeds, half_section=True)


def meshed(finest: float) -> lf.Result:
    """The impact of the two meshes."""
    scene = gallery.meshed_sphere_on_rod(finest, SPEED)
    return lf.simulate(scene, DURATION, lf.MasslessBoundary(dynamic_modes=20), record=2e-7)


def measured(result: lf.Result) -> dict[str, float]:
    """Contact time [s], peak force [N], apparent restitution: what the reference is given by."""
    contact = result.contact("ball")
    pressed = result.times[contact.force[:, 0] > 0.0]
    assert result.compiled is not None
    rod, ball = result.u[-1, result.compiled.model.bodies.dof[:2]]
    return {
        "contact time": float(pressed[-1] - pressed[0]),
        "peak force": contact.peak_force,
        "restitution": float(rod - ball) / SPEED,
    }


def run(folder: Path) -> lf.Result:
    """Run, print what came out, and write the picture into ``folder``."""
    print(told())
    case = gallery.scenes()["sphere_on_rod"]
    reference = lf.simulate(case.build(), DURATION, case.stepper, record=2e-7)
    results = [meshed(finest) for finest in MESHES]
    figure = Figure(figsize=(11, 4.2), layout="constrained")
    forces, pairs = figure.subplots(1, 2)
    forces.plot(1e6 * reference.times, reference.force[:, 0, 0], "k--", label="Hertz' law and 1D waves")
    for finest, result in zip(MESHES, results, strict=True):
        contact, numbers = result.contact("ball"), measured(result)
        peak = int(contact.pairs[np.argmax(contact.force[:, 0])])
        name = f"{1e3 * finest:g} mm"
        forces.plot(1e6 * contact.times, contact.force[:, 0], label=f"meshes of {name} at the contact")
        pairs.step(1e6 * contact.times, contact.pairs, where="post", label=name)
        errors = ", ".join(f"{key} {100.0 * (numbers[key] / PUBLISHED[key] - 1.0):+.1f} %" for key in PUBLISHED)
        print(f"{name}: {peak} pairs at the peak; {errors}; {result.wall_time:.2g} s", *result.warnings, sep="\n  ")
    forces.set(xlabel="time [µs]", ylabel="contact force [N]", title="No contact law, no restitution: two meshes")
    pairs.axhline(advice.PAIRS, color="k", linestyle=":", label="advice: 9 pairs")
    pairs.set(xlabel="time [µs]", ylabel="pairs in contact", title="Nodes of the ball on the face of the rod")
    for axes in (forces, pairs):
        axes.legend(fontsize=8)
        axes.grid(alpha=0.3)
    figure.savefig(folder / "ball_on_rod.png", dpi=130)
    return results[-1]


if __name__ == "__main__":
    run(Path.cwd())
