"""Weights of the corners of a patch: shares of a load in its middle that change with the patch without a jump.

    w_k ~ A(k-1, k, k+1) / (A(c, k-1, k) A(c, k, k+1)),   sum w_k = TOTAL

with areas A of triangles and the centroid c: Wachspress coordinates of c. A corner that arises within a side weighs
nothing, and of two that meet each has its part: least squares of f_k/sqrt(w_k) share a load on the patch in the same
way before and after. Source: Wachspress, A Rational Finite Element Basis (1975).
"""

from __future__ import annotations

from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.kinematics.spatial.rotations import Vector, cross
from lcpflex.kinematics.spatial.vectors import added, apart_from, dot, row_vector, scaled

__all__ = ["lay_weights"]

TOTAL = 4.0  # as of a box on a plane, whose corners weigh 1


@kernel
def twice_area(n: Vector, a: Vector, b: Vector, c: Vector) -> float:
    """2 A(a, b, c), seen against n."""
    return dot(n, cross(apart_from(b, a), apart_from(c, a)))


@kernel
def lay_weights(at: FloatArray, m: int, n: Vector, least: float) -> None:
    """Into column 3 of the m corners ``at``, either way about n; 1 below the ``least`` area [m^2]."""
    total, middle = 0.0, (0.0, 0.0, 0.0)
    first = row_vector(at, 0)
    for k in range(1, m - 1):
        second, third = row_vector(at, k), row_vector(at, k + 1)
        area = twice_area(n, first, second, third)
        total += area
        middle = added(middle, scaled(area / 3.0, added(added(first, second), third)))
    if abs(total) <= least:
        for k in range(m):
            at[k, 3] = 1.0
        return
    middle = scaled(1.0 / total, middle)
    least_part = 1e-30  # of the square of the area: no division by 0 where a side goes through the middle
    every = 0.0
    for k in range(m):
        before, here, after = row_vector(at, (k + m - 1) % m), row_vector(at, k), row_vector(at, (k + 1) % m)
        beside = twice_area(n, middle, before, here) * twice_area(n, middle, here, after)
        at[k, 3] = max(twice_area(n, before, here, after) / total, 0.0) / max(beside / (total * total), least_part)
        every += at[k, 3]
    for k in range(m):
        at[k, 3] *= TOTAL / every
