"""A step of the generalised-alpha stepper: its two drivers, and the same scene by Moreau and Jean."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import lcpflex as lf
from lcpflex.steppers.generalized_alpha.stepper import GeneralizedAlpha

STEP = 1e-4


def seconds_per_step(scene: lf.Scene, stepper: Any, steps: int) -> float:
    result = lf.simulate(scene, steps * STEP, stepper, record=steps * STEP, progress=False)
    assert result.size[-1] == 6  # two contacts with friction: n_N + 2 n_H
    return result.wall_time / result.steps


def test_compiled_driver_is_ten_times_faster(
    interleave: Callable[..., Mapping[str, float]],
    resting_strip: Callable[..., lf.Scene],
    delegate: lf.solvers.LcpSolver,
) -> None:
    scene = resting_strip()
    python = GeneralizedAlpha(STEP, solver=delegate)
    medians = interleave(
        {
            "generalised-alpha, compiled driver": lambda: seconds_per_step(scene, GeneralizedAlpha(STEP), 2000),
            "generalised-alpha, Python driver": lambda: seconds_per_step(scene, python, 50),
            "Moreau-Jean, compiled driver": lambda: seconds_per_step(scene, lf.MoreauJean(STEP), 2000),
        }
    )
    compiled = medians["generalised-alpha, compiled driver"]
    assert medians["generalised-alpha, Python driver"] >= 10.0 * compiled
