"""Forces, energies and momenta of spatial bodies by themselves: inertia, weight, stiffness and damping."""

from __future__ import annotations

from lcpflex.dynamics.inertia import add_row_product
from lcpflex.dynamics.spatial.inertia import PARTS, SpatialArrow, add_products, deform, spin_stiffens, symmetric
from lcpflex.jit.kernel import FloatArray, kernel, late_kernel
from lcpflex.kinematics.spatial.rotations import (
    Vector,
    cross,
    rotation_matrix,
    transform,
    transform_back,
)
from lcpflex.model.spatial import N_PLACE, N_RIGID, SpatialBodies, SpatialLoads

__all__ = ["elastic_forces", "inertial_forces", "momenta", "stored_energies", "weight_forces"]


@kernel
def inertial_forces(bodies: SpatialBodies, q: FloatArray, u: FloatArray, work: SpatialArrow, force: FloatArray) -> None:
    """force = centrifugal and Coriolis forces of every body.

    h_R = -A(omega x (omega x d) + 2 omega x S etadot),
    h_theta = -omega x (J omega + C etadot) - Jdot omega,   Jdot = 2 tr(Q) I - Q - Q^T,   Q = sum_k etadot_k Y_k,
    h_k = |omega|^2 tr Y_k - omega.Y_k omega - 2 sum_l etadot_l omega.<Phi_l x Phi_k>

    and for what spin stiffens (J has its part of it) h_k -= sum_ij omega_i omega_j (G_ij eta)_k, and of Jdot_ij
    -2 etadot.G_ij eta.
    """
    for b in range(len(bodies.mass)):
        if bodies.dof[b + 1] - bodies.dof[b] > N_RIGID:
            flexible_inertia(bodies, q, u, b, work, force)
        else:
            rigid_inertia(bodies, q, u, b, work, force)


@kernel
def rigid_inertia(
    bodies: SpatialBodies, q: FloatArray, u: FloatArray, b: int, work: SpatialArrow, force: FloatArray
) -> None:
    """That of a body without modes."""
    d = bodies.dof[b]
    omega = u[d + 3], u[d + 4], u[d + 5]
    tx, ty, tz = cross(symmetric(work.inertia, b, omega[0], omega[1], omega[2]), omega)
    x, y, z = 0.0, 0.0, 0.0
    if bodies.centred[b] == 0:
        arm = work.arm[b, 0], work.arm[b, 1], work.arm[b, 2]
        x, y, z = out_of_body(bodies, q, b, cross(omega, cross(arm, omega)))
    force[d], force[d + 1], force[d + 2] = x, y, z
    force[d + 3], force[d + 4], force[d + 5] = tx, ty, tz


@kernel
def flexible_inertia(
    bodies: SpatialBodies, q: FloatArray, u: FloatArray, b: int, work: SpatialArrow, force: FloatArray
) -> None:
    """That of a body with modes."""
    deform(bodies, q, b, work)
    d = bodies.dof[b]
    first = d - N_RIGID * b
    n = bodies.dof[b + 1] - d - N_RIGID
    ox, oy, oz = u[d + 3], u[d + 4], u[d + 5]
    turn_modes(bodies, u, b, work, force)
    S, Y = bodies.S, work.moments
    xx, yy, zz, xy, yx, yz, zy, zx, xz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    sx, sy, sz = 0.0, 0.0, 0.0
    square = ox * ox + oy * oy + oz * oz
    for k in range(n):
        m = first + k
        o = 9 * m
        rate = u[d + N_RIGID + k]
        sx += S[m, 0] * rate
        sy += S[m, 1] * rate
        sz += S[m, 2] * rate
        a, e, i = Y[o], Y[o + 4], Y[o + 8]
        xx += rate * a
        yy += rate * e
        zz += rate * i
        xy += rate * Y[o + 1]
        yx += rate * Y[o + 3]
        yz += rate * Y[o + 5]
        zy += rate * Y[o + 7]
        zx += rate * Y[o + 6]
        xz += rate * Y[o + 2]
        along = ox * ox * a + oy * oy * e + oz * oz * i
        across = ox * oy * (Y[o + 1] + Y[o + 3]) + oy * oz * (Y[o + 5] + Y[o + 7]) + oz * ox * (Y[o + 6] + Y[o + 2])
        force[d + N_RIGID + k] += square * (a + e + i) - along - across
    px, py, pz = symmetric(work.inertia, b, ox, oy, oz)
    omega = ox, oy, oz
    tx, ty, tz = cross((px + yz - zy, py + zx - xz, pz + xy - yx), omega)
    tx -= 2.0 * (yy + zz) * ox - (xy + yx) * oy - (zx + xz) * oz
    ty -= 2.0 * (zz + xx) * oy - (yz + zy) * oz - (xy + yx) * ox
    tz -= 2.0 * (xx + yy) * oz - (zx + xz) * ox - (yz + zy) * oy
    if spin_stiffens(bodies, b):
        more_x, more_y, more_z = resist_spin(bodies, u, b, work, force)
        tx, ty, tz = tx + more_x, ty + more_y, tz + more_z
    arm = work.arm[b, 0], work.arm[b, 1], work.arm[b, 2]
    fx, fy, fz = cross((2.0 * sx, 2.0 * sy, 2.0 * sz), omega)
    gx, gy, gz = cross(omega, cross(arm, omega))
    fx, fy, fz = out_of_body(bodies, q, b, (fx + gx, fy + gy, fz + gz))
    force[d], force[d + 1], force[d + 2] = fx, fy, fz
    force[d + 3], force[d + 4], force[d + 5] = tx, ty, tz


