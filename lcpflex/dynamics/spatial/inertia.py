"""Inertia of spatial floating-frame bodies and its inverse: an arrow, factorised in O(n) per body.

With the velocity of the frame taken in body axes, w = A^T v, the matrix M + alpha_c C + alpha_k K of a body reads

    [ m I   -d~   S^T     ]     d = s0 + S eta,   Y_k = <s Phi_k^T> = P1_k + sum_l eta_l <Phi_l Phi_k^T>
    [  .     J    C^T     ]     C_k = <s x Phi_k>,   J = tr(P) I - P,   P = <s s^T> = P0 + sum_k eta_k (P1_k + Y_k^T)
    [  .     .    diag(1/e)]    1/e_k = 1 + alpha_c c_k + alpha_k omega_k^2

and its inverse needs the Schur complement of the first six alone; of the rotation, J - C^T diag(e) C, where S = 0 and
s0 = 0 (a mean frame about the mass centre). No factor depends on A, by which right-hand sides are turned. alpha_c =
alpha_k = 0 gives the mass matrix; alpha_c = theta h, alpha_k = (theta h)^2 the iteration matrix of an implicit step.
Products <Phi_l Phi_k^T> count between the first n2 modes of a body, in all terms at once: T stays one quadratic form.

Spin stiffens a body that has six matrices G_ij (n, n). Its material lies at x + Phi eta + s2(eta), with s2 of second
order: a beam that is bent is drawn together. Of T what s2 adds to <|omega x s|^2> / 2 is kept,

    T <- T - 1/2 sum_ij omega_i omega_j eta^T G_ij eta,     J_ij <- J_ij - eta^T G_ij eta,

so that the stiffness sum_ij omega_i omega_j G_ij, the torque of Jdot, energy and angular momentum are those of one J.
What s2 adds to the mass centre and to the momentum of the modes is left out, as in the plane: neither weight nor the
acceleration of the place that is held stiffens.

Source: Zwoelfer & Gerstmayr (2020), nodal-based floating frame of reference; Shabana, Dynamics of Multibody Systems.
"""

from __future__ import annotations

import math
from typing import Any, TypeAlias

import numpy as np

from lcpflex.dynamics.spatial.point_blocks import PointBlocks, no_blocks, point_blocks, touching_points
from lcpflex.jit.kernel import FloatArray, kernel, late_kernel
from lcpflex.jit.struct import allocate, array, struct
from lcpflex.kinematics.spatial.rotations import Vector, rotation_matrix
from lcpflex.model.spatial import N_PLACE, N_RIGID, SpatialBodies, SpatialModel

__all__ = [
    "PARTS",
    "SpatialArrow",
    "SpatialWork",
    "add_products",
    "deform",
    "factorise",
    "factors",
    "model_factors",
    "spin_stiffens",
    "symmetric",
]

FACTOR = 21  # entries of a lower triangle of six rows
PARTS = 6  # of J and of G: xx, yy, zz, yz, zx, xy


@struct
class SpatialArrow:
    """The factorised matrices of all bodies, and what they have in common with their forces."""

    at: FloatArray = array("modes")  # eta that the next five belong to; NaN before the first
    arm: FloatArray = array("bodies", 3)  # d
    inertia: FloatArray = array("bodies", 6)  # xx, yy, zz, yz, zx, xy of J
    moments: FloatArray = array("moments")  # Y of each mode, nine numbers, row by row
    couple: FloatArray = array("modes", 3)  # C
    laid: FloatArray = array("places")  # configuration of the factors, and of the rows that are solved by them
    axes: FloatArray = array("bodies", 9)  # A there
    diagonal: FloatArray = array("modes")  # e
    lower: FloatArray = array("bodies", FACTOR)  # Cholesky factor by rows, 1 / its diagonal: of three rows, if centred
    pull: FloatArray = array("pulls")  # G_ij eta of each mode, in the order of J; of bodies that have G
    swing: FloatArray = array("moments")  # sum_l etadot_l <Phi_l Phi_k^T> of each mode; scratch
    six: FloatArray = array(N_RIGID)  # scratch
    spin: FloatArray = array("ndof")  # inertial forces of the last velocity
    mean: FloatArray = array("ndof")  # a velocity; scratch
    touch: FloatArray = array("ndof")  # what contacts are expected to add to the velocity in a step
    shift: FloatArray = array("ndof")  # scratch
    energy: FloatArray = array("bodies")  # scratch
    blocks: PointBlocks  # of the points that may touch, by the weights that a factor has given to the modes


