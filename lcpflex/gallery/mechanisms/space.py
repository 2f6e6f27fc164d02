"""Bodies and mechanisms in space, each with a reference in closed form or from a converged equation of its own."""

from __future__ import annotations

import math
from functools import partial

import numpy as np

from lcpflex.bodies.spatial.body import SpatialBody, SpatialPoint
from lcpflex.bodies.spatial.rigid import Sphere
from lcpflex.gallery.mechanisms.arguments import checked
from lcpflex.runs.case import Case
from lcpflex.scene.functions_of_time import Table
from lcpflex.scene.joints.distance import Distance
from lcpflex.scene.joints.driven_angle import DrivenAngle
from lcpflex.scene.joints.prismatic import Prismatic
from lcpflex.scene.joints.revolute import Revolute
from lcpflex.scene.spatial.joints.ball import Ball
from lcpflex.scene.spatial.scene import SpatialScene
from lcpflex.steppers.event_driven.stepper import EventDriven

__all__ = ["dzhanibekov", "heavy_top", "spatial_slider_crank", "spherical_pendulum"]

SLIDER, CRANK_HEIGHT, CRANK_RADIUS, ROD = 2.0, 0.12, 0.08, 0.3  # [kg], [m]
CRANK_INERTIA = 2e-3  # about the axis of the crank [kg m^2]


@checked
def dzhanibekov(disturbance: float = 0.01, spin: float = 5.0) -> SpatialScene:
    """A free body with the principal moments 1, 2, 3 kg m^2, spun about the middle one: it turns over and back.

    disturbance: angular velocity about the other two axes [rad/s]. spin: that about the middle one [rad/s].
    """
    scene = SpatialScene(gravity=(0.0, 0.0, 0.0))
    body = SpatialBody(mass=1.0, inertia=np.diag([1.0, 2.0, 3.0]))
    scene.add(body, name="body", angular_velocity=(disturbance, spin, disturbance))
    return scene


@checked
def heavy_top(spin: float = 100.0, precession: float = 0.0, degrees: float = 30.0) -> SpatialScene:
    """A top of 1 kg on a ball joint, .1 m below its mass centre, leaning by ``degrees``.

    spin: angular velocity about the axis of the top [rad/s]. precession: of that axis about the vertical at the start
    [rad/s]; 0 releases it from rest.
    """
    lean = math.radians(degrees)
    axis = np.array([0.0, -math.sin(lean), math.cos(lean)])
    # 0.013 kg m^2 about the pivot across the axis, of which m l^2 is 0.01
    top = SpatialBody(
        mass=1.0,
        inertia=np.diag([0.003, 0.003, 0.004]),
        points={"pivot": SpatialPoint(np.array([0.0, 0.0, -0.1]), np.zeros((0, 3)), np.zeros((0, 3)))},
    )
    upright = np.array([0.0, 0.0, 1.0])
    omega = precession * upright + (spin - precession * math.cos(lean)) * axis
    cos, sin = math.cos(lean), math.sin(lean)
    scene = SpatialScene()
    placed = scene.add(
        top,
        name="top",
        position=0.1 * axis,
        orientation=np.array([[1.0, 0.0, 0.0], [0.0, cos, -sin], [0.0, sin, cos]]),
        velocity=np.cross(omega, 0.1 * axis),
        angular_velocity=omega,
    )
    scene.join(Ball(placed.point("pivot"), scene.ground.at(0.0, 0.0, 0.0), name="pivot"))
    return scene


