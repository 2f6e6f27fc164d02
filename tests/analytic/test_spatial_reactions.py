"""Reactions of joints in space: by statics, by least norm, and of mechanisms that are assembled with errors."""

from __future__ import annotations

import warnings
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

LONG_STEPS = [lf.EventDriven(), lf.MoreauJean(step=1e-3), lf.GeneralizedAlpha(step=1e-3)]


def scene_of(mechanism: Mechanism) -> tuple[lf.SpatialScene, list[Any]]:
    """The same bodies and joints, which are called joint0, joint1, ..., and the handles of the bodies."""
    scene = lf.SpatialScene(gravity=GRAVITY)
    placed = [
        scene.add(lf.SpatialRigidBody(b.mass, b.inertia), position=b.place, orientation=b.axes)
        for b in mechanism.bodies
    ]

    def end(b: int, r: FloatArray, axes: FloatArray) -> tuple[Any, FloatArray]:
        if b == GROUND:
            return scene.ground.at(*r), axes
        body = mechanism.bodies[b]
        return placed[b].at(*(body.axes.T @ (r - body.place))), body.axes.T @ axes

    for k, joint in enumerate(mechanism.joints):
        P, axes_p = end(joint.bodies[0], joint.r_p, joint.axes_p)
        Q, axes_q = end(joint.bodies[1], joint.r_q, joint.axes_q)
        if joint.kind == "hinge":
            scene.join(lf.Revolute(P, Q, axis=axes_q[:, 2], axis_p=axes_p[:, 2], name=f"joint{k}"))
        else:
            scene.join({"ball": lf.Ball, "weld": lf.Weld}[joint.kind](P, Q, name=f"joint{k}"))
    return scene, placed


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
    turn, place, center = (
        Rotation.from_rotvec([0.3, 0.2, -0.5]),
        np.array([0.5, 0.2, 0.1]),
        np.array([0.1, 0.05, -0.02]),
    )
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
    """A body that turns about an axis off its mass centre: m omega^2 d inwards, and omega x J omega."""
    scene, rate, d = lf.SpatialScene(gravity=(0.0, 0.0, 0.0)), 7.0, 0.2
    J = np.array([[0.2, 0.01, 0.03], [0.01, 0.25, -0.02], [0.03, -0.02, 0.3]])
    body = scene.add(
        lf.SpatialRigidBody(2.0, J),
        "rotor",
        position=(d, 0, 0),
        velocity=(0, rate * d, 0),
        angular_velocity=(0, 0, rate),
    )
    scene.join(lf.Revolute(body.at(-d, 0, 0), scene.ground.at(0, 0, 0), axis=(0, 0, 1), name="hinge"))
    result = lf.simulate(scene, 1.0, lf.EventDriven(rtol=1e-10))
    told = result.reaction("hinge", axes="rotor")
    assert told.force == pytest.approx(np.broadcast_to([-2.0 * rate**2 * d, 0.0, 0.0], told.force.shape), abs=1e-6)
    moment = rate**2 * np.array([-J[1, 2], J[0, 2], 0.0])
    assert told.moment == pytest.approx(np.broadcast_to(moment, told.moment.shape), abs=1e-6)
    assert result.reaction("hinge").moment[:, 2] == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize("stepper", STEPPERS, ids=lambda s: type(s).__name__)
@pytest.mark.parametrize("masses", [(1.0, 1.0, 1.0), (1.0, 1e-3, 1.0)], ids=str)
@pytest.mark.parametrize("make", [four_bar, bennett, box])
def test_least_norm(make: Callable[..., Mechanism], masses: tuple[float, ...], stepper: Any) -> None:
    """Reactions of redundant joints are those of least norm, and marked."""
    mechanism = make(0.0, masses)
    result = lf.simulate(scene_of(mechanism)[0], 1e-6, stepper)
    assert result.compiled is not None
    expected = least_norm(mechanism, result.compiled.size)
    assert np.abs(reactions_at_start(result) - expected).max() < 1e-7 * np.abs(expected).max()
    assert not result.reaction("joint1").unique[-1]


