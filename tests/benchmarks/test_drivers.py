"""A step within the compiled driver against the same step with its outer loop in Python."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import lcpflex as lf

STEP = 1e-4


def seconds_per_step(scene: lf.Scene, stepper: lf.MoreauJean, steps: int) -> float:
    result = lf.simulate(scene, steps * STEP, stepper, record=steps * STEP, progress=False)
    assert result.size[-1] == 6  # two contacts with friction: n_N + 2 n_H
    return result.wall_time / result.steps


def test_compiled_driver_is_ten_times_faster(
    interleave: Callable[..., Mapping[str, float]],
    resting_strip: Callable[..., lf.Scene],
    delegate: lf.solvers.LcpSolver,
) -> None:
    scene = resting_strip()
    medians = interleave(
        {
            "compiled driver": lambda: seconds_per_step(scene, lf.MoreauJean(step=STEP), 5000),
            "Python driver": lambda: seconds_per_step(scene, lf.MoreauJean(step=STEP, solver=delegate), 100),
        }
    )
    assert medians["Python driver"] >= 10.0 * medians["compiled driver"]
