"""Bodies that go through each other between two looks, and indentations deeper than a body: said by every stepper."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import lcpflex as lf
from lcpflex.results.doubts import doubts
from tests.scenes import disc_on_floor, floor_of, shot_at_thin_wall

Loud = Callable[..., str]


def dropped(size: float = 1.0) -> lf.Scene:
    """A disc of ``size`` / 10 falls on a floor, for lengths in units of 1/size metres."""
    return disc_on_floor(0.3 * size, radius=0.1 * size, mass=1.0 / size, gravity=9.81 * size, restitution=0.5)


def head_on(offset: float) -> lf.Scene:
    """Two discs of 5 mm radius that meet at 200 m/s."""
    scene = lf.Scene(gravity=(0.0, 0.0))
    one = scene.add(lf.Disc(0.005, mass=0.01), position=(-0.5, 0.0), velocity=(100.0, 0.0))
    other = scene.add(lf.Disc(0.005, mass=0.01), position=(0.5, offset), velocity=(-100.0, 0.0))
    scene.contact(one.surface(), other.surface(), name="pair")
    return scene


@pytest.mark.parametrize("size", [1.0, 1e3])
def test_the_last_instant_is_measured(loud: Loud, size: float) -> None:
    # one step, from 0.3 m above the floor to 4.6 m below it
    said = loud(dropped(size), 1.0, lf.MoreauJean(step=1.0))
    assert "penetrates by" in said
    assert "is large for a scene" in said
    sound = lf.simulate(dropped(size), 1.0, lf.MoreauJean(step=1e-4))
    assert doubts(sound) == sound.warnings == ()


def test_penetration_counts_where_a_run_ends_and_not_only_where_a_contact_holds() -> None:
    # the disc touches at 0.2019 s; the one step that passes the floor is the last
    result = lf.simulate(dropped(), 0.24, lf.MoreauJean(step=0.12))
    assert result.penetration.max() == pytest.approx(0.1 - result.q[-1, 1], rel=1e-12)
    assert result.penetration.max() > 0.05


FIXED = [
    pytest.param(lf.MoreauJean(step=7e-4), None, id="moreau"),
    pytest.param(lf.GeneralizedAlpha(step=1e-3), None, id="alpha"),
    pytest.param(lf.MoreauJean(step=7e-4), lf.Penalty(1e7), id="moreau, by law"),
    pytest.param(lf.Smooth(lf.Penalty(1e7), integrator=lf.Verlet(7e-4)), None, id="verlet"),
]


@pytest.mark.parametrize("size", [1.0, 1e3])
@pytest.mark.parametrize(("stepper", "law"), FIXED)
def test_a_disc_does_not_fly_through_a_wall_unseen(loud: Loud, stepper: Any, law: Any, size: float) -> None:
    said = loud(shot_at_thin_wall(size=size, law=law, start=-0.091), 0.0028, stepper)
    assert "the bodies of contact 'wall' passed through each other, or met by luck, at t = " in said
    assert "take steps of at most 3e-05 s" in said or "take steps of at most 4e-05 s" in said


@pytest.mark.parametrize("stepper", [lf.MoreauJean(step=1e-3), lf.GeneralizedAlpha(step=1e-3)])
@pytest.mark.parametrize("offset", [0.0, 0.003, 0.008])
def test_two_discs_do_not_pass_each_other_unseen(loud: Loud, stepper: Any, offset: float) -> None:
    assert "the bodies of contact 'pair' passed through each other" in loud(head_on(offset), 0.01, stepper)


def test_a_spinning_rod_does_not_pass_a_disc_unseen(loud: Loud) -> None:
    scene = lf.Scene(gravity=(0.0, 0.0))
    rod = scene.add(lf.Box(1.0, 0.01, mass=1.0), angular_velocity=300.0)
    disc = scene.add(lf.Disc(0.02, mass=1.0), position=(0.0, 0.4))
    scene.contact(rod.surface(), disc.surface(), name="rod")
    assert "the bodies of contact 'rod' passed through each other" in loud(scene, 0.02, lf.GeneralizedAlpha(step=1e-3))


@pytest.mark.parametrize("stepper", [lf.MoreauJean(step=1e-3), lf.GeneralizedAlpha(step=1e-3)])
def test_a_fast_body_that_meets_nothing_thin_is_no_reason_to_doubt(stepper: Any) -> None:
    beside = shot_at_thin_wall(height=0.2)
    beside.contact(beside.body("disc").surface(), beside.ground.half_plane((0, -5), (0, 1)))
    result = lf.simulate(beside, 0.01, stepper)
    assert doubts(result) == result.warnings == ()
    # two that fly side by side, 1 mm apart, faster than they are thick
    scene = lf.Scene(gravity=(0.0, 0.0))
    discs = [scene.add(lf.Disc(0.005, mass=0.01), position=(0.0, y), velocity=(100.0, 0.0)) for y in (0.0, 0.011)]
    scene.contact(discs[0].surface(), discs[1].surface())
    result = lf.simulate(scene, 0.01, stepper)
    assert doubts(result) == result.warnings == ()


@pytest.mark.parametrize("stepper", [lf.MoreauJean(step=2e-6), lf.GeneralizedAlpha(step=2e-6), lf.EventDriven()])
def test_a_wall_that_a_fine_step_meets_stops_the_disc(stepper: Any) -> None:
    result = lf.simulate(shot_at_thin_wall(), 0.001, stepper)
    assert result.q[-1, 0] == pytest.approx(-0.005, abs=2e-4)
    assert result.found_wrong == result.warnings == ()


SOFT = [
    pytest.param(lf.Smooth(lf.Penalty(1e5)), None, id="runge-kutta"),
    pytest.param(lf.Smooth(lf.Penalty(1e5), integrator=lf.Stiff()), None, id="stiff"),
    pytest.param(lf.Smooth(lf.Penalty(1e5), integrator=lf.Verlet(1e-5)), None, id="verlet"),
    pytest.param(lf.MoreauJean(step=1e-5), lf.Penalty(1e5), id="moreau"),
    pytest.param(lf.EventDriven(), lf.Penalty(1e5), id="event-driven"),
]


@pytest.mark.parametrize(("stepper", "law"), SOFT)
def test_a_law_too_soft_lets_a_body_out_on_the_far_side_and_is_told_of(loud: Loud, stepper: Any, law: Any) -> None:
    said = loud(shot_at_thin_wall(law=law), 0.001, stepper)
    assert "the indentation of contact 'wall' reached 0.00" in said
    assert "comes out of the other on the far side" in said


def test_a_stiff_law_turns_the_body_back_and_is_trusted() -> None:
    for stepper, law in ((lf.Smooth(lf.Penalty(1e8)), None), (lf.EventDriven(), lf.Penalty(1e8))):
        result = lf.simulate(shot_at_thin_wall(law=law), 0.001, stepper)
        assert result.u[-1, 0] == pytest.approx(-100.0, rel=1e-3)
        assert result.found_wrong == ()


def test_a_disc_that_vanishes_in_a_soft_floor_is_told_of(loud: Loud) -> None:
    scene = lf.Scene()
    disc = scene.add(lf.Disc(0.01, mass=1.0), position=(0.0, 0.02))
    scene.contact(disc.surface(), floor_of(scene), name="floor")
    # static indentation m g/k = 98 mm, five diameters
    assert "the indentation of contact 'floor' reached" in loud(scene, 0.5, lf.Smooth(lf.Penalty(1e2)))
    result = lf.simulate(scene, 0.5, lf.Smooth(lf.Penalty(1e5)))
    assert result.found_wrong == ()
    assert np.isfinite(result.q).all()
    assert math.isfinite(result.penetration.max())


def crossing(kind: str, height: float) -> lf.SpatialScene:
    """Two rods, bars or a bar and a plate that cross at 10 m/s, far from their ends."""
    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    along = Rotation.from_euler("y", 90, degrees=True)
    held = lf.Capsule(0.002, 0.3, mass=0.01) if kind == "rods" else lf.Cuboid(4e-3, 4e-3, 0.3, mass=0.01)
    one = scene.add(held, orientation=along)
    place, down = (0.01, 0.013, height), (0.0, 0.0, -10.0)
    if kind == "bar and plate":
        other = scene.add(lf.Cuboid(0.1, 0.1, 5e-4, mass=0.01), position=place, velocity=down)
    else:
        turn = Rotation.from_rotvec([0.0, 0.0, 1.2]) * along
        other = scene.add(held, position=place, orientation=turn, velocity=down)
    scene.contact(one.surface(), other.surface(), restitution=0.5, name="cross")
    return scene


@pytest.mark.parametrize("stepper", [lf.MoreauJean(step=1e-3), lf.GeneralizedAlpha(step=1e-3)])
@pytest.mark.parametrize("kind", ["rods", "bars", "bar and plate"])
def test_what_crosses_edge_on_edge_does_not_pass_unseen(stepper: Any, kind: str) -> None:
    """No node comes near the other body. At some heights steps meet it, at others they do not, and say so."""
    missed = 0
    for height in np.linspace(0.05, 0.0599, 8):
        result = lf.simulate(crossing(kind, float(height)), 0.02, stepper, progress=False)
        if not result.contact("cross").impulse[-1, 0] > 0.0:
            missed += 1
            assert "the bodies of contact 'cross' passed through each other" in " ".join(doubts(result))
    assert missed > 0


@pytest.mark.parametrize("stepper", [lf.MoreauJean(step=2e-5), lf.GeneralizedAlpha(step=2e-5), lf.EventDriven()])
@pytest.mark.parametrize("kind", ["rods", "bars", "bar and plate"])
def test_what_crosses_edge_on_edge_and_is_met_is_trusted(stepper: Any, kind: str) -> None:
    result = lf.simulate(crossing(kind, 0.05), 0.01, stepper, progress=False)
    assert result.contact("cross").impulse[-1, 0] > 0.0
    assert not doubts(result)


def clipped(speed: float) -> lf.SpatialScene:
    """A turning cube of 1 cm that grazes a sphere as large."""
    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    ball = scene.add(lf.Sphere(0.01, mass=1.0))
    cube = scene.add(
        lf.Cuboid(0.01, 0.01, 0.01, mass=0.01),
        position=(0.01, 0.013, 0.3),
        velocity=(0.0, 0.0, -speed),
        angular_velocity=(30.0, 20.0, 5.0),
    )
    scene.contact(ball.surface(), cube.surface(), friction=0.2, restitution=0.5, name="clip")
    return scene


@pytest.mark.parametrize(
    "stepper", [lf.MoreauJean(step=1e-3), lf.GeneralizedAlpha(step=1e-3), lf.GeneralizedAlpha(step=5e-4)]
)
def test_what_is_pushed_out_of_a_body_without_an_impulse_is_told(loud: Loud, stepper: Any) -> None:
    """A pair that opens again at the end of the step in which it closed: half the step sees no more of it."""
    said = loud(clipped(10.0), 0.062, stepper)
    assert "penetrates by 877.8 µm at t = " in said


def test_what_grazes_a_body_in_fine_steps_is_trusted() -> None:
    result = lf.simulate(clipped(10.0), 0.062, lf.GeneralizedAlpha(step=1e-5), progress=False)
    assert result.contact("clip").impulse[-1, 0] == pytest.approx(0.0425, rel=0.01)
    assert not doubts(result)
