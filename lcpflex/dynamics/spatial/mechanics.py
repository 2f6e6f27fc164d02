"""What a stepper asks of the mechanics, for a compiled spatial scene; see :mod:`lcpflex.dynamics.mechanics`."""

from __future__ import annotations

from lcpflex.contact.spatial.pairs import contact_bias, contact_rows
from lcpflex.dynamics.delassus import apply_impulses
from lcpflex.dynamics.spatial.applied_forces import applied_forces, spring_energy
from lcpflex.dynamics.spatial.body_forces import elastic_forces, inertial_forces, stored_energies, weight_forces
from lcpflex.dynamics.spatial.inertia import RowsOfSpace, SpatialWork, factorise as factorise_bodies
from lcpflex.dynamics.spatial.inertia_solve import multiply as multiply_block, solve_block, whiten
from lcpflex.jit.kernel import FloatArray, kernel, late_kernel
from lcpflex.kinematics.spatial.configuration import advance
from lcpflex.model.spatial import SpatialModel

__all__ = [
    "contact_biases",
    "displace",
    "energies",
    "factorise",
    "fill_contact_rows",
    "forces",
    "multiply",
    "solve_rows",
    "solve_vector",
    "whiten_rows",
]


@kernel
def forces(model: SpatialModel, t: float, q: FloatArray, u: FloatArray, work: SpatialWork) -> None:
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
def factorise(model: SpatialModel, q: FloatArray, alpha_c: float, alpha_k: float, work: SpatialWork) -> None:
    """Factorise M(q) + alpha_c C + alpha_k K."""
    factorise_bodies(model.bodies, q, alpha_c, alpha_k, work.rows.arrow)


@kernel
def multiply(model: SpatialModel, q: FloatArray, x: FloatArray, work: SpatialWork, out: FloatArray) -> None:
    """out = M(q) x, after ``factorise`` at the same q."""
    dof = model.bodies.dof
    for b in range(len(dof) - 1):
        multiply_block(model.bodies, work.rows.arrow, b, x[dof[b] : dof[b + 1]], out[dof[b] : dof[b + 1]])


@kernel
def solve_vector(model: SpatialModel, work: SpatialWork, x: FloatArray) -> None:
    """x <- A^-1 x for a vector over all degrees of freedom."""
    dof = model.bodies.dof
    for b in range(len(dof) - 1):
        block = x[dof[b] : dof[b + 1]]
        solve_block(model.bodies, work.rows.arrow, b, block, block)


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


@kernel
def fill_contact_rows(model: SpatialModel, q: FloatArray, n: int, n_joint: int, rows: RowsOfSpace) -> int:
    """Rows of the first n contacts of the table at q, behind the joint rows: normals, then tangents where mu > 0.

    Two tangential rows a contact, t1 and t2 = n x t1, one behind the other. Returns how many there are.
    """
    table, J, row_body = rows.table, rows.J, rows.body
    scratch = len(J) - 2
    n_tangent = 0
    for k in range(n):
        mu = model.contacts.friction[table.law[k]]
        rows.mu[k] = mu
        r = n_joint + k
        s = scratch
        if mu > 0.0:
            s = n_joint + n + n_tangent
            rows.tangent[n_tangent] = k
            rows.tangent[n_tangent + 1] = k
            n_tangent += 2
        contact_rows(model, q, table, k, J[r], J[s : s + 2])
        for i in range(2):
            b = table.body[k, i]
            row_body[r, i] = b
            row_body[s, i] = b
            row_body[s + 1, i] = b
    return n_tangent


@kernel
def contact_biases(
    model: SpatialModel, q: FloatArray, u: FloatArray, n: int, n_tangent: int, n_joint: int, rows: RowsOfSpace
) -> None:
    """bias[r] = w_N and both w_T of the contact rows laid out by ``fill_contact_rows``."""
    tangent = 0
    first = n_joint + n
    for k in range(n):
        along_n, along_t, along_w = contact_bias(model, q, u, rows.table, k)
        rows.bias[n_joint + k] = along_n
        if tangent < n_tangent and rows.tangent[tangent] == k:
            rows.bias[first + tangent] = along_t
            rows.bias[first + tangent + 1] = along_w
            tangent += 2


@kernel
def displace(model: SpatialModel, rows: RowsOfSpace, first: int, last: int, p: FloatArray, q: FloatArray) -> None:
    """q moved by A^-1 W^T p of the rows first..last, ``rows.solved``: what impulses are to a velocity."""
    shift = rows.arrow.shift
    for i in range(len(shift)):
        shift[i] = 0.0
    apply_impulses(rows.solved, rows.body, first, last, p, rows.dof, shift)
    advance(model, q, shift, 1.0, q)


@kernel
def energies(model: SpatialModel, q: FloatArray, u: FloatArray, work: SpatialWork) -> tuple[float, float, float]:
    """Kinetic, elastic (bodies) and potential (weight, springs) energy [J]."""
    kinetic, elastic, weight = stored_energies(model.bodies, model.loads, q, u, work.rows.arrow)
    return kinetic, elastic, weight + spring_energy(model, q)
