"""A user's own law against the same of the library: what the call by address and the call of Python cost."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import lcpflex as lf
from lcpflex.force_laws.contact_law import ContactLaw
from lcpflex.force_laws.damping.hysteresis import HysteresisDamping
from lcpflex.force_laws.elastic.power_law import PowerLaw
from lcpflex.force_laws.user_law import UserLaw
from lcpflex.steppers.smooth.stepper import Smooth, Verlet

K, E = 1e6, 0.6
STEP = 1e-5


def hunt_crossley(depth: float, rate: float, speed: float, p: Any) -> float:
    return p[0] * depth**1.5 * (1.0 + p[1] * rate / speed)


def seconds_per_step(law: ContactLaw, scene: lf.Scene, steps: int) -> float:
    result = lf.simulate(scene, steps * STEP, Smooth(law, integrator=Verlet(STEP)), progress=False)
    assert result.impulse[-1, :, 0].min() > 0.0
    return result.wall_time / result.steps


def test_compiled_own_law_costs_little_more_than_one_of_the_library(
    interleave: Callable[..., Mapping[str, float]], resting_strip: Callable[..., lf.Scene]
) -> None:
    damping = HysteresisDamping(E)
    built_in = ContactLaw(PowerLaw(K), damping)
    own = ContactLaw(UserLaw(hunt_crossley, (K, damping.eta)))
    python = ContactLaw(UserLaw(hunt_crossley, (K, damping.eta), compiled=False))
    scene = resting_strip()
    medians = interleave(
        {
            "Hunt-Crossley of the library": lambda: seconds_per_step(built_in, scene, 20000),
            "the same as own law, compiled": lambda: seconds_per_step(own, scene, 20000),
            "the same as own law in Python": lambda: seconds_per_step(python, scene, 5000),
        }
    )
    assert medians["the same as own law, compiled"] < 1.5 * medians["Hunt-Crossley of the library"]
    assert medians["the same as own law in Python"] < 20.0 * medians["Hunt-Crossley of the library"]
