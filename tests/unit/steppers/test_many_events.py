"""Where many contacts switch at one instant, an event-driven run goes on: what they would switch by is no motion."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

import lcpflex as lf

LENGTH, THICKNESS = 0.1, 0.02


def chain(links: int, friction: float, restitution: float, degrees: float, units: tuple[float, float]) -> lf.Scene:
    """Hinged links fall onto a floor, the left end first, from 0.2 m; ``units``: of length [m] and mass [kg]."""
    m, kg = 1.0 / units[0], 1.0 / units[1]
    scene = lf.Scene(gravity=(0.0, -9.81 * m))
    scene.ground.half_plane((0.0, 0.0), (0.0, 1.0))
    link = lf.Box(LENGTH * m, THICKNESS * m, mass=0.1 * kg)
    angle = math.radians(degrees)
    x, y = LENGTH * m * math.cos(angle), LENGTH * m * math.sin(angle)
    placed = [
        scene.add(link, position=((k + 0.5) * x, 0.2 * m + 0.5 * THICKNESS * m + (k + 0.5) * y), angle=angle)
        for k in range(links)
    ]
    for left, right in itertools.pairwise(placed):
        scene.join(lf.Revolute(left.point("right"), right.point("left")))
    scene.contact_all(friction=friction, restitution=restitution)
    return scene


@pytest.mark.parametrize(
    ("links", "friction", "restitution", "degrees", "units"),
    [
        (8, 0.5, 0.0, 5.0, (1.0, 1.0)),  # links that lie on the floor slide as one, faster than the threshold by noise
        (8, 0.3, 0.3, 5.0, (1.0, 1.0)),
        (8, 1.0, 0.0, 5.0, (1e-3, 1e3)),  # millimetres and tonnes
        (12, 0.4, 0.0, 15.0, (1.0, 1.0)),  # each of many events a little later
        pytest.param(8, 0.5, 0.5, 5.0, (1.0, 1.0), marks=pytest.mark.slow),
        pytest.param(7, 0.3, 0.3, 5.0, (1.0, 1.0), marks=pytest.mark.slow),
    ],
)
def test_a_chain_comes_to_lie_on_a_floor(
    links: int, friction: float, restitution: float, degrees: float, units: tuple[float, float]
) -> None:
    """It lies flat or bounces low, with less energy than it began with; what was raised to go on is told."""
    scene = chain(links, friction, restitution, degrees, units)
    result = lf.simulate(scene, 0.6, lf.EventDriven())
    assert result.times[-1] == pytest.approx(0.6)
    (said,) = (text for text in result.warnings if "events accumulated" in text)
    assert "slip slower than" in said
    assert "NOT" not in result.summary()
    assert result.energies.relative_remainder < 2e-4
    energy = result.energies.kinetic + result.energies.potential
    assert energy[-1] < energy[0] - 0.5 * (energy[0] - result.energies.potential.min())
    height = result.q[-1].reshape(links, 3)[:, 1] * units[0]
    assert np.all(height > 0.5 * THICKNESS - 1e-7)
    if restitution == 0.0:
        assert height.max() < 0.5 * THICKNESS + 1e-3
