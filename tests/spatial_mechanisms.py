"""Rigid mechanisms in space with known motions, their joints given as rows: tops, a pendulum, a slider-crank."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

import lcpflex as lf
from lcpflex.jit.kernel import FloatArray
from lcpflex.kinematics.spatial.relative import ALONG, COMPONENT, DISTANCE, PERPENDICULAR
from lcpflex.model.arrays import frozen
from lcpflex.model.spatial import SpatialJoints, SpatialPointTable
from lcpflex.steppers.system import System
from tests.spatial_bodies import random_body
from tests.spatial_flight import flexible_body

GROUND = -1
NONE = np.zeros(3)
X, Y, Z = np.eye(3)
Row = tuple[int, FloatArray, FloatArray, float]  # kind, axis at Q, direction at P, value
Joint = tuple[tuple[int, Any], tuple[int, Any], Sequence[Row]]  # body and place of P, of Q, rows

BALL: list[Row] = [(COMPONENT, e, NONE, 0.0) for e in np.eye(3)]
HINGE: list[Row] = [*BALL, (PERPENDICULAR, X, Y, 0.0), (PERPENDICULAR, X, Z, 0.0)]  # about x
SLIDE: list[Row] = [(ALONG, e, NONE, 0.0) for e in (Y, Z)] + [
    (PERPENDICULAR, q, p, 0.0) for p, q in ((Y, X), (Z, Y), (X, Z))
]  # along x

STEADY, FAST = 2.650181072, 32.879066262  # [rad/s] precession of the top
TILT = math.radians(30.0)


def system_of(
    scene: lf.SpatialScene, joints: Sequence[Joint], shapes: Mapping[int, Any] = MappingProxyType({})
) -> System:
    """A scene of free bodies, joined; ``shapes``: phi and psi at the points of those that are flexible."""
    compiled, table = scene.compile(), SpatialPointTable()
    points = [[table.add(body, place, *shapes.get(body, ([], []))) for body, place in ends] for *ends, _ in joints]
    rows = [row for *_, own in joints for row in own]
    kinds, axes, directions, rest = zip(*rows, strict=True)
    made = SpatialJoints(
        point=frozen(points, np.int64),
        row=frozen(np.cumsum([0, *(len(own) for *_, own in joints)]), np.int64),
        kind=frozen(kinds, np.int64),
        axis=frozen(axes),
        on_p=frozen(directions),
        on_q=frozen(np.zeros((len(rows), 3))),
        rest=frozen(rest),
        signal=frozen(np.full(len(rows), -1), np.int64),
    )
    return replace(compiled.system(), model=compiled.model._replace(points=table.compile(), joints=made))


def simulated(system: System, duration: float, stepper: Any) -> dict[str, FloatArray]:
    """What a run records at its start and at its end."""
    run = stepper.start(system, duration, duration)
    message = run.advance(10**9)
    assert not message, message
    assert not run.records.warnings
    collected: dict[str, FloatArray] = run.records.collected()
    return collected


def top(precession: float, spin: float = 100.0) -> System:
    """R2: J about the pivot (.013, .013, .004), mass 1, centre .1 m above; ``spin``: omega_3 [rad/s]."""
    axes = Rotation.from_rotvec(TILT * X).as_matrix()
    axis = axes[:, 2]
    omega = precession * Z + (spin - precession * math.cos(TILT)) * axis
    scene = lf.SpatialScene()
    body = lf.SpatialBody(mass=1.0, inertia=np.diag([0.003, 0.003, 0.004]))
    velocity = np.cross(omega, 0.1 * axis)
    scene.add(body, position=0.1 * axis, orientation=axes, angular_velocity=omega, velocity=velocity)
    return system_of(scene, [((0, -0.1 * Z), (GROUND, NONE), BALL)])


def axis_of_top(q: FloatArray) -> FloatArray:
    """(3,) the third axis of the first body, in the world."""
    return np.asarray(Rotation.from_quat(q[[4, 5, 6, 3]]).as_matrix()[:, 2])


def axis_in_precession(precession: float, time: float) -> FloatArray:
    """The same, where the top precesses steadily."""
    turned = precession * time
    return np.array([math.sin(TILT) * math.sin(turned), -math.sin(TILT) * math.cos(turned), math.cos(TILT)])


def pendulum() -> System:
    """R7: a point mass on a massless rod of 1 m, 1 rad from the vertical, 2 rad/s about it."""
    scene = lf.SpatialScene()
    start = np.array([math.sin(1.0), 0.0, -math.cos(1.0)])
    scene.add(lf.Sphere(0.01, mass=1.0), position=start, velocity=2.0 * math.sin(1.0) * Y)
    return system_of(scene, [((0, NONE), (GROUND, NONE), [(DISTANCE, NONE, NONE, 1.0)])])


def angles_of_pendulum(q: FloatArray) -> FloatArray:
    """Angle from the vertical, and azimuth in (-pi, pi]."""
    return np.array([math.acos(-q[2] / np.linalg.norm(q[:3])), math.atan2(q[1], q[0])])


def slider_crank() -> System:
    """R6': crank about x through (0, 0, .12), r = .08, rod .3 without mass; slider of 2 kg on x; 6 rad/s."""
    scene = lf.SpatialScene()
    place = math.sqrt(0.3**2 - 0.08**2 - 0.12**2)
    speed = -0.12 * 6.0 * 0.08 / place
    crank = lf.SpatialBody(mass=1.0, inertia=2e-3 * np.eye(3))
    scene.add(crank, position=(0.0, 0.0, 0.12), angular_velocity=6.0 * X)
    scene.add(lf.Cuboid(0.1, 0.1, 0.1, mass=2.0), position=place * X, velocity=speed * X)
    rod: Joint = ((1, NONE), (0, 0.08 * Y), [(DISTANCE, NONE, NONE, 0.3)])
    return system_of(scene, [((0, NONE), (GROUND, 0.12 * Z), HINGE), ((1, NONE), (GROUND, NONE), SLIDE), rod])


def flexible_pendulum(modes: int = 3) -> System:
    """A damped flexible body of point masses that hangs on a ball joint at one of them, and spins."""
    given = random_body(np.random.default_rng(7), modes, centred=True)
    body = flexible_body(given, stiffness=400.0 * (1.0 + np.arange(modes)), damping=np.ones(modes))
    omega, place = np.array([1.0, 2.0, -1.5]), given.places[0]
    scene = lf.SpatialScene()
    scene.add(body, position=-place, angular_velocity=omega, velocity=-np.cross(omega, place))
    turns = 0.3 * np.random.default_rng(1).normal(size=(modes, 3))
    return system_of(scene, [((0, place), (GROUND, NONE), BALL)], {0: (given.shapes[:, 0], turns)})
