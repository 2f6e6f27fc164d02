"""Bodies that slide and spin on more contacts than are needed: their motion is that of contacts of equal compliance.

The reference integrates the level motion of a rigid body whose feet carry f = w (a + b x + c y), as compliant feet do
however stiff they are, with Coulomb friction against the slip of each; feet that would pull carry nothing.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

import lcpflex as lf

STEPPERS = [lf.EventDriven(), lf.MoreauJean(step=5e-4), lf.GeneralizedAlpha(step=1e-3)]
NAMES = ["event-driven", "Moreau-Jean", "generalised-alpha"]
SMOOTH = 1e-5  # [m/s] of slip below which the friction of the reference grows with it
IRREGULAR = [(0.1, 0.0), (0.03, 0.09), (-0.08, 0.05), (-0.06, -0.07), (0.05, -0.08), (0.0, -0.1)]


def ring(k: int) -> list[tuple[float, float]]:
    return [(0.1 * math.cos(0.2 + 2 * math.pi * i / k), 0.1 * math.sin(0.2 + 2 * math.pi * i / k)) for i in range(k)]


def shares(rows: NDArray[np.float64], B: NDArray[np.float64], load: NDArray[np.float64]) -> NDArray[np.float64]:
    carries = np.ones(len(B), dtype=bool)
    for _ in range(len(B)):
        f = carries * (B @ np.linalg.solve(rows @ (carries[:, None] * B), load))
        if (f >= -1e-12 * load.max()).all():
            break
        carries &= f > 0.0
    return f


def reference(
    feet: Any, mu: float, height: float, mass: float, spin_inertia: float, velocity: Any, spin: float, duration: float
) -> NDArray[np.float64]:
    """Angle, x and y after the duration."""
    at = np.asarray(feet, dtype=float)

    def rate(_: float, state: NDArray[np.float64]) -> NDArray[np.float64]:
        c, s = math.cos(state[2]), math.sin(state[2])
        r = at @ np.array([[c, s], [-s, c]])
        slip = state[3:5] + state[5] * np.c_[-r[:, 1], r[:, 0]]
        pull = -mu * slip / np.sqrt((slip * slip).sum(axis=1) + SMOOTH**2)[:, None]
        B = np.c_[np.ones(len(r)), r]
        rows = np.stack([np.ones(len(r)), r[:, 1] + height * pull[:, 1], -r[:, 0] - height * pull[:, 0]])
        F = shares(rows, B, np.array([mass * 9.81, 0.0, 0.0]))[:, None] * pull
        torque = (r[:, 0] * F[:, 1] - r[:, 1] * F[:, 0]).sum()
        return np.array([*state[3:], *(F.sum(axis=0) / mass), torque / spin_inertia])

    start = [0.0, 0.0, 0.0, *velocity, spin]
    found = solve_ivp(rate, (0.0, duration), start, method="Radau", rtol=1e-7, atol=1e-9)
    return np.asarray(found.y[[2, 0, 1], -1])


def slid(scene: lf.SpatialScene, stepper: Any, duration: float) -> tuple[NDArray[np.float64], lf.Result]:
    result = lf.simulate(scene, duration, stepper, progress=False)
    turned = result.orientation("b")[-1].as_rotvec()[2]
    return np.array([turned, result.q[-1, 0], result.q[-1, 1]]), result


def box_scene(size: Any, mass: float, mu: float, velocity: Any, spin: float, unit: float = 1.0) -> lf.SpatialScene:
    scene = lf.SpatialScene(gravity=(0, 0, -9.81 * unit))
    body = scene.add(
        lf.Cuboid(*(unit * np.asarray(size)), mass=mass),
        name="b",
        position=(0, 0, unit * size[2] / 2),
        velocity=(unit * velocity[0], unit * velocity[1], 0),
        angular_velocity=(0, 0, spin),
    )
    scene.contact(body.surface(), scene.ground.plane((0, 0, 0), (0, 0, 1)), friction=mu)
    return scene


def feet_scene(feet: Any, height: float = 0.05, mass: float = 1.0, radius: float = 0.0) -> lf.SpatialScene:
    scene = lf.SpatialScene(gravity=(0, 0, -9.81))
    disc = lf.SpatialRigidBody(mass, (0.01 * mass, 0.01 * mass, 0.015 * mass))
    body = scene.add(disc, name="b", position=(0, 0, height), velocity=(1.0, 0, 0), angular_velocity=(0, 0, 8.0))
    floor = scene.ground.plane((0, 0, 0), (0, 0, 1))
    for x, y in feet:
        foot = body.sphere((x, y, radius - height), radius) if radius > 0.0 else body.node((x, y, -height))
        scene.contact(foot, floor, friction=0.3)
    return scene


@pytest.mark.parametrize("stepper", STEPPERS, ids=NAMES)
def test_a_box_slides_and_spins_as_on_equal_compliance(stepper: Any) -> None:
    found, result = slid(box_scene((0.2, 0.1, 0.1), 1.0, 0.3, (1.0, 0.0), 8.0), stepper, 0.5)
    assert found == pytest.approx([1.05850, 0.19254, -0.01372], rel=2e-3)  # the reference, at rest from .3733 s on
    assert any("share a load" in note for note in result.notes)
    assert not any("share a load" in warning for warning in result.warnings)
    assert result.energies.kinetic[-1] <= 1e-12 * result.energies.kinetic[0]


@pytest.mark.parametrize("stepper", STEPPERS, ids=NAMES)
@pytest.mark.parametrize(
    ("size", "mass", "mu", "velocity", "spin", "unit"),
    [
        ((0.2, 0.3, 0.1), 5e3, 0.7, (0.5, 0.8), -12.0, 1.0),
        ((0.2, 0.1, 0.3), 1e-3, 0.3, (0.6, 0.3), 8.0, 1e3),
    ],
)
def test_boxes_of_other_sizes_and_units(
    stepper: Any, size: Any, mass: float, mu: float, velocity: Any, spin: float, unit: float
) -> None:
    corners = [(x * size[0] / 2, y * size[1] / 2) for x in (1, -1) for y in (1, -1)]
    inertia = mass * (size[0] ** 2 + size[1] ** 2) / 12
    expected = reference(corners, mu, size[2] / 2, mass, inertia, velocity, spin, 0.15)
    found, _ = slid(box_scene(size, mass, mu, velocity, spin, unit), stepper, 0.15)
    assert found / (1.0, unit, unit) == pytest.approx(expected, rel=2e-3, abs=1e-4)


@pytest.mark.parametrize("stepper", STEPPERS, ids=NAMES)
def test_a_corner_without_a_share_gets_one_again(stepper: Any) -> None:
    """Of a tall box, corners that a load leaves carry again a quarter of a turn later."""
    corners = [(x * 0.05, y * 0.05) for x in (1, -1) for y in (1, -1)]
    expected = reference(corners, 0.3, 0.15, 1.0, 0.02 / 12, (1.0, 0.4), 15.0, 0.4)
    found, _ = slid(box_scene((0.1, 0.1, 0.3), 1.0, 0.3, (1.0, 0.4), 15.0), stepper, 0.4)
    assert found == pytest.approx(expected, rel=2e-3, abs=2e-4)


@pytest.mark.parametrize("stepper", STEPPERS, ids=NAMES)
@pytest.mark.parametrize("feet", [ring(3), ring(4), ring(6), IRREGULAR[:5], IRREGULAR[5::-1]], ids=len)
def test_feet_slide_and_spin(stepper: Any, feet: Any) -> None:
    expected = reference(feet, 0.3, 0.05, 1.0, 0.015, (1.0, 0.0), 8.0, 0.3)
    found, result = slid(feet_scene(feet), stepper, 0.3)
    assert found == pytest.approx(expected, rel=1e-3, abs=2e-4)
    assert any("share a load" in note for note in result.notes) == (len(feet) > 3)


@pytest.mark.parametrize("stepper", STEPPERS, ids=NAMES)
def test_round_feet_do_as_pointed_ones_in_any_order(stepper: Any) -> None:
    first, _ = slid(feet_scene(IRREGULAR), stepper, 0.2)
    other, _ = slid(feet_scene(np.roll(IRREGULAR, 2, axis=0), mass=300.0, radius=0.01), stepper, 0.2)
    assert other == pytest.approx(first, rel=1e-5)


@pytest.mark.parametrize("stepper", STEPPERS, ids=NAMES)
def test_a_box_that_does_not_spin_needs_no_note(stepper: Any) -> None:
    """All corners slide in one direction: friction is the same by any shares."""
    _, result = slid(box_scene((0.2, 0.1, 0.1), 1.0, 0.3, (1.0, 0.3), 0.0), stepper, 0.2)
    assert not any("share a load" in note for note in result.notes)


def test_feet_of_a_body_with_a_joint() -> None:
    """Joints are condensed into the problem of the contacts; the motion is that of the two bodies as one."""
    inertia = 0.015 + 0.2 * 0.0004
    expected = reference(ring(4), 0.3, 0.05, 1.2, inertia, (1.0, 0.0), 8.0, 0.2)
    for stepper in STEPPERS:
        scene = feet_scene(ring(4))
        body = scene.body("b")
        load = scene.add(
            lf.SpatialRigidBody(0.2, (8e-5, 8e-5, 8e-5)),
            position=(0, 0, 0.05),
            velocity=(1.0, 0, 0),
            angular_velocity=(0, 0, 8.0),
        )
        scene.join(lf.Weld(body.point("center"), load.point("center")))
        found, _ = slid(scene, stepper, 0.2)
        assert found == pytest.approx(expected, rel=1e-3, abs=2e-4)
