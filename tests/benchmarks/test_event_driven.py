"""A step of the event-driven stepper within the compiled driver against one whose outer loop is Python's."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import lcpflex as lf
from lcpflex import gallery
from lcpflex.dynamics.impact_laws import ImpactLaw, Newton, Poisson, Stronge

LONGEST = 1e-3


def seconds_per_step(duration: float, impact: ImpactLaw, solver: lf.solvers.LcpSolver) -> float:
    """A block that sticks, slips and sticks, in steps of equal length."""
    stepper = lf.EventDriven(max_step=LONGEST, impact=impact, solver=solver)
    result = lf.simulate(gallery.stick_slip_block(), duration, stepper, record=duration, progress=False)
    assert result.steps >= duration / LONGEST
    return result.wall_time / result.steps


def test_compiled_driver_is_ten_times_faster(
    interleave: Callable[..., Mapping[str, float]], delegate: lf.solvers.LcpSolver
) -> None:
    medians = interleave(
        {
            "compiled driver": lambda: seconds_per_step(1.9, Newton(), lf.Lemke()),
            "compiled driver, Poisson": lambda: seconds_per_step(1.9, Poisson(), lf.Lemke()),
            "compiled driver, Stronge": lambda: seconds_per_step(1.9, Stronge(), lf.Lemke()),
            "Python driver": lambda: seconds_per_step(0.05, Newton(), delegate),
        }
    )
    assert medians["Python driver"] >= 10.0 * medians["compiled driver"]


def seconds_per_bounce(impact: ImpactLaw, solver: lf.solvers.LcpSolver) -> float:
    stepper = lf.EventDriven(impact=impact, solver=solver)
    result = lf.simulate(gallery.bouncing_ball(restitution=0.9), 8.0, stepper, record=8.0, progress=False)
    return result.wall_time / len(result.events)


def test_compiled_impacts_are_ten_times_faster(
    interleave: Callable[..., Mapping[str, float]], delegate: lf.solvers.LcpSolver
) -> None:
    medians = interleave(
        {
            "compiled impact": lambda: seconds_per_bounce(Newton(), lf.Lemke()),
            "Python impact": lambda: seconds_per_bounce(Newton(), delegate),
        }
    )
    assert medians["Python impact"] >= 10.0 * medians["compiled impact"]
