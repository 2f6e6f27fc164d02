"""Compliant contacts in space: impacts of Hertz spheres by closed form, and the numbers of the plane in any plane."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import lcpflex as lf
from tests.scenes import floor_of

laws = lf.laws
RADIUS, MASS = 0.02, 0.1
INERTIA = 0.5 * MASS * RADIUS**2
HERTZ = laws.Hertz.spheres(RADIUS, RADIUS, laws.Material(2.1e9, 0.3))
TILT = Rotation.from_rotvec([0.3, -0.5, 0.7])
EXPLICIT = lf.Smooth(integrator=lf.ExplicitRungeKutta(rtol=1e-10))
EVENTS = lf.EventDriven(rtol=1e-10)
START = (((-0.0205, 0.003, 0.0), (1.0, 0.0, 0.0), 0.0), ((0.0205, -0.003, 0.0), (-0.5, 0.0, 0.0), 30.0))


def balls(stepper: Any, law: Any, friction: float, duration: float, start: Any = START) -> lf.Result:
    """Two balls of space that meet, in a tilted plane."""
    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    surfaces = []
    for name, (place, velocity, spin) in zip("ab", start, strict=True):
        ball = scene.add(
            lf.SpatialRigidBody(MASS, INERTIA * np.eye(3)),
            position=TILT.apply(place),
            velocity=TILT.apply(velocity),
            angular_velocity=TILT.apply([0.0, 0.0, spin]),
            name=name,
        )
        surfaces.append(ball.sphere((0.0, 0.0, 0.0), RADIUS))
    scene.contact(*surfaces, friction=friction, law=law, name="pair")
    return lf.simulate(scene, duration, stepper)


def discs(stepper: Any, law: Any, friction: float, duration: float) -> lf.Result:
    """The same of discs."""
    scene = lf.Scene(gravity=(0.0, 0.0))
    a, b = (
        scene.add(lf.Disc(RADIUS, mass=MASS), position=place[:2], velocity=velocity[:2], angular_velocity=spin)
        for place, velocity, spin in START
    )
    scene.contact(a.surface(), b.surface(), friction=friction, law=law, name="pair")
    return lf.simulate(scene, duration, stepper)


def in_plane(result: lf.Result) -> Any:
    """Last velocities of both balls as in the plane; what leaves that plane is an error."""
    q, u = result.q[-1].reshape(2, 7), result.u[-1].reshape(2, 6)
    v = TILT.inv().apply(u[:, :3])
    w = TILT.inv().apply(Rotation.from_quat(q[:, [4, 5, 6, 3]]).apply(u[:, 3:]))
    np.testing.assert_allclose(v[:, 2], 0.0, atol=1e-12)
    np.testing.assert_allclose(w[:, :2], 0.0, atol=1e-9)
    return np.column_stack([v[:, :2], w[:, 2]]).reshape(-1)


@pytest.mark.parametrize("stepper", [EXPLICIT, lf.MoreauJean(1e-6), EVENTS], ids=["Smooth", "MoreauJean", "events"])
def test_an_elastic_impact_of_spheres_has_the_duration_and_the_force_of_hertz(stepper: Any) -> None:
    speed, reduced = 1.5, 0.5 * MASS
    start = (((-0.02, 0.0, 0.0), (1.0, 0.0, 0.0), 0.0), ((0.02, 0.0, 0.0), (-0.5, 0.0, 0.0), 0.0))
    K = HERTZ.parameters[0]
    deepest = (1.25 * reduced * speed**2 / K) ** 0.4
    lasts = 2.0 * math.sqrt(math.pi) * math.gamma(1.4) / math.gamma(0.9) * deepest / speed  # 2.9432 d/v
    result = balls(stepper, lf.ContactLaw(HERTZ), 0.0, 1.01 * lasts, start)
    pair = result.contact("pair")
    np.testing.assert_allclose(in_plane(result)[[0, 3]], [-0.5, 1.0], rtol=1e-5)
    assert pair.force[:, 0].max() == pytest.approx(K * deepest**1.5, rel=1e-3)
    assert (pair.force[:, 0] > 0.0).mean() * result.times[-1] == pytest.approx(lasts, rel=5e-3)
    assert pair.impulse[-1, 0] == pytest.approx(reduced * 2.0 * speed, rel=1e-5)


@pytest.mark.parametrize(
    ("stepper", "error"),
    [(EXPLICIT, 2e-7), (lf.MoreauJean(2e-6), 1e-11), (EVENTS, 2e-7)],
    ids=["Smooth", "MoreauJean", "events"],
)
@pytest.mark.parametrize("friction", [laws.SmoothedCoulomb(), laws.BrownMcPhee(static_friction=0.3)])
def test_balls_in_a_tilted_plane_are_discs(stepper: Any, error: float, friction: Any) -> None:
    law = lf.ContactLaw(HERTZ, laws.HysteresisDamping(restitution=0.8), friction)
    planar, spatial = discs(stepper, law, 0.2, 1.5e-3), balls(stepper, law, 0.2, 1.5e-3)
    np.testing.assert_allclose(in_plane(spatial), planar.u[-1], atol=error)
    assert spatial.energies.friction[-1] == pytest.approx(planar.energies.friction[-1], abs=error)
    pushed = TILT.inv().apply(spatial.contact("pair").impulse[-1, 1:])
    assert pushed[2] == pytest.approx(0.0, abs=1e-14)
    # friction of a turning tangent, and the normal forces, change the momentum of the first ball
    assert np.linalg.norm(pushed) == pytest.approx(abs(planar.contact("pair").impulse[-1, 1]), rel=1e-5)


@pytest.mark.parametrize("integrator", [lf.ExplicitRungeKutta(rtol=1e-10), lf.Stiff(rtol=1e-8)])
def test_balls_on_bristles_are_discs(integrator: Any) -> None:
    stepper = lf.Smooth(integrator=integrator)
    law = lf.ContactLaw(HERTZ, None, laws.LuGre(static_friction=0.3))
    planar, spatial = discs(stepper, law, 0.2, 1.5e-3), balls(stepper, law, 0.2, 1.5e-3)
    np.testing.assert_allclose(in_plane(spatial), planar.u[-1], atol=2e-6)


def test_momentum_and_spin_of_a_pair_are_kept_where_surfaces_penetrate() -> None:
    law = lf.ContactLaw(HERTZ, None, laws.SmoothedCoulomb(slip_speed=1e-2))
    start = (((-0.0205, 0.003, 0.002), (1.0, 0.0, 0.3), 20.0), ((0.0205, -0.003, 0.0), (-0.5, 0.2, 0.0), 30.0))
    result = balls(EXPLICIT, law, 0.4, 1.5e-3, start)
    q, u = result.q.reshape(-1, 2, 7), result.u.reshape(-1, 2, 6)
    spin = np.stack([INERTIA * Rotation.from_quat(q[:, i][:, [4, 5, 6, 3]]).apply(u[:, i, 3:]) for i in range(2)], 1)
    momentum = MASS * u[:, :, :3].sum(axis=1)
    turning = (np.cross(q[:, :, :3], MASS * u[:, :, :3]) + spin).sum(axis=1)
    np.testing.assert_allclose(momentum, np.broadcast_to(momentum[0], momentum.shape), atol=1e-14)
    np.testing.assert_allclose(turning, np.broadcast_to(turning[0], turning.shape), atol=2e-12)
    assert result.energies.friction[-1] > 1e-4


@pytest.mark.parametrize("stepper", [EXPLICIT, lf.MoreauJean(2e-6), EVENTS], ids=["Smooth", "MoreauJean", "events"])
def test_forces_told_are_those_on_the_first_surface(stepper: Any) -> None:
    law = lf.ContactLaw(HERTZ, None, laws.SmoothedCoulomb())
    for order in (1, -1):
        result = balls(stepper, law, 0.2, 1.5e-3, START[::order])
        first = result.u[-1, :3] - result.u[0, :3]
        along = TILT.apply([-1.0, 0.0, 0.0]) * order
        given = result.contact("pair").impulse[-1]
        # the tangent turns by little: its impulse is that of the momentum across the line of centres
        line = (result.q[0, :3] - result.q[0, 7:10]) / np.linalg.norm(result.q[0, :3] - result.q[0, 7:10])
        across = MASS * (first - (first @ line) * line)
        assert along @ line > 0.9
        np.testing.assert_allclose(given[1:], across, atol=0.1 * np.linalg.norm(across))


@pytest.mark.parametrize("direction", [0.0, 1.0, 2.5, 4.0])
def test_a_ball_under_a_regularised_law_comes_to_roll_as_by_coulombs(direction: float) -> None:
    """S2, thrown in any direction: the end is that of Coulomb, whatever the slip speed of the law."""
    radius, mass, turn = 0.028575, 0.17, Rotation.from_rotvec([0.0, 0.0, direction])
    missed = []
    for slip_speed in (4e-3, 1e-3):
        scene = lf.SpatialScene()
        ball = scene.add(
            lf.Sphere(radius, mass=mass),
            position=(0.0, 0.0, radius - (mass * 9.81 / 1e7)),
            velocity=turn.apply([2.0, 0.0, 0.0]),
            angular_velocity=turn.apply([15.0, -30.0, 7.0]),
        )
        floor = scene.ground.plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
        law = lf.ContactLaw(laws.PowerLaw(1e7, 1.0), None, laws.SmoothedCoulomb(slip_speed))
        scene.contact(ball.surface(), floor, friction=0.2, law=law)
        result = lf.simulate(scene, 0.5, lf.MoreauJean(1e-4))
        missed.append(turn.inv().apply(result.u[-1, :3]) - [1.18364286, -0.12246429, 0.0])
        spin = Rotation.from_quat(result.q[-1, [4, 5, 6, 3]]).apply(result.u[-1, 3:])
        assert spin[2] == pytest.approx(7.0, abs=1e-3)
    assert max(np.linalg.norm(one) for one in missed) < 1e-5  # most of it by indentation, 1.7e-7 m


@pytest.mark.parametrize(
    ("stepper", "error"),  # fixed steps pass over the instant at which a damper would begin to pull: of order 1 there
    [(EXPLICIT, 2e-5), (lf.MoreauJean(2e-6), 4e-4), (lf.MoreauJean(2e-7), 4e-5), (EVENTS, 2e-5)],
    ids=["Smooth", "MoreauJean", "MoreauJean, finer", "events"],
)
@pytest.mark.parametrize(
    ("damping", "restitution"),
    [(laws.HysteresisDamping(0.7), 0.7), (laws.Tsuji(0.7), laws.restitution_of(laws.Tsuji, 0.7))],
    ids=["Hunt and Crossley", "Tsuji"],
)
def test_dissipative_laws_give_back_what_they_do_in_the_plane(
    stepper: Any, error: float, damping: Any, restitution: float
) -> None:
    start = (((-0.02, 0.0, 0.0), (1.0, 0.0, 0.0), 0.0), ((0.02, 0.0, 0.0), (-0.5, 0.0, 0.0), 0.0))
    result = balls(stepper, lf.ContactLaw(HERTZ, damping), 0.0, 1.5e-3, start)
    after = in_plane(result)
    assert (after[3] - after[0]) / 1.5 == pytest.approx(restitution, rel=error)
    assert after[0] + after[3] == pytest.approx(0.5, abs=1e-13)


def test_compliant_contacts_beside_rigid_ones_are_those_of_the_plane() -> None:
    """A ball that slides on a rigid floor strikes one at rest by a law, and both slide on."""
    law = lf.ContactLaw(HERTZ, laws.HysteresisDamping(restitution=0.8), laws.SmoothedCoulomb())
    flat, scene = lf.Scene(), lf.SpatialScene()
    floor = scene.ground.plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    line = floor_of(flat)
    discs_of, balls_of = [], []
    along = np.array([0.6, 0.8, 0.0])
    for x, speed in ((0.0, 1.0), (0.05, 0.0)):
        disc = flat.add(lf.Disc(RADIUS, mass=MASS), position=(x, RADIUS), velocity=(speed, 0.0)).surface()
        ball = scene.add(
            lf.SpatialRigidBody(MASS, INERTIA * np.eye(3)),
            position=x * along + [0.0, 0.0, RADIUS],
            velocity=speed * along,
        ).sphere((0.0, 0.0, 0.0), RADIUS)
        flat.contact(disc, line, friction=0.3)
        scene.contact(ball, floor, friction=0.3)
        discs_of.append(disc)
        balls_of.append(ball)
    flat.contact(*discs_of, friction=0.2, law=law, name="pair")
    scene.contact(*balls_of, friction=0.2, law=law, name="pair")
    planar, spatial = (lf.simulate(one, 0.05, EVENTS) for one in (flat, scene))
    u, v = spatial.u[-1].reshape(2, 6), planar.u[-1].reshape(2, 3)
    np.testing.assert_allclose(u[:, :3] @ along, v[:, 0], atol=1e-7)
    np.testing.assert_allclose(u[:, :3] @ [-0.8, 0.6, 0.0], 0.0, atol=1e-9)
    np.testing.assert_allclose(np.linalg.norm(u[:, 3:], axis=1), np.abs(v[:, 2]), atol=1e-5)
    assert spatial.contact("pair").impulse[-1, 0] == pytest.approx(planar.contact("pair").impulse[-1, 0], rel=1e-7)
    assert v[1, 0] > 0.5


def test_bristles_turn_with_bodies_that_turn_together() -> None:
    """Two balls that are welded to one carrier keep a bent bristle as it is while all of it turns about any axis."""
    from lcpflex.dynamics.spatial.bristles import direction, spin_of_bristles
    from lcpflex.jit.struct import pack

    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    omega = np.array([2.0, -3.0, 5.0])
    places = (np.array([0.3, 0.1, -0.2]), np.array([0.31, 0.13, -0.16]))
    surfaces = [
        scene.add(lf.Sphere(0.026, mass=1.0), position=x, velocity=np.cross(omega, x), angular_velocity=omega).surface()
        for x in places
    ]
    scene.contact(*surfaces, friction=0.3)
    compiled = scene.compile(indents=lambda name: True)
    model, q, u = pack(compiled.model), compiled.q.copy(), compiled.u.copy()
    from lcpflex.contact.near import near

    table, n = near(model, q, 0.01)
    assert n == 1
    normal = table.normal[0].copy()
    for axis in range(3):
        e = np.array(direction(model, q, table, 0, axis))
        spin = spin_of_bristles(model, q, u, table, 0, axis)
        assert spin == pytest.approx(0.0, abs=1e-12)
        u[9:12] += normal  # the second ball spins about the normal: bristles go half of it with it
        own = 1.0 if table.body[0, 1] == 1 else 0.0  # and e all of it, where it is fixed there
        assert spin_of_bristles(model, q, u, table, 0, axis) == pytest.approx(0.5 - own, abs=1e-12)
        u[9:12] -= normal
        assert e @ normal == pytest.approx(0.0, abs=1e-15)
