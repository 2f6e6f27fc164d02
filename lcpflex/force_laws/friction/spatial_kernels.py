"""Friction of continuous contact in space: a force in the tangent plane, of a slip velocity with two components.

Laws are isotropic. Without states the force opposes the slip, and has the size that the law of the plane gives a slip
of that speed. Bristles are vectors z in the tangent plane; with v the slip velocity, v = |v|,

    LuGre:    zdot = v - sigma_0 |v| z / g(|v|)
              lambda_T = -lambda_N (sigma_0 z + sigma_1 zdot + sigma_2 v)
    bristle:  zdot = s v + (1 - s) (mu dir(v) - sigma_0 z) / sigma_1,   |sigma_0 z + sigma_1 zdot| <= f

which for a slip along a fixed line are those of the plane. Sources: Velenis, Tsiotras & Canudas de Wit 2002 (LuGre);
Gonthier, McPhee, Lange & Piedboeuf 2004.
"""

from __future__ import annotations

import math

from lcpflex.force_laws.friction.kernels import BRISTLE, LUGRE, friction_force, sticking
from lcpflex.force_laws.layout import FRICTION, FRICTION_KIND
from lcpflex.jit.kernel import FloatArray, IntArray, kernel

__all__ = ["Pair", "bristle_slopes", "friction_pull"]

Pair = tuple[float, float]  # components of a vector in the tangent plane


@kernel
def lugre_slope(p: FloatArray, slip: Pair, mu: float, bristle: Pair) -> Pair:
    """dz/dt of the LuGre law [m/s]."""
    speed = math.hypot(slip[0], slip[1])
    drop = math.exp(-((speed / p[FRICTION + 3]) ** 2))
    sliding = mu + (max(p[FRICTION + 4], mu) - mu) * drop
    back = p[FRICTION] * speed / sliding
    return slip[0] - back * bristle[0], slip[1] - back * bristle[1]


@kernel
def bristle_slope(p: FloatArray, slip: Pair, mu: float, bristle: Pair) -> Pair:
    """dz/dt of the bristle law [m/s]."""
    speed = math.hypot(slip[0], slip[1])
    s = sticking(p, speed)
    x = speed / p[FRICTION + 6]
    share = mu / speed if x >= 1.0 else mu * (1.5 - 0.5 * x * x) / p[FRICTION + 6]
    pull = (1.0 - s) / p[FRICTION + 1]
    return (
        s * slip[0] + pull * (share * slip[0] - p[FRICTION] * bristle[0]),
        s * slip[1] + pull * (share * slip[1] - p[FRICTION] * bristle[1]),
    )


@kernel
def friction_pull(
    kinds: IntArray, p: FloatArray, slip: Pair, normal: float, mu: float, bristle: Pair, dwell: float
) -> Pair:
    """Tangential force [N] on the side of the node at a slip velocity [m/s] under a normal force >= 0 [N]."""
    kind = kinds[FRICTION_KIND]
    if kind == LUGRE:
        rate = lugre_slope(p, slip, mu, bristle)
        return (
            -normal * (p[FRICTION] * bristle[0] + p[FRICTION + 1] * rate[0] + p[FRICTION + 2] * slip[0]),
            -normal * (p[FRICTION] * bristle[1] + p[FRICTION + 1] * rate[1] + p[FRICTION + 2] * slip[1]),
        )
    if kind == BRISTLE:
        rate = bristle_slope(p, slip, mu, bristle)
        first = p[FRICTION] * bristle[0] + p[FRICTION + 1] * rate[0]
        second = p[FRICTION] * bristle[1] + p[FRICTION + 1] * rate[1]
        most = mu + (max(p[FRICTION + 4], mu) - mu) * dwell
        size = math.hypot(first, second)
        share = most / size if size > most else 1.0
        return (
            -normal * (share * first + p[FRICTION + 2] * slip[0]),
            -normal * (share * second + p[FRICTION + 2] * slip[1]),
        )
    speed = math.hypot(slip[0], slip[1])
    if speed == 0.0:
        return 0.0, 0.0
    force = friction_force(kinds, p, speed, normal, mu, 0.0, 0.0)
    return force * (slip[0] / speed), force * (slip[1] / speed)


@kernel
def bristle_slopes(
    kinds: IntArray, p: FloatArray, slip: Pair, mu: float, bristle: Pair, dwell: float
) -> tuple[float, float, float]:
    """Rates of the states of a friction law, of the bristle [m/s] and of the dwell [1/s]; zero for laws without."""
    kind = kinds[FRICTION_KIND]
    if kind == LUGRE:
        rate = lugre_slope(p, slip, mu, bristle)
        return rate[0], rate[1], 0.0
    if kind == BRISTLE:
        change = sticking(p, math.hypot(slip[0], slip[1])) - dwell
        lag = p[FRICTION + 5] if change >= 0.0 else p[FRICTION + 1] / p[FRICTION]
        rate = bristle_slope(p, slip, mu, bristle)
        return rate[0], rate[1], change / lag
    return 0.0, 0.0, 0.0
