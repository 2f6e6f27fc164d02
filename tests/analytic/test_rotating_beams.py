"""Rotating beams: frequencies, and the spin-up of Kane, Ryan & Banerjee with and without geometric stiffening."""

from __future__ import annotations

import math

import numpy as np
import pytest

from lcpflex import Beam, DrivenAngle, GeneralizedAlpha, Result, Revolute, Scene, Table, simulate
from lcpflex.bodies import Body, MaterialPoint
from lcpflex.bodies.reduction.stiffening import Stiffening
from lcpflex.studies.vibrations import small_vibrations

# out of plane, E I = rho A = L = 1, no hub: spin -> eta
FREQUENCIES = {
    0.0: (3.5160, 22.0345, 61.6972),
    2.0: (4.1373, 22.6149, 62.2732),
    4.0: (5.5850, 24.2734, 63.9668),
    6.0: (7.3604, 26.8091, 66.6840),
}
RAMP, SPIN, LENGTH = 15.0, 6.0, 10.0  # [s], [rad/s], [m]
BENDING, STRETCHING, LINE_MASS = 1.4e4, 2.8e7, 1.2  # [N m^2], [N], [kg/m]


def held_and_driven(body: Body, angle: Table, spin: float = 0.0) -> Scene:
    scene = Scene(gravity=(0, 0))
    beam = scene.add(body, name="beam", angular_velocity=spin)
    scene.join(Revolute(beam.point("left"), scene.ground.at(0, 0)))
    scene.join(DrivenAngle(beam.point("left"), scene.ground.at(0, 0), angle))
    return scene


@pytest.mark.parametrize("spin", FREQUENCIES)
def test_frequencies_of_a_rotating_cantilever(spin):
    """In plane sqrt(eta^2 - Omega^2), seen from the turning axes."""
    thickness = 0.01
    beam = Beam(1.0, 1.0, thickness, 1.0 / thickness, 12.0 / thickness**3, elements=12, axial=False)
    scene = held_and_driven(beam.reduce(None, stiffening=Stiffening(held="left")), Table((0.0, 1.0), (0.0, spin)), spin)
    found = small_vibrations(scene, spin)
    assert found.frequencies[:3] == pytest.approx(np.sqrt(np.square(FREQUENCIES[spin]) - spin**2), rel=1e-3)
    assert found.growth < 1e-9 * found.frequencies[-1]


def ramp(t: np.ndarray, spin: float) -> np.ndarray:
    """Angle of the hub: omega = spin (t / T - sin(2 pi t / T) / (2 pi)) up to T, spin from then on."""
    phase = 2.0 * math.pi * t / RAMP
    rising = spin * (0.5 * t**2 / RAMP + RAMP / (4.0 * math.pi**2) * (np.cos(phase) - 1.0))
    return np.where(t < RAMP, rising, spin * (t - 0.5 * RAMP))


def spun_up(body: Body, spin: float = SPIN, end: float = 20.0) -> tuple[Result, np.ndarray, np.ndarray]:
    """The run, deflection of the tip from the line of the hub and its stretch [m]."""
    knots = np.linspace(0.0, 25.0, 501)
    scene = held_and_driven(body, Table(knots, ramp(knots, spin)))
    result = simulate(scene, end, GeneralizedAlpha(step=5e-3), record=0.02, project=True)
    angle = ramp(result.times, spin)
    along, across = np.cos(angle), np.sin(angle)
    x, y = result.point("beam", "right").T
    return result, along * y - across * x, along * x + across * y - LENGTH


def kanes_beam() -> Beam:
    thickness = math.sqrt(12.0 * BENDING / STRETCHING)
    return Beam(LENGTH, 1.0, thickness, LINE_MASS / thickness, STRETCHING / thickness, elements=10)


def test_spin_up_with_stiffening():
    result, lag, stretch = spun_up(kanes_beam().reduce(None, stiffening=Stiffening(held="left")))
    assert result.complete
    assert lag.min() == pytest.approx(-0.5744, rel=2e-3)
    assert result.times[lag.argmin()] == pytest.approx(6.76, abs=0.05)
    steady = result.times > RAMP + 1.0
    assert stretch[steady].mean() == pytest.approx(5.14e-4, rel=2e-3)
    assert np.abs(lag[steady]).max() < 0.01


def test_spin_up_without_stiffening_is_wrong():
    """The frame of Buckens turns with the mean of the beam and so has a part of the stiffening, too little of it."""
    _, lag, _ = spun_up(kanes_beam().reduce(None))
    assert lag.min() < -0.66


def cantilever(stiffened: bool) -> Body:
    """The beam in the first mode of a cantilever: its frame is tangential to it at the hub, as in textbooks.

    More modes would imitate rigid rotation, and leave the frame itself hardly any inertia.
    """
    x, weight = np.polynomial.legendre.leggauss(60)
    x, weight = 0.5 * LENGTH * (x + 1.0), 0.5 * LENGTH * LINE_MASS * weight
    root = 1.8751040687119611 / LENGTH
    shape, slope = cantilever_mode(root, x)
    scale = 1.0 / math.sqrt(weight @ shape**2)
    shape, slope = shape * scale, slope * scale
    tip, tip_slope = cantilever_mode(root, np.array([LENGTH]))
    tension = 0.5 * (LENGTH**2 - x**2)
    still = np.zeros((1, 2))
    across = np.array([[0.0, scale * tip[0]]])
    return Body(
        mass=LINE_MASS * LENGTH,
        inertia=LINE_MASS * LENGTH**3 / 3.0,
        moment=np.array([0.5 * LINE_MASS * LENGTH**2, 0.0]),
        S=np.array([[0.0, weight @ shape]]),
        a=np.zeros(1),
        c=np.array([(weight * x) @ shape]),
        stiffness=np.array([root**4 * BENDING / LINE_MASS]),
        damping=np.zeros(1),
        coupling=None,
        cross_damping=None,
        points={
            "left": MaterialPoint(np.zeros(2), still, np.zeros(1)),
            "right": MaterialPoint(np.array([LENGTH, 0.0]), across, scale * tip_slope),
        },
        surfaces={},
        locate=lambda x, y: MaterialPoint(np.array([x, y]), still, np.zeros(1)),
        geometric=np.array([[weight @ (tension * slope**2)]]) if stiffened else None,
    )


def cantilever_mode(root: float, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """cosh - cos - s (sinh - sin) of b x, and its slope."""
    end, bx = root * LENGTH, root * x
    s = (math.cosh(end) + math.cos(end)) / (math.sinh(end) + math.sin(end))
    shape = np.cosh(bx) - np.cos(bx) - s * (np.sinh(bx) - np.sin(bx))
    return shape, root * (np.sinh(bx) + np.sin(bx) - s * (np.cosh(bx) - np.cos(bx)))


def test_tangential_frame_gives_the_same_motion():
    """Stiffening is objective: another frame and one mode of another kind, nearly the same lag."""
    _, lag, _ = spun_up(cantilever(stiffened=True))
    assert lag.min() == pytest.approx(-0.5744, rel=1e-2)


def test_tangential_frame_without_stiffening_diverges():
    """Above the first frequency, 3.798 rad/s, the textbook's linear beam has no equilibrium."""
    assert math.sqrt(cantilever(stiffened=False).stiffness[0]) == pytest.approx(3.798, rel=1e-3)
    _, lag, _ = spun_up(cantilever(stiffened=False), end=12.0)
    assert np.abs(lag).max() > LENGTH
