"""A step of the generalised-alpha stepper: its two drivers, and the same scene by Moreau and Jean."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import lcpflex as lf
from lcpflex.solvers.problem import Lcp, Solution
from lcpflex.steppers.generalized_alpha import GeneralizedAlpha

STEP = 1e-4


class Delegate:
    """Lemke's method behind an object that is not known to be compiled."""

    def solve(self, problem: Lcp, guess: Solution | None = None) -> Solution:
        return lf.Lemke().solve(problem, guess)


def resting_strip() -> lf.Scene:
    """A strip with four modes lies on its two ends, with friction."""
    strip = lf.Beam(length=0.7, width=0.028, thickness=0.005, density=2700.0, youngs_modulus=6.9e10)
    scene = lf.Scene(gravity=(0.0, -9.81))
    body = scene.add(strip.reduce(modes=4, damping=0.02), name="strip", position=(0.0, 0.0025))
    floor = scene.ground.half_plane((0.0, 0.0), (0.0, 1.0))
    for name, x in (("left", 0.0), ("right", 0.7)):
        scene.contact(body.node(x, -0.0025), floor, friction=0.5, name=name)
    return scene


def seconds_per_step(stepper: Any, steps: int) -> float:
    result = lf.simulate(resting_strip(), steps * STEP, stepper, record=steps * STEP, progress=False)
    assert result.size[-1] == 6  # two contacts with friction: n_N + 2 n_H
    return result.wall_time / result.steps


def test_compiled_driver_is_ten_times_faster(interleave: Callable[..., Mapping[str, float]]) -> None:
    medians = interleave(
        {
            "generalised-alpha, compiled driver": lambda: seconds_per_step(GeneralizedAlpha(STEP), 2000),
            "generalised-alpha, Python driver": lambda: seconds_per_step(GeneralizedAlpha(STEP, solver=Delegate()), 50),
            "Moreau-Jean, compiled driver": lambda: seconds_per_step(lf.MoreauJean(STEP), 2000),
        }
    )
    compiled = medians["generalised-alpha, compiled driver"]
    assert medians["generalised-alpha, Python driver"] >= 10.0 * compiled
