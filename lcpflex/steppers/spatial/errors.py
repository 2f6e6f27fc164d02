"""Errors of Runge-Kutta steps in the numbers of spatial configurations, as velocities."""

from __future__ import annotations

from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.model.spatial import N_PLACE, N_RIGID, SpatialModel
from lcpflex.steppers.runge_kutta import EXTRAPOLATED, STAGES, E

__all__ = ["add_errors"]


@kernel
def error_of(slopes: FloatArray, i: int) -> float:
    """Error of component i over the length of the step."""
    error = 0.0
    for j in range(STAGES):
        error += E[j] * slopes[j, i]
    return error


@kernel
def add_errors(model: SpatialModel, y: FloatArray, slopes: FloatArray, h: float, sums: FloatArray) -> None:
    """sums (2, nu) += magnitudes of the errors of a step of length h from y, of q as of velocities, and of u.

    An error e of a quaternion p is a rotation by 2 Im(conj(p) o e), body axes. As in the plane the estimate is that of
    the result of order 4.
    """
    place, dof = model.bodies.place, model.bodies.dof
    n = len(dof) - 1
    size = EXTRAPOLATED * h
    for b in range(n):
        q, d = place[b], dof[b]
        p0, p1, p2, p3 = y[q + 3], y[q + 4], y[q + 5], y[q + 6]
        e0, e1 = error_of(slopes, q + 3), error_of(slopes, q + 4)
        e2, e3 = error_of(slopes, q + 5), error_of(slopes, q + 6)
        sums[0, d + 3] += 2.0 * size * abs(p0 * e1 - p1 * e0 - p2 * e3 + p3 * e2)
        sums[0, d + 4] += 2.0 * size * abs(p0 * e2 - p2 * e0 - p3 * e1 + p1 * e3)
        sums[0, d + 5] += 2.0 * size * abs(p0 * e3 - p3 * e0 - p1 * e2 + p2 * e1)
        for i in range(3):
            sums[0, d + i] += size * abs(error_of(slopes, q + i))
        for k in range(dof[b + 1] - d - N_RIGID):
            sums[0, d + N_RIGID + k] += size * abs(error_of(slopes, q + N_PLACE + k))
    for i in range(dof[n]):
        sums[1, i] += size * abs(error_of(slopes, place[n] + i))
