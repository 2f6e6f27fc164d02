"""The rows of a side of a contact in space: what its velocity is along the normal and both tangents.

See :mod:`lcpflex.contact.spatial.narrow_phase.sides`.
"""

from __future__ import annotations

from lcpflex.contact.spatial.narrow_phase.sides import Frame, Mean, is_rigid, mean_shape, mean_undeformed, modal_sum
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.kinematics.spatial.rotations import Vector, cross, tangent
from lcpflex.kinematics.spatial.vectors import added, is_zero, row_vector, scaled, turned_back
from lcpflex.model.spatial import N_RIGID, SpatialPoints

__all__ = ["lay_side"]


@kernel
def lay_block(row: FloatArray, sign: float, d: Vector, moment: Vector) -> None:
    """Set a block to sign times what v and omega do along d; its modal part to 0."""
    lay_frame(row, sign, d, moment)
    for i in range(N_RIGID, len(row)):
        row[i] = 0.0


@kernel
def lay_frame(row: FloatArray, sign: float, d: Vector, moment: Vector) -> None:
    """The part of a block that v and omega have."""
    row[0] = sign * d[0]
    row[1] = sign * d[1]
    row[2] = sign * d[2]
    row[3] = sign * moment[0]
    row[4] = sign * moment[1]
    row[5] = sign * moment[2]


@kernel
def add_modes(
    points: SpatialPoints, field: FloatArray, p: int, a: Vector, b: Vector, c: Vector, rough: bool, normal: FloatArray,
    first: FloatArray, second: FloatArray,
) -> None:  # fmt: skip
    """Add Phi_k.d or Psi_k.d of all modes k, for d = a, b, c in the frame, to the three rows."""
    start = points.start[p]
    for k in range(points.start[p + 1] - start):
        x, y, z = field[start + k, 0], field[start + k, 1], field[start + k, 2]
        normal[N_RIGID + k] += x * a[0] + y * a[1] + z * a[2]
        if not rough:
            continue
        first[N_RIGID + k] += x * b[0] + y * b[1] + z * b[2]
        second[N_RIGID + k] += x * c[0] + y * c[1] + z * c[2]


@kernel
def add_material(
    points: SpatialPoints, q: FloatArray, frame: Frame, p: int, weight: float, lever: Vector, n: Vector, t: Vector,
    rough: bool, normal: FloatArray, first: FloatArray, second: FloatArray,
) -> None:  # fmt: skip
    """Add what the modes do at point p along weight times n, t and n x t, by a lever; all in the frame."""
    a, b = scaled(weight, n), scaled(weight, t)
    c = cross(n, b)
    add_modes(points, points.phi, p, a, b, c, rough, normal, first, second)
    if is_zero(lever):
        return
    psi = modal_sum(points, points.psi, p, q, frame.modal)
    T = tangent(psi[0], psi[1], psi[2])
    a, b, c = cross(lever, a), cross(lever, b), cross(lever, c)
    a, b, c = turned_back(T, a), turned_back(T, b), turned_back(T, c)
    add_modes(points, points.psi, p, a, b, c, rough, normal, first, second)


@kernel
def lay_rigid(
    frame: Frame, s: Vector, lever: Vector, sign: float, n: Vector, t: Vector, rough: bool, normal: FloatArray,
    first: FloatArray, second: FloatArray,
) -> None:  # fmt: skip
    """The same of a rigid body, whose mean place is s."""
    a, b = turned_back(frame.A, n), turned_back(frame.A, t)
    arm = added(s, turned_back(frame.A, lever))
    lay_block(normal, sign, n, cross(arm, a))
    if not rough:
        return
    lay_block(first, sign, t, cross(arm, b))
    lay_block(second, sign, cross(n, t), cross(arm, cross(a, b)))


@kernel
def lay_point(
    points: SpatialPoints, q: FloatArray, frame: Frame, p: int, sign: float, n: Vector, t: Vector, rough: bool,
    normal: FloatArray, first: FloatArray, second: FloatArray,
) -> None:  # fmt: skip
    """The same of one point of a flexible body that touches where it is: its shapes are read once."""
    a, b = turned_back(frame.A, n), turned_back(frame.A, t)
    u, v = scaled(sign, a), scaled(sign, b)
    w = cross(a, v)
    x = y = z = 0.0
    start, phi = points.start[p], points.phi
    for k in range(points.start[p + 1] - start):
        e = q[frame.modal + k]
        f, g, h = phi[start + k, 0], phi[start + k, 1], phi[start + k, 2]
        x += f * e
        y += g * e
        z += h * e
        normal[N_RIGID + k] = f * u[0] + g * u[1] + h * u[2]
        if rough:
            first[N_RIGID + k] = f * v[0] + g * v[1] + h * v[2]
            second[N_RIGID + k] = f * w[0] + g * w[1] + h * w[2]
    for k in range(N_RIGID + points.start[p + 1] - start, len(normal)):  # of wider bodies
        normal[k] = 0.0
        if rough:
            first[k], second[k] = 0.0, 0.0
    arm = added(row_vector(points.place, p), (x, y, z))
    lay_frame(normal, sign, n, cross(arm, a))
    if rough:
        lay_frame(first, sign, t, cross(arm, b))
        lay_frame(second, sign, cross(n, t), cross(arm, cross(a, b)))


@kernel
def lay_flexible(
    points: SpatialPoints, q: FloatArray, frame: Frame, mean: Mean, lever: Vector, sign: float, n: Vector, t: Vector,
    rough: bool, normal: FloatArray, first: FloatArray, second: FloatArray,
) -> None:  # fmt: skip
    """The same of a flexible one: a kernel of its own, as its code slows down what rigid bodies pass through."""
    if mean.number == 1 and is_zero(lever):
        lay_point(points, q, frame, mean.a, sign * mean.w[0], n, t, rough, normal, first, second)
        return
    s = added(mean_undeformed(points, mean), mean_shape(points, q, frame.modal, mean))
    lay_rigid(frame, s, lever, sign, n, t, rough, normal, first, second)
    a, b = turned_back(frame.A, n), turned_back(frame.A, t)
    inner = turned_back(frame.A, lever)
    for e in range(mean.number):
        p = mean.a if e == 0 else (mean.b if e == 1 else mean.c)
        add_material(points, q, frame, p, sign * mean.w[e], inner, a, b, rough, normal, first, second)


@kernel
def lay_side(
    points: SpatialPoints, q: FloatArray, frame: Frame, mean: Mean, lever: Vector, sign: float, n: Vector, t: Vector,
    rough: bool, normal: FloatArray, first: FloatArray, second: FloatArray,
) -> None:  # fmt: skip
    """Set the blocks of a side in the rows along n, t1 = t and t2 = n x t1 to sign times its velocity along them.

    lever, n, t: world axes. Unless it is ``rough`` there are no rows along t1 and t2.
    """
    if is_rigid(points, mean.a):
        lay_rigid(frame, mean_undeformed(points, mean), lever, sign, n, t, rough, normal, first, second)
    else:
        lay_flexible(points, q, frame, mean, lever, sign, n, t, rough, normal, first, second)
