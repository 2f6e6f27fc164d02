"""Systems of the user's own whose contacts have two directions of friction: those of scenes, and of the plane."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import lcpflex as lf

laws = lf.laws
FEET = [(0.1 * math.cos(a), 0.1 * math.sin(a), 0.0) for a in (0.0, 2.0 * math.pi / 3.0, 4.0 * math.pi / 3.0)]
INERTIA = np.diag([2.5e-3, 2.5e-3, 5e-3])
SLOPE = math.radians(25.0)
SLANTED = (0.0, -9.81 * math.sin(SLOPE), -9.81 * math.cos(SLOPE))


def skew(a: Any) -> Any:
    return np.array([[0.0, -a[2], a[1]], [a[2], 0.0, -a[0]], [-a[1], a[0], 0.0]])


def axes(q: Any) -> Any:
    """A of the quaternion in q."""
    w, v = q[3], np.asarray(q[4:7])
    return (w * w - v @ v) * np.eye(3) + 2.0 * np.outer(v, v) + 2.0 * w * skew(v)


def kinematics(q: Any) -> Any:
    """Rdot = v, pdot = p o (0, omega)/2."""
    w, v = q[3], q[4:7]
    return np.block([[np.eye(3), np.zeros((3, 3))], [np.zeros((1, 3)), -0.5 * v[None]], [np.zeros((3, 3)),
                     0.5 * (w * np.eye(3) + skew(v))]])  # fmt: skip


def normalise(q: Any) -> Any:
    return np.concatenate([q[:3], q[3:] / np.linalg.norm(q[3:])])


def columns(q: Any) -> Any:
    """L^T of each foot, (6, feet, 3): what forces on it do."""
    A = axes(q)
    return np.stack([np.vstack([np.eye(3), skew(s) @ A.T]) for s in FEET], axis=1)


def own_puck(gravity: Any, friction: float, spin: float, **changes: Any) -> lf.UserSystem:
    """A puck of 1 kg on three feet in the plane of its mass centre."""

    def force(t: float, q: Any, u: Any) -> Any:
        return np.concatenate([gravity, -np.cross(u[3:], INERTIA @ u[3:])])

    given: dict[str, Any] = {
        "q": [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0], "u": [1.0, 0.0, 0.0, 0.0, 0.0, spin],
        "mass": np.block([[np.eye(3), np.zeros((3, 3))], [np.zeros((3, 3)), INERTIA]]), "force": force,
        "gaps": lambda q: [q[2] + (axes(q) @ s)[2] for s in FEET], "normals": lambda q: columns(q)[:, :, 2],
        "tangents": lambda q: columns(q)[:, :, :2], "kinematics": kinematics, "normalise": normalise,
        "friction": friction, "names": ["a", "b", "c"],
    }  # fmt: skip
    return lf.UserSystem(**{**given, **changes})


def puck(gravity: Any, friction: float, spin: float) -> lf.SpatialScene:
    """The same as a scene."""
    scene = lf.SpatialScene(gravity=gravity)
    body = scene.add(
        lf.SpatialRigidBody(1.0, INERTIA), velocity=(1.0, 0.0, 0.0), angular_velocity=(0.0, 0.0, spin), name="puck"
    )
    floor = scene.ground.plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    for name, foot in zip("abc", FEET, strict=True):
        scene.contact(body.node(foot), floor, friction=friction, name=name)
    return scene


@pytest.mark.parametrize(
    ("gravity", "friction", "spin", "error"),
    [(SLANTED, math.tan(SLOPE), 0.0, 1e-9), ((0.0, 0.0, -9.81), 0.2, 10.0, 2e-5)],
    ids=["S1", "R4"],
)
@pytest.mark.parametrize("stepper", [lf.MoreauJean(2e-3), lf.GeneralizedAlpha(2e-3)], ids=["MJ", "alpha"])
def test_a_puck_of_functions_is_that_of_a_scene(
    gravity: Any, friction: float, spin: float, error: float, stepper: Any
) -> None:
    own = lf.simulate(own_puck(gravity, friction, spin), 0.1, stepper)
    scene = lf.simulate(puck(gravity, friction, spin), 0.1, stepper)
    np.testing.assert_allclose(own.q[-1], scene.q[-1], atol=error)
    np.testing.assert_allclose(own.u[-1], scene.u[-1], atol=error * max(1.0, spin))
    assert own.energies.friction[-1] == pytest.approx(scene.energies.friction[-1], abs=10.0 * error)
    impulses = [sum(result.contact(name).impulse[-1] for name in "abc") for result in (own, scene)]
    np.testing.assert_allclose(impulses[0], impulses[1], atol=10.0 * error)
    assert not own.warnings


def sled(axes_of: int, speed: float, mu: float, **changes: Any) -> lf.UserSystem:
    """A particle above a floor that is pushed to and fro along a line of its plane, of a line or of two directions."""
    along = np.array([1.0]) if axes_of == 1 else np.array([0.6, 0.8])
    n = len(along) + 1
    normals, tangents = np.zeros((n, 1)), np.zeros((n, 1, axes_of))
    normals[-1] = 1.0
    tangents[:axes_of, 0] = np.eye(axes_of)

    def force(t: float, q: Any, u: Any) -> Any:
        return np.append(4.0 * math.sin(40.0 * t) * along, -9.81)

    given: dict[str, Any] = {
        "q": np.zeros(n), "u": np.append(speed * along, 0.0), "mass": np.eye(n), "force": force,
        "gaps": lambda q: [q[-1]], "normals": normals, "tangents": tangents if axes_of == 2 else tangents[:, :, 0],
        "friction": mu, "names": ["floor"],
    }  # fmt: skip
    return lf.UserSystem(**{**given, **changes})


ELASTIC = laws.PowerLaw(1e4, 1.0)


@pytest.mark.parametrize("friction", [laws.SmoothedCoulomb(), laws.LuGre(), laws.Bristle()], ids=["tanh", "LuGre", "z"])
@pytest.mark.parametrize(
    "integrator",
    [pytest.param(lf.ExplicitRungeKutta(), marks=pytest.mark.slow), lf.Verlet(1e-4)],
    ids=["Runge-Kutta", "Verlet"],
)
def test_along_a_line_two_directions_are_one(friction: Any, integrator: Any) -> None:
    stepper = lf.Smooth(lf.ContactLaw(ELASTIC, None, friction), integrator=integrator)
    one, two = (lf.simulate(sled(k, 0.3, 0.3), 0.02, stepper) for k in (1, 2))
    np.testing.assert_allclose(two.q[-1], [0.6 * one.q[-1, 0], 0.8 * one.q[-1, 0], one.q[-1, 1]], atol=2e-7)
    force, other = one.contact("floor").force[-1], two.contact("floor").force[-1]
    np.testing.assert_allclose(other, [force[0], 0.6 * force[1], 0.8 * force[1], 0.0], atol=2e-5 * abs(force[0]))


def test_a_rigid_floor_stops_a_particle_along_its_line() -> None:
    one, two = (lf.simulate(sled(k, 0.3, 0.3, restitution=0.5), 0.2, lf.MoreauJean(1e-3)) for k in (1, 2))
    np.testing.assert_allclose(two.q[:, 0], 0.6 * one.q[:, 0], atol=1e-10)
    np.testing.assert_allclose(two.q[:, 1], 0.8 * one.q[:, 0], atol=1e-10)
    assert two.contact("floor").impulse[-1, 0] == pytest.approx(one.contact("floor").impulse[-1, 0], rel=1e-9)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"tangents": np.zeros((3, 1, 3))}, r"tangents: .*\(3, 1, 2\)"),
        ({"tangents": lambda q: np.zeros((2, 1, 2))}, r"tangents.*\(3, 1, 2\)"),
        ({"tangent_bias": lambda q, u: [0.0]}, r"tangent_bias.*\(1, 2\)"),
    ],
)
def test_bad_directions(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(lf.ModelError, match=message):
        sled(2, 0.3, 0.3, **changes)


def test_a_stepper_without_cones_says_so() -> None:
    with pytest.raises(lf.ModelError, match="MasslessBoundary"):
        lf.simulate(sled(2, 0.3, 0.3), 0.01, lf.MasslessBoundary(1e-3))


@pytest.mark.slow
def test_the_puck_of_an_incline_slides_by_closed_form() -> None:
    """S1: mu = tan(slope), |v| + v_down = 1 m/s stays, and the direction of slip turns by separation."""
    own = lf.simulate(own_puck(SLANTED, math.tan(SLOPE), 0.0), 0.3, lf.EventDriven())
    scene = lf.simulate(puck(SLANTED, math.tan(SLOPE), 0.0), 0.3, lf.EventDriven())
    np.testing.assert_allclose(own.u[-1, :2], [0.13577602, -0.49078244], atol=1e-8)
    np.testing.assert_allclose(own.q[-1], scene.q[-1], atol=1e-9)
    np.testing.assert_allclose(own.u[-1], scene.u[-1], atol=1e-9)
    impulses = [sum(result.contact(name).impulse[-1] for name in "abc") for result in (own, scene)]
    np.testing.assert_allclose(impulses[0], impulses[1], atol=1e-9)
    assert not own.warnings


@pytest.mark.slow
def test_events_along_a_line_are_those_of_one_direction() -> None:
    """It slides to and fro, sticks and falls onto the floor: events of the same kinds at the same times."""
    one, two = (
        lf.simulate(sled(k, 0.05, 0.3, restitution=0.5, q=np.append(np.zeros(k), 1e-3)), 0.1, lf.EventDriven())
        for k in (1, 2)
    )
    np.testing.assert_allclose(two.q[-1], [0.6 * one.q[-1, 0], 0.8 * one.q[-1, 0], one.q[-1, 1]], atol=1e-7)
    np.testing.assert_allclose(two.u[-1], [0.6 * one.u[-1, 0], 0.8 * one.u[-1, 0], one.u[-1, 1]], atol=1e-6)
    assert two.contact("floor").impulse[-1, 0] == pytest.approx(one.contact("floor").impulse[-1, 0], rel=1e-7)
    impacts = [[event.time for event in result.events if event.kind == "impact"] for result in (one, two)]
    assert len(impacts[0]) > 3
    np.testing.assert_allclose(impacts[0][:4], impacts[1][:4], atol=1e-9)


@pytest.mark.parametrize("scheme", [lf.MoreauJean, lf.GeneralizedAlpha])
def test_error_control_takes_a_point_in_space_for_what_it_is(scheme: Any) -> None:
    """It has no bodies whose angles could be followed along a step; it moves as the same point does in the plane."""

    def falling(dimensions: int) -> lf.UserSystem:
        unit = np.eye(dimensions)
        across = unit[:, None, :-1] if dimensions > 2 else unit[:, :1]
        return lf.UserSystem(
            q=0.01 * unit[-1], u=unit[0], mass=unit, force=lambda t, q, u: -9.81 * unit[-1], gaps=lambda q: q[-1:],
            normals=unit[:, -1:], tangents=across, friction=0.3,
        )  # fmt: skip

    stepper = scheme(1e-3, adaptive=lf.AdaptiveStep(rtol=1e-5))
    space, plane = (lf.simulate(falling(dimensions), 0.1, stepper, record=0.01) for dimensions in (3, 2))
    np.testing.assert_allclose(space.q[:, [0, 2]], plane.q, atol=1e-6)
    assert space.impulse[-1, 0, 0] > 0.4
    assert not space.q[:, 1].any()
