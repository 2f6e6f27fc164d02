"""Which contacts of bodies with modes are flat, before a run and after it, and what is said of their steppers."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import lcpflex as lf
from lcpflex import gallery
from lcpflex.checks.first_touch import first_touches, is_flat
from tests.flat_scenes import STEEL, bar_at_wall, bar_on_roller

MASSLESS = lf.MasslessBoundary(step=2e-7)
BAR = (0.2, 0.02, 0.02)


@cache
def reduced(shape: str) -> lf.SpatialBody:
    if shape == "ball":
        return lf.Solid.ball(0.01, 2.5e-3, **STEEL).reduce(12)
    solid = lf.Solid.box(BAR, elements=(20, 2, 2), **STEEL)
    return solid.reduce(20, boundary="right") if shape == "held" else solid.reduce(20, contact="right")


def in_space(
    shape: str = "free", turn: Any = (0.0, 0.0), gap: float = 1e-7, speed: float = 1.0, weight: float = 0.0
) -> Any:
    """A bar that flies along x with its end, or a ball, against a wall; turned about y and z [deg]."""
    scene = lf.SpatialScene(gravity=(weight, 0.0, 0.0))
    turned = Rotation.from_euler("yz", turn, degrees=True)
    corners = 0.5 * np.array(BAR) * (np.array(np.meshgrid(*[(-1, 1)] * 3)).reshape(3, -1).T)
    reach = 0.01 if shape == "ball" else float(turned.apply(corners)[:, 0].max())
    body = scene.add(reduced(shape), "body", (-reach - gap, 0.0, 0.0), turned, velocity=(speed, 0.0, 0.0))
    scene.contact(body.surface(), scene.ground.plane((0.0, 0.0, 0.0), (-1.0, 0.0, 0.0)), name="hit")
    return scene


def side_on_sphere() -> lf.SpatialScene:
    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    bar = scene.add(reduced("free"), "bar", (0.0, 0.0, 0.01 + 1e-7), velocity=(0.0, 0.0, -0.4))
    scene.contact(bar.surface(), scene.ground.sphere((0.0, 0.0, -0.02), 0.02))
    return scene


CASES: dict[str, Any] = {
    "end": (bar_at_wall, {}, True),
    "end, Craig and Bampton": (bar_at_wall, {"basis": "held"}, True),
    "end, far": (bar_at_wall, {"gap": 0.1}, True),
    "end, falling": (bar_at_wall, {"gap": 0.15, "speed": 0.0, "weight": 9.81}, True),
    "end, at rest": (bar_at_wall, {"gap": 0.0, "speed": 0.0, "weight": 9.81}, True),
    "end, hardly tilted": (bar_at_wall, {"tilt": 1e-4}, True),
    "end, little tilted": (bar_at_wall, {"tilt": 1e-3}, False),
    "corner": (bar_at_wall, {"tilt": np.deg2rad(5.0)}, False),
    "corner that turns flat": (bar_at_wall, {"tilt": -0.01, "gap": 0.01, "spin": 1.0}, True),
    "end that turns on its corner": (bar_at_wall, {"gap": 0.01, "spin": 1.0}, False),
    "roller": (bar_on_roller, {}, False),
    "roller, few modes": (bar_on_roller, {"modes": 20}, False),
    "ball of revolution on a rod": (gallery.meshed_sphere_on_rod, {}, False),
    "face": (in_space, {}, True),
    "face, Craig and Bampton": (in_space, {"shape": "held"}, True),
    "face, falling": (in_space, {"gap": 0.1, "speed": 0.0, "weight": 9.81}, True),
    "face, at rest": (in_space, {"gap": 0.0, "speed": 0.0, "weight": 9.81}, True),
    "edge": (in_space, {"turn": (0.0, 5.0)}, False),
    "corner of a block": (in_space, {"turn": (5.0, 5.0)}, False),
    "ball": (in_space, {"shape": "ball", "turn": (20.0, 30.0)}, False),
    "ball on one of its facets": (in_space, {"shape": "ball"}, True),
    "side on a sphere": (side_on_sphere, {}, False),
}


@pytest.mark.parametrize("case", CASES)
def test_how_a_contact_closes_is_told_before_a_run(case: str) -> None:
    make, given, flat = CASES[case]
    (touch,) = first_touches(make(**given).compile())
    assert touch.flat == flat
    assert 1 <= touch.at_once <= touch.points


def test_nothing_is_told_of_what_does_not_close() -> None:
    for scene in (bar_at_wall(speed=-1.0), bar_at_wall(gap=10.0), bar_at_wall(speed=0.0), in_space(speed=-1.0)):
        assert not first_touches(scene.compile())


def test_what_is_led_is_told_only_if_it_touches_soon() -> None:
    """A spring or a joint changes what comes later."""
    for gap, known in ((1e-7, 1), (0.01, 0)):
        scene = bar_at_wall(gap=gap)
        bar = scene.add(lf.Box(0.01, 0.01, mass=1.0), "other", position=(-1.0, 1.0))
        scene.load(lf.Spring(bar.point("center"), scene.ground.at(-1.0, 2.0), stiffness=1.0))
        assert len(first_touches(scene.compile())) == known


def test_units_do_not_matter() -> None:
    """Points on a line or in one place are no face, at any size."""
    square = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]])
    for size in (1e-9, 1.0, 1e9):
        assert is_flat(size * square, 4, size)
        assert not is_flat(size * square, 8, size)
        assert not is_flat(size * square[:2], 2, size)
        assert not is_flat(size * square[[0, 0, 0, 1]], 4, size)
        assert not is_flat(0.0 * square, 4, size)
        assert is_flat(size * square[:2, :2], 2, size)
        assert not is_flat(size * square[:2, :2], 3, size)  # of a roller, .7 of the points are half of the area
        assert not is_flat(size * square[[0, 0], :2], 2, size)


def told(result: lf.Result, words: str) -> list[str]:
    return [text for text in (*result.warnings, *result.notes) if words in text]


@pytest.mark.parametrize("record", [0.0, 4e-6])
def test_a_flat_contact_over_a_massless_boundary_rings_and_is_warned_of(record: float) -> None:
    result = lf.simulate(bar_at_wall(), 1.2e-4, MASSLESS, record=record)
    wave = np.sqrt(2.1e11 * 7850.0) * 0.02**2  # Z v
    within = result.force[(result.times > 15e-6) & (result.times < 60e-6), 0, 0] / wave
    assert np.ptp(within) > 1.5
    (text,) = told(result, "is flat")
    assert text.startswith("contact 'hit' is flat (5 of its 5 points closed within 1.2e-06 s)")


@pytest.mark.parametrize("tilt", [1e-3, np.deg2rad(5.0)])
def test_what_closes_point_by_point_is_not_warned_of(tilt: float) -> None:
    assert not told(lf.simulate(bar_at_wall(tilt), 1.2e-4, MASSLESS, record=0.0), "is flat")


def test_nothing_is_said_where_too_little_was_stored() -> None:
    assert not told(lf.simulate(bar_at_wall(), 1.2e-4, MASSLESS, record=2e-5), "is flat")


@pytest.mark.parametrize("stepper", [lf.MoreauJean(step=4e-7), lf.GeneralizedAlpha(step=4e-7, rho_inf=0.5)])
def test_flat_contacts_are_in_order_with_impacts(stepper: Any) -> None:
    for basis in ("free", "held"):
        result = lf.simulate(bar_at_wall(basis=basis), 1.2e-4, stepper, record=0.0)
        assert not told(result, "is flat")
        assert not told(result, "one by one")


def test_a_roller_under_impacts_is_told_of_the_massless_boundary() -> None:
    (text,) = told(lf.simulate(bar_on_roller(), 1e-4, lf.MoreauJean(step=1e-7), record=0.0), "one by one")
    assert "'hit'" in text
    assert "MasslessBoundary" in text
    assert not told(lf.simulate(bar_on_roller(), 1e-4, MASSLESS, record=0.0), "one by one")
    bouncing = lf.simulate(bar_on_roller(restitution=0.5), 1e-4, lf.MoreauJean(step=1e-7), record=0.0)
    assert not told(bouncing, "one by one")  # nothing bounces by a coefficient over a massless boundary


def test_rigid_bodies_are_told_nothing() -> None:
    scene = lf.Scene(gravity=(0.0, -9.81))
    box = scene.add(lf.Box(0.2, 0.1, mass=1.0), "box", position=(0.0, 0.06))
    scene.contact(box.surface(), scene.ground.half_plane((0.0, 0.0), (0.0, 1.0)))
    assert not first_touches(scene.compile())
    result = lf.simulate(scene, 0.1, lf.MoreauJean(step=1e-4))
    assert not told(result, "is flat")
    assert not told(result, "one by one")
