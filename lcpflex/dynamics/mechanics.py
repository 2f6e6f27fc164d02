"""What a stepper asks of the mechanics, for a compiled scene.

A user's own system answers the same questions in Python (:mod:`lcpflex.dynamics.user_system`): forces, factorise,
multiply, solve_vector, solve_rows, whiten_rows, contact and joint rows, energies.
"""

from __future__ import annotations

from lcpflex.contact.narrow_phase.feature import contact_bias
from lcpflex.contact.rows import contact_rows
from lcpflex.dynamics.applied_forces import applied_forces, spring_energy
from lcpflex.dynamics.body_forces import elastic_forces, inertial_forces, stored_energies
from lcpflex.dynamics.delassus import apply_impulses
from lcpflex.dynamics.inertia import (
    factorise as factorise_bodies,
    multiply as multiply_bodies,
    solve_block,
    solve_rigid,
)
from lcpflex.dynamics.whitening import whiten_rows as whiten
from lcpflex.dynamics.workspace import Rows, Workspace
from lcpflex.jit.kernel import FloatArray, kernel, late_kernel
from lcpflex.jit.leaf import in_space
from lcpflex.model.arrays import Model
from lcpflex.model.planar import N_RIGID

__all__ = [
    "contact_biases",
    "displace",
    "energies",
    "fill_contact_rows",
    "forces",
    "factorise",
    "multiply",
    "solve_rows",
    "solve_vector",
    "supply",
    "whiten_rows",
]


@kernel
def supply(model: Model, t: float, q: FloatArray, u: FloatArray, work: Workspace) -> None:
    """Fill ``work.external`` from Python callbacks at time t: none in a compiled loop."""


@in_space("lcpflex.dynamics.spatial.mechanics")
@kernel
def forces(model: Model, t: float, q: FloatArray, u: FloatArray, work: Workspace) -> None:
    """All generalised forces but constraint ones: by kind in conservative, dissipative, driving; their sum in total."""
    n = len(q)
    for i in range(n):
        work.conservative[i] = 0.0
        work.dissipative[i] = 0.0
        work.driving[i] = 0.0
    inertial_forces(model.bodies, model.loads, q, u, work.conservative)
    elastic_forces(model.bodies, q, u, work.conservative, work.dissipative)
    applied_forces(model, t, q, u, work.span, work.external, work.conservative, work.dissipative, work.driving)
    for i in range(n):
        work.total[i] = work.conservative[i] + work.dissipative[i] + work.driving[i]


@in_space("lcpflex.dynamics.spatial.mechanics")
@kernel
def factorise(model: Model, q: FloatArray, alpha_c: float, alpha_k: float, work: Workspace) -> None:
    """Factorise M(q) + alpha_c C + alpha_k K."""
    factorise_bodies(model.bodies, q, alpha_c, alpha_k, work.arrow)


@in_space("lcpflex.dynamics.spatial.mechanics")
@kernel
def multiply(model: Model, q: FloatArray, x: FloatArray, work: Workspace, out: FloatArray) -> None:
    """out = M(q) x, after ``factorise`` at the same q."""
    multiply_bodies(model.bodies, q, x, work.arrow, out)


@in_space("lcpflex.dynamics.spatial.mechanics")
@kernel
def solve_vector(model: Model, work: Workspace, x: FloatArray) -> None:
    """x <- A^-1 x for a vector over all degrees of freedom."""
    dof = model.bodies.dof
    for b in range(len(dof) - 1):
        block = x[dof[b] : dof[b + 1]]
        solve_block(model.bodies, work.arrow, b, block, block)


@in_space("lcpflex.dynamics.spatial.mechanics")
@kernel
def solve_rows(model: Model, work: Rows, first: int, last: int) -> None:
    """solved[r] <- A^-1 rows[r] for first <= r < last."""
    rows, solved, row_body, dof = work.rows, work.solved, work.row_body, model.bodies.dof
    for r in range(first, last):
        for i in range(2):
            b = row_body[r, i]
            if b < 0:
                continue
            if dof[b + 1] - dof[b] > N_RIGID:
                solve_block(model.bodies, work.arrow, b, rows[r, i], solved[r, i])
            else:
                x, y, t = solve_rigid(work.arrow, b, rows[r, i, 0], rows[r, i, 1], rows[r, i, 2])
                solved[r, i, 0] = x
                solved[r, i, 1] = y
                solved[r, i, 2] = t


@in_space("lcpflex.dynamics.spatial.mechanics")
@late_kernel
def whiten_rows(model: Model, work: Workspace, first: int, last: int) -> None:
    """white[r] <- L^-1 rows[r] for first <= r < last, L L^T = A."""
    whiten(model.bodies, work.arrow, work.rows, work.row_body, first, last, work.white)


@in_space("lcpflex.dynamics.spatial.mechanics")
@kernel
def fill_contact_rows(model: Model, q: FloatArray, n: int, n_joint: int, work: Rows) -> int:
    """Rows of the first n contacts of the table at q, behind the joint rows: normals, then tangents where mu > 0.

    Returns the number of tangential rows.
    """
    table = work.table
    scratch = len(work.rows) - 1
    n_tangent = 0
    for k in range(n):
        mu = model.contacts.friction[table.law[k]]
        work.mu[k] = mu
        r = n_joint + k
        s = scratch
        if mu > 0.0:
            s = n_joint + n + n_tangent
            work.tangent[n_tangent] = k
            n_tangent += 1
        contact_rows(model, q, table, k, work.rows[r], work.rows[s : s + 1])
        for i in range(2):
            work.row_body[r, i] = table.body[k, i]
            work.row_body[s, i] = table.body[k, i]
    return n_tangent


@in_space("lcpflex.dynamics.spatial.mechanics")
@kernel
def contact_biases(
    model: Model, q: FloatArray, u: FloatArray, n: int, n_tangent: int, n_joint: int, work: Workspace
) -> None:
    """bias[r] = w_N and w_T of the contact rows laid out by ``fill_contact_rows``."""
    tangent = 0
    for k in range(n):
        w_n, w_t = contact_bias(model, q, u, work.table, k)
        work.bias[n_joint + k] = w_n
        if tangent < n_tangent and work.tangent[tangent] == k:
            work.bias[n_joint + n + tangent] = w_t
            tangent += 1


@in_space("lcpflex.dynamics.spatial.mechanics")
@kernel
def displace(model: Model, work: Workspace, first: int, last: int, p: FloatArray, q: FloatArray) -> None:
    """q moved by A^-1 W^T p of the rows first..last, ``work.solved``: what impulses are to a velocity."""
    apply_impulses(work.solved, work.row_body, first, last, p, work.dof, q)


@in_space("lcpflex.dynamics.spatial.mechanics")
@kernel
def energies(model: Model, q: FloatArray, u: FloatArray, work: Workspace) -> tuple[float, float, float]:
    """Kinetic, elastic (bodies) and potential (weight, springs) energy [J]."""
    kinetic, elastic, weight = stored_energies(model.bodies, model.loads, q, u, work.arrow)
    return kinetic, elastic, weight + spring_energy(model, q)
