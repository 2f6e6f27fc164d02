"""Relative coordinates in space: rows, rates and biases against differences, deforming bodies at both ends."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from lcpflex.jit.kernel import FloatArray
from lcpflex.kinematics.joint_rows import joint_residual, joint_rows
from lcpflex.kinematics.spatial.relative import off_rest
from lcpflex.model.coordinates import SPATIAL_KINDS as KINDS
from lcpflex.scene.functions_of_time import Harmonic
from tests.space import Line, Moving, derivatives, moving

AXIS = tuple(np.array([2.0, -1.0, 2.0]) / 3.0)
ACROSS = tuple(np.array([2.0, 2.0, -1.0]) / 3.0)
SKEW = tuple(np.array([0.6, 0.0, 0.8]))
MOTION = Harmonic(0.3, 4.0, 0.5)
LINES = [
    Line("component", axis=SKEW),
    Line("along", axis=AXIS),
    Line("angle", axis=AXIS, on_p=SKEW, on_q=ACROSS),
    Line("distance"),
    Line("perpendicular", axis=AXIS, on_p=SKEW),
    Line("turn", axis=SKEW, on_p=(0.2, -0.1, 0.4)),
]


def residual(case: Moving, t: float, q: FloatArray) -> FloatArray:
    phi = np.zeros(int(case.model.joints.row[-1]))
    joint_residual(case.model, t, q, case.external, phi)
    return phi


def passed(case: Moving, t: float, q: FloatArray) -> FloatArray:
    """phi(q, t) less that of now, angles over half a turn included."""
    now = residual(case, 0.0, case.q)
    kinds = case.model.joints.kind
    return np.array([off_rest(kind, c) for kind, c in zip(kinds, residual(case, t, q) - now, strict=True)])


def laid(case: Moving, t: float = 0.0) -> tuple[FloatArray, FloatArray, FloatArray]:
    """J (r, nu), rate and bias."""
    dof = case.model.bodies.dof
    r = int(case.model.joints.row[-1])
    rows = np.full((r, 2, int(np.diff(dof).max())), np.nan)
    row_body = np.zeros((r, 2), dtype=np.int64)
    wrench, rate, bias = np.zeros((r, 6)), np.zeros(r), np.zeros(r)
    joint_rows(case.model, t, case.q, case.u, case.external, rows, row_body, wrench, rate, bias)
    J = np.zeros((r, len(case.u)))
    for k in range(r):
        for end, b in enumerate(row_body[k]):
            if b >= 0:
                J[k, dof[b] : dof[b + 1]] += rows[k, end, : dof[b + 1] - dof[b]]
            else:
                assert not rows[k, end].any()
    return J, rate, bias


@pytest.mark.parametrize("modes", [(3, 2), (0, 2), (0, 0)])
@pytest.mark.parametrize("grounded", [-1, 0, 1])
def test_rows_and_biases_are_the_derivatives_of_the_residuals(modes: tuple[int, int], grounded: int) -> None:
    """phidot = J u + rate, phiddot = J a + bias along a path with velocity u and acceleration a, motions or none."""
    lines = [Line(**{**vars_of(line), "motion": motion}) for line in LINES for motion in (None, MOTION)]
    for seed in range(3):
        case = moving(seed, modes, grounded, lines=lines)
        J, rate, bias = laid(case)
        for a in (np.zeros(len(case.u)), np.random.default_rng(seed + 10).standard_normal(len(case.u))):
            first, second = derivatives(lambda t, a=a, case=case: passed(case, t, case.at(t, a)), 5e-3)
            np.testing.assert_allclose(J @ case.u + rate, first, rtol=1e-9, atol=1e-10)
            np.testing.assert_allclose(J @ a + bias, second, rtol=1e-7, atol=1e-7)


def test_single_velocities_move_coordinates_as_their_rows_say() -> None:
    """Each column of J, and that rigid bodies and those with modes without a shape give the same."""
    case = moving(5, lines=LINES)
    J, _, _ = laid(case)
    for k in range(len(case.u)):
        alone = Moving(case.model, case.q, np.eye(len(case.u))[k])
        first, _ = derivatives(lambda t, alone=alone: passed(alone, t, alone.at(t)), 1e-2)
        np.testing.assert_allclose(J[:, k], first, rtol=1e-9, atol=1e-10)


def vars_of(line: Line) -> dict[str, Any]:
    return {name: getattr(line, name) for name in Line.__dataclass_fields__}


@pytest.mark.parametrize("turns", [-2.0, -0.9, 0.3, 0.999, 1.001, 7.5])
def test_driven_angles_count_beyond_half_turns(turns: float) -> None:
    """What is left of an angle that differs from its motion by whole turns is 0, in (-pi, pi]."""
    kind = KINDS.index("angle")
    left = off_rest(kind, 2.0 * math.pi * turns)
    assert -math.pi < left <= math.pi
    assert math.isclose((left / (2.0 * math.pi) - turns) % 1.0, 0.0, abs_tol=1e-12) or math.isclose(
        (left / (2.0 * math.pi) - turns) % 1.0, 1.0, abs_tol=1e-12
    )
    assert off_rest(KINDS.index("along"), 2.0 * math.pi * turns) == 2.0 * math.pi * turns
    assert off_rest(kind, math.pi) == math.pi
    assert off_rest(kind, -math.pi) == math.pi
