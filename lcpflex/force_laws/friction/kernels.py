"""Friction of continuous contact: the tangential force of a slip velocity, a normal force and states of its own.

All constants are per unit of normal force, so that friction begins and ends with the contact. Parameters of a law in
``p`` from FRICTION on are in the order of ``parameters`` of its class in :mod:`lcpflex.force_laws.friction.laws`.
"""

from __future__ import annotations

import math

from lcpflex.force_laws.layout import FRICTION, FRICTION_KIND
from lcpflex.jit.kernel import FloatArray, IntArray, kernel

__all__ = ["BENGISU_AKAY", "BROWN_MCPHEE", "KINDS", "bristle_rates", "friction_force", "friction_forces"]

KINDS = ("tanh", "arctangent", "ramp", "threlfall", "ambrosio", "bengisu_akay", "brown_mcphee", "lugre", "bristle")
TANH, ARCTANGENT, RAMP, THRELFALL, AMBROSIO, BENGISU_AKAY, BROWN_MCPHEE, LUGRE, BRISTLE = range(len(KINDS))


@kernel
def coefficient(kind: int, p: FloatArray, speed: float, mu: float) -> float:
    """Friction force per unit of normal force at a slip speed >= 0 [m/s], of laws without states but tanh."""
    first = p[FRICTION]
    if kind == ARCTANGENT:
        return 2.0 / math.pi * mu * math.atan(speed / first)
    if kind == RAMP:
        return mu * min(speed / first, 1.0)
    if kind == THRELFALL:
        return mu * (1.0 - math.exp(-3.0 * min(speed / first, 1.0)))
    if kind == AMBROSIO:
        return mu * min(max((speed - first) / (p[FRICTION + 1] - first), 0.0), 1.0)
    static = max(p[FRICTION + 1], mu)
    if kind == BENGISU_AKAY:
        if speed < first:
            return static * (speed / first) * (2.0 - speed / first)
        return mu + (static - mu) * math.exp(-p[FRICTION + 2] * (speed - first))
    x = speed / first  # Brown and McPhee
    return mu * math.tanh(4.0 * x) + (static - mu) * x / (0.25 * x * x + 0.75) ** 2 + p[FRICTION + 2] * speed


@kernel
def lugre_rate(p: FloatArray, slip: float, mu: float, bristle: float) -> float:
    """dz/dt of the LuGre law [m/s]."""
    drop = math.exp(-((slip / p[FRICTION + 3]) ** 2))
    sliding = mu + (max(p[FRICTION + 4], mu) - mu) * drop
    return slip - p[FRICTION] * abs(slip) * bristle / sliding


@kernel
def sticking(p: FloatArray, slip: float) -> float:
    """s of the bristle law: 1 at rest, 0 far above the Stribeck speed."""
    return math.exp(-((slip / p[FRICTION + 3]) ** 2))


@kernel
def bristle_rate(p: FloatArray, slip: float, mu: float, bristle: float) -> float:
    """dz/dt of the bristle law [m/s]."""
    s = sticking(p, slip)
    x = slip / p[FRICTION + 6]
    direction = math.copysign(1.0, slip) if abs(x) >= 1.0 else x * (1.5 - 0.5 * x * x)
    return s * slip + (1.0 - s) * (mu * direction - p[FRICTION] * bristle) / p[FRICTION + 1]


@kernel
def friction_force(
    kinds: IntArray, p: FloatArray, slip: float, normal: float, mu: float, bristle: float, dwell: float
) -> float:
    """Tangential force [N] on the node at a slip velocity [m/s] under a normal force >= 0 [N]: it opposes the slip.

    ``bristle`` [m] and ``dwell`` are the states of laws that have some.
    """
    kind = kinds[FRICTION_KIND]
    if kind == TANH:
        return -mu * normal * math.tanh(slip / p[FRICTION])
    if kind == LUGRE:
        rate = lugre_rate(p, slip, mu, bristle)
        return -normal * (p[FRICTION] * bristle + p[FRICTION + 1] * rate + p[FRICTION + 2] * slip)
    if kind == BRISTLE:
        part = p[FRICTION] * bristle + p[FRICTION + 1] * bristle_rate(p, slip, mu, bristle)
        most = mu + (max(p[FRICTION + 4], mu) - mu) * dwell
        return -normal * (min(max(part, -most), most) + p[FRICTION + 2] * slip)
    return -math.copysign(normal * coefficient(kind, p, abs(slip), mu), slip)


@kernel
def bristle_rates(
    kinds: IntArray, p: FloatArray, slip: float, normal: float, mu: float, bristle: float, dwell: float
) -> tuple[float, float]:
    """Rates of the two states of a friction law [m/s, 1/s]; zero for laws without."""
    kind = kinds[FRICTION_KIND]
    if kind == LUGRE:
        return lugre_rate(p, slip, mu, bristle), 0.0
    if kind == BRISTLE:
        change = sticking(p, slip) - dwell
        lag = p[FRICTION + 5] if change >= 0.0 else p[FRICTION + 1] / p[FRICTION]
        return bristle_rate(p, slip, mu, bristle), change / lag
    return 0.0, 0.0


@kernel
def friction_forces(
    kinds: IntArray, p: FloatArray, slip: FloatArray, normal: FloatArray, mu: FloatArray, out: FloatArray
) -> None:
    """out = ``friction_force`` of each element, for laws without states."""
    for i in range(len(out)):
        out[i] = friction_force(kinds, p, slip[i], normal[i], mu[i], 0.0, 0.0)
