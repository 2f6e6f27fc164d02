"""Gauss-Seidel over units in the velocities of their bodies: x = J^T q is kept up to date."""

from __future__ import annotations

from lcpflex.jit.kernel import kernel
from lcpflex.solvers.contact.cones.large.memory import FRICTIONAL, SpatialLargeMemory
from lcpflex.solvers.contact.laws.disc import NONE, solve_cone

__all__ = ["sweep"]


@kernel
def stop(a: float, v: float) -> float:
    """Change of the force of a joint row by itself that stops its velocity v."""
    return -v / a if a > 0.0 else 0.0


@kernel
def sweep(memory: SpatialLargeMemory, count: int) -> None:
    """``count`` sweeps over q and x, each unit solved exactly with the forces of the others as they are."""
    pos, body, J, free, W = memory.pos, memory.body, memory.J, memory.free, memory.W
    q, x, mu, kind, slip = memory.q, memory.x, memory.mu, memory.kind, memory.slip
    for _ in range(count):
        for k in range(memory.n_units):
            n, t, s = free[k, 0], free[k, 1], free[k, 2]
            for i in range(2):
                b = body[k, i]
                if b >= 0:
                    o = pos[b]
                    for j in range(pos[b + 1] - o):
                        v = x[o + j]
                        n += J[k, i, 0, j] * v
                        t += J[k, i, 1, j] * v
                        s += J[k, i, 2, j] * v
            f, g, h = q[k, 0], q[k, 1], q[k, 2]
            nn, n1, n2, aa, ab, bb = W[k, 0], W[k, 1], W[k, 2], W[k, 3], W[k, 4], W[k, 5]
            if kind[k] <= FRICTIONAL:
                n -= nn * f + n1 * g + n2 * h
                t -= n1 * f + aa * g + ab * h
                s -= n2 * f + ab * g + bb * h
                new, along, across, state = solve_cone(nn, n1, n2, aa, ab, bb, n, t, s, mu[k], slip[k])
                if state == NONE:  # by itself: the others may help
                    continue
                slip[k] = state
                d, d1, d2 = new - f, along - g, across - h
                q[k, 0], q[k, 1], q[k, 2] = new, along, across
            else:
                d = stop(nn, n)
                d1 = stop(aa, t + n1 * d)
                d2 = stop(bb, s + n2 * d + ab * d1)
                q[k, 0], q[k, 1], q[k, 2] = f + d, g + d1, h + d2
            if d != 0.0 or d1 != 0.0 or d2 != 0.0:
                for i in range(2):
                    b = body[k, i]
                    if b >= 0:
                        o = pos[b]
                        for j in range(pos[b + 1] - o):
                            x[o + j] += J[k, i, 0, j] * d + J[k, i, 1, j] * d1 + J[k, i, 2, j] * d2
    memory.sweeps += count
