"""What the factors of :mod:`lcpflex.dynamics.spatial.inertia` are for: solving, whitening and multiplying blocks."""

from __future__ import annotations

import math

from lcpflex.dynamics.spatial.inertia import SpatialArrow, symmetric
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.kinematics.spatial.rotations import Vector
from lcpflex.model.spatial import N_RIGID, SpatialBodies

__all__ = ["multiply", "solve_block", "turn_in", "turn_out", "whiten"]


@kernel
def forward(lower: FloatArray, b: int, x: float, y: float, z: float) -> Vector:
    """L^-1 (x, y, z) of a centred body's rotation."""
    x *= lower[b, 0]
    y = (y - lower[b, 1] * x) * lower[b, 2]
    z = (z - lower[b, 3] * x - lower[b, 4] * y) * lower[b, 5]
    return x, y, z


@kernel
def forward_six(lower: FloatArray, b: int, x: FloatArray) -> None:
    """x <- L^-1 x, six numbers in place."""
    row = 0
    for i in range(N_RIGID):
        total = x[i]
        for k in range(i):
            total -= lower[b, row + k] * x[k]
        x[i] = total * lower[b, row + i]
        row += i + 1


@kernel
def backward_six(lower: FloatArray, b: int, x: FloatArray) -> None:
    """x <- L^-T x, six numbers in place."""
    for i in range(N_RIGID - 1, -1, -1):
        x[i] *= lower[b, i * (i + 1) // 2 + i]
        for k in range(i):
            x[k] -= lower[b, i * (i + 1) // 2 + k] * x[i]


@kernel
def turn_in(axes: FloatArray, b: int, x: float, y: float, z: float) -> Vector:
    """A^T (x, y, z): into the axes of body b."""
    return (
        axes[b, 0] * x + axes[b, 3] * y + axes[b, 6] * z,
        axes[b, 1] * x + axes[b, 4] * y + axes[b, 7] * z,
        axes[b, 2] * x + axes[b, 5] * y + axes[b, 8] * z,
    )


@kernel
def turn_out(axes: FloatArray, b: int, x: float, y: float, z: float) -> Vector:
    """A (x, y, z): out of the axes of body b."""
    return (
        axes[b, 0] * x + axes[b, 1] * y + axes[b, 2] * z,
        axes[b, 3] * x + axes[b, 4] * y + axes[b, 5] * z,
        axes[b, 6] * x + axes[b, 7] * y + axes[b, 8] * z,
    )


@kernel
def solve_block(bodies: SpatialBodies, work: SpatialArrow, b: int, right: FloatArray, out: FloatArray) -> None:
    """out = (M + ...)^-1 right for the block (6 + n,) of body b; ``out`` may be ``right`` itself."""
    first = bodies.dof[b] - N_RIGID * b
    n = bodies.dof[b + 1] - bodies.dof[b] - N_RIGID
    if bodies.centred[b] == 0:
        solve_joined(bodies, work, b, right, out)
        return
    C, diagonal, lower = work.couple, work.diagonal, work.lower
    x, y, z = right[3], right[4], right[5]
    for k in range(n):
        scaled = diagonal[first + k] * right[N_RIGID + k]
        x -= C[first + k, 0] * scaled
        y -= C[first + k, 1] * scaled
        z -= C[first + k, 2] * scaled
    x, y, z = forward(lower, b, x, y, z)
    z *= lower[b, 5]
    y = (y - lower[b, 4] * z) * lower[b, 2]
    x = (x - lower[b, 1] * y - lower[b, 3] * z) * lower[b, 0]
    lighter = 1.0 / bodies.mass[b]
    for i in range(3):
        out[i] = lighter * right[i]
    out[3] = x
    out[4] = y
    out[5] = z
    for k in range(n):
        m = first + k
        out[N_RIGID + k] = diagonal[m] * (right[N_RIGID + k] - C[m, 0] * x - C[m, 1] * y - C[m, 2] * z)


@kernel
def reduce_motion(bodies: SpatialBodies, work: SpatialArrow, b: int, right: FloatArray) -> None:
    """``work.six`` = what is left of ``right`` for translation and rotation, in body axes, behind the modes."""
    first = bodies.dof[b] - N_RIGID * b
    S, C, diagonal, six = bodies.S, work.couple, work.diagonal, work.six
    x, y, z = turn_in(work.axes, b, right[0], right[1], right[2])
    u, v, w = right[3], right[4], right[5]
    for k in range(bodies.dof[b + 1] - bodies.dof[b] - N_RIGID):
        m = first + k
        scaled = diagonal[m] * right[N_RIGID + k]
        x -= S[m, 0] * scaled
        y -= S[m, 1] * scaled
        z -= S[m, 2] * scaled
        u -= C[m, 0] * scaled
        v -= C[m, 1] * scaled
        w -= C[m, 2] * scaled
    six[0], six[1], six[2], six[3], six[4], six[5] = x, y, z, u, v, w


@kernel
def solve_joined(bodies: SpatialBodies, work: SpatialArrow, b: int, right: FloatArray, out: FloatArray) -> None:
    """:func:`solve_block` of a body whose translation and rotation are coupled."""
    reduce_motion(bodies, work, b, right)
    forward_six(work.lower, b, work.six)
    backward_six(work.lower, b, work.six)
    first = bodies.dof[b] - N_RIGID * b
    S, C, diagonal, six = bodies.S, work.couple, work.diagonal, work.six
    x, y, z, u, v, w = six[0], six[1], six[2], six[3], six[4], six[5]
    for k in range(bodies.dof[b + 1] - bodies.dof[b] - N_RIGID):
        m = first + k
        coupled = S[m, 0] * x + S[m, 1] * y + S[m, 2] * z + C[m, 0] * u + C[m, 1] * v + C[m, 2] * w
        out[N_RIGID + k] = diagonal[m] * (right[N_RIGID + k] - coupled)
    x, y, z = turn_out(work.axes, b, x, y, z)
    out[0], out[1], out[2], out[3], out[4], out[5] = x, y, z, u, v, w


@kernel
def whiten(bodies: SpatialBodies, work: SpatialArrow, b: int, row: FloatArray, out: FloatArray) -> None:
    """out (6 + n,) = L^-1 row of body b, L L^T the matrix factorised last, its translation in body axes."""
    reduce_motion(bodies, work, b, row)
    six, lower = work.six, work.lower
    if bodies.centred[b] == 0:
        forward_six(lower, b, six)
    else:
        lighter = 1.0 / math.sqrt(bodies.mass[b])
        x, y, z = forward(lower, b, six[3], six[4], six[5])
        six[0], six[1], six[2] = lighter * six[0], lighter * six[1], lighter * six[2]
        six[3], six[4], six[5] = x, y, z
    first = bodies.dof[b] - N_RIGID * b
    for k in range(bodies.dof[b + 1] - bodies.dof[b] - N_RIGID):
        out[N_RIGID + k] = math.sqrt(work.diagonal[first + k]) * row[N_RIGID + k]
    for i in range(N_RIGID):
        out[i] = six[i]


@kernel
def multiply(bodies: SpatialBodies, work: SpatialArrow, b: int, x: FloatArray, out: FloatArray) -> None:
    """out = M x for the block (6 + n,) of body b, M at the configuration of the factors; ``out`` is not ``x``."""
    first = bodies.dof[b] - N_RIGID * b
    S, C = bodies.S, work.couple
    m, dx, dy, dz = bodies.mass[b], work.arm[b, 0], work.arm[b, 1], work.arm[b, 2]
    vx, vy, vz = turn_in(work.axes, b, x[0], x[1], x[2])
    wx, wy, wz = x[3], x[4], x[5]
    fx = m * vx + wy * dz - wz * dy
    fy = m * vy + wz * dx - wx * dz
    fz = m * vz + wx * dy - wy * dx
    tx, ty, tz = symmetric(work.inertia, b, wx, wy, wz)
    tx += dy * vz - dz * vy
    ty += dz * vx - dx * vz
    tz += dx * vy - dy * vx
    for k in range(bodies.dof[b + 1] - bodies.dof[b] - N_RIGID):
        o = first + k
        modal = x[N_RIGID + k]
        fx += S[o, 0] * modal
        fy += S[o, 1] * modal
        fz += S[o, 2] * modal
        tx += C[o, 0] * modal
        ty += C[o, 1] * modal
        tz += C[o, 2] * modal
        driven = S[o, 0] * vx + S[o, 1] * vy + S[o, 2] * vz + C[o, 0] * wx + C[o, 1] * wy + C[o, 2] * wz
        out[N_RIGID + k] = modal + driven
    fx, fy, fz = turn_out(work.axes, b, fx, fy, fz)
    out[0], out[1], out[2], out[3], out[4], out[5] = fx, fy, fz, tx, ty, tz
