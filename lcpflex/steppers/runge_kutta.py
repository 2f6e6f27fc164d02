"""The embedded Runge-Kutta pair 5(4) of Dormand and Prince with its dense output of order 4.

    y_i = y + h sum_j A[i, j] k_j,   k_i = f(t + C[i] h, y_i);   y+ = y_7,   error = h sum_i E[i] k_i
    y(t + s h) = y + h sum_i (P[i, 0] s + P[i, 1] s^2 + P[i, 2] s^3 + P[i, 3] s^4) k_i,   0 <= s <= 1

The seventh slope is that at the end of the step. Sources: Dormand & Prince 1980; Shampine 1986 (dense output).
"""

from __future__ import annotations

import math

import numpy as np

from lcpflex.jit.kernel import FloatArray, kernel

__all__ = ["C", "STAGES", "copy_state", "error_norm", "interpolate", "stage_state", "step_factor"]

STAGES = 7
C = np.array([0.0, 1 / 5, 3 / 10, 4 / 5, 8 / 9, 1.0, 1.0])
A = np.array(
    [
        [0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        [1 / 5, 0.0, 0.0, 0.0, 0.0, 0.0],
        [3 / 40, 9 / 40, 0.0, 0.0, 0.0, 0.0],
        [44 / 45, -56 / 15, 32 / 9, 0.0, 0.0, 0.0],
        [19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729, 0.0, 0.0],
        [9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656, 0.0],
        [35 / 384, 0.0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84],
    ]
)
E = np.array([-71 / 57600, 0.0, 71 / 16695, -71 / 1920, 17253 / 339200, -22 / 525, 1 / 40])
P = np.array(
    [
        [1.0, -8048581381 / 2820520608, 8663915743 / 2820520608, -12715105075 / 11282082432],
        [0.0, 0.0, 0.0, 0.0],
        [0.0, 131558114200 / 32700410799, -68118460800 / 10900136933, 87487479700 / 32700410799],
        [0.0, -1754552775 / 470086768, 14199869525 / 1410260304, -10690763975 / 1880347072],
        [0.0, 127303824393 / 49829197408, -318862633887 / 49829197408, 701980252875 / 199316789632],
        [0.0, -282668133 / 205662961, 2019193451 / 616988883, -1453857185 / 822651844],
        [0.0, 40617522 / 29380423, -110615467 / 29380423, 69997945 / 29380423],
    ]
)


@kernel
def copy_state(source: FloatArray, target: FloatArray) -> None:
    """target = source."""
    for i in range(len(source)):
        target[i] = source[i]


@kernel
def stage_state(y: FloatArray, slopes: FloatArray, h: float, stage: int, out: FloatArray) -> None:
    """out = y + h sum_j A[stage, j] slopes[j]; y (n,), slopes (7, n)."""
    for i in range(len(y)):
        total = 0.0
        for j in range(stage):
            total += A[stage, j] * slopes[j, i]
        out[i] = y[i] + h * total


@kernel
def interpolate(y: FloatArray, slopes: FloatArray, h: float, share: float, out: FloatArray) -> None:
    """out = state at the ``share`` (0 ... 1) of the step from y."""
    for i in range(len(y)):
        out[i] = 0.0
    for j in range(STAGES):
        weight = h * share * (P[j, 0] + share * (P[j, 1] + share * (P[j, 2] + share * P[j, 3])))
        if weight != 0.0:
            for i in range(len(y)):
                out[i] += weight * slopes[j, i]
    for i in range(len(y)):
        out[i] += y[i]


@kernel
def error_norm(
    y: FloatArray, end: FloatArray, slopes: FloatArray, h: float, n: int, rtol: float, atol: FloatArray
) -> float:
    """Root mean square of error / (atol + rtol |y|) over the first n components; NaN where not finite."""
    total = 0.0
    for i in range(n):
        error = 0.0
        for j in range(STAGES):
            error += E[j] * slopes[j, i]
        ratio = h * error / (atol[i] + rtol * max(abs(y[i]), abs(end[i])))
        total += ratio * ratio
    return math.sqrt(total / max(n, 1))


@kernel
def step_factor(error: float, before: float) -> float:
    """Factor on the length of the next step: proportional-integral control (Hairer, Norsett & Wanner)."""
    if not error < math.inf:
        return 0.1
    if error <= 1e-10:
        return 5.0
    return min(5.0, max(0.2, 0.9 * error**-0.14 * max(before, 1e-4) ** 0.08))
