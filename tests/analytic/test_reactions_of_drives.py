"""Torques and forces of drives against the power balance of mechanisms of one degree of freedom.

With the prescribed coordinate f and K + V = I(f) f'^2 / 2 + V(f), the drive has Q = I f'' + I' f'^2 / 2 + V'.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.jit.kernel import FloatArray

G = 9.81
SWING, OMEGA = 2.0, 5.0  # the drive turns by SWING sin(OMEGA t)
CRANK, ROD = 0.2, 0.7  # [m]
MASSES, INERTIAS = (1.5, 0.8, 2.0), (0.02, 0.05)
Curve = Callable[[Any], Any]


def motion(times: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    phase = OMEGA * times
    return SWING * np.sin(phase), SWING * OMEGA * np.cos(phase), -SWING * OMEGA**2 * np.sin(phase)


def rate(curve: Curve, x: FloatArray) -> FloatArray:
    """Derivative by a complex step."""
    return np.asarray(curve(x + 1e-30j)).imag / 1e-30


def balance(inertia: Curve, potential: Curve, times: FloatArray) -> FloatArray:
    f, speed, acceleration = motion(times)
    return np.asarray(inertia(f).real) * acceleration + 0.5 * rate(inertia, f) * speed**2 + rate(potential, f)


def slider_crank() -> lf.Scene:
    scene = lf.Scene(gravity=(0, -G))
    spin = SWING * OMEGA
    half = 0.5 * CRANK
    crank = scene.add(
        lf.RigidBody(mass=MASSES[0], inertia=INERTIAS[0]), "crank", position=(half, 0.0), velocity=(0.0, spin * half),
        angular_velocity=spin,
    )  # fmt: skip
    rod = scene.add(
        lf.RigidBody(mass=MASSES[1], inertia=INERTIAS[1]), "rod", position=(CRANK + 0.5 * ROD, 0.0),
        velocity=(0.0, 0.5 * spin * CRANK), angular_velocity=-spin * CRANK / ROD,
    )  # fmt: skip
    slider = scene.add(lf.RigidBody(mass=MASSES[2], inertia=0.1), "slider", position=(CRANK + ROD, 0.0))
    ground = scene.ground.at(0.0, 0.0)
    scene.join(lf.Revolute(crank.at(-half, 0), ground, name="shaft"))
    scene.join(lf.Revolute(rod.at(-0.5 * ROD, 0), crank.at(half, 0), name="pin"))
    scene.join(lf.Revolute(rod.at(0.5 * ROD, 0), slider.at(0, 0), name="wrist"))
    scene.join(lf.Prismatic(slider.at(0, 0), ground, name="guide"))
    scene.join(lf.DrivenAngle(crank.at(-half, 0), ground, lf.Harmonic(SWING, OMEGA), name="motor"))
    return scene


def places(theta: Any) -> tuple[Any, ...]:
    """Angle of the rod, the middle of the rod, the slider."""
    lean = -np.arcsin(CRANK / ROD * np.sin(theta))
    x, y = CRANK * np.cos(theta), CRANK * np.sin(theta)
    return lean, x + 0.5 * ROD * np.cos(lean), y + 0.5 * ROD * np.sin(lean), x + ROD * np.cos(lean)


def slider_crank_inertia(theta: Any) -> Any:
    """By the chain rule, all of it analytic in theta."""
    ratio = CRANK / ROD
    turn = -ratio * np.cos(theta) / np.sqrt(1.0 - (ratio * np.sin(theta)) ** 2)  # of the rod by that of the crank
    lean = places(theta)[0]
    x, y = -CRANK * np.sin(theta), CRANK * np.cos(theta)
    middle = (x - 0.5 * ROD * np.sin(lean) * turn) ** 2 + (y + 0.5 * ROD * np.cos(lean) * turn) ** 2
    slide = (x - ROD * np.sin(lean) * turn) ** 2
    own = INERTIAS[0] + MASSES[0] * 0.25 * CRANK**2
    return own + INERTIAS[1] * turn**2 + MASSES[1] * middle + MASSES[2] * slide


def slider_crank_potential(theta: Any) -> Any:
    return G * (MASSES[0] * 0.5 * CRANK * np.sin(theta) + MASSES[1] * places(theta)[2])


@pytest.fixture(scope="module")
def crank_run() -> lf.Result:
    return lf.simulate(slider_crank(), 1.2, lf.EventDriven(), record=0.01, progress=False)


def test_torque_of_a_slider_crank(crank_run: lf.Result) -> None:
    torque = crank_run.reaction("motor").drive
    assert torque is not None
    expected = balance(slider_crank_inertia, slider_crank_potential, crank_run.times)
    assert torque == pytest.approx(expected, abs=1e-6 * np.abs(expected).max())
    assert np.array_equal(torque, crank_run.reaction("motor").moment)
    assert crank_run.reaction("shaft").drive is None


def test_angles_of_a_slider_crank(crank_run: lf.Result) -> None:
    """Of the crank, of the rod, and of one relative to the other."""
    theta = motion(crank_run.times)[0]
    assert crank_run.angle("crank") == pytest.approx(theta, abs=1e-8)
    assert crank_run.angle("rod") == pytest.approx(places(theta)[0], abs=1e-8)
    assert crank_run.angle("rod", relative_to="crank") == pytest.approx(places(theta)[0] - theta, abs=1e-8)
    assert crank_run.angle("slider") == pytest.approx(np.zeros_like(theta), abs=1e-8)


def test_axes_of_bodies(crank_run: lf.Result) -> None:
    """The force on the end of a rod that is a pendulum is turned by its angle, and no other number changes."""
    world, rod = crank_run.reaction("wrist"), crank_run.reaction("wrist", axes="body")
    lean = crank_run.angle("rod")
    along = np.cos(lean) * world.force[:, 0] + np.sin(lean) * world.force[:, 1]
    across = -np.sin(lean) * world.force[:, 0] + np.cos(lean) * world.force[:, 1]
    assert rod.force == pytest.approx(np.column_stack([along, across]), abs=1e-9)
    assert (world.axes, rod.axes) == ("world", "rod")
    assert np.array_equal(world.largest_force, rod.largest_force)
    named = crank_run.reaction("wrist", axes="rod")
    assert np.array_equal(named.force, rod.force)
    slider = crank_run.reaction("wrist", axes="slider")
    assert slider.force == pytest.approx(world.force, abs=1e-6)


@pytest.mark.parametrize("stepper", [lf.MoreauJean(1e-3), lf.GeneralizedAlpha(1e-3)], ids=lambda s: type(s).__name__)
def test_a_pendulum_in_its_own_axes(stepper: Any) -> None:
    """Along the rod: m (g cos a + l spin^2), the mean of a millisecond at the mean angle; across: m g sin a / 4.

    A rod of length 2 l has the inertia m l^2 / 3 about its middle, so that its spin changes by -3 g sin a / (4 l).
    """
    m, half = 2.0, 0.4
    scene = lf.Scene(gravity=(0, -G))
    place = (half * math.sin(1.0), -half * math.cos(1.0))
    rod = scene.add(lf.RigidBody(mass=m, inertia=m * half**2 / 3.0), "rod", position=place, angle=1.0)
    scene.join(lf.Revolute(rod.at(0, half), scene.ground.at(0, 0), name="hinge"))
    result = lf.simulate(scene, 0.5, stepper, progress=False)
    force = result.reaction("hinge", axes="body").force[1:]
    angle = 0.5 * (result.angle("rod")[1:] + result.angle("rod")[:-1])
    spin = 0.5 * (result.u[1:, 2] + result.u[:-1, 2])
    along, across = m * (G * np.cos(angle) + half * spin**2), 0.25 * m * G * np.sin(angle)
    assert force == pytest.approx(np.column_stack([across, along]), abs=1e-4 * m * G)


LIFT, RADIUS, FOLLOWER, SPRING = 0.02, 0.06, 0.7, 400.0


def cam() -> lf.Scene:
    """An eccentric disc, driven, lifts a flat follower by LIFT sin(angle) against its weight and a spring."""
    scene = lf.Scene(gravity=(0, -G))
    speed = SWING * OMEGA
    disc = scene.add(
        lf.Disc(RADIUS, mass=1.2), "cam", position=(LIFT, 0.0), velocity=(0.0, LIFT * speed), angular_velocity=speed
    )
    face = lf.Box(0.4, 0.02, mass=FOLLOWER)
    follower = scene.add(face, "follower", position=(0.0, RADIUS + 0.01), velocity=(0.0, LIFT * speed))
    axle = scene.ground.at(0.0, 0.0)
    scene.join(lf.Revolute(disc.at(-LIFT, 0.0), axle, name="axle"))
    scene.join(lf.DrivenAngle(disc.at(-LIFT, 0.0), axle, lf.Harmonic(SWING, OMEGA), name="motor"))
    scene.join(lf.Prismatic(follower.at(0, 0), scene.ground.at(0.0, RADIUS + 0.01), axis=(0.0, 1.0), name="guide"))
    free = 1.0 - RADIUS - 0.01 + LIFT  # compressed by LIFT where the follower is in the middle
    scene.load(lf.Spring(follower.at(0, 0), scene.ground.at(0.0, 1.0), stiffness=SPRING, length=free))
    scene.contact(disc.surface(), follower.surface(), name="face")
    return scene


def test_torque_of_a_cam() -> None:
    """Frictionless: all that the motor puts in goes into the cam and the follower."""
    result = lf.simulate(cam(), 1.2, lf.EventDriven(), record=0.01, progress=False)
    torque = result.reaction("motor").drive
    assert torque is not None

    def inertia(theta: Any) -> Any:
        return 1.2 * (0.5 * RADIUS**2 + LIFT**2) + FOLLOWER * (LIFT * np.cos(theta)) ** 2

    def potential(theta: Any) -> Any:
        lift = LIFT * np.sin(theta)
        return (1.2 + FOLLOWER) * G * lift + 0.5 * SPRING * (LIFT + lift) ** 2

    expected = balance(inertia, potential, result.times)
    assert torque == pytest.approx(expected, abs=1e-6 * np.abs(expected).max())
    (touch,) = result.contact("face").windows()
    assert (touch.begin, touch.end, touch.from_start, touch.to_end) == (0.0, 1.2, True, True)
    theta, speed, acceleration = motion(result.times)
    lift = LIFT * (acceleration * np.cos(theta) - speed**2 * np.sin(theta))
    pressure = FOLLOWER * (G + lift) + SPRING * LIFT * (1.0 + np.sin(theta))
    assert pressure.min() > 0.0
    assert result.contact("face").force[:, 0] == pytest.approx(pressure, abs=1e-6 * pressure.max())
    assert touch.peak_force == pytest.approx(pressure.max(), rel=1e-6)


def pushed(joint: str) -> lf.Scene:
    """A mass on a guide, moved by a drive to and fro."""
    scene = lf.Scene(gravity=(0, -G))
    slope = 0.5
    way = (math.cos(slope), math.sin(slope))
    speed = 0.1 * OMEGA
    mass = scene.add(lf.RigidBody(mass=3.0, inertia=0.1), "mass", position=way, velocity=np.multiply(speed, way))
    ground = scene.ground.at(0, 0)
    scene.join(lf.Prismatic(mass.at(0, 0), ground, axis=way, angle=0.0, name="guide"))
    motion = lf.Harmonic(0.1, OMEGA, mean=1.0)
    if joint == "driven":
        scene.join(lf.DrivenDisplacement(mass.at(0, 0), ground, motion, way, name="push"))
    elif joint == "reversed":
        back = (-way[0], -way[1])
        scene.join(lf.DrivenDisplacement(ground, mass.at(0, 0), motion, back, name="push"))
    else:
        scene.join(lf.Distance(mass.at(0, 0), ground, motion, name="push"))
    return scene


@pytest.mark.parametrize("joint", ["driven", "reversed", "distance"])
def test_force_of_a_linear_drive(joint: str) -> None:
    """Weight down the slope and inertia, positive where it pushes the coordinate up, and of both signs here."""
    for stepper, rough in ((lf.EventDriven(), 1e-6), (lf.MoreauJean(1e-3), 2e-3)):
        result = lf.simulate(pushed(joint), 1.0, stepper, record=1e-3, progress=False)
        force = result.reaction("push").drive
        assert force is not None
        times = result.times if rough < 1e-4 else result.times - 5e-4
        expected = 3.0 * (G * math.sin(0.5) - 0.1 * OMEGA**2 * np.sin(OMEGA * times))
        assert force[1:] == pytest.approx(expected[1:], abs=rough * np.abs(expected).max())


@pytest.mark.parametrize("axes", ["World", "", None, 3, ("world",), "ground"])
def test_unknown_axes(crank_run: lf.Result, axes: Any) -> None:
    with pytest.raises(lf.ModelError, match=r"axes: no frame .*'world', 'body', 'crank'"):
        crank_run.reaction("motor", axes=axes)


@pytest.mark.parametrize("given", [("arm", None), (3, None), ("crank", "arm"), ("crank", 0)])
def test_angles_of_bodies_that_are_not_there(crank_run: lf.Result, given: Any) -> None:
    with pytest.raises(lf.ModelError, match=r"(body|relative_to): no body .*'crank'"):
        crank_run.angle(*given)
