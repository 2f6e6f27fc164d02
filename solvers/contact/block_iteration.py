"""Block Gauss-Seidel: each unit solved by itself, exactly, with the forces of the others as they are.

The one iteration of all contact problems: in the plane and in space, for any operator and any law. Sources: Jean 1999
(nonsmooth contact dynamics); Jourdan, Alart & Jean 1998; Bonnefon & Daviet 2011 (the exact law of one contact).
"""

from __future__ import annotations

import numpy as np

from lcpflex.jit.kernel import kernel
from lcpflex.solvers.contact.algebra import Vector, less, put, size_of, taken
from lcpflex.solvers.contact.group import Group
from lcpflex.solvers.contact.laws import solve
from lcpflex.solvers.contact.operators import Operator, push, velocity

__all__ = ["sweep"]


@kernel
def sweep(op: Operator, group: Group, like: Vector, count: int, target: float) -> tuple[int, float]:
    """Up to ``count`` sweeps over all units; how many were made, and the largest change of a force in the last one.

    Forces and what the operator keeps of their effect (:func:`lcpflex.solvers.contact.operators.begin`) are advanced in
    place. Ends early once the change, in units of the contacts, is ``target`` or less. inf: a contact that no force of
    its own keeps apart, which the others may help.
    """
    p, unit, made, change = group.p, group.unit, 0, np.inf
    while made < count and change > target:
        change = 0.0
        for k in range(group.n):
            old = taken(p, k, like)
            new, found = solve(group, k, velocity(op, group, k, like), old)
            if not found:
                change = np.inf
                continue
            d = less(new, old)
            size = size_of(d)
            if size != 0.0:
                change = max(change, size / unit[k])
                put(p, k, new)
                push(op, group, k, d)
        made += 1
    return made, change
