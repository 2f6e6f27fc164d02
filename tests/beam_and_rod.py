"""A hinged beam strikes a rod by Hertz's law: modes of both by themselves, as a reference for solids."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from scipy.linalg import eigh

from lcpflex.jit.kernel import FloatArray

__all__ = ["Collision", "beam_strikes_rod"]

STEEL, ALUMINIUM = (7850.0, 2.1e11, 0.3), (2700.0, 7e10, 0.33)  # density, Young's modulus, Poisson's ratio
LENGTH, WIDTH, STRIKE, NOSE = 0.5, 0.02, 0.45, 0.015  # of the pendulum [m]
ROD, ROUND = 1.0, 0.01  # length and radius of the rod [m]


class Collision(NamedTuple):
    """Of one push."""

    end: float  # [s]
    peak: float  # [N]
    impulse: float  # [N s]


def hinged_beam(modes: int, elements: int = 200) -> tuple[FloatArray, FloatArray]:
    """omega of a Timoshenko beam hinged at one end, the first that of its swing, and its modes where it strikes.

    Elements of cubic w and quadratic rotation (Przemieniecki 1968) with the rotary inertia of their sections.
    """
    rho, E, nu = STEEL
    A, inertia, step = WIDTH**2, WIDTH**4 / 12.0, LENGTH / elements
    soft = 12.0 * E * inertia / (5.0 / 6.0 * E / (2.0 * (1.0 + nu)) * A * step**2)
    s = np.array([1.0, step, 1.0, step])
    bend = np.array([[12, 6, -12, 6], [6, 4 + soft, -6, 2 - soft], [-12, -6, 12, -6], [6, 2 - soft, -6, 4 + soft]])
    mass = np.array([[156, 22, 54, -13], [22, 4, 13, -3], [54, 13, 156, -22], [-13, -3, -22, 4]])
    turn = np.array([[36, 3, -36, 3], [3, 4, -3, -1], [-36, -3, 36, -3], [3, -1, -3, 4]])
    K, M = np.zeros((2, 2 * elements + 2, 2 * elements + 2))
    for e in range(elements):
        own = slice(2 * e, 2 * e + 4)
        K[own, own] += E * inertia / (step**3 * (1.0 + soft)) * bend * np.outer(s, s)
        M[own, own] += (rho * A * step / 420.0 * mass + rho * inertia / (30.0 * step) * turn) * np.outer(s, s)
    square, shapes = eigh(K[1:, 1:], M[1:, 1:], subset_by_index=[0, modes - 1])
    square[0] = 0.0
    return np.sqrt(square), shapes[2 * round(STRIKE / step) - 1]


def free_rod(modes: int) -> tuple[FloatArray, FloatArray]:
    """omega of a rod that moves along itself, the first that of the whole, and its modes at the end."""
    rho, E, _ = ALUMINIUM
    k = np.arange(modes)
    mass = rho * math.pi * ROUND**2 * ROD
    return k * math.pi / ROD * math.sqrt(E / rho), np.where(k == 0, 1.0, math.sqrt(2.0)) / math.sqrt(mass)


def beam_strikes_rod(speed: float = 1.0, beam: int = 80, rod: int = 200, step: float = 5e-8) -> Collision:
    """Modes turn by omega h exactly between kicks of the force k delta^(3/2)."""
    (w_beam, at_beam), (w_rod, at_rod) = hinged_beam(beam), free_rod(rod)
    w, at = np.concatenate([w_beam, w_rod]), np.concatenate([at_beam, -at_rod])
    compliance = sum((1.0 - nu**2) / E for _, E, nu in (STEEL, ALUMINIUM))
    k = 4.0 / 3.0 / compliance * math.sqrt(NOSE)
    cos, sin, reach = np.cos(w * step), w * np.sin(w * step), step * np.sinc(w * step / math.pi)
    q, v = np.zeros((2, len(w)))
    v[0] = speed / at[0]
    q += 0.5 * step * v
    end = peak = impulse = 0.0
    for i in range(round(6e-4 / step)):
        force = k * max(float(at @ q), 0.0) ** 1.5
        if force == 0.0 and impulse > 0.0:
            break
        v -= step * force * at
        impulse += step * force
        peak, end = max(peak, force), (i + 1) * step
        q, v = cos * q + reach * v, cos * v - sin * q
    return Collision(end, peak, impulse)
