"""What collisions of two free bodies in space do to their momenta.

The linear one is kept by the rows of contacts, which are equal and opposite. So is the angular one at the instant at
which a contact is posed; a scheme that strikes at one instant of a step and moves on by the velocities of both its ends
leaves terms of first order in the step h. Where a strike changes omega by D, in body axes, the midpoint rule leaves

    h/2 sum_b A_b (D x J D + D x J omega + omega x J D)_b + g n x P_T,     g: gap in the middle of the step,

of a rigid body: the place of its frame counts exactly. The massless boundary carries its momenta on.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import lcpflex as lf
from tests.rates import assert_rate

PLASTIC: dict[str, Any] = {"density": 1200.0, "youngs_modulus": 2e9, "poissons_ratio": 0.35}
TURN = Rotation.from_rotvec([0.3, -0.2, 0.5])
DRIFT = np.array([0.1, 0.2, 0.3])  # [m/s] of both
SPEED = TURN.apply([0.3, 0.1, -3.0])  # [m/s] of the upper one towards the lower one
SPINS = [np.array([5.0, -8.0, 3.0]), np.array([-4.0, 6.0, 2.0])]  # [rad/s]
ARM = 0.02  # [m] of the impulse about the mass centres
SIZES, RADIUS = (0.06, 0.04, 0.02), 0.015
STEPPERS: dict[str, Callable[[float], Any]] = {
    "Moreau-Jean": lf.MoreauJean,
    "alpha": lambda h: lf.GeneralizedAlpha(h, rho_inf=0.8),
}


def thrown(lower: Any, upper: Any, gap: float) -> tuple[lf.SpatialScene, Any, Any]:
    """Two spinning bodies, the upper one over the face z = 0.01 of the lower one, beside its middle."""
    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    a = scene.add(lower, "lower", orientation=TURN, velocity=DRIFT, angular_velocity=SPINS[0])
    place = TURN.apply([0.012, 0.006, 0.5 * SIZES[2] + RADIUS + gap])
    turned = TURN * Rotation.from_rotvec([0.01, 0.02, 0.3])
    b = scene.add(upper, "upper", place, turned, velocity=SPEED + DRIFT, angular_velocity=SPINS[1])
    return scene, a, b


@pytest.mark.parametrize("friction", [0.0, 0.4])
def test_what_a_strike_leaves_of_angular_momentum(friction: float) -> None:
    h = 5e-6
    plate, ball = lf.Cuboid(*SIZES, density=1200.0), lf.Sphere(RADIUS, mass=0.03)
    scene, a, b = thrown(plate, ball, 4e-4)
    scene.contact(b.surface(), a.plane((0.0, 0.0, 0.01), (0.0, 0.0, 1.0)), friction=friction, name="hit")
    result = lf.simulate(scene, 3e-4, lf.MoreauJean(h), record=0.0)
    k = int(np.argmax(result.impulse[:, 0, 0] > 0.0)) - 1
    frames, u, change = result.q[k].reshape(2, 7), result.u[k].reshape(2, 6), np.diff(result.u[k : k + 2], axis=0)
    jump = change.reshape(2, 6)
    left = np.zeros(3)
    for frame, rates, D, J in zip(frames, u[:, 3:], jump[:, 3:], (plate.inertia, ball.inertia), strict=True):
        turn = Rotation.from_quat(frame[3:], scalar_first=True)
        left += 0.5 * h * turn.apply(np.cross(D, J @ D) + np.cross(D, J @ rates) + np.cross(rates, J @ D))
    middle = Rotation.from_quat(frames[0, 3:], scalar_first=True) * Rotation.from_rotvec(0.5 * h * u[0, 3:])
    n, across = middle.apply([0.0, 0.0, 1.0]), np.diff(frames[:, :3] + 0.5 * h * u[:, :3], axis=0)[0]
    gap = across @ n - 0.5 * SIZES[2] - RADIUS
    left += gap * np.cross(n, ball.mass * jump[1, :3])
    found = np.diff(result.momentum().angular[k : k + 2], axis=0)[0]
    np.testing.assert_allclose(found, left, atol=2e-3 * np.abs(left).max())


@cache
def solids() -> tuple[lf.SpatialBody, lf.SpatialBody]:
    lower = lf.Solid.box(SIZES, elements=(3, 2, 1), sets={"face": lambda x, y, z: z > 0.00999}, **PLASTIC)
    cube = (2.0 * RADIUS,) * 3
    upper = lf.Solid.box(cube, elements=(2, 2, 2), sets={"face": lambda x, y, z: z < -0.01499}, **PLASTIC)
    return lower.reduce(8, contact="face", rows="all"), upper.reduce(8, contact="face", rows="all")


def collision(stepper: Any, friction: float, gap: float = 4e-4) -> tuple[lf.Result, float]:
    scene, a, b = thrown(*solids(), gap)
    scene.contact(b.face("face"), a.face("face"), friction=friction, name="hit")
    result = lf.simulate(scene, 1e-3, stepper, record=0.0)
    assert result.force[-1, 0, 0] == 0.0
    return result, float(result.impulse[-1, 0, 0])


def angular_error(stepper: Any, friction: float) -> float:
    """Root of the mean square over gaps at the start, as steps begin anywhere before the strike."""
    errors = []
    for part in (0.0, 0.17, 0.39, 0.71):
        result, impulse = collision(stepper, friction, 4e-4 + 1.3e-4 * part)
        angular = result.momentum().angular
        errors.append(np.abs(angular - angular[0]).max() / (impulse * ARM))
    return float(np.sqrt(np.mean(np.square(errors))))


@pytest.mark.filterwarnings("ignore:mesh. its stiffness:lcpflex.ModelWarning")
@pytest.mark.parametrize("friction", [0.0, 0.4])
def test_momenta_of_two_solids_that_collide(friction: float) -> None:
    """The linear one to rounding by all; the angular one by the massless boundary, when its contact is open again."""
    for make in STEPPERS.values():
        result, impulse = collision(make(5e-6), friction)
        linear = result.momentum().linear
        assert np.abs(linear - linear[0]).max() < 1e-13 * impulse
        angular = result.momentum().angular
        assert np.abs(angular - angular[0]).max() < 3e-4 * ARM * impulse
    result, impulse = collision(lf.MasslessBoundary(step=2.5e-6), friction)
    told = result.momentum()
    assert np.abs(told.linear[-1] - told.linear[0]).max() < 1e-13 * impulse
    assert np.abs(told.angular[-1] - told.angular[0]).max() < 1e-10 * ARM * impulse


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:mesh. its stiffness:lcpflex.ModelWarning")
@pytest.mark.parametrize("friction", [0.0, 0.4])
@pytest.mark.parametrize("name", STEPPERS)
def test_angular_momentum_is_kept_to_the_order_of_impacts(name: str, friction: float) -> None:
    """Order 1 of what strikes within a step, order 2 of the force that follows, which shrinks the larger steps more."""
    steps = 2e-5 / 2.0 ** np.arange(5)
    errors = [angular_error(STEPPERS[name](float(h)), friction) for h in steps]
    assert_rate(steps, errors, 1.0, within=(0.2, 0.7))
    assert errors[-1] < 3e-5
