"""Whether one spatial contact may answer in several ways: a compiled test beside :mod:`.several`, which finds them."""

from __future__ import annotations

import math

from lcpflex.jit.kernel import FloatArray, kernel

__all__ = ["several_forces"]

GRID = 96  # slips at which the friction ratio is looked at
FROM = 1e-6  # of the largest slip
CLEAR = 1e-9  # of the largest velocity: a slower normal one is rounding


@kernel
def several_forces(W: FloatArray, q: FloatArray, at: int, mu: float) -> bool:
    """Whether u = W r + q of one contact has several solutions: open, sticking and sliding, see :mod:`.local`.

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
