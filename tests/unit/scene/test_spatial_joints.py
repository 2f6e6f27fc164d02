"""Joints and loads of spatial scenes: rows, assembly, projection, springs, and what is refused."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import lcpflex as lf
from lcpflex.dynamics import start
from lcpflex.dynamics.mass_matrix import mass_matrix
from lcpflex.jit.kernel import FloatArray
from lcpflex.jit.struct import pack
from lcpflex.kinematics.configuration import advance
from lcpflex.kinematics.spatial.joint_rows import joint_residual
from tests.solids import block

AXIS = (2.0, -1.0, 2.0)
HINGE = (0.7, -0.2, 0.4)  # where P and Q meet, world axes
TILTED = Rotation.from_rotvec([0.3, -0.5, 0.2])
TURNED = Rotation.from_rotvec([-0.4, 0.1, 0.9])
Maker = Callable[[Any, Any], Any]

JOINTS: dict[str, tuple[Maker, int]] = {
    "Ball": (lambda P, Q: lf.Ball(P, Q), 3),
    "Revolute": (lambda P, Q: lf.Revolute(P, Q, axis=AXIS), 5),
    "Weld": (lambda P, Q: lf.Weld(P, Q), 6),
    "Universal": (lambda P, Q: lf.Universal(P, Q, axis=AXIS, axis_p=partner(AXIS, (1.0, 2.0, 0.0))), 4),
    "Cylindrical": (lambda P, Q: lf.Cylindrical(P, Q, AXIS), 4),
    "Prismatic": (lambda P, Q: lf.Prismatic(P, Q, AXIS), 5),
    "Planar": (lambda P, Q: lf.Planar(P, Q, AXIS), 3),
    "PointOnPlane": (lambda P, Q: lf.PointOnPlane(P, Q, AXIS), 1),
    "PointOnLine": (lambda P, Q: lf.PointOnLine(P, Q, AXIS), 2),
    "DrivenAngle": (lambda P, Q: lf.DrivenAngle(P, Q, 0.0, axis=AXIS), 1),
    "DrivenDisplacement": (lambda P, Q: lf.DrivenDisplacement(P, Q, 0.0, AXIS), 1),
}


def partner(axis: Any, across: Any) -> FloatArray:
    """Of an axis at Q, seen from P: a direction across it."""
    return (TURNED.inv() * TILTED).apply(np.cross(axis, across))


def pair(grounded: bool = False, apart: Any = (0.0, 0.0, 0.0)) -> tuple[lf.SpatialScene, Any, Any]:
    """A scene with two tilted bodies (or one and the ground), and points P, Q of them, ``apart`` from each other."""
    scene = lf.SpatialScene()
    frames = []
    for place, turn in (((0.1, 0.0, 0.3), TURNED), ((1.0, 0.2, -0.1), TILTED)):
        body = lf.Cuboid(0.3, 0.2, 0.1, density=1000.0)
        frames.append((scene.add(body, position=place, orientation=turn), np.array(place), turn))
    first, place, turn = frames[0]
    P = first.at(*turn.inv().apply(np.add(HINGE, apart) - place))
    second, place, turn = frames[1]
    Q = scene.ground.at(*HINGE) if grounded else second.at(*turn.inv().apply(np.array(HINGE) - place))
    return scene, P, Q


def jacobian(model: Any, q: FloatArray) -> tuple[FloatArray, FloatArray]:
    found = start.violation(model, q, np.zeros(len(q) - len(model.bodies.mass)), np.zeros((0, 3)))
    return found.jacobian, found.position


@pytest.mark.parametrize("grounded", [False, True])
@pytest.mark.parametrize("kind", JOINTS)
def test_each_joint_has_its_rows_and_is_fulfilled_where_it_was_assembled(kind: str, grounded: bool) -> None:
    """As many independent rows as the table of joints says, none violated."""
    if grounded and kind == "Universal":
        pytest.skip("the axis at P is given for two bodies")
    maker, count = JOINTS[kind]
    scene, P, Q = pair(grounded)
    scene.join(maker(P, Q))
    compiled = scene.compile()
    J, phi = jacobian(compiled.model, compiled.q.copy())
    assert J.shape[0] == count
    assert np.linalg.matrix_rank(J, tol=1e-8) == count
    assert np.abs(phi).max() < 1e-12


@pytest.mark.parametrize("kind", [*JOINTS, "Distance"])
def test_projection_is_quadratic(kind: str) -> None:
    """Violations v, from 2e-2 m and rad off, in the metric of mass: the next is below 10 v^2 (bodies of 0.1 m)."""
    scene, P, Q = pair(apart=(0.3, 0.1, -0.2) if kind == "Distance" else (0.0, 0.0, 0.0))
    scene.join(lf.Distance(P, Q) if kind == "Distance" else JOINTS[kind][0](P, Q))
    compiled = scene.compile()
    model = pack(compiled.model)
    random = np.random.default_rng(4)
    q = compiled.q.copy()
    advance(model, q, random.uniform(-1.0, 1.0, len(compiled.u)), 2e-2, q)
    sizes = []
    for _ in range(4):
        J, phi = jacobian(compiled.model, q)
        sizes.append(float(np.abs(phi).max()))
        M = mass_matrix(compiled.model, q)
        spread = np.linalg.solve(M, J.T)
        advance(model, q, -spread @ np.linalg.lstsq(J @ spread, phi, rcond=1e-12)[0], 1.0, q)
    assert 1e-3 < sizes[0] < 1e-1
    for before, after in pairwise(sizes):
        assert after < 10.0 * before**2 + 1e-14
    assert sizes[3] < 1e-9


def test_what_was_given_at_p_is_held_against_the_axis_at_q() -> None:
    """A small misfit is a violation that is said or projected away; opposite axes and far orientations are refused."""
    at_p = (TURNED.inv() * TILTED).apply(AXIS)
    off = Rotation.from_rotvec(1e-3 * np.array([0.0, 0.6, 0.8])).apply(at_p)
    cases: list[tuple[Maker, str]] = [
        (lambda P, Q: lf.Revolute(P, Q, axis=AXIS, axis_p=off), "violates it by 0.00"),
        (lambda P, Q: lf.Revolute(P, Q, axis=AXIS, axis_p=-at_p), "axis_p: it is 180 degrees from axis"),
        (lambda P, Q: lf.Cylindrical(P, Q, axis=AXIS, axis_p=-off), "the other sign"),
        (lambda P, Q: lf.Planar(P, Q, axis=AXIS, axis_p=-off), "expected the same direction"),
        (lambda P, Q: lf.Universal(P, Q, axis=AXIS, axis_p=at_p), "expected right angles"),
        (
            lambda P, Q: lf.Weld(P, Q, orientation=TILTED.inv() * TURNED * Rotation.from_rotvec([0.0, 0.6, 0.0])),
            "34.4 degrees from the one that was given",
        ),
        (lambda P, Q: lf.Prismatic(P, Q, AXIS, orientation=np.eye(3)), "orientation: the start is"),
    ]
    for maker, words in cases:
        scene, P, Q = pair()
        scene.join(maker(P, Q))
        with pytest.raises(lf.ModelError, match=words):
            scene.compile()
    for fine in (
        lambda P, Q: lf.Revolute(P, Q, axis=AXIS, axis_p=at_p),
        lambda P, Q: lf.Weld(P, Q, orientation=TILTED.inv() * TURNED),
        lambda P, Q: lf.Prismatic(P, Q, AXIS, orientation=(TILTED.inv() * TURNED).as_matrix()),
    ):
        scene, P, Q = pair()
        scene.join(fine(P, Q))
        scene.compile()
    scene, P, Q = pair()
    scene.join(lf.Revolute(P, Q, axis=AXIS, axis_p=off))
    moved = scene.compile(project=True)
    _, phi = jacobian(moved.model, moved.q.copy())
    assert np.abs(phi).max() < 1e-11


def test_an_orientation_that_was_given_is_the_relative_rotation() -> None:
    """A start a little off is projected onto A_Q^T A_P = orientation."""
    wanted = TILTED.inv() * TURNED * Rotation.from_rotvec([0.02, -0.01, 0.03])
    scene, P, Q = pair()
    scene.join(lf.Weld(P, Q, orientation=wanted))
    compiled = scene.compile(project=True)
    turns = [Rotation.from_quat(np.roll(compiled.q[7 * b + 3 : 7 * b + 7], -1)) for b in range(2)]
    np.testing.assert_allclose((turns[1].inv() * turns[0]).as_matrix(), wanted.as_matrix(), atol=1e-10)


@pytest.mark.parametrize("turn", [0.4, -3.0, 3.1])
def test_angles_are_counted_from_the_start_or_from_parallel_axes(turn: float) -> None:
    """DrivenAngle(angle=0) holds the relative angle itself, with an axis of the same components in both bodies."""
    axis = np.array(AXIS) / 3.0
    for angle, motion in ((None, 0.0), (0.0, turn), (turn, 0.0)):
        scene = lf.SpatialScene()
        a = scene.add(lf.Cuboid(0.3, 0.2, 0.1, density=1.0), orientation=TILTED * Rotation.from_rotvec(turn * axis))
        b = scene.add(lf.Cuboid(0.3, 0.2, 0.1, density=1.0), orientation=TILTED)
        scene.join(lf.Revolute(a.at(0, 0, 0), b.at(0, 0, 0), axis=axis))
        scene.join(lf.DrivenAngle(a.at(0, 0, 0), b.at(0, 0, 0), motion, angle, axis=axis))
        compiled = scene.compile()
        _, phi = jacobian(compiled.model, compiled.q.copy())
        assert abs(phi[-1]) < 1e-12


def test_a_drive_turns_by_what_it_is_told_over_many_turns() -> None:
    """Along f(t) = 12 rad of rotation about the axis the residual stays 0; a tenth of a rad off is a tenth off."""
    scene, P, Q = pair(grounded=True)
    scene.join(lf.DrivenAngle(P, Q, lambda t: (12.0 * t, 12.0, 0.0), axis=AXIS))
    compiled = scene.compile(project=True)  # the drive turns from the start on
    model = pack(compiled.model)
    u = np.zeros(len(compiled.u))
    u[3:6] = TURNED.inv().apply(np.array(AXIS) / 3.0)
    q, phi = compiled.q.copy(), np.zeros(1)
    for t in (0.1, 0.25, 0.6, 1.0):
        advance(model, compiled.q, u, 12.0 * t, q)
        joint_residual(model, t, q, np.array([[12.0 * t, 12.0, 0.0]]), phi)
        assert abs(phi[0]) < 1e-12
        joint_residual(model, t, q, np.array([[12.0 * t + 0.1, 12.0, 0.0]]), phi)
        assert math.isclose(phi[0], -0.1, abs_tol=1e-12)


def bad_cases() -> list[tuple[str, Callable[[], Any]]]:
    _, P, Q = pair()
    flat = lf.Scene()
    a = flat.add(lf.Box(1.0, 1.0, density=1.0)).at(0, 0)
    b = flat.ground.at(0, 0)
    return [
        ("axis: it was omitted", lambda: lf.Revolute(P, Q)),
        ("axis: it was omitted", lambda: lf.DrivenAngle(P, Q, 0.0)),
        ("axis: it was omitted", lambda: lf.TorsionSpring(P, Q, 1.0)),
        (r"expected shape \(3\)", lambda: lf.Revolute(P, Q, axis=(1.0, 0.0))),
        (r"expected shape \(3\)", lambda: lf.DrivenDisplacement(P, Q, 0.0, (1.0, 0.0))),
        ("not all 0", lambda: lf.Prismatic(P, Q, (0.0, 0.0, 0.0))),
        ("with nan in it", lambda: lf.Planar(P, Q, (0.0, math.nan, 0.0))),
        ("angle: 0.1 was given with points of a spatial", lambda: lf.Weld(P, Q, angle=0.1)),
        ("angle: 0.1 was given with points of a spatial", lambda: lf.Prismatic(P, Q, AXIS, angle=0.1)),
        ("with points of a planar", lambda: lf.Revolute(a, b, axis=(0.0, 0.0, 1.0))),
        ("with points of a planar", lambda: lf.Weld(a, b, orientation=np.eye(3))),
        ("with points of a planar", lambda: lf.TorsionSpring(a, b, 1.0, axis=(0.0, 0.0, 1.0))),
        ("with points of a planar", lambda: lf.Torque(a, 1.0, follower=True)),
        (r"expected shape \(2\)", lambda: lf.PointOnLine(a, b, AXIS)),
        ("point of a planar scene", lambda: lf.Ball(a, b)),
        ("point of a planar scene", lambda: lf.Universal(a, b, AXIS, AXIS)),
        ("point of a planar scene", lambda: lf.Bushing(a, b, 1.0)),
        ("and .* of a spatial one", lambda: lf.Revolute(a, Q)),
        ("and .* of a spatial one", lambda: lf.Spring(P, b, 1.0)),
        ("left-handed", lambda: lf.Weld(P, Q, orientation=-np.eye(3))),
        ("four numbers", lambda: lf.Weld(P, Q, orientation=(1.0, 0.0, 0.0, 0.0))),
        ("points of the same body", lambda: lf.Ball(P, P)),
        ("a triple", lambda: lf.Force(P, (1.0, 2.0))),
        ("a triple", lambda: lf.Torque(P, 1.0)),
        ("a pair", lambda: lf.Force(a, (1.0, 2.0, 3.0))),
        ("numbers >= 0", lambda: lf.Bushing(P, Q, (1.0, -1.0, 0.0))),
        ("angle: 4.0 was given", lambda: lf.TorsionSpring(P, Q, 1.0, angle=4.0, axis=AXIS)),
        ("angle: 4.0 was given", lambda: lf.DrivenAngle(P, Q, 0.0, angle=4.0, axis=AXIS)),
    ]


@pytest.mark.parametrize("number", range(28))
def test_what_cannot_be_is_refused_with_words(number: int) -> None:
    """Every message names what was wrong."""
    words, call = bad_cases()[number]
    with pytest.raises(lf.ModelError, match=words):
        call()
    assert len(bad_cases()) == 28


def test_joints_of_the_plane_and_of_space_do_not_mix() -> None:
    """Scenes take their own points only."""
    scene, P, Q = pair()
    flat = lf.Scene()
    with pytest.raises(lf.ModelError, match="expected a joint"):
        flat.join(lf.Ball(P, Q))
    with pytest.raises(lf.ModelError, match="not of another one"):
        flat.join(lf.Revolute(P, Q, axis=AXIS))
    box = flat.add(lf.Box(1.0, 1.0, density=1.0))
    with pytest.raises(lf.ModelError, match="not of another one"):
        scene.join(lf.Revolute(box.at(0, 0), flat.ground.at(0, 0)))
    with pytest.raises(lf.ModelError, match="not of another one"):
        scene.load(lf.Torque(box.at(0, 0), 1.0))


def test_springs_that_begin_nearly_half_a_turn_off_are_refused() -> None:
    """Whole turns cannot be told apart; from the start itself any spring may begin."""
    for make in (
        lambda a, b: lf.TorsionSpring(a, b, 1.0, angle=0.0, axis=(0.0, 0.0, 1.0)),
        lambda a, b: lf.Bushing(a, b, 1.0, 1.0, orientation=np.eye(3)),
    ):
        for degrees, fine in ((169.0, True), (171.0, False)):
            scene = lf.SpatialScene()
            body = scene.add(
                lf.Sphere(0.1, density=1.0), orientation=Rotation.from_rotvec([0, 0, degrees], degrees=True)
            )
            scene.load(make(body.at(0, 0, 0), scene.ground.at(0, 0, 0)))
            if fine:
                scene.compile()
                continue
            with pytest.raises(lf.ModelError, match="twisted by 171 degrees"):
                scene.compile()
    scene = lf.SpatialScene()
    body = scene.add(lf.Sphere(0.1, density=1.0), orientation=Rotation.from_rotvec([0, 0, 179], degrees=True))
    scene.load(lf.TorsionSpring(body.at(0, 0, 0), scene.ground.at(0, 0, 0), 1.0, axis=(0.0, 0.0, 1.0)))
    scene.load(lf.Bushing(body.at(0, 0, 0), scene.ground.at(0, 0, 0), 1.0, 1.0))
    scene.compile()


def test_nodes_on_one_line_hold_no_rotation() -> None:
    given = block((0.3, 0.2, 0.1), (2, 1, 1), "hex1")
    x, y, _ = given["coordinates"].T
    line = np.flatnonzero((x < 1e-9) & (y < 1e-9))
    face = np.flatnonzero(x < 1e-9)
    body = lf.SpatialMatrices(**given, node_sets={"line": line}).reduce(4)

    def compiled(of: Callable[[Any, Any], Any], nodes: Any = line) -> Any:
        scene = lf.SpatialScene()
        P = scene.add(body, name="solid").at_nodes(nodes)
        Q = scene.ground.at(*P.material.place)
        made = of(P, Q)
        (scene.load if isinstance(made, lf.Torque | lf.Force | lf.Spring) else scene.join)(made)
        return scene.compiled()

    held = lf.Revolute, lambda P, Q: lf.Weld(Q, P), lambda P, Q: lf.PointOnPlane(Q, P, (1, 0, 0))
    for turned in (*held, lambda P, Q: lf.Torque(P, (1.0, 0.0, 0.0))):
        make = (lambda P, Q: lf.Revolute(P, Q, axis=AXIS)) if turned is lf.Revolute else turned
        with pytest.raises(lf.ModelError, match=r"solid.at_nodes.* was given, whose nodes lie on one line"):
            compiled(make)
        compiled(make, face)
    compiled(lambda P, Q: lf.Ball(P, Q))
    compiled(lambda P, Q: lf.PointOnPlane(P, Q, (1, 0, 0)))
    compiled(lambda P, Q: lf.Force(P, (1.0, 0.0, 0.0)))
    scene = lf.SpatialScene()
    scene.join(lf.Ball(scene.add(body).point("line"), scene.ground.at(0, 0, 0)))
    with pytest.raises(lf.ModelError, match="nodes: the ground has no mesh"):
        scene.ground.at_nodes(3)


@pytest.mark.parametrize("stepper", [lf.MoreauJean(step=1e-3), lf.EventDriven()], ids=lambda one: type(one).__name__)
def test_a_run_that_winds_a_spring_ends_and_says_which(stepper: Any) -> None:
    """Not at 180 degrees with a force of the wrong sign."""
    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    wheel = scene.add(lf.Cuboid(0.2, 0.1, 0.1, density=1000.0), name="wheel", angular_velocity=(0.0, 0.0, 20.0))
    hinge, axle = wheel.at(0, 0, 0), scene.ground.at(0, 0, 0)
    scene.join(lf.Revolute(hinge, axle, axis=(0.0, 0.0, 1.0)))
    scene.load(lf.TorsionSpring(hinge, axle, 0.01, axis=(0.0, 0.0, 1.0)))
    with pytest.raises(lf.StepError, match=r"between wheel and the ground is twisted by 1(69|70)") as caught:
        lf.simulate(scene, 0.5, stepper, progress=False)
    assert abs(20.0 * caught.value.time - math.radians(170.0)) < 0.03
