"""A step under continuous contact forces: compiled against the same with its outer loop in Python."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import lcpflex as lf
from lcpflex.force_laws.penalty import Penalty
from lcpflex.steppers.smooth.stepper import ExplicitRungeKutta, Smooth, Stiff, Verlet

STEP = 1e-5


def seconds_per_step(scene: lf.Scene, integrator: Any, steps: int) -> float:
    stepper = Smooth(Penalty(1e5, damping=10.0, slip_speed=1e-2), integrator=integrator)
    result = lf.simulate(scene, steps * STEP, stepper, record=steps * STEP, progress=False)
    assert result.force[-1, :, 0].min() > 0.0
    return result.wall_time / result.steps


def test_compiled_driver_is_ten_times_faster(
    interleave: Callable[..., Mapping[str, float]], resting_strip: Callable[..., lf.Scene]
) -> None:
    compiled = resting_strip(pull=0.1)
    python = resting_strip(pull=lambda t: 0.1)  # a callback: the loop is Python's
    fixed = ExplicitRungeKutta(rtol=1e9, atol=1e9, first_step=STEP, max_step=STEP)
    medians = interleave(
        {
            "Runge-Kutta, compiled driver": lambda: seconds_per_step(compiled, fixed, 5000),
            "Runge-Kutta, Python driver": lambda: seconds_per_step(python, fixed, 200),
            "Verlet, compiled driver": lambda: seconds_per_step(compiled, Verlet(STEP), 20000),
            "Verlet, Python driver": lambda: seconds_per_step(python, Verlet(STEP), 500),
            "Radau": lambda: seconds_per_step(compiled, Stiff(), 5000),
        }
    )
    assert medians["Runge-Kutta, Python driver"] >= 10.0 * medians["Runge-Kutta, compiled driver"]
    assert medians["Verlet, Python driver"] >= 10.0 * medians["Verlet, compiled driver"]
