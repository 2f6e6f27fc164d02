"""Spatial twins of planar bodies and scenes, for what must come out alike."""

from __future__ import annotations

import math

import numpy as np

from lcpflex.bodies.body import Body, MaterialPoint
from lcpflex.bodies.spatial.body import SpatialBody, SpatialPoint
from lcpflex.jit.kernel import FloatArray

__all__ = ["about_z", "at", "twin"]


def twin(body: Body) -> SpatialBody:
    """A planar body in space: the same integrals in its plane, and some moment about axes in the plane.

    Of <x Phi^T> and <Phi Phi^T> a planar body knows the trace and the skew part, as its motion depends on no more.
    """
    n = body.modes
    first, products = np.zeros((n, 3, 3)), np.zeros((n, n, 3, 3))
    coupling = np.zeros((n, n)) if body.coupling is None else body.coupling
    first[:, 0, 0] = first[:, 1, 1] = 0.5 * body.a
    first[:, 0, 1] = 0.5 * body.c
    first[:, 1, 0] = -0.5 * body.c
    products[:, :, 0, 0] = products[:, :, 1, 1] = 0.5 * np.eye(n)
    # D_lk = <Phi_l^T J^T Phi_k> = <Phi_l,x Phi_k,y> - <Phi_l,y Phi_k,x>
    products[:, :, 0, 1] = 0.5 * coupling
    products[:, :, 1, 0] = -0.5 * coupling
    moment = np.append(body.moment, 0.0)
    about_centre = body.inertia - float(moment @ moment) / body.mass
    second = np.outer(moment, moment) / body.mass + about_centre * np.diag([0.5, 0.5, 0.1])
    return SpatialBody(
        mass=body.mass,
        second=second,
        moment=moment,
        stiffness=body.stiffness,
        damping=body.damping,
        S=np.column_stack([body.S, np.zeros(n)]),
        first=first.reshape(n, 9),
        products=products.reshape(n, n, 9),
        points={name: at(point) for name, point in body.points.items()},
    )


def at(point: MaterialPoint) -> SpatialPoint:
    """A planar material point in space."""
    n = len(point.psi)
    return SpatialPoint(
        np.append(point.place, 0.0),
        np.column_stack([np.reshape(point.phi, (n, 2)), np.zeros(n)]),
        np.column_stack([np.zeros((n, 2)), point.psi]),
    )


def about_z(angle: float) -> FloatArray:
    """Rotation matrix of a planar angle."""
    cos, sin = math.cos(angle), math.sin(angle)
    return np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
