"""Axial force of bodies that get shorter as they bend: one potential of axial modes a and bending modes b,

    V = 1/2 sum_a omega_a^2 z_a^2 + 1/2 sum_b omega_b^2 q_b^2,    z_a = q_a + 1/2 q_b^T G_a q_b

so that N = E A sum_a z_a u_a' is the axial force and V holds 1/2 N w'^2: von Karman's strain u' + w'^2 / 2, taken in
the space of the axial modes (an assumed strain: what they cannot follow neither locks nor softens). With p_a = G_a q_b,

    dV/dq_a = omega_a^2 z_a,    dV/dq_b = omega_b^2 q_b + sum_a omega_a^2 z_a p_a
    d2V/dq_a dq_b = omega_a^2 p_a,    d2V/dq_b dq_b = diag(omega_b^2) + sum_a omega_a^2 (p_a p_a^T + z_a G_a)

Linear springs, in diag(omega^2), are the business of :mod:`lcpflex.dynamics.inertia`; here is what comes on top.
Sources: von Karman 1910 (strain); Simo & Hughes 1986 (assumed strains).
"""

from __future__ import annotations

from lcpflex.jit.kernel import FloatArray, kernel, late_kernel
from lcpflex.model.arrays import Bodies
from lcpflex.model.planar import N_RIGID
from lcpflex.solvers.semidefinite import cholesky

__all__ = ["add_tangent", "factorise_tangent", "shortening_energy", "shortening_forces", "shortens"]


@kernel
def shortens(bodies: Bodies, b: int) -> bool:
    """Whether body b gets shorter as it bends."""
    return bodies.shortening_start[b + 1] > bodies.shortening_start[b]


@kernel
def slope_product(bodies: Bodies, b: int, modal: FloatArray, i: int, row: int) -> float:
    """Entry ``row`` of p_a = G_a q_b, for the i-th axial mode of body b."""
    first = bodies.bending_start[b]
    k = bodies.bending_start[b + 1] - first
    start = bodies.shortening_start[b] + (i * k + row) * k
    total = 0.0
    for j in range(k):
        total += bodies.shortening[start + j] * modal[bodies.bending_mode[first + j]]
    return total


@kernel
def shortened(bodies: Bodies, b: int, modal: FloatArray, i: int) -> float:
    """q_b^T G_a q_b / 2, for the i-th axial mode of body b."""
    first = bodies.bending_start[b]
    k = bodies.bending_start[b + 1] - first
    start = bodies.shortening_start[b] + i * k * k
    total = 0.0
    for row in range(k):
        part = 0.5 * bodies.shortening[start + row * k + row] * modal[bodies.bending_mode[first + row]]
        for j in range(row):
            part += bodies.shortening[start + row * k + j] * modal[bodies.bending_mode[first + j]]
        total += part * modal[bodies.bending_mode[first + row]]
    return total


@late_kernel
def shortening_forces(bodies: Bodies, b: int, modal: FloatArray, force: FloatArray) -> None:
    """force -= gradient of V without its linear springs, of body b with ``modal`` (n,) and ``force`` (n,)."""
    first = bodies.axial_start[b]
    bends = bodies.bending_start[b]
    for i in range(bodies.axial_start[b + 1] - first):
        a = bodies.axial_mode[first + i]
        omega2 = bodies.stiffness[bodies.dof[b] - N_RIGID * b + a]
        g = shortened(bodies, b, modal, i)
        force[a] -= omega2 * g
        pull = omega2 * (modal[a] + g)
        for row in range(bodies.bending_start[b + 1] - bends):
            force[bodies.bending_mode[bends + row]] -= pull * slope_product(bodies, b, modal, i, row)


@late_kernel
def shortening_energy(bodies: Bodies, b: int, modal: FloatArray) -> float:
    """V of body b without its linear springs [J]: the sum of omega_a^2 (z_a^2 - q_a^2) / 2."""
    first = bodies.axial_start[b]
    total = 0.0
    for i in range(bodies.axial_start[b + 1] - first):
        a = bodies.axial_mode[first + i]
        g = shortened(bodies, b, modal, i)
        total += bodies.stiffness[bodies.dof[b] - N_RIGID * b + a] * g * (modal[a] + 0.5 * g)
    return total


@kernel
def add_tangent(bodies: Bodies, b: int, modal: FloatArray, scale: float, with_force: bool, matrix: FloatArray) -> None:
    """matrix (n, n) += scale times the second derivatives of V without its linear springs.

    ``with_force`` False leaves out z_a G_a, with which compression may make them negative. Entries of axial with
    bending modes must be 0 before.
    """
    first = bodies.axial_start[b]
    bends = bodies.bending_start[b]
    k = bodies.bending_start[b + 1] - bends
    for i in range(bodies.axial_start[b + 1] - first):
        a = bodies.axial_mode[first + i]
        stiff = scale * bodies.stiffness[bodies.dof[b] - N_RIGID * b + a]
        pull = stiff * (modal[a] + shortened(bodies, b, modal, i)) if with_force else 0.0
        start = bodies.shortening_start[b] + i * k * k
        for row in range(k):
            r = bodies.bending_mode[bends + row]
            slope = slope_product(bodies, b, modal, i, row)
            matrix[a, r] = stiff * slope
            matrix[r, a] = stiff * slope
            for j in range(row + 1):
                c = bodies.bending_mode[bends + j]
                added = matrix[a, c] * slope + pull * bodies.shortening[start + row * k + j]
                matrix[r, c] += added
                if j < row:
                    matrix[c, r] += added


@kernel
def factorise_tangent(
    bodies: Bodies, b: int, modal: FloatArray, scale: float, inverse: FloatArray, matrix: FloatArray
) -> bool:
    """matrix (n, n) <- lower Cholesky factor of diag(1 / inverse) + scale d2V/dq2; False where it has none.

    V without its linear springs, which are in the diagonal. Where compression leaves it indefinite, z_a G_a is left
    out: an iteration takes longer then, and a step treats the axial force as it does any other.
    """
    n = len(modal)
    for trial in range(2):
        matrix[:, :] = 0.0
        for k in range(n):
            matrix[k, k] = 1.0 / inverse[k]
        add_tangent(bodies, b, modal, scale, trial == 0, matrix)
        cholesky(matrix, n, matrix)
        positive = True
        for k in range(n):
            positive = positive and matrix[k, k] > 0.0
        if positive:
            return True
    return False
