"""A steel pendulum strikes an aluminium rod, both solids: the example of Chen, Liu & Hong 2015, in space.

Printed are steel, aluminium and a circle of contact of 0.8 mm; all lengths are lost. Chosen: a pendulum of
0.5 x 0.02 x 0.02 m that hangs on its upper end, with a round nose of 15 mm radius 0.45 m below, and a free rod of 1 m
with the section of a circle of 10 mm radius, made square. At 1 m/s the circle of contact is 0.78 mm.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np

from lcpflex.basics.arguments import whole_number
from lcpflex.bodies.fem.mesh import Mesh
from lcpflex.bodies.fem.shape_grids import Block
from lcpflex.bodies.solid import Solid
from lcpflex.bodies.spatial.body import SpatialBody
from lcpflex.gallery.mechanisms.strikers import graded
from lcpflex.jit.kernel import FloatArray
from lcpflex.scene.joints.revolute import Revolute
from lcpflex.scene.spatial.scene import SpatialScene

__all__ = ["NOSE", "REACH", "solid_pendulum", "solid_pendulum_and_rod", "solid_rod"]

STEEL = {"density": 7850.0, "youngs_modulus": 2.1e11, "poissons_ratio": 0.3}
ALUMINIUM = {"density": 2700.0, "youngs_modulus": 7e10, "poissons_ratio": 0.33}
LENGTH, WIDTH, STRIKE, NOSE = 0.5, 0.02, 0.45, 0.015  # of the pendulum [m]
RISE = 3e-4  # of the nose over its face [m]: a cap of 3 mm radius
ROD, ROUND = 1.0, 0.01  # length and radius [m]
FINE = 2.8e-4  # elements of the contact region [m]: 2.8 along the radius of contact
REACH = 1.12e-3  # half of the contact region [m]
GROWTH, FASTER = 2.5, 3.0  # of elements from one to the next, away from it, in pendulum and rod
GAP = 1e-8  # at the start [m]


def solid_pendulum(
    fine: float = FINE, coarse: float = 8.5e-3, layers: int | None = None, reach: float = REACH
) -> Solid:
    """The pendulum, its nose at the origin, striking along x; it hangs along z.

    Elements are ``fine`` [m] in the region of contact, the face "contact", grow away from it and are at most ``coarse``
    long. In the direction of impact they grow from ``fine`` as well, or there are ``layers`` of one depth. "hinge" is
    the upper end face, "back" the point of the rear face right behind the contact.
    """
    reach = fine * round(reach / fine)
    up, down = (graded(way, fine, reach, coarse, GROWTH) for way in (STRIKE, LENGTH - STRIKE))
    half = graded(0.5 * WIDTH, fine, reach, coarse, GROWTH)
    deep = graded(WIDTH, fine, 2.0 * fine, coarse, GROWTH)
    if layers is not None:
        deep = np.linspace(0.0, WIDTH, whole_number("layers", layers, 1, 1000) + 1)
    mesh = block(-deep[::-1], mirrored(half), mirrored(down, up))
    x, y, z = mesh.places.T
    near = np.flatnonzero((x > -1e-9) & (np.maximum(abs(y), abs(z)) < reach + 0.1 * fine))
    back = int(np.argmin(np.hypot(np.hypot(x + WIDTH, y), z)))
    hinge = np.flatnonzero(z > STRIKE - 1e-9)
    bulge = (1.0 + x / WIDTH) * np.maximum(RISE - (y**2 + z**2) / (2.0 * NOSE), 0.0)
    mesh = replace(mesh, places=np.column_stack([x + bulge - RISE, y, z]))
    return Solid(mesh, sets={"contact": near, "back": [back], "hinge": hinge}, **STEEL)


def solid_rod(fine: float = FINE, coarse: float = 0.05, reach: float = REACH) -> Solid:
    """The rod along x, its end face at the origin, with elements ``fine`` [m] in the region of contact, "contact".

    Its nodes lie half an element aside from those of a pendulum as fine: a node that met a node would change from one
    facet to the next for nothing.
    """
    reach = fine * round(reach / fine)
    side = 0.5 * math.sqrt(math.pi) * ROUND
    half = 0.5 * fine + graded(side - 0.5 * fine, fine, reach, 2.0 * ROUND, FASTER)
    across = np.concatenate([-half[::-1], half])
    mesh = block(graded(ROD, fine, 2.0 * fine, coarse, FASTER), across, across)
    x, y, z = mesh.places.T
    near = np.flatnonzero((x < 1e-9) & (np.maximum(abs(y), abs(z)) < reach + 0.6 * fine))
    return Solid(mesh, sets={"contact": near}, **ALUMINIUM)


def block(*lines: FloatArray) -> Mesh:
    """Hexahedra between lines of x, y and z."""
    low, high = (np.array([line[end] for line in lines]) for end in (0, -1))
    return Block(low, high).mesh(lines)


def mirrored(below: FloatArray, above: FloatArray | None = None) -> FloatArray:
    """Places on both sides of 0; those below are as those above where these are not given."""
    return np.concatenate([-below[:0:-1], below if above is None else above])


def solid_pendulum_and_rod(
    pendulum: SpatialBody, rod: SpatialBody, speed: float = 1.0, law: Any | None = None
) -> SpatialScene:
    """The nodes of the pendulum's nose meet the end of the rod at ``speed`` [m/s]; no gravity, no friction.

    Bodies are those that the solids above were reduced to.
    """
    scene = SpatialScene(gravity=(0.0, 0.0, 0.0))
    spin = np.array([0.0, -speed / STRIKE, 0.0])
    hinge = np.array([-0.5 * WIDTH - RISE, 0.0, STRIKE])
    start = np.array([GAP, 0.0, 0.0])
    swinging = scene.add(
        pendulum, name="pendulum", position=pendulum.origin - start,
        velocity=np.cross(spin, pendulum.origin - hinge), angular_velocity=spin,
    )  # fmt: skip
    struck = scene.add(rod, name="rod", position=rod.origin)
    pivot = scene.ground.at(*(hinge - start).tolist())
    scene.join(Revolute(swinging.point("hinge"), pivot, axis=(0.0, 1.0, 0.0), name="hinge"))
    nose = swinging.face("contact")
    given = {} if law is None else {"law": law}
    scene.contact(nose, struck.face("contact"), points="nodes", node_side=nose, name="strike", **given)
    return scene
