"""Velocities of contact rows in space, as :func:`lcpflex.dynamics.delassus.free_velocities` of the plane has them.

A row of a rigid body has six numbers there, and a step poses three rows a contact: products and their sizes in one
walk, instead of two, take half as long.
"""

from __future__ import annotations

from lcpflex.dynamics.delassus import row_velocity
from lcpflex.dynamics.spatial.inertia import SpatialWork
from lcpflex.jit.kernel import kernel

__all__ = ["measure_free"]


@kernel
def measure_free(work: SpatialWork, n: int) -> None:
    """``work.free`` and ``work.terms`` of the first n rows at ``work.free_u``."""
    rows, row_body, dof, u, n_joint = work.rows, work.row_body, work.dof, work.free_u, work.n_joint
    free, terms = work.free, work.terms
    for r in range(n_joint):
        free[r] = row_velocity(rows, row_body, r, dof, u)
    for r in range(n_joint, n):
        total, size = 0.0, 0.0
        for i in range(2):
            b = row_body[r, i]
            if b < 0:
                continue
            d = dof[b]
            for c in range(dof[b + 1] - d):
                part = rows[r, i, c] * u[d + c]
                total += part
                size += abs(part)
        free[r] = total
        terms[r - n_joint] = size
