"""Whether an LCP has a point, and a solution, in exact rational arithmetic; owes nothing to the solvers' own proofs.

Inequalities a.z + b >= 0 are decided by eliminating one unknown after the other (Fourier & Motzkin).
"""

import itertools
from fractions import Fraction


def has_point(rows):
    """Whether some z fulfils a.z + b >= 0 for all rows (a_1, ..., a_n, b) of fractions."""
    rows = set(rows)
    while rows and len(next(iter(rows))) > 1:
        above = [r for r in rows if r[0] > 0]
        below = [r for r in rows if r[0] < 0]
        rows = {_scaled(r[1:]) for r in rows if r[0] == 0}
        rows |= {
            _scaled(tuple(x * -b[0] + y * a[0] for x, y in zip(a[1:], b[1:], strict=True)))
            for a, b in itertools.product(above, below)
        }
    return all(r[0] >= 0 for r in rows)


def _scaled(row):
    """Proportional rows are one."""
    size = next((abs(x) for x in row if x), 1)
    return tuple(x / size for x in row)


def _parts(M, q):
    n = len(q)
    w = [tuple(Fraction(float(x)) for x in (*M[i], q[i])) for i in range(n)]
    z = [tuple(Fraction(int(i == j)) for j in range(n + 1)) for i in range(n)]
    return w, z


def is_feasible(M, q):
    """Whether some z >= 0 has M z + q >= 0."""
    w, z = _parts(M, q)
    return has_point([*w, *z])


def is_solvable(M, q):
    """Whether one of all active sets gives a solution."""
    w, z = _parts(M, q)
    for basic in itertools.product((False, True), repeat=len(q)):
        zero = [w[i] if on else z[i] for i, on in enumerate(basic)]
        if has_point([*w, *z, *(tuple(-x for x in row) for row in zero)]):
            return True
    return False


def proves_infeasible(M, q, u):
    """Whether integers u >= 0 have M^T u <= 0 and q.u < 0 on the floats as they are."""
    columns = range(len(q))
    return (
        len(u) == len(q)
        and all(isinstance(value, int) and value >= 0 for value in u)
        and all(sum(u[i] * Fraction(float(M[i][j])) for i in columns) <= 0 for j in columns)
        and sum(u[i] * Fraction(float(q[i])) for i in columns) < 0
    )


def left_of_load(M, q, z, units=None):
    """max_i |min(m_i z_i, w_i)| / max_i |q_i| in fractions, m_i the largest |M_ij|, 1 in a row of zeros; as a float.

    units: d (n,), of the problem d M d, d q and its point z / d, without rounding.
    """
    d = [Fraction(1)] * len(q) if units is None else [Fraction(float(x)) for x in units]
    point = [Fraction(float(x)) / unit for x, unit in zip(z, d, strict=True)]
    loads = [Fraction(float(x)) * unit for x, unit in zip(q, d, strict=True)]
    worst = Fraction(0)
    for row, load, own, unit in zip(M, loads, point, d, strict=True):
        entries = [Fraction(float(x)) * unit * other for x, other in zip(row, d, strict=True)]
        w = sum((a * x for a, x in zip(entries, point, strict=True)), load)
        worst = max(worst, abs(min((max(map(abs, entries)) or 1) * own, w)))
    return float(worst / max(map(abs, loads)))
