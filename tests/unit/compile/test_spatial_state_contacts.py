"""Contacts at a state in space: rows, biases and problems against closed forms and difference quotients."""

from __future__ import annotations

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.kinematics.spatial.configuration import advance

MU, G, RADIUS, MASS = 0.3, 9.81, 0.1, 2.0


def ball_on_a_slope(
    velocity: tuple[float, float, float] = (0.0, 0.0, 0.0),
    spin: tuple[float, float, float] = (0.0, 0.0, 0.0),
    first: str = "ball",
    restitution: float = 0.5,
) -> lf.SpatialScene:
    """A ball that touches the plane z = 0; its surface is declared first, or that of the ground."""
    scene = lf.SpatialScene(gravity=(0.0, 0.0, -G))
    ball = scene.add(
        lf.Sphere(RADIUS, mass=MASS), "ball", position=(0.3, 0.1, RADIUS), velocity=velocity, angular_velocity=spin
    )
    sides = [ball.surface(), scene.ground.plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0))]
    sides = sides if first == "ball" else sides[::-1]
    scene.contact(*sides, friction=MU, restitution=restitution, name="floor")
    return scene


def solved(problem: lf.solvers.SpatialContactProblem) -> np.ndarray:
    return np.asarray(lf.solvers.ConicFixedPoint().solve(problem).z)


@pytest.mark.parametrize("first", ["ball", "ground"])
def test_rows_of_a_ball_are_its_slip_on_the_first_body(first: str) -> None:
    at = ball_on_a_slope((1.0, 0.2, 0.0), (3.0, -2.0, 5.0), first).compile().at()
    sign = 1.0 if first == "ball" else -1.0
    assert at.contacts == ("floor",)
    assert at.W_T.shape == (6, 1, 2)
    assert at.slip_speeds.shape == at.w_T.shape == (1, 2)
    np.testing.assert_allclose(at.normals, [[0.0, 0.0, sign]], atol=1e-15)
    np.testing.assert_allclose(np.cross(at.normals[0], at.tangents[0, 0]), at.tangents[0, 1], atol=1e-15)
    np.testing.assert_allclose(at.places, [[0.3, 0.1, 0.0]], atol=1e-15)
    slip = np.array([1.0, 0.2, 0.0]) + np.cross([3.0, -2.0, 5.0], [0.0, 0.0, -RADIUS])
    np.testing.assert_allclose(at.slip_speeds[0], sign * at.tangents[0] @ slip, atol=1e-14)
    np.testing.assert_allclose(at.W_N[:, 0], [0.0, 0.0, 1.0, 0.0, 0.0, 0.0], atol=1e-15)
    np.testing.assert_allclose(at.w_N, 0.0, atol=1e-13)


def test_biases_are_what_differences_of_slip_leave() -> None:
    """gddot_T = W_T^T udot + w_T, of a motion with udot = 0."""
    compiled = ball_on_a_slope((1.0, 0.2, 0.0), (3.0, -2.0, 5.0), "ground").compile()
    u, h, model = compiled.u.copy(), 1e-5, compiled.system().model
    seen = []
    for t in (-h, h):
        q = compiled.q.copy()
        advance(model, compiled.q.copy(), u, t, q)
        there = compiled.at(q, u)
        seen.append(there.slip_speeds[0] @ there.tangents[0])
    at = compiled.at()
    change = (seen[1] - seen[0]) / (2.0 * h)
    np.testing.assert_allclose(at.w_T[0], at.tangents[0] @ change, atol=1e-7)


@pytest.mark.parametrize("first", ["ball", "ground"])
def test_a_sliding_ball_brakes_against_its_slip(first: str) -> None:
    at = ball_on_a_slope((1.2, 0.5, 0.0), first=first).compile().at()
    assert at.G.tolist() == [0]
    problem = at.contact_problem()
    assert isinstance(problem, lf.solvers.SpatialContactProblem)
    normal = solved(problem)[0]
    assert normal == pytest.approx(MASS * G, rel=1e-7)
    push = at.W_N[:, 0] * normal - MU * normal * at.W_T[:, 0] @ at.slip_speeds[0] / np.linalg.norm(at.slip_speeds)
    udot = np.linalg.solve(at.M, at.h + push)
    np.testing.assert_allclose(udot[:3], [-MU * G * 12.0 / 13.0, -MU * G * 5.0 / 13.0, 0.0], atol=1e-6)


def test_a_ball_that_strikes_is_left_as_by_newton() -> None:
    at = ball_on_a_slope((1.0, 0.0, -2.0)).compile().at()
    with pytest.raises(lf.ModelError, match="its impact comes first"):
        at.contact_problem()
    p = solved(at.contact_problem("impulse"))
    after = at.u + np.linalg.solve(at.M, at.W_N[:, 0] * p[0] + at.W_T[:, 0] @ p[1:])
    stick = 2.0 / 7.0 * MASS  # of the slip of 1 m/s, below mu times the normal impulse
    assert p[0] == pytest.approx(1.5 * 2.0 * MASS, rel=1e-7)
    assert np.linalg.norm(p[1:]) == pytest.approx(stick, rel=1e-6)
    np.testing.assert_allclose(after[:3], [5.0 / 7.0, 0.0, 1.0], atol=1e-6)


def test_a_ball_at_rest_may_stick() -> None:
    at = ball_on_a_slope().compile().at()
    assert at.H.tolist() == at.N.tolist() == [0]
    np.testing.assert_allclose(solved(at.contact_problem()), [MASS * G, 0.0, 0.0], atol=1e-6)