SpatialWork: TypeAlias = Any  # a Workspace, or CompliantContacts, with the rows of space
RowsOfSpace: TypeAlias = Any  # Rows with a SpatialArrow for their arrow and a SpatialContactTable


def model_factors(model: SpatialModel) -> SpatialArrow:
    """:func:`factors` of the bodies of a model, with the blocks of all points that may touch."""
    return _arrow(model.bodies, point_blocks(model.bodies, model.points, touching_points(model.contacts)))


def factors(bodies: SpatialBodies) -> SpatialArrow:
    """Memory for the factors of these bodies and of no others: what does not change in rigid ones is filled in."""
    return _arrow(bodies, no_blocks())


def _arrow(bodies: SpatialBodies, blocks: PointBlocks) -> SpatialArrow:
    n_modes = len(bodies.stiffness)
    sizes = {"bodies": len(bodies.mass), "modes": n_modes, "moments": 9 * n_modes, "ndof": int(bodies.dof[-1])}
    sizes["places"] = int(bodies.place[-1])
    sizes["pulls"] = PARTS * n_modes if len(bodies.geometric) else 0
    P = np.asarray(bodies.second)
    J = np.trace(P, axis1=1, axis2=2)[:, None, None] * np.eye(3) - P
    return allocate(
        SpatialArrow,
        sizes,
        blocks=blocks,
        at=np.full(n_modes, np.nan),
        arm=np.array(bodies.moment),
        inertia=np.ascontiguousarray(J[:, [0, 1, 2, 1, 2, 0], [0, 1, 2, 2, 0, 1]]),
    )


@kernel
def add_products(products: FloatArray, x: FloatArray, out: FloatArray) -> None:
    """out (n, 9) += sum_l x_l <Phi_l Phi_k^T>, all flat; or (n, 6) += sum_l x_l G_lk.

    Row by row and four at a time, so that all memory is passed in order and one instruction serves several columns.
    """
    n, width = len(x), len(out)  # lengths are known not to be negative: nor are the places below, which costs half
    whole = n - n % 4
    for i in range(0, whole, 4):
        a, b, c, d = x[i], x[i + 1], x[i + 2], x[i + 3]
        first = products[i * width : (i + 1) * width]
        second = products[(i + 1) * width : (i + 2) * width]
        third = products[(i + 2) * width : (i + 3) * width]
        fourth = products[(i + 3) * width : (i + 4) * width]
        for k in range(width):
            out[k] += a * first[k] + b * second[k] + c * third[k] + d * fourth[k]
    for i in range(whole, n):
        a = x[i]
        row = products[i * width : (i + 1) * width]
        for k in range(width):
            out[k] += a * row[k]


@kernel
def deform(bodies: SpatialBodies, q: FloatArray, b: int, work: SpatialArrow) -> None:
    """d, J, Y and C of body b at q, unless they are known there."""
    e = bodies.place[b] + N_PLACE
    first = bodies.dof[b] - N_RIGID * b
    n = bodies.dof[b + 1] - bodies.dof[b] - N_RIGID
    at = work.at
    for k in range(n):
        if at[first + k] != q[e + k]:
            deform_anew(bodies, q, b, work)
            return


