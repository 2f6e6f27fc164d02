"""One spatial contact: the exact solution against the law itself, written out with a projection on the cone."""

import numpy as np
import pytest

from lcpflex.errors import ModelError
from lcpflex.jit.kernel import kernel
from lcpflex.solvers.contact.cones.several import contact_solutions
from lcpflex.solvers.contact.laws.disc import NONE, solve_cone

THREE = np.array([[1.0, -0.9, 0.0], [-0.9, 1.0, 0.0], [0.0, 0.0, 1.0]])  # opens, sticks or slides at mu = 2


@kernel
def _solve_all(data, out):
    for i in range(len(data)):
        x = data[i]
        out[i, 0], out[i, 1], out[i, 2], out[i, 3] = solve_cone(
            x[0], x[1], x[2], x[3], x[4], x[5], x[6], x[7], x[8], x[9], out[i, 3]
        )


def solve(W, q, mu, slip=0.0):
    """Forces (m, 3) and slips (m,) of contacts W (m, 3, 3), q (m, 3), mu (m,)."""
    data = np.column_stack([W[:, 0, 0], W[:, 0, 1], W[:, 0, 2], W[:, 1, 1], W[:, 1, 2], W[:, 2, 2], q, mu])
    out = np.zeros((len(q), 4))
    out[:, 3] = slip
    _solve_all(data, out)
    return out[:, :3], out[:, 3]


def miss(W, q, mu, r):
    """|x - P_K(x - y - mu |y_T| n)|, x = r sqrt(D), y = u / sqrt(D), D the largest of the diagonal: over its terms."""
    s = np.sqrt(np.einsum("kii->ki", W).max(axis=1))[:, None]
    u = np.einsum("kij,kj->ki", W, r) + q
    x, y = r * s, u / s
    y[:, 0] += mu * np.hypot(y[:, 1], y[:, 2])
    z = x - y
    slip = np.hypot(z[:, 1], z[:, 2])
    normal = np.where(mu * slip <= -z[:, 0], 0.0, (z[:, 0] + mu * slip) / (1.0 + mu * mu))
    shrink = mu * normal / np.maximum(slip, 1e-300)
    edge = np.column_stack([normal, z[:, 1] * shrink, z[:, 2] * shrink])
    near = np.where((slip <= mu * z[:, 0])[:, None], z, edge)
    terms = np.abs(q).max(axis=1) + np.einsum("kij,kj->ki", np.abs(W), np.abs(r)).max(axis=1)
    return np.abs(x - near).max(axis=1) * s[:, 0] / terms


def random_contacts(m, seed=0, rank=3):
    rng = np.random.default_rng(seed)
    A = rng.normal(size=(m, 3, rank))
    W = A @ A.transpose(0, 2, 1)
    q = rng.normal(size=(m, 3))
    q[:, 0] = -np.abs(q[:, 0])
    return W, q, 10.0 ** rng.uniform(np.log10(0.03), np.log10(5.0), size=m)


def test_twenty_thousand_random_contacts():
    W, q, mu = random_contacts(20_000)
    r, slip = solve(W, q, mu)
    assert miss(W, q, mu, r).max() <= 1e-13
    assert (slip >= 0.0).all()
    assert 0.1 < (slip > 0.0).mean() < 0.9  # many slide, many stick
    again, same = solve(W, q, mu, slip)
    assert miss(W, q, mu, again).max() <= 1e-13
    np.testing.assert_allclose(same, slip, rtol=1e-9)  # started from its own slip it stays there


def test_units_do_not_matter():
    W, q, mu = random_contacts(500, seed=1)
    r, slip = solve(W, q, mu)
    far, swift = solve(W * 2.0**30, q * 2.0**-20, mu)
    np.testing.assert_allclose(far, r * 2.0**-50, rtol=1e-12, atol=0.0)
    np.testing.assert_allclose(swift, slip * 2.0**30, rtol=1e-12, atol=0.0)


def test_slip_is_that_of_the_velocity():
    W, q, mu = random_contacts(500, seed=2)
    r, slip = solve(W, q, mu)
    u = np.einsum("kij,kj->ki", W, r) + q
    np.testing.assert_allclose(u[:, 1:], -slip[:, None] * r[:, 1:], atol=1e-10 * np.abs(u).max())


