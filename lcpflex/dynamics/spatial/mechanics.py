"""What a stepper asks of the mechanics, for a compiled spatial scene; see :mod:`lcpflex.dynamics.mechanics`."""

from __future__ import annotations

from lcpflex.contact.spatial.pairs import contact_bias, contact_rows
from lcpflex.dynamics.delassus import apply_impulses
from lcpflex.dynamics.spatial.applied_forces import applied_forces, spring_energy
from lcpflex.dynamics.spatial.body_forces import elastic_forces, inertial_forces, stored_energies, weight_forces
from lcpflex.dynamics.spatial.inertia import SpatialWork, factorise as factorise_bodies
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
    bodies, spin = model.bodies, work.arrow.spin
    conservative, dissipative, driving, total = work.conservative, work.dissipative, work.driving, work.total
    inertial_forces(bodies, q, u, work.arrow, spin)
    for i in range(len(u)):
        conservative[i] = spin[i]
        dissipative[i] = 0.0
        driving[i] = 0.0
    weight_forces(bodies, model.loads, q, work.arrow, conservative)
    elastic_forces(bodies, q, u, conservative, dissipative)
    applied_forces(model, t, q, u, work.span, work.external, conservative, dissipative, driving)
    for i in range(len(u)):
        total[i] = conservative[i] + dissipative[i] + driving[i]


@kernel
def factorise(model: SpatialModel, q: FloatArray, alpha_c: float, alpha_k: float, work: SpatialWork) -> None:
    """Factorise M(q) + alpha_c C + alpha_k K."""
    factorise_bodies(model.bodies, q, alpha_c, alpha_k, work.arrow)


@kernel
def multiply(model: SpatialModel, q: FloatArray, x: FloatArray, work: SpatialWork, out: FloatArray) -> None:
    """out = M(q) x, after ``factorise`` at the same q."""
    dof = model.bodies.dof
    for b in range(len(dof) - 1):
        multiply_block(model.bodies, work.arrow, b, x[dof[b] : dof[b + 1]], out[dof[b] : dof[b + 1]])


@kernel
def solve_vector(model: SpatialModel, work: SpatialWork, x: FloatArray) -> None:
    """x <- A^-1 x for a vector over all degrees of freedom."""
    dof = model.bodies.dof
    for b in range(len(dof) - 1):
        block = x[dof[b] : dof[b + 1]]
        solve_block(model.bodies, work.arrow, b, block, block)


@kernel
def solve_rows(model: SpatialModel, work: SpatialWork, first: int, last: int) -> None:
    """solved[r] <- A^-1 rows[r] for first <= r < last."""
    rows, solved, row_body = work.rows, work.solved, work.row_body
    for r in range(first, last):
        for i in range(2):
            b = row_body[r, i]
            if b >= 0:
                solve_block(model.bodies, work.arrow, b, rows[r, i], solved[r, i])


@late_kernel
def whiten_rows(model: SpatialModel, work: SpatialWork, first: int, last: int) -> None:
    """white[r] <- L^-1 rows[r] for first <= r < last, L L^T = A."""
    for r in range(first, last):
        for i in range(2):
            b = work.row_body[r, i]
            if b >= 0:
                whiten(model.bodies, work.arrow, b, work.rows[r, i], work.white[r, i])


@kernel
def fill_contact_rows(model: SpatialModel, q: FloatArray, n: int, n_joint: int, work: SpatialWork) -> int:
    """Rows of the first n contacts of the table at q, behind the joint rows: normals, then tangents where mu > 0.

    Two tangential rows a contact, t1 and t2 = n x t1, one behind the other. Returns how many there are.
    """
    table, rows, row_body = work.table, work.rows, work.row_body
    scratch = len(rows) - 2
    n_tangent = 0
    for k in range(n):
        mu = model.contacts.friction[table.law[k]]
        work.mu[k] = mu
        r = n_joint + k
        s = scratch
        if mu > 0.0:
            s = n_joint + n + n_tangent
            work.tangent[n_tangent] = k
            work.tangent[n_tangent + 1] = k
            n_tangent += 2
        contact_rows(model, q, table, k, rows[r], rows[s : s + 2])
        for i in range(2):
            b = table.body[k, i]
            row_body[r, i] = b
            row_body[s, i] = b
            row_body[s + 1, i] = b
    return n_tangent


@kernel
def contact_biases(
    model: SpatialModel, q: FloatArray, u: FloatArray, n: int, n_tangent: int, n_joint: int, work: SpatialWork
) -> None:
    """bias[r] = w_N and both w_T of the contact rows laid out by ``fill_contact_rows``."""
    tangent = 0
    first = n_joint + n
    for k in range(n):
        along_n, along_t, along_w = contact_bias(model, q, u, work.table, k)
        work.bias[n_joint + k] = along_n
        if tangent < n_tangent and work.tangent[tangent] == k:
            work.bias[first + tangent] = along_t
            work.bias[first + tangent + 1] = along_w
            tangent += 2


@kernel
def displace(model: SpatialModel, work: SpatialWork, first: int, last: int, p: FloatArray, q: FloatArray) -> None:
    """q moved by A^-1 W^T p of the rows first..last, ``work.solved``: what impulses are to a velocity."""
    shift = work.arrow.shift
    for i in range(len(shift)):
        shift[i] = 0.0
    apply_impulses(work.solved, work.row_body, first, last, p, work.dof, shift)
    advance(model, q, shift, 1.0, q)


@kernel
def energies(model: SpatialModel, q: FloatArray, u: FloatArray, work: SpatialWork) -> tuple[float, float, float]:
    """Kinetic, elastic (bodies) and potential (weight, springs) energy [J]."""
    kinetic, elastic, weight = stored_energies(model.bodies, model.loads, q, u, work.arrow)
    return kinetic, elastic, weight + spring_energy(model, q)
