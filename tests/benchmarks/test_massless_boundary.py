"""Time of a massless-boundary step: compiled against Python, and against Moreau-Jean on the same bar."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import lcpflex as lf
from lcpflex import gallery
from lcpflex.steppers.massless_boundary.stepper import MasslessBoundary
from tests.run_warnings import of_the_run

STEP = 2e-6  # short enough for the sticking ends of the strip: no step is divided


def seconds_per_step(scene: lf.Scene, stepper: MasslessBoundary, steps: int) -> float:
    result = lf.simulate(scene, steps * STEP, stepper, record=steps * STEP, progress=False)
    assert not of_the_run(result)
    assert result.size.max() == 6  # two contacts with friction: n_N + 2 n_H
    return result.wall_time / result.steps


def bar(stepper: MasslessBoundary | lf.MoreauJean) -> float:
    result = lf.simulate(gallery.elastic_bar(), 1.5, stepper, record=1.5, progress=False)
    return result.wall_time / result.steps


def test_compiled_driver_is_ten_times_faster(
    interleave: Callable[..., Mapping[str, float]],
    resting_strip: Callable[..., lf.Scene],
    delegate: lf.solvers.LcpSolver,
) -> None:
    scene = resting_strip(modes=8)
    medians = interleave(
        {
            "compiled driver": lambda: seconds_per_step(scene, MasslessBoundary(step=STEP), 5000),
            "Python driver": lambda: seconds_per_step(scene, MasslessBoundary(step=STEP, solver=delegate), 200),
        }
    )
    assert medians["Python driver"] >= 10.0 * medians["compiled driver"]


def test_a_step_costs_about_as_much_as_one_of_moreau_jean(interleave: Callable[..., Mapping[str, float]]) -> None:
    medians = interleave(
        {
            "massless boundary, bar of 400 modes": lambda: bar(MasslessBoundary(step=2e-4)),
            "Moreau-Jean, bar of 400 modes": lambda: bar(lf.MoreauJean(step=2e-4)),
        }
    )
    massless, jean = medians.values()
    assert massless <= 4.0 * jean
