"""Complementarity problems with a known solution, and what no change of units or order may alter."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from lcpflex.solvers import ContactProblem, Lcp, Lemke, QuadraticProgram

SIZES = st.integers(1, 8)
ENTRIES = st.floats(-3.0, 3.0, allow_subnormal=False).map(lambda x: round(x, 2))
RELAXED = settings(max_examples=60, deadline=None, derandomize=True)


@st.composite
def definite(draw, skew: bool):
    """(M, q, z): M positive definite, z the one solution by construction, some pairs with z = w = 0."""
    n = draw(SIZES)
    A = draw(arrays(float, (n, n), elements=ENTRIES))
    M = A @ A.T + 0.5 * np.eye(n) + (A - A.T if skew else 0.0)
    kind = draw(arrays(np.int64, n, elements=st.integers(0, 2)))
    size = draw(arrays(float, n, elements=st.floats(0.1, 2.0)))
    z = np.where(kind == 0, size, 0.0)
    w = np.where(kind == 1, size, 0.0)
    return M, w - M @ z, z


@st.composite
def semidefinite(draw):
    """(M, q, w): M = J J^T of rank below n, so that z is not unique but w is."""
    n = draw(st.integers(2, 8))
    J = draw(arrays(float, (n, max(1, n // 2)), elements=ENTRIES))
    M = J @ J.T
    active = draw(arrays(bool, n))
    size = draw(arrays(float, n, elements=st.floats(0.1, 2.0)))
    w = np.where(active, 0.0, size)
    return M, w - M @ np.where(active, size, 0.0), w


@RELAXED
@given(definite(skew=True))
def test_lemke_finds_the_planted_solution(planted):
    M, q, z = planted
    solution = Lemke().solve(Lcp(M, q))
    assert solution.solved
    assert solution.z == pytest.approx(z, abs=1e-8)


@RELAXED
@given(semidefinite())
def test_redundant_contacts_have_one_velocity(planted):
    M, q, w = planted
    solution = Lemke().solve(Lcp(M, q))
    assert solution.solved
    assert solution.w == pytest.approx(w, abs=1e-7)


@settings(RELAXED, max_examples=25)
@given(semidefinite(), st.sampled_from(["clarabel", "osqp"]))
def test_quadratic_programs_agree_or_say_that_they_do_not(planted, backend):
    M, q, w = planted
    problem = Lcp(M, q)
    solution = QuadraticProgram(backend).solve(problem)
    assert solution.solved == (problem.residual(solution.z) <= 1e-10)
    assert solution.solved
    assert solution.w == pytest.approx(w, abs=1e-6)


@RELAXED
@given(definite(skew=False), st.integers(-20, 20), st.integers(-20, 20), st.data())
def test_units_scale_the_solution(planted, power_of_matrix, power_of_load, data):
    M, q, z = planted
    D = 10.0 ** data.draw(arrays(float, len(q), elements=st.integers(-3, 3).map(float)))
    a, b = 2.0**power_of_matrix, 2.0**power_of_load
    solution = Lemke().solve(Lcp(a * M * np.outer(D, D), b * q * D))
    assert solution.solved
    scaled = solution.z * D * a / b
    weight = np.sqrt(np.diag(M)) * D  # a row counts in the residual by its own size
    assert np.abs((scaled - z) * weight).max() <= 1e-6 * max(1.0, np.abs(z * weight).max(), np.abs(q * D).max())


@RELAXED
@given(definite(skew=True), st.randoms(use_true_random=False))
def test_order_of_the_contacts_does_not_matter(planted, random):
    M, q, z = planted
    order = list(range(len(q)))
    random.shuffle(order)
    solution = Lemke().solve(Lcp(M[np.ix_(order, order)], q[order]))
    assert solution.z == pytest.approx(z[order], abs=1e-8)


@RELAXED
@given(st.data())
def test_single_frictional_contacts_follow_coulomb(data):
    """Independent mass points: the answer of each is known in closed form."""
    n = data.draw(st.integers(1, 5))
    mass = data.draw(arrays(float, n, elements=st.floats(0.1, 10.0)))
    mu = data.draw(arrays(float, n, elements=st.sampled_from([0.0, 0.2, 0.7, 1.5])))
    normal = data.draw(arrays(float, n, elements=st.floats(-2.0, 2.0)))
    slide = data.draw(arrays(float, n, elements=st.floats(-2.0, 2.0)))
    tangent = np.flatnonzero(mu)
    problem = ContactProblem(
        np.diag(np.concatenate([1.0 / mass, 1.0 / mass[tangent]])), np.concatenate([normal, slide[tangent]]), mu
    )
    solution = Lemke().solve(problem.lcp())
    assert solution.solved
    pressed, rubbed = problem.forces(solution.z)
    expected = mass * np.maximum(-normal, 0.0)
    assert pressed == pytest.approx(expected, abs=1e-8)
    limit = mu * expected
    assert rubbed == pytest.approx(np.clip(-mass * slide, -limit, limit)[tangent], abs=1e-7)
