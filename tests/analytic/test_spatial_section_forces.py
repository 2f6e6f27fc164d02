"""Section forces of spatial beams against closed forms."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import lcpflex as lf

LENGTH, AREA, DENSITY, BENDING = 0.6, 1e-4, 2700.0, 8e-10
LINE = DENSITY * AREA  # [kg/m]
X = np.array([-0.3, -0.11, 0.0, 0.07, 0.3])
TURN = Rotation.from_rotvec([0.4, -0.7, 0.5])  # of the beam in the world


def beam(modulus: float = 7e10) -> lf.SpatialBeam:
    return lf.SpatialBeam(
        LENGTH, AREA, (BENDING, 2 * BENDING), 3 * BENDING, DENSITY, modulus, poissons_ratio=0.3, elements=10
    )


def held(scene: lf.SpatialScene, body: Any, ends: tuple[str, ...] = ("left",)) -> Any:
    """A body that is turned in the world and welded to the ground at its ends."""
    placed = scene.add(body, "beam", orientation=TURN)
    for end in ends:
        sign = -0.5 if end == "left" else 0.5
        there = scene.ground.at(*TURN.apply([sign * LENGTH, 0, 0]))
        scene.join(lf.Weld(placed.point(end), there, name=f"hold {end}"))
    return placed


@pytest.mark.parametrize("modes", [0, 6])
def test_cantilever_under_its_weight(modes: int) -> None:
    """With q from a section to its end: S = q, M = (l / 2) e_x x q; world and body axes differ.

    The steps follow no mode: all count as static, held by an inertia of 1e12 of their own, which leaves 1e-10.
    """
    gravity = np.array([1.0, -2.0, -9.81])
    scene = lf.SpatialScene(gravity=tuple(gravity))
    held(scene, beam().reduce(modes))
    result = lf.simulate(scene, 1e-2, lf.MoreauJean(step=1e-2))
    found, own = result.section("beam", X), TURN.inv().apply(gravity)
    rest = 0.5 * LENGTH - X
    S = LINE * rest[:, None] * own
    M = 0.5 * rest[:, None] * np.cross([1.0, 0.0, 0.0], S)
    scale = LINE * LENGTH * 10.0
    for k, name in enumerate(("N", "V_y", "V_z")):
        assert getattr(found, name)[0] == pytest.approx(S[:, k], abs=1e-9 * scale)
    for k, name in enumerate(("T", "M_y", "M_z")):
        assert getattr(found, name)[0] == pytest.approx(M[:, k], abs=1e-9 * scale)
    assert found.unique.all()
    assert found.M_y.shape == (2, 5)


def test_a_cantilever_at_rest_bends_as_its_moments_say() -> None:
    """Damped until it rests: M = E I kappa, of the deflected beam itself, in both planes; and they balance the weld."""
    scene = lf.SpatialScene(gravity=(0.3, -2.0, -9.81))
    modulus = 7e9
    body = beam(modulus).reduce(None, damping=0.9, second_order=0)
    placed = scene.add(body, "beam")
    scene.join(lf.Weld(placed.point("left"), scene.ground.at(-LENGTH / 2, 0, 0), name="hold"))
    result = lf.simulate(scene, 4.0, lf.MoreauJean(step=5e-3, theta=1.0), record=1.0)
    eta, x = result.q[-1, 7:], np.array([-0.1, 0.0, 0.1])
    h = 1e-4
    turn = [np.array([eta @ body.locate(float(at), 0, 0).psi for at in x + step]) for step in (-h, h)]
    kappa = (turn[1] - turn[0]) / (2 * h)
    found, told = result.section("beam", x), result.reaction("hold")
    assert found.M_y[-1] == pytest.approx(modulus * BENDING * kappa[:, 1], rel=2e-2)
    assert found.M_z[-1] == pytest.approx(modulus * 2 * BENDING * kappa[:, 2], rel=2e-2)
    end = result.section("beam", -LENGTH / 2)
    assert [end.V_y[-1], end.V_z[-1]] == pytest.approx(-told.force[-1, 1:], rel=1e-4)
    assert [end.M_y[-1], end.M_z[-1]] == pytest.approx(-told.moment[-1, 1:], rel=1e-4)


@pytest.mark.parametrize("modes", [0, 6])
def test_a_rod_that_spins_about_its_end(modes: int) -> None:
    """N = rho A w^2 (L^2 - s^2) / 2 at the distance s from the axis."""
    scene, speed = lf.SpatialScene(gravity=(0, 0, 0)), 30.0
    axis = TURN.apply([0.0, 0.6, 0.8])
    end = TURN.apply([-0.5 * LENGTH, 0, 0])
    placed = scene.add(
        beam().reduce(modes), "beam", orientation=TURN,
        velocity=tuple(np.cross(speed * axis, -end)), angular_velocity=tuple(speed * axis),
    )  # fmt: skip
    scene.join(lf.Revolute(placed.point("left"), scene.ground.at(*end), axis=tuple(axis)))
    result = lf.simulate(scene, 0.02, lf.MoreauJean(step=1e-2))
    s = X + 0.5 * LENGTH
    expected = 0.5 * LINE * speed**2 * (LENGTH**2 - s**2)
    found = result.section("beam", X)
    assert found.N[0] == pytest.approx(expected, rel=1e-9, abs=1e-9 * expected[0])
    # rotary inertia of the section: the axis is none of its principal ones
    assert np.abs([found.V_y[0], found.V_z[0]]).max() < 1e-3 * expected[0]
    twist = LINE * (0.5 * LENGTH - X) * speed**2 * 0.6 * 0.8 * (2 - 1) * BENDING / AREA
    assert np.abs(found.T[0]) == pytest.approx(twist, rel=1e-6, abs=1e-12)


def test_a_shaft_under_a_torque() -> None:
    """T is that of the torque before it, and nothing beyond; a force off the axis bends what is before it, too."""
    scene = lf.SpatialScene(gravity=(0, 0, 0))
    body = beam().reduce(6)
    placed = held(scene, body)
    scene.load(lf.Torque(placed.at(0.05, 0, 0), tuple(TURN.apply([3.0, 0, 0]))))
    scene.load(lf.Force(placed.at(0.2, 0.1, 0), tuple(TURN.apply([0, 0, 5.0]))))
    result = lf.simulate(scene, 1e-2, lf.MoreauJean(step=1e-2))
    x = np.array([-0.3, 0.0, 0.05, 0.1, 0.2, 0.3])
    found = result.section("beam", x)
    assert found.T[0] == pytest.approx([3.5, 3.5, 0.5, 0.5, 0.0, 0.0], abs=1e-8)
    assert found.V_z[0] == pytest.approx([5.0, 5.0, 5.0, 5.0, 0.0, 0.0], abs=1e-8)
    assert found.M_y[0] == pytest.approx([-2.5, -1.0, -0.75, -0.5, 0.0, 0.0], abs=1e-8)
    assert np.abs([found.N[0], found.V_y[0], found.M_z[0]]).max() < 1e-8


def test_what_shares_a_load_is_told(tmp_path: Any) -> None:
    """A rigid beam held at both ends has no one answer; files keep what sections come from."""
    scene = lf.SpatialScene()
    held(scene, beam().reduce(0), ("left", "right"))
    result = lf.simulate(scene, 1e-3, lf.MoreauJean(step=1e-3))
    found = result.section("beam")
    assert not found.unique.any()
    assert "not determined by the motion" in str(found)
    loaded = lf.Result.load(result.save(tmp_path / "run.npz")).section("beam")
    assert (loaded.M_y == found.M_y).all()
    assert loaded.x == pytest.approx(np.linspace(-0.3, 0.3, 11))
    weight = LINE * LENGTH * TURN.inv().apply([0, 0, -9.81])
    assert found.V_y[0, 0] - found.V_y[0, -1] == pytest.approx(weight[1])


def test_what_has_no_sections_is_refused() -> None:
    scene = lf.SpatialScene()
    scene.add(beam().reduce(0), "beam")
    scene.add(lf.Sphere(0.1, mass=1.0), "ball", (2, 0, 0))
    result = lf.simulate(scene, 1e-3, lf.MoreauJean(step=1e-3))
    for bad in (0.31, [0.0, np.nan], "left", [[0.1]]):
        with pytest.raises(lf.ModelError, match=r"x: .* was given, expected a place from -0\.3 to 0\.3 m"):
            result.section("beam", bad)
    with pytest.raises(lf.ModelError, match="'ball' was given, expected a SpatialBeam"):
        result.section("ball")
    with pytest.raises(lf.ModelError, match="stresses of beams are planar so far"):
        result.stress("beam")
    assert np.abs(result.section("beam", X).M_y).max() < 1e-12
