"""Dissipative part of contact laws: the force beyond the elastic one.

The state of a contact is its indentation, its rate, and what it remembers from the touch: impact speed and effective
mass 1/G_NN. The sum with the elastic part is clipped at zero by the caller: a contact never pulls.
"""

from __future__ import annotations

import math

from lcpflex.force_laws.elastic.kernels import elastic_stiffness, stored_energy
from lcpflex.force_laws.layout import DAMPING, DAMPING_KIND
from lcpflex.jit.kernel import FloatArray, IntArray, kernel

__all__ = ["KINDS", "PERMANENT", "damping_force", "damping_mass"]

KINDS = (
    "none", "proportional", "hysteresis", "viscous", "tsuji", "kuwabara_kono", "ristow", "jankowski", "permanent",
)  # fmt: skip
NONE, PROPORTIONAL, HYSTERESIS, VISCOUS, TSUJI, KUWABARA_KONO, RISTOW, JANKOWSKI, PERMANENT = range(len(KINDS))


@kernel
def damping_mass(p: FloatArray, mass: float) -> float:
    """Mass in the law of a damping [kg]: the given one, or else ``mass`` that the contact remembers.

    Infinite where nothing can move along the normal: it has no rate then, and no damping.
    """
    given = p[DAMPING + 1]
    if given > 0.0:
        return given
    return mass if mass < math.inf else 0.0


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
    if kind == KUWABARA_KONO:
        return p[DAMPING] * elastic_stiffness(kinds, p, depth) * rate
    if kind == RISTOW:
        return p[DAMPING] * damping_mass(p, mass) * rate
    if kind == VISCOUS:  # of linear springs only
        return 2.0 * p[DAMPING] * math.sqrt(elastic_stiffness(kinds, p, depth) * damping_mass(p, mass)) * rate
    if kind == TSUJI or (kind == JANKOWSKI and rate > 0.0):
        # c = 2 zeta sqrt(m) ds/ddelta with s = sqrt(2 E): a linear oscillator in the phase plane of s, for any law
        energy = stored_energy(kinds, p, depth)
        if energy > 0.0:  # it is not for the least of indentations
            return p[DAMPING] * elastic * (math.sqrt(2.0 * damping_mass(p, mass)) / math.sqrt(energy)) * rate
    return 0.0