@checked
def spatial_slider_crank(rate: float = 6.0, driven: bool = False) -> SpatialScene:
    """A crank that turns about x above a slider on the x axis, a rod with two ball joints between them.

    The pin is at (0, r cos, z + r sin); the massless rod is a distance joint. rate: of the crank at the start [rad/s].
    driven: it turns at that rate all the time; else freely.
    """
    scene = SpatialScene()
    crank = scene.add(
        SpatialBody(mass=1.0, inertia=np.diag([CRANK_INERTIA, CRANK_INERTIA, CRANK_INERTIA])),
        name="crank",
        position=(0.0, 0.0, CRANK_HEIGHT),
        angular_velocity=(rate, 0.0, 0.0),
    )
    reach = math.sqrt(ROD**2 - CRANK_RADIUS**2 - CRANK_HEIGHT**2)
    # the rod keeps its length: xdot x = ydot y + zdot z, with the pin moving along z at rate r
    slider = scene.add(
        Sphere(radius=0.03, mass=SLIDER),
        name="slider",
        position=(reach, 0.0, 0.0),
        velocity=(-rate * CRANK_RADIUS * CRANK_HEIGHT / reach, 0.0, 0.0),
    )
    center, pin = crank.at(0.0, 0.0, 0.0), crank.at(0.0, CRANK_RADIUS, 0.0)
    bearing = scene.ground.at(0.0, 0.0, CRANK_HEIGHT)
    scene.join(Revolute(center, bearing, axis=(1.0, 0.0, 0.0), name="bearing"))
    if driven:
        turn = Table((0.0, 1e3), (0.0, 1e3 * rate))
        scene.join(DrivenAngle(center, bearing, turn, axis=(1.0, 0.0, 0.0), name="motor"))
    scene.join(Distance(slider.at(0.0, 0.0, 0.0), pin, length=ROD, name="rod"))
    scene.join(Prismatic(slider.at(0.0, 0.0, 0.0), scene.ground.at(0.0, 0.0, 0.0), axis=(1.0, 0.0, 0.0), name="rail"))
    return scene


@checked
def spherical_pendulum(theta: float = 1.0, rate: float = 2.0) -> SpatialScene:
    """A point mass on a massless rod of 1 m: the rod ends in the centre of a ball, so that it does not turn it.

    theta: from the downward vertical [rad]. rate: of its plane about the vertical at the start [rad/s].
    """
    scene = SpatialScene()
    sin, cos = math.sin(theta), math.cos(theta)
    ball = scene.add(
        Sphere(radius=0.05, mass=1.0), name="ball", position=(sin, 0.0, -cos), velocity=(0.0, rate * sin, 0.0)
    )
    scene.join(Distance(ball.at(0.0, 0.0, 0.0), scene.ground.at(0.0, 0.0, 0.0), length=1.0, name="rod"))
    return scene


def cases() -> tuple[Case, ...]:
    """Those of this module."""
    return (
        Case(
            "dzhanibekov",
            "body spun about its middle axis turns over and back",
            dzhanibekov,
            8.0,
            EventDriven(),
            {
                "omega_x": 4.04901407,
                "omega_y": 2.93352774,
                "omega_z": 2.33771363,
                "p_0": 0.88663647,
                "p_1": -0.36676484,
                "p_2": 0.0916551,
                "p_3": 0.26638068,
                "period": 10.0518582763,
            },
            "closed form by elliptic functions",
        ),
        Case(
            "heavy_top",
            "top of 1 kg in steady precession on a ball joint",
            partial(heavy_top, precession=2.650181072),
            1.0,
            EventDriven(),
            {"lean": math.radians(30.0), "precession": 2.650181072},
            "closed form",
        ),
        Case(
            "released_top",
            "top of 1 kg released on a ball joint: it nods",
            heavy_top,
            0.237882413,
            EventDriven(),
            {"largest_lean": 0.623871299, "period": 0.237882413, "turn": 0.627062592},
            "quadrature of the equation of the nutation",
        ),
        Case(
            "driven_slider_crank",
            "spatial slider-crank driven at one turn a second",
            partial(spatial_slider_crank, rate=2.0 * math.pi, driven=True),
            0.3,
            EventDriven(),
            {"x_1": 0.2406543645, "v_1": -0.2027752771, "x_3": 0.2256982829, "v_3": 0.0825857678},
            "closed form",
        ),
        Case(
            "free_slider_crank",
            "spatial slider-crank in free motion",
            spatial_slider_crank,
            5.0,
            EventDriven(),
            {
                "theta_1": 7.025303,
                "theta_2": 14.287785,
                "theta_5": 35.596708,
                "rate_1": 6.663690,
                "rate_2": 8.978506,
                "rate_5": 8.110375,
                "x_1": 0.237115,
                "x_2": 0.224092,
                "x_5": 0.292831,
            },
            "equation of motion in the angle of the crank, to 1e-8",
        ),
        Case(
            "spherical_pendulum",
            "point mass on a rod that swings about a point",
            spherical_pendulum,
            2.0,
            EventDriven(),
            {"theta": 0.930829520, "phi": 7.259031152},
            "equations of motion in two angles, to 1e-12",
        ),
    )
