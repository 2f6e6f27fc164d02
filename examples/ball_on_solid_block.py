"""A heavy ball is pressed slowly into an elastic block: the patch of contact, its radius and its pressures are Hertz's.

Two smooth bodies touch in a circle, and Hertz (1882) found its radius a and the pressure p in it: with the force F, the
radius R of the ball and E* = E / (1 - nu^2) of the block,

    a^3 = 3 F R / (4 E*),   p = p_0 (1 - (r/a)^2)^1/2,   p_0 = 3 F / (2 pi a^2).

Here the block is a mesh of hexahedra of eight nodes, four along that radius, and the ball is rigid. Each node of its
face that touches has a force, and stands for an area: the integral of its hat. Force over area is the pressure.

The radius has to be told from where the forces are, and not from how many nodes touch: those at the rim stand for areas
that reach beyond it, so that the sum of the areas is a fifth too large. The mean square of the distance from the
middle, weighed by the forces, is 2 a^2 / 5 of Hertz's distribution, and has no such steps: that is what
``result.contact("hit").radius`` tells. At nodes of quadratic elements it is right as well, while force over area is no
pressure there: an even pressure gives their corners other shares than the middles of their sides, and the library
refuses to call that one.
"""

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from skfem import MeshHex

import lcpflex as lf

STEEL = {"density": 7800.0, "youngs_modulus": 2.1e11, "poissons_ratio": 0.3}
STIFFNESS = STEEL["youngs_modulus"] / (1.0 - STEEL["poissons_ratio"] ** 2)  # E* [Pa]
EXPECTED = 0.8e-3  # radius of the contact, about [m]
BALL, MASS, SPEED = 16e-3, 2.0, 0.35  # [m], [kg], [m/s]
LASTS = 2.87 * (MASS**2 / (BALL * STIFFNESS**2 * SPEED)) ** 0.2  # contact of a ball on a half space [s]
FINE = 0.25 * EXPECTED  # elements at the contact [m]
DEEP = 4.0 * EXPECTED  # of the block [m]


def graded(near: float) -> np.ndarray:
    """Places from 0 to the depth of the block, even up to ``near``, then each half as far again as the one before."""
    even = np.linspace(0.0, near, round(near / FINE) + 1)
    ways = np.cumsum(FINE * 1.5 ** np.arange(1, 20))
    ways = ways[: np.searchsorted(ways, DEEP - near) + 1]
    return np.concatenate([even, near + ways * (DEEP - near) / ways[-1]])


def block() -> lf.Solid:
    """As wide as it is deep on each side of the contact, about its middle; with the face that is to touch."""
    half, down = graded(1.25 * EXPECTED), graded(0.75 * EXPECTED)
    side = np.concatenate([-half[:0:-1], half])
    sets = {
        "bottom": lambda x, y, z: z < -0.4999 * DEEP,
        "contact": lambda x, y, z: (z > 0.4999 * DEEP) & (np.maximum(abs(x), abs(y)) < 1.2501 * EXPECTED),
    }
    mesh: Any = MeshHex.init_tensor(side, side, 0.5 * DEEP - down[::-1])
    return lf.Solid(mesh, sets=sets, **STEEL)


def run(folder: Path = Path()) -> lf.Result:
    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    solid = block().reduce(
        modes=6, contact="contact", rows="normal", interfaces=["bottom"]
    )  # no friction: normals alone
    body = scene.add(solid, name="block")
    scene.join(lf.Weld(body.point("bottom"), scene.ground.at(0.0, 0.0, -0.5 * DEEP)))
    above = 0.5 * DEEP + BALL + 1e-8
    ball = scene.add(lf.Sphere(BALL, mass=MASS), name="ball", position=(0.0, 0.0, above), velocity=(0.0, 0.0, -SPEED))
    scene.contact(body.face("contact"), ball.surface(), name="hit")
    result = lf.simulate(scene, 1.02 * LASTS, lf.MoreauJean(step=1e-3 * LASTS), record=0.02 * LASTS)

    hit = result.contact("hit")
    force = hit.normal_force
    hertz = (0.75 * force * BALL / STIFFNESS) ** (1.0 / 3.0)
    k = int(force.argmax())
    a, peak = hertz[k], 1.5 * force[k] / (np.pi * hertz[k] ** 2)
    places, pressure = hit.pressure(hit.times[k])
    share = np.hypot(places[:, 0], places[:, 1]) / a
    off = pressure / peak - np.sqrt(np.maximum(1.0 - share**2, 0.0))
    assert abs(hit.radius[k] / a - 1.0) < 0.015
    assert np.sqrt(np.mean(off[share < 0.8] ** 2)) < 0.03
    assert np.abs(off[share < 0.8]).max() < 0.05

    figure = Figure(figsize=(10, 7.5), layout="constrained")
    (pushes, patch), (wide, across) = figure.subplots(2, 2)
    pushes.plot(1e6 * hit.times, 1e-3 * force)
    pushes.set(xlabel="time [µs]", ylabel="force [kN]")
    wide.plot(1e6 * hit.times, 1e3 * hertz, "k:", label="Hertz, of that force")
    wide.plot(1e6 * hit.times, 1e3 * hit.radius, label="from the mean square of the distance")
    wide.plot(1e6 * hit.times, 1e3 * np.sqrt(hit.area / np.pi), linewidth=1.0, label="from the sum of the areas")
    wide.set(xlabel="time [µs]", ylabel="radius of the contact [mm]", ylim=(0.0, None))
    wide.legend(loc="lower center")
    hit.plot_pressure(hit.times[k], patch)
    r = np.linspace(0.0, 1.0, 200)
    across.plot(r, 1e-9 * peak * np.sqrt(1.0 - r**2), "k:", label="Hertz")
    across.plot(share, 1e-9 * pressure, "o", label="nodes")
    across.set(xlabel="distance from the middle / a", ylabel="pressure [GPa]")
    across.legend()
    figure.savefig(folder / "ball_on_solid_block.png", dpi=150)
    return result


if __name__ == "__main__":
    print(run().summary())
