"""How fast two free bodies part after an impact under a dissipative law: functions of one number, without units.

e = -v_out / v_0 of an impact without any other load, in which a force that would pull is zero. The laws are followed in
the plane of s = (2 E(delta))^(1/2), with E the stored energy, and v: there a law that only depends on the
elastic force is the same for all elastic laws, masses and speeds.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from lcpflex.basics import libs
from lcpflex.jit.kernel import FloatArray

__all__ = [
    "damping_ratio",
    "exact_factor",
    "half_oscillation",
    "rebound_of_drag",
    "rebound_of_factor",
    "rebound_of_ratio",
]

# e(eta) = 1 - 2/3 eta + ...
SERIES = (1.0, -2 / 3, 4 / 9, -44 / 135, 104 / 405, -40 / 189, 7648 / 42525)
SERIES_UP_TO = 0.02  # of eta: seven terms are exact to 1e-12, W_0 near its branch point is not
NEARLY_ELASTIC = 0.988  # e above which the root is taken of the series
PRECISE = 8.9e-16  # relative: the finest that brentq takes
RTOL, ATOL = 1e-12, 1e-13  # of the integration where there is no closed form
LAST = (math.pi * (1.0 - 1e-12)) ** 0.2  # tau at which it ends at the latest: bodies part at theta = pi


def elementwise(function: Callable[[float], float], values: ArrayLike) -> Any:
    """``function`` of each value; a float for a float."""
    array = np.asarray(values, dtype=float)
    results = np.array([function(value) for value in array.ravel().tolist()], dtype=float).reshape(array.shape)
    return float(results) if array.ndim == 0 else results


def rebound_of_factor(eta: ArrayLike) -> Any:
    """e of F (1 + eta v / v_0), eta >= 0: e = (1 + W_0(-(1 + eta) exp(-(1 + eta)))) / eta.

    The same for every elastic law F, mass and impact speed. It solves ln((1 + eta) / (1 - e eta)) = eta (1 + e).
    """
    factor = np.asarray(eta, dtype=float)
    large = np.maximum(factor, SERIES_UP_TO)
    closed = (1.0 + libs.lambertw(-(1.0 + large) * np.exp(-(1.0 + large))).real) / large
    series = np.polynomial.polynomial.polyval(np.minimum(factor, SERIES_UP_TO), np.array(SERIES))
    result: FloatArray = np.where(factor < SERIES_UP_TO, series, closed)
    return float(result) if factor.ndim == 0 else result


def exact_factor(e: ArrayLike) -> Any:
    """eta with which F (1 + eta v / v_0) gives e, 0 < e <= 1: inverse of ``rebound_of_factor``, to 1e-11."""
    return elementwise(_exact_factor, e)


def _exact_factor(e: float) -> float:
    first = 1.5 * (1.0 - e) / (1.0 - e + e * e)
    if e > NEARLY_ELASTIC:
        polynomial = np.polynomial.Polynomial(SERIES) - e
        slope = polynomial.deriv()
        eta = first
        for _ in range(6):  # quadratic from 1e-4
            eta -= float(polynomial(eta) / slope(eta))
        return max(eta, 0.0)

    def unbalance(s: float) -> float:  # s = ln(1 - e eta) resolves the neighbourhood of eta = 1/e
        eta = -math.expm1(s) / e
        return math.log1p(eta) - s - eta * (1.0 + e)

    low, high = -2.0 * (1.0 + 1.0 / e) - 5.0, math.log1p(-0.25 * e * first)
    return -math.expm1(libs.brentq(unbalance, low, high, xtol=1e-300, rtol=PRECISE, maxiter=2000)) / e


def damping_ratio(e: ArrayLike) -> Any:
    """zeta = -ln e / (pi^2 + ln^2 e)^(1/2) of a linear oscillator whose speed is e after half a period; 1 for e = 0."""
    value = np.asarray(e, dtype=float)
    with np.errstate(divide="ignore", invalid="ignore"):
        log = -np.log(value)
        ratio: FloatArray = np.where(value > 0.0, log / np.hypot(math.pi, log), 1.0)
    return float(ratio) if value.ndim == 0 else ratio


def half_oscillation(zeta: ArrayLike) -> Any:
    """Largest s over v_0 of s'' + 2 zeta s' + s = 0 from s = 0, for zeta >= 0."""
    ratio = np.asarray(zeta, dtype=float)
    low, high = np.minimum(ratio, 1.0), np.maximum(ratio, 1.0)
    q = np.sqrt((1.0 - low) * (1.0 + low))
    p = high * np.sqrt((high - 1.0) / high * ((high + 1.0) / high))  # the square of a large ratio has no number
    with np.errstate(divide="ignore", invalid="ignore"):
        under = np.arctan2(q, ratio) / q
        over = np.log1p(ratio - 1.0 + p) / p  # artanh(p / zeta) without its loss of digits
    time: FloatArray = np.where(ratio < 1.0, under, np.where(ratio > 1.0, over, 1.0))
    result: FloatArray = np.exp(-ratio * time)
    return float(result) if ratio.ndim == 0 else result


def rebound_of_ratio(zeta: ArrayLike) -> Any:
    """e of a linear oscillator in the plane of s whose contact ends where its force does.

    e = exp(-(2 zeta / q) atan(q / zeta)), q = (1 - zeta^2)^(1/2); e^-2 at zeta = 1, and so on beyond it: the square of
    ``half_oscillation``.
    """
    return half_oscillation(zeta) ** 2


def rebound_of_drag(strength: ArrayLike, power: float) -> Any:
    """e of v dv/ds = -(s + k s^power v), from v = 1 at s = 0 until the force s + k s^power v is zero; k >= 0.

    With s = r sin(theta), v = r cos(theta) it is a regular equation for ln r(theta) up to that end; theta = tau^5 takes
    the roots of s away, for a power of 1/5 (Kuwabara & Kono) and of -1/5 (Ristow).
    """

    def rebound(k: float) -> float:
        if k == 0.0:
            return 1.0

        def drag(tau: float, log_r: float) -> tuple[float, float, float]:
            theta = tau**5
            sine, cosine = math.sin(theta), math.cos(theta)
            # over tau^(5 power), which goes to theta's own derivative
            smooth = k * (math.exp(log_r) * (sine / theta if theta > 0.0 else 1.0)) ** power
            return smooth, sine, cosine

        def slope(tau: float, log_r: FloatArray) -> tuple[float]:
            smooth, sine, cosine = drag(tau, float(log_r[0]))
            friction = 5.0 * tau ** (4.0 + 5.0 * power) * smooth
            return (-friction * cosine**2 / (1.0 + smooth * _power(tau, 5.0 * power, sine) * cosine),)

        def force(tau: float, log_r: FloatArray) -> float:
            smooth, sine, cosine = drag(tau, float(log_r[0]))
            return _power(tau, -5.0 * power, sine) + smooth * cosine

        force.terminal, force.direction = True, -1.0  # type: ignore[attr-defined]
        path = libs.solve_ivp(slope, (0.0, LAST), (0.0,), method="DOP853", rtol=RTOL, atol=ATOL, events=force)
        end, log_r = path.t[-1], path.y[0, -1]
        return -math.exp(log_r) * math.cos(end**5)

    return elementwise(rebound, strength)


def _power(tau: float, exponent: float, sine: float) -> float:
    """tau^exponent sin(tau^5), zero at zero."""
    return tau**exponent * sine if tau > 0.0 else 0.0
