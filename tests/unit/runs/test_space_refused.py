"""What contacts in space are not offered with is refused by name."""

from __future__ import annotations

import pytest

import lcpflex as lf


def ball_on_floor() -> lf.SpatialScene:
    scene = lf.SpatialScene()
    ball = scene.add(lf.Sphere(radius=0.1, mass=1.0), position=(0.0, 0.0, 0.1))
    scene.contact(ball.surface(), scene.ground.plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0)), name="floor")
    return scene


@pytest.mark.parametrize(
    "stepper",
    [lf.MasslessBoundary(step=1e-3)],
    ids=["massless boundary"],
)
def test_steppers_whose_contacts_are_planar_are_refused(stepper: lf.MasslessBoundary) -> None:
    with pytest.raises(lf.ModelError, match=rf"{type(stepper).__name__}.*SpatialScene.*expected MoreauJean"):
        lf.simulate(ball_on_floor(), 0.01, stepper, progress=False)