def test_unique_ones_of_redundant_mechanisms() -> None:
    """What hangs on a redundant mechanism by a ball joint has a reaction that the motion determines."""
    mechanism = four_bar()
    scene, placed = scene_of(mechanism)
    bob = scene.add(
        lf.SpatialRigidBody(0.5, (0.01, 0.01, 0.01)), "bob", position=mechanism.bodies[1].place - [0, 0.3, 0]
    )
    scene.join(lf.Ball(bob.at(0, 0.3, 0), placed[1].at(0, 0, 0), name="hanger"))
    result = lf.simulate(scene, 1e-2, lf.MoreauJean(step=1e-3))
    assert result.reaction("hanger").unique.all()
    assert not any(result.reaction(f"joint{k}").unique[1:].any() for k in range(4))
    assert "not determined" in str(result.reaction("joint0"))


@pytest.mark.parametrize("stepper", LONG_STEPS, ids=lambda s: type(s).__name__)
@pytest.mark.parametrize("make", [four_bar, bennett])
def test_assembled_with_errors(make: Callable[..., Mechanism], stepper: Any) -> None:
    """It moves, off the way of the one that fits by as much as it is assembled badly, and so are its reactions."""
    duration = 0.3
    exact = lf.simulate(scene_of(make())[0], duration, stepper, record=0.01)
    assert np.ptp(exact.energies.kinetic) > 1.0
    for error in (1e-8, 1e-6):
        with pytest.warns(lf.ModelWarning, match="redundant joints contradict each other, most at joint"):
            off = lf.simulate(scene_of(make(error))[0], duration, stepper, record=0.01, project=True)
        assert any(text.startswith("redundant joints contradict each other") for text in off.warnings)
        assert np.abs(off.q[-1] - exact.q[-1]).max() < 50.0 * error
        assert off.joint_drift.max() < 10.0 * error
        assert np.ptp(off.energies.kinetic + off.energies.potential) < 1e-3
        at_last = np.abs(off.joint_force[-1] - exact.joint_force[-1]).max()
        assert at_last < 1e4 * error * np.abs(exact.joint_force[-1]).max()


def test_badly_assembled_ones_are_refused() -> None:
    """Without projection, and where nothing like a misfit is left of it."""
    with pytest.raises(lf.ModelError, match=r"place the bodies accordingly, or use project=True"):
        scene_of(four_bar(1e-6))[0].compile()
    with pytest.raises(lf.ModelError, match=r"the joints contradict each other"):
        scene_of(four_bar(1e-3))[0].compile(project=True)


def test_locked_by_its_assembly() -> None:
    """Axes that are off by 3e-3 rad lock a four-bar: this is said, and nothing where it moves or is none."""
    for make, off, locked in ((four_bar, 3e-3, True), (four_bar, 0.0, False), (box, 0.0, False)):
        mechanism = make()
        scene = lf.SpatialScene(gravity=GRAVITY)
        placed = [scene.add(lf.SpatialRigidBody(b.mass, b.inertia), position=b.place) for b in mechanism.bodies]
        for k, joint in enumerate(mechanism.joints):
            P, Q = (
                scene.ground.at(*joint.r_p) if b == GROUND else placed[b].at(*(joint.r_p - mechanism.bodies[b].place))
                for b in joint.bodies
            )
            axis = (off if k == 1 else 0.0, off if k == 2 else 0.0, 1.0)
            scene.join(lf.Weld(P, Q) if joint.kind == "weld" else lf.Revolute(P, Q, axis=axis))
        with warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always")
            result = lf.simulate(scene, 0.01, lf.MoreauJean(step=1e-3))
        assert (result.energies.kinetic.max() > 1e-3) == (make is four_bar and not locked)
        assert any("leave the bodies no motion" in str(one.message) for one in told) == locked
        assert any("leave the bodies no motion" in text for text in result.warnings) == locked
