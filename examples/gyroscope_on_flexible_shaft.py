"""An overhung disc on a flexible shaft: whirl forwards and backwards, against the spin (Campbell's diagram).

A disc of 4.9 kg is welded to the end of a round shaft, 6 mm by .2 m, whose other end turns in a hinge that holds its
direction, driven at a constant rate W. In world axes the place y + i z of the disc's centre and the tilt of its axis
are sums of exp(i w t), with the four roots w of

    det [[k11 - m w^2, k12], [k12, k22 - Jd w^2 + Jp W w]] = 0,
    k11 = 12 E I / L^3,   k12 = -6 E I / L^2,   k22 = 4 E I / L

(Gasch, Nordmann and Pfuetzner, Rotordynamik; m, Jd, Jp: mass of the disc, moments across and about its axis): w > 0
whirls in the sense of the spin. The gyroscopic moment Jp W w makes the shaft stiffer for forward whirl and softer for
backward whirl. It grows with the spin: the slow backward whirl goes to zero, the fast forward whirl to Jp W / Jd.

A pulse at the disc starts all four; each run then tells them by the peaks of one spectrum, that of y + i z, in which
forward and backward whirl lie at frequencies of different sign. The formula has no mass of the shaft; the shaft
here has 1 % of that of the disc, which lowers the frequencies by about two thousandths. The library leaves out that
spin and tension stiffen a beam: for so light a shaft the first does not matter, and there is no tension. The gyroscopic
moment of the disc is exact. Of the shaft, only the static response to forces and moments at the disc is kept (residual
modes): its own vibrations are far above the whirl, and steps that do not resolve them could raise them.
"""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import lcpflex as lf

LENGTH, DIAMETER, YOUNG, DENSITY = 0.2, 6e-3, 2.1e11, 7850.0  # of the shaft [m], [m], [Pa], [kg/m^3]
RADIUS, THICKNESS = 0.1, 0.02  # of the disc [m]
AREA, INERTIA = np.pi * DIAMETER**2 / 4.0, np.pi * DIAMETER**4 / 64.0
MASS = DENSITY * np.pi * RADIUS**2 * THICKNESS
POLAR, ACROSS = MASS * RADIUS**2 / 2.0, MASS * (RADIUS**2 / 4.0 + THICKNESS**2 / 12.0)
SPINS, PULSE, DURATION, RECORD = (0.0, 60.0, 120.0, 180.0), 4e-3, 4.0, 1e-3  # [rad/s], [s], [s], [s]


def whirl(spin: float) -> np.ndarray:
    """The four w (4,) [rad/s], ascending: fast backward, slow backward, slow forward, fast forward."""
    k11, k12, k22 = YOUNG * INERTIA * np.array([12.0 / LENGTH**3, -6.0 / LENGTH**2, 4.0 / LENGTH])
    quartic = np.polymul([-MASS, 0.0, k11], [-ACROSS, POLAR * spin, k22])
    return np.sort(np.roots(np.polysub(quartic, [k12**2])).real)


