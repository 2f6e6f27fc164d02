"""Contacts that a step was found to be short enough for: fewer of them are slower, and need not be asked of again.

With fewer rows W the compliance F^-1 that they share is less stiff: no frequency rises. See
:mod:`lcpflex.dynamics.stable_step`.
"""

from __future__ import annotations

from typing import Any

from lcpflex.dynamics.spatial.inertia import SpatialWork
from lcpflex.dynamics.spatial.position import stiffens
from lcpflex.jit.kernel import kernel

__all__ = ["admit", "is_admitted"]

LASTS = 16  # steps: in so few a body turns by nothing that the safety of the step would not bear


@kernel
def is_admitted(held: Any, work: SpatialWork, square: float) -> bool:
    """Whether contacts and sticking of the present solution were admitted with sqrt(square) [1/s] or less of late."""
    if held.age >= LASTS or square < held.admitted:
        return False
    at = 0
    for k in range(work.rows.n_contacts):
        if not stiffens(work, k):
            continue
        key = work.rows.table.key[k]
        while at < held.n_admitted and held.key[at] != key:
            at += 1
        if at == held.n_admitted or sticks(work, k) > held.sticks[at]:
            return False
        at += 1
    held.age += 1
    return True


@kernel
def admit(held: Any, work: SpatialWork, square: float) -> None:
    """Keep the contacts of the present solution as those that sqrt(square) [1/s] admits."""
    held.age, held.admitted, held.n_admitted = 0, square, 0
    for k in range(work.rows.n_contacts):
        if stiffens(work, k):
            held.key[held.n_admitted] = work.rows.table.key[k]
            held.sticks[held.n_admitted] = sticks(work, k)
            held.n_admitted += 1


@kernel
def sticks(work: SpatialWork, k: int) -> int:
    """1 where contact k has friction and sticks."""
    j = work.posed.tangent_of[k]
    return 1 if j >= 0 and stiffens(work, work.rows.n_contacts + j) else 0
