"""Coulomb's law of one contact in space, solved exactly: the friction force is in a disc.

With u = W r + q of one contact, W symmetric and positive semidefinite, r solves

    K_mu ∋ r  _|_  u + mu |u_T| n ∈ K_mu*        (de Saxce & Feng 1998)

where it is open (r = 0, q_N >= 0), sticks (u = 0, r in the cone) or slides: u_N = 0, u_T = -s r_T with a slip s > 0
[1/kg] and |r_T| = mu r_N. Without r_N = a + w.p, a = -q_N / W_NN, w = W_TN / W_NN, p = -r_T, sliding is

    (S + s I) p = b,   S = W_TT - W_TN W_NT / W_NN,   b = q_T - w q_N,   mu (a + w.p(s)) / |p(s)| = 1,

a quartic in s (Bonnefon & Daviet 2011). The left side is smooth for s > 0, below 1 at s = 0 unless the contact sticks,
and nearly linear in s far out, so that a safeguarded Newton iteration always ends.
"""

from __future__ import annotations

import math

import numpy as np

from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.solvers.contact.algebra import Vector
from lcpflex.solvers.contact.cones.certificate import natural_miss, nearest_in_cone
from lcpflex.solvers.contact.group import Group
from lcpflex.solvers.contact.laws import coulomb
from lcpflex.solvers.contact.laws.states import EDGE, OPEN, SLIDING, STICKING

__all__ = ["NONE", "solve_cone"]

INSIDE = 1e-12  # of the edge of its disc: a contact that is nearer slides already

NONE = -1.0  # slip of a contact that no forces keep apart
CLOSE = 1e-14  # of 1: the friction ratio at the slip found
LAST_DIGIT = 4e-16  # relative step of the slip that changes nothing
MOST = 100  # Newton steps and bisections; a bracket of floats is halved away in fewer
ROUND = 8e-16  # what S keeps of the terms that it is the difference of
ROUNDING = 1e-15  # by how much of it friction may be beyond the cone to stick


@kernel
def solve_cone(
    W_nn: float,
    W_n1: float,
    W_n2: float,
    W_11: float,
    W_12: float,
    W_22: float,
    q_n: float,
    q_1: float,
    q_2: float,
    mu: float,
    slip: float,
) -> tuple[float, float, float, float]:
    """Forces r (normal, two tangents) of one contact with u = W r + q, and its slip s = |u_T| / |r_T|.

    W symmetric and positive semidefinite, singular or zero in its tangents as well; slip: that of a similar problem, or
    0. Slip is 0 for an open and a sticking contact. Where several solutions exist it is an open contact, then a
    sticking one, then the slide that the iteration comes to; where none is found (W_NN <= 0, or wedged by a singular W,
    while approaching) r = 0 and the slip is -1 (``NONE``).
    """
    if q_n >= 0.0:
        return 0.0, 0.0, 0.0, 0.0
    if not W_nn > 0.0:
        return 0.0, 0.0, 0.0, NONE
    a = -q_n / W_nn
    if mu <= 0.0:
        return a, 0.0, 0.0, 0.0
    w_1, w_2 = W_n1 / W_nn, W_n2 / W_nn
    b_1, b_2 = q_1 - w_1 * q_n, q_2 - w_2 * q_n
    if b_1 == 0.0 and b_2 == 0.0:
        return a, 0.0, 0.0, 0.0
    # One Jacobi rotation makes S diagonal: (c, e) is its first axis.
    c, e, first, second = _axes(W_11 - w_1 * W_n1, W_12 - w_1 * W_n2, W_22 - w_2 * W_n2)
    floor = ROUND * max(abs(W_11), abs(W_22))
    h_1, h_2 = c * b_1 - e * b_2, e * b_1 + c * b_2
    v_1, v_2 = c * w_1 - e * w_2, e * w_1 + c * w_2
    first, h_1 = _settled(first, h_1, floor, abs(q_1) + abs(w_1 * q_n) + abs(q_2) + abs(w_2 * q_n))
    second, h_2 = _settled(second, h_2, floor, abs(q_1) + abs(w_1 * q_n) + abs(q_2) + abs(w_2 * q_n))
    p_1 = h_1 / first if h_1 != 0.0 else 0.0
    p_2 = h_2 / second if h_2 != 0.0 else 0.0
    size = math.sqrt(p_1 * p_1 + p_2 * p_2)
    press = a + v_1 * p_1 + v_2 * p_2
    if size < math.inf:
        if size * (1.0 - ROUNDING) <= mu * press:
            return press, -(c * p_1 + e * p_2), e * p_1 - c * p_2, 0.0
    elif _wedged(v_1, h_1, first, mu) or _wedged(v_2, h_2, second, mu):
        return 0.0, 0.0, 0.0, NONE
    s = _slip(a, v_1, v_2, h_1, h_2, first, second, mu, slip)
    p_1 = h_1 / (first + s) if h_1 != 0.0 else 0.0
    p_2 = h_2 / (second + s) if h_2 != 0.0 else 0.0
    press = a + v_1 * p_1 + v_2 * p_2
    if not (0.0 < press < math.inf):
        return 0.0, 0.0, 0.0, NONE
    return press, -(c * p_1 + e * p_2), e * p_1 - c * p_2, s


