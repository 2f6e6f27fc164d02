"""Friction laws of continuous contact. The coefficient mu is that of the declared contact."""

from __future__ import annotations

import math
from dataclasses import dataclass

from lcpflex.contact.laws.layout import TANH
from lcpflex.errors import in_range

__all__ = ["SmoothedCoulomb"]


@dataclass(frozen=True, slots=True)
class SmoothedCoulomb:
    """lambda_T = -mu lambda_N tanh(gdot_T / v_s).

    Attributes
    ----------
    slip_speed
        v_s > 0 [m/s]. Nothing sticks: what Coulomb's law would hold creeps, at up to about v_s.
    """

    slip_speed: float = 1e-3

    def __post_init__(self) -> None:
        in_range("slip_speed", self.slip_speed, 0.0, math.inf, open_ends=True)

    @property
    def kind(self) -> int:
        """Number among the kinds of friction."""
        return TANH

    @property
    def parameters(self) -> tuple[float, ...]:
        """v_s."""
        return (self.slip_speed,)

    @property
    def bristles(self) -> bool:
        """It has no states."""
        return False
