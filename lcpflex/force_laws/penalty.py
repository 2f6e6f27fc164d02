"""The simplest continuous contact force: a spring between surfaces, with damping and smoothed friction."""

from __future__ import annotations

import math
from dataclasses import dataclass

from lcpflex.basics.options import keep_number
from lcpflex.force_laws.contact_law import law_row
from lcpflex.force_laws.friction.laws import SmoothedCoulomb
from lcpflex.force_laws.layout import LawRow, Part

__all__ = ["Penalty"]


@dataclass(frozen=True, slots=True)
class Penalty:
    """A spring between surfaces that penetrate, with damping and smoothed friction.

        lambda_N = max(0, K delta^n (1 + chi deltadot)),   delta = -g_N > 0
        lambda_T = -mu lambda_N tanh(gdot_T / v_s)

    Bodies of a scene rub halfway between their surfaces, where gdot_T is taken: friction makes no couple of its own.
    For laws with the constants of a material, named damping and other friction see :class:`ContactLaw`.
    Sources: Hertz 1881 (n = 3/2); Hunt & Crossley 1975 (damping).

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
        keep_number(self, "stiffness", 0.0, math.inf, open_ends=True)
        keep_number(self, "exponent", 1.0, math.inf)
        keep_number(self, "damping", 0.0, math.inf)
        keep_number(self, "slip_speed", 0.0, math.inf, open_ends=True)

    def row(self) -> LawRow:
        """The law as kernels take it."""
        spring = Part("power", (self.stiffness, self.exponent))
        return law_row(spring, Part("proportional", (self.damping,)), SmoothedCoulomb(self.slip_speed))
