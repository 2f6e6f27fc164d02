"""Time of a reduced pendulum and rod against that of their whole meshes: same contact, same method, same step."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

import lcpflex as lf
from lcpflex.bodies.reduction.component_modes import craig_bampton, unreduced
from lcpflex.bodies.reduction.damping import Rayleigh
from lcpflex.gallery.mechanisms.strikers import pendulum_and_rod, pendulum_with_hammer, rod_with_crown

FINE = 1.2e-3  # elements of the contact region [m]: 3000 coordinates of the whole meshes
DURATION = 1e-4  # of the strike: its first peak and the fall after it [s]
STEP = 4e-8  # within 2 / omega of the whole meshes [s]
DAMPING = Rayleigh(0.0, 1e-9)


def strike(scene: lf.Scene) -> lf.Result:
    stepper = lf.Smooth(lf.Penalty(1e9), integrator=lf.Verlet(STEP))
    return lf.simulate(scene, DURATION, stepper, record=1e-6, progress=False)


def test_reduced_bodies_are_fifty_times_faster_at_an_error_of_a_percent(
    interleave: Callable[..., Mapping[str, float]], report: Callable[[str], None]
) -> None:
    rod, pendulum = rod_with_crown(FINE), pendulum_with_hammer(FINE)
    reduced = pendulum_and_rod(rod, pendulum, lambda mesh, kept: craig_bampton(mesh, kept, modes=40, damping=DAMPING))
    whole = pendulum_and_rod(rod, pendulum, lambda mesh, kept: unreduced(mesh, damping=DAMPING))
    impulses: dict[str, np.ndarray] = {}

    def seconds(name: str, scene: lf.Scene) -> float:
        result = strike(scene)
        assert result.energies.relative_remainder < 1e-3
        impulses[name] = result.impulse[:, 0, 0]
        return result.wall_time

    medians = interleave(
        {"Craig-Bampton, 40 modes": lambda: seconds("reduced", reduced), "whole mesh": lambda: seconds("whole", whole)},
        rounds=1,
    )
    off = float(np.abs(impulses["reduced"] - impulses["whole"]).max() / impulses["whole"].max())
    report(f"largest error of the impulse of the reduced bodies: {off:.2g} of it")
    assert off < 0.01
    assert medians["whole mesh"] >= 50.0 * medians["Craig-Bampton, 40 modes"]
