"""States within a step in space: where pairs are followed that neither result of a trial has met."""

from __future__ import annotations

import math

from lcpflex.jit.kernel import FloatArray, kernel
from lcpflex.kinematics.spatial.logarithms import half_cotangent
from lcpflex.kinematics.spatial.rotations import Vector, compose, conjugate, cross, exponential, logarithm, unit
from lcpflex.model.spatial import N_PLACE, N_RIGID, SpatialModel
from lcpflex.steppers.backup import Backup
from lcpflex.steppers.recorder import Recorder
from lcpflex.steppers.unmet import MOST_PARTS, TURN

__all__ = ["fastest", "on_way", "parts_of"]


@kernel
def length(values: FloatArray, first: int) -> float:
    """Length of the vector of three components from ``first`` on."""
    x, y, z = values[first], values[first + 1], values[first + 2]
    return math.sqrt(x * x + y * y + z * z)


@kernel
def rate_of_turn(theta: Vector, omega: Vector) -> Vector:
    """thetadot of p = p0 o exp(theta) with the angular velocity omega in body axes: omega + theta x omega / 2 + ..."""
    e, _ = half_cotangent(theta[0] ** 2 + theta[1] ** 2 + theta[2] ** 2)
    once = cross(theta, omega)
    twice = cross(theta, once)
    return (
        omega[0] + 0.5 * once[0] + e * twice[0],
        omega[1] + 0.5 * once[1] + e * twice[1],
        omega[2] + 0.5 * once[2] + e * twice[2],
    )


@kernel
def on_way(model: SpatialModel, q: FloatArray, u: FloatArray, h: float, share: float, kept: Backup) -> None:
    """Configuration at a share of the step from what is kept to (q, u), into ``kept.at``.

    The cubic with the places and velocities of both ends; of rotations that of theta in p = p0 o exp(theta).
    """
    left = 1.0 - share
    part = share * share * (3.0 - 2.0 * share)
    first = h * share * left * left
    last = h * share * share * left
    at, old = kept.at, kept.q
    dof, place = model.bodies.dof, model.bodies.place
    for b in range(len(place) - 1):
        i, d = place[b], dof[b]
        for k in range(3):
            at[i + k] = old[i + k] + part * (q[i + k] - old[i + k]) + first * kept.u[d + k] - last * u[d + k]
        before = (old[i + 3], old[i + 4], old[i + 5], old[i + 6])
        theta = logarithm(compose(conjugate(before), (q[i + 3], q[i + 4], q[i + 5], q[i + 6])))
        rate = rate_of_turn(theta, (u[d + 3], u[d + 4], u[d + 5]))
        turn = exponential(
            part * theta[0] + first * kept.u[d + 3] - last * rate[0],
            part * theta[1] + first * kept.u[d + 4] - last * rate[1],
            part * theta[2] + first * kept.u[d + 5] - last * rate[2],
        )
        w, x, y, z = unit(compose(before, turn))
        at[i + 3] = w
        at[i + 4] = x
        at[i + 5] = y
        at[i + 6] = z
        for k in range(dof[b + 1] - d - N_RIGID):
            e, f = i + N_PLACE + k, d + N_RIGID + k
            at[e] = old[e] + part * (q[e] - old[e]) + first * kept.u[f] - last * u[f]


@kernel
def fastest(model: SpatialModel, u: FloatArray, recorder: Recorder) -> float:
    """Largest speed of a point of a surface [m/s], at most; infinite where bodies are unknown."""
    largest = math.inf if len(model.bodies.mass) == 0 else 0.0
    for b in range(len(model.bodies.mass)):
        d = model.bodies.dof[b]
        modal = 0.0
        for m in range(d + N_RIGID, model.bodies.dof[b + 1]):
            modal += abs(u[m])
        speed = length(u, d) + recorder.farthest * length(u, d + 3) + recorder.deflection[b] * modal
        largest = max(largest, speed)
    return largest


@kernel
def parts_of(model: SpatialModel, h: float, speed: float, u: FloatArray, kept: Backup) -> int:
    """Into how many parts a step is divided: in each, bodies turn little and travel less than the smallest surface."""
    most = 1.0
    for b in range(len(model.bodies.mass)):
        d = model.bodies.dof[b]
        most = max(most, h * max(length(u, d + 3), length(kept.u, d + 3)) / TURN)
    for extent in model.contacts.surface_extent:
        if extent > 0.0:
            most = max(most, 0.5 * h * speed / extent)
    return math.ceil(min(most, float(MOST_PARTS)))
