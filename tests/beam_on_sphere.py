"""A hinged beam of Timoshenko's strikes a rigid sphere by Hertz's law: a reference that shares nothing with lcpflex.

E I phi'' + k G A (w' - phi) = rho I phi_tt and k G A (w'' - phi') = rho A w_tt with w = 0 at x = 0, in the lowest modes
of a Ritz basis (x P_k for w, P_k for phi, Legendre's polynomials). Modes turn exactly from force to force, each of them
acting at once for a whole step: symplectic, of second order. Sections stay plane and do not bend.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import numpy.typing as npt
from numpy.polynomial import legendre
from scipy.linalg import eigh

__all__ = ["BEAM_LENGTH", "Collision", "collisions_of", "struck"]

Floats = npt.NDArray[np.float64]
Collision = tuple[float, float, float]  # start and end [s], peak [N]

BEAM_LENGTH, WIDTH, THICKNESS = 0.7, 0.028, 0.005  # Shi, Hong & Liu 2013
DENSITY, YOUNG, POISSON = 2700.0, 6.9e10, 0.33  # the last is not printed
SHEAR = YOUNG / (2.0 * (1.0 + POISSON)) * 5.0 / 6.0


@cache
def modes(count: int) -> tuple[Floats, Floats]:
    """Frequencies [rad/s] and (p, count) shapes of w as sums of x P_k(2 x / L - 1), masses of one."""
    p = 2 * count  # polynomials: pi for each wavelength, two modes, and a margin
    at, weight = legendre.leggauss(p + 2)
    x, weight = 0.5 * BEAM_LENGTH * (1.0 + at), 0.5 * BEAM_LENGTH * weight
    turn = legendre.legvander(at, p - 1)
    bend = 2.0 / BEAM_LENGTH * np.array([legendre.legval(at, legendre.legder(row)) for row in np.eye(p)]).T
    deflection, slope = x[:, None] * turn, turn + x[:, None] * bend

    def product(a: Floats, b: Floats) -> Floats:
        return np.asarray((weight[:, None] * a).T @ b)

    area, inertia, zero = WIDTH * THICKNESS, WIDTH * THICKNESS**3 / 12.0, np.zeros((p, p))
    mixed = -SHEAR * area * product(slope, turn)
    turning = YOUNG * inertia * product(bend, bend) + SHEAR * area * product(turn, turn)
    stiffness = np.block([[SHEAR * area * product(slope, slope), mixed], [mixed.T, turning]])
    light, heavy = DENSITY * inertia * product(turn, turn), DENSITY * area * product(deflection, deflection)
    square, shapes = eigh(stiffness, np.block([[heavy, zero], [zero, light]]), subset_by_index=[0, count - 1])
    square[0] = 0.0  # the rigid swing, but for rounding
    return np.sqrt(square), shapes[:p]


def struck(
    places: npt.ArrayLike,
    radii: npt.ArrayLike,
    speed: float = 0.4,
    count: int = 80,
    step: float = 1e-7,
    duration: float = 1.5e-3,
) -> tuple[Floats, Floats]:
    """Times [s] and (times, cases) forces [N] of straight beams that meet spheres of ``radii`` at ``places`` [m]."""
    x, radius = np.atleast_1d(places), np.atleast_1d(radii)
    omega, shapes = modes(count)
    phi = (x[:, None] * legendre.legvander(2.0 * x / BEAM_LENGTH - 1.0, len(shapes) - 1) @ shapes).T
    stiffness = 4.0 / 3.0 * YOUNG / (1.0 - POISSON**2) * np.sqrt(radius)
    turned = omega[:, None] * step
    cos, sin = np.cos(turned), np.sin(turned)
    over = step * np.sinc(turned / np.pi)
    u = np.zeros(phi.shape)
    u[0] = -speed / phi[0]
    q = 0.5 * step * u  # all of it in the rigid swing, half a step before the first force
    forces = np.zeros((round(duration / step), len(x)))
    for force in forces:
        force[:] = stiffness * np.maximum(-(phi * q).sum(axis=0), 0.0) ** 1.5
        u += step * phi * force
        q, u = cos * q + over * u, cos * u - omega[:, None] * sin * q
    return step * (0.5 + np.arange(len(forces))), forces


def collisions_of(times: Floats, force: Floats) -> list[Collision]:
    """Of one history of force (times,)."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], force > 0.0, [0]])))
    return [(float(times[a]), float(times[b - 1]), float(force[a:b].max())) for a, b in edges.reshape(-1, 2).tolist()]
