"""A side of a contact in space: a mean of material points of one body, and a lever from there to where it touches.

    r = sum_a w_a r_a,   v = L u = sum_a w_a L_a u + (sum_a w_a Omega_a) x lever

The weights w_a, which sum to 1, and the lever are frozen in a row: they slide with the contact in its bias alone.
"""

from __future__ import annotations

from typing import NamedTuple

from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.kinematics.spatial.rotations import Matrix, Vector, cross, rotation_matrix, tangent, tangent_rate
from lcpflex.kinematics.spatial.vectors import (
    IDENTITY,
    NOTHING,
    added,
    apart_from,
    is_zero,
    row_vector,
    scaled,
    turned,
    turned_back,
)
from lcpflex.model.spatial import N_PLACE, N_RIGID, SpatialBodies, SpatialPoints

__all__ = [
    "AT_REST",
    "Frame",
    "Mean",
    "MeanMotion",
    "Motion",
    "frame_motion",
    "frame_of",
    "is_rigid",
    "lay_side",
    "line_between",
    "line_rate",
    "mean_motion",
    "mean_place",
    "mean_spin",
    "mean_velocity",
    "place_in",
    "point_spin",
    "rigid_bias",
    "seen_from",
    "single",
    "world_place",
]


class Frame(NamedTuple):
    """Of a body; of the ground, the world."""

    origin: Vector  # R [m]
    A: Matrix
    modal: int  # where its modal coordinates begin in q


class Motion(NamedTuple):
    """Of a frame."""

    v: Vector  # [m/s], world axes
    omega: Vector  # [rad/s], body axes
    modal: int  # where its modal velocities begin in u


class Mean(NamedTuple):
    """Material points a, b, c of one body, ``number`` of them, and their weights."""

    number: int
    a: int
    b: int
    c: int
    w: Vector


class MeanMotion(NamedTuple):
    """Of a mean of material points with frozen weights: rdot = v, rddot = L udot + b; world axes."""

    v: Vector  # [m/s]
    b: Vector  # [m/s^2]


GROUND = Frame(NOTHING, IDENTITY, 0)
STILL = Motion(NOTHING, NOTHING, 0)
AT_REST = MeanMotion(NOTHING, NOTHING)


@kernel
def single(p: int) -> Mean:
    """Point p alone."""
    return Mean(1, p, p, p, (1.0, 0.0, 0.0))


@kernel
def frame_of(bodies: SpatialBodies, q: FloatArray, b: int) -> Frame:
    """Of body b; -1: the ground."""
    if b < 0:
        return GROUND
    at = bodies.place[b]
    A = rotation_matrix(q[at + 3], q[at + 4], q[at + 5], q[at + 6])
    return Frame((q[at], q[at + 1], q[at + 2]), A, at + N_PLACE)


@kernel
def frame_motion(bodies: SpatialBodies, u: FloatArray, b: int) -> Motion:
    """Of body b; -1: the ground."""
    if b < 0:
        return STILL
    d = bodies.dof[b]
    return Motion((u[d], u[d + 1], u[d + 2]), (u[d + 3], u[d + 4], u[d + 5]), d + N_RIGID)


@kernel
def is_rigid(points: SpatialPoints, p: int) -> bool:
    """Whether the body of point p has no modes, or is the ground."""
    return bool(points.start[p + 1] == points.start[p])


@kernel
def modal_sum(points: SpatialPoints, field: FloatArray, p: int, values: FloatArray, modal: int) -> Vector:
    """Phi e or Psi e of point p, the field being phi or psi, for the e that begin at ``modal`` of ``values``."""
    x = y = z = 0.0
    start = points.start[p]
    for k in range(points.start[p + 1] - start):
        e = values[modal + k]
        x += field[start + k, 0] * e
        y += field[start + k, 1] * e
        z += field[start + k, 2] * e
    return x, y, z


@kernel
def place_in(points: SpatialPoints, q: FloatArray, frame: Frame, p: int) -> Vector:
    """s of point p [m], in its frame."""
    place = row_vector(points.place, p)
    if is_rigid(points, p):
        return place
    return added(place, modal_sum(points, points.phi, p, q, frame.modal))


@kernel
def world_place(frame: Frame, s: Vector) -> Vector:
    """R + A s [m]."""
    return added(frame.origin, turned(frame.A, s))


@kernel
def seen_from(frame: Frame, r: Vector) -> Vector:
    """A^T (r - R) [m]."""
    return turned_back(frame.A, apart_from(r, frame.origin))


@kernel
def flow_in(points: SpatialPoints, u: FloatArray, motion: Motion, p: int) -> Vector:
    """Phi etadot of point p [m/s], in its frame."""
    if is_rigid(points, p):
        return NOTHING
    return modal_sum(points, points.phi, p, u, motion.modal)


@kernel
def weighted(mean: Mean, a: Vector, b: Vector, c: Vector) -> Vector:
    """The mean of three vectors."""
    return added(added(scaled(mean.w[0], a), scaled(mean.w[1], b)), scaled(mean.w[2], c))


