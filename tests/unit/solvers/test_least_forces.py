"""What is asked of a contact problem beside its forces: the least that move contacts alike, several motions."""

import numpy as np
import pytest
from scipy.optimize import minimize

from lcpflex.solvers.contact.index_sets import SLIDE_BACK
from lcpflex.solvers.contact.least_forces import least_forces
from lcpflex.solvers.contact.memory import contact_data, prepare
from lcpflex.solvers.contact.several_motions import several_motions, trials


def posed(J, free, friction):
    """The problem G = J J^T, rows [normals; tangents of contacts with friction], and memory for it."""
    n = len(friction)
    data = contact_data(n + 1)
    tangent = np.flatnonzero(friction)
    m = n + len(tangent)
    data.n_contacts, data.n_tangents = n, len(tangent)
    data.delassus[:m, :m], data.free[:m] = J @ J.T, free
    data.friction[:n], data.tangent[: len(tangent)] = friction, tangent
    return data, prepare(n + 1)


def standing(count, mu, unit=1.0, order=slice(None)):
    """A box of 1 kg that stops on ``count`` points of its lower side, and forces of the first and last alone."""
    x = np.linspace(-0.5, 0.5, count)[order]
    rows = np.vstack([np.column_stack([0 * x, 1 + 0 * x, x]), np.column_stack([1 + 0 * x, 0 * x, 0.25 + 0 * x])])
    J = rows * np.sqrt([1.0, 1.0, 9.6]) / np.sqrt(unit)
    forces = np.zeros(2 * count)
    forces[[np.argmin(x), np.argmax(x)]] = unit
    forces[count + np.argmin(x)], forces[count + np.argmax(x)] = 0.3 * mu * unit, -0.3 * mu * unit
    return J, -(J @ J.T) @ forces, np.full(count, mu), forces


@pytest.mark.parametrize("unit", [1e-6, 1.0, 1e6])
@pytest.mark.parametrize("count", [2, 3, 7])
def test_box_at_rest_shares_its_load_evenly_and_without_friction(count, unit):
    J, free, friction, forces = standing(count, 0.5, unit)
    data, memory = posed(J, free, friction)
    least_forces(data, memory, forces)
    np.testing.assert_allclose(forces[:count], 2.0 * unit / count, rtol=1e-9)
    np.testing.assert_allclose(forces[count:], 0.0, atol=1e-9 * unit)


@pytest.mark.parametrize("seed", range(4))
def test_least_of_all_in_the_cones(seed):
    """A load beside the middle, contacts in any order: as a constrained minimum of the norm, the motion as it was."""
    rng = np.random.default_rng(seed)
    J, _, friction, forces = standing(4, 0.4, order=rng.permutation(4))
    forces[:4] *= np.where(forces[:4] > 0.0, rng.uniform(0.2, 2.0, 4), 0.0)
    forces[4:] = np.clip(forces[4:], -0.4 * forces[:4], 0.4 * forces[:4])
    data, memory = posed(J, -(J @ J.T) @ forces, friction)
    before = J.T @ forces
    cones = ({"type": "ineq", "fun": lambda p: np.concatenate([0.4 * p[:4] - p[4:], 0.4 * p[:4] + p[4:]])},)
    same = ({"type": "eq", "fun": lambda p: J.T @ p - before},)
    expected = minimize(lambda p: p @ p, forces, jac=lambda p: 2 * p, constraints=cones + same, tol=1e-14).x
    least_forces(data, memory, forces)
    np.testing.assert_allclose(J.T @ forces, before, atol=1e-9)
    assert forces @ forces <= expected @ expected * (1.0 + 1e-6)
    np.testing.assert_allclose(forces, expected, atol=2e-5)


def test_forces_that_the_motion_determines_stay_as_they_are():
    rng = np.random.default_rng(0)
    J = rng.standard_normal((4, 6))
    forces = np.array([1.0, 2.0, 0.1, -0.2])
    data, memory = posed(J, -(J @ J.T) @ forces, np.array([0.5, 0.5]))
    given = forces.copy()
    least_forces(data, memory, forces)
    assert forces.tolist() == given.tolist()


@pytest.mark.parametrize("unit", [1e-6, 1.0, 1e6])
@pytest.mark.parametrize(("mu", "several"), [(0.2, False), (2.0, True)])
def test_rod_with_much_friction_may_move_in_two_ways(mu, several, unit):
    """Painleve's rod, slipping: with G_NN < mu |G_NT| and a free acceleration upwards it slides on, or jams."""
    data, memory = posed(np.eye(2), np.array([0.5, -1.0]) / unit, np.array([mu]))
    data.delassus[:2, :2] = np.array([[1.0, -0.9], [-0.9, 1.5]]) / unit
    data.on_sets, data.mode[0], memory.size = 1, SLIDE_BACK, 1  # its friction is in the normal column
    assert several_motions(data, memory, 1e-10, trials()) == several
    data.free[0] = -0.5 / unit
    assert not several_motions(data, memory, 1e-10, trials())
