"""Friction laws with two tangents: those of the plane along any line, and isotropic; bristles on turning bodies."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import lcpflex as lf
from lcpflex.dynamics.contact_forces_friction import balanced_friction
from lcpflex.dynamics.spatial.bristles import AXIS, direction, keep_bristles, straighten
from lcpflex.dynamics.spatial.contact_forces_friction import balanced_pull
from lcpflex.force_laws.friction.kernels import bristle_rates, friction_force
from lcpflex.force_laws.friction.spatial_kernels import bristle_slopes, friction_pull
from lcpflex.force_laws.history import contact_memory
from lcpflex.jit.struct import pack

laws = lf.laws
STATELESS = [
    laws.SmoothedCoulomb(), laws.ArctangentCoulomb(), laws.RampCoulomb(), laws.Threlfall(), laws.Ambrosio(),
    laws.BengisuAkay(static_friction=0.4), laws.BrownMcPhee(static_friction=0.4),
]  # fmt: skip
WITH_STATES = [laws.LuGre(static_friction=0.4, viscous=0.2), laws.Bristle(static_friction=0.4, viscous=0.2)]
MU, NORMAL = 0.3, 20.0


def arrays(friction: Any) -> tuple[Any, Any]:
    """Kinds and parameters of a law, as kernels take them."""
    row = lf.ContactLaw(laws.PowerLaw(1e5), friction=friction).row()
    return np.array(row.kinds), np.array(row.parameters)


@pytest.mark.parametrize("friction", STATELESS + WITH_STATES, ids=lambda law: type(law).__name__)
@pytest.mark.parametrize("speed", [0.0, 1e-5, 7e-4, 0.02, 1.5])
def test_along_a_line_the_law_is_that_of_the_plane(friction: Any, speed: float) -> None:
    kinds, p = arrays(friction)
    c, s = math.cos(0.7), math.sin(0.7)
    bristle, dwell = 2e-5, 0.3
    states = (bristle, dwell) if friction.bristles else (0.0, 0.0)
    force = friction_force(kinds, p, speed, NORMAL, MU, *states)
    pull = friction_pull(kinds, p, (c * speed, s * speed), NORMAL, MU, (c * states[0], s * states[0]), states[1])
    np.testing.assert_allclose(pull, (c * force, s * force), rtol=1e-13, atol=1e-14)
    rates = bristle_rates(kinds, p, speed, NORMAL, MU, *states)
    slopes = bristle_slopes(kinds, p, (c * speed, s * speed), MU, (c * states[0], s * states[0]), states[1])
    np.testing.assert_allclose(slopes, (c * rates[0], s * rates[0], rates[1]), rtol=1e-12, atol=1e-16)


@pytest.mark.parametrize("friction", WITH_STATES, ids=lambda law: type(law).__name__)
def test_bristles_know_no_direction(friction: Any) -> None:
    kinds, p = arrays(friction)
    turn = np.array([[math.cos(2.0), -math.sin(2.0)], [math.sin(2.0), math.cos(2.0)]])
    slip, bristle = np.array([3e-4, -8e-4]), np.array([-3e-5, -1e-5])
    for size in (1.0, 100.0):
        one = np.array(friction_pull(kinds, p, tuple(size * slip), NORMAL, MU, tuple(bristle), 0.6))
        other = friction_pull(kinds, p, tuple(size * turn @ slip), NORMAL, MU, tuple(turn @ bristle), 0.6)
        np.testing.assert_allclose(other, turn @ one, rtol=1e-12)
        rate = np.array(bristle_slopes(kinds, p, tuple(size * slip), MU, tuple(bristle), 0.6))
        turned = bristle_slopes(kinds, p, tuple(size * turn @ slip), MU, tuple(turn @ bristle), 0.6)
        np.testing.assert_allclose(turned, (*(turn @ rate[:2]), rate[2]), rtol=1e-12)


def test_held_bristles_pull_no_more_than_static_friction() -> None:
    kinds, p = arrays(laws.Bristle(static_friction=0.4))
    for dwell, most in ((0.0, 0.3), (1.0, 0.4)):
        pull = friction_pull(kinds, p, (0.0, 0.0), NORMAL, MU, (3e-3, -4e-3), dwell)
        assert math.hypot(*pull) == pytest.approx(most * NORMAL, rel=1e-12)
        assert pull[0] / pull[1] == pytest.approx(-0.75)


def memory(friction: Any) -> Any:
    """The memory of one contact with that friction."""
    scene = lf.SpatialScene()
    ball = scene.add(lf.Sphere(0.1, mass=1.0), position=(0.0, 0.0, 0.1))
    scene.contact(ball.surface(), scene.ground.plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0)), friction=MU)
    return contact_memory(scene.compile().model.contacts, [lf.ContactLaw(laws.PowerLaw(1e5), friction=friction).row()])


@pytest.mark.parametrize("friction", STATELESS, ids=lambda law: type(law).__name__)
def test_balanced_friction_is_that_of_the_slip_it_leaves(friction: Any) -> None:
    kinds, p = arrays(friction)
    known = memory(friction)
    random = np.random.default_rng(3)
    for _ in range(50):
        root = random.normal(size=(2, 2)) * 10.0 ** random.uniform(-4.0, -1.0)
        G = root @ root.T
        free, before = random.normal(size=2) * 10.0 ** random.uniform(-4.0, 0.5), random.normal(size=2)
        block = (G[0, 0], G[0, 1], G[1, 1])
        force = np.array(balanced_pull(known, 0, MU, NORMAL, tuple(before), tuple(free), block))
        left = friction_pull(kinds, p, tuple(free + G @ force), NORMAL, MU, (0.0, 0.0), 0.0)
        steep = NORMAL * 1e3 * np.linalg.norm(G @ force) * 1e-13  # rounding of the slip, by the slope of the law
        np.testing.assert_allclose(force, left, atol=1e-9 * NORMAL + steep)


@pytest.mark.parametrize("friction", STATELESS, ids=lambda law: type(law).__name__)
def test_balanced_friction_stays_on_the_branch_that_it_takes_in_the_plane(friction: Any) -> None:
    known = memory(friction)
    c, s = math.cos(-2.1), math.sin(-2.1)
    for share in (1e-4, 3e-3, 0.1):
        for free in (1e-3, 0.2, 1.0):
            for before in (0.0, 1e-4, 0.05, 2.0):
                planar = balanced_friction(known, 0, MU, NORMAL, before, free, share)
                pair = (c * before, s * before), (c * free, s * free)
                force = balanced_pull(known, 0, MU, NORMAL, *pair, (share, 0.0, share))
                np.testing.assert_allclose(force, (c * planar, s * planar), atol=1e-8 * NORMAL)


def test_bristles_keep_their_direction_where_another_axis_takes_over() -> None:
    scene = lf.SpatialScene()
    ball = scene.add(lf.Sphere(0.1, mass=1.0), position=(0.0, 0.0, 0.3))
    turn = Rotation.from_rotvec([0.2, -0.4, 0.3])
    hill = scene.add(lf.Sphere(0.2, mass=1.0), position=(0.0, 0.0, 0.0), orientation=turn)
    scene.contact(ball.surface(), hill.surface(), friction=MU)
    compiled = scene.compile()
    system = compiled.system()
    contacts = system.compliant([lf.ContactLaw(laws.PowerLaw(1e5), friction=laws.LuGre()).row()], 4)
    model, q, states = pack(compiled.model), compiled.q.copy(), np.zeros((2, 4))
    contacts.rows.table.body[0] = 0, 1
    contacts.rows.table.normal[0] = 0.0, 0.0, 1.0
    straighten(model, q, contacts, 0, states, 0)
    axis = int(states[0, AXIS])
    states[0, :2] = 3e-5, -4e-5
    contacts.rows.table.normal[0] = normal = turn.as_matrix()[:, axis] * 0.95 + turn.as_matrix()[:, 0] * math.sqrt(
        1 - 0.95**2
    )

    def bristle() -> Any:
        e = np.array(direction(model, q, contacts.rows.table, 0, int(states[0, AXIS])))
        assert e @ normal == pytest.approx(0.0, abs=1e-15)
        return states[0, 0] * e + states[0, 1] * np.cross(normal, e)

    before = bristle()
    keep_bristles(model, q, contacts, 0, states, 0)
    assert int(states[0, AXIS]) != axis
    np.testing.assert_allclose(bristle(), before, atol=1e-19)
