"""What is asked of the reduction of a body with its scene: modes, damping, initial deformation."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from tests.unit.compile.bodies import BEAM, RHO, E, plate


def test_initial_deformation_is_that_of_the_free_modes() -> None:
    scene = lf.Scene(gravity=(0.0, 0.0))
    beam = scene.add(BEAM, modes=2, modal=[1e-3, 0.0], modal_velocity=[0.0, 0.1], position=(1.0, 0.0))
    scene.contact(beam.node(1.0, 0.0), scene.ground.half_plane((0.0, -1.0), (0.0, 1.0)))
    compiled = scene.compiled()
    np.testing.assert_allclose(compiled.q[[0, 3, 4]], [1.0, 1e-3, 0.0])
    np.testing.assert_allclose(compiled.u[[3, 4]], [0.0, 0.1])
    assert not compiled.q[5:].any()


def test_damping_of_residual_modes_may_be_their_own() -> None:
    for model, options in ((BEAM, {}), (plate(), {}), (lf.Bar(1.0, 1e-4, RHO, E), {})):
        scene = lf.Scene()
        body = scene.add(model, modes=3, damping=0.05, residual_damping=0.5, **options)
        scene.contact(body.node(0.3, 0.0), scene.ground.half_plane((0.0, -1.0), (0.0, 1.0)))
        bodies = scene.compiled().model.bodies
        ratio = bodies.damping / (2.0 * np.sqrt(bodies.stiffness))
        np.testing.assert_allclose(ratio[:3], 0.05)
        np.testing.assert_allclose(ratio[3:], 0.5)
    with pytest.raises(lf.ModelError, match="residual_damping: -1"):
        lf.Scene().add(BEAM, modes=3, residual_damping=-1.0)


def test_rayleigh_damping_and_a_ratio_of_the_residual_modes() -> None:
    body = BEAM.reduce(2, lf.Rayleigh(1.0, 1e-5), interfaces=["left"], residual_damping=0.1)
    np.testing.assert_allclose(body.damping[:2], 1.0 + 1e-5 * body.stiffness[:2])
    np.testing.assert_allclose(body.damping[2:], 0.2 * np.sqrt(body.stiffness[2:]))


def test_spun_up_with_eight_modes_as_with_all() -> None:
    """Held at its end and turned up to 6 rad/s in 2 s: the tip lags alike within 1 %."""

    def lag(modes: int | None) -> np.ndarray:
        scene = lf.Scene(gravity=(0.0, 0.0))
        stiffening = lf.Stiffening(held="left")
        beam = lf.Beam(4.0, 0.05, 0.02, RHO, E, elements=20, axial=False)
        arm = (
            scene.add(beam.reduce(None, stiffening=stiffening), "arm")
            if modes is None
            else scene.add(beam, "arm", modes=modes, stiffening=stiffening)
        )
        times = np.linspace(0.0, 2.0, 201)
        turned = 3.0 * (0.5 * times**2 + (np.cos(math.pi * times) - 1.0) / math.pi**2)
        hub = scene.add(lf.Box(0.1, 0.1, mass=1.0), "hub")
        scene.join(lf.Revolute(hub.point("center"), scene.ground.at(0.0, 0.0)))
        scene.join(lf.DrivenAngle(hub.point("center"), scene.ground.at(0.0, 0.0), lf.Table(times, turned)))
        scene.join(lf.Weld(arm.point("left"), hub.point("center")))
        result = lf.simulate(scene, 2.0, lf.GeneralizedAlpha(2e-3), progress=False)
        angle = result.q[:, 3 + (len(result.q[0]) - 6) + 2]
        x, y = result.point("arm", "right").T
        return np.asarray(y * np.cos(angle) - x * np.sin(angle))

    few, all_of_them = lag(8), lag(None)
    assert np.abs(all_of_them).max() > 0.02
    assert np.abs(few - all_of_them).max() < 0.01 * np.abs(all_of_them).max()


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({}, "modes: none were given for Beam"),
        ({"modes": -1}, "modes: -1 was given"),
        ({"modes": 2.5}, "modes: 2.5 was given"),
        ({"modes": 3, "damping": [0.1, 0.1]}, "damping: an array of shape"),
        ({"modes": 3, "contact_nodes": -1}, "contact_nodes: -1 was given"),
        ({"modes": 3, "modal": [1.0]}, "modal: an array of shape"),
        ({"modes": 3, "stiffening": 1.0}, "stiffening: 1.0 was given"),
    ],
)
def test_orders_that_cannot_be(options: dict[str, Any], said: str) -> None:
    with pytest.raises(lf.ModelError, match=said):
        lf.Scene().add(BEAM, **options)


def test_bodies_that_have_their_modes_take_no_order() -> None:
    for name, value in (("modes", 3), ("damping", 0.1), ("contact_nodes", 2), ("residual_damping", 0.1)):
        with pytest.raises(lf.ModelError, match=f"{name}: it was given for a Body"):
            lf.Scene().add(BEAM.reduce(2), **{name: value})
    with pytest.raises(lf.ModelError, match="expected a Body, or a flexible body"):
        lf.Scene().add(lf.Beam, modes=3)  # type: ignore[arg-type]
    scene = lf.Scene()
    scene.add(BEAM, modes=500)
    with pytest.raises(lf.ModelError, match="modes: 500 was given"):
        scene.compile()


def test_errors_of_a_reduction_name_the_body() -> None:
    with pytest.raises(lf.ModelError, match=r"stiffening: .* was given for Bar, which takes none"):
        lf.Scene().add(lf.Bar(1.0, 1e-4, RHO, E), modes=5, stiffening=lf.Stiffening(held="left"))
    scene = lf.Scene()
    scene.add(BEAM, "arm", modes=500)
    with pytest.raises(lf.ModelError, match="body 'arm': modes: 500 was given"):
        scene.compile()
    with pytest.raises(lf.ModelError, match=r"interfaces: 5 was given"):
        plate().reduce(3, interfaces=5)  # type: ignore[arg-type]
    with pytest.raises(lf.ModelError, match=r"interfaces\[1\]: "):
        plate().reduce(3, interfaces=[(0.0, 0.0), (0.0, 1.0)])
    with pytest.raises(lf.ModelError, match="forces, moment: both are False"):
        lf.Interface("left", forces=False, moment=False)
