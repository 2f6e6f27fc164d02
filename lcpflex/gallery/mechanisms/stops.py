"""Stops and balls that give way: contacts with a force law of their own, to be run by ``Smooth``."""

from __future__ import annotations

import math

from lcpflex.bodies.bar import Bar
from lcpflex.bodies.beam import Beam
from lcpflex.bodies.rigid import Disc
from lcpflex.force_laws.penalty import Penalty
from lcpflex.gallery.mechanisms.arguments import checked
from lcpflex.runs.case import Case
from lcpflex.scene.joints.point_on_line import PointOnLine
from lcpflex.scene.joints.revolute import Revolute
from lcpflex.scene.loads.spring import Spring
from lcpflex.scene.scene import Scene
from lcpflex.steppers.smooth.stepper import ExplicitRungeKutta, Smooth

__all__ = ["elastic_stop", "hinged_beam", "sphere_on_beam", "sphere_on_rod"]

BEAM_HERTZ = 1.58056e10  # steel ball of 10 mm on the beam [N/m^1.5]


@checked
def elastic_stop(mass: float = 100.0, stiffness: float = 1e4, speed: float = 1.0) -> Scene:
    """A mass on a spring meets a stop at its place of rest (code_aster SDND101; the stop has 1e6 N/m)."""
    scene = Scene(gravity=(0.0, 0.0))
    body = scene.add(Disc(radius=0.1, mass=mass), name="mass", position=(0.0, 0.1), velocity=(0.0, -speed))
    scene.load(Spring(body.point("center"), scene.ground.at(0.0, 3.1), stiffness=stiffness, length=3.0))
    scene.contact(body.surface(), scene.ground.half_plane((0.0, 0.0), (0.0, 1.0)), name="stop")
    return scene


@checked
def hinged_beam(modes: int = 20, elements: int = 40) -> Scene:
    """A hinged beam turns at 3.8 rad/s onto a stop at its tip (code_aster SDNL32; the stop has 18000 N/m)."""
    body = Beam(0.783, 0.014, 0.014, density=2400.0, youngs_modulus=6.7e10, elements=elements, axial=False)
    scene = Scene(gravity=(0.0, 0.0))
    beam = scene.add(body, name="beam", angular_velocity=-3.8, modes=modes)
    scene.join(Revolute(beam.point("left"), scene.ground.at(0.0, 0.0), name="hinge"))
    scene.contact(beam.node(0.783, 0.0), scene.ground.half_plane((0.0, 0.0), (0.0, 1.0)), name="stop")
    return scene


@checked
def sphere_on_beam(modes: int = 40, elements: int = 60) -> Scene:
    """Timoshenko's steel ball meets the middle of a simply supported steel beam at 0.01 m/s."""
    length, side, radius = 0.1535, 0.01, 0.01
    body = Beam(length, side, side, density=7960.0, youngs_modulus=2.157463e11, elements=elements, axial=False)
    ball_mass = 4.0 / 3.0 * math.pi * radius**3 * 7960.0
    scene = Scene(gravity=(0.0, 0.0))
    beam = scene.add(body, name="beam", modes=modes)
    scene.join(Revolute(beam.point("left"), scene.ground.at(0.0, 0.0), name="left support"))
    scene.join(PointOnLine(beam.point("right"), scene.ground.at(length, 0.0), (1.0, 0.0), name="right support"))
    ball = scene.add(
        Disc(radius=radius, mass=ball_mass),
        name="ball",
        position=(0.5 * length, 0.5 * side + radius),
        velocity=(0.0, -0.01),
    )
    scene.contact(beam.node(0.5 * length, 0.5 * side), ball.surface(), name="ball")
    return scene


def rod_hertz() -> float:
    """K = 4/3 E* sqrt(R) of the ball on the end of :func:`sphere_on_rod` [N/m^1.5]."""
    compliance = (1.0 - 0.3**2) / 210e9 + (1.0 - 0.33**2) / 69e9
    return 4.0 / 3.0 / compliance * math.sqrt(0.015)


@checked
def sphere_on_rod(elements: int = 200, speed: float = 0.3) -> Scene:
    """A steel ball strikes the end of an aluminium rod: waves alone make the loss."""
    radius = 0.015
    body = Bar(1.0, math.pi * 0.01**2, density=2700.0, youngs_modulus=69e9, elements=elements)
    scene = Scene(gravity=(0.0, 0.0))
    rod = scene.add(body.reduce(modes=None), name="rod")
    ball_mass = 4.0 / 3.0 * math.pi * radius**3 * 7780.0
    ball = scene.add(Disc(radius=radius, mass=ball_mass), name="ball", position=(-radius, 0.0), velocity=(speed, 0.0))
    scene.contact(rod.node(0.0, 0.0), ball.surface(), name="ball")
    return scene


def cases() -> tuple[Case, ...]:
    """The cases of this module."""
    fine = ExplicitRungeKutta(rtol=1e-10, atol=1e-13)
    converged = "converged numerical solution"
    return (
        Case(
            "elastic_stop",
            "mass on a spring bounces on an elastic stop",
            elastic_stop,
            0.4,
            Smooth(Penalty(1e6), integrator=fine),
            {"contact_time": 0.031260015, "force": 9950.371902, "flight": 0.314159265},
            "closed form; code_aster SDND101",
        ),
        Case(
            "hinged_beam",
            "hinged beam turns onto an elastic stop at its tip",
            hinged_beam,
            0.015,
            Smooth(Penalty(18000.0), integrator=fine),
            {
                "contact_end": 1.23171e-2,
                "deepest": -4.97897e-3,
                "deepest_time": 3.3293e-3,
                "force": 89.62,
                "rigid_rate": 3.6773,
            },
            f"{converged}; code_aster SDNL32",
        ),
        Case(
            "sphere_on_beam",
            "Timoshenko's steel ball on the middle of a steel beam, Hertz' law",
            sphere_on_beam,
            2e-4,
            Smooth(Penalty(BEAM_HERTZ, 1.5), integrator=fine),
            {"contact_time": 1.5640e-4, "force": 4.9771, "rebound": -0.302324, "mode_1": 0.89124, "mode_3": 0.017332},
            f"{converged}: Euler-Bernoulli, all 120 modes of 60 elements; after Timoshenko",
        ),
        Case(
            "sphere_on_rod",
            "steel ball on the end of an aluminium rod, Hertz' law: waves make the loss",
            sphere_on_rod,
            2.5e-4,
            Smooth(Penalty(rod_hertz(), 1.5), integrator=fine),
            {"contact_time": 1.9357e-4, "force": 467.78, "ball": -0.45375, "rod": 0.18850, "restitution": 0.64225},
            f"{converged}: Hertz' law and one-dimensional waves",
        ),
    )
