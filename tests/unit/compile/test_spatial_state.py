"""The mechanics of a spatial scene at one state, against sums over the masses of its bodies."""

from __future__ import annotations

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.errors import ModelError
from tests.spatial_scenes import soft_body, thrown

GRAVITY = np.array([0.0, 0.0, -9.81])


def test_a_state_fulfils_newtons_law_of_a_rigid_body() -> None:
    compiled = thrown("box").compile()
    state = compiled.at()
    J = 2.0 / 12.0 * np.array([0.2**2 + 0.1**2, 0.3**2 + 0.1**2, 0.3**2 + 0.2**2])
    omega = compiled.u[3:6]
    np.testing.assert_allclose(state.M, np.diag([2.0, 2.0, 2.0, *J]), rtol=0.0, atol=1e-16)
    np.testing.assert_allclose(state.h, [*(2.0 * GRAVITY), *-np.cross(omega, J * omega)], rtol=0.0, atol=1e-15)
    assert state.velocities == ("box.v_x", "box.v_y", "box.v_z", "box.omega_x", "box.omega_y", "box.omega_z")
    assert len(state.coordinates) == len(state.q) == 7


def test_a_state_fulfils_newtons_law_of_a_soft_body() -> None:
    """No other force acts on the whole body than weight, where udot solves M udot = h."""
    body, compiled = soft_body(), thrown("soft").compile()
    state = compiled.at()
    udot = np.linalg.solve(state.M, state.h)

    def places(s: float) -> np.ndarray:
        """Of the masses after the time s, by a start with u and udot: (masses, 3)."""
        from scipy.spatial.transform import Rotation

        q, u = compiled.q, compiled.u + 0.5 * s * udot
        turn = Rotation.from_quat(q[[4, 5, 6, 3]]) * Rotation.from_rotvec(s * u[3:6])
        eta = q[7:] + s * u[6:]
        return q[:3] + s * u[:3] + turn.apply(body.places + np.einsum("k,kni->ni", eta, body.shapes))

    h = 1e-4
    acceleration = (places(h) - 2.0 * places(0.0) + places(-h)) / h**2
    masses = body.mass.sum(axis=0)[:, None]
    np.testing.assert_allclose((masses * (acceleration - GRAVITY)).sum(axis=0), 0.0, atol=1e-6)
    assert np.abs(masses * acceleration).max() > 0.1
    np.testing.assert_array_equal(state.stiffness[6:, 6:], np.diag(100.0 * np.asarray(body.stiffness)))
    assert not state.stiffness[:6].any()


def test_states_that_are_none_are_refused() -> None:
    compiled = thrown("box").compile()
    with pytest.raises(ModelError, match="q: the quaternion of body 'box' has the length 2, expected 1"):
        compiled.at([0, 0, 0, 2, 0, 0, 0])
    with pytest.raises(ModelError, match=r"u: an array of shape \(7,\) was given, expected shape \(6\)"):
        compiled.at(u=np.zeros(7))


def test_a_study_of_work_and_precision_sees_a_spatial_motion() -> None:
    study = lf.studies.work_precision(
        lambda: thrown("box"), {"MJ": [lf.MoreauJean(1e-2), lf.MoreauJean(5e-3)]}, duration=0.2,
        reference=lf.MoreauJean(2e-4), outputs=["trajectory"], repeats=1,
    )  # fmt: skip
    coarse, fine = (point.errors["trajectory"] for point in study.points)
    assert 3.6 < coarse / fine < 4.4  # of order 2
