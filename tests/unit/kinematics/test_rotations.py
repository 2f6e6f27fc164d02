"""Rotations against scipy's, series and differences, and configurations that are moved by them."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.spatial.transform import Rotation

from lcpflex.jit.kernel import FloatArray
from lcpflex.jit.struct import pack
from lcpflex.kinematics.configuration import advance, difference, normalise, rate
from lcpflex.kinematics.spatial import rotations
from tests.spatial_bodies import any_state, random_body, spatial_model

RNG = np.random.default_rng(11)
AXIS = np.array([2.0, -3.0, 6.0]) / 7.0
ANGLES = (0.0, 1e-9, 0.9e-4, 1.1e-4, 1e-2, 0.4999, 0.5001, 1.0, 3.1, 5.0)


@pytest.fixture(autouse=True)
def numbers_of_its_own() -> None:
    """Each test draws from the beginning: the same numbers alone and after others."""
    RNG.bit_generator.state = np.random.default_rng(11).bit_generator.state


def skew(a: FloatArray) -> FloatArray:
    return np.array([[0.0, -a[2], a[1]], [a[2], 0.0, -a[0]], [-a[1], a[0], 0.0]])


def matrix(nine: tuple[float, ...]) -> FloatArray:
    return np.reshape(nine, (3, 3))


@pytest.mark.parametrize("angle", ANGLES)
def test_exponential_and_logarithm(angle: float) -> None:
    psi = angle * AXIS
    p = rotations.exponential(*psi)
    assert np.linalg.norm(p) == pytest.approx(1.0, abs=1e-15)
    np.testing.assert_allclose(
        matrix(rotations.rotation_matrix(*p)), Rotation.from_rotvec(psi).as_matrix(), rtol=0, atol=1e-15
    )
    back = rotations.logarithm(p)
    shortest = psi if angle <= np.pi else (angle - 2 * np.pi) * AXIS
    np.testing.assert_allclose(back, shortest, rtol=1e-15, atol=1e-15)
    assert rotations.logarithm(tuple(-x for x in p)) == pytest.approx(back, abs=0) or angle == 0.0


def test_quaternions_compose_as_matrices_do() -> None:
    a, b = (rotations.unit(tuple(RNG.normal(size=4))) for _ in range(2))
    both = matrix(rotations.product(rotations.rotation_matrix(*a), rotations.rotation_matrix(*b)))
    np.testing.assert_allclose(matrix(rotations.rotation_matrix(*rotations.compose(a, b))), both, atol=1e-15)
    np.testing.assert_allclose(
        both, (Rotation.from_quat(np.roll(a, -1)) * Rotation.from_quat(np.roll(b, -1))).as_matrix(), atol=1e-15
    )
    assert rotations.compose(a, rotations.conjugate(a)) == pytest.approx((1.0, 0.0, 0.0, 0.0), abs=1e-15)
    m, x, y = rotations.rotation_matrix(*a), RNG.normal(size=3), RNG.normal(size=3)
    np.testing.assert_allclose(rotations.transform(m, *x), matrix(m) @ x, atol=1e-15)
    np.testing.assert_allclose(rotations.transform_back(m, *x), matrix(m).T @ x, atol=1e-15)
    np.testing.assert_allclose(rotations.cross(tuple(x), tuple(y)), np.cross(x, y), atol=1e-15)


def series(psi: FloatArray) -> FloatArray:
    """T = sum psi~^k / (k + 1)!, of any angle."""
    total, term = np.eye(3, dtype=psi.dtype), np.eye(3, dtype=psi.dtype)
    for k in range(2, 60):
        term = term @ skew(psi) / k
        total = total + term
    return total


@pytest.mark.parametrize("angle", ANGLES[:-1])
def test_tangent_and_its_rate(angle: float) -> None:
    psi, psidot = angle * AXIS, np.array([0.4, 0.7, -0.2])
    np.testing.assert_allclose(matrix(rotations.tangent(*psi)), series(psi), rtol=0, atol=1e-15)
    slope = series(psi + 1e-30j * psidot).imag / 1e-30
    np.testing.assert_allclose(matrix(rotations.tangent_rate(tuple(psi), tuple(psidot))), slope, rtol=0, atol=3e-15)
    h = 1e-3
    turned = sum(
        w * (expm(skew(psi + j * h * psidot)) - expm(skew(psi - j * h * psidot))) / h
        for j, w in ((1, 4 / 5), (2, -1 / 5), (3, 4 / 105), (4, -1 / 280))
    )
    spin = skew(matrix(rotations.tangent(*psi)) @ psidot)
    np.testing.assert_allclose(turned @ expm(skew(psi)).T, spin, rtol=0, atol=1e-11)


def test_configurations_move_and_compare() -> None:
    plain = spatial_model([random_body(RNG, 0), random_body(RNG, 3), random_body(RNG, 1)])
    model = pack(plain)
    q, u = any_state(RNG, plain)
    there, back, numbers = np.zeros(len(q)), np.zeros(len(u)), np.zeros(len(q))
    advance(model, q, u, 0.3, there)
    difference(model, q, there, back)
    np.testing.assert_allclose(back, 0.3 * u, rtol=0, atol=1e-15)
    other = there.copy()
    for i in plain.bodies.place[:-1]:
        other[i + 3 : i + 7] *= -1.0
        A, B = (matrix(rotations.rotation_matrix(*x[i + 3 : i + 7])) for x in (q, there))
        omega = u[int(plain.bodies.dof[list(plain.bodies.place).index(i)]) :][3:6]
        np.testing.assert_allclose(B, A @ expm(0.3 * skew(omega)), atol=1e-15)
    difference(model, q, other, back)
    np.testing.assert_allclose(back, 0.3 * u, rtol=0, atol=1e-15)
    rate(model, q, u, numbers)
    ahead, behind = np.zeros(len(q)), np.zeros(len(q))
    advance(model, q, u, 1e-5, ahead)
    advance(model, q, u, -1e-5, behind)
    np.testing.assert_allclose((ahead - behind) / 2e-5, numbers, rtol=0, atol=1e-9)
    same = q.copy()
    advance(model, same, u, 0.3, same)
    np.testing.assert_array_equal(same, there)
    stretched = there.copy()
    for i in plain.bodies.place[:-1]:
        stretched[i + 3 : i + 7] *= 1.01
    normalise(model, stretched)
    np.testing.assert_allclose(stretched, there, rtol=0, atol=1e-15)


def test_lengths_of_quaternions_stay_over_many_steps() -> None:
    plain = spatial_model([random_body(RNG, 0)])
    model = pack(plain)
    q, u = any_state(RNG, plain)
    for _ in range(2000):
        advance(model, q, u, 0.01, q)
        assert abs(np.linalg.norm(q[3:7]) - 1.0) < 1e-15


def test_interpreted_kernels_are_the_compiled_ones() -> None:
    for square in (0.0, 0.1, 0.2499, 0.26, 4.0):
        assert rotations.coefficients.py_func(square) == pytest.approx(rotations.coefficients(square), abs=1e-15)  # type: ignore[attr-defined]
    p = rotations.exponential.py_func(0.3, -0.2, 0.7)  # type: ignore[attr-defined]
    assert rotations.logarithm.py_func(p) == pytest.approx((0.3, -0.2, 0.7), abs=1e-15)  # type: ignore[attr-defined]
