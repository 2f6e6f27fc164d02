"""Order of the massless-boundary stepper with elastic laws of contacts: in the step, and in the modes it keeps."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import numpy.typing as npt
import pytest

import lcpflex as lf
from lcpflex.force_laws.contact_law import ContactLaw
from lcpflex.force_laws.elastic.hertz import Hertz
from lcpflex.force_laws.elastic.materials import Material
from lcpflex.force_laws.elastic.power_law import PowerLaw
from lcpflex.gallery.mechanisms.stops import sphere_on_rod
from lcpflex.steppers.massless_boundary.stepper import MasslessBoundary
from tests.rates import assert_rate
from tests.scenes import floor_of

FloatArray = npt.NDArray[np.float64]
CONTACT_TIME = 7.828287e-5
DEEPEST = 2.659720e-5
FORCE = 5169.114
LAW = Hertz.sphere_on_plane(0.015, Material(210e9, 0.3), Material(69e9, 0.33))
FOOT = PowerLaw(1e7)


def ball_on_wall(start: float) -> lf.Scene:
    """A steel ball, 30 mm thick, 1 m/s, ``start`` [m] before a rigid wall."""
    radius = 0.015
    scene = lf.Scene(gravity=(0.0, 0.0))
    body = lf.Disc(radius=radius, mass=4.0 / 3.0 * math.pi * radius**3 * 7780.0)
    ball = scene.add(body, position=(radius + start, 0.0), velocity=(-1.0, 0.0))
    scene.contact(ball.surface(), scene.ground.half_plane((0.0, 0.0), (1.0, 0.0)), name="wall")
    return scene


def test_ball_on_wall_is_of_order_two() -> None:
    """Indentation at half the time of contact, where it is largest, and the rebound, against the closed form."""
    steps = 50 * 2 ** np.arange(6)
    errors: dict[str, list[float]] = {"depth": [], "force": [], "speed": []}
    for n in steps:
        step = 0.5 * CONTACT_TIME / float(n)
        stepper = MasslessBoundary(step=step, safety=1.0, compliance={"wall": PowerLaw(3.768446e10)})
        half = lf.simulate(ball_on_wall(0.0), 0.5 * CONTACT_TIME, stepper, record=1.0)
        whole = lf.simulate(ball_on_wall(0.0), 1.05 * CONTACT_TIME, stepper, record=1.0)
        errors["depth"].append(abs(-half.gap[-1, 0] / DEEPEST - 1.0))
        errors["force"].append(abs(half.force[-1, 0, 0] / FORCE - 1.0))
        errors["speed"].append(abs(half.u[-1, 0]) + abs(whole.u[-1, 0] - 1.0))
    assert errors["force"][-1] < 1e-5
    for values in errors.values():
        assert_rate(1.0 / steps, values, 2.0, within=(0.3, 0.5))


@cache
def smooth(elements: int) -> FloatArray:
    """Speeds of rod and ball after the impact, under the same law with all modes, by Runge-Kutta steps."""
    integrator = lf.ExplicitRungeKutta(rtol=1e-11, atol=1e-14)
    result = lf.simulate(sphere_on_rod(elements), 2.2e-4, lf.Smooth(ContactLaw(LAW), integrator=integrator), record=1.0)
    return np.asarray(result.u[-1, [0, -3]])


def massless(elements: int, modes: int, step: float) -> FloatArray:
    stepper = MasslessBoundary(step=step, dynamic_modes=modes, safety=1.0, compliance={"ball": LAW})
    return np.asarray(lf.simulate(sphere_on_rod(elements), 2.2e-4, stepper, record=1.0).u[-1, [0, -3]])


def test_all_modes_dynamic_approach_the_same_law_under_smooth_forces_by_order_two() -> None:
    steps = 300 * 2 ** np.arange(5)
    errors = [np.abs(massless(40, 40, 2.2e-4 / float(n)) - smooth(40)).max() for n in steps]
    assert_rate(1.0 / steps, errors, 2.0, within=0.2)
    assert errors[-1] < 1e-6


def test_more_dynamic_modes_approach_it_too() -> None:
    """With steps that leave no error of their own; static modes lack their inertia, which matters less the stiffer."""
    modes = np.array([5, 10, 20, 40])
    errors = [np.abs(massless(80, int(n), 2e-8) - smooth(80)).max() for n in modes]
    assert_rate(1.0 / modes, errors, 2.5, within=1.0)


@pytest.mark.parametrize("friction", [0.3, 2.0], ids=["foot slides", "foot sticks"])
def test_order_two_with_friction_and_static_modes(friction: float) -> None:
    """A beam leans with its foot, which gives way by a law along the normal and by static modes both ways."""
    start = settled(friction)
    steps = 60 * 2 ** np.arange(5)
    exact = leaning(friction, start, 60 * 64)
    errors = [np.abs(leaning(friction, start, int(n)) - exact).max() for n in steps]
    assert_rate(1.0 / steps, errors, 2.0, within=(0.2, 0.3))


def beam(friction: float, start: tuple[FloatArray, FloatArray] | None) -> lf.Scene:
    body = lf.Beam(1.0, 0.05, 0.02, 1000.0, 2e7, elements=12).reduce(modes=8, damping=0.1)
    scene = lf.Scene(gravity=(0.0, -9.81))
    angle = -math.radians(40.0)
    place = (0.0, -math.sin(angle) + 0.01 * math.cos(angle))  # the foot touches
    if start is None:
        placed = scene.add(body, name="beam", position=place, angle=angle)
    else:
        q, u = (values[:11] for values in start)
        placed = scene.add(
            body, name="beam", position=q[:2], angle=q[2], modal=q[3:],
            velocity=u[:2], angular_velocity=u[2], modal_velocity=u[3:],
        )  # fmt: skip
    scene.add(lf.Disc(radius=1e3, mass=1.0))  # against which the indentation of the foot is small enough to start with
    scene.join(lf.PointOnLine(placed.point("left"), scene.ground.at(0.0, 0.0), axis=(0.0, 1.0)))
    floor = floor_of(scene)
    scene.contact(placed.node(1.0, -0.01), floor, friction=friction, name="foot")
    return scene


def settled(friction: float) -> tuple[FloatArray, FloatArray]:
    """State with the contact closed, after the damped start."""
    stepper = MasslessBoundary(dynamic_modes=3, safety=0.1, compliance={"foot": FOOT})
    result = lf.simulate(beam(friction, None), 0.15, stepper, record=0.15)
    assert result.force[-1, 0, 0] > 0.0
    return result.q[-1], result.u[-1]


def leaning(friction: float, start: tuple[FloatArray, FloatArray], steps: int) -> FloatArray:
    stepper = MasslessBoundary(step=0.1 / steps, dynamic_modes=3, substeps=False, safety=1.0, compliance={"foot": FOOT})
    result = lf.simulate(beam(friction, start), 0.1, stepper, record=0.0, project=True)
    assert len(set(result.state[1:, 0])) == 1, "slip and stick would each be smooth, but not their change"
    assert result.force[:, 0, 0].min() > 0.0
    return np.concatenate([result.q[-1, :11], result.u[-1, :11], 1e-3 * result.force[-1, 0]])
