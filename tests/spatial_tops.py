"""Reference mechanisms of space: the heavy top (R2), the spherical pendulum (R7), the spatial slider-crank (R6')."""

from __future__ import annotations

import math

import numpy as np
from scipy.spatial.transform import Rotation

import lcpflex as lf
from lcpflex.jit.kernel import FloatArray

LENGTH = 0.1
LEAN = math.pi / 6.0
SPIN = 100.0
PRECESSION = (2.650181072, 32.879066262)  # [rad/s], both steady
RELEASED = {"lowest": 0.623871299, "period": 0.237882413, "turn": 0.627062592}
PENDULUM = {"theta": 0.930829520, "phi": 7.259031152}  # at t = 2
CRANK = {"angle": (7.025303, 14.287785), "rate": (6.663690, 8.978506), "slider": (0.237115, 0.224092)}  # at t = 1, 2


def heavy_top(precession: float) -> lf.SpatialScene:
    """A top that leans by 30 degrees and precesses, spinning with 100 rad/s about its axis in all."""
    scene = lf.SpatialScene()
    turned = Rotation.from_euler("x", -LEAN)
    axis = turned.apply([0.0, 0.0, 1.0])
    omega = precession * np.array([0.0, 0.0, 1.0]) + (SPIN - precession * math.cos(LEAN)) * axis
    centred = np.diag([0.013 - LENGTH**2, 0.013 - LENGTH**2, 0.004])
    top = scene.add(
        lf.SpatialBody(mass=1.0, inertia=centred),
        name="top",
        position=LENGTH * axis,
        orientation=turned,
        velocity=np.cross(omega, LENGTH * axis),
        angular_velocity=omega,
    )
    scene.join(lf.Ball(top.at(0.0, 0.0, -LENGTH), scene.ground.at(0.0, 0.0, 0.0)))
    return scene


def axis_of(result: lf.Result) -> tuple[FloatArray, FloatArray]:
    """(m,) angle of the third axis of the first body from the vertical, and its azimuth without jumps."""
    axis = Rotation.from_quat(result.q[:, [4, 5, 6, 3]]).apply([0.0, 0.0, 1.0])
    return np.arccos(axis[:, 2]), np.unwrap(np.arctan2(axis[:, 1], axis[:, 0]))


def spherical_pendulum() -> lf.SpatialScene:
    """A mass on a distance of 1 m, which tumbles besides."""
    scene = lf.SpatialScene()
    place = np.array([math.sin(1.0), 0.0, -math.cos(1.0)])
    bob = scene.add(
        lf.SpatialBody(mass=1.0, inertia=np.diag([0.1, 0.2, 0.15])),
        position=place,
        velocity=(0.0, 2.0 * math.sin(1.0), 0.0),
        angular_velocity=(1.0, 2.0, 3.0),
    )
    scene.join(lf.Distance(bob.at(0.0, 0.0, 0.0), scene.ground.at(0.0, 0.0, 0.0)))
    return scene


def polar(result: lf.Result) -> tuple[FloatArray, FloatArray]:
    """(m,) angles theta from the downward vertical and phi without jumps, of the place of the first body."""
    x, y, z = result.q[:, :3].T
    return np.arccos(-z / np.linalg.norm(result.q[:, :3], axis=1)), np.unwrap(np.arctan2(y, x))


def slider_crank() -> lf.SpatialScene:
    """A crank about the x axis at 6 rad/s drives a slider on the x axis by a massless rod of 0.3 m."""
    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    reach, height, rod = 0.08, 0.12, 0.3
    x = math.sqrt(rod**2 - reach**2 - height**2)
    crank = scene.add(
        lf.SpatialBody(mass=1.0, inertia=np.diag([2e-3, 2e-3, 2e-3])),
        name="crank",
        position=(0.0, 0.0, height),
        angular_velocity=(6.0, 0.0, 0.0),
    )
    slider = scene.add(
        lf.SpatialBody(mass=2.0, inertia=np.diag([1e-3, 1e-3, 1e-3])),
        name="slider",
        position=(x, 0.0, 0.0),
        velocity=(-height * reach * 6.0 / x, 0.0, 0.0),
    )
    ground = scene.ground
    scene.join(lf.Revolute(crank.at(0.0, 0.0, 0.0), ground.at(0.0, 0.0, height), axis=(1.0, 0.0, 0.0)))
    scene.join(lf.Prismatic(slider.at(0.0, 0.0, 0.0), ground.at(0.0, 0.0, 0.0), axis=(1.0, 0.0, 0.0)))
    scene.join(lf.Distance(crank.at(0.0, reach, 0.0), slider.at(0.0, 0.0, 0.0)))
    return scene


def crank_angle(result: lf.Result) -> FloatArray:
    """(m,) angle about the x axis, without jumps."""
    return np.asarray(np.unwrap(2.0 * np.arctan2(result.q[:, 4], result.q[:, 3]), period=2.0 * math.pi))