@kernel
def mean_undeformed(points: SpatialPoints, mean: Mean) -> Vector:
    """Mean place [m], undeformed, in the frame."""
    a = row_vector(points.place, mean.a)
    if mean.number == 1:
        return a
    b = row_vector(points.place, mean.b)
    return weighted(mean, a, b, row_vector(points.place, mean.c) if mean.number == 3 else NOTHING)


@kernel
def mean_shape(points: SpatialPoints, values: FloatArray, modal: int, mean: Mean) -> Vector:
    """Mean Phi e of the modal numbers e that begin at ``modal`` of ``values``, in the frame."""
    a = modal_sum(points, points.phi, mean.a, values, modal)
    if mean.number == 1:
        return a
    b = modal_sum(points, points.phi, mean.b, values, modal)
    c = modal_sum(points, points.phi, mean.c, values, modal) if mean.number == 3 else NOTHING
    return weighted(mean, a, b, c)


@kernel
def mean_place(points: SpatialPoints, q: FloatArray, frame: Frame, mean: Mean) -> Vector:
    """Mean s [m], in the frame."""
    place = mean_undeformed(points, mean)
    if is_rigid(points, mean.a):
        return place
    return added(place, mean_shape(points, q, frame.modal, mean))


@kernel
def mean_flow(points: SpatialPoints, u: FloatArray, motion: Motion, mean: Mean) -> Vector:
    """Mean Phi etadot [m/s], in the frame."""
    if is_rigid(points, mean.a):
        return NOTHING
    return mean_shape(points, u, motion.modal, mean)


@kernel
def mean_velocity(
    points: SpatialPoints, q: FloatArray, u: FloatArray, frame: Frame, motion: Motion, mean: Mean
) -> Vector:
    """v [m/s], world axes."""
    sweep = cross(motion.omega, mean_place(points, q, frame, mean))
    return added(motion.v, turned(frame.A, added(sweep, mean_flow(points, u, motion, mean))))


@kernel
def rigid_bias(frame: Frame, motion: Motion, s: Vector) -> Vector:
    """b [m/s^2] of a place s in a rigid body, world axes."""
    return turned(frame.A, cross(motion.omega, cross(motion.omega, s)))


@kernel
def rigid_motion(frame: Frame, motion: Motion, s: Vector) -> MeanMotion:
    """Of a place s in a rigid body."""
    sweep = cross(motion.omega, s)
    return MeanMotion(added(motion.v, turned(frame.A, sweep)), turned(frame.A, cross(motion.omega, sweep)))


@kernel
def flexible_motion(
    points: SpatialPoints, q: FloatArray, u: FloatArray, frame: Frame, motion: Motion, mean: Mean
) -> MeanMotion:
    """v and b in a flexible body, the weights being frozen."""
    sweep = cross(motion.omega, added(mean_undeformed(points, mean), mean_shape(points, q, frame.modal, mean)))
    flow = mean_shape(points, u, motion.modal, mean)
    bias = cross(motion.omega, added(sweep, scaled(2.0, flow)))
    return MeanMotion(added(motion.v, turned(frame.A, added(sweep, flow))), turned(frame.A, bias))


@kernel
def mean_motion(
    points: SpatialPoints, q: FloatArray, u: FloatArray, frame: Frame, motion: Motion, mean: Mean
) -> MeanMotion:
    """v and b, the weights being frozen."""
    if is_rigid(points, mean.a):
        return rigid_motion(frame, motion, mean_undeformed(points, mean))
    return flexible_motion(points, q, u, frame, motion, mean)


@kernel
def point_spin(
    points: SpatialPoints, q: FloatArray, u: FloatArray, frame: Frame, motion: Motion, p: int
) -> tuple[Vector, Vector]:
    """Omega of the material at point p [rad/s], and Omegadot at udot = 0 [rad/s^2]; world axes."""
    if is_rigid(points, p):
        return turned(frame.A, motion.omega), NOTHING
    psi = modal_sum(points, points.psi, p, q, frame.modal)
    rate = modal_sum(points, points.psi, p, u, motion.modal)
    spin = turned(tangent(psi[0], psi[1], psi[2]), rate)
    turn = added(cross(motion.omega, spin), turned(tangent_rate(psi, rate), rate))
    return turned(frame.A, added(motion.omega, spin)), turned(frame.A, turn)


@kernel
def mean_spin(
    points: SpatialPoints, q: FloatArray, u: FloatArray, frame: Frame, motion: Motion, mean: Mean, slide: float
) -> tuple[Vector, Vector]:
    """Mean Omega of one point, or of two whose second weight grows by ``slide`` [1/s]; and its rate at udot = 0."""
    spin, turn = point_spin(points, q, u, frame, motion, mean.a)
    if mean.number == 1 or is_rigid(points, mean.a):
        return spin, turn
    other, rate = point_spin(points, q, u, frame, motion, mean.b)
    turn = added(weighted(mean, turn, rate, NOTHING), scaled(slide, apart_from(other, spin)))
    return weighted(mean, spin, other, NOTHING), turn


