"""Order of the massless-boundary stepper while contacts stay closed: normal contact, and friction on a moving body."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial

import numpy as np
import numpy.typing as npt
import pytest

import lcpflex as lf
from lcpflex.steppers.massless_boundary.stepper import MasslessBoundary
from tests.rates import assert_rate
from tests.scenes import floor_of

FloatArray = npt.NDArray[np.float64]
State = tuple[FloatArray, FloatArray]
Build = Callable[[State | None], lf.Scene]


def pressed_bar(start: State | None) -> lf.Scene:
    """A damped bar is pressed against a wall by a force that swings about 50 N."""
    material = lf.Bar(length=10.0, area=1.0, density=1.0, youngs_modulus=900.0, elements=40)
    scene = lf.Scene(gravity=(0.0, 0.0))
    body = material.reduce(modes=20, damping=0.3)
    q, u = (np.zeros(23), np.zeros(23)) if start is None else start
    bar = scene.add(body, name="bar", position=q[:2], modal=q[3:], velocity=u[:2], modal_velocity=u[3:])
    scene.load(lf.Force(bar.point("right"), (lf.Harmonic(20.0, 3.0, mean=-50.0), 0.0)))
    scene.contact(bar.node(0.0, 0.0), scene.ground.half_plane((0.0, 0.0), (1.0, 0.0)))
    return scene


def leaning_beam(start: State | None, friction: float = 0.3) -> lf.Scene:
    """A soft beam, guided at its upper end, leans on a rough floor; its foot slides away, or sticks and bends it."""
    material = lf.Beam(1.0, 0.05, 0.02, 1000.0, 2e7, elements=12)
    body = material.reduce(modes=8, damping=0.1)
    scene = lf.Scene(gravity=(0.0, -9.81))
    if start is None:
        angle = -math.radians(40.0)
        foot = (-0.01 * math.sin(angle), 0.01 * math.cos(angle))
        place = (0.0, -math.sin(angle) + foot[1])
        beam = scene.add(body, name="beam", position=place, angle=angle)
    else:
        q, u = start
        beam = scene.add(
            body, name="beam", position=q[:2], angle=q[2], modal=q[3:],
            velocity=u[:2], angular_velocity=u[2], modal_velocity=u[3:],
        )  # fmt: skip
    scene.join(lf.PointOnLine(beam.point("left"), scene.ground.at(0.0, 0.0), axis=(0.0, 1.0)))
    scene.contact(beam.node(1.0, -0.01), floor_of(scene), friction=friction)
    return scene


def settled(build: Build, duration: float, modes: int) -> State:
    """State with the contact closed, after the damped start."""
    result = lf.simulate(build(None), duration, MasslessBoundary(dynamic_modes=modes, safety=0.1), record=duration)
    assert result.force[-1, 0, 0] > 0.0
    return result.q[-1], result.u[-1]


def final(build: Build, start: State, duration: float, steps: int, modes: int) -> FloatArray:
    """q, u and contact force at the end of equal steps, all with the contact closed."""
    h = duration / steps
    stepper = MasslessBoundary(step=h, dynamic_modes=modes, substeps=False, safety=1.0)
    result = lf.simulate(build(start), duration, stepper, record=0.0, project=True)
    assert result.steps == steps
    assert len(set(result.state[1:, 0])) == 1, "slip and stick would each be smooth, but not their change"
    assert result.force[:, 0, 0].min() > 0.0
    assert not [w for w in result.warnings if "divided" in w]
    return np.concatenate([result.q[-1], result.u[-1], 1e-3 * result.force[-1, 0]])


@pytest.mark.parametrize(
    ("build", "lead", "duration", "coarsest", "modes"),
    [
        (pressed_bar, 4.0, 1.0, 120, 8),
        (leaning_beam, 0.15, 0.1, 60, 3),
        (partial(leaning_beam, friction=2.0), 0.15, 0.1, 480, 1),  # and what the guide holds
    ],
    ids=["pressed bar", "foot slides", "foot sticks"],
)
def test_order_two_with_closed_contacts(build: Build, lead: float, duration: float, coarsest: int, modes: int) -> None:
    start = settled(build, lead, modes)
    steps = coarsest * 2 ** np.arange(5)
    exact = final(build, start, duration, 64 * coarsest, modes)
    errors = [np.abs(final(build, start, duration, int(n), modes) - exact).max() for n in steps]
    assert_rate(1.0 / steps, errors, 2.0, within=(0.2, 0.3))
