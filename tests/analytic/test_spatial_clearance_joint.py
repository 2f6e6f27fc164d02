"""Pins in bores: against the planar joint with play, statics of a tilted pin, and collars that hold along the axis."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import lcpflex as lf
from lcpflex.errors import ModelError

PIN, PLAY, LENGTH = 0.02, 1e-3, 0.1  # [m]
MASS, ARM = 2.0, 0.5
G = 9.81


def pendulum(
    friction: float = 0.0, pin_length: float | None = None, swapped: bool = False, unit: float = 1.0
) -> lf.SpatialScene:
    """A bar on a pin along y, which lies in its bore; ``swapped``: the pin is the bar's."""
    scene = lf.SpatialScene(gravity=(0.0, 0.0, -G * unit))
    low = PLAY if not swapped else -PLAY
    bar = lf.Cuboid(0.04 * unit, 0.1 * unit, ARM * unit, mass=MASS)
    body = scene.add(bar, "bar", (0.1 * unit, 0.0, (-0.5 * ARM - abs(low)) * unit))
    on_bar, fixed = body.at(-0.1 * unit, 0.0, 0.5 * ARM * unit), scene.ground.at(0.0, 0.0, 0.0)
    pair = (fixed, on_bar) if swapped else (on_bar, fixed)
    scene.revolute_with_clearance(
        *pair, PIN * unit, (PIN + PLAY) * unit, friction, axis=(0.0, 1.0, 0.0), length=LENGTH * unit, name="play",
        pin_length=None if pin_length is None else pin_length * unit,
    )  # fmt: skip
    return scene


def twin(friction: float, swapped: bool) -> lf.Scene:
    scene = lf.Scene(gravity=(0.0, -G))
    body = scene.add(lf.RigidBody(MASS, MASS * (ARM**2 + 0.04**2) / 12.0), "bar", (0.1, -0.5 * ARM - PLAY))
    pair = body.at(-0.1, 0.5 * ARM), scene.ground.at(0.0, 0.0)
    scene.revolute_with_clearance(*(pair[::-1] if swapped else pair), PIN, PIN + PLAY, friction)
    return scene


@pytest.mark.parametrize("pin_length", [None, 0.2, 0.06], ids=["flush", "longer", "shorter"])
@pytest.mark.parametrize("swapped", [False, True], ids=["bore swings", "pin swings"])
def test_it_swings_as_in_the_plane(pin_length: float | None, swapped: bool) -> None:
    """With friction the bar rolls and slips in its bore; whichever is longer, and whichever carries the bore."""
    step = lf.MoreauJean(step=1e-3)
    own = lf.simulate(pendulum(0.3, pin_length, swapped), 0.6, step)
    planar = lf.simulate(twin(0.3, swapped), 0.6, step)
    assert len(own.times) == len(planar.times)
    assert np.abs(own.q[:, [0, 2]] - planar.q[:, :2]).max() <= 1e-8
    assert np.abs(own.q[:, 1]).max() <= 1e-8
    assert own.verdict.level >= planar.verdict.level
    assert own.contact("play").force[:, 0] == pytest.approx(planar.contact("contact1").force[:, 0], abs=1e-5 * MASS * G)


def eccentric(load: float, collar: bool = False) -> lf.SpatialScene:
    """A shaft of 0.3 m without weight in a bore along x that is shorter, pulled across at its end, down at first."""
    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    shaft = scene.add(lf.Cylinder(PIN, 0.3, mass=1.0), "shaft", orientation=Rotation.from_rotvec([0, np.pi / 2, 0]))
    more = {"axial_play": 2e-3} if collar else {}
    scene.revolute_with_clearance(
        scene.ground.at(0.0, 0.0, 0.0), shaft.point("center"), PIN, PIN + PLAY,
        axis=(0.0, 0.0, 1.0), length=LENGTH, pin_length=0.3, name="bush", **more,
    )  # fmt: skip
    scene.load(lf.Force(shaft.at(0.0, 0.0, 0.15), (load, 0.0, 0.0), follower=True))
    return scene


def test_an_eccentric_load_tilts_the_pin_until_both_ends_touch() -> None:
    """Ends of the bore at -L/2 and L/2, the load P at a: forces P (a - L/2)/L and P (a + L/2)/L, tilt 2 c/L."""
    rest = lf.equilibrium(eccentric(10.0))
    (bush,) = rest.contacts
    a, L = 0.15, LENGTH
    tilt = Rotation.from_quat(np.roll(rest.q[3:7], -1)).as_matrix() @ [0.0, 0.0, 1.0]
    assert -tilt[2] / tilt[0] == pytest.approx(2.0 * PLAY / L, rel=1e-3)
    assert len(bush.states) == 2
    square = (2.0 * PLAY / L) ** 2  # of the tilt: by so much the levers are longer
    assert sorted(bush.normal) == pytest.approx([10.0 * (a / L - 0.5), 10.0 * (a / L + 0.5)], rel=2.0 * square)
    assert rest.stable


