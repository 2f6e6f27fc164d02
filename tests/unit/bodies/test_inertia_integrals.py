"""The kinetic energy made of the inertia integrals is the integral of rho v.v / 2 over the moving, deformed body."""

from __future__ import annotations

import math

import numpy as np
import pytest

from lcpflex.bodies import Bar, Beam, Body, Box, Matrices, Polygon

BEAM = Beam(0.7, 0.028, 0.05, 2700.0, 6.9e10, elements=6)
TURN = np.array([[0.0, -1.0], [1.0, 0.0]])


def motion(body: Body) -> tuple[np.ndarray, np.ndarray]:
    """Any angle, modal coordinates of the size of the body, and velocities."""
    random = np.random.default_rng(7)
    scale = 0.1 * math.sqrt(body.inertia)
    return scale * random.standard_normal(body.modes), random.standard_normal(3 + body.modes) * scale


def energy_of_integrals(body: Body, q: np.ndarray, u: np.ndarray) -> float:
    """1/2 u^T M(q) u with the entries of the mass matrix, frame at angle 0."""
    coupling = np.zeros((body.modes, body.modes)) if body.coupling is None else body.coupling
    matrix = np.eye(3 + body.modes)
    matrix[:2, :2] *= body.mass
    matrix[:2, 2] = matrix[2, :2] = TURN @ (body.moment + body.S.T @ q)
    matrix[:2, 3:] = body.S.T
    matrix[3:, :2] = body.S
    matrix[2, 2] = body.inertia + 2 * body.a @ q + q @ q
    matrix[2, 3:] = matrix[3:, 2] = body.c + q @ coupling
    return float(0.5 * u @ matrix @ u)


def velocity(body: Body, q: np.ndarray, u: np.ndarray, x: float, y: float) -> np.ndarray:
    point = body.locate(x, y)
    return u[:2] + TURN @ (point.place + point.phi.T @ q) * u[2] + point.phi.T @ u[3:]


@pytest.mark.parametrize("modes", [3, 18])
def test_beam(modes):
    body = BEAM.reduce(modes)
    q, u = motion(body)
    place, weight = np.polynomial.legendre.leggauss(4)
    total = 0.0
    for k in range(6):
        for r, w in zip(place, weight, strict=True):
            v = velocity(body, q, u, 0.7 / 6 * (k + 0.5 * (r + 1)), 0.0)
            total += 0.5 * w * body.mass / 6 * 0.5 * float(v @ v)
    assert energy_of_integrals(body, q, u) == pytest.approx(total, rel=1e-10)


@pytest.mark.parametrize("lumped", [False, True])
def test_bar(lumped):
    body = Bar(2.0, 0.1, 5.0, 9.0, elements=8, lumped=lumped).reduce()
    q, u = motion(body)
    v = np.array([velocity(body, q, u, 0.25 * k, 0.0) for k in range(9)])
    ends = np.sum(v[:-1] ** 2) + np.sum(v[1:] ** 2)
    total = ends / 2 if lumped else (ends + np.sum(v[:-1] * v[1:])) / 3
    assert energy_of_integrals(body, q, u) == pytest.approx(0.5 * body.mass / 8 * total, rel=1e-10)


def test_lattice_given_by_matrices():
    """A square of point masses with all its six springs, off the origin: modes that couple by D."""
    places = np.array([[1.0, 2.0], [2.0, 2.0], [2.0, 3.0], [1.0, 3.0]])
    weights = np.array([1.0, 2.0, 3.0, 4.0])
    stiffness = np.zeros((8, 8))
    for i in range(4):
        for j in range(i):
            along = (places[i] - places[j]) / np.hypot(*(places[i] - places[j]))
            row = np.zeros(8)
            row[2 * i : 2 * i + 2], row[2 * j : 2 * j + 2] = along, -along
            stiffness += 100.0 * (1 + i) * np.outer(row, row)
    body = Matrices(np.diag(np.repeat(weights, 2)), stiffness, places).reduce(None)
    assert body.modes == 5
    assert body.coupling is not None
    assert body.mass == pytest.approx(10.0)
    assert body.moment == pytest.approx(weights @ places)
    assert body.inertia == pytest.approx(weights @ np.sum(places**2, axis=1))
    q, u = motion(body)
    total = sum(0.5 * m * np.sum(velocity(body, q, u, *at) ** 2) for m, at in zip(weights, places, strict=True))
    assert energy_of_integrals(body, q, u) == pytest.approx(total, rel=1e-11)


def test_rigid():
    body = Polygon([(1.0, 1.0), (3.0, 1.0), (3.0, 2.0), (1.0, 2.0)], density=2.0)
    box = Box(2.0, 1.0, density=2.0)
    u = np.array([0.3, -0.2, 1.7])
    at_center = u[:2] + u[2] * (TURN @ np.array([2.0, 1.5]))
    expected = 0.5 * box.mass * at_center @ at_center + 0.5 * box.inertia * u[2] ** 2
    assert energy_of_integrals(body, np.zeros(0), u) == pytest.approx(expected, rel=1e-12)
