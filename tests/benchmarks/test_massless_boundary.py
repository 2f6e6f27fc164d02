"""Time of a massless-boundary step: compiled against Python, and against Moreau-Jean on the same bar."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import lcpflex as lf
from lcpflex import gallery
from lcpflex.solvers.problem import Lcp, Solution
from lcpflex.steppers.massless_boundary import MasslessBoundary

STEP = 2e-6  # short enough for the sticking ends of the strip: no step is divided


class Delegate:
    """Lemke's method behind an object that is not known to be compiled."""

    def solve(self, problem: Lcp, guess: Solution | None = None) -> Solution:
        return lf.Lemke().solve(problem, guess)


def resting_strip() -> lf.Scene:
    """A strip with eight modes lies on its two ends, with friction."""
    strip = lf.Beam(length=0.7, width=0.028, thickness=0.005, density=2700.0, youngs_modulus=6.9e10)
    scene = lf.Scene(gravity=(0.0, -9.81))
    body = scene.add(strip.reduce(modes=8, damping=0.02), name="strip", position=(0.0, 0.0025))
    floor = scene.ground.half_plane((0.0, 0.0), (0.0, 1.0))
    for name, x in (("left", 0.0), ("right", 0.7)):
        scene.contact(body.node(x, -0.0025), floor, friction=0.5, name=name)
    return scene


def seconds_per_step(stepper: MasslessBoundary, steps: int) -> float:
    result = lf.simulate(resting_strip(), steps * STEP, stepper, record=steps * STEP, progress=False)
    assert not result.warnings
    assert result.size.max() == 6  # two contacts with friction: n_N + 2 n_H
    return result.wall_time / result.steps


def bar(stepper: MasslessBoundary | lf.MoreauJean) -> float:
    result = lf.simulate(gallery.elastic_bar(), 1.5, stepper, record=1.5, progress=False)
    return result.wall_time / result.steps


def test_compiled_driver_is_ten_times_faster(interleave: Callable[..., Mapping[str, float]]) -> None:
    medians = interleave(
        {
            "compiled driver": lambda: seconds_per_step(MasslessBoundary(step=STEP), 5000),
            "Python driver": lambda: seconds_per_step(MasslessBoundary(step=STEP, solver=Delegate()), 200),
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
