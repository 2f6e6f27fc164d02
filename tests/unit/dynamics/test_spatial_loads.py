"""Springs, dampers, forces and torques in space: energies, gradients, power."""

from __future__ import annotations

import math

import numpy as np
import pytest

from lcpflex.dynamics.applied_forces import applied_forces, spring_energy
from lcpflex.dynamics.spatial.applied_forces import (
    FOLLOWER,
    FORCE,
    TORQUE,
    TORQUE_FOLLOWER,
    WOUND,
    spring_stretch,
)
from lcpflex.jit.kernel import FloatArray
from lcpflex.kinematics.spatial.logarithms import half_cotangent, vector_of_axes
from lcpflex.kinematics.spatial.points import point_axes, point_place
from lcpflex.kinematics.spatial.rotations import exponential, rotation_matrix
from tests.space import Line, Moving, derivatives, moving
from tests.unit.kinematics.test_spatial_rows import LINES

SIZE = (0.3, -2.0, 1.1)


def forces(case: Moving, t: float = 0.0) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Conservative, dissipative and driving ones."""
    kinds = np.zeros((3, len(case.u)))
    applied_forces(case.model, t, case.q, case.u, np.zeros(2), case.external, *kinds)
    return kinds[0], kinds[1], kinds[2]


@pytest.mark.parametrize("grounded", [-1, 0, 1])
@pytest.mark.parametrize("line", LINES, ids=lambda line: line.kind)
def test_springs_are_the_gradients_of_their_energies(line: Line, grounded: int) -> None:
    """E = k c^2 / 2, -dE/dt the power of the force, and that of the damper -d cdot^2."""
    spring = Line(line.kind, line.axis, line.on_p, line.on_q, rest=0.0 if line.kind == "turn" else 0.2)
    case = moving(3, grounded=grounded, springs=[(spring, 7.0, 0.0)])
    stretch = spring_stretch(case.model, case.q, 0)
    assert math.isclose(spring_energy(case.model, case.q), 3.5 * stretch * stretch, rel_tol=1e-14)
    conservative, dissipative, driving = forces(case)
    assert not dissipative.any()
    assert not driving.any()
    for k in range(len(case.u)):
        alone = Moving(case.model, case.q, np.eye(len(case.u))[k])
        first, _ = derivatives(lambda t, alone=alone: spring_energy(alone.model, alone.at(t)), 1e-2)
        assert math.isclose(-conservative[k], first, rel_tol=1e-9, abs_tol=1e-9)


@pytest.mark.parametrize("line", LINES, ids=lambda line: line.kind)
def test_dampers_take_the_square_of_the_rate(line: Line) -> None:
    """Power -d cdot^2."""
    case = moving(4, springs=[(line, 0.0, 1.7)])
    rate, _ = derivatives(lambda t: spring_stretch(case.model, case.at(t), 0), 3e-3)
    conservative, dissipative, _ = forces(case)
    assert not conservative.any()
    assert math.isclose(dissipative @ case.u, -1.7 * float(rate) ** 2, rel_tol=1e-9)


@pytest.mark.parametrize("kind", [FORCE, FOLLOWER, TORQUE, TORQUE_FOLLOWER])
def test_forces_and_torques_do_the_work_of_what_they_push(kind: int) -> None:
    """Power is force.velocity of the point, or torque.angular velocity of the material."""
    case = moving(6, forces=[(kind, 0, SIZE)])

    def place(t: float) -> FloatArray:
        return np.array(point_place(case.model.bodies, case.model.points, case.at(t), 0))

    def axes(t: float) -> FloatArray:
        return np.reshape(point_axes(case.model.bodies, case.model.points, case.at(t), 0), (3, 3))

    velocity, _ = derivatives(place, 1e-2)
    rate, _ = derivatives(axes, 1e-2)
    turning = rate @ axes(0.0).T
    spin = np.array([turning[2, 1], turning[0, 2], turning[1, 0]])
    effort = axes(0.0) @ SIZE if kind in (FOLLOWER, TORQUE_FOLLOWER) else np.array(SIZE)
    _, _, driving = forces(case)
    pushed = velocity if kind in (FORCE, FOLLOWER) else spin
    assert math.isclose(driving @ case.u, effort @ pushed, rel_tol=1e-9)


def test_the_force_of_a_spring_that_is_wound_too_far_is_no_number() -> None:
    """A state does not tell whole turns: beyond WOUND there is no force that could be right."""
    for twist, fine in ((WOUND - 1e-6, True), (WOUND + 1e-6, False), (-WOUND - 1e-6, False)):
        for line in (
            Line("angle", (0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (1.0, 0.0, 0.0)),
            Line("turn", (0.0, 0.0, 1.0)),
        ):
            case = moving(1, (0, 0), springs=[(line, 1.0, 0.0)])
            case.q[:] = 0.0
            w, x, y, z = exponential(0.0, 0.0, twist)
            case.q[3:7] = w, x, y, z
            case.q[10] = 1.0
            stretch = spring_stretch(case.model, case.q, 0)
            assert math.isclose(stretch, twist, rel_tol=1e-12) if fine else math.isnan(stretch)
            assert np.isfinite(forces(case)[0]).all() == fine


@pytest.mark.parametrize("angle", [1e-9, 1e-4, 0.4999, 0.5001, 1.5, 3.0, 3.04, 3.05, math.pi - 1e-7])
def test_rotation_vectors_come_back(angle: float) -> None:
    """exp and log in turn, to rounding; at half a turn the axis is kept, too."""
    for axis in (*np.eye(3), -np.eye(3)[1], np.array([2.0, -1.0, 2.0]) / 3.0, np.array([-0.6, 0.0, -0.8])):
        back = vector_of_axes(rotation_matrix(*exponential(*(angle * axis))))
        np.testing.assert_allclose(back, angle * axis, rtol=0.0, atol=2e-15 + 2e-15 * angle)


def test_the_two_forms_of_the_cotangent_meet() -> None:
    """Series below, closed form above."""
    below, above = half_cotangent(0.25 - 1e-12), half_cotangent(0.25 + 1e-12)
    np.testing.assert_allclose(below, above, rtol=1e-11)
    a = 1.3
    assert math.isclose(half_cotangent(a * a)[0], (1.0 - 0.5 * a / math.tan(0.5 * a)) / a**2, rel_tol=1e-14)