@kernel
def deform_anew(bodies: SpatialBodies, q: FloatArray, b: int, work: SpatialArrow) -> None:
    """The same, whatever is known."""
    e = bodies.place[b] + N_PLACE
    first = bodies.dof[b] - N_RIGID * b
    n = bodies.dof[b + 1] - bodies.dof[b] - N_RIGID
    n2 = bodies.second_modes[b]
    start = bodies.products_start[b]
    P1, S, Y, C, at = bodies.first, bodies.S, work.moments, work.couple, work.at
    for k in range(n):
        at[first + k] = q[e + k]
        for i in range(9):
            Y[9 * (first + k) + i] = P1[first + k, i]
    if n2 > 0:
        products = bodies.products[start : start + 9 * n2 * n2]
        add_products(products, q[e : e + n2], Y[9 * first : 9 * (first + n2)])
    P = bodies.second
    xx, yy, zz = P[b, 0, 0], P[b, 1, 1], P[b, 2, 2]
    yz, zx, xy = P[b, 1, 2], P[b, 2, 0], P[b, 0, 1]
    dx, dy, dz = bodies.moment[b, 0], bodies.moment[b, 1], bodies.moment[b, 2]
    for k in range(n):
        m = first + k
        o = 9 * m
        eta = q[e + k]
        dx += S[m, 0] * eta
        dy += S[m, 1] * eta
        dz += S[m, 2] * eta
        xx += eta * (P1[m, 0] + Y[o])
        yy += eta * (P1[m, 4] + Y[o + 4])
        zz += eta * (P1[m, 8] + Y[o + 8])
        yz += 0.5 * eta * (P1[m, 5] + P1[m, 7] + Y[o + 5] + Y[o + 7])  # P is symmetric but for rounding
        zx += 0.5 * eta * (P1[m, 6] + P1[m, 2] + Y[o + 6] + Y[o + 2])
        xy += 0.5 * eta * (P1[m, 1] + P1[m, 3] + Y[o + 1] + Y[o + 3])
        C[m, 0] = Y[o + 5] - Y[o + 7]
        C[m, 1] = Y[o + 6] - Y[o + 2]
        C[m, 2] = Y[o + 1] - Y[o + 3]
    work.arm[b, 0] = dx
    work.arm[b, 1] = dy
    work.arm[b, 2] = dz
    J = work.inertia
    J[b, 0] = yy + zz
    J[b, 1] = zz + xx
    J[b, 2] = xx + yy
    J[b, 3] = -yz
    J[b, 4] = -zx
    J[b, 5] = -xy
    if spin_stiffens(bodies, b):
        shorten(bodies, b, work)


@kernel
def spin_stiffens(bodies: SpatialBodies, b: int) -> bool:
    """Whether body b has G."""
    return len(bodies.geometric) > 0 and bodies.geometric_start[b + 1] > bodies.geometric_start[b]


@late_kernel
def shorten(bodies: SpatialBodies, b: int, work: SpatialArrow) -> None:
    """``work.pull`` of body b at the eta that ``deform_anew`` is at, and J less eta^T G eta."""
    first = bodies.dof[b] - N_RIGID * b
    n = bodies.dof[b + 1] - bodies.dof[b] - N_RIGID
    start = bodies.geometric_start[b]
    eta = work.at[first : first + n]
    pull = work.pull[PARTS * first : PARTS * (first + n)]
    for k in range(len(pull)):
        pull[k] = 0.0
    add_products(bodies.geometric[start : start + PARTS * n * n], eta, pull)
    for i in range(PARTS):
        total = 0.0
        for k in range(n):
            total += eta[k] * pull[PARTS * k + i]
        work.inertia[b, i] -= total


@kernel
def symmetric(entries: FloatArray, b: int, x: float, y: float, z: float) -> Vector:
    """J (x, y, z) of row b of ``entries``: xx, yy, zz, yz, zx, xy."""
    return (
        entries[b, 0] * x + entries[b, 5] * y + entries[b, 4] * z,
        entries[b, 5] * x + entries[b, 1] * y + entries[b, 3] * z,
        entries[b, 4] * x + entries[b, 3] * y + entries[b, 2] * z,
    )


