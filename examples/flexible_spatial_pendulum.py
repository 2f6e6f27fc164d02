"""A rod on a ball joint swings in space, stiff and flexible: the bending hardly changes the swing.

A stiff slender rod on a ball joint moves as a point mass on a string of the length I / (m a) (I: moment about the
pivot, a: distance of the mass centre): the length of the rod here is such that this is 1 m, and the rod, released at
1 rad from the downward vertical and at 2 rad/s about it, takes the way of the spherical pendulum of the gallery.

What gravity asks of the sections of the rod and what their inertia gives differ by m' g sin(theta) (1 - 3 x / (2 L)),
transversely in the vertical plane through the rod. Slowly applied, this bends the tip outwards from the mean line of
the rod, e ~ <x r>, by

    w = m' g sin(theta) L^4 / (336 E I),

about which the rod, released straight, rings in both planes, as the plane of its swing turns. The bending is orthogonal
to turning as a whole: the mean line swings as the stiff rod does, apart from terms of second order. Energy and the
vertical angular momentum about the pivot stay as they are.

The library leaves out that tension stiffens a beam (m' L^2 / (E I) times the squared rates of the swing, some percent
here): do not read the last percent of the ringing.
"""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import lcpflex as lf
from lcpflex import gallery

DIAMETER, DENSITY, YOUNG, STRING, GRAVITY = 8e-3, 7850.0, 2e11, 1.0, 9.81  # [m], [kg/m^3], [Pa], [m], [m/s^2]
AREA, INERTIA = np.pi * DIAMETER**2 / 4.0, np.pi * DIAMETER**4 / 64.0
# I / (m a) = (L^2 / 3 + INERTIA / AREA) / (L / 2) = STRING
LENGTH = (STRING / 2.0 + np.sqrt(STRING**2 / 4.0 - 4.0 / 3.0 * INERTIA / AREA)) * 1.5


def pendulum(modes: int) -> lf.SpatialScene:
    """The rod at 1 rad from the downward vertical, turning about the vertical at 2 rad/s and not about its own axis."""
    beam = lf.SpatialBeam(
        length=LENGTH, area=AREA, second_moments=(INERTIA, INERTIA), torsion_constant=2.0 * INERTIA, density=DENSITY,
        youngs_modulus=YOUNG, poissons_ratio=0.3, shear_factor=0.9,
    )  # fmt: skip
    along, across = np.array([np.sin(1.0), 0.0, -np.cos(1.0)]), np.array([0.0, 1.0, 0.0])
    rate = 2.0 * np.sin(1.0) * across  # of the direction of the rod
    scene = lf.SpatialScene(gravity=(0.0, 0.0, -GRAVITY))
    rod = scene.add(
        beam.reduce(modes=modes, interfaces=["left"] if modes else []),
        name="rod",
        position=0.5 * LENGTH * along,
        orientation=np.column_stack([along, across, np.cross(along, across)]),
        velocity=0.5 * LENGTH * rate,
        angular_velocity=np.cross(along, rate),
    )
    scene.join(lf.Ball(rod.point("left"), scene.ground.at(0.0, 0.0, 0.0), name="pivot"))
    return scene


def mean_line(result: lf.Result) -> np.ndarray:
    """Direction (m, 3) of <x r>, x from the pivot: all of the motion that is no bending.

    The frame of the body is its mean frame, in which bending has no <x r>: what remains is that of a stiff rod in it.
    """
    axis = result.orientation("rod").apply([1.0, 0.0, 0.0])
    line = axis * LENGTH**2 / 12.0 + result.q[:, :3] * LENGTH / 2.0
    return np.asarray(line / np.linalg.norm(line, axis=1)[:, None])


def angles(line: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """From the downward vertical, and about it [rad]."""
    return np.arctan2(np.hypot(line[:, 0], line[:, 1]), -line[:, 2]), np.unwrap(np.arctan2(line[:, 1], line[:, 0]))


def deflection(result: lf.Result) -> tuple[np.ndarray, np.ndarray]:
    """Of the tip from the mean line [m]: outwards in the vertical plane through it, and across that plane."""
    line = mean_line(result)
    theta, phi = angles(line)
    outwards = np.stack([np.cos(theta) * np.cos(phi), np.cos(theta) * np.sin(phi), np.sin(theta)], axis=1)
    across = np.stack([-np.sin(phi), np.cos(phi), np.zeros_like(phi)], axis=1)
    tip = result.point("rod", "right")
    return (tip * outwards).sum(axis=1), (tip * across).sum(axis=1)


def changes(result: lf.Result) -> tuple[float, float]:
    """Largest relative change of the energy and of the vertical angular momentum about the pivot."""
    total, vertical = result.energies.stored, result.momentum().angular[:, 2]
    return (
        float(np.abs(total - total[0]).max() / result.energies.kinetic.max()),
        float(np.abs(vertical / vertical[0] - 1.0).max()),
    )


def run(folder: Path = Path()) -> lf.Result:
    case = gallery.scenes()["spherical_pendulum"]
    stiff = lf.simulate(pendulum(0), case.duration, lf.EventDriven(rtol=1e-8), record=2e-3)
    soft = lf.simulate(pendulum(4), case.duration, lf.GeneralizedAlpha(step=5e-4), record=2e-3)
    theta, phi = angles(mean_line(stiff))
    assert abs(theta[-1] - case.reference["theta"]) < 1e-7
    assert abs(phi[-1] - case.reference["phi"]) < 1e-7
    bent, _ = angles(mean_line(soft))
    assert np.abs(np.interp(soft.times, stiff.times, theta) - bent).max() < 1e-3
    assert max(changes(soft)) < 1e-5
    tip, across = deflection(soft)
    static = DENSITY * AREA * GRAVITY * np.sin(bent) * LENGTH**4 / (336.0 * YOUNG * INERTIA)
    assert abs(tip.mean() / static.mean() - 1.0) < 0.05

    figure = Figure(figsize=(9, 7), layout="constrained")
    swing, bending = figure.subplots(2, 1, sharex=True)
    swing.plot(stiff.times, np.degrees(theta), label="stiff rod: the spherical pendulum")
    swing.plot(soft.times, np.degrees(bent), "--", label="flexible rod, mean line")
    swing.set(ylabel="from the downward vertical [degrees]", title="A rod on a ball joint swings in space")
    swing.legend(loc="lower center")
    bending.plot(soft.times, 1e3 * tip, label="in the vertical plane")
    bending.plot(soft.times, 1e3 * across, label="across it")
    bending.plot(soft.times, 1e3 * static, ":", color="black", label="slowly applied, closed form")
    bending.set(xlabel="time [s]", ylabel="tip off the mean line [mm]")
    bending.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=3, frameon=False)
    figure.savefig(folder / "flexible_spatial_pendulum.png", dpi=150)
    return soft


if __name__ == "__main__":
    print(run().summary())
