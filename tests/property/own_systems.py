"""Systems of the user's own with a mass matrix that changes, drawn at random, and where their points are.

"cart": a pendulum on a cart that may run into a wall. "polar", "cylindrical", "spherical": a particle over a rough
floor in these coordinates, x = x(q), so that M = m J^T J, h = m J^T (g - dJ/dt u), W = J^T n with J = dx/dq.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

import lcpflex as lf
from tests.property.random_scenes import Drawn

__all__ = ["own_points", "own_system"]

Array = npt.NDArray[np.float64]
BELOW = 0.3  # lengths from the origin down to the floor


def _units(name: str, q: Any) -> tuple[Array, Array]:
    """Unit vectors of the coordinates, as rows, and what their rates are multiplied by."""
    if name == "spherical":  # r, angle from the way up, angle about it
        (s, c), (sp, cp) = _sin_cos(q[1]), _sin_cos(q[2])
        return np.array([(s * cp, s * sp, c), (c * cp, c * sp, -s), (-sp, cp, 0.0)]), np.array([1.0, q[0], q[0] * s])
    s, c = _sin_cos(q[1])
    if name == "cylindrical":  # the axis is level, so that the way up is no coordinate
        return np.array([(c, 0.0, s), (-s, 0.0, c), (0.0, 1.0, 0.0)]), np.array([1.0, q[0], 1.0])
    return np.array([(c, s), (-s, c)]), np.array([1.0, q[0]])


def _sin_cos(angle: float) -> tuple[float, float]:
    return math.sin(angle), math.cos(angle)


def _jacobian(name: str, q: Any) -> Array:
    """dx/dq (d, n)."""
    vectors, scales = _units(name, q)
    return np.asarray((vectors * scales[:, None]).T)


def _place(name: str, q: Any) -> Array:
    """x (d,)."""
    along, _ = _units(name, q)
    x = q[0] * along[0]
    return np.asarray(x + q[2] * along[2] if name == "cylindrical" else x)


def _apparent(name: str, q: Any, u: Any) -> Array:
    """dJ/dt u (d,), by the formulas of each."""
    vectors, _ = _units(name, q)
    if name == "spherical":
        s, c = _sin_cos(q[1])
        parts = [
            -q[0] * (u[1] ** 2 + (s * u[2]) ** 2),
            2.0 * u[0] * u[1] - q[0] * s * c * u[2] ** 2,
            2.0 * u[2] * (u[0] * s + q[0] * u[1] * c),
        ]
    else:
        parts = [-q[0] * u[1] ** 2, 2.0 * u[0] * u[1], 0.0][: len(q)]
    return np.asarray(np.array(parts) @ vectors)


def own_system(drawn: Drawn) -> lf.UserSystem:
    """The system of a drawing."""
    return _cart(drawn) if drawn.system[0] == "cart" else _particle(drawn)


def _particle(drawn: Drawn) -> lf.UserSystem:
    name, (mass, L, g, _, told, *start) = drawn.system
    d = drawn.dimension
    up = np.eye(d)[-1]
    level = np.eye(d)[:-1].T  # (d, d - 1)

    def tangents(q: Any) -> Array:
        found = _jacobian(name, q).T @ level
        return found if d == 2 else found[:, None, :]

    begin = {"polar": (1.0, 0.3), "cylindrical": (1.0, 0.3, 0.0), "spherical": (1.0, 1.2, 0.3)}[name]
    q = np.array(begin) * np.array([L, 1.0, L if name == "cylindrical" else 1.0][:d])
    speed = drawn.speed * np.array(start[:d])
    potential: Any = (lambda q: mass * g * float(_place(name, q)[-1])) if told else None
    return lf.UserSystem(
        q=q,
        u=np.linalg.solve(_jacobian(name, q), speed),
        mass=lambda q: mass * _jacobian(name, q).T @ _jacobian(name, q),
        force=lambda t, q, u: -mass * _jacobian(name, q).T @ (g * up + _apparent(name, q, u)),
        gaps=lambda q: np.array([_place(name, q)[-1] + BELOW * L]),
        normals=lambda q: (_jacobian(name, q).T @ up)[:, None],
        tangents=tangents,
        friction=drawn.friction,
        restitution=drawn.restitution,
        potential=potential,
    )


def _cart(drawn: Drawn) -> lf.UserSystem:
    _, (mass, L, g, bob, told, *start) = drawn.system

    def inertia(q: Any) -> Array:
        swing = bob * L * math.cos(q[1])
        return np.array([[mass + bob, swing], [swing, bob * L**2]])

    def force(t: float, q: Any, u: Any) -> Array:
        return np.array([bob * L * math.sin(q[1]) * u[1] ** 2, -bob * g * L * math.sin(q[1])])

    return lf.UserSystem(
        q=[0.0, 1.5 * start[0]],
        u=[drawn.speed * start[1], drawn.speed / L * start[2]],
        mass=inertia,
        force=force,
        gaps=lambda q: np.array([0.3 * L - q[0]]),
        normals=np.array([[-1.0], [0.0]]),
        restitution=drawn.restitution,
        potential=(lambda q: -bob * g * L * math.cos(q[1])) if told else None,
    )


def own_points(drawn: Drawn, q: Array, u: Array) -> tuple[Array, Array]:
    """Places and velocities (m, points, d) at states."""
    name, (_, L, *_) = drawn.system
    if name == "cart":
        c, s = np.cos(q[:, 1]), np.sin(q[:, 1])
        zero = np.zeros(len(q))
        places = np.stack([q[:, 0], zero, q[:, 0] + L * s, -L * c], axis=1)
        rates = np.stack([u[:, 0], zero, u[:, 0] + L * c * u[:, 1], L * s * u[:, 1]], axis=1)
        return places.reshape(-1, 2, 2), rates.reshape(-1, 2, 2)
    places = np.array([_place(name, each) for each in q])
    rates = np.array([_jacobian(name, each) @ rate for each, rate in zip(q, u, strict=True)])
    return places[:, None], rates[:, None]
