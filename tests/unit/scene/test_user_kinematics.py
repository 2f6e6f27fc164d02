"""Systems of the user's own whose velocities are not the rates of their coordinates."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.dynamics.user_mechanics import hooks
from lcpflex.jit.kernel import FloatArray
from lcpflex.steppers import unmet
from lcpflex.steppers.user_hooks import hooks_of_steps
from tests.rates import assert_rate
from tests.spatial_flight import OMEGA, VELOCITY, J, apart, dzhanibekov, exact_flight, lengths

ARM = 0.5


def free_body(**changes: Any) -> lf.UserSystem:
    """R1 of spatial.md as a user would write it: place and quaternion, velocity and spin in body axes."""

    def kinematics(q: FloatArray) -> FloatArray:
        w, x, y, z = q[3:]
        B = np.zeros((7, 6))
        B[:3, :3] = np.eye(3)
        B[3:, 3:] = 0.5 * np.array([[-x, -y, -z], [w, -z, y], [z, w, -x], [-y, x, w]])
        return B

    given: dict[str, Any] = {
        "q": [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0],
        "u": [*VELOCITY, *OMEGA],
        "mass": np.diag([1.0, 1.0, 1.0, *J]),
        "force": lambda t, q, u: np.array([0.0, 0.0, 0.0, *-np.cross(u[3:], J * u[3:])]),
        "kinematics": kinematics,
        "normalise": lambda q: np.array([*q[:3], *(q[3:] / np.linalg.norm(q[3:]))]),
    }
    return lf.UserSystem(**{**given, **changes})


def hinged_rod(by_angle: bool) -> lf.UserSystem:
    """A rod hinged at an end strikes a wall with the other; its direction is an angle, or its cosine and sine."""

    def direction(q: FloatArray) -> tuple[float, float]:
        return (math.cos(q[2]), math.sin(q[2])) if by_angle else (q[2], q[3])

    def pinned(t: float, q: FloatArray) -> FloatArray:
        c, s = direction(q)
        return np.array([q[0] + ARM * c, q[1] + ARM * s])

    def jacobian(t: float, q: FloatArray) -> FloatArray:
        c, s = direction(q)
        return np.array([[1.0, 0.0, -ARM * s], [0.0, 1.0, ARM * c]])

    def normals(q: FloatArray) -> FloatArray:
        _, s = direction(q)
        return np.array([[-1.0], [0.0], [-ARM * s]])

    given: dict[str, Any] = {} if by_angle else {
        "kinematics": lambda q: np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -q[3]], [0.0, 0.0, q[2]]]),
        "normalise": lambda q: np.array([*q[:2], *(q[2:] / math.hypot(q[2], q[3]))]),
    }  # fmt: skip
    return lf.UserSystem(
        q=[-ARM, 0.0, 0.0] if by_angle else [-ARM, 0.0, 1.0, 0.0],
        u=[0.0, 0.0, 0.0],
        mass=np.diag([1.0, 1.0, 0.1]),
        force=lambda t, q, u: np.array([0.0, -9.81, 0.0]),
        gaps=lambda q: [0.5 - q[0] + ARM * direction(q)[0]],
        normals=normals,
        restitution=0.5,
        constraints=pinned,
        jacobian=jacobian,
        **given,
    )


@pytest.mark.parametrize(
    "stepper",
    [
        lf.EventDriven(rtol=1e-9),
        lf.Smooth(integrator=lf.ExplicitRungeKutta(rtol=1e-9)),
        lf.Smooth(integrator=lf.Stiff(rtol=1e-9)),
    ],
    ids=["events", "explicit", "stiff"],
)
def test_a_free_body_with_quaternions_moves_as_that_of_the_library(stepper: Any) -> None:
    own, known = (lf.simulate(scene, 0.5, stepper, record=0.05) for scene in (free_body(), dzhanibekov()))
    np.testing.assert_allclose(own.q[-1], known.q[-1], atol=2e-9)
    np.testing.assert_allclose(own.u[-1], known.u[-1], atol=2e-8)
    assert np.abs(lengths(own) - 1.0).max() < 1e-14


@pytest.mark.parametrize("stepper", [lf.MoreauJean, lf.GeneralizedAlpha])
def test_time_stepping_moves_it_to_second_order(stepper: Any) -> None:
    exact = exact_flight(0.4)(0.4)
    steps = np.array([0.02, 0.01, 0.005])
    errors = []
    for h in steps:
        own, known = (lf.simulate(scene, 0.4, stepper(h)) for scene in (free_body(), dzhanibekov()))
        errors.append(apart(own.q[-1, 3:], exact[:4]))
        np.testing.assert_allclose(own.u[-1], known.u[-1], atol=1e-12)  # forces at the mean velocity, too
        assert np.abs(lengths(own) - 1.0).max() < 1e-14
    assert_rate(steps, errors, 2.0, 0.15)


def test_adaptive_steps_keep_to_their_tolerance() -> None:
    stepper = lf.MoreauJean(2e-3, adaptive=lf.AdaptiveStep(rtol=1e-5))
    result = lf.simulate(free_body(), 0.3, stepper)
    assert apart(result.q[-1, 3:], exact_flight(0.3)(0.3)[:4]) < 3e-5


@pytest.mark.parametrize(
    ("stepper", "tolerance"),
    [(lf.EventDriven(rtol=1e-6), 3e-5), (lf.MoreauJean(2e-3), 8e-5), (lf.GeneralizedAlpha(4e-3), 3e-4)],
    ids=["events", "time stepping", "alpha"],
)
def test_joints_and_impacts_are_those_of_the_system_by_angles(stepper: Any, tolerance: float) -> None:
    results = [lf.simulate(hinged_rod(by_angle), 0.75, stepper, record=0.05) for by_angle in (True, False)]
    assert results[0].impulse[-1, 0, 0] > 0.1  # it has struck
    turned = np.arctan2(results[1].q[:, 3], results[1].q[:, 2])
    np.testing.assert_allclose(turned[-1], results[0].q[-1, 2], atol=tolerance)
    np.testing.assert_allclose(results[1].q[-1, :2], results[0].q[-1, :2], atol=tolerance)
    np.testing.assert_allclose(results[1].impulse[-1], results[0].impulse[-1], rtol=100.0 * tolerance)
    assert results[1].joint_drift.max() < 1e-3
    np.testing.assert_allclose(np.hypot(*results[1].q[:, 2:].T), 1.0, atol=1e-14)


def test_error_control_follows_the_numbers_of_a_configuration() -> None:
    """Pairs that close within a step are looked for along it: there are more numbers than velocities."""
    functions = hinged_rod(by_angle=False)._functions
    on_way: Any = hooks_of_steps(functions, hooks(functions))[unmet.on_way]
    h, u, end = 0.1, np.array([0.0, 0.2, 0.5]), np.array([0.1, 0.3, 0.7])
    q = np.array([0.0, 0.0, 1.0, 0.0])
    last = functions.kinematics.moved(q, 0.5 * (u + end), h)
    kept = SimpleNamespace(q=q, u=u, at=np.zeros(4))

    def at(share: float) -> Any:
        on_way(None, last, end, h, share, kept)
        return kept.at.copy()

    np.testing.assert_allclose(at(0.0), q, atol=1e-15)
    np.testing.assert_allclose(at(1.0), last, atol=1e-15)
    near = 1e-6
    np.testing.assert_allclose((at(near) - q) / (near * h), functions.kinematics.rate(q, u), atol=1e-5)
    np.testing.assert_allclose((last - at(1.0 - near)) / (near * h), functions.kinematics.rate(last, end), atol=1e-5)
    assert np.hypot(*at(0.5)[2:]) == pytest.approx(1.0, abs=1e-15)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"kinematics": np.eye(6)}, r"kinematics: .*\(7, 6\)"),
        ({"kinematics": np.zeros((7, 6))}, "kinematics: a matrix of rank 0 was given"),
        ({"kinematics": None}, "u: "),
        ({"kinematics": None, "u": np.zeros(7)}, "normalise: a function was given without kinematics"),
        ({"kinematics": lambda q: 1.0 / 0.0}, "kinematics: the function raised ZeroDivisionError"),
        ({"normalise": 3.0}, "normalise: 3.0 was given, expected a function"),
        ({"normalise": lambda q: q[:3]}, "normalise .*shape"),
        ({"q": [0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0]}, "q: normalise changes the start by 1"),
        ({"u": np.zeros(8)}, "u: 8 velocities were given with 7 numbers in q"),
        ({"u": []}, "u: 0 velocities"),
        ({"stiffness": np.eye(6)}, "stiffness: a matrix was given with kinematics"),
    ],
)
def test_bad_kinematics(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(lf.ModelError, match=message):
        free_body(**changes)


def test_states_between_instants_are_not_told() -> None:
    result = lf.simulate(free_body(), 0.01, lf.EventDriven(), record=0.005)
    assert result.at(0.005).how == "stored"
    with pytest.raises(lf.ModelError, match="kinematics of its own"):
        result.at(0.003)
