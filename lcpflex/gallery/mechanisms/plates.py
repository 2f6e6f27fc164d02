"""A ball that strikes a large thin plate: what it does not get back goes off in waves (Zener 1941)."""

from __future__ import annotations

import math

import numpy as np

from lcpflex.bodies.spatial.body import SpatialBody, SpatialPoint
from lcpflex.bodies.spatial.rigid import Sphere
from lcpflex.errors import in_range
from lcpflex.force_laws.contact_law import ContactLaw
from lcpflex.force_laws.elastic.hertz import Hertz
from lcpflex.force_laws.elastic.materials import Material
from lcpflex.gallery.mechanisms.arguments import checked
from lcpflex.runs.case import Case
from lcpflex.scene.joints.weld import Weld
from lcpflex.scene.spatial.scene import SpatialScene
from lcpflex.steppers.smooth.stepper import ExplicitRungeKutta, Smooth

__all__ = ["BALL_SPEED", "BALL_TIME", "sphere_on_plate"]

RADIUS = 5e-3  # of the ball [m]
BALL_MASS = 4.0 / 3.0 * math.pi * RADIUS**3 * 7850.0  # [kg]
BALL_SPEED = 1.0  # [m/s]
GLASS = Material(7e10, 0.25)
GLASS_DENSITY = 2500.0  # [kg/m^3]
HERTZ = Hertz.sphere_on_plane(RADIUS, Material(2.1e11, 0.3), GLASS)
BALL_TIME = (BALL_MASS / (HERTZ.parameters[0] * math.sqrt(BALL_SPEED))) ** 0.4  # T0, unit of time of the impact [s]
MOST = 4000  # modes


@checked
def sphere_on_plate(inelasticity: float = 0.1, side: float = 20.0, cutoff: float = 50.0) -> SpatialScene:
    """A steel ball of 5 mm strikes the middle of a large thin glass plate at 1 m/s, with Hertz's law of contact.

    A large plate yields at F / (8 (D rho h)^(1/2)) [m/s] under a force F, so that the indentation s v_0 T0 obeys
    s'' + (1 + lambda d/dt) s^(3/2) = 0 in the unit T0 = (m / (K v_0^(1/2)))^(2/5) of time. Here it is a body with the
    modes of a square plate that is simply supported, of those which move its middle; errors fall as 1 / cutoff, as long
    as waves come back from the edges after the contact only.

    inelasticity: lambda = m / (8 (D rho h)^(1/2) T0), 0.001 to 10, for which the thickness h is chosen. side: of the
    plate in units of (D / (rho h))^(1/4) T0^(1/2), which is 15 mm by default; 1 to 100. cutoff: highest frequency of a
    mode, times T0, from that of the lowest one on, for at most 4000 modes.
    """
    in_range("inelasticity", inelasticity, 1e-3, 10.0)
    in_range("side", side, 1.0, 100.0)
    in_range("cutoff", cutoff, 2.0 * (math.pi / side) ** 2, 16.0 * MOST * math.pi / side**2)
    rigidity = GLASS.youngs_modulus / (12.0 * (1.0 - GLASS.poissons_ratio**2))  # D / h^3
    yielding = inelasticity * BALL_TIME / BALL_MASS
    thickness = 1.0 / math.sqrt(8.0 * yielding * math.sqrt(rigidity * GLASS_DENSITY))
    edge = side * (rigidity * thickness**2 / GLASS_DENSITY) ** 0.25 * math.sqrt(BALL_TIME)
    scene = SpatialScene(gravity=(0.0, 0.0, 0.0))
    plate = scene.add(_plate(edge, GLASS_DENSITY * thickness * edge**2, side, cutoff), name="plate")
    scene.join(Weld(plate.point("corner"), scene.ground.at(-0.5 * edge, -0.5 * edge, 0.0)))
    ball = scene.add(
        Sphere(RADIUS, mass=BALL_MASS), name="ball", position=(0.0, 0.0, RADIUS), velocity=(0.0, 0.0, -BALL_SPEED)
    )
    surface = plate.plane("middle", (0.0, 0.0, 1.0))
    scene.contact(ball.surface(), surface, friction=0.0, law=ContactLaw(HERTZ), name="ball")
    return scene


def _plate(edge: float, mass: float, side: float, cutoff: float) -> SpatialBody:
    """w = 2 / mass^(1/2) sin(m pi x / edge) sin(n pi y / edge) with odd m and n, at (pi / side)^2 (m^2 + n^2) / T0."""
    odd = np.arange(1.0, side * math.sqrt(cutoff) / math.pi + 1.0, 2.0)
    m, n = (grid.ravel() for grid in np.meshgrid(odd, odd))
    frequency = (math.pi / side) ** 2 * (m**2 + n**2)
    order = np.argsort(frequency, kind="stable")
    order = order[frequency[order] <= cutoff]
    m, n, frequency = m[order], n[order], frequency[order] / BALL_TIME
    modes = len(order)
    shape, total = np.zeros((2, modes, 3))
    shape[:, 2] = 2.0 / math.sqrt(mass) * np.sin(0.5 * math.pi * m) * np.sin(0.5 * math.pi * n)
    total[:, 2] = 8.0 * math.sqrt(mass) / (math.pi**2 * m * n)
    flat = np.zeros((modes, 3))
    corner = np.array([-0.5 * edge, -0.5 * edge, 0.0])
    return SpatialBody(
        mass=mass,
        inertia=mass * edge**2 / 12.0 * np.diag([1.0, 1.0, 2.0]),
        stiffness=frequency**2,
        S=total,
        points={"middle": SpatialPoint(np.zeros(3), shape, flat), "corner": SpatialPoint(corner, flat, flat)},
    )


def cases() -> tuple[Case, ...]:
    """Those of this module."""
    return (
        Case(
            "sphere_on_plate",
            "ball that strikes a large thin plate, by Hertz's law",
            sphere_on_plate,
            3.8 * BALL_TIME,
            Smooth(integrator=ExplicitRungeKutta(rtol=1e-8)),
            {"restitution": 0.84333941, "contact_time": 3.27849499 * BALL_TIME},
            "Zener 1941, The intrinsic inelasticity of large plates: his equation, to 1e-11",
        ),
    )
