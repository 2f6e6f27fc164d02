"""Corners of a patch that begin where another one has left, of no extent then: event-driven runs find them soon after.

A box spins on a plate that is narrower than it is long: a vertex leaves over a side of the plate, and edges on either
side of the vertex cross that side from then on. Without one of the two crossings the load is shared in another way.
"""

from __future__ import annotations

import pytest
from scipy.spatial.transform import Rotation

import lcpflex as lf


def turned(yaw: float, aside: float, stepper: object, reverse: bool) -> tuple[float, float]:
    """Angle about z and way across in .3 s."""
    scene = lf.SpatialScene(gravity=(0.0, 0.0, -9.81))
    plate = scene.add(lf.Cuboid(0.3, 0.06, 0.06, mass=1.0), position=(0.0, 0.0, 0.03))
    scene.join(lf.Weld(plate.at(0.0, 0.0, 0.0), scene.ground.at(0.0, 0.0, 0.03)))
    box = scene.add(
        lf.Cuboid(0.2, 0.1, 0.06, mass=1.0),
        name="box",
        position=(0.0, aside, 0.09),
        orientation=Rotation.from_euler("z", yaw),
        velocity=(0.2, 0.0, 0.0),
        angular_velocity=(0.0, 0.0, 6.0),
    )
    pair = (box.surface(), plate.surface())
    scene.contact(*(pair[::-1] if reverse else pair), friction=0.3)
    result = lf.simulate(scene, 0.3, stepper, progress=False)
    return float(result.orientation("box")[-1].as_rotvec()[2]) - yaw, float(result.q[-1, 8]) - aside


@pytest.mark.parametrize(("yaw", "aside"), [(0.0, 0.0), (1e-7, 0.0), (0.01, 0.01)])
@pytest.mark.parametrize("reverse", [False, True])
def test_a_box_that_spins_over_the_sides_of_a_plate(yaw: float, aside: float, reverse: bool) -> None:
    found = turned(yaw, aside, lf.EventDriven(), reverse)
    known = turned(yaw, aside, lf.GeneralizedAlpha(step=5e-4), reverse)
    assert found == pytest.approx(known, abs=1e-4)  # of .27 rad: one corner less makes 1.5e-3 to 4.6e-3
