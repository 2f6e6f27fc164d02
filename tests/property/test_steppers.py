"""What holds for every stepper on any scene: balances of momentum and energy, pushing contacts, Coulomb's cone."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

import lcpflex as lf
from lcpflex.dynamics.mass_matrix import mass_matrix
from tests.property.overlap import deepest

Array = npt.NDArray[np.float64]

GRAVITY = (0.3, -9.81)
WALLS = {"floor": ((0.0, 0.0), (0.0, 1.0)), "left": ((-1.0, 0.0), (1.0, 0.0)), "right": ((1.0, 0.0), (-0.8, 0.6))}
CONTROL = lf.AdaptiveStep(rtol=1e-5, atol=1e-7, shortest=1e-7)
SPRING = lf.Penalty(1e5, damping=0.1, slip_speed=0.05)

# stepper; what is allowed: depth of bodies in each other and in walls [m], unexplained energy (of the largest stored),
# error of angular momentum. Depths and energies are about twice what was measured; the smallest disc has a radius of
# 50 mm. Moreau-Jean lets bodies in by half a step of their speed, penalty springs by what their force needs.
STEPPERS: dict[str, tuple[Any, float, float, float]] = {
    "moreau": (lf.MoreauJean(step=1e-4), 7e-4, 2e-8, 2e-3),
    "moreau long": (lf.MoreauJean(step=5e-3), 3e-2, 1e-5, 1e-1),
    "moreau controlled": (lf.MoreauJean(step=1e-4, adaptive=CONTROL), 6e-5, 1e-9, 1e-4),
    "alpha": (lf.GeneralizedAlpha(step=1e-4), 1e-12, 3e-7, 2e-3),
    "alpha damped": (lf.GeneralizedAlpha(step=1e-3, rho_inf=0.0), 1e-12, 1.5e-5, 2e-2),
    "alpha controlled": (lf.GeneralizedAlpha(step=1e-4, adaptive=CONTROL), 1e-12, 1e-7, 1e-4),
    "events": (lf.EventDriven(), 3e-9, 1e-8, 1e-7),
    "penalty": (lf.Smooth(SPRING), 2e-2, 5e-6, 1e-9),
    "penalty, Verlet": (lf.Smooth(SPRING, integrator=lf.Verlet(2e-5)), 2e-2, 5e-3, 1e-9),
    "penalty, stiff": (lf.Smooth(SPRING, integrator=lf.Stiff()), 2e-2, 1e-5, 1e-6),
}
ROUNDING = 1e-12  # [m] of outlines that touch


def thrown(rng: np.random.Generator, scene: lf.Scene, place: tuple[float, float], speed: tuple[float, float]) -> Any:
    """A disc or a box of random size and mass, spinning."""
    if rng.random() < 0.5:
        body = lf.Disc(radius=rng.uniform(0.05, 0.15), mass=rng.uniform(0.5, 3.0))
    else:
        body = lf.Box(width=rng.uniform(0.1, 0.3), height=rng.uniform(0.1, 0.3), mass=rng.uniform(0.5, 3.0))
    spin = rng.uniform(-5.0, 5.0)
    return scene.add(body, position=place, angle=rng.uniform(-3.0, 3.0), velocity=speed, angular_velocity=spin)


def room(seed: int) -> lf.Scene:
    """Four bodies thrown about between walls, one of which leans, with random friction and restitution."""
    rng = np.random.default_rng(seed)
    scene = lf.Scene(gravity=GRAVITY)
    made = [
        thrown(rng, scene, (0.4 * k - 0.6, rng.uniform(0.22, 0.4)), (rng.uniform(-3, 3), rng.uniform(-3, 0)))
        for k in range(4)
    ]
    law = {"friction": rng.uniform(0.0, 1.0), "restitution": (0.0, 0.5, 0.0)[seed % 3]}
    for name, (point, normal) in WALLS.items():
        plane = scene.ground.half_plane(point, normal)
        for i, body in enumerate(made):
            scene.contact(body.surface(), plane, name=f"{name} {i}", **law)
    for i, body in enumerate(made):
        for k in range(i):
            scene.contact(body.surface(), made[k].surface(), name=f"{i} {k}", **law)
    return scene


def swarm(seed: int) -> lf.Scene:
    """Six bodies fly at each other in empty space."""
    rng = np.random.default_rng(seed)
    scene = lf.Scene(gravity=(0.0, 0.0))
    for k in range(6):
        angle = math.pi / 3.0 * k
        place = (0.5 * math.cos(angle) + 3.0, 0.5 * math.sin(angle))
        speed = rng.uniform(1.0, 2.0)
        thrown(rng, scene, place, (-speed * math.cos(angle) + 0.2, -speed * math.sin(angle)))
    scene.contact_all(friction=rng.uniform(0.1, 1.0), restitution=(0.0, 0.5, 0.0)[seed % 3])
    return scene


def momenta(result: lf.Result) -> Array:
    """Linear momentum and angular momentum about the origin at each instant, (m, 3), of bodies with central frames."""
    assert result.compiled is not None
    model = result.compiled.model
    out = np.zeros((len(result.times), 3))
    for k, (q, u) in enumerate(zip(result.q, result.u, strict=True)):
        p = mass_matrix(model, q) @ u
        for d in model.bodies.dof[:-1]:
            out[k] += (p[d], p[d + 1], p[d + 2] + q[d] * p[d + 1] - q[d + 1] * p[d])
    return out


def from_walls(result: lf.Result) -> Array:
    """Impulse of gravity and walls since the start, (m, 2) [N s]."""
    assert result.compiled is not None
    given = np.outer(result.times, GRAVITY) * result.compiled.model.bodies.mass.sum()
    for c, name in enumerate(result.contact_names):
        if (wall := name.split()[0]) in WALLS:
            x, y = WALLS[wall][1]
            given += result.impulse[:, c] @ np.array([(x, y), (y, -x)])
    return given


def check_depth(result: lf.Result, walls: bool, allowed: float) -> None:
    """No body lies deeper in another or in a wall than allowed, by an independent measure; the result's own agrees."""
    assert result.compiled is not None
    planes = [("plane", point, normal) for point, normal in WALLS.values()] if walls else []
    count = len(result.compiled.layout.bodies)
    rows = np.arange(len(result.times))
    depth = deepest(result, planes, [(i, j) for i in range(count) for j in range(i)], rows).max()
    assert depth <= allowed
    assert result.penetration.max() >= depth - ROUNDING  # between stored instants there may have been more


