"""One spatial contact that answers in several ways: a compiled test whether it may, and all its solutions.

With friction the forces of a single contact need not be unique.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from lcpflex.errors import ModelError, in_range
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.solvers.arrays import finite_array

__all__ = ["contact_solutions", "several_forces"]

SMALL = 1e-9  # residual of a root of the quartic that is a solution
APART = 1e-6  # relative distance of two solutions
REAL = 1e-3  # imaginary part of a root, relative to its size, that Newton steps may take away
STEPS = 8  # of Newton, for each root
GRID = 96  # slips at which the friction ratio is looked at
FROM = 1e-6  # of the largest slip
CLEAR = 1e-9  # of the largest velocity: a slower normal one is rounding


def contact_solutions(delassus: npt.ArrayLike, free: npt.ArrayLike, friction: float) -> FloatArray:
    """All forces (k, 3) of one contact that solve u = W r + q, K_mu ∋ r _|_ u + mu |u_T| n ∈ K_mu*.

    The open contact where q_N >= 0, the sticking one r = -W^-1 q where it is in the cone, and of sliding ones,
    u_N = 0, u_T = -s r_T, those of the positive roots s of the quartic |r_T(s)|^2 = (mu r_N(s))^2. There is mostly
    one, sometimes three. Of a singular W, whose solutions may form a family, one that sticks is told.

    Parameters
    ----------
    delassus : array (3, 3)
        W [1/kg], rows normal, two tangents; need not be symmetric.
    free : array (3,)
        q [m/s].
    friction : float
        mu >= 0 [-].

    Returns
    -------
    array (k, 3)
        Forces [N s] of growing slip, none where there is no solution.

    Raises
    ------
    ModelError
        For arrays of another shape, numbers that are not finite, and a negative friction.

    Notes
    -----
    Source: Bonnefon & Daviet 2011, Quartic formulation of Coulomb 3D frictional contact.
    """
    W, q = finite_array("delassus", delassus, 2), finite_array("free", free, 1)
    if W.shape != (3, 3) or q.shape != (3,):
        raise ModelError(
            f"delassus has shape {W.shape}, free {q.shape}: expected (3, 3) and (3,), those of one contact"
        )
    mu = in_range("friction", friction, 0.0, np.inf)
    load, size = float(np.abs(q).max()), float(np.abs(W).max())
    if load == 0.0 or size == 0.0:
        return np.zeros((1, 3)) if q[0] >= 0.0 else np.zeros((0, 3))
    W, q = W / size, q / load
    found: list[FloatArray] = []
    with np.errstate(all="ignore"):
        for r in [np.zeros(3), *_sticking(W, q), *_sliding(W, q, mu)]:
            new = all(np.abs(r - other).max() > APART * max(np.abs(r).max(), np.abs(other).max()) for other in found)
            if new and _miss(W, q, mu, r) <= SMALL:
                found.append(r)
    return np.array(found).reshape(-1, 3) * (load / size)


def _sticking(W: FloatArray, q: FloatArray) -> list[FloatArray]:
    """The shortest forces that stop the contact, if any do."""
    return [np.asarray(-np.linalg.lstsq(W, q, rcond=1e-13)[0], dtype=float)]


def _sliding(W: FloatArray, q: FloatArray, mu: float) -> list[FloatArray]:
    """Forces for the positive roots of the quartic, in rising order."""
    if W[0, 0] <= 0.0:
        return []
    a, w = -q[0] / W[0, 0], W[0, 1:] / W[0, 0]
    if mu == 0.0:
        return [np.array([a, 0.0, 0.0])]
    S = W[1:, 1:] - np.outer(W[1:, 0], w)
    b = q[1:] - W[1:, 0] * q[0] / W[0, 0]
    adjugate = np.array([[S[1, 1], -S[0, 1]], [-S[1, 0], S[0, 0]]])
    start = adjugate @ b  # p(s) = (start + s b) / (s^2 + tr S s + det S), r_T = -p
    determinant = np.array([1.0, np.trace(S), S[0, 0] * S[1, 1] - S[0, 1] * S[1, 0]])
    press = a * determinant + np.array([0.0, w @ b, w @ start])
    rub = np.array([b @ b, 2.0 * start @ b, start @ start])
    roots = np.roots(np.polysub(mu * mu * np.polymul(press, press), rub))
    real = sorted(root.real for root in roots if root.real > 0.0 and abs(root.imag) <= REAL * abs(root))
    return [r for r in (_forces(S, w, b, a, _polished(S, w, b, a, mu, s)) for s in real) if r[0] > 0.0]


def _forces(S: FloatArray, w: FloatArray, b: FloatArray, a: float, s: float) -> FloatArray:
    p = _solved(S, b, s)
    return np.array([a + w @ p, *-p])


def _solved(S: FloatArray, b: FloatArray, s: float) -> FloatArray:
    """(S + s I)^-1 b."""
    A = S + s * np.eye(2)
    determinant = A[0, 0] * A[1, 1] - A[0, 1] * A[1, 0]
    upper, lower = A[1, 1] * b[0] - A[0, 1] * b[1], A[0, 0] * b[1] - A[1, 0] * b[0]
    return np.array([upper / determinant, lower / determinant])


def _polished(S: FloatArray, w: FloatArray, b: FloatArray, a: float, mu: float, s: float) -> float:
    """The root of mu r_N / |r_T| - 1 near s, by Newton steps while they become smaller."""
    last = np.inf
    for _ in range(STEPS):
        p = _solved(S, b, s)
        turn = -_solved(S, p, s)
        size = np.sqrt(p @ p)
        press = a + w @ p
        slope = mu * (w @ turn / size - press * (p @ turn) / size**3)
        step = (mu * press / size - 1.0) / slope
        if not abs(step) < last or not s - step > 0.0:
            break
        s, last = s - step, abs(step)
    return float(s)


def _miss(W: FloatArray, q: FloatArray, mu: float, r: FloatArray) -> float:
    """The largest violation of the law, written out for the three states, relative to its terms."""
    u = W @ r + q
    slip, rub = np.hypot(u[1], u[2]), np.hypot(r[1], r[2])
    size = np.abs(q).max() + (np.abs(W) @ np.abs(r)).max()
    force = max(np.abs(r).max(), 1e-300)
    if r[0] <= 0.0:
        return float(max(-u[0], 0.0) / size if not r.any() else np.inf)
    wrong = abs(u[0]) / size, (rub - mu * r[0]) / force
    if rub < (1.0 - SMALL) * mu * r[0]:
        return float(max(*wrong, slip / size))
    against = u[1:] * rub + slip * r[1:]  # slip is against friction
    return float(max(*wrong, np.abs(against).max() / (size * force)))


@kernel
def several_forces(W: FloatArray, q: FloatArray, at: int, mu: float) -> bool:
    """Whether u = W r + q of one contact has several solutions: open, sticking and sliding.

    W, q: its leading unknowns, the normal one first; at: the first of two tangential ones, or -1, where friction is a
    part of the column of the normal. W is symmetric where there are three.
    """
    if at < 0:
        return bool(W[0, 0] < 0.0 < q[0])
    a, b = at, at + 1
    size = max(abs(q[0]), max(abs(q[a]), abs(q[b])))
    if not W[0, 0] > 0.0 or mu <= 0.0 or abs(q[0]) <= CLEAR * size:
        return False
    w_1, w_2 = W[a, 0] / W[0, 0], W[b, 0] / W[0, 0]
    press = -q[0] / W[0, 0]
    h_1, h_2 = q[a] - w_1 * q[0], q[b] - w_2 * q[0]
    S_11, S_12, S_22 = W[a, a] - w_1 * W[0, a], W[a, b] - w_1 * W[0, b], W[b, b] - w_2 * W[0, b]
    high = math.hypot(h_1, h_2) * (1.0 / mu + math.hypot(w_1, w_2)) / abs(press)
    changes = 0
    inside = False
    for i in range(-1, GRID):
        s = 0.0 if i < 0 else high * FROM ** (1.0 - i / (GRID - 1.0))
        determinant = (S_11 + s) * (S_22 + s) - S_12 * S_12
        if not determinant > 0.0:
            continue
        p_1 = ((S_22 + s) * h_1 - S_12 * h_2) / determinant
        p_2 = ((S_11 + s) * h_2 - S_12 * h_1) / determinant
        now = mu * (press + w_1 * p_1 + w_2 * p_2) >= math.hypot(p_1, p_2)
        if i >= 0 and now != inside:
            changes += 1
        inside = now
    return changes >= (1 if q[0] > 0.0 else 2)
