"""A corner that comes to the end of a face as it reaches it strikes nothing: an edge leaves it at the same instant."""

from __future__ import annotations

import math

import numpy as np
import pytest

import lcpflex as lf

LENGTH, HEIGHT = 0.2, 0.06  # of a brick, over the size


def tipping(size: float, speed: float, way: float, held: bool, turn: float) -> lf.Scene:
    """A smooth brick slides over the end of an equal one and tips off; all of it turned by an angle."""
    a, b = LENGTH * size, HEIGHT * size
    c, s = math.cos(turn), math.sin(turn)

    def at(x: float, y: float) -> tuple[float, float]:
        return c * x - s * y, s * x + c * y

    scene = lf.Scene(gravity=at(0.0, -9.81 * size))
    brick = lf.Box(a, b, mass=1.0)
    if held:
        body = scene.add(brick, "low", angle=turn)
        scene.join(lf.Weld(body.at(0.0, 0.0), scene.ground.at(0.0, 0.0)))
        low = body.surface()
    else:
        corners = [(-0.5 * a, -0.5 * b), (0.5 * a, -0.5 * b), (0.5 * a, 0.5 * b), (-0.5 * a, 0.5 * b)]
        low = scene.ground.chain([at(*corner) for corner in corners], closed=True)
    velocity = at(way * speed * math.sqrt(9.81 * LENGTH) * size, 0.0)
    up = scene.add(brick, "up", position=at(way * 0.25 * a, b), angle=turn, velocity=velocity)
    scene.contact(up.surface(), low, name="bricks")
    return scene


@pytest.mark.parametrize("speed", [0.1, 0.2, 0.5, 0.7, 1.0])
@pytest.mark.parametrize(("size", "way", "held", "turn"), [(1.0, 1.0, False, 0.0), (1e3, -1.0, True, 0.3)])
@pytest.mark.parametrize("rtol", [1e-5, 1e-8])
def test_a_brick_tips_off_an_edge_without_an_impact(
    size: float, way: float, held: bool, turn: float, speed: float, rtol: float
) -> None:
    """Nothing is lost where nothing rubs and nothing strikes; it leaves once."""
    scene = tipping(size, speed, way, held, turn)
    result = lf.simulate(scene, 0.8, lf.EventDriven(rtol=rtol), progress=False)
    assert "impact" not in [event.kind for event in result.events if event.time > 0.0]
    stored = result.energies.kinetic + result.energies.potential
    assert np.ptp(stored) <= 1e3 * rtol * np.ptp(result.energies.kinetic)
    assert result.force[-1, 0, 0] == 0.0  # it has left


def test_a_corner_that_lands_at_the_very_end_of_a_face_strikes_it() -> None:
    """A brick falls on an equal one, exactly above it or a little aside, and moves aside as it falls: it lands."""
    for aside, speed in ((0.0, 0.0), (0.0, 0.3), (1e-12, 0.3), (-1e-12, 0.3), (1e-4, 0.3)):
        scene = lf.Scene()
        brick = lf.Box(LENGTH, HEIGHT, mass=1.0)
        low = scene.add(brick, "low", position=(0.0, 0.5 * HEIGHT))
        up = scene.add(brick, "up", position=(aside, 1.5 * HEIGHT + 0.02), velocity=(speed, 0.0))
        scene.contact(low.surface(), scene.ground.half_plane((0.0, 0.0), (0.0, 1.0)), friction=0.3)
        scene.contact(up.surface(), low.surface(), friction=0.3)
        result = lf.simulate(scene, 0.2, lf.EventDriven(), progress=False)
        height = result.point("up", "center")[:, 1]
        assert height.min() > 1.5 * HEIGHT - 1e-9
        assert height[-1] == pytest.approx(1.5 * HEIGHT, abs=1e-9)


def test_a_box_that_tips_onto_the_end_of_a_face_strikes_it() -> None:
    """It turns about its left corner and comes down flush: the right corner meets the very end of the other's face."""
    scene = lf.Scene()
    brick = lf.Box(LENGTH, HEIGHT, mass=1.0)
    low = scene.ground.chain([(0.0, -HEIGHT), (LENGTH, -HEIGHT), (LENGTH, 0.0), (0.0, 0.0)], closed=True)
    lean = 0.1
    middle = (0.5 * LENGTH * math.cos(lean) - 0.5 * HEIGHT * math.sin(lean),
              0.5 * LENGTH * math.sin(lean) + 0.5 * HEIGHT * math.cos(lean))  # fmt: skip
    up = scene.add(brick, "up", position=middle, angle=lean)
    scene.contact(up.surface(), low, friction=0.8)
    result = lf.simulate(scene, 0.4, lf.EventDriven(), progress=False)
    assert "impact" in [event.kind for event in result.events if event.time > 0.0]
    assert result.point("up", "center")[-1, 1] == pytest.approx(0.5 * HEIGHT, abs=1e-9)