@kernel
def line_between(points: SpatialPoints, q: FloatArray, frame: Frame, a: int, b: int) -> Vector:
    """s_b - s_a [m], in the frame."""
    return apart_from(place_in(points, q, frame, b), place_in(points, q, frame, a))


@kernel
def line_rate(
    points: SpatialPoints, u: FloatArray, frame: Frame, motion: Motion, a: int, b: int, line: Vector
) -> Vector:
    """Rate of r_b - r_a [m/s], world axes; line: s_b - s_a."""
    rate = cross(motion.omega, line)
    if not is_rigid(points, a):
        rate = added(rate, apart_from(flow_in(points, u, motion, b), flow_in(points, u, motion, a)))
    return turned(frame.A, rate)


@kernel
def lay_block(row: FloatArray, sign: float, d: Vector, moment: Vector) -> None:
    """Set a block to sign times what v and omega do along d; its modal part to 0."""
    row[0] = sign * d[0]
    row[1] = sign * d[1]
    row[2] = sign * d[2]
    row[3] = sign * moment[0]
    row[4] = sign * moment[1]
    row[5] = sign * moment[2]
    for i in range(N_RIGID, len(row)):
        row[i] = 0.0


@kernel
def add_modes(
    points: SpatialPoints, field: FloatArray, p: int, a: Vector, b: Vector, c: Vector, normal: FloatArray,
    first: FloatArray, second: FloatArray,
) -> None:  # fmt: skip
    """Add Phi_k.d or Psi_k.d of all modes k, for d = a, b, c in the frame, to the three rows."""
    start = points.start[p]
    for k in range(points.start[p + 1] - start):
        x, y, z = field[start + k, 0], field[start + k, 1], field[start + k, 2]
        normal[N_RIGID + k] += x * a[0] + y * a[1] + z * a[2]
        first[N_RIGID + k] += x * b[0] + y * b[1] + z * b[2]
        second[N_RIGID + k] += x * c[0] + y * c[1] + z * c[2]


@kernel
def add_material(
    points: SpatialPoints, q: FloatArray, frame: Frame, p: int, weight: float, lever: Vector, n: Vector, t: Vector,
    normal: FloatArray, first: FloatArray, second: FloatArray,
) -> None:  # fmt: skip
    """Add what the modes do at point p along weight times n, t and n x t, by a lever; all in the frame."""
    a, b = scaled(weight, n), scaled(weight, t)
    c = cross(n, b)
    add_modes(points, points.phi, p, a, b, c, normal, first, second)
    if is_zero(lever):
        return
    psi = modal_sum(points, points.psi, p, q, frame.modal)
    T = tangent(psi[0], psi[1], psi[2])
    a, b, c = cross(lever, a), cross(lever, b), cross(lever, c)
    add_modes(points, points.psi, p, turned_back(T, a), turned_back(T, b), turned_back(T, c), normal, first, second)


@kernel
def lay_rigid(
    frame: Frame, s: Vector, lever: Vector, sign: float, n: Vector, t: Vector, normal: FloatArray, first: FloatArray,
    second: FloatArray,
) -> None:  # fmt: skip
    """The same of a rigid body, whose mean place is s."""
    a, b = turned_back(frame.A, n), turned_back(frame.A, t)
    arm = added(s, turned_back(frame.A, lever))
    lay_block(normal, sign, n, cross(arm, a))
    lay_block(first, sign, t, cross(arm, b))
    lay_block(second, sign, cross(n, t), cross(arm, cross(a, b)))


@kernel
def lay_flexible(
    points: SpatialPoints, q: FloatArray, frame: Frame, mean: Mean, lever: Vector, sign: float, n: Vector, t: Vector,
    normal: FloatArray, first: FloatArray, second: FloatArray,
) -> None:  # fmt: skip
    """The same of a flexible one: a kernel of its own, as its code slows down what rigid bodies pass through."""
    s = added(mean_undeformed(points, mean), mean_shape(points, q, frame.modal, mean))
    lay_rigid(frame, s, lever, sign, n, t, normal, first, second)
    a, b = turned_back(frame.A, n), turned_back(frame.A, t)
    inner = turned_back(frame.A, lever)
    for e in range(mean.number):
        p = mean.a if e == 0 else (mean.b if e == 1 else mean.c)
        add_material(points, q, frame, p, sign * mean.w[e], inner, a, b, normal, first, second)


@kernel
def lay_side(
    points: SpatialPoints, q: FloatArray, frame: Frame, mean: Mean, lever: Vector, sign: float, n: Vector, t: Vector,
    normal: FloatArray, first: FloatArray, second: FloatArray,
) -> None:  # fmt: skip
    """Set the blocks of a side in the rows along n, t1 = t and t2 = n x t1 to sign times its velocity along them.

    lever, n, t: world axes.
    """
    if is_rigid(points, mean.a):
        lay_rigid(frame, mean_undeformed(points, mean), lever, sign, n, t, normal, first, second)
    else:
        lay_flexible(points, q, frame, mean, lever, sign, n, t, normal, first, second)
