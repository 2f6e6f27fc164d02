"""Sticking of bodies that share their load among more contacts than are determined, and when it ends (g = 9.81 m/s^2).

The conic problem decides: a body slips at the least load that no forces inside Coulomb's cones can hold.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from scipy.optimize import linprog

import lcpflex as lf

G = 9.81
MASS, MU = 2.0, 0.3
GRIP = MU * MASS * G
SIZE = (0.4, 0.3, 0.2)


def box(
    gravity: tuple[float, float, float] = (0.0, 0.0, -G), unit: float = 1.0
) -> tuple[lf.SpatialScene, lf.SpatialPoint]:
    """A box that stands with four corners on the plane z = 0, and its mass centre."""
    scene = lf.SpatialScene(gravity=(gravity[0] * unit, gravity[1] * unit, gravity[2] * unit))
    size = [unit * side for side in SIZE]
    body = scene.add(lf.Cuboid(*size, mass=MASS), position=(0.0, 0.0, 0.5 * size[2]))
    scene.contact(body.surface(), scene.ground.plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0)), friction=MU)
    return scene, body.at(0.0, 0.0, 0.0)


def onset(scene: lf.SpatialScene, until: float) -> float:
    """Time of the only event, at which the box begins to slip [s]."""
    (event,) = lf.simulate(scene, until, lf.EventDriven(), record=until).events
    assert event.kind == "slip"
    return float(event.time)


@pytest.mark.parametrize("unit", [1.0, 1e3, 1e-3])
def test_a_box_pushed_at_its_mass_centre_slips_at_mu_times_its_weight(unit: float) -> None:
    """A force 5 t N in metres, millimetres and kilometres: corners behind carry less."""
    scene, centre = box(unit=unit)
    scene.load(lf.Force(centre, (lambda t: 4.0 * unit * t, lambda t: 3.0 * unit * t, 0.0)))
    late = 0.01
    time = GRIP / 5.0
    result = lf.simulate(scene, time + late, lf.EventDriven(), record=time + late)
    assert [event.kind for event in result.events] == ["slip"]
    assert result.events[0].time == pytest.approx(time, rel=5e-9)
    speed = 0.5 * 5.0 * late**2 / MASS * unit
    assert np.allclose(result.u[-1, :2], (0.8 * speed, 0.6 * speed), rtol=1e-6, atol=0.0)


@pytest.mark.parametrize("height", [-0.1, 0.1])
def test_a_box_pushed_below_and_above_its_mass_centre_slips_at_the_same_load(height: float) -> None:
    """What each corner carries depends on the height of the force; the limit does not."""
    time = GRIP / 4.0
    assert onset(pushed(0.0, height), 1.0001 * time) == pytest.approx(time, rel=5e-9)


def pushed(y: float, z: float) -> lf.SpatialScene:
    """A force 4 t along x, at (0, y, z) from the mass centre."""
    scene = lf.SpatialScene()
    body = scene.add(lf.Cuboid(*SIZE, mass=MASS), position=(0.0, 0.0, 0.5 * SIZE[2]))
    scene.contact(body.surface(), scene.ground.plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0)), friction=MU)
    scene.load(lf.Force(body.at(0.0, y, z), (lambda t: 4.0 * t, 0.0, 0.0)))
    return scene


def least_load(y: float, facets: int = 1440) -> float:
    """The largest force along x at (0, y) on the ground that cones with so many facets can hold."""
    angles = 2.0 * math.pi * (np.arange(facets) + 0.5) / facets
    corners = [(0.5 * SIZE[0] * i, 0.5 * SIZE[1] * j) for i in (-1, 1) for j in (-1, 1)]
    balance = np.zeros((6, 13))  # forces along z, x, y; moments about x, y, z
    cones = np.zeros((4 * facets, 13))
    for c, (a, b) in enumerate(corners):
        n, s, t = 3 * c, 3 * c + 1, 3 * c + 2
        balance[0, n] = balance[1, s] = balance[2, t] = 1.0
        balance[3, n], balance[4, n], balance[5, s], balance[5, t] = b, -a, -b, a
        rows = slice(facets * c, facets * (c + 1))
        cones[rows, n], cones[rows, s], cones[rows, t] = -MU, np.cos(angles), np.sin(angles)
    balance[1, 12], balance[5, 12] = 1.0, -y
    load = np.array([MASS * G, 0.0, 0.0, 0.0, 0.0, 0.0])
    found = linprog(-np.eye(13)[12], cones, np.zeros(4 * facets), balance, load, [(None, None)] * 13)
    return float(found.x[12])


def test_a_box_pushed_beside_its_mass_centre_slips_where_no_forces_hold_it() -> None:
    """Force and yaw together; the linear programme has cones of 1440 facets, which are wider by 1 / cos(pi / 1440)."""
    load = least_load(0.1) * math.cos(math.pi / 1440)
    assert load < 0.95 * GRIP
    assert onset(pushed(0.1, -0.1), 1.00005 * load / 4.0) == pytest.approx(load / 4.0, rel=5e-7)


def test_a_torque_about_the_normal_turns_a_box_at_mu_times_weight_times_arm() -> None:
    """The four corners are equally far from the centre."""
    scene, centre = box()
    scene.load(lf.Torque(centre, (0.0, 0.0, lambda t: t)))
    limit = GRIP * 0.5 * math.hypot(SIZE[0], SIZE[1])
    assert onset(scene, 1.001 * limit) == pytest.approx(limit, rel=5e-9)


def test_a_slope_that_grows_steeper_lets_a_box_go_at_the_friction_angle() -> None:
    """The weight turns by .2 rad/s."""
    scene, centre = box((0.0, 0.0, 0.0))
    weight: Callable[[float], float] = lambda t: -MASS * G * math.cos(0.2 * t)  # noqa: E731
    scene.load(lf.Force(centre, (lambda t: MASS * G * math.sin(0.2 * t), 0.0, weight)))
    limit = math.atan(MU) / 0.2
    assert onset(scene, 1.0005 * limit) == pytest.approx(limit, rel=5e-9)


@pytest.mark.parametrize("part", [0.5, 0.9, 0.999])
def test_a_box_below_the_friction_angle_does_not_drift_in_ten_seconds(part: float) -> None:
    """Position and attitude change by rounding only."""
    slope = math.atan(part * MU)
    scene, _ = box((G * math.sin(slope), 0.0, -G * math.cos(slope)))
    result = lf.simulate(scene, 10.0, lf.EventDriven(), record=10.0)
    assert not result.events
    assert np.abs(result.q[-1] - result.q[0]).max() < 1e-12


def test_a_force_that_swings_below_the_limit_does_not_move_a_box() -> None:
    """19 of 20 parts of the limit, to and fro."""
    scene, centre = box()
    scene.load(lf.Force(centre, (lambda t: 0.95 * GRIP * math.sin(20.0 * t), 0.0, 0.0)))
    result = lf.simulate(scene, 1.0, lf.EventDriven(), record=1.0)
    assert not result.events
    assert np.abs(result.q[-1] - result.q[0]).max() < 1e-12
