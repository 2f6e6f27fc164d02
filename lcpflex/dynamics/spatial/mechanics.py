"""What a stepper asks of the mechanics, for a compiled spatial scene; see :mod:`lcpflex.dynamics.mechanics`."""

from __future__ import annotations

from typing import Any

from lcpflex.dynamics.applied_forces import applied_forces
from lcpflex.dynamics.delassus import apply_impulses
from lcpflex.dynamics.spatial.body_forces import elastic_forces, inertial_forces, weight_forces
from lcpflex.dynamics.spatial.inertia import RowsOfSpace, SpatialWork
from lcpflex.dynamics.spatial.inertia_solve import multiply as multiply_block, solve_block, whiten
from lcpflex.jit.kernel import FloatArray, kernel, late_kernel
from lcpflex.kinematics.spatial.configuration import advance
from lcpflex.model.spatial import SpatialModel

__all__ = ["displace", "forces", "multiply", "solve_rows", "whiten_late", "whiten_rows"]


@kernel
def forces(model: Any, t: float, q: FloatArray, u: FloatArray, work: SpatialWork) -> None:
    """All generalised forces but constraint ones: by kind in conservative, dissipative, driving; their sum in total."""
    bodies, spin = model.bodies, work.rows.arrow.spin
    conservative, dissipative = work.free.conservative, work.free.dissipative
    driving, total = work.free.driving, work.free.total
    inertial_forces(bodies, q, u, work.rows.arrow, spin)
    for i in range(len(u)):
        conservative[i] = spin[i]
        dissipative[i] = 0.0
        driving[i] = 0.0
    weight_forces(bodies, model.loads, q, work.rows.arrow, conservative)
    elastic_forces(bodies, q, u, conservative, dissipative)
    applied_forces(model, t, q, u, work.free.span, work.free.external, conservative, dissipative, driving)
    for i in range(len(u)):
        total[i] = conservative[i] + dissipative[i] + driving[i]


@kernel
def multiply(model: SpatialModel, q: FloatArray, x: FloatArray, work: SpatialWork, out: FloatArray) -> None:
    """out = M(q) x, after ``factorise`` at the same q."""
    dof = model.bodies.dof
    for b in range(len(dof) - 1):
        multiply_block(model.bodies, work.rows.arrow, b, x[dof[b] : dof[b + 1]], out[dof[b] : dof[b + 1]])


@kernel
def solve_rows(model: SpatialModel, rows: RowsOfSpace, first: int, last: int) -> None:
    """solved[r] <- A^-1 rows[r] for first <= r < last."""
    J, solved, row_body = rows.J, rows.solved, rows.body
    for r in range(first, last):
        for i in range(2):
            b = row_body[r, i]
            if b >= 0:
                solve_block(model.bodies, rows.arrow, b, J[r, i], solved[r, i])


@late_kernel
def whiten_rows(model: SpatialModel, rows: RowsOfSpace, first: int, last: int) -> None:
    """white[r] <- L^-1 rows[r] for first <= r < last, L L^T = A."""
    for r in range(first, last):
        for i in range(2):
            b = rows.body[r, i]
            if b >= 0:
                whiten(model.bodies, rows.arrow, b, rows.J[r, i], rows.white[r, i])


@late_kernel
def whiten_late(work: SpatialWork, i: int) -> None:
    """Whiten the rows of island i, where that was spared."""
    rows, islands, blocks = work.rows, work.posed.islands, work.rows.arrow.blocks
    for c in range(islands.start[i], islands.start[i + 1]):
        k = islands.contact[c]
        j = work.posed.tangent_of[k]
        for e in range(3 if j >= 0 else 1):
            r = rows.n_joint + (k if e == 0 else rows.n_contacts + j + e - 1)
            for side in range(2):
                b = rows.body[r, side]
                if b >= 0:
                    whiten(blocks, rows.arrow, b, rows.J[r, side], rows.white[r, side])


@kernel
def displace(model: SpatialModel, rows: RowsOfSpace, first: int, last: int, p: FloatArray, q: FloatArray) -> None:
    """q moved by A^-1 W^T p of the rows first..last, ``rows.solved``: what impulses are to a velocity."""
    shift = rows.arrow.shift
    for i in range(len(shift)):
        shift[i] = 0.0
    apply_impulses(rows.solved, rows.body, first, last, p, rows.dof, shift)
    advance(model, q, shift, 1.0, q)
