"""Dissipative part of contact laws: the force beyond the elastic one.

The state of a contact is its indentation, its rate, and what it remembers from the touch: impact speed and effective
mass 1/G_NN. The sum with the elastic part is clipped at zero by the caller: a contact never pulls.
"""

from __future__ import annotations

from lcpflex.compiled import FloatArray, IntArray, kernel
from lcpflex.contact.laws.layout import DAMPING, DAMPING_KIND, HYSTERESIS, PROPORTIONAL

__all__ = ["damping_force"]


@kernel
def damping_force(
    kinds: IntArray, p: FloatArray, depth: float, rate: float, elastic: float, speed: float, mass: float
) -> float:
    """Force [N] at an indentation > 0 [m] growing with ``rate`` [m/s], beside the ``elastic`` force [N].

    ``speed`` [m/s]: of the impact, guarded; ``mass`` [kg]: effective mass of the contact.
    """
    kind = kinds[DAMPING_KIND]
    if kind == PROPORTIONAL:
        return elastic * p[DAMPING] * rate
    if kind == HYSTERESIS:
        return elastic * p[DAMPING] * rate / speed
    return 0.0
