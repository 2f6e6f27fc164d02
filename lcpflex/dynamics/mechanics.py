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
from lcpflex.dynamics.rows import Rows
from lcpflex.dynamics.whitening import whiten_rows as whiten
from lcpflex.dynamics.workspace import Workspace
from lcpflex.jit.kernel import FloatArray, kernel, late_kernel
from lcpflex.jit.leaf import in_space
from lcpflex.kinematics.joint_rows import joint_rows
from lcpflex.model.arrays import Model
from lcpflex.model.planar import N_RIGID

__all__ = [
    "contact_biases",
    "count_rows",
    "displace",
    "energies",
    "fill_contact_rows",
    "fill_joint_rows",
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
    """Fill ``work.free.external`` from Python callbacks at time t: none in a compiled loop."""


@in_space("lcpflex.dynamics.spatial.mechanics")
@kernel
def forces(model: Model, t: float, q: FloatArray, u: FloatArray, work: Workspace) -> None:
    """All generalised forces but constraint ones: by kind in conservative, dissipative, driving; their sum in total."""
    free = work.free
    n = len(q)
    for i in range(n):
        free.conservative[i] = 0.0
        free.dissipative[i] = 0.0
        free.driving[i] = 0.0
    inertial_forces(model.bodies, model.loads, q, u, free.conservative)
    elastic_forces(model.bodies, q, u, free.conservative, free.dissipative)
    applied_forces(model, t, q, u, free.span, free.external, free.conservative, free.dissipative, free.driving)
    for i in range(n):
        free.total[i] = free.conservative[i] + free.dissipative[i] + free.driving[i]


@kernel
def factorise(model: Model, q: FloatArray, alpha_c: float, alpha_k: float, work: Workspace) -> None:
    """Factorise M(q) + alpha_c C + alpha_k K."""
    factorise_bodies(model.bodies, q, alpha_c, alpha_k, work.rows.arrow)


@in_space("lcpflex.dynamics.spatial.mechanics")
@kernel
def multiply(model: Model, q: FloatArray, x: FloatArray, work: Workspace, out: FloatArray) -> None:
    """out = M(q) x, after ``factorise`` at the same q."""
    multiply_bodies(model.bodies, q, x, work.rows.arrow, out)


@kernel
def solve_vector(model: Model, work: Workspace, x: FloatArray) -> None:
    """x <- A^-1 x for a vector over all degrees of freedom."""
    dof = model.bodies.dof
    for b in range(len(dof) - 1):
        block = x[dof[b] : dof[b + 1]]
        solve_block(model.bodies, work.rows.arrow, b, block, block)


@in_space("lcpflex.dynamics.spatial.mechanics")
@kernel
def solve_rows(model: Model, rows: Rows, first: int, last: int) -> None:
    """solved[r] <- A^-1 rows[r] for first <= r < last."""
    J, solved, row_body, dof = rows.J, rows.solved, rows.body, model.bodies.dof
    for r in range(first, last):
        for i in range(2):
            b = row_body[r, i]
            if b < 0:
                continue
            if dof[b + 1] - dof[b] > N_RIGID:
                solve_block(model.bodies, rows.arrow, b, J[r, i], solved[r, i])
            else:
                x, y, t = solve_rigid(rows.arrow, b, J[r, i, 0], J[r, i, 1], J[r, i, 2])
                solved[r, i, 0] = x
                solved[r, i, 1] = y
                solved[r, i, 2] = t


@in_space("lcpflex.dynamics.spatial.mechanics")
@late_kernel
def whiten_rows(model: Model, rows: Rows, first: int, last: int) -> None:
    """white[r] <- L^-1 rows[r] for first <= r < last, L L^T = A."""
    whiten(model.bodies, rows.arrow, rows.J, rows.body, first, last, rows.white)


@kernel
def fill_joint_rows(model: Model, t: float, q: FloatArray, u: FloatArray, external: FloatArray, rows: Rows) -> None:
    """Rows of all joints at (q, u) and time t, which come first, their rates, biases and wrenches."""
    joint_rows(model, t, q, u, external, rows.J, rows.body, rows.wrench, rows.rate, rows.bias)


@kernel
def fill_contact_rows(model: Model, q: FloatArray, n: int, n_joint: int, rows: Rows) -> int:
    """Rows of the first n contacts of the table at q, behind the joint rows: normals, then tangents where mu > 0.

    In space two tangential rows a contact, t1 and t2 = n x t1, one behind the other. Returns how many there are.
    """
    table, row_body, across = rows.table, rows.body, rows.across
    scratch = len(rows.J) - across
    n_tangent = 0
    for k in range(n):
        mu = model.contacts.friction[table.law[k]]
        rows.mu[k] = mu
        r = n_joint + k
        s = scratch
        if mu > 0.0:
            s = n_joint + n + n_tangent
            for t in range(across):
                rows.tangent[n_tangent + t] = k
            n_tangent += across
        end = s if across == 2 and mu == 0.0 else s + across  # in space only those that there are
        contact_rows(model, q, table, k, rows.J[r], rows.J[s:end])
        for i in range(2):
            b = table.body[k, i]
            row_body[r, i] = b
            for t in range(across):
                row_body[s + t, i] = b
    return n_tangent


@kernel
def count_rows(rows: Rows, n_joint: int, n_contacts: int, n_tangents: int) -> None:
    """Say how many rows there are of each kind: those of what has been filled in."""
    rows.n_joint = n_joint
    rows.n_contacts = n_contacts
    rows.n_tangents = n_tangents


@kernel
def contact_biases(
    model: Model, q: FloatArray, u: FloatArray, n: int, n_tangent: int, n_joint: int, rows: Rows
) -> None:
    """bias[r] = w_N and w_T of the contact rows laid out by ``fill_contact_rows``."""
    tangent = 0
    for k in range(n):
        bias = contact_bias(model, q, u, rows.table, k)
        rows.bias[n_joint + k] = bias[0]
        if tangent < n_tangent and rows.tangent[tangent] == k:
            for t in range(rows.across):
                rows.bias[n_joint + n + tangent + t] = bias[1 + t]
            tangent += rows.across


@in_space("lcpflex.dynamics.spatial.mechanics")
@kernel
def displace(model: Model, rows: Rows, first: int, last: int, p: FloatArray, q: FloatArray) -> None:
    """q moved by A^-1 W^T p of the rows first..last, ``rows.solved``: what impulses are to a velocity."""
    apply_impulses(rows.solved, rows.body, first, last, p, rows.dof, q)


@kernel
def energies(model: Model, q: FloatArray, u: FloatArray, work: Workspace) -> tuple[float, float, float]:
    """Kinetic, elastic (bodies) and potential (weight, springs) energy [J]."""
    kinetic, elastic, weight = stored_energies(model.bodies, model.loads, q, u, work.rows.arrow)
    return kinetic, elastic, weight + spring_energy(model, q)
