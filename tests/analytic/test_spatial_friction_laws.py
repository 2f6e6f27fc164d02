"""Friction in space by force laws: creep at stick by closed forms, its direction, and that it prefers none."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import lcpflex as lf

laws = lf.laws
MU, G, STIFFNESS, FEET, REACH = 0.3, 9.81, 1e4, 3, 0.1
SINK = G / (FEET * STIFFNESS)  # of the feet of a puck of 1 kg [m]
DIRECTIONS = 2.0 * math.pi * np.arange(24) / 24 + 0.05
STOPS_AFTER = 1.0 / (2.0 * MU * G)  # from 1 m/s [m]


def puck(
    friction: Any, velocity: Any = (0.0, 0.0, 0.0), load: Any = None, legs: float = 0.0, spin: float = 0.0
) -> lf.SpatialScene:
    """A puck of 1 kg on three feet, ``legs`` below its mass centre, at rest on a floor that gives way, or a rigid one.

    Without legs friction acts at the height of the mass centre, halfway between floor and feet: nothing tips it.
    """
    scene = lf.SpatialScene()
    sink = SINK if friction else 0.0
    below = legs + 0.5 * sink
    angles = 2.0 * math.pi * np.arange(FEET) / FEET
    places = {f"foot{k}": (REACH * math.cos(a), REACH * math.sin(a), -below) for k, a in enumerate(angles)}
    none = np.zeros((0, 3))
    points = {name: lf.SpatialPoint(np.array(place), none, none) for name, place in places.items()}
    points["center"] = lf.SpatialPoint(np.zeros(3), none, none)
    body = scene.add(
        lf.SpatialBody(mass=1.0, inertia=0.25 * REACH**2 * np.diag([1.0, 1.0, 2.0]), points=points),
        name="puck",
        position=(0.0, 0.0, below - sink),
        velocity=velocity,
        angular_velocity=(0.0, 0.0, spin),
    )
    floor = scene.ground.plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    law = lf.ContactLaw(laws.PowerLaw(STIFFNESS, 1.0), None, friction) if friction else None
    for name in places:
        scene.contact(body.node(name), floor, friction=MU, law=law, name=name)
    if load is not None:
        scene.load(lf.Force(body.point("center"), load))
    return scene


def explicit(rtol: float) -> lf.Smooth:
    return lf.Smooth(integrator=lf.ExplicitRungeKutta(rtol=rtol))


def pulled(friction: Any, shares: Any, direction: float, each: float = 2.0) -> Any:
    """(n,) paths [m] of a puck pulled along ``direction``, the load going from each share of mu N to the next."""
    times = np.linspace(0.0, each * (len(shares) - 1), 40 * (len(shares) - 1) + 1)
    part, s = np.divmod(times / each, 1.0)
    k = np.minimum(part.astype(int), len(shares) - 2)
    s = np.where(part > k, 1.0, s)
    given = np.asarray(shares)
    force = MU * G * (given[k] + (given[k + 1] - given[k]) * s * s * (3.0 - 2.0 * s))
    along = np.array([math.cos(direction), math.sin(direction)])
    load = (lf.Table(times, along[0] * force), lf.Table(times, along[1] * force), 0.0)
    result = lf.simulate(puck(friction, load=load), times[-1], explicit(1e-9), record=each)
    assert np.abs(result.q[:, :2] @ [-along[1], along[0]]).max() < 1e-14
    return result.q[:, :2] @ along


@pytest.mark.parametrize("direction", [0.0, 1.0, 4.0])
def test_a_puck_at_stick_gives_way_as_its_bristles_bend(direction: float) -> None:
    """LuGre: x = -mu / sigma_0 ln(1 - f) under a load f mu N that grows; Gonthier: a spring."""
    for share in (0.5, 0.8):
        lugre = pulled(laws.LuGre(damping=100.0), (0.0, share, share), direction)
        assert lugre[-1] == pytest.approx(-MU / 1e4 * math.log(1.0 - share), rel=3e-4)
        spring = pulled(laws.Bristle(stribeck_speed=0.02), (0.0, share, share), direction)
        assert spring[-1] == pytest.approx(share * MU / 1e4, rel=3e-4)


def test_a_puck_drifts_under_a_load_that_comes_and_goes_as_the_law_says() -> None:
    """LuGre's trait: each time the load f mu N is put on and off it goes on by -mu / sigma_0 ln(1 - f^2)."""
    path = pulled(laws.LuGre(damping=100.0), (0.0, 0.8) * 3 + (0.0,), 2.0)
    drift = -MU / 1e4 * math.log(1.0 - 0.8**2)
    np.testing.assert_allclose(np.diff(path[::2]), drift, rtol=3e-3)
    held = pulled(laws.Bristle(stribeck_speed=0.02), (0.0, 0.8) * 3 + (0.0,), 2.0)
    assert np.abs(held[::2]).max() < 1e-3 * drift