@kernel
def _axes(A: float, B: float, C: float) -> tuple[float, float, float, float]:
    """Cosine and sine of the rotation that makes [[A, B], [B, C]] diagonal, and what is on its diagonal then.

    (c, -s) and (s, c) are the eigenvectors of the two numbers.
    """
    if B == 0.0:
        return 1.0, 0.0, A, C
    turn = (C - A) / (2.0 * B)
    t = 1.0 / (abs(turn) + math.sqrt(1.0 + turn * turn))
    if turn < 0.0:
        t = -t
    c = 1.0 / math.sqrt(1.0 + t * t)
    return c, t * c, A - t * B, C + t * B


@kernel
def _settled(value: float, load: float, floor: float, size: float) -> tuple[float, float]:
    """An eigenvalue of S and the component of b along its axis, both 0 where they are rounding."""
    if value > floor:
        return value, load
    if abs(load) <= ROUND * size:
        return 0.0, 0.0
    return 0.0, load


@kernel
def _wedged(lever: float, load: float, value: float, mu: float) -> bool:
    """Whether forces along an axis of S that moves nothing (``value`` 0) grow into the cone and never stop the load."""
    return value == 0.0 and load != 0.0 and mu * (lever if load > 0.0 else -lever) >= 1.0


@kernel
def _slip(
    a: float, v_1: float, v_2: float, h_1: float, h_2: float, first: float, second: float, mu: float, slip: float
) -> float:
    """s > 0 with mu (a + v.p) = |p|, p_i = h_i / (S_i + s); one where several are.

    Between the slips at which the ratio would be 1 if v.p were as small, and as large, as it can be.
    """
    length, lever = math.sqrt(h_1 * h_1 + h_2 * h_2), math.sqrt(v_1 * v_1 + v_2 * v_2)
    low = max(length * (1.0 / mu - lever) / a - max(first, second), 0.0)
    high = length * (1.0 / mu + lever) / a - min(first, second)
    s = slip if low < slip < high else max(low, LAST_DIGIT * high)
    for _ in range(MOST):
        i_1, i_2 = 1.0 / (first + s), 1.0 / (second + s)
        p_1, p_2 = h_1 * i_1, h_2 * i_2
        size = math.sqrt(p_1 * p_1 + p_2 * p_2)
        press = a + v_1 * p_1 + v_2 * p_2
        miss = mu * press / size - 1.0
        if abs(miss) <= CLOSE:
            return s
        if miss < 0.0:
            low = s
        else:
            high = s
        shrink = (p_1 * p_1 * i_1 + p_2 * p_2 * i_2) / (size * size)
        slope = mu * (press * shrink - (v_1 * p_1 * i_1 + v_2 * p_2 * i_2)) / size
        new = s - miss / slope
        if not (low < new < high):
            new = 0.5 * (low + high)
        if abs(new - s) <= LAST_DIGIT * s:
            return new
        s = new
    return s


@coulomb.solve.of(3)
@kernel(inline=True)
def solve(group: Group, k: int, v: Vector, p: Vector) -> tuple[Vector, bool]:
    """Open, sticking or sliding, as :func:`solve_cone` tells; where nothing solves it alone, the others may help.

    A block that is not symmetric is taken by its symmetric part, the rest as known from the last force: what is left of
    it shrinks with the sweeps.
    """
    own = group.own
    nn, aa, bb = own[k, 0], own[k, 4], own[k, 8]
    n1, n2, ab = 0.5 * (own[k, 1] + own[k, 3]), 0.5 * (own[k, 2] + own[k, 6]), 0.5 * (own[k, 5] + own[k, 7])
    f, g, h, slip = solve_cone(
        nn, n1, n2, aa, ab, bb,
        v[0] - (nn * p[0] + n1 * p[1] + n2 * p[2]),
        v[1] - (n1 * p[0] + aa * p[1] + ab * p[2]),
        v[2] - (n2 * p[0] + ab * p[1] + bb * p[2]),
        group.mu[k], group.slip[k],
    )  # fmt: skip
    if slip == NONE:
        return p, False
    group.slip[k] = slip
    return (f, g, h), True


