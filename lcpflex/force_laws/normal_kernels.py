"""Normal force of a contact law: its elastic and dissipative part together, and what is stored.

A law with permanent indentation unloads along a curve of its own, from the largest indentation delta_m,

    F((delta - delta_p) / e^2),   delta_p = (1 - e^2) delta_m,

which gives back e^2 of the work done on the way in, whatever the elastic law F.
"""

from __future__ import annotations

from lcpflex.force_laws.damping.kernels import PERMANENT, damping_force
from lcpflex.force_laws.elastic.kernels import OWN, elastic_force, elastic_stiffness, stored_energy
from lcpflex.force_laws.layout import ADDRESS, DAMPING, DAMPING_KIND, ELASTIC, ELASTIC_KIND, GUARD
from lcpflex.force_laws.user_call import own_force
from lcpflex.jit.kernel import FloatArray, IntArray, kernel

__all__ = ["contact_energy", "contact_stiffness", "normal_force"]


@kernel
def shrunk(p: FloatArray, depth: float, deepest: float, loading: bool) -> float:
    """Indentation that the elastic law is to be taken at, under a permanent one; <= 0 where surfaces have parted."""
    if loading or depth >= deepest:
        return depth
    kept = p[DAMPING] * p[DAMPING]
    return deepest - (deepest - depth) / kept


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
    permanent = kinds[DAMPING_KIND] == PERMANENT
    at = shrunk(p, depth, deepest, loading) if permanent else depth
    if at <= 0.0:
        return 0.0, 0.0
    elastic = elastic_force(kinds, p, at)
    if permanent:
        return elastic, elastic * (p[DAMPING] * p[DAMPING] if loading or depth >= deepest else 1.0)
    damping = damping_force(kinds, p, depth, rate, elastic, max(speed, p[GUARD]), mass)
    force = elastic + damping
    if kinds[ELASTIC_KIND] == OWN:
        force += own_force(kinds[ADDRESS], depth, rate, max(speed, p[ELASTIC])) - elastic
    return (0.0 if force < 0.0 else force), elastic  # not max: what is not a number is to be seen


@kernel
def contact_energy(kinds: IntArray, p: FloatArray, depth: float, deepest: float, loading: bool) -> float:
    """Energy that a contact can give back [J], at an indentation >= 0 [m]."""
    if kinds[DAMPING_KIND] == PERMANENT:
        at = shrunk(p, depth, deepest, loading)
        return p[DAMPING] * p[DAMPING] * stored_energy(kinds, p, at) if at > 0.0 else 0.0
    return stored_energy(kinds, p, depth)


@kernel
def contact_stiffness(kinds: IntArray, p: FloatArray, depth: float, deepest: float, loading: bool) -> float:
    """Slope of the elastic part at an indentation > 0 [N/m]."""
    if kinds[DAMPING_KIND] == PERMANENT and not loading and depth < deepest:
        at = shrunk(p, depth, deepest, loading)
        return elastic_stiffness(kinds, p, at) / (p[DAMPING] * p[DAMPING]) if at > 0.0 else 0.0
    return elastic_stiffness(kinds, p, depth)