@kernel
def factorise(bodies: SpatialBodies, q: FloatArray, alpha_c: float, alpha_k: float, work: SpatialArrow) -> None:
    """Factorise M(q) + alpha_c C + alpha_k K of every body (C: diagonal part of the modal damping)."""
    axes, laid = work.axes, work.laid
    for i in range(len(laid)):
        laid[i] = q[i]
    for b in range(len(bodies.mass)):
        i = bodies.place[b]
        turned = rotation_matrix(q[i + 3], q[i + 4], q[i + 5], q[i + 6])
        for k in range(9):
            axes[b, k] = turned[k]
        deform(bodies, q, b, work)
        first = bodies.dof[b] - N_RIGID * b
        diagonal, damping, stiffness = work.diagonal, bodies.damping, bodies.stiffness
        for k in range(first, first + bodies.dof[b + 1] - bodies.dof[b] - N_RIGID):
            diagonal[k] = 1.0 / (1.0 + alpha_c * damping[k] + alpha_k * stiffness[k])
        if bodies.centred[b] != 0:
            factorise_rotation(bodies, b, work)
        else:
            factorise_motion(bodies, b, work)


@kernel
def factorise_rotation(bodies: SpatialBodies, b: int, work: SpatialArrow) -> None:
    """The Cholesky factor of J - C^T diag(e) C."""
    J, C, diagonal = work.inertia, work.couple, work.diagonal
    xx, yy, zz, yz, zx, xy = J[b, 0], J[b, 1], J[b, 2], J[b, 3], J[b, 4], J[b, 5]
    first = bodies.dof[b] - N_RIGID * b
    for k in range(first, first + bodies.dof[b + 1] - bodies.dof[b] - N_RIGID):
        cx, cy, cz = C[k, 0], C[k, 1], C[k, 2]
        ex, ey, ez = diagonal[k] * cx, diagonal[k] * cy, diagonal[k] * cz
        xx -= cx * ex
        yy -= cy * ey
        zz -= cz * ez
        yz -= cy * ez
        zx -= cz * ex
        xy -= cx * ey
    a = 1.0 / math.sqrt(xx)
    yx = xy * a
    zx = zx * a
    c = 1.0 / math.sqrt(yy - yx * yx)
    zy = (yz - zx * yx) * c
    lower = work.lower
    lower[b, 0] = a
    lower[b, 1] = yx
    lower[b, 2] = c
    lower[b, 3] = zx
    lower[b, 4] = zy
    lower[b, 5] = 1.0 / math.sqrt(zz - zx * zx - zy * zy)


@kernel
def factorise_motion(bodies: SpatialBodies, b: int, work: SpatialArrow) -> None:
    """The Cholesky factor of the Schur complement of translation and rotation, both in body axes."""
    lower, J, S, C, diagonal = work.lower, work.inertia, bodies.S, work.couple, work.diagonal
    dx, dy, dz = work.arm[b, 0], work.arm[b, 1], work.arm[b, 2]
    for k in range(FACTOR):
        lower[b, k] = 0.0
    for k in (0, 2, 5):
        lower[b, k] = bodies.mass[b]
    lower[b, 7], lower[b, 8] = -dz, dy  # d~, below the diagonal
    lower[b, 10], lower[b, 12] = dz, -dx
    lower[b, 15], lower[b, 16] = -dy, dx
    lower[b, 9], lower[b, 13], lower[b, 14] = J[b, 0], J[b, 5], J[b, 1]
    lower[b, 18], lower[b, 19], lower[b, 20] = J[b, 4], J[b, 3], J[b, 2]
    first = bodies.dof[b] - N_RIGID * b
    six = work.six
    for k in range(first, first + bodies.dof[b + 1] - bodies.dof[b] - N_RIGID):
        for i in range(3):
            six[i] = S[k, i]
            six[3 + i] = C[k, i]
        o = 0
        for i in range(N_RIGID):
            scaled = diagonal[k] * six[i]
            for j in range(i + 1):
                lower[b, o] -= scaled * six[j]
                o += 1
    row = 0
    for i in range(N_RIGID):
        above = 0
        for j in range(i):
            total = lower[b, row + j]
            for k in range(j):
                total -= lower[b, row + k] * lower[b, above + k]
            lower[b, row + j] = total * lower[b, above + j]
            above += j + 1
        total = lower[b, row + i]
        for k in range(i):
            total -= lower[b, row + k] ** 2
        lower[b, row + i] = 1.0 / math.sqrt(total)
        row += i + 1
