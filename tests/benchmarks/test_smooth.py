"""A step under continuous contact forces: compiled against the same with its outer loop in Python."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import lcpflex as lf
from lcpflex.contact.penalty import Penalty
from lcpflex.steppers.smooth import ExplicitRungeKutta, Smooth, Stiff, Verlet

STEP = 1e-5


def seconds_per_step(pull: Any, integrator: Any, steps: int) -> float:
    """Of a strip with four modes that lies on its two ends, with friction."""
    strip = lf.Beam(length=0.7, width=0.028, thickness=0.005, density=2700.0, youngs_modulus=6.9e10)
    scene = lf.Scene(gravity=(0.0, -9.81))
    body = scene.add(strip.reduce(modes=4, damping=0.02), name="strip", position=(0.0, 0.0025))
    floor = scene.ground.half_plane((0.0, 0.0), (0.0, 1.0))
    for name, x in (("left", 0.0), ("right", 0.7)):
        scene.contact(body.node(x, -0.0025), floor, friction=0.5, name=name)
    scene.load(lf.Force(body.point("left"), (pull, 0.0)))
    stepper = Smooth(Penalty(1e5, damping=10.0, slip_speed=1e-2), integrator=integrator)
    result = lf.simulate(scene, steps * STEP, stepper, record=steps * STEP, progress=False)
    assert result.force[-1, :, 0].min() > 0.0
    return result.wall_time / result.steps


def test_compiled_driver_is_ten_times_faster(interleave: Callable[..., Mapping[str, float]]) -> None:
    fixed = ExplicitRungeKutta(rtol=1e9, atol=1e9, first_step=STEP, max_step=STEP)
    medians = interleave(
        {
            "Runge-Kutta, compiled driver": lambda: seconds_per_step(0.1, fixed, 5000),
            "Runge-Kutta, Python driver": lambda: seconds_per_step(lambda t: 0.1, fixed, 200),
            "Verlet, compiled driver": lambda: seconds_per_step(0.1, Verlet(STEP), 20000),
            "Verlet, Python driver": lambda: seconds_per_step(lambda t: 0.1, Verlet(STEP), 500),
            "Radau": lambda: seconds_per_step(0.1, Stiff(), 5000),
        }
    )
    assert medians["Runge-Kutta, Python driver"] >= 10.0 * medians["Runge-Kutta, compiled driver"]
    assert medians["Verlet, Python driver"] >= 10.0 * medians["Verlet, compiled driver"]
