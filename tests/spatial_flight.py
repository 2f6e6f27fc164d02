"""Free flight in space: a rigid body near its unstable axis, an asymmetric flexible body, and what both conserve."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

import lcpflex as lf
from lcpflex.jit.kernel import FloatArray
from tests.spatial_bodies import MassBody, random_body

J = np.array([1.0, 2.0, 3.0])
OMEGA = (0.01, 5.0, 0.01)  # about the middle axis
VELOCITY = (1.0, 2.0, 3.0)
PERIOD = 10.0518582763  # 4 K(k) / Omega
# at t = 8, from spatial.md: eight digits
OMEGA_8 = np.array([4.04901407, 2.93352774, 2.33771363])
P_8 = np.array([0.88663647, -0.36676484, 0.0916551, 0.26638068])


def dzhanibekov() -> lf.SpatialScene:
    """R1: J = (1, 2, 3), thrown."""
    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    body = lf.SpatialBody(mass=1.0, inertia=np.diag(J))
    scene.add(body, angular_velocity=OMEGA, velocity=VELOCITY)
    return scene


def exact_flight(end: float) -> Any:
    """t -> (p, omega) of R1 by an independent integrator, to rounding."""

    def rate(t: float, y: FloatArray) -> FloatArray:
        p, omega = y[:4], y[4:]
        turn = 0.5 * np.array([-p[1:] @ omega, *(p[0] * omega + np.cross(p[1:], omega))])
        return np.array([*turn, *(-np.cross(omega, J * omega) / J)])

    start = [1.0, 0.0, 0.0, 0.0, *OMEGA]
    return solve_ivp(rate, (0.0, end), start, method="DOP853", rtol=1e-13, atol=1e-14, dense_output=True).sol


def flexible_body(given: MassBody, **elastic: Any) -> lf.SpatialBody:
    """A body of point masses in its mean frame; ``elastic``: stiffness, damping, points."""
    weights, modes = given.mass.sum(axis=0), given.n
    return lf.SpatialBody(
        mass=float(weights.sum()),
        second=given.places.T @ given.mass @ given.places,
        first=np.einsum("mi,mn,knj->kij", given.places, given.mass, given.shapes).reshape(modes, 9),
        products=np.einsum("lmi,mn,knj->lkij", given.shapes, given.mass, given.shapes).reshape(modes, modes, 9),
        **elastic,
    )


def flexible_flight(modes: int = 3) -> lf.SpatialScene:
    """A free asymmetric body of point masses, all of its inertia kept, that spins and vibrates."""
    given = random_body(np.random.default_rng(7), modes, centred=True)
    body = flexible_body(given, stiffness=40.0 * (1.0 + np.arange(modes)))
    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    eta = 0.05 * np.cos(np.arange(modes))
    scene.add(body, angular_velocity=(1.0, 2.0, -1.5), velocity=VELOCITY, modal=eta, modal_velocity=-eta)
    return scene


def angular_momenta(result: lf.Result) -> FloatArray:
    """(m, 3) A J omega of R1, about the mass centre, world axes."""
    turned = Rotation.from_quat(result.q[:, [4, 5, 6, 3]])
    return np.asarray(turned.apply(J * result.u[:, 3:6]))


def lengths(result: lf.Result) -> FloatArray:
    """(m,) of the first quaternion."""
    return np.asarray(np.linalg.norm(result.q[:, 3:7], axis=1))


def apart(p: FloatArray, other: FloatArray) -> float:
    """Largest difference of two quaternions of either sign."""
    return float(min(np.abs(p - other).max(), np.abs(p + other).max()))
