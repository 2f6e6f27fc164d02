"""Systems of the user's own: what is refused, and a consistent start. (Motion: tests/analytic, tests/unit/steppers.)"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import lcpflex as lf


def particle(**changes: Any) -> lf.UserSystem:
    """A particle above the line y = 0."""
    given: dict[str, Any] = {
        "q": [0.0, 1.0], "u": [1.0, 0.0], "mass": np.eye(2), "force": lambda t, q, u: np.array([0.0, -9.81]),
        "gaps": lambda q: [q[1]], "normals": [[0.0], [1.0]], "tangents": [[1.0], [0.0]],
    }  # fmt: skip
    return lf.UserSystem(**{**given, **changes})


def pendulum(**changes: Any) -> lf.UserSystem:
    """A particle at the distance 1 + a t from the origin, a = 0.5."""
    given: dict[str, Any] = {
        "q": [1.0, 0.0], "u": [0.5, 0.0], "mass": np.diag([1.0, 2.0]), "force": lambda t, q, u: [0.0, -9.81],
        "constraints": lambda t, q: [math.hypot(*q) - 1.0 - 0.5 * t], "jacobian": lambda t, q: [q / math.hypot(*q)],
    }  # fmt: skip
    return lf.UserSystem(**{**given, **changes})


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"q": []}, "q: an empty array"),
        ({"q": [0.0, math.nan]}, "q: .*nan"),
        ({"force": None}, "force: None was given, expected a function"),
        ({"gaps": [0.0]}, "gaps: .*expected a function"),
        ({"friction": "rough"}, "friction: 'rough'"),
        ({"friction": [0.1, 0.2]}, "friction: .*expected a number or 1 of them"),
        ({"restitution": math.nan}, "restitution: nan"),
        ({"names": "ab"}, "names: 'ab'"),
        ({"names": [3]}, r"names: \[3\]"),
        ({"names": 3}, "names: 3"),
        ({"stiffness": [[1.0, 1.0], [0.0, 1.0]]}, "stiffness: an unsymmetric matrix"),
        ({"stiffness": np.diag([1.0, -1.0])}, "stiffness: a matrix with the eigenvalue -1"),
        ({"damping": -np.eye(2)}, "damping: a matrix with the eigenvalue -1"),
    ],
)
def test_bad_input(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(lf.ModelError, match=message):
        particle(**changes)


def test_laws_are_given_once_or_for_each_contact() -> None:
    two: dict[str, Any] = {"gaps": lambda q: [q[1], q[0] + 1.0], "normals": np.eye(2)[::-1], "tangents": np.eye(2)}
    np.testing.assert_array_equal(particle(**two, friction=0.3).friction, [0.3, 0.3])
    np.testing.assert_array_equal(particle(**two, friction=np.array([0.3, 0.0])).friction, [0.3, 0.0])


def test_initial_penetration_is_refused_with_contact_and_depth() -> None:
    with pytest.raises(lf.ModelError, match=r"contact 'floor' penetrates by 0\.01 m"):
        particle(q=[0.0, -0.01], names=["floor"]).system()
    particle(q=[0.0, -1e-9]).system()


def test_a_start_off_the_joints_is_refused_or_projected() -> None:
    pendulum().system()
    with pytest.raises(lf.ModelError, match=r"q: .*row 0 of the constraints by 0.1, .*project=True"):
        pendulum(q=[1.1, 0.0]).system()
    with pytest.raises(lf.ModelError, match=r"u: .*row 0 of the constraints by -0.5"):
        pendulum(u=[0.0, 0.0]).system()
    system = pendulum(q=[0.9, 0.8], u=[0.0, 3.0]).system(project=True)
    assert math.hypot(*system.q) == pytest.approx(1.0, abs=1e-11)
    assert system.u @ system.q == pytest.approx(0.5, abs=1e-9)
    with pytest.raises(lf.ModelError, match="contradict each other"):
        pendulum(
            constraints=lambda t, q: [q[0] - 1.0, q[0] - 2.0], jacobian=lambda t, q: [[1.0, 0.0], [1.0, 0.0]]
        ).system(project=True)


def test_the_rate_of_moving_joints_is_taken_by_differences() -> None:
    moving = pendulum(constraints=lambda t, q: [q[0] - math.exp(t)], jacobian=lambda t, q: [[1.0, 0.0]], u=[1.0, 0.0])
    moving.system()
    assert moving._functions.rate(0.3, np.array([1.0, 0.0]))[0] == pytest.approx(-math.exp(0.3), rel=1e-10)
    resting = pendulum(constraints=lambda t, q: [q[0] - 1.0], jacobian=lambda t, q: [[1.0, 0.0]], u=[0.0, 0.0])
    assert resting._functions.rate(0.3, np.array([1.7, 0.0]))[0] == 0.0
