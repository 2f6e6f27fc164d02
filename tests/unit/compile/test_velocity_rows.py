"""L(q) of material points: against difference quotients of their places, and the rows of contacts and forces."""

from __future__ import annotations

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.errors import ModelError
from tests.spatial_scenes import thrown
from tests.unit.compile.by_hand import flexible_beam, sliding_block

STEP = 1e-6


def bent(scene: lf.Scene) -> lf.StateMechanics:
    """Some state with all coordinates away from 0."""
    compiled = scene.compile()
    turn = np.random.default_rng(3)
    q = compiled.q + 1e-3 * turn.standard_normal(len(compiled.q))
    return compiled.at(q, turn.standard_normal(len(compiled.u)))


def place(at: lf.StateMechanics, point: str, along: np.ndarray) -> np.ndarray:
    """Of a point of the strip, with q moved."""
    from lcpflex.kinematics.places import world_places

    known = at.compiled.layout.points["strip", point]
    return world_places(at.compiled.model, at.q + along, np.array([known]))[0]


@pytest.mark.parametrize("point", ["left", "right"])
def test_rows_are_the_derivative_of_the_place(point: str) -> None:
    at = bent(flexible_beam())
    rows = at.velocity_rows("strip", point)
    assert rows.shape == (2, len(at.u))
    for k, unit in enumerate(np.eye(len(at.u))):
        slope = (place(at, point, STEP * unit) - place(at, point, -STEP * unit)) / (2.0 * STEP)
        assert np.abs(rows[:, k] - slope).max() <= 1e-9 * max(np.abs(slope).max(), 1.0)


def test_two_points_that_touch_make_the_rows_of_the_contact() -> None:
    """A node of the strip lies on a support, which is the first body: W_N = -L^T n, and W_T = -L^T t."""
    at = flexible_beam().compile().at()
    model = at.compiled.model
    for k, where in enumerate(at.places):
        q = at.q[:2]
        place = where - q  # the strip lies along x: the point of it that touches, undeformed
        touching = model.points.place[model.points.body == 0]
        nearest = touching[np.abs(touching - place).sum(axis=1).argmin()]
        if np.abs(nearest - place).max() > 1e-9:
            continue
        rows = at.velocity_rows("strip", tuple(nearest))
        assert np.abs(-rows.T @ at.normals[k] - at.W_N[:, k]).max() <= 1e-9
        assert np.abs(-rows.T @ at.tangents[k, 0] - at.W_T[:, k]).max() <= 1e-9
        return
    pytest.fail("no node lies on a support")


def test_anywhere_on_a_rigid_body() -> None:
    scene = sliding_block(0.3)
    at = scene.compile().at()
    (name,) = at.compiled.layout.bodies
    s = np.array([0.3, -0.2])
    angle = at.q[2]
    across = np.array([-np.sin(angle) * s[0] - np.cos(angle) * s[1], np.cos(angle) * s[0] - np.sin(angle) * s[1]])
    assert np.allclose(at.velocity_rows(name, tuple(s)), np.column_stack([np.eye(2), across]), rtol=0.0, atol=1e-15)
    assert np.array_equal(at.velocity_rows(name), np.eye(3)[:2])


def test_in_space_the_velocity_is_that_of_the_result() -> None:
    result = lf.simulate(thrown("soft"), 1e-2, lf.MoreauJean(step=1e-3))
    at = result.compiled.at(result.q[-1], result.u[-1])
    rows = at.velocity_rows("soft", "1")
    assert rows.shape == (3, len(at.u))
    assert np.abs(rows @ at.u - result.velocity("soft", "1")[-1]).max() <= 1e-14


def test_what_is_no_point_is_refused() -> None:
    at = flexible_beam().compile().at()
    with pytest.raises(ModelError, match="body: no body 'stirp'"):
        at.velocity_rows("stirp", "left")
    with pytest.raises(ModelError, match="point: 'strip' has no point 'lift'"):
        at.velocity_rows("strip", "lift")