@coulomb.answer.of(3)
@kernel(inline=True)
def answer(group: Group, k: int, a: Vector, convex: bool) -> tuple[Vector, int]:
    """(a_N, the nearest friction force to a_T)."""
    n, t, s = a
    if convex:
        f, g, h = nearest_in_cone(n, t, s, group.mu[k])
        if f == 0.0:
            return (0.0, 0.0, 0.0), OPEN
        return (f, g, h), (STICKING if f == n and g == t and h == s else EDGE)
    if n <= 0.0:
        return (0.0, 0.0, 0.0), OPEN
    size, bound = math.sqrt(t * t + s * s), group.mu[k] * n
    if size <= bound:
        return a, STICKING
    return (n, bound * (t / size), bound * (s / size)), SLIDING


@coulomb.derivative.of(3)
@kernel(inline=True)
def derivative(group: Group, k: int, a: Vector, state: int, rho: float, C: FloatArray) -> None:
    """With t = a_T / |a_T|: along it what the edge does, across it the turning of the friction force."""
    for e in range(9):
        C[k, e] = 0.0
    if state == OPEN:
        return
    C[k, 0] = rho
    if state == STICKING:
        C[k, 4], C[k, 8] = rho, rho
        return
    size, m = math.sqrt(a[1] * a[1] + a[2] * a[2]), group.mu[k]
    if size == 0.0:  # on the axis, where only a cone without width has an edge
        return
    t, s = a[1] / size, a[2] / size
    along, across = 0.0, rho * m * a[0] / size
    if state == EDGE:
        part = 1.0 / (1.0 + m * m)
        C[k, 0] = rho * part
        along, across = rho * part * m * m, rho * part * m * (a[0] + m * size) / size
        C[k, 1], C[k, 2] = rho * part * m * t, rho * part * m * s
        C[k, 3], C[k, 6] = C[k, 1], C[k, 2]
    else:
        C[k, 3], C[k, 6] = rho * m * t, rho * m * s
    C[k, 4] = along * t * t + across * s * s
    C[k, 5] = (along - across) * t * s
    C[k, 7] = C[k, 5]
    C[k, 8] = along * s * s + across * t * t


@coulomb.room.of(3)
@kernel(inline=True)
def room(group: Group, k: int, q: Vector, d: Vector) -> float:
    """To the normal force 0, and to the edge of the cone from inside."""
    far, mu = np.inf, group.mu[k]
    if q[0] > 0.0:
        if d[0] < 0.0:
            far = -q[0] / d[0]
        if math.sqrt(q[1] ** 2 + q[2] ** 2) < mu * q[0] * (1.0 - INSIDE):
            far = min(far, _way_to_edge(q[0], q[1], q[2], d[0], d[1], d[2], mu))
    return far


@kernel
def _way_to_edge(f: float, g: float, h: float, d: float, d1: float, d2: float, mu: float) -> float:
    """The least t > 0 at which (f, g, h) + t (d, d1, d2), inside |q_T| <= mu q_N at t = 0, leaves that cone."""
    a = d1 * d1 + d2 * d2 - mu * mu * d * d
    b = g * d1 + h * d2 - mu * mu * f * d
    c = min(g * g + h * h - mu * mu * f * f, 0.0)
    root = b * b - a * c
    if root < 0.0:
        return np.inf
    root = math.sqrt(root)
    if b + root > 0.0:  # a t^2 + 2 b t + c = 0, without the difference of two large numbers
        return -c / (b + root)
    return (-b + root) / a if a > 0.0 else np.inf


@coulomb.miss.of(3)
@kernel(inline=True)
def miss(group: Group, k: int, p: Vector, v: Vector) -> float:
    """The largest component of p - P_K(p - (v + mu |v_T| n)): :mod:`lcpflex.solvers.contact.cones.certificate`."""
    return natural_miss(p[0], p[1], p[2], v[0], v[1], v[2], group.mu[k], group.unit[k])
