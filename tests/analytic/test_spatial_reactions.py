"""Reactions of joints in space: by statics, by least norm, and of mechanisms that are assembled with errors."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import lcpflex as lf
from lcpflex.jit.kernel import FloatArray
from tests.unit.dynamics.spatial_mechanisms import GROUND, PAIRS, Mechanism, bennett, box, four_bar

GRAVITY = (0.3, -9.81, 1.0)
STEPPERS = [lf.EventDriven(), lf.MoreauJean(step=1e-7), lf.GeneralizedAlpha(step=1e-7)]


def scene_of(mechanism: Mechanism) -> lf.SpatialScene:
    """The same bodies and joints, which are called joint0, joint1, ..."""
    scene = lf.SpatialScene(gravity=GRAVITY)
    placed = [
        scene.add(lf.SpatialRigidBody(mass=b.mass, inertia=b.inertia), position=b.place, orientation=b.axes)
        for b in mechanism.bodies
    ]
    for k, joint in enumerate(mechanism.joints):
        (P, axes_p), (Q, axes_q) = (
            (scene.ground.at(*r), axes)
            if b == GROUND
            else (placed[b].at(*mechanism.bodies[b].axes.T @ (r - mechanism.bodies[b].place)), mechanism.bodies[b].axes.T @ axes)
            for b, r, axes in zip(joint.bodies, (joint.r_p, joint.r_q), (joint.axes_p, joint.axes_q), strict=True)
        )
        made = {
            "ball": lambda P=P, Q=Q, k=k: lf.Ball(P, Q, name=f"joint{k}"),
            "hinge": lambda P=P, Q=Q, a=axes_q[:, 2], b=axes_p[:, 2], k=k: lf.Revolute(
                P, Q, axis=a, axis_p=b, name=f"joint{k}"
            ),
            "weld": lambda P=P, Q=Q, k=k: lf.Weld(P, Q, name=f"joint{k}"),
        }[joint.kind]()
        scene.join(made)
    return scene


def least_norm(mechanism: Mechanism, size: float) -> FloatArray:
    """(joints, 6) the reactions at the start, at rest: of all with that motion those of least |F|^2 + |M|^2 / L^2."""
    J, inverse = mechanism.rows(), mechanism.inverse_masses()
    weight = np.concatenate([[*(b.mass * np.array(GRAVITY)), 0.0, 0.0, 0.0] for b in mechanism.bodies])
    root = np.sqrt(inverse)
    some = -np.linalg.lstsq(root @ J.T, root @ weight, rcond=1e-12)[0]
    wrenches = np.zeros((6 * len(mechanism.joints), len(J)))
    first = np.cumsum([0, *mechanism.row_counts()])
    for k, joint in enumerate(mechanism.joints):
        own = wrenches[6 * k : 6 * k + 6, first[k] : first[k + 1]]
        own[:3, :3] = np.eye(3)
        for i, (a, b) in enumerate(PAIRS[joint.kind]):
            own[3:, 3 + i] = np.cross(joint.axes_p[:, a], joint.axes_q[:, b]) / size
    _, sizes, rows = np.linalg.svd(J.T)
    idle = rows[(sizes > 1e-10 * sizes[0]).sum() :].T
    least = some - idle @ np.linalg.lstsq(wrenches @ idle, wrenches @ some, rcond=None)[0]
    return (wrenches @ least).reshape(-1, 6) * ([1.0] * 3 + [size] * 3)


def reactions_at_start(result: Any) -> FloatArray:
    """(joints, 6): at the first instant that tells."""
    told = np.isfinite(result.joint_force).all(axis=(1, 2))
    return np.asarray(result.joint_force[int(np.argmax(told))])


@pytest.mark.parametrize("on_ground", ["P", "Q"])
@pytest.mark.parametrize("stepper", STEPPERS, ids=lambda s: type(s).__name__)
def test_cantilever(stepper: Any, on_ground: str) -> None:
    """A weld carries the weight, and its moment about P: on the body, and the opposite on the ground."""
    scene = lf.SpatialScene(gravity=GRAVITY)
    turn, place, center = Rotation.from_rotvec([0.3, 0.2, -0.5]), np.array([0.5, 0.2, 0.1]), np.array([0.1, 0.05, -0.02])
    body = scene.add(lf.SpatialRigidBody(2.0, (0.1, 0.2, 0.25), center=center), "arm", position=place, orientation=turn)
    at = (-0.3, 0.1, 0.2)
    ends = body.at(*at), scene.ground.at(*(place + turn.apply(at)))
    scene.join(lf.Weld(*(ends if on_ground == "Q" else ends[::-1]), name="weld"))
    result = lf.simulate(scene, 1e-6, stepper)
    weight = 2.0 * np.array(GRAVITY)
    sign = -1.0 if on_ground == "Q" else 1.0
    expected = sign * np.array([*weight, *np.cross(turn.apply(center - at), weight)])
    assert reactions_at_start(result)[0] == pytest.approx(expected, abs=1e-10)
    told = result.reaction("weld", axes="arm")
    assert told.force[-1] == pytest.approx(turn.inv().apply(expected[:3]), abs=1e-9)
    assert told.moment[-1] == pytest.approx(turn.inv().apply(expected[3:]), abs=1e-9)
    assert told.largest_force[-1] == pytest.approx(np.linalg.norm(expected[:3]))
    assert told.largest_moment[-1] == pytest.approx(np.linalg.norm(expected[3:]))
    assert told.unique.all()


def test_spinning_hinge() -> None:
    """A body that turns about an axis off its mass centre: m omega^2 d inwards, and what its products of inertia ask."""
    scene, rate, d = lf.SpatialScene(gravity=(0.0, 0.0, 0.0)), 7.0, 0.2
    J = np.array([[0.2, 0.01, 0.03], [0.01, 0.25, -0.02], [0.03, -0.02, 0.3]])
    body = scene.add(
        lf.SpatialRigidBody(2.0, J), "rotor", position=(d, 0, 0), velocity=(0, rate * d, 0), angular_velocity=(0, 0, rate)
    )
    scene.join(lf.Revolute(body.at(-d, 0, 0), scene.ground.at(0, 0, 0), axis=(0, 0, 1), name="hinge"))
    result = lf.simulate(scene, 1.0, lf.EventDriven(rtol=1e-10))
    told = result.reaction("hinge", axes="rotor")
    assert told.force == pytest.approx(np.broadcast_to([-2.0 * rate**2 * d, 0.0, 0.0], told.force.shape), abs=1e-6)
    moment = rate**2 * np.array([-J[1, 2], J[0, 2], 0.0])  # omega x J omega
    assert told.moment == pytest.approx(np.broadcast_to(moment, told.moment.shape), abs=1e-6)
    assert result.reaction("hinge").moment[:, 2] == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize("stepper", STEPPERS, ids=lambda s: type(s).__name__)
@pytest.mark.parametrize("masses", [(1.0, 1.0, 1.0), (1.0, 1e-3, 1.0)], ids=str)
@pytest.mark.parametrize("make", [four_bar, bennett, box])
def test_least_norm(make: Callable[..., Mechanism], masses: tuple[float, ...], stepper: Any) -> None:
    """Reactions of redundant joints are those of least norm, and marked."""
    mechanism = make(0.0, masses)
    result = lf.simulate(scene_of(mechanism), 1e-6, stepper)
    assert result.compiled is not None
    expected = least_norm(mechanism, result.compiled.size)
    assert np.abs(reactions_at_start(result) - expected).max() < 1e-7 * np.abs(expected).max()
    assert not result.reaction("joint1").unique[-1]


def test_unique_ones_of_redundant_mechanisms() -> None:
    """What hangs on a redundant mechanism by a hinge has a reaction that the motion determines."""
    mechanism = four_bar()
    scene = scene_of(mechanism)
    place = np.array([0.5, -0.3, 0.2])
    bob = scene.add(lf.SpatialRigidBody(0.5, (0.01, 0.01, 0.01)), "bob", position=place)
    coupler = mechanism.bodies[1]
    held = scene.placed("body2") if hasattr(scene, "placed") else None
    assert held is not None and coupler is not None
    scene.join(lf.Ball(bob.at(0, 0.3, 0), held.at(0, 0, 0), name="hanger"))
