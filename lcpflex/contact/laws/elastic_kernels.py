"""Elastic part of contact laws: force, stiffness and stored energy of an indentation, and their inverses.

``kind`` is one of the elastic kinds of :mod:`lcpflex.contact.laws.layout`, ``p`` the row of parameters of the law.
"""

from __future__ import annotations

from lcpflex.compiled import FloatArray, IntArray, kernel
from lcpflex.contact.laws.layout import ELASTIC

__all__ = ["elastic_force", "elastic_stiffness", "indentation_of", "stored_energy"]

MOST_ITERATIONS = 40
ROUGH = 1e-2  # relative, of an indentation that only bounds a step


@kernel
def elastic_force(kinds: IntArray, p: FloatArray, depth: float) -> float:
    """Force F [N] at an indentation > 0 [m]: the derivative of ``stored_energy``."""
    return p[ELASTIC] * depth ** p[ELASTIC + 1]


@kernel
def elastic_stiffness(kinds: IntArray, p: FloatArray, depth: float) -> float:
    """dF/ddelta at an indentation > 0 [N/m]."""
    return p[ELASTIC] * p[ELASTIC + 1] * depth ** (p[ELASTIC + 1] - 1.0)


@kernel
def stored_energy(kinds: IntArray, p: FloatArray, depth: float) -> float:
    """Energy stored at an indentation >= 0 [J]."""
    return p[ELASTIC] * depth ** (p[ELASTIC + 1] + 1.0) / (p[ELASTIC + 1] + 1.0)


@kernel
def indentation_of(kinds: IntArray, p: FloatArray, energy: float) -> float:
    """Indentation at which about ``energy`` is stored [m], to 1 %: Newton's method in logarithms, exact for powers."""
    depth = 1e-6
    for _ in range(MOST_ITERATIONS):
        stored = stored_energy(kinds, p, depth)
        if abs(stored - energy) <= ROUGH * energy:
            break
        depth *= (energy / stored) ** (stored / (depth * elastic_force(kinds, p, depth)))
    return depth
