"""Bodies that slide and spin on a ring of many corners: the load is shared as by springs, linear over the ring.

With N_k = A + B x_k + C y_k, from the weight and the moments about the centre of mass at its height above the ground,
and friction mu N_k against the slip of each corner, the spin after 50 ms follows from six ordinary differential
equations (to 1e-10). It does not depend on where the body stands, nor on the stepper.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import lcpflex as lf

STEPPERS = [lf.EventDriven(), lf.MoreauJean(step=2.5e-4), lf.GeneralizedAlpha(step=1e-3)]


def prism(n: int) -> Any:
    angles = 2.0 * math.pi * np.arange(n) / n
    return lf.ConvexHull([(0.05 * math.cos(a), 0.05 * math.sin(a), z) for a in angles for z in (-0.05, 0.05)], mass=1.0)


@pytest.mark.parametrize("stepper", STEPPERS)
@pytest.mark.parametrize(
    ("body", "spin"),
    [(prism(16), 2.53645), (prism(24), 2.54249), (lf.Cylinder(0.05, 0.1, mass=1.0), 2.54726)],
    ids=["16", "24", "can"],
)
def test_spin_is_lost_as_by_corners_on_springs(body: Any, spin: float, stepper: Any) -> None:
    for place in ((0.0, 0.0, 0.05), (0.3, 0.1, 0.05)):
        scene = lf.SpatialScene(gravity=(0.0, 0.0, -9.81))
        ground = scene.ground.box((0.0, 0.0, -0.1), (1.0, 1.0, 0.2))
        moved = scene.add(body, position=place, velocity=(0.6, 0.1, 0.0), angular_velocity=(0.0, 0.0, 3.0))
        scene.contact(moved.surface(), ground, friction=0.2)
        result = lf.simulate(scene, 0.05, stepper, progress=False)
        # of .46 rad/s lost; .15 less, or .03 more, by other shares. A can stands on 16 corners, or on a 17th
        assert result.u[-1, 5] == pytest.approx(spin, abs=3e-4)