@pytest.mark.parametrize(
    "friction", [laws.SmoothedCoulomb(0.01), laws.LuGre(), laws.Bristle()], ids=lambda law: law.kind
)
@pytest.mark.parametrize(
    "stepper", [lf.Smooth(integrator=lf.Verlet(1e-4)), lf.MoreauJean(step=1e-4)], ids=["Verlet", "Moreau-Jean"]
)
def test_a_scene_turned_about_the_vertical_has_the_turned_result(friction: Any, stepper: Any) -> None:
    """A billiard ball that slides on a curve and rolls."""
    if friction.bristles and isinstance(stepper, lf.MoreauJean):
        pytest.skip("it refuses friction with states")

    def thrown(angle: float) -> Any:
        turn = Rotation.from_rotvec([0.0, 0.0, angle])
        scene = lf.SpatialScene()
        ball = scene.add(
            lf.Sphere(0.028575, mass=0.17),
            name="ball",
            position=turn.apply([0.3, -0.2, 0.028575 - 0.17 * G / 1e5]),
            orientation=turn,
            velocity=turn.apply([2.0, 0.0, 0.0]),
            angular_velocity=turn.apply([15.0, -30.0, 7.0]),
        )
        law = lf.ContactLaw(laws.PowerLaw(1e5, 1.0), None, friction)
        floor = scene.ground.plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
        scene.contact(ball.surface(), floor, friction=0.2, law=law, name="cloth")
        result = lf.simulate(scene, 0.5, stepper, record=0.1)
        told = result.q[:, :3], result.u[:, :3], result.angular_velocity("ball"), result.contact("cloth").force[:, 1:]
        return np.concatenate([turn.inv().apply(each) for each in told], axis=1)

    straight = thrown(0.0)
    for angle in (0.7, 0.5 * math.pi, 4.0):
        np.testing.assert_allclose(thrown(angle), straight, atol=1e-10)


COULOMB, REGULAR = None, laws.SmoothedCoulomb(0.01)
RUNS = {
    # stepper, friction law, height of the mass centre above the feet, largest error of the path (None: has none)
    "Moreau-Jean": (lf.MoreauJean(step=2e-3), COULOMB, 0.0, 1e-5),
    "Moreau-Jean, on legs": (lf.MoreauJean(step=2e-3), COULOMB, 0.02, 1e-5),
    "events": (lf.EventDriven(rtol=1e-8), COULOMB, 0.0, 1e-8),
    "events, on legs": (lf.EventDriven(rtol=1e-8), COULOMB, 0.02, 1e-8),
    "generalised alpha": (lf.GeneralizedAlpha(step=2e-3), COULOMB, 0.0, 1e-5),
    "Moreau-Jean, law": (lf.MoreauJean(step=1e-3), REGULAR, 0.0, 1e-4),
    "Moreau-Jean, law, on legs": (lf.MoreauJean(step=1e-3), REGULAR, 0.02, None),
    "events, law": (lf.EventDriven(rtol=1e-8), REGULAR, 0.0, 1e-6),
    "events, law, on legs": (lf.EventDriven(rtol=1e-8), REGULAR, 0.02, None),
    "explicit": (explicit(1e-8), REGULAR, 0.0, 1e-6),
    "explicit, on legs": (explicit(1e-8), REGULAR, 0.02, None),
    "Verlet, LuGre": (lf.Smooth(integrator=lf.Verlet(2e-4)), laws.LuGre(), 0.0, None),
    "explicit, Bristle": (explicit(1e-8), laws.Bristle(), 0.0, None),
}


# each stepper and law is here by default: without legs by the closed form of its stop, on legs by all directions alike
STUDIES = ("Moreau-Jean", "events", "Moreau-Jean, law", "events, law, on legs", "explicit")


@pytest.mark.parametrize(
    ("stepper", "friction", "legs", "error"),
    [pytest.param(*run, id=name, marks=[pytest.mark.slow] * (name in STUDIES)) for name, run in RUNS.items()],
)
def test_a_puck_stops_alike_in_all_directions(stepper: Any, friction: Any, legs: float, error: float | None) -> None:
    """Also on legs, where the feet ahead carry more."""
    stops, forces = [], []
    for angle in DIRECTIONS:
        along = np.array([math.cos(angle), math.sin(angle), 0.0])
        result = lf.simulate(puck(friction, along, legs=legs), 0.5, stepper, record=0.1)
        at = int(np.argmin(np.abs(result.times - 0.2)))
        forces.append((1.0 - result.u[at, :2] @ along[:2]) / result.times[at])
        stops.append(np.hypot(*result.q[-1, :2]))
        for vector in (result.q[-1, :2], result.u[at, :2]):
            assert abs(vector @ [-along[1], along[0]]) < 1e-9
    assert np.ptp(stops) < 1e-8 * STOPS_AFTER
    assert np.ptp(forces) < 1e-8 * MU * G
    if error is not None:
        longer = (math.pi * friction.slip_speed) ** 2 / (12.0 * MU * G) if friction else 0.0  # creeping to its stop
        assert np.mean(stops) == pytest.approx(STOPS_AFTER + longer, rel=error)
        assert np.mean(forces) == pytest.approx(MU * G, rel=1e-6)


def pushed(solver: Any, u: Any, step: float) -> Any:
    """(3,) impulse on a point of 1 kg on the floor that moves at u, in a step."""
    free = u - np.array([step * G, 0.0, 0.0])
    return solver.solve(lf.solvers.SpatialContactProblem(np.eye(3), free, np.array([MU]))).z


@pytest.mark.slow
def test_on_a_cone_with_facets_a_point_stops_at_distances_of_its_own() -> None:
    step = 0.02

    def stop(solver: Any, angle: float) -> float:
        u, x = np.array([0.0, math.cos(angle), math.sin(angle)]), np.zeros(2)
        for _ in range(25):
            u = u - np.array([step * G, 0.0, 0.0]) + pushed(solver, u, step)
            x += step * u[1:]
        assert np.abs(u).max() < 1e-9
        return float(np.hypot(*x))

    round_one = [stop(lf.solvers.Auto(), angle) for angle in DIRECTIONS]
    assert np.ptp(round_one) < 1e-8 * STOPS_AFTER
    faceted = [stop(lf.solvers.FacetedCone(8), angle) for angle in DIRECTIONS]
    assert np.ptp(faceted) > 1e-2 * STOPS_AFTER
    assert max(faceted) < 1.01 / math.cos(math.pi / 8.0) * np.mean(round_one)
