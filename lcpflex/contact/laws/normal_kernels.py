"""Normal force of a contact law: its elastic and dissipative part together, and what is stored.

Beyond the end of an elastic law its tangent there goes on: trial states of a step may lie beyond, accepted ones not.
"""

from __future__ import annotations

from lcpflex.compiled import FloatArray, IntArray, kernel
from lcpflex.contact.laws.damping_kernels import damping_force
from lcpflex.contact.laws.elastic_kernels import elastic_force, elastic_stiffness, stored_energy
from lcpflex.contact.laws.layout import GUARD

__all__ = ["contact_energy", "contact_stiffness", "normal_force"]


@kernel
def normal_force(
    kinds: IntArray,
    p: FloatArray,
    depth: float,
    rate: float,
    speed: float,
    mass: float,
    deepest: float,
    loading: bool,
) -> tuple[float, float]:
    """Force >= 0 and its part that stores energy [N], at an indentation > 0 [m] growing with ``rate`` [m/s].

    speed [m/s], mass [kg]: impact speed and effective mass at the touch. deepest [m]: largest indentation so far;
    loading: whether the contact has not turned back from it.
    """
    elastic = elastic_force(kinds, p, depth)
    damping = damping_force(kinds, p, depth, rate, elastic, max(speed, p[GUARD]), mass)
    force = elastic + damping
    return (0.0 if force < 0.0 else force), elastic  # not max: what is not a number is to be seen


@kernel
def contact_energy(kinds: IntArray, p: FloatArray, depth: float, deepest: float, loading: bool) -> float:
    """Energy that a contact can give back [J], at an indentation >= 0 [m]."""
    return stored_energy(kinds, p, depth)


@kernel
def contact_stiffness(kinds: IntArray, p: FloatArray, depth: float, deepest: float, loading: bool) -> float:
    """Slope of the elastic part at an indentation > 0 [N/m]."""
    return elastic_stiffness(kinds, p, depth)
