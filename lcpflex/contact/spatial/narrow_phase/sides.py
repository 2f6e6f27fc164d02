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
    "line_between",
    "line_rate",
    "mean_motion",
    "mean_place",
    "mean_shape",
    "mean_spin",
    "mean_undeformed",
    "mean_velocity",
    "modal_sum",
    "place_in",
    "point_spin",
    "rigid_bias",
    "seen_from",
    "single",
    "three_places",
    "three_sums",
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
def modal_sums(
    points: SpatialPoints, field: FloatArray, p: int, x: FloatArray, at: int, y: FloatArray, beside: int
) -> tuple[Vector, Vector]:
    """:func:`modal_sum` of two: the e that begin at ``at`` of x, and at ``beside`` of y. They wait for memory once."""
    a = b = c = d = e = f = 0.0
    start = points.start[p]
    for k in range(points.start[p + 1] - start):
        u, v, w = field[start + k, 0], field[start + k, 1], field[start + k, 2]
        first, second = x[at + k], y[beside + k]
        a += u * first
        b += v * first
        c += w * first
        d += u * second
        e += v * second
        f += w * second
    return (a, b, c), (d, e, f)


@kernel
def three_sums(
    points: SpatialPoints, a: int, b: int, c: int, values: FloatArray, modal: int
) -> tuple[Vector, Vector, Vector]:
    """Phi e of three points of one body, as :func:`modal_sum`: nine sums side by side take little longer than three."""
    x = y = z = 0.0
    u = v = w = 0.0
    d = e = f = 0.0
    i, j, m, phi = points.start[a], points.start[b], points.start[c], points.phi
    for k in range(points.start[a + 1] - i):
        value = values[modal + k]
        x += phi[i + k, 0] * value
        y += phi[i + k, 1] * value
        z += phi[i + k, 2] * value
        u += phi[j + k, 0] * value
        v += phi[j + k, 1] * value
        w += phi[j + k, 2] * value
        d += phi[m + k, 0] * value
        e += phi[m + k, 1] * value
        f += phi[m + k, 2] * value
    return (x, y, z), (u, v, w), (d, e, f)


@kernel
def three_places(
    points: SpatialPoints, q: FloatArray, frame: Frame, a: int, b: int, c: int
) -> tuple[Vector, Vector, Vector]:
    """s of three points of one body [m], in its frame."""
    first, second, third = row_vector(points.place, a), row_vector(points.place, b), row_vector(points.place, c)
    if is_rigid(points, a):
        return first, second, third
    e, f, g = three_sums(points, a, b, c, q, frame.modal)
    return added(first, e), added(second, f), added(third, g)


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
def mean_shapes(
    points: SpatialPoints, x: FloatArray, at: int, y: FloatArray, beside: int, mean: Mean
) -> tuple[Vector, Vector]:
    """:func:`mean_shape` of the e that begin at ``at`` of x, and of those at ``beside`` of y."""
    a, d = modal_sums(points, points.phi, mean.a, x, at, y, beside)
    if mean.number == 1:
        return a, d
    b, e = modal_sums(points, points.phi, mean.b, x, at, y, beside)
    c, f = modal_sums(points, points.phi, mean.c, x, at, y, beside) if mean.number == 3 else (NOTHING, NOTHING)
    return weighted(mean, a, b, c), weighted(mean, d, e, f)


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
    shape, flow = mean_shapes(points, q, frame.modal, u, motion.modal, mean)
    sweep = cross(motion.omega, added(mean_undeformed(points, mean), shape))
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
