"""Friction laws with states: bristles that bend before they slip, so that contacts hold at rest.

All constants are per unit of normal force, since that varies in a contact: a stiffness sigma_0 of the literature in
N/m, and a damping in N s/m, hold at a certain load (of a test rig, say) and are divided by it. A usual set of 1e5 N/m,
316 N s/m and 0.4 N s/m at F_c = 1 N with mu = 0.1, so at a load of 10 N, is 1e4 1/m, 31.6 s/m and 0.04 s/m here.

The bristles of a contact are straight when it begins, and forgotten when it ends. What they store counts as lost to
friction in the energies of a result, and is given back there as they straighten.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt

from lcpflex.basics.options import keep_number, keep_number_or_none
from lcpflex.force_laws.friction.static_friction import (
    check_static_friction,
    common_shape,
    slip_of,
)

__all__ = ["Bristle", "LuGre"]

FAST = 1e3  # Stribeck speeds, beyond which exp(-x^2) is zero


@dataclass(frozen=True, slots=True)
class WithBristles:
    """A friction law with states: what LuGre's and Gonthier's have in common."""

    stiffness: float = 1e4
    damping: float = 30.0
    viscous: float = 0.0
    stribeck_speed: float = 1e-3
    static_friction: float | None = None
    bristles: ClassVar[bool] = True
    check = check_static_friction

    def __post_init__(self) -> None:
        keep_number(self, "stiffness", 0.0, math.inf, open_ends=True)
        keep_number(self, "damping", 0.0, math.inf)
        keep_number(self, "viscous", 0.0, math.inf)
        keep_number(self, "stribeck_speed", 0.0, math.inf, open_ends=True)
        keep_number_or_none(self, "static_friction", 0.0, math.inf)

    @property
    def slip_speed(self) -> float:
        """Below it a contact counts as sticking in records [m/s]."""
        return self.stribeck_speed


@dataclass(frozen=True, slots=True)
class LuGre(WithBristles):
    """Bristles of deflection z (Canudas de Wit, Olsson, Astrom & Lischinsky 1995).

        lambda_T = -lambda_N (sigma_0 z + sigma_1 zdot + sigma_2 gdot_T)
        zdot = gdot_T - sigma_0 |gdot_T| z / g,   g = mu + (mu_s - mu) exp(-(gdot_T / v_s)^2)

    At constant speed z = g sgn(gdot_T) / sigma_0, so that friction is the Stribeck curve g + sigma_2 |gdot_T|. Before
    it slips a contact is a spring of stiffness sigma_0 lambda_N. |z| stays below mu_s / sigma_0, the force may pass
    mu_s by the part of sigma_1: a contact that begins at a slip v begins with sigma_1 v lambda_N, and its impulse is mu
    (sigma_1 - mu / v) / sigma_0 lambda_N above Coulomb's. Let sigma_1 be well below mu / v where that matters. Under a
    force f mu lambda_N that comes and goes, f < 1, it drifts by -mu / sigma_0 ln(1 - f^2) each time, a known trait.

    Attributes
    ----------
    stiffness
        sigma_0 > 0 [1/m].
    damping
        sigma_1 >= 0 [s/m].
    viscous
        sigma_2 >= 0 [s/m].
    stribeck_speed
        v_s > 0 [m/s]; below it a contact counts as sticking in records.
    static_friction
        mu_s >= mu; None: mu.

    Raises
    ------
    ModelError
        For a number out of its range.
    """

    kind: ClassVar[str] = "lugre"

    @property
    def parameters(self) -> tuple[float, ...]:
        """sigma_0, sigma_1, sigma_2, v_s, mu_s."""
        return self.stiffness, self.damping, self.viscous, self.stribeck_speed, self.static_friction or 0.0

    def steady_force(self, slip: npt.ArrayLike, normal: npt.ArrayLike, mu: npt.ArrayLike) -> Any:
        """Tangential force [N] after sliding at constant velocities [m/s] under normal forces >= 0 [N], broadcast.

        Where mu is 0 there is none, as in a run.

        slip: velocity [m/s].

        Raises
        ------
        ModelError
            For what is no finite number, a negative normal force or coefficient, and mu_s < mu.
        """
        slip, normal, mu = slip_of(slip, normal, mu)
        common_shape((slip, normal, mu))
        if mu.size > 0:
            self.check(float(mu.max()), "mu")
        static = np.maximum(self.static_friction or 0.0, mu)
        sliding = mu + (static - mu) * np.exp(-(np.minimum(np.abs(slip) / self.stribeck_speed, FAST) ** 2))
        return -normal * (mu > 0.0) * (np.sign(slip) * sliding + self.viscous * slip)


@dataclass(frozen=True, slots=True)
class Bristle(WithBristles):
    """Bristles of deflection z that remember how long a contact has been at rest (Gonthier et al. 2004).

        lambda_T = -lambda_N (min(max(sigma_0 z + sigma_1 zdot, -f), f) + sigma_2 gdot_T),   f = mu + (mu_s - mu) s_d
        zdot = s gdot_T + (1 - s) (mu dir(gdot_T) - sigma_0 z) / sigma_1,   s = exp(-(gdot_T / v_s)^2)
        ds_d/dt = (s - s_d) / tau,   tau = tau_d where s >= s_d, else sigma_1 / sigma_0

    dir(v) = sgn(v), smoothed by a cubic below ``direction_speed``. At rest z is as the slip has left it: a contact does
    not drift, and its static friction mu_s is reached after it has dwelt for some tau_d. Unconfirmed: the formula was
    not compared with its text, and that the limit f does not hold for the viscous part is a reading.

    Attributes
    ----------
    stiffness
        sigma_0 > 0 [1/m].
    damping
        sigma_1 > 0 [s/m].
    viscous
        sigma_2 >= 0 [s/m].
    stribeck_speed
        v_s > 0 [m/s]; below it a contact counts as sticking in records.
    static_friction
        mu_s >= mu; None: mu.
    dwell_time
        tau_d > 0 [s].
    direction_speed
        [m/s], > 0; None: v_s / 100.

    Raises
    ------
    ModelError
        For a number out of its range.
    """

    kind: ClassVar[str] = "bristle"
    dwell_time: float = 1.0
    direction_speed: float | None = None

    def __post_init__(self) -> None:
        WithBristles.__post_init__(self)
        keep_number(self, "damping", 0.0, math.inf, open_ends=True)  # it is divided by
        keep_number(self, "dwell_time", 0.0, math.inf, open_ends=True)
        keep_number_or_none(self, "direction_speed", 0.0, math.inf, open_ends=True)

    @property
    def parameters(self) -> tuple[float, ...]:
        """sigma_0, sigma_1, sigma_2, v_s, mu_s, tau_d, direction speed."""
        return (
            self.stiffness,
            self.damping,
            self.viscous,
            self.stribeck_speed,
            self.static_friction or 0.0,
            self.dwell_time,
            0.01 * self.stribeck_speed if self.direction_speed is None else self.direction_speed,
        )