def check_contacts(result: lf.Result, penetration: float) -> None:
    """No pulling, Coulomb's cone at every point, no penetration, impulses that only grow along normals."""
    assert result.compiled is not None
    limit = result.compiled.model.contacts.friction[result.contact_points.contact] * result.contact_points.force[:, 0]
    assert result.contact_points.force.size == 0 or result.contact_points.force[:, 0].min() >= -1e-9
    assert (np.abs(result.contact_points.force[:, 1]) <= limit * (1.0 + 1e-9) + 1e-9).all()
    assert np.diff(result.impulse[:, :, 0], axis=0).min() > -1e-5  # mean of a force that is released within a step
    assert result.penetration.max() < penetration


def check_energy(result: lf.Result, remainder: float) -> None:
    """What is unexplained is small; what contacts create is told."""
    energies = result.energies
    assert energies.relative_remainder < remainder
    grown = (energies.stored - energies.work).max() - (energies.stored - energies.work)[0]
    assert grown < 1e-3 * energies.scale or any("energy" in text for text in result.warnings)


@pytest.mark.parametrize("seed", [0, 1, pytest.param(2, marks=pytest.mark.slow)])
@pytest.mark.parametrize("name", STEPPERS)
def test_bodies_in_a_room(name: str, seed: int) -> None:
    """Change of momentum = impulses of gravity and walls, to rounding: bodies are rigid, and impulses theirs."""
    stepper, penetration, remainder, _ = STEPPERS[name]
    result = lf.simulate(room(seed), 0.30007, stepper, record=1e-3)
    assert result.times[-1] == 0.30007
    p = momenta(result)[:, :2]
    np.testing.assert_allclose(p - p[0], from_walls(result), rtol=0, atol=1e-10)
    assert result.impulse[-1, :, 0].sum() > 1.0
    check_contacts(result, penetration)
    check_depth(result, True, penetration)
    check_energy(result, remainder)


@pytest.mark.parametrize("seed", [0, 1, pytest.param(2, marks=pytest.mark.slow)])
@pytest.mark.parametrize("name", STEPPERS)
def test_bodies_by_themselves(name: str, seed: int) -> None:
    """Linear momentum stays to rounding, angular momentum to the accuracy of the places where contacts act."""
    stepper, penetration, remainder, turning = STEPPERS[name]
    result = lf.simulate(swarm(seed), 0.5, stepper, record=2e-3)
    p = momenta(result)
    np.testing.assert_allclose(p[:, :2], np.broadcast_to(p[0, :2], p[:, :2].shape), rtol=0, atol=1e-10)
    assert np.abs(p[:, 2] - p[0, 2]).max() < turning
    assert result.impulse[-1, :, 0].sum() > 0.5
    check_contacts(result, penetration)
    check_depth(result, False, penetration)
    check_energy(result, remainder)
