"""Programs over cones of friction of second order against what geometry says."""

from __future__ import annotations

import math

import numpy as np
import pytest

from lcpflex.statics.cone_programs import Cones, ends_in_cones, margins_in_cones, shortest_in_cones


def of_contacts(friction: tuple[float, ...]) -> Cones:
    """Of z = (n, t1, t2) of each contact."""
    eye = np.eye(3 * len(friction))
    second = [np.vstack([mu * eye[3 * k], eye[3 * k + 1 : 3 * k + 3]]) for k, mu in enumerate(friction)]
    return Cones(eye[::3], np.array(second))


def test_sides_tell_how_far_inside() -> None:
    cones = of_contacts((0.5, 0.0))
    assert cones.sides(np.array([2.0, 0.3, 0.4, 1.0, 0.0, 0.1])) == pytest.approx([2.0, 1.0, 0.5, -0.1])


@pytest.mark.parametrize("friction", [0.05, 0.5, 3.0])
def test_shortest_of_a_pinch(friction: float) -> None:
    """Friction of 0.6 and 0.8 is given: the least normal force for it is 1 / mu, to rounding."""
    x, N = np.array([0.0, 0.6, 0.8]), np.array([[1.0], [0.0], [0.0]])
    y = shortest_in_cones(x, N, of_contacts((friction,)), 0.0)
    assert y is not None
    assert y == pytest.approx([1.0 / friction], rel=1e-12)


def test_shortest_on_a_curved_side() -> None:
    """One friction component is free: the nearest point of a hyperbola n = sqrt(1 + t^2) / mu is its vertex, where
    nothing but the curvature of the cone tells the other component."""
    x, N = np.array([0.0, 1.0, 0.0, 0.0, 0.0, 0.3]), np.zeros((6, 3))
    N[0, 0] = N[3, 1] = 1.0
    N[[2, 5], 2] = math.sqrt(0.5), -math.sqrt(0.5)
    x[[2, 5]] = 0.15  # at right angles to the last column
    y = shortest_in_cones(x, N, of_contacts((0.5, 0.5)), 0.0)
    assert y is not None
    z = x + N @ y
    assert of_contacts((0.5, 0.5)).sides(z)[2:] == pytest.approx([0.0, 0.0], abs=1e-12)
    best, least = None, np.inf
    for share in np.linspace(-1.0, 1.0, 20_001):  # by hand: t of the first, 0.3 - t of the second
        first, second = 2.0 * math.hypot(1.0, share), 2.0 * abs(0.3 - share)
        size = first**2 + second**2 + 1.0 + share**2 + (0.3 - share) ** 2
        if size < least:
            best, least = share, size
    assert z[2] == pytest.approx(best, abs=1e-4)
    assert float(z @ z) <= least * (1.0 + 1e-12)


def test_cones_without_a_common_point() -> None:
    x, N = np.array([1.0, 0.6, 0.8]), np.array([[0.0], [0.8], [-0.6]])
    assert shortest_in_cones(x, N, of_contacts((0.5,)), 0.0) is None


def test_ends() -> None:
    """Friction in a disc of radius 2; the normal force above the friction has no bound."""
    cones = of_contacts((0.5,))
    assert ends_in_cones(np.array([1.0]), np.array([4.0, 0.0, 0.0]), np.eye(3)[:, 1:2], cones, 0.0) == pytest.approx(
        2.0
    )
    assert ends_in_cones(np.array([1.0]), np.array([4.0, 1.0, 0.0]), np.eye(3)[:, :1], cones, 0.0) == np.inf
    low = ends_in_cones(np.array([-1.0]), np.array([4.0, 1.0, 0.0]), np.eye(3)[:, :1], cones, 0.0)
    assert low == pytest.approx(2.0)  # from 4 down to 2


def test_margins() -> None:
    """Two contacts whose friction adds up to their limit: both inside is asked for, one is not to be had."""
    cones, N = of_contacts((0.5, 0.5)), np.zeros((6, 1))
    N[1], N[4] = math.sqrt(0.5), -math.sqrt(0.5)
    wanted = np.array([False, False, True, True])
    loose = margins_in_cones(np.array([2.0, 1.0, 0.0, 2.0, 0.5, 0.0]), N, cones, wanted, 1e-3, 0.0)
    assert loose is not None
    assert (loose[2:] > 0.9e-3).all()
    tight = margins_in_cones(np.array([2.0, 1.0, 0.0, 2.0, 1.0, 0.0]), N, cones, wanted, 1e-3, 0.0)
    assert tight is not None
    assert np.abs(tight[2:]).max() < 1e-8