@late_kernel
def resist_spin(
    bodies: SpatialBodies, u: FloatArray, b: int, work: SpatialArrow, force: FloatArray
) -> tuple[float, float, float]:
    """The modal entries of force -= sum_ij omega_i omega_j G_ij eta; returns the torque, 2 etadot.G_ij eta omega_j."""
    d = bodies.dof[b]
    first = d - N_RIGID * b
    x, y, z = u[d + 3], u[d + 4], u[d + 5]
    xx, yy, zz, yz, zx, xy = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    pull = work.pull
    for k in range(bodies.dof[b + 1] - d - N_RIGID):
        o = PARTS * (first + k)
        own = x * x * pull[o] + y * y * pull[o + 1] + z * z * pull[o + 2]
        mixed = y * z * pull[o + 3] + z * x * pull[o + 4] + x * y * pull[o + 5]
        force[d + N_RIGID + k] -= own + 2.0 * mixed
        rate = 2.0 * u[d + N_RIGID + k]
        xx += rate * pull[o]
        yy += rate * pull[o + 1]
        zz += rate * pull[o + 2]
        yz += rate * pull[o + 3]
        zx += rate * pull[o + 4]
        xy += rate * pull[o + 5]
    return xx * x + xy * y + zx * z, xy * x + yy * y + yz * z, zx * x + yz * y + zz * z


@kernel
def turn_modes(bodies: SpatialBodies, u: FloatArray, b: int, work: SpatialArrow, force: FloatArray) -> None:
    """The modal entries of force = -2 sum_l etadot_l omega.<Phi_l x Phi_k>.

    It has no power and does not enter momenta: neither would tell that it is wrong.
    """
    d = bodies.dof[b]
    first = d - N_RIGID * b
    n2 = bodies.second_modes[b]
    ox, oy, oz = -2.0 * u[d + 3], -2.0 * u[d + 4], -2.0 * u[d + 5]
    for k in range(d + N_RIGID, bodies.dof[b + 1]):
        force[k] = 0.0
    if n2 == 0 or (ox == 0.0 and oy == 0.0 and oz == 0.0):
        return
    W = work.swing[9 * first : 9 * (first + n2)]
    for k in range(len(W)):
        W[k] = 0.0
    start = bodies.products_start[b]
    add_products(bodies.products[start : start + 9 * n2 * n2], u[d + N_RIGID : d + N_RIGID + n2], W)
    for k in range(n2):
        o = 9 * k
        turned = ox * (W[o + 5] - W[o + 7]) + oy * (W[o + 6] - W[o + 2]) + oz * (W[o + 1] - W[o + 3])
        force[d + N_RIGID + k] = turned


@kernel
def into_body(bodies: SpatialBodies, q: FloatArray, b: int, v: Vector) -> Vector:
    """A^T v of body b at q."""
    i = bodies.place[b]
    return transform_back(rotation_matrix(q[i + 3], q[i + 4], q[i + 5], q[i + 6]), v[0], v[1], v[2])


@kernel
def out_of_body(bodies: SpatialBodies, q: FloatArray, b: int, v: Vector) -> Vector:
    """A v of body b at q."""
    i = bodies.place[b]
    return transform(rotation_matrix(q[i + 3], q[i + 4], q[i + 5], q[i + 6]), v[0], v[1], v[2])


@kernel
def weight_forces(
    bodies: SpatialBodies, loads: SpatialLoads, q: FloatArray, work: SpatialArrow, force: FloatArray
) -> None:
    """force += the weight of every body: m g, d x A^T g, S^T A^T g."""
    g = loads.gravity[0], loads.gravity[1], loads.gravity[2]
    for b in range(len(bodies.mass)):
        d = bodies.dof[b]
        for i in range(3):
            force[d + i] += bodies.mass[b] * loads.gravity[i]
        if bodies.centred[b] != 0:
            continue
        deform(bodies, q, b, work)
        x, y, z = into_body(bodies, q, b, g)
        tx, ty, tz = cross((work.arm[b, 0], work.arm[b, 1], work.arm[b, 2]), (x, y, z))
        force[d + 3] += tx
        force[d + 4] += ty
        force[d + 5] += tz
        first = d - N_RIGID * b
        for k in range(bodies.dof[b + 1] - d - N_RIGID):
            m = first + k
            force[d + N_RIGID + k] += bodies.S[m, 0] * x + bodies.S[m, 1] * y + bodies.S[m, 2] * z


