"""Shares of forces that nothing determines: least sum of squares over weights, among all with the same effect."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from lcpflex.solvers.contact.cones.shares import Shares, share_out, shares

PLACES = np.array([(0.1, 0.05), (0.1, -0.05), (-0.1, 0.05), (-0.1, -0.05), (0.02, 0.08)])
MASS = np.diag([1.0, 400.0, 150.0])  # inverse: of a lift and two turns


def levers(n: int) -> NDArray[np.float64]:
    return np.c_[np.ones(n), PLACES[:n]]


def posed(W: Any, x: Any, weight: Any, own: Any = None) -> Shares:
    n = len(x)
    s = shares(n, 3 * n, 6)
    s.n, s.m = n, n
    s.W[:n, :n], s.x[:n], s.weight[:n] = W, x, weight
    s.own[:n] = np.diag(W) if own is None else own
    s.contact[:n] = np.arange(n)
    return s


@pytest.mark.parametrize("weight", [np.ones(5), np.array([1.0, 3.0, 0.2, 0.7, 2.0]), 1e-6 * np.ones(5)])
@pytest.mark.parametrize("scale", [1.0, 1e9, 1e-9])
def test_least_weighted_forces(weight: Any, scale: float) -> None:
    B = levers(5)
    f = np.array([3.0, 2.0, 2.0, 3.0, 2.0])
    s = posed(scale * B @ MASS @ B.T, f, weight)
    assert share_out(s)
    D = np.diag(weight)
    expected = D @ B @ np.linalg.solve(B.T @ D @ B, B.T @ f)
    assert (expected > 0.0).all()
    assert s.x[:5] == pytest.approx(expected, rel=1e-9)


def test_the_friction_of_what_slides_counts_with_the_normals() -> None:
    """W = B A^-1 C^T is not symmetric: forces in D B z of the same effect, not the shortest."""
    rng = np.random.default_rng(3)
    B = levers(5)
    C = B + 0.2 * rng.normal(size=B.shape)
    f = np.array([3.0, 1.0, 2.0, 4.0, 0.5])
    W = B @ MASS @ C.T
    s = posed(W, f, np.ones(5), np.diag(B @ MASS @ B.T))
    assert share_out(s)
    assert s.x[:5] == pytest.approx(B @ np.linalg.solve(C.T @ B, C.T @ f), rel=1e-9)
    assert W @ s.x[:5] == pytest.approx(W @ f, rel=1e-9)


def test_a_corner_of_no_weight_gets_nothing_unless_it_must() -> None:
    B = levers(4)
    middle, corner = np.array([1.0, 1.0, 1.0, 1.0]), np.array([0.0, 0.0, 0.0, 5.0])
    for f, free in ((middle, False), (corner, True)):
        s = posed(B @ MASS @ B.T, f, np.array([1.0, 1.0, 1.0, 0.0]))
        assert share_out(s)
        assert (s.x[3] == pytest.approx(5.0, rel=1e-6)) if free else (abs(s.x[3]) < 1e-6)


def test_contacts_do_not_pull() -> None:
    """A load near a corner: compliant feet there press, the opposite one opens and the others share without it."""
    B = levers(4)
    f = np.array([4.0, 0.5, 0.5, 0.0])
    s = posed(B @ MASS @ B.T, f, np.ones(4))
    assert share_out(s)
    assert s.x[:4] == pytest.approx([4.0, 0.5, 0.5, 0.0], abs=1e-12)
    assert s.left == 3


@pytest.mark.parametrize("n", [1, 2, 3])
def test_forces_that_are_determined_stay(n: int) -> None:
    B = levers(n)
    f = np.array([2.0, 3.0, 1.0])[:n]
    s = posed(B @ MASS @ B.T, f, np.ones(n))
    assert not share_out(s)
    assert s.x[:n].tolist() == f.tolist()


def test_the_order_of_contacts_does_not_matter() -> None:
    B, f, weight = levers(5), np.array([3.0, 0.0, 2.0, 4.0, 0.5]), np.array([1.0, 2.0, 1.0, 0.5, 1.0])
    W = B @ MASS @ B.T
    s = posed(W, f, weight)
    share_out(s)
    for seed in range(5):
        order = np.random.default_rng(seed).permutation(5)
        other = posed(W[np.ix_(order, order)], f[order], weight[order])
        share_out(other)
        assert other.x[:5] == pytest.approx(s.x[order], rel=1e-10)
