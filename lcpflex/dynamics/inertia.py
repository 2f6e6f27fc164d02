"""Inertia of floating-frame bodies and its inverse: an arrow, factorised in O(n) per body.

In its own orthonormal basis the matrix of a body, M + alpha_c C + alpha_k K, reads

    [ R (3 x 3)   B^T (3 x n) ]      R = [[m I, A J (s0 + S q)], [., I0 + 2 a.q + q.q - q^T G q]]
    [ B (n x 3)   diag(d)     ]      B_k = [A S_k, c_k + (q^T D)_k],   d_k = 1 + alpha_c c_k + alpha_k omega_k^2

so its inverse needs the 3 x 3 Schur complement R - B^T diag(1/d) B only. Where the axial force of a body acts on its
bending (:mod:`lcpflex.dynamics.shortening`), diag(d) gets alpha_k times the second derivatives of that potential at q,
and a dense factor. alpha_c = alpha_k = 0 gives the mass
matrix; alpha_c = theta h, alpha_k = (theta h)^2 the iteration matrix of an implicit step of length h.
G, for bodies that have it, is their stiffening by rotation (:mod:`lcpflex.bodies.reduction.stiffening`): deflections
that draw the body together make it easier to spin, so that its stiffness omega^2 G and its torque come from one
kinetic energy. Inertia terms: Zwoelfer & Gerstmayr (2020), nodal-based floating frame of reference.
"""

from __future__ import annotations

import math

import numpy as np

from lcpflex.dynamics.shortening import factorise_tangent, shortens
from lcpflex.jit.kernel import FloatArray, IntArray, kernel, late_kernel
from lcpflex.jit.leaf import in_space
from lcpflex.jit.struct import allocate, array, struct
from lcpflex.model.arrays import Bodies, Model
from lcpflex.model.planar import N_RIGID
from lcpflex.solvers.semidefinite import cholesky_solve

__all__ = [
    "Arrow",
    "add_row_product",
    "arrow",
    "couple_modes",
    "deformed_moments",
    "factorise",
    "factors",
    "model_factors",
    "multiply",
    "solve_block",
    "solve_rigid",
    "stiffened",
]


@struct
class Arrow:
    """The factorised matrices of all bodies."""

    rigid: FloatArray = array("bodies", 3, 3)  # lower Cholesky factor of the Schur complement
    couple: FloatArray = array("modes", 3)  # B
    diagonal: FloatArray  # (modes,) 1 / d
    turn: FloatArray = array("modes")  # q^T D
    full: IntArray = array("bodies")  # whether 1 / d is that of a dense matrix
    dense_start: IntArray  # (nb + 1,) offsets into dense; equal where no such matrix can be
    dense: FloatArray = array("dense")  # flat n x n lower Cholesky factors of these matrices
    eased: FloatArray = array("eased", 3)  # their inverse times B


def arrow(n_bodies: int, n_modes: int, dense: IntArray | None = None) -> Arrow:
    """Memory for the factors of all bodies; ``dense`` (nb,): modes of each that gets shorter as it bends, 0 of others.

    None: there is no such body.
    """
    squares = np.zeros(n_bodies, dtype=np.int64) if dense is None else np.asarray(dense, dtype=np.int64) ** 2
    start = np.concatenate([[0], np.cumsum(squares)])
    sizes = {"bodies": n_bodies, "modes": n_modes, "dense": int(start[-1]), "eased": n_modes if squares.any() else 0}
    return allocate(Arrow, sizes, diagonal=np.ones(n_modes), dense_start=start)


@in_space("lcpflex.dynamics.spatial.inertia")
def model_factors(model: Model) -> Arrow:
    """:func:`factors` of the bodies of a model."""
    return factors(model.bodies)


@in_space("lcpflex.dynamics.spatial.inertia")
def factors(bodies: Bodies) -> Arrow:
    """Memory for the factors of these bodies."""
    shortening = np.where(np.diff(bodies.shortening_start) > 0, np.diff(bodies.dof) - N_RIGID, 0)
    return arrow(len(bodies.dof) - 1, len(bodies.stiffness), shortening)


@kernel
def deformed_moments(bodies: Bodies, q: FloatArray, b: int) -> tuple[float, float, float]:
    """s0 + S q [kg m] (body axes) and I0 + 2 a.q + q.q - q^T G q [kg m^2] of body b."""
    d = bodies.dof[b]
    first = d - N_RIGID * b
    sx = bodies.moment[b, 0]
    sy = bodies.moment[b, 1]
    inertia = bodies.inertia[b]
    for k in range(bodies.dof[b + 1] - d - N_RIGID):
        qk = q[d + N_RIGID + k]
        sx += bodies.S[first + k, 0] * qk
        sy += bodies.S[first + k, 1] * qk
        inertia += (2.0 * bodies.a[first + k] + qk) * qk
    if bodies.geometric_start[b + 1] > bodies.geometric_start[b]:
        modal = q[d + N_RIGID : bodies.dof[b + 1]]
        inertia -= stiffened(bodies, b, modal, modal)
    return sx, sy, inertia