def test_open_contacts_and_those_without_friction():
    W, q, _ = random_contacts(50, seed=3)
    r, slip = solve(W, np.abs(q), np.full(50, 0.5))
    assert not r.any()
    assert not slip.any()
    r, _ = solve(W, q, np.zeros(50))
    np.testing.assert_array_equal(r[:, 1:], 0.0)
    np.testing.assert_allclose(r[:, 0], -q[:, 0] / W[:, 0, 0])


def test_tangents_that_nothing_moves():
    W = np.zeros((2, 3, 3))
    W[:, 0, 0] = 2.0
    q, mu = np.array([[-1.0, 3.0, -4.0], [-1.0, 0.0, 0.0]]), np.full(2, 0.5)
    r, slip = solve(W, q, mu)
    np.testing.assert_allclose(r[0], [0.5, -0.15, 0.2])  # against the slip that no force changes
    np.testing.assert_allclose(slip[0], 5.0 / 0.25)
    np.testing.assert_allclose(r[1], [0.5, 0.0, 0.0])


def test_singular_contacts_in_range_are_solved():
    """Of rank two and few digits: nothing is rounded, and q is what forces can take away, to the last digit.

    Tangents that the normal leaves next to no freedom of their own are left out: their axes are known to rounding over
    what is left.
    """
    rng = np.random.default_rng(4)
    A = rng.integers(-64, 65, (20_000, 3, 2)) / 32.0
    W = A @ A.transpose(0, 2, 1)
    q = (W @ (rng.integers(-64, 65, (20_000, 3, 1)) / 32.0))[:, :, 0]
    q *= -np.sign(q[:, :1])
    left = np.einsum("kii->k", W[:, 1:, 1:]) - (W[:, 1:, 0] ** 2).sum(axis=1) / np.maximum(W[:, 0, 0], 1e-9)
    fair = (left > 0.2 * np.abs(W).max(axis=(1, 2))) & (q[:, 0] < 0.0)
    assert fair.sum() > 10_000
    W, q, mu = W[fair], q[fair], 10.0 ** rng.uniform(np.log10(0.03), np.log10(5.0), fair.sum())
    r, slip = solve(W, q, mu)
    assert (slip >= 0.0).all()
    assert miss(W, q, mu, r).max() <= 1e-13


def test_contacts_that_no_force_keeps_apart():
    r, slip = solve(np.zeros((1, 3, 3)), np.array([[-1.0, 0.0, 0.0]]), np.array([0.5]))
    assert slip[0] == NONE
    assert not r.any()
    along = np.array([1.0, 0.5, 0.0])  # a force inside the cone that moves nothing
    across = np.array([-0.5, 1.0, 0.0])
    W = np.outer(across, across) + np.diag([0.0, 0.0, 1.0])
    q = -1.0 * along
    r, slip = solve(W[None], q[None], np.array([1.0]))
    assert slip[0] == NONE
    assert not r.any()
    assert len(contact_solutions(W, q, 1.0)) == 0


def test_all_solutions_hold_the_one_found_and_are_one_or_three():
    W, q, mu = random_contacts(300, seed=6)
    q[::2, 0] *= -1.0  # open ones may stick or slide as well
    r, _ = solve(W, q, mu)
    for k in range(300):
        found = contact_solutions(W[k], q[k], mu[k])
        assert len(found) in (1, 3)
        assert miss(*(np.repeat(x[None], len(found), 0) for x in (W[k], q[k], mu[k])), found).max() <= 1e-9
        assert np.abs(found - r[k]).max(axis=1).min() <= 1e-8 * max(np.abs(r[k]).max(), np.abs(q[k]).max())


def test_three_solutions_of_one_contact():
    """In the plane of the first tangent: it is open, sticks, or slides with r_1 = mu r_N."""
    q = np.array([0.1, -1.0, 0.0])
    found = contact_solutions(THREE, q, 2.0)
    stick = -np.linalg.solve(THREE, q)
    slide = 0.1 / (0.9 * 2.0 - 1.0)  # u_N = r_N - 0.9 r_1 + 0.1 with r_1 = 2 r_N
    assert len(found) == 3
    for expected in ([0.0, 0.0, 0.0], stick, [slide, 2.0 * slide, 0.0]):
        assert np.abs(found - expected).max(axis=1).min() <= 1e-9


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        ((np.eye(2), np.zeros(2), 0.5), "shape"),
        ((np.eye(3), np.array([np.nan, 0.0, 0.0]), 0.5), "free"),
        ((np.eye(3), np.zeros(3), -0.5), "friction"),
    ],
)
def test_what_is_no_contact_is_refused(arguments, word):
    with pytest.raises(ModelError, match=word):
        contact_solutions(*arguments)
