"""Forces and energies of bodies by themselves: inertia, weight, stiffness and damping."""

from __future__ import annotations

import math

from lcpflex.dynamics.inertia import Arrow, add_row_product, couple_modes, deformed_moments, stiffened
from lcpflex.dynamics.shortening import shortening_energy, shortening_forces, shortens
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.jit.leaf import in_space
from lcpflex.model.arrays import Bodies, Loads
from lcpflex.model.planar import N_RIGID

__all__ = ["elastic_forces", "inertial_forces", "stored_energies"]


@kernel
def inertial_forces(bodies: Bodies, loads: Loads, q: FloatArray, u: FloatArray, force: FloatArray) -> None:
    """force += centrifugal, Coriolis and weight forces of every body.

    h_R = A(omega^2 (s0 + S q) - 2 omega J S qdot) + m g,
    h_theta = -2 omega (a + q - G q).qdot + B(s0 + S q)^T A^T g,
    h_f = omega^2 (a + q - G q) + 2 omega D qdot + S^T A^T g
    """
    for b in range(len(bodies.mass)):
        d = bodies.dof[b]
        first = d - N_RIGID * b
        n = bodies.dof[b + 1] - d - N_RIGID
        omega = u[d + 2]
        cos = math.cos(q[d + 2])
        sin = math.sin(q[d + 2])
        gx = cos * loads.gravity[0] + sin * loads.gravity[1]
        gy = -sin * loads.gravity[0] + cos * loads.gravity[1]
        sx, sy, _ = deformed_moments(bodies, q, b)
        rx = omega * omega * sx
        ry = omega * omega * sy
        torque = sx * gy - sy * gx
        for k in range(n):
            rate = u[d + N_RIGID + k]
            arm = bodies.a[first + k] + q[d + N_RIGID + k]
            ex = bodies.S[first + k, 0]
            ey = bodies.S[first + k, 1]
            rx += 2.0 * omega * ey * rate
            ry -= 2.0 * omega * ex * rate
            torque -= 2.0 * omega * arm * rate
            force[d + N_RIGID + k] += omega * omega * arm + ex * gx + ey * gy
        start = bodies.coupling_start[b]
        if bodies.coupling_start[b + 1] > start and omega != 0.0:
            # D u = -(u^T D): D is skew
            matrix = bodies.coupling[start : start + n * n]
            add_row_product(
                u[d + N_RIGID : d + N_RIGID + n], matrix, -2.0 * omega, force[d + N_RIGID : d + N_RIGID + n]
            )
        start = bodies.geometric_start[b]
        if bodies.geometric_start[b + 1] > start and omega != 0.0:
            modal = q[d + N_RIGID : d + N_RIGID + n]
            torque += 2.0 * omega * stiffened(bodies, b, modal, u[d + N_RIGID : d + N_RIGID + n])
            matrix = bodies.geometric[start : start + n * n]
            add_row_product(modal, matrix, -omega * omega, force[d + N_RIGID : d + N_RIGID + n])
        force[d] += cos * rx - sin * ry + bodies.mass[b] * loads.gravity[0]
        force[d + 1] += sin * rx + cos * ry + bodies.mass[b] * loads.gravity[1]
        force[d + 2] += torque


@kernel
def elastic_forces(
    bodies: Bodies, q: FloatArray, u: FloatArray, conservative: FloatArray, dissipative: FloatArray
) -> None:
    """conservative -= dV/dq and dissipative -= C u, modal, every body (C with its off-diagonal part).

    V = q^T K q / 2, with what axial forces do to bending where a body has that.
    """
    for b in range(len(bodies.mass)):
        d = bodies.dof[b]
        first = d - N_RIGID * b
        n = bodies.dof[b + 1] - d - N_RIGID
        for k in range(n):
            conservative[d + N_RIGID + k] -= bodies.stiffness[first + k] * q[d + N_RIGID + k]
            dissipative[d + N_RIGID + k] -= bodies.damping[first + k] * u[d + N_RIGID + k]
        if shortens(bodies, b):
            shortening_forces(bodies, b, q[d + N_RIGID : d + N_RIGID + n], conservative[d + N_RIGID : d + N_RIGID + n])
        start = bodies.cross_damping_start[b]
        if bodies.cross_damping_start[b + 1] > start:
            # C u = u^T C: C is symmetric
            matrix = bodies.cross_damping[start : start + n * n]
            add_row_product(u[d + N_RIGID : d + N_RIGID + n], matrix, -1.0, dissipative[d + N_RIGID : d + N_RIGID + n])


@in_space("lcpflex.dynamics.spatial.body_forces")
@kernel
def stored_energies(
    bodies: Bodies, loads: Loads, q: FloatArray, u: FloatArray, work: Arrow
) -> tuple[float, float, float]:
    """Kinetic, elastic (modal) and weight energy of all bodies [J]; overwrites ``work.couple``."""
    kinetic = 0.0
    elastic = 0.0
    weight = 0.0
    for b in range(len(bodies.mass)):
        d = bodies.dof[b]
        first = d - N_RIGID * b
        couple_modes(bodies, q, b, work)
        sx, sy, inertia = deformed_moments(bodies, q, b)
        cos = math.cos(q[d + 2])
        sin = math.sin(q[d + 2])
        wx = cos * sx - sin * sy
        wy = sin * sx + cos * sy
        vx = u[d]
        vy = u[d + 1]
        omega = u[d + 2]
        mass = bodies.mass[b]
        kinetic += 0.5 * mass * (vx * vx + vy * vy) + omega * (wx * vy - wy * vx) + 0.5 * inertia * omega * omega
        for k in range(bodies.dof[b + 1] - d - N_RIGID):
            rate = u[d + N_RIGID + k]
            row = work.couple[first + k]
            kinetic += rate * (row[0] * vx + row[1] * vy + row[2] * omega + 0.5 * rate)
            elastic += 0.5 * bodies.stiffness[first + k] * q[d + N_RIGID + k] ** 2
        if shortens(bodies, b):
            elastic += shortening_energy(bodies, b, q[d + N_RIGID : bodies.dof[b + 1]])
        weight -= loads.gravity[0] * (mass * q[d] + wx) + loads.gravity[1] * (mass * q[d + 1] + wy)
    return kinetic, elastic, weight