@kernel
def stiffened(bodies: Bodies, b: int, x: FloatArray, y: FloatArray) -> float:
    """x^T G y of body b, which has a G."""
    n = len(x)
    start = bodies.geometric_start[b]
    total = 0.0
    for i in range(n):
        row = bodies.geometric[start + i * n : start + (i + 1) * n]
        part = 0.0
        for k in range(n):
            part += row[k] * y[k]
        total += x[i] * part
    return total


@kernel
def add_row_product(x: FloatArray, matrix: FloatArray, scale: float, out: FloatArray) -> None:
    """out += scale x^T A for a flat row-major n x n matrix A.

    Row by row and four at a time, so that all memory is passed in order and one instruction serves several columns.
    """
    n = len(x)
    whole = n - n % 4
    for i in range(0, whole, 4):
        a, b, c, d = scale * x[i], scale * x[i + 1], scale * x[i + 2], scale * x[i + 3]
        row = matrix[i * n : (i + 4) * n]
        for k in range(n):
            out[k] += a * row[k] + b * row[n + k] + c * row[2 * n + k] + d * row[3 * n + k]
    for i in range(whole, n):
        a = scale * x[i]
        for k in range(n):
            out[k] += a * matrix[i * n + k]


@kernel
def couple_modes(bodies: Bodies, q: FloatArray, b: int, work: Arrow) -> None:
    """B of body b: coupling of its modes with translation and rotation of the frame."""
    couple = work.couple
    d = bodies.dof[b]
    first = d - N_RIGID * b
    n = bodies.dof[b + 1] - d - N_RIGID
    cos = math.cos(q[d + 2])
    sin = math.sin(q[d + 2])
    for k in range(n):
        sx = bodies.S[first + k, 0]
        sy = bodies.S[first + k, 1]
        couple[first + k, 0] = cos * sx - sin * sy
        couple[first + k, 1] = sin * sx + cos * sy
        couple[first + k, 2] = bodies.c[first + k]
    start = bodies.coupling_start[b]
    if bodies.coupling_start[b + 1] > start:
        turn = work.turn[first : first + n]
        turn[:] = 0.0
        add_row_product(q[d + N_RIGID : d + N_RIGID + n], bodies.coupling[start : start + n * n], 1.0, turn)
        for k in range(n):
            couple[first + k, 2] += turn[k]


@in_space("lcpflex.dynamics.spatial.inertia")
@kernel
def factorise(bodies: Bodies, q: FloatArray, alpha_c: float, alpha_k: float, work: Arrow) -> None:
    """Factorise M(q) + alpha_c C + alpha_k K of every body (C: diagonal part of the modal damping)."""
    for b in range(len(bodies.mass)):
        d = bodies.dof[b]
        first = d - N_RIGID * b
        if bodies.dof[b + 1] - d > N_RIGID:
            couple_modes(bodies, q, b, work)
        sx, sy, inertia = deformed_moments(bodies, q, b)
        cos = math.cos(q[d + 2])
        sin = math.sin(q[d + 2])
        xx = bodies.mass[b]
        yy = xx
        xy = 0.0
        xt = -(sin * sx + cos * sy)
        yt = cos * sx - sin * sy
        tt = inertia
        for k in range(first, first + bodies.dof[b + 1] - d - N_RIGID):
            scale = 1.0 / (1.0 + alpha_c * bodies.damping[k] + alpha_k * bodies.stiffness[k])
            work.diagonal[k] = scale
            bx = work.couple[k, 0]
            by = work.couple[k, 1]
            bt = work.couple[k, 2]
            xx -= bx * bx * scale
            xy -= bx * by * scale
            yy -= by * by * scale
            xt -= bx * bt * scale
            yt -= by * bt * scale
            tt -= bt * bt * scale
        if shortens(bodies, b):
            xx, xy, yy, xt, yt, tt = with_tangent(bodies, q, b, alpha_k, work, (xx, xy, yy, xt, yt, tt))
        lower = work.rigid[b]
        lower[0, 0] = math.sqrt(xx)
        lower[1, 0] = xy / lower[0, 0]
        lower[2, 0] = xt / lower[0, 0]
        lower[1, 1] = math.sqrt(yy - lower[1, 0] * lower[1, 0])
        lower[2, 1] = (yt - lower[2, 0] * lower[1, 0]) / lower[1, 1]
        lower[2, 2] = math.sqrt(tt - lower[2, 0] * lower[2, 0] - lower[2, 1] * lower[2, 1])


