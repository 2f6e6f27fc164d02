"""Directions in which bristles of contacts in space are known while their tangent plane turns.

The tangents of a contact table may jump, where another edge or facet is touched; states that are integrated must not.
So a bristle has its components along e = c - (c.n) n, normalised, and n x e, where c is an axis of the body of the
feature (of the world, where that is the ground) that is chosen when the contact begins. Its states are these two
components [m], the dwell, and the number of the axis. Where c comes near the normal, another axis takes its place, and
the components go over to it.

Bristles tilt with the tangent plane, and turn about its normal n as both bodies do on the mean, so that bodies that
turn together leave them as they are, whichever of both has the node. As e turns about n at the rate

    sigma = (n x e).(cdot - (c.n) ndot) / |c - (c.n) n|,   cdot = omega_j x c,

zdot has the part (n.(omega_i + omega_j)/2 - sigma) n x z in addition to that of the law of friction.
"""

from __future__ import annotations

from lcpflex.contact.spatial.pairs import normal_rate
from lcpflex.contact.spatial.table import SpatialContactTable
from lcpflex.dynamics.spatial.inertia import SpatialWork
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.kinematics.spatial.rotations import Matrix, Vector, cross, rotation_matrix
from lcpflex.kinematics.spatial.vectors import (
    IDENTITY,
    NOTHING,
    added,
    apart_from,
    dot,
    norm,
    row_vector,
    scaled,
    turned,
)
from lcpflex.model.spatial import SpatialModel

__all__ = ["AXIS", "DWELL", "STATES", "direction", "keep_bristles", "spin_of_bristles", "straighten", "turn_of"]

DWELL, AXIS, STATES = 2, 3, 4  # of a place, behind the two components
SLANTED = 0.5  # sine of the angle between axis and normal below which another axis is taken


@kernel
def axes_of(model: SpatialModel, q: FloatArray, b: int) -> Matrix:
    """Axes of a body as columns, world axes; of the world for the ground, and for a user's own system."""
    if b < 0 or len(model.bodies.mass) == 0:
        return IDENTITY
    d = model.bodies.place[b] + 3
    return rotation_matrix(q[d], q[d + 1], q[d + 2], q[d + 3])


@kernel
def projected(axes: Matrix, axis: int, n: Vector) -> Vector:
    """Part of a column of ``axes`` across the unit vector n."""
    c = (axes[axis], axes[3 + axis], axes[6 + axis])
    return added(c, scaled(-dot(c, n), n))


@kernel
def direction(model: SpatialModel, q: FloatArray, table: SpatialContactTable, k: int, axis: int) -> Vector:
    """e of entry k, of unit length; its first tangent, should it be no direction at all."""
    n = row_vector(table.normal, k)
    e = projected(axes_of(model, q, table.body[k, 1]), axis, n)
    size = norm(e)
    return scaled(1.0 / size, e) if size > 0.0 else row_vector(table.tangent, k)


@kernel
def spin_of(model: SpatialModel, q: FloatArray, u: FloatArray, b: int) -> Vector:
    """omega of a body, world axes; 0 of the ground."""
    if b < 0:
        return NOTHING
    d = model.bodies.dof[b] + 3
    return turned(axes_of(model, q, b), (u[d], u[d + 1], u[d + 2]))


@kernel
def spin_of_bristles(
    model: SpatialModel, q: FloatArray, u: FloatArray, table: SpatialContactTable, k: int, axis: int
) -> float:
    """Rate [rad/s] at which bristles of entry k turn about the normal, against e."""
    if len(model.bodies.mass) == 0:
        return 0.0
    n = row_vector(table.normal, k)
    axes = axes_of(model, q, table.body[k, 1])
    c = (axes[axis], axes[3 + axis], axes[6 + axis])
    across = projected(axes, axis, n)
    size = norm(across)
    i, j = spin_of(model, q, u, table.body[k, 0]), spin_of(model, q, u, table.body[k, 1])
    moved = apart_from(cross(j, c), scaled(dot(c, n), normal_rate(model, q, u, table, k)))
    own = dot(cross(n, across), moved) / (size * size) if size > 0.0 else 0.0
    return 0.5 * (dot(n, i) + dot(n, j)) - own


@kernel
def best_axis(model: SpatialModel, q: FloatArray, table: SpatialContactTable, k: int) -> int:
    """The axis that is most nearly across the normal of entry k."""
    axes = axes_of(model, q, table.body[k, 1])
    n = row_vector(table.normal, k)
    best = 0
    for axis in range(1, 3):
        if norm(projected(axes, axis, n)) > norm(projected(axes, best, n)):
            best = axis
    return best


@kernel
def turn_of(a: Vector, e: Vector, n: Vector) -> tuple[float, float]:
    """Cosine and sine of the angle from a to e about n, both across n and of unit length."""
    return dot(e, a), dot(e, cross(n, a))


@kernel
def straighten(
    model: SpatialModel, q: FloatArray, contacts: SpatialWork, k: int, states: FloatArray, place: int
) -> None:
    """The states of friction of entry k, which has begun."""
    if place < len(states):
        for j in range(AXIS):
            states[place, j] = 0.0
        states[place, AXIS] = best_axis(model, q, contacts.rows.table, k)


@kernel
def keep_bristles(
    model: SpatialModel, q: FloatArray, contacts: SpatialWork, k: int, states: FloatArray, place: int
) -> None:
    """The states of friction of entry k, which goes on: along another axis, where theirs is too near the normal."""
    if place >= len(states):
        return
    table = contacts.rows.table
    old = int(states[place, AXIS])
    n = row_vector(table.normal, k)
    if norm(projected(axes_of(model, q, table.body[k, 1]), old, n)) >= SLANTED:
        return
    axis = best_axis(model, q, table, k)
    before = direction(model, q, table, k, old)
    c, s = turn_of(before, direction(model, q, table, k, axis), n)
    first, second = states[place, 0], states[place, 1]
    states[place, 0] = c * first + s * second
    states[place, 1] = c * second - s * first
    states[place, AXIS] = axis
