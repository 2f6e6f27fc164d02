"""A rotating cantilever rings higher: its frequencies over its spin, and what is heard of them.

A beam held at one end and spun about it is under tension, as a string is. Its frequencies rise with the spin: out of
the plane of rotation from 3.516 to 7.360 sqrt(E I / (rho A)) / L^2 at a spin of 6 of the same unit, and in the plane
to sqrt(7.360^2 - 6^2), for there the centrifugal force pulls outwards what has left the line of the hub. Without
geometric stiffening only that part is left, and they fall.

On the left the small vibrations about the steady state; on the right the tip after a light blow, at a spin of 4: the
period of the free vibration that a simulation shows is that of the left picture.
"""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import lcpflex as lf
from lcpflex.jit.kernel import FloatArray
from lcpflex.studies import small_vibrations

PUBLISHED = {
    0.0: (3.5160, 22.0345, 61.6972),
    2.0: (4.1373, 22.6149, 62.2732),
    4.0: (5.5850, 24.2734, 63.9668),
    6.0: (7.3604, 26.8091, 66.6840),
}  # spin: out of plane
SPIN = 4.0


def rotating(spin: float, stiffened: bool, blow: float = 0.0) -> lf.Scene:
    """A beam of E I = rho A = L = 1 that cannot stretch, and turns; ``blow``: speed that its tip is given [m/s]."""
    thickness = 0.01
    beam = lf.Beam(1.0, 1.0, thickness, 1.0 / thickness, 12.0 / thickness**3, elements=12, axial=False)
    body = beam.reduce(modes=None, stiffening=lf.Stiffening(held="left") if stiffened else None)
    dx, dy, turn, modal = body.project(lambda x, y: (0.0, blow * x**2 * (6.0 - 4.0 * x + x**2) / 3.0))
    scene = lf.Scene(gravity=(0, 0))
    blade = scene.add(body, "blade", velocity=(dx, dy), angular_velocity=spin + turn, modal_velocity=modal)
    hub = scene.ground.at(0, 0)
    scene.join(lf.Revolute(blade.point("left"), hub))
    scene.join(lf.DrivenAngle(blade.point("left"), hub, lf.Table((0.0, 100.0), (0.0, 100.0 * spin))))
    return scene


def struck(stiffened: bool) -> tuple[lf.Result, FloatArray]:
    """The run and how far the tip is ahead of the hub [m]."""
    scene = rotating(SPIN, stiffened, blow=0.01)
    result = lf.simulate(scene, 6.0, lf.GeneralizedAlpha(step=2e-3), record=0.01, project=True)
    x, y = result.point("blade", "right").T
    return result, y * np.cos(SPIN * result.times) - x * np.sin(SPIN * result.times)


def run(folder: Path = Path()) -> lf.Result:
    figure = Figure(figsize=(11, 6), layout="constrained")
    left, heard = figure.subfigures(1, 2)
    axes = left.subplots(3, 1, sharex=True)
    spins = np.linspace(0.0, 6.0, 13)
    for stiffened, style in ((True, "-"), (False, "--")):
        found = np.array([small_vibrations(rotating(spin, stiffened), spin).frequencies[:3] for spin in spins])
        for k, axis in enumerate(axes[::-1]):
            label = "stiffened by its spin" if stiffened else "linear beam"
            axis.plot(spins, found[:, k], "C0" + style if stiffened else "C1" + style, label=label)
    for spin, out_of_plane in PUBLISHED.items():
        expected = np.sqrt(np.square(out_of_plane) - spin**2)
        computed = small_vibrations(rotating(spin, stiffened=True), spin).frequencies[:3]
        assert np.abs(computed / expected - 1.0).max() < 1e-3
        for value, axis in zip(expected, axes[::-1], strict=True):
            axis.plot(spin, value, "ko", label="published" if spin == 0.0 else None)
    axes[0].legend()
    axes[0].set_title("frequencies in the plane of rotation")
    left.supylabel("frequency [sqrt(E I / (rho A)) / L$^2$]")
    axes[2].set_xlabel("spin [same unit]")

    tip = heard.subplots()
    result, ahead = struck(stiffened=True)
    crossings = result.times[1:][ahead[1:] * ahead[:-1] < 0.0]
    heard_at = np.pi * (len(crossings) - 1) / (crossings[-1] - crossings[0])
    assert abs(heard_at / np.sqrt(PUBLISHED[SPIN][0] ** 2 - SPIN**2) - 1.0) < 0.02
    tip.plot(result.times, 1e3 * ahead, "C0", label="stiffened by its spin")
    other, ahead = struck(stiffened=False)
    tip.plot(other.times, 1e3 * ahead, "C1--", label="linear beam")
    tip.set(title=f"tip after a blow, spin {SPIN:g}", xlabel="time", ylabel="tip ahead of the hub [L/1000]")
    tip.set_ylim(-3.6, 4.4)
    tip.legend(loc="upper right")
    for axis in (*axes, tip):
        axis.grid(True, alpha=0.4)
    figure.savefig(folder / "rotating_beam.png", dpi=150)
    return result


if __name__ == "__main__":
    print(run().summary())
