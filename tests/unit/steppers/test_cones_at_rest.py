"""What rests in space does not creep, and towers carry what stands on them."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import lcpflex as lf

STEP = 1e-3


def on_incline(angle: float, friction: float, mass: float, axes: Rotation) -> lf.SpatialScene:
    """A box on a slope, all of it in other axes."""
    tilt = axes * Rotation.from_rotvec([0.0, angle, 0.0])
    up = tilt.apply([0.0, 0.0, 1.0])
    scene = lf.SpatialScene(gravity=axes.apply([0.0, 0.0, -9.81]))
    box = scene.add(lf.Cuboid(0.3, 0.2, 0.1, mass=mass), "box", 0.05 * up, tilt)
    scene.contact(box.surface(), scene.ground.plane((0.0, 0.0, 0.0), up), friction=friction)
    return scene


@pytest.mark.parametrize("mass", [1e-9, 2.0, 1e6])
@pytest.mark.parametrize(
    "axes", [Rotation.identity(), Rotation.from_rotvec([0.4, -1.1, 0.7])], ids=["upright", "tilted"]
)
def test_box_sticks_on_an_incline(mass: float, axes: Rotation) -> None:
    """Below the angle of friction: drift of 10 s is rounding."""
    scene = on_incline(0.3, 0.4, mass, axes)
    result = lf.simulate(scene, 10.0, lf.MoreauJean(step=STEP), record=10.0, progress=False)
    assert np.abs(result.q[-1, :3] - result.q[0, :3]).max() < 1e-13
    assert np.abs(result.u[-1]).max() < 1e-14


def test_box_slides_down_a_steeper_one() -> None:
    """x = g (sin - mu cos) t^2 / 2; Moreau and Jean's mean rule is exact for it."""
    angle, mu, time = 0.5, 0.3, 0.5
    scene = on_incline(angle, mu, 2.0, Rotation.from_rotvec([0.4, -1.1, 0.7]))
    result = lf.simulate(scene, time, lf.MoreauJean(step=STEP), record=time, progress=False)
    way = np.linalg.norm(result.q[-1, :3] - result.q[0, :3])
    assert way == pytest.approx(0.5 * 9.81 * (np.sin(angle) - mu * np.cos(angle)) * time**2, rel=1e-8)


def tower(boxes: int, top: float = 1.0) -> lf.SpatialScene:
    """Boxes one on the other, four contacts each, the uppermost of mass ``top``."""
    scene, below = lf.SpatialScene(), None
    ground = scene.ground.plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    for b in range(boxes):
        mass = top if b == boxes - 1 else 1.0
        box = scene.add(lf.Cuboid(0.2, 0.2, 0.2, mass=mass), f"box{b}", (0.0, 0.0, 0.1 + 0.2 * b))
        scene.contact(box.surface(), ground if below is None else below, friction=0.5)
        below = box.surface()
    return scene


@pytest.mark.parametrize("top", [1.0, 100.0])
def test_tower_stands(top: float) -> None:
    """Ten boxes, 40 contacts: they sink by rounding."""
    result = lf.simulate(tower(10, top), 0.3, lf.MoreauJean(step=STEP), record=0.3, progress=False)
    moved = result.q[-1].reshape(10, 7)[:, :3] - result.q[0].reshape(10, 7)[:, :3]
    assert np.abs(moved).max() < 1e-12


def test_what_is_not_solved_is_told() -> None:
    """A tower of 220 contacts to a tolerance below rounding: no way reaches it."""
    below = {"step": STEP, "solver_tolerance": 1e-18}
    with pytest.raises(lf.StepError, match=r"island of 220 contacts was not solved in [1-9]\d* sparse factors"):
        lf.simulate(tower(55), STEP, lf.MoreauJean(**below, on_unsolved="raise"), progress=False)
    result = lf.simulate(tower(55), STEP, lf.MoreauJean(**below), progress=False)
    assert any("were not solved to the tolerance within their budget" in warning for warning in result.warnings)


def test_tall_tower_stands() -> None:
    """55 boxes, 220 contacts that nothing is known of: sweeps crawl, Newton's method in body velocities solves them."""
    result = lf.simulate(tower(55), 20.0 * STEP, lf.MoreauJean(step=STEP), record=20.0 * STEP, progress=False)
    moved = result.q[-1].reshape(55, 7)[:, :3] - result.q[0].reshape(55, 7)[:, :3]
    assert np.abs(moved).max() < 1e-10
    assert not result.warnings
