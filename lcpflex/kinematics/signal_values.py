"""Values of the functions of time of a scene, from kernels."""

from __future__ import annotations

import math

from lcpflex.force_laws.user_call import own_force
from lcpflex.jit.kernel import FloatArray, kernel, late_kernel
from lcpflex.model.arrays import Signals

__all__ = ["signal_value"]


@kernel
def function_value(address: int, component: int, t: float) -> tuple[float, float, float]:
    """A compiled function of a user's at time t: a component of a force, or, for -1, a motion with its derivatives."""
    value = own_force(address, t, float(max(component, 0)), 0.0)
    if component >= 0:
        return value, 0.0, 0.0
    return value, own_force(address, t, 1.0, 0.0), own_force(address, t, 2.0, 0.0)


@late_kernel
def signal_value(signals: Signals, index: int, t: float, external: FloatArray) -> tuple[float, float, float]:
    """Value, first and second derivative at time t of function ``index``; see :class:`lcpflex.model.arrays.Signals`."""
    first = signals.first[index]
    if signals.kind[index] == 2:
        return external[first, 0], external[first, 1], external[first, 2]
    if signals.kind[index] == 3:
        return function_value(signals.address[first], signals.last[index], t)
    if signals.kind[index] == 1:
        mean = signals.coefficients[first, 0]
        amplitude = signals.coefficients[first, 1]
        omega = signals.coefficients[first, 2]
        phase = omega * t + signals.coefficients[first, 3]
        swing = amplitude * math.sin(phase)
        return mean + swing, omega * amplitude * math.cos(phase), -omega * omega * swing
    low = first
    high = signals.last[index] - 1
    if t < signals.breaks[low]:
        return signals.coefficients[low, 3], 0.0, 0.0
    if t > signals.breaks[high]:
        return signals.coefficients[high, 3], 0.0, 0.0
    while high - low > 1:
        middle = (low + high) // 2
        if signals.breaks[middle] <= t:
            low = middle
        else:
            high = middle
    s = t - signals.breaks[low]
    cubic = signals.coefficients[low, 0]
    square = signals.coefficients[low, 1]
    slope = signals.coefficients[low, 2]
    value = ((cubic * s + square) * s + slope) * s + signals.coefficients[low, 3]
    return value, (3.0 * cubic * s + 2.0 * square) * s + slope, 6.0 * cubic * s + 2.0 * square
