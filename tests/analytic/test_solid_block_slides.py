"""A solid block on a rough floor: it begins to slide where Coulomb's law says, however its face shares the load."""

from __future__ import annotations

import numpy as np
import pytest

import lcpflex as lf

GRAVITY, FRICTION, RAMP = 9.81, 0.3, 1.0  # [m/s^2], -, time in which the pull reaches 1.02 mu m g [s]
PLASTIC = {"density": 1200.0, "youngs_modulus": 2e9, "poissons_ratio": 0.35}


@pytest.mark.filterwarnings("ignore:mesh. its stiffness:lcpflex.ModelWarning")  # coarse: the sum is that of any mesh
@pytest.mark.parametrize("points", ["areas", "nodes"])
def test_a_pulled_block_begins_to_slide_at_mu(points: str) -> None:
    """Pulled at its bottom, slowly more: all points stick, then some slip by less than a nanometre, at mu m g all.

    From then on  m vdot = T - mu m g,  T growing evenly, so that v is a square of the time since then.
    """
    solid = lf.Solid.box((0.04, 0.03, 0.02), elements=(4, 3, 2), **PLASTIC)
    body = solid.reduce(modes=4, interfaces=["bottom"], contact="bottom", damping=lf.Rayleigh(0.0, 1e-4))
    weight, step = body.mass * GRAVITY, 1e-3
    scene = lf.SpatialScene(gravity=(0.0, 0.0, -GRAVITY))
    block = scene.add(body, name="block", position=(0.0, 0.0, 0.01))
    pull = lf.Table([0.0, 0.1, 0.1 + RAMP], [0.0, 0.0, 1.02 * FRICTION * weight])
    scene.load(lf.Force(block.point("bottom"), (pull, 0.0, 0.0)))
    floor = scene.ground.plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    scene.contact(block.face("bottom"), floor, friction=FRICTION, points=points, name="floor")
    result = lf.simulate(
        scene, 0.1 + RAMP, lf.MoreauJean(step=step, solver_tolerance=1e-11), record=step, progress=False
    )
    pulled = 1.02 * FRICTION * np.clip((result.times - 0.1) / RAMP, 0.0, 1.0)
    way, speed = result.point("block", "bottom")[:, 0], result.velocity("block", "bottom")[:, 0]
    slides = pulled > 1.01 * FRICTION
    slope, offset = np.polyfit(pulled[slides], np.sqrt(speed[slides]), 1)
    assert -offset / slope == pytest.approx(FRICTION, rel=1e-3)
    assert slope**2 == pytest.approx(0.5 * GRAVITY / (1.02 * FRICTION / RAMP), rel=0.01)
    assert np.abs(way[pulled < 0.3 * FRICTION]).max() < 1e-15
    assert np.abs(way[pulled < 0.99 * FRICTION]).max() < 1e-9
