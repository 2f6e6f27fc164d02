"""Spatial scenes that tests share."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

import lcpflex as lf
from tests.spatial_bodies import MassBody, random_body

__all__ = ["flexible", "soft_body", "thrown"]


def soft_body() -> MassBody:
    """Point masses with three modes, no mean frame."""
    return random_body(np.random.default_rng(7), 3)


def flexible(body: MassBody) -> lf.SpatialBody:
    """A body of point masses by its integrals; its nodes are the points "0", "1", ..., which do not turn."""
    m = body.mass
    return lf.SpatialBody(
        mass=float(m.sum()),
        second=body.places.T @ m @ body.places,
        moment=m.sum(axis=0) @ body.places,
        stiffness=100.0 * np.asarray(body.stiffness),
        damping=np.asarray(body.damping),
        S=np.einsum("n,kni->ki", m.sum(axis=0), body.shapes),
        first=np.einsum("mi,mn,knj->kij", body.places, m, body.shapes).reshape(-1, 9),
        products=np.einsum("lmi,mn,knj->lkij", body.shapes, m, body.shapes).reshape(body.n, body.n, 9),
        points={
            str(i): lf.SpatialPoint(body.places[i], body.shapes[:, i], np.zeros((body.n, 3)))
            for i in range(len(body.places))
        },
    )


def thrown(*bodies: str) -> lf.SpatialScene:
    """A box that tumbles ("box"), a ball that spins about z ("ball") and a soft body ("soft"), or those asked for."""
    scene = lf.SpatialScene()
    if "box" in bodies or not bodies:
        turn = Rotation.from_rotvec([0.3, -0.2, 0.5])
        scene.add(lf.Cuboid(0.3, 0.2, 0.1, mass=2.0), "box", (0.1, 0.2, 1.0), turn, (1.0, -0.5, 2.0), (0.3, 5.0, 0.2))
    if "ball" in bodies or not bodies:
        scene.add(lf.Sphere(0.1, mass=1.0), "ball", (1.0, 0.0, 0.0), angular_velocity=(0.0, 0.0, 3.0))
    if "soft" in bodies or not bodies:
        scene.add(
            flexible(soft_body()),
            "soft",
            (0.0, -3.0, 1.0),
            velocity=(0.0, 1.0, 3.0),
            angular_velocity=(2.0, 1.0, -1.0),
            modal=(0.05, -0.02, 0.03),
        )
    return scene
