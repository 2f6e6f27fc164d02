"""A solid block on an incline: it sticks or slides as Coulomb's law says within .1 % of mu, however its face shares.

    vdot = g (sin - mu cos) at atan(1.001 mu),   rest at atan(.999 mu)

It is let go undeformed, strikes, slides a little while it settles, and its own damping brings it to rest.
"""

from __future__ import annotations

import itertools
from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import lcpflex as lf

GRAVITY = 9.81  # [m/s^2]
PLASTIC: dict[str, Any] = {"density": 1200.0, "youngs_modulus": 2e9, "poissons_ratio": 0.35}
SIZES, SLAB = np.array([0.04, 0.03, 0.02]), np.array([0.1, 0.08, 0.03])  # [m] at scale 1
HEADING, SPIN = Rotation.from_euler("z", 0.6), Rotation.from_euler("z", 0.4)  # of the incline; of the block on it
DURATION = 0.04  # [s] at scale 1
SHARES = [0.999, 1.001]  # of the slope, over mu
TIME_STEPPING, MASSLESS = lf.MoreauJean(step=2e-5), lf.MasslessBoundary(step=4e-6)
pytestmark = pytest.mark.filterwarnings("ignore:mesh. its stiffness:lcpflex.ModelWarning")  # coarse


@cache
def block(scale: float, coarse: bool = False) -> lf.SpatialBody:
    bottom = {"bottom": lambda x, y, z: z < -0.4999 * scale * SIZES[2]}
    solid = lf.Solid.box(tuple(scale * SIZES), elements=(2, 2, 1) if coarse else (4, 3, 2), sets=bottom, **PLASTIC)
    return solid.reduce(modes=4, contact="bottom", damping=lf.Rayleigh(0.0, 2e-5 * scale))


@cache
def slab() -> lf.SpatialBody:
    ends = {"top": lambda x, y, z: z > 0.01499, "under": lambda x, y, z: z < -0.01499}
    solid = lf.Solid.box(tuple(SLAB), elements=(3, 2, 1), sets=ends, **PLASTIC)
    held = [lf.Interface("under", contact=False)]
    return solid.reduce(modes=4, interfaces=held, contact="top", damping=lf.Rayleigh(0.0, 2e-5))


def incline(
    share: float, friction: float, scale: float = 1.0, points: str = "areas", on: str = "plane", damper: float = 0.0
) -> tuple[lf.SpatialScene, Rotation]:
    """The block, and the axes of the incline: x downhill, z its normal. Far dampers at its corners act along z."""
    turn = HEADING * Rotation.from_euler("y", np.arctan(share * friction))
    normal = turn.apply([0.0, 0.0, 1.0])
    scene = lf.SpatialScene(gravity=(0.0, 0.0, -GRAVITY))
    half = 0.5 * scale * SIZES
    body = scene.add(block(scale, damper > 0.0), "block", half[2] * normal, turn * SPIN)
    for x, y in itertools.product((-half[0], half[0]), (-half[1], half[1])):
        if damper > 0.0:
            above = half[2] * normal + (turn * SPIN).apply([x, y, -half[2]]) + 100.0 * normal
            scene.load(lf.Spring(body.at(x, y, -half[2]), scene.ground.at(*above), stiffness=0.0, damping=damper))
    surface = scene.ground.plane((0.0, 0.0, 0.0), tuple(normal))
    if on == "slab":
        below = scene.add(slab(), "slab", -0.5 * SLAB[2] * normal, turn)
        scene.join(lf.Weld(below.point("under"), scene.ground.at(*(-SLAB[2] * normal))))
        surface = below.face("top")
    scene.contact(body.face("bottom"), surface, friction=friction, points=points, name="incline")
    return scene, turn


def assert_starts_at_mu(share: float, friction: float, stepper: Any, end: float, **more: Any) -> None:
    """By the last fifth of the run: nothing moves but by rounding, or all slides with that acceleration."""
    scene, turn = incline(share, friction, **more)
    result = lf.simulate(scene, end, stepper, record=end / 400, progress=False)
    late, down = result.times > 0.8 * end, turn.apply([1.0, 0.0, 0.0])
    half = 0.5 * more.get("scale", 1.0) * SIZES
    feet = [(x, y, -half[2]) for x in (-half[0], half[0]) for y in (-half[1], half[1])]
    places = np.stack([result.point("block", foot)[late] for foot in feet])
    normal, *pull = result.contact("incline").force[late].T
    slope = np.arctan(share * friction)
    weight = block(more.get("scale", 1.0)).mass * GRAVITY
    np.testing.assert_allclose(normal, weight * np.cos(slope), rtol=1e-5)
    if share < 1.0:
        np.testing.assert_allclose(np.linalg.norm(pull, axis=0), weight * np.sin(slope), rtol=1e-5)
        assert np.ptp(places, axis=1).max() < 1e-14 * half[0] / DURATION
        return
    speed = result.velocity("block", "bottom")[late] @ down
    found = np.polyfit(result.times[late], speed, 1)[0]
    assert found == pytest.approx(GRAVITY * (np.sin(slope) - friction * np.cos(slope)), rel=1e-3)
    assert np.ptp(places @ down, axis=1).min() > 0.1 * speed[0] * end
    assert np.abs(np.ptp(places @ turn.apply([0.0, 1.0, 0.0]), axis=1)).max() < 1e-6 * half[0]


@pytest.mark.parametrize("points", ["areas", "nodes"])
@pytest.mark.parametrize("share", SHARES)
def test_a_block_on_a_plane_starts_at_mu(share: float, points: str) -> None:
    assert_starts_at_mu(share, 0.3, TIME_STEPPING, DURATION, points=points)


@pytest.mark.parametrize(("scale", "step", "end"), [(0.05, 5e-6, 0.02), (50.0, 1e-3, 5.0)])
@pytest.mark.parametrize("share", SHARES)
def test_so_do_blocks_of_2_mm_and_of_2_m(share: float, scale: float, step: float, end: float) -> None:
    assert_starts_at_mu(share, 0.3, lf.MoreauJean(step), end, scale=scale)


@pytest.mark.parametrize("share", SHARES)
@pytest.mark.parametrize("friction", [0.02, 1.0])
def test_so_does_it_on_smooth_and_rough_planes(friction: float, share: float) -> None:
    assert_starts_at_mu(share, friction, TIME_STEPPING, 2.0 * DURATION)


@pytest.mark.slow
@pytest.mark.parametrize("points", ["areas", "nodes"])
@pytest.mark.parametrize("share", SHARES)
def test_a_block_on_a_solid_slab_starts_at_mu(share: float, points: str) -> None:
    assert_starts_at_mu(share, 0.3, TIME_STEPPING, DURATION, points=points, on="slab")


@pytest.mark.slow
@pytest.mark.parametrize("points", ["areas", "nodes"])
@pytest.mark.parametrize("share", SHARES)
@pytest.mark.parametrize("on", ["plane", "slab"])
def test_massless_it_starts_at_mu(on: str, share: float, points: str) -> None:
    """With dampers: static modes have none, and bounces along the normal couple with slip and grow from mu = .3 on."""
    assert_starts_at_mu(share, 0.3, MASSLESS, DURATION, points=points, on=on, damper=100.0)