@late_kernel
def with_tangent(
    bodies: Bodies, q: FloatArray, b: int, alpha_k: float, work: Arrow, rigid: tuple[float, ...]
) -> tuple[float, float, float, float, float, float]:
    """The Schur complement (xx, xy, yy, xt, yt, tt) of body b with its dense matrix, from that with the diagonal."""
    xx, xy, yy, xt, yt, tt = rigid
    d = bodies.dof[b]
    first = d - N_RIGID * b
    n = bodies.dof[b + 1] - d - N_RIGID
    work.full[b] = 0
    if alpha_k == 0.0:
        return xx, xy, yy, xt, yt, tt
    start = work.dense_start[b]
    matrix = work.dense[start : start + n * n].reshape((n, n))
    diagonal = work.diagonal[first : first + n]
    turn = work.turn[first : first + n]
    if factorise_tangent(bodies, b, q[d + N_RIGID : d + N_RIGID + n], alpha_k, diagonal, matrix):
        work.full[b] = 1
        for i in range(3):
            for k in range(n):
                turn[k] = work.couple[first + k, i]
            cholesky_solve(matrix, n, turn)
            for k in range(n):
                work.eased[first + k, i] = turn[k]
        for k in range(n):
            row = work.couple[first + k]
            more_x = work.eased[first + k, 0] - diagonal[k] * row[0]
            more_y = work.eased[first + k, 1] - diagonal[k] * row[1]
            more_t = work.eased[first + k, 2] - diagonal[k] * row[2]
            xx -= row[0] * more_x
            xy -= row[0] * more_y
            yy -= row[1] * more_y
            xt -= row[0] * more_t
            yt -= row[1] * more_t
            tt -= row[2] * more_t
    return xx, xy, yy, xt, yt, tt


@kernel
def solve_rigid(work: Arrow, b: int, x: float, y: float, t: float) -> tuple[float, float, float]:
    """The Schur complement of body b solved for (x, y, t)."""
    lower = work.rigid[b]
    x /= lower[0, 0]
    y = (y - lower[1, 0] * x) / lower[1, 1]
    t = (t - lower[2, 0] * x - lower[2, 1] * y) / lower[2, 2]
    t /= lower[2, 2]
    y = (y - lower[2, 1] * t) / lower[1, 1]
    x = (x - lower[1, 0] * y - lower[2, 0] * t) / lower[0, 0]
    return x, y, t


@in_space("lcpflex.dynamics.spatial.inertia_solve")
@kernel
def solve_block(bodies: Bodies, work: Arrow, b: int, right: FloatArray, out: FloatArray) -> None:
    """out = (M + ...)^-1 right for the block (3 + n,) of body b; ``out`` may be ``right`` itself."""
    d = bodies.dof[b]
    first = d - N_RIGID * b
    n = bodies.dof[b + 1] - d - N_RIGID
    x = right[0]
    y = right[1]
    t = right[2]
    if work.full[b] != 0:
        start = work.dense_start[b]
        for k in range(n):
            out[N_RIGID + k] = right[N_RIGID + k]
        cholesky_solve(work.dense[start : start + n * n].reshape((n, n)), n, out[N_RIGID : N_RIGID + n])
        for k in range(n):
            x -= work.couple[first + k, 0] * out[N_RIGID + k]
            y -= work.couple[first + k, 1] * out[N_RIGID + k]
            t -= work.couple[first + k, 2] * out[N_RIGID + k]
        x, y, t = solve_rigid(work, b, x, y, t)
        for k in range(n):
            row = work.eased[first + k]
            out[N_RIGID + k] -= row[0] * x + row[1] * y + row[2] * t
        out[0] = x
        out[1] = y
        out[2] = t
        return
    for k in range(n):
        scaled = work.diagonal[first + k] * right[N_RIGID + k]
        x -= work.couple[first + k, 0] * scaled
        y -= work.couple[first + k, 1] * scaled
        t -= work.couple[first + k, 2] * scaled
    x, y, t = solve_rigid(work, b, x, y, t)
    out[0] = x
    out[1] = y
    out[2] = t
    for k in range(n):
        row = work.couple[first + k]
        out[N_RIGID + k] = work.diagonal[first + k] * (right[N_RIGID + k] - row[0] * x - row[1] * y - row[2] * t)


@kernel
def multiply(bodies: Bodies, q: FloatArray, x: FloatArray, work: Arrow, out: FloatArray) -> None:
    """out = M(q) x for all bodies, with the couplings that :func:`factorise` left at the same q."""
    for b in range(len(bodies.mass)):
        d = bodies.dof[b]
        first = d - N_RIGID * b
        sx, sy, inertia = deformed_moments(bodies, q, b)
        cos = math.cos(q[d + 2])
        sin = math.sin(q[d + 2])
        xt = -(sin * sx + cos * sy)
        yt = cos * sx - sin * sy
        right = bodies.mass[b] * x[d] + xt * x[d + 2]
        up = bodies.mass[b] * x[d + 1] + yt * x[d + 2]
        turn = xt * x[d] + yt * x[d + 1] + inertia * x[d + 2]
        for k in range(bodies.dof[b + 1] - d - N_RIGID):
            row = work.couple[first + k]
            modal = x[d + N_RIGID + k]
            right += row[0] * modal
            up += row[1] * modal
            turn += row[2] * modal
            out[d + N_RIGID + k] = modal + row[0] * x[d] + row[1] * x[d + 1] + row[2] * x[d + 2]
        out[d] = right
        out[d + 1] = up
        out[d + 2] = turn
