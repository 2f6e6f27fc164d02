"""Continuous contact forces: the normal force as a function of the indentation and its rate.

    lambda_N = max(0, K delta^n (1 + chi deltadot)),   delta = -g_N > 0
    lambda_T = -mu lambda_N tanh(gdot_T / v_s)

Bodies of a scene rub halfway between their surfaces, where gdot_T is taken: friction makes no couple of its own. The
elastic part K delta^n stores K delta^(n + 1) / (n + 1); what the force does beyond it is lost. A declared contact has
the number of its law and an array of its parameters: the kernels below branch on that number alone, so that another law
is one more branch in each of them. Sources: Hertz 1881 (n = 3/2); Hunt & Crossley 1975 (damping).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from lcpflex.compiled import FloatArray, kernel
from lcpflex.errors import in_range

__all__ = [
    "PARAMETERS",
    "Penalty",
    "elastic_force",
    "indentation_of",
    "normal_force",
    "stiffness_at",
    "stored_energy",
]

POWER = 0  # kind of Penalty; parameters K, n, chi
PARAMETERS = 3  # of the law that has most of them


@kernel
def normal_force(kind: int, indentation: float, rate: float, parameters: FloatArray) -> float:
    """Force [N] at an indentation > 0 [m] that grows with ``rate`` [m/s]; never attractive."""
    return max(0.0, parameters[0] * indentation ** parameters[1] * (1.0 + parameters[2] * rate))


@kernel
def elastic_force(kind: int, indentation: float, parameters: FloatArray) -> float:
    """Part of the force that stores energy [N]: the derivative of ``stored_energy``."""
    return parameters[0] * indentation ** parameters[1]


@kernel
def stored_energy(kind: int, indentation: float, parameters: FloatArray) -> float:
    """Energy of the elastic part at an indentation >= 0 [J]."""
    return parameters[0] * indentation ** (parameters[1] + 1.0) / (parameters[1] + 1.0)


@kernel
def stiffness_at(kind: int, indentation: float, parameters: FloatArray) -> float:
    """Slope of the elastic part at an indentation > 0 [N/m]."""
    return parameters[0] * parameters[1] * indentation ** (parameters[1] - 1.0)


@kernel
def indentation_of(kind: int, energy: float, parameters: FloatArray) -> float:
    """Indentation at which the elastic part has stored ``energy`` [m]."""
    return ((parameters[1] + 1.0) * energy / parameters[0]) ** (1.0 / (parameters[1] + 1.0))


@dataclass(frozen=True, slots=True)
class Penalty:
    """A spring between surfaces that penetrate, with damping and smoothed friction.

    Attributes
    ----------
    stiffness
        K [N/m^n], > 0.
    exponent
        n >= 1: 1 a linear spring, 3/2 Hertz's contact of curved bodies.
    damping
        chi >= 0 [s/m]: the elastic force is multiplied by 1 + chi deltadot, and clipped where that is negative (parting
        faster than 1/chi): it never pulls. It begins and ends at zero with the indentation (Hunt & Crossley).
    slip_speed
        v_s > 0 [m/s]: friction is -mu lambda_N tanh(gdot_T / v_s), with the mu of the declared contact. Nothing sticks:
        what Coulomb's law would hold creeps, at up to about v_s.

    Raises
    ------
    ModelError
        For a number out of its range.
    """

    stiffness: float
    exponent: float = 1.0
    damping: float = 0.0
    slip_speed: float = 1e-3

    def __post_init__(self) -> None:
        in_range("stiffness", self.stiffness, 0.0, math.inf, open_ends=True)
        in_range("exponent", self.exponent, 1.0, math.inf)
        in_range("damping", self.damping, 0.0, math.inf)
        in_range("slip_speed", self.slip_speed, 0.0, math.inf, open_ends=True)

    @property
    def kind(self) -> int:
        """Number of the law in the kernels."""
        return POWER

    @property
    def parameters(self) -> tuple[float, ...]:
        """Its numbers in their order."""
        return self.stiffness, self.exponent, self.damping
