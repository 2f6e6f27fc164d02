"""Gauss-Seidel over units in the velocities of their bodies: x = J^T q is kept up to date."""

from __future__ import annotations

from lcpflex.jit.kernel import kernel
from lcpflex.solvers.contact.large.memory import FRICTIONAL, HINGE, NORMAL, LargeMemory
from lcpflex.solvers.contact.laws.interval import solve_contact

__all__ = ["sweep"]

SINGULAR = 1e-13  # relative determinant of a hinge whose rows move together


@kernel
def solve_hinge(a: float, b: float, d: float, v: float, w: float) -> tuple[float, float]:
    """Changes of two impulses that stop the velocities v and w; of dependent rows the first alone is served."""
    det = a * d - b * b
    if det > SINGULAR * a * d:
        return (b * w - d * v) / det, (b * v - a * w) / det
    if a > 0.0:
        return -v / a, 0.0
    return 0.0, (-w / d if d > 0.0 else 0.0)


@kernel
def sweep(memory: LargeMemory, count: int) -> float:
    """``count`` sweeps over q and x; the largest change of the velocity of a unit by itself in the last one."""
    pos, body, J, free, W = memory.pos, memory.body, memory.J, memory.free, memory.W
    q, x, mu, kind = memory.q, memory.x, memory.mu, memory.kind
    change = 0.0
    for _ in range(count):
        change = 0.0
        for k in range(memory.n_units):
            a, b, d = W[k, 0], W[k, 1], W[k, 2]
            p, t = q[k, 0], q[k, 1]
            v, w = free[k, 0], free[k, 1]
            for i in range(2):
                at = body[k, i]
                if at >= 0:
                    o, size = pos[at], pos[at + 1] - pos[at]
                    side, along = J[k, 0, i], J[k, 1, i]
                    for j in range(size):
                        v += side[j] * x[o + j]
                        w += along[j] * x[o + j]
            if kind[k] == FRICTIONAL:
                new, rub, _ = solve_contact(a, b, b, d, v - a * p - b * t, w - b * p - d * t, mu[k])
                more, rubbed = new - p, rub - t
            elif kind[k] == NORMAL:
                more, rubbed = (max(-p, -v / a) if a > 0.0 else 0.0), 0.0
            elif kind[k] == HINGE:
                more, rubbed = solve_hinge(a, b, d, v, w)
            else:
                more, rubbed = (-v / a if a > 0.0 else 0.0), 0.0
            if more != 0.0 or rubbed != 0.0:
                q[k, 0], q[k, 1] = p + more, t + rubbed
                change = max(change, max(abs(more), abs(rubbed)))
                for i in range(2):
                    at = body[k, i]
                    if at >= 0:
                        o, size = pos[at], pos[at + 1] - pos[at]
                        side, along = J[k, 0, i], J[k, 1, i]
                        for j in range(size):
                            x[o + j] += side[j] * more + along[j] * rubbed
    memory.sweeps += count
    return change
