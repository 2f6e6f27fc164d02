"""Coaxial impact of meshed solids of revolution: no law of contact stiffness, no coefficient of restitution."""

from __future__ import annotations

import numpy as np

from lcpflex.bodies.body import Body
from lcpflex.bodies.fem import meshes
from lcpflex.bodies.reduction.component_modes import residual_compliance
from lcpflex.bodies.solid_of_revolution import SolidOfRevolution
from lcpflex.errors import in_range
from lcpflex.gallery.mechanisms.arguments import checked
from lcpflex.runs.case import Case
from lcpflex.scene.joints.prismatic import Prismatic
from lcpflex.scene.scene import Scene
from lcpflex.steppers.massless_boundary.stepper import MasslessBoundary

__all__ = ["meshed_ball", "meshed_rod", "meshed_sphere_on_rod"]

RADIUS = 0.015  # of the ball [m]
LENGTH = 1.0  # of the rod [m]
REACH = 7.5e-4  # distance from the axis up to which nodes may touch: the contact patch has a radius of 0.45 mm
FINEST = 2e-5  # edge of an element at the contact [m]
ORDER = 1  # linear elements: forces of contact are smooth from node to node, and nothing bends or is incompressible


@checked
def meshed_rod(finest: float = 5e-5, size: float = 5e-3, modes: int = 20) -> Body:
    """An aluminium rod of 1 m, 20 mm thick, along x; "tip": nodes around the middle of its left end, (0, 0).

    ``finest`` [m] is the edge of an element there, from 20 micrometres on, ``size`` the largest one, from 2 mm on.
    """
    _check_edges(finest, size, 2e-3)
    mesh = meshes.half_section_of_rod(LENGTH, 0.01, size, finest=finest, within=REACH, order=ORDER)
    solid = SolidOfRevolution(
        mesh,
        density=2700.0,
        youngs_modulus=69e9,
        poissons_ratio=0.33,
        sets={"tip": lambda x, y: (x < 1e-9) & (y < REACH), "far": lambda x, y: (x > LENGTH - 1e-9) & (y < 1e-9)},
    )
    return residual_compliance(solid, "tip", modes)


@checked
def meshed_ball(finest: float = 5e-5, size: float = 2e-3, modes: int = 20) -> Body:
    """A steel ball of radius 15 mm about the origin; "tip": nodes around its pole (0.015, 0).

    ``finest`` [m] is the edge of an element there, from 20 micrometres on, ``size`` the largest one, from 1 mm on.
    """
    _check_edges(finest, size, 1e-3)
    mesh = meshes.half_section_of_sphere(RADIUS, size, finest=finest, within=REACH, order=ORDER)
    solid = SolidOfRevolution(
        mesh,
        density=7780.0,
        youngs_modulus=210e9,
        poissons_ratio=0.3,
        sets={
            "tip": lambda x, y: (np.hypot(x, y) > RADIUS - 1e-9) & (y < REACH) & (x > 0.0),
            "far": lambda x, y: x < -RADIUS + 1e-9,
        },
    )
    return residual_compliance(solid, "tip", modes)


@checked
def meshed_sphere_on_rod(finest: float = 5e-5, speed: float = 0.3, modes: int = 20) -> Scene:
    """The impact of :func:`sphere_on_rod` with two elastic meshes, ``finest`` [m] where they touch.

    Each body keeps its ``modes`` lowest modes; the others are the compliance of its contact nodes, exactly with
    ``MasslessBoundary(dynamic_modes=modes)``. The ball is the node side of its contact with the rod.
    """
    scene = Scene(gravity=(0.0, 0.0))
    rod = scene.add(meshed_rod(finest, modes=modes), "rod")
    ball = scene.add(meshed_ball(finest, modes=modes), "ball", position=(-RADIUS, 0.0), velocity=(speed, 0.0))
    for body, place in ((rod, LENGTH), (ball, -2.0 * RADIUS)):
        scene.join(Prismatic(body.point("far"), scene.ground.at(place, 0.0), axis=(1.0, 0.0)))
    tip = ball.surface("tip")
    scene.contact(tip, rod.surface("tip"), name="ball", node_side=tip)
    return scene


def _check_edges(finest: float, size: float, least: float) -> None:
    """Refuse edges that make a mesh whose reduction takes minutes, and that no element has."""
    in_range("size", size, least, LENGTH)
    in_range("finest", finest, FINEST, size)


def cases() -> tuple[Case, ...]:
    """The cases of this module."""
    return (
        Case(
            "meshed_sphere_on_rod",
            "steel ball on the end of an aluminium rod, two elastic meshes: indentation and waves make the loss",
            meshed_sphere_on_rod,
            2.5e-4,
            MasslessBoundary(step=1.5e-7, dynamic_modes=20),
            {"contact_time": 1.9357e-4, "force": 467.78, "ball": -0.45375, "rod": 0.18850, "restitution": 0.64225},
            "Hertz' law and one-dimensional waves: another model of the same, some per cent away",
        ),
    )
