"""Contact problems in space with known answers."""

from __future__ import annotations

import numpy as np

from lcpflex.solvers import SpatialContactProblem

__all__ = ["left_of_map", "planted", "puck"]


def planted(rng, n, columns=None, largest=2.0):
    """A problem of n contacts by its factor, and a solution with open, sticking and sliding contacts."""
    J = rng.standard_normal((3 * n, 3 * n + 2 if columns is None else columns))
    mu = np.where(rng.random(n) < 0.2, 0.0, rng.uniform(0.05, largest, n))
    r, u = np.zeros((n, 3)), np.zeros((n, 3))
    state = rng.integers(3, size=n)
    for k in range(n):
        direction = rng.standard_normal(2)
        direction /= np.linalg.norm(direction)
        if state[k] == 0:
            u[k] = [rng.uniform(0.1, 1.0), *rng.standard_normal(2)]
        else:
            pressed = rng.uniform(0.1, 1.0)
            slides = state[k] == 2 or mu[k] == 0.0
            r[k] = [pressed, *(-mu[k] * pressed * (1.0 if slides else 0.7) * direction)]
            u[k, 1:] = rng.uniform(0.1, 1.0) * direction if slides else 0.0
    return SpatialContactProblem(J @ J.T, u.ravel() - J @ (J.T @ r.ravel()), mu, factor=J), r.ravel()


def puck(velocity, mu=0.3, feet=4, height=0.0):
    """A disc of 2 kg on feet around it, all in the plane ``height`` below its mass centre.

    velocity (6,): of its mass centre and its rotation, without contact forces.
    """
    angle = 2.0 * np.pi * np.arange(feet) / feet
    places = np.column_stack([0.1 * np.cos(angle), 0.1 * np.sin(angle), np.full(feet, -height)])
    rows = []
    for place in places:
        for axis in ([0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]):
            rows.append([*axis, *np.cross(place, axis)])
    rows = np.array(rows)
    factor = rows * np.sqrt([0.5, 0.5, 0.5, 200.0, 200.0, 100.0])
    return SpatialContactProblem(factor @ factor.T, rows @ np.array(velocity), np.full(feet, mu), factor=factor)


def left_of_map(force, velocity, mu):
    """Largest component of r - P_K(r - (u + mu |u_T| n)) of one contact."""
    x = force - velocity
    x[0] -= mu * np.linalg.norm(velocity[1:])
    slip = np.linalg.norm(x[1:])
    if slip > mu * x[0]:
        normal = max((x[0] + mu * slip) / (1.0 + mu**2), 0.0)
        x = np.array([normal, *(mu * normal * x[1:] / slip if slip else x[1:])])
    return np.abs(force - x).max()