@kernel
def elastic_forces(
    bodies: SpatialBodies, q: FloatArray, u: FloatArray, conservative: FloatArray, dissipative: FloatArray
) -> None:
    """conservative -= K eta and dissipative -= C etadot, every body (C with its off-diagonal part)."""
    for b in range(len(bodies.mass)):
        d = bodies.dof[b] + N_RIGID
        e = bodies.place[b] + N_PLACE
        first = d - N_RIGID * (b + 1)
        n = bodies.dof[b + 1] - d
        for k in range(n):
            conservative[d + k] -= bodies.stiffness[first + k] * q[e + k]
            dissipative[d + k] -= bodies.damping[first + k] * u[d + k]
        start = bodies.cross_damping_start[b]
        if bodies.cross_damping_start[b + 1] > start:
            # C u = u^T C: C is symmetric
            matrix = bodies.cross_damping[start : start + n * n]
            add_row_product(u[d : d + n], matrix, -1.0, dissipative[d : d + n])


@kernel
def momentum(bodies: SpatialBodies, q: FloatArray, u: FloatArray, b: int, work: SpatialArrow) -> tuple[Vector, Vector]:
    """Linear momentum of body b and its angular momentum about the origin of its frame, both in body axes."""
    deform(bodies, q, b, work)
    d = bodies.dof[b]
    first = d - N_RIGID * b
    mass = bodies.mass[b]
    arm = work.arm[b, 0], work.arm[b, 1], work.arm[b, 2]
    v = into_body(bodies, q, b, (u[d], u[d + 1], u[d + 2]))
    omega = u[d + 3], u[d + 4], u[d + 5]
    px, py, pz = cross(omega, arm)
    px += mass * v[0]
    py += mass * v[1]
    pz += mass * v[2]
    lx, ly, lz = symmetric(work.inertia, b, omega[0], omega[1], omega[2])
    tx, ty, tz = cross(arm, v)
    S, C = bodies.S, work.couple
    for k in range(bodies.dof[b + 1] - d - N_RIGID):
        m = first + k
        modal = u[d + N_RIGID + k]
        px += S[m, 0] * modal
        py += S[m, 1] * modal
        pz += S[m, 2] * modal
        lx += C[m, 0] * modal
        ly += C[m, 1] * modal
        lz += C[m, 2] * modal
    return (px, py, pz), (lx + tx, ly + ty, lz + tz)


@kernel
def stored_energies(
    bodies: SpatialBodies, loads: SpatialLoads, q: FloatArray, u: FloatArray, work: SpatialArrow
) -> tuple[float, float, float]:
    """Kinetic, elastic (modal) and weight energy of all bodies [J]."""
    kinetic, elastic, weight = 0.0, 0.0, 0.0
    for b in range(len(bodies.mass)):
        i, d = bodies.place[b], bodies.dof[b]
        first = d - N_RIGID * b
        p, turn = momentum(bodies, q, u, b, work)
        v = into_body(bodies, q, b, (u[d], u[d + 1], u[d + 2]))
        kinetic += 0.5 * (p[0] * v[0] + p[1] * v[1] + p[2] * v[2])
        kinetic += 0.5 * (turn[0] * u[d + 3] + turn[1] * u[d + 4] + turn[2] * u[d + 5])
        S, C = bodies.S, work.couple
        for k in range(bodies.dof[b + 1] - d - N_RIGID):
            m = first + k
            driven = S[m, 0] * v[0] + S[m, 1] * v[1] + S[m, 2] * v[2]
            driven += C[m, 0] * u[d + 3] + C[m, 1] * u[d + 4] + C[m, 2] * u[d + 5]
            kinetic += 0.5 * u[d + N_RIGID + k] * (u[d + N_RIGID + k] + driven)
            elastic += 0.5 * bodies.stiffness[m] * q[i + N_PLACE + k] ** 2
        arm = out_of_body(bodies, q, b, (work.arm[b, 0], work.arm[b, 1], work.arm[b, 2]))
        for c in range(3):
            weight -= loads.gravity[c] * (bodies.mass[b] * q[i + c] + arm[c])
    return kinetic, elastic, weight


@kernel
def momenta(bodies: SpatialBodies, q: FloatArray, u: FloatArray, work: SpatialArrow, out: FloatArray) -> None:
    """out (nb, 9) = linear momentum, angular momentum about the world's origin, mass centre, of each body.

    World axes, [kg m/s], [kg m^2/s], [m]:  p = m v + A(omega x d + S etadot),
    R x p + A(d x A^T v + J omega + C etadot),  R + A d / m.
    """
    for b in range(len(bodies.mass)):
        i = bodies.place[b]
        p, turn = momentum(bodies, q, u, b, work)
        linear = out_of_body(bodies, q, b, p)
        about = out_of_body(bodies, q, b, turn)
        orbit = cross((q[i], q[i + 1], q[i + 2]), linear)
        arm = out_of_body(bodies, q, b, (work.arm[b, 0], work.arm[b, 1], work.arm[b, 2]))
        for c in range(3):
            out[b, c] = linear[c]
            out[b, 3 + c] = orbit[c] + about[c]
            out[b, 6 + c] = q[i + c] + arm[c] / bodies.mass[b]
