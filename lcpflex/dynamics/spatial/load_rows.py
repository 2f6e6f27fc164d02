"""How points and stretches of springs in space move with all velocities: rows of their velocities, once in a run."""

from __future__ import annotations

from lcpflex.dynamics.spatial.applied_forces import directions, stretch
from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.kinematics.spatial.points import add_wrench, arm_of
from lcpflex.kinematics.spatial.relative import (
    add_gradient,
    apart,
    coordinate_gradient,
    coordinate_rate,
    relative_motion,
)
from lcpflex.kinematics.spatial.vectors import NOTHING
from lcpflex.model.spatial import SpatialModel

__all__ = ["point_rows", "spring_blocks", "spring_row"]


@kernel
def point_rows(model: SpatialModel, q: FloatArray, p: int, rows: FloatArray) -> None:
    """rows (6, nu) += L and L^r of material point p: rdot_P and Omega_P, world axes, by u; nothing for the ground."""
    b = model.points.body[p]
    if b < 0:
        return
    arm = arm_of(model.bodies, model.points, q, p)
    first = model.bodies.dof[b]
    last = model.bodies.dof[b + 1]
    for i in range(3):
        unit = (1.0 if i == 0 else 0.0, 1.0 if i == 1 else 0.0, 1.0 if i == 2 else 0.0)
        add_wrench(model.points, p, arm, unit, NOTHING, rows[i, first:last])
        add_wrench(model.points, p, arm, NOTHING, unit, rows[3 + i, first:last])


@kernel
def spring_row(model: SpatialModel, q: FloatArray, k: int, row: FloatArray) -> None:
    """row (nu,) += that of the rate of the relative coordinate that spring k resists."""
    loads, points, dof = model.loads, model.points, model.bodies.dof
    i = loads.spring_point[k, 0]
    j = loads.spring_point[k, 1]
    at, arms = apart(model.bodies, points, q, i, j)
    gradient = coordinate_gradient(loads.spring_kind[k], at, directions(loads, k))
    b = points.body[i]
    c = points.body[j]
    on_p = row[dof[b] : dof[b + 1]]  # empty for the ground, body -1
    on_q = row[dof[c] : dof[c + 1]]
    add_gradient(points, (i, j), arms, gradient, 1.0, on_p, on_q)


@kernel
def spring_blocks(
    model: SpatialModel, q: FloatArray, u: FloatArray, k: int, on_p: FloatArray, on_q: FloatArray
) -> None:
    """Generalised forces (6 + n,) of spring and damper k, added for P and Q each, which may be of one body."""
    loads, points = model.loads, model.points
    i = loads.spring_point[k, 0]
    j = loads.spring_point[k, 1]
    kind = loads.spring_kind[k]
    way = directions(loads, k)
    at, arms = apart(model.bodies, points, q, i, j)
    gradient = coordinate_gradient(kind, at, way)
    size = -loads.spring_value[k, 0] * stretch(kind, at, way, loads.spring_value[k, 2])
    if loads.spring_value[k, 1] != 0.0:
        size -= loads.spring_value[k, 1] * coordinate_rate(
            gradient, relative_motion(model.bodies, points, u, i, j, arms)
        )
    add_gradient(points, (i, j), arms, gradient, size, on_p, on_q)
