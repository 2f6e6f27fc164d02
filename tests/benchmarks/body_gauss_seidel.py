"""A plain Gauss-Seidel iteration in the velocities of bodies: what a physics engine does, for comparisons.

A contact costs as much as its two bodies have coordinates; the local law of the plane is solved exactly. Nothing else:
no active sets, no start, no order.
"""

import numba
import numpy as np


@numba.njit(cache=True, error_model="numpy")
def sweep(first, place, value, own, free, mu, u, p, count):
    """``count`` sweeps over compressed rows [normals; tangents] of J; own (n, 3) = J_N.J_N, J_N.J_T, J_T.J_T."""
    n = len(mu)
    for _ in range(count):
        for k in range(n):
            t = n + k
            a, b, d = own[k, 0], own[k, 1], own[k, 2]
            vn, vt = free[k], free[t]
            for e in range(first[k], first[k + 1]):
                vn += value[e] * u[place[e]]
            for e in range(first[t], first[t + 1]):
                vt += value[e] * u[place[e]]
            vn -= a * p[k] + b * p[t]
            vt -= b * p[k] + d * p[t]
            pn, pt = 0.0, 0.0
            if vn < 0.0:
                det = a * d - b * b
                pn, pt = (b * vt - d * vn) / det, (b * vn - a * vt) / det
                if pn < 0.0 or abs(pt) > mu[k] * pn:
                    sign = 1.0 if pt > 0.0 else -1.0
                    pn = -vn / (a + sign * mu[k] * b)
                    pt = sign * mu[k] * pn
            dn, dt = pn - p[k], pt - p[t]
            if dn != 0.0:
                for e in range(first[k], first[k + 1]):
                    u[place[e]] += dn * value[e]
            if dt != 0.0:
                for e in range(first[t], first[t + 1]):
                    u[place[e]] += dt * value[e]
            p[k], p[t] = pn, pt


def iteration(J, free, mu):
    """A function that makes so many sweeps more and returns the impulses (2 n,)."""
    n = len(mu)
    J = J.tocsr()
    cross = np.asarray(J[:n].multiply(J[n:]).sum(axis=1)).ravel()
    squares = np.asarray(J.multiply(J).sum(axis=1)).ravel()
    own = np.column_stack([squares[:n], cross, squares[n:]])
    rows = (J.indptr.astype(np.int64), J.indices.astype(np.int64), J.data)
    u, p = np.zeros(J.shape[1]), np.zeros(2 * n)

    def go_on(count):
        sweep(*rows, own, free, mu, u, p, count)
        return p

    return go_on
