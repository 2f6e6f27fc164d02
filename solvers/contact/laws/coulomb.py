"""Coulomb's law of dry friction: :mod:`.interval` in the plane, :mod:`.disc` in space.

    0 <= v_N  _|_  p_N >= 0,    |p_T| <= mu p_N,    p_T against v_T where it slides

What each function of a law does is said in :mod:`lcpflex.solvers.contact.laws`.
"""

from __future__ import annotations

from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.jit.leaf import leaf
from lcpflex.solvers.contact.algebra import Vector
from lcpflex.solvers.contact.group import Group

__all__ = ["answer", "derivative", "miss", "room", "soft", "solve"]


@leaf
def solve(group: Group, k: int, v: Vector, p: Vector) -> tuple[Vector, bool]:
    """Exactly, whatever the velocities of other units are."""
    raise NotImplementedError


@leaf
def answer(group: Group, k: int, a: Vector, convex: bool) -> tuple[Vector, int]:
    """Open (a_N <= 0): 0; sticking (|a_T| <= mu a_N): a; sliding: (a_N, mu a_N a_T / |a_T|).

    convex: the nearest point of the cone instead, as if what slides lifted off.
    """
    raise NotImplementedError


@leaf
def derivative(group: Group, k: int, a: Vector, state: int, rho: float, C: FloatArray) -> None:
    """Of the answer at a."""
    raise NotImplementedError


@leaf
def room(group: Group, k: int, q: Vector, d: Vector) -> float:
    """Until it opens, or what sticks slides."""
    raise NotImplementedError


@leaf
def miss(group: Group, k: int, p: Vector, v: Vector) -> float:
    """What is left of the natural map of its cone."""
    raise NotImplementedError


@kernel(inline=True)
def soft(eps: float) -> float:
    """A contact is as soft as it is taken to be."""
    return eps