def test_collars_hold_it_along_its_axis() -> None:
    """A shaft that is pushed along its bore goes half of the play, and its collar bears the push."""
    scene = eccentric(0.0, collar=True)
    assert scene.parts().contacts.keys() == {"bush", "bush.first", "bush.second"}
    scene.load(lf.Force(scene.body("shaft").point("center"), (5.0, 0.0, 0.0)))
    step = 1e-4
    result = lf.simulate(scene, 0.1, lf.MoreauJean(step=step))
    assert result.q[-1, 0] == pytest.approx(1e-3, abs=0.1 * step)  # it arrives with 0.1 m/s
    assert result.contact("bush.first").force[-1, 0] == pytest.approx(5.0, rel=1e-6)
    assert not result.contact("bush.second").force[-1, 0]
    assert result.verdict.level > 0


def test_it_slides_along_without_collars_until_it_is_out() -> None:
    """Nothing holds it along its axis; an end that has left the bore touches it no more."""
    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    shaft = scene.add(lf.Cylinder(PIN, 0.05, mass=1.0), "shaft", velocity=(0.0, 0.0, 1.0))
    scene.revolute_with_clearance(
        scene.ground.at(0.0, 0.0, 0.0), shaft.point("center"), PIN, PIN + PLAY,
        axis=(0.0, 0.0, 1.0), length=LENGTH, pin_length=0.05,
    )  # fmt: skip
    result = lf.simulate(scene, 0.2, lf.MoreauJean(step=1e-3))
    assert result.q[-1, 2] == pytest.approx(0.2, abs=1e-12)
    assert result.verdict.level > 0


@pytest.mark.parametrize("stepper", [lf.EventDriven(), lf.GeneralizedAlpha(5e-4)], ids=["event-driven", "alpha"])
def test_other_steppers_agree(stepper: lf.EventDriven | lf.GeneralizedAlpha) -> None:
    fine = lf.simulate(pendulum(0.3), 0.3, lf.MoreauJean(step=1e-4))
    other = lf.simulate(pendulum(0.3), 0.3, stepper)
    assert np.abs(other.q[-1] - fine.q[-1]).max() <= 2e-4


def test_units_do_not_matter() -> None:
    one = lf.simulate(pendulum(0.3, 0.06), 0.3, lf.MoreauJean(step=1e-3))
    other = lf.simulate(pendulum(0.3, 0.06, unit=1000.0), 0.3, lf.MoreauJean(step=1e-3))
    assert np.abs(other.q[:, :3] / 1000.0 - one.q[:, :3]).max() <= 1e-9


def test_a_ball_in_a_bore_rolls_as_in_a_trough() -> None:
    """Small swings across the bore, rolling: omega^2 = 5 g / (7 (R - r)); along it, the ball goes on."""
    scene = lf.SpatialScene()
    R, r, start = 0.5, 0.05, 0.02
    ball = scene.add(
        lf.Sphere(r, mass=1.0), "ball", ((R - r) * np.sin(start), 0.0, -(R - r) * np.cos(start)),
        velocity=(0.0, 0.1, 0.0), angular_velocity=(-0.1 / r, 0.0, 0.0),
    )  # fmt: skip
    scene.contact(ball.sphere("center", r), scene.ground.bore((0.0, 0.0, 0.0), (0.0, 1.0, 0.0), R, 2.0), friction=0.5)
    result = lf.simulate(scene, 1.0, lf.MoreauJean(step=1e-3))
    omega = np.sqrt(5.0 * G / (7.0 * (R - r)))
    assert result.q[:, 0] == pytest.approx((R - r) * start * np.cos(omega * result.times), abs=2e-3 * start)
    assert result.q[-1, 1] == pytest.approx(0.1, rel=start**2)  # spin about the normal turns with the swing


class TestRefused:
    def make(self, **given: object) -> str:
        scene = lf.SpatialScene()
        bar = scene.add(lf.Cuboid(0.1, 0.1, 0.1, mass=1.0), "bar")
        known = {"pin_radius": 0.02, "hole_radius": 0.021, "axis": (0.0, 1.0, 0.0), "length": 0.1}
        return scene.revolute_with_clearance(bar.at(0, 0, 0), scene.ground.at(0, 0, 0), **{**known, **given})  # type: ignore[arg-type]

    @pytest.mark.parametrize(
        ("given", "words"),
        [
            ({"pin_radius": 0.021}, "pin_radius: a radius of 0.021 m was given, expected less than 0.021 m"),
            ({"collar_radius": 0.03}, "collar_radius: 0.03 was given without axial_play"),
            ({"collar_radius": 0.02, "axial_play": 1e-3}, "collar_radius: 0.02 m was given, expected more than 0.021"),
            ({"axis": (0.0, 0.0, 0.0)}, "axis: .* was given, expected a direction"),
            ({"length": -1.0}, "length: "),
            ({"axial_play": -1.0}, "axial_play: "),
        ],
    )
    def test_numbers_that_cannot_be(self, given: dict[str, object], words: str) -> None:
        with pytest.raises(ModelError, match=words):
            self.make(**given)

    def test_a_pin_outside_of_its_bore(self) -> None:
        scene = lf.SpatialScene()
        bar = scene.add(lf.Cuboid(0.1, 0.1, 0.1, mass=1.0), "bar", (0.0, 0.0, 5e-3))
        scene.revolute_with_clearance(
            bar.at(0, 0, 0), scene.ground.at(0, 0, 0), 0.02, 0.021, axis=(0.0, 1.0, 0.0), length=0.1
        )
        with pytest.raises(ModelError, match="contact1"):
            scene.compile()