def rotor(spin: float) -> lf.SpatialScene:
    """Shaft along x from the hinge in the origin, disc on its end, driven at ``spin``; a pulse at the disc."""
    shaft = lf.SpatialBeam(
        length=LENGTH, area=AREA, second_moments=(INERTIA, INERTIA), torsion_constant=2.0 * INERTIA, density=DENSITY,
        youngs_modulus=YOUNG, poissons_ratio=0.3, shear_factor=None, elements=20,
    )  # fmt: skip
    turning = {"angular_velocity": (spin, 0.0, 0.0)}
    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    beam = scene.add(
        shaft.reduce(modes=0, clamped="left", interfaces=["right"]),
        name="shaft",
        position=(0.5 * LENGTH, 0.0, 0.0),
        **turning,
    )
    facing_x = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    disc = scene.add(
        lf.Cylinder(radius=RADIUS, length=THICKNESS, density=DENSITY),
        name="disc", position=(LENGTH, 0.0, 0.0), orientation=facing_x, **turning,
    )  # fmt: skip
    bearing = scene.ground.at(0.0, 0.0, 0.0)
    scene.join(lf.Revolute(beam.point("left"), bearing, axis=(1.0, 0.0, 0.0), name="bearing"))
    turn = lf.Table((0.0, 2.0 * DURATION), (0.0, 2.0 * DURATION * spin))
    scene.join(lf.DrivenAngle(beam.point("left"), bearing, turn, axis=(1.0, 0.0, 0.0), name="motor"))
    scene.join(lf.Weld(disc.point("center"), beam.point("right"), name="hub"))
    instants = (0.0, 0.5 * PULSE, PULSE)
    scene.load(lf.Force(disc.point("center"), (0.0, lf.Table(instants, (0.0, 2.0, 0.0)), 0.0)))
    scene.load(lf.Torque(disc.point("center"), (0.0, lf.Table(instants, (0.0, 1.0, 0.0)), 0.0)))
    return scene


def measured(result: lf.Result) -> np.ndarray:
    """Frequencies (4,) [rad/s], ascending, of the two highest peaks of a spectrum on either side of 0."""
    place = result.point("disc", "center")[int(PULSE / RECORD) + 2 :]
    signal = (place[:, 1] + 1j * place[:, 2]) * np.hanning(len(place))
    size = 8 * len(signal)
    height = np.log(np.abs(np.fft.fft(signal, size)) + 1e-300)
    before, after = np.roll(height, 1), np.roll(height, -1)
    w = 2.0 * np.pi * np.fft.fftfreq(size, RECORD)
    between = 0.5 * (before - after) / (before - 2.0 * height + after)  # top of a parabola
    found: list[float] = []
    for side in (w < -3.0, w > 3.0):
        peaks = np.flatnonzero(side & (height > before) & (height > after))
        highest = peaks[np.argsort(height[peaks])[-2:]]
        found += list(w[highest] + between[highest] * w[1])
    return np.sort(found)


def run(folder: Path = Path()) -> lf.Result:
    results = [lf.simulate(rotor(spin), DURATION, lf.MoreauJean(step=2e-4), record=RECORD) for spin in SPINS]
    frequencies = np.array([measured(result) for result in results])
    expected = np.array([whirl(spin) for spin in SPINS])
    assert np.abs(frequencies / expected - 1.0).max() < 0.005, frequencies / expected
    assert (np.diff(frequencies, axis=0) > 0.0).all()  # backward whirl slows down, forward whirl becomes faster

    figure = Figure(figsize=(10, 4.8), layout="constrained")
    campbell, path = figure.subplots(1, 2)
    line = np.linspace(0.0, 1.1 * SPINS[-1], 100)
    curves = np.abs([whirl(spin) for spin in line])
    kinds = (("backward", "C1"), ("backward", "C1"), ("forward", "C0"), ("forward", "C0"))
    for k, (kind, color) in enumerate(kinds):
        label = kind if k in (0, 2) else None
        campbell.plot(line, curves[:, k], color=color, label=label)
        campbell.plot(SPINS, np.abs(frequencies[:, k]), "o", color=color, label="measured" if k == 3 else None)
    campbell.plot(line, line, ":", color="gray", label="once a turn")
    campbell.set(xlabel="spin [rad/s]", ylabel="whirl [rad/s]", title="Campbell diagram of an overhung disc")
    campbell.legend()
    place = 1e6 * results[-1].point("disc", "center")[: int(0.5 / RECORD)]
    path.plot(place[:, 1], place[:, 2], linewidth=0.9)
    path.set(aspect="equal", xlabel="y [µm]", ylabel="z [µm]")
    path.set_title(f"centre of the disc, {SPINS[-1]:g} rad/s, first half second")
    figure.savefig(folder / "gyroscope_on_flexible_shaft.png", dpi=150)
    return results[-1]


if __name__ == "__main__":
    print(run().summary())
