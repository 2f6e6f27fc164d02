"""Reactions of joints against closed forms and the laws of Newton and Euler for each body."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.jit.kernel import FloatArray

G = 10.0
STEPPERS = [lf.EventDriven(), lf.Smooth(), lf.MoreauJean(1e-3), lf.GeneralizedAlpha(1e-3), lf.MasslessBoundary(1e-3)]
MEANS = (lf.MoreauJean, lf.GeneralizedAlpha, lf.MasslessBoundary)


def run(scene: lf.Scene, stepper: Any, duration: float = 0.2, record: float | None = 1e-3) -> lf.Result:
    return lf.simulate(scene, duration, stepper, record=record, progress=False)


def cross(r: FloatArray, f: FloatArray) -> FloatArray:
    return r[..., 0] * f[..., 1] - r[..., 1] * f[..., 0]


@pytest.mark.parametrize("stepper", STEPPERS, ids=lambda s: type(s).__name__)
def test_pendulum(stepper: Any) -> None:
    """Weight and centripetal force, at an instant or as the mean of a millisecond."""
    m, inertia, length = 2.0, 0.3, 0.7
    scene = lf.Scene(gravity=(0, -G))
    place = (length * math.sin(1.0), -length * math.cos(1.0))
    bob = scene.add(lf.RigidBody(mass=m, inertia=inertia), "bob", position=place, angle=1.0)
    scene.join(lf.Revolute(bob.at(0, length), scene.ground.at(0, 0), name="hinge"))
    result = run(scene, stepper)
    angle, omega = result.q[:, 2], result.u[:, 2]
    alpha = -m * G * length * np.sin(angle) / (inertia + m * length**2)
    radial, along = (np.column_stack(e) for e in ((-np.sin(angle), np.cos(angle)), (np.cos(angle), np.sin(angle))))
    exact = m * length * (alpha[:, None] * along + omega[:, None] ** 2 * radial) + [0.0, m * G]
    if isinstance(stepper, MEANS):
        exact[1:] = 0.5 * (exact[1:] + exact[:-1])
    hinge = result.reaction("hinge")
    error = np.abs(hinge.force - exact)[1:].max() / (m * G)
    assert error < (1e-3 if isinstance(stepper, lf.MoreauJean | lf.MasslessBoundary) else 1e-5)
    assert hinge.largest_force[1:] == pytest.approx(np.hypot(*exact[1:].T), rel=2e-3)
    assert hinge.unique.all()
    assert not hinge.moment[1:].any()
    assert not hinge.impulse.any()


def test_means_are_those_of_the_whole_interval() -> None:
    """F dt over a swing is the change of momentum less that by the weight, with few instants and with many."""
    m, length = 2.0, 0.7
    for stepper in (lf.MoreauJean(1e-3), lf.GeneralizedAlpha(1e-3), lf.MoreauJean(1e-3, adaptive=lf.AdaptiveStep())):
        for record in (0.01, 0.25):
            scene = lf.Scene(gravity=(0, -G))
            bob = scene.add(lf.RigidBody(mass=m, inertia=0.1), "bob", position=(length, 0.0))
            scene.join(lf.Revolute(bob.at(-length, 0), scene.ground.at(0, 0)))
            result = run(scene, stepper, 0.5, record)
            force = result.reaction("joint1").force
            impulse = (force[1:] * np.diff(result.times)[:, None]).sum(axis=0) - [0.0, m * G * 0.5]
            assert impulse == pytest.approx(m * (result.u[-1, :2] - result.u[0, :2]), abs=2e-3)


@pytest.mark.parametrize("stepper", STEPPERS, ids=lambda s: type(s).__name__)
def test_driven_crank(stepper: Any) -> None:
    """The torque of a drive at constant speed carries the weight of the crank, and its hinge the rest."""
    m, length, speed = 3.0, 0.4, 5.0
    scene = lf.Scene(gravity=(0, -G))
    start = {"velocity": (0.0, speed * length), "angular_velocity": speed}
    crank = scene.add(lf.RigidBody(mass=m, inertia=0.2), "crank", position=(length, 0.0), **start)
    scene.join(lf.Revolute(crank.at(-length, 0), scene.ground.at(0, 0), name="hinge"))
    scene.join(lf.DrivenAngle(crank.at(-length, 0), scene.ground.at(0, 0), lambda t: speed * t, name="drive"))
    result = run(scene, stepper)
    angle = speed * result.times
    torque, pull = m * G * length * np.cos(angle), m * length * speed**2
    force = np.column_stack([-pull * np.cos(angle), m * G - pull * np.sin(angle)])
    drive, hinge = result.reaction("drive"), result.reaction("hinge")
    rough = 6e-3 if isinstance(stepper, MEANS) else 1e-6
    assert drive.moment[2:] == pytest.approx(torque[2:], abs=rough * m * G)
    assert hinge.force[2:] == pytest.approx(force[2:], abs=rough * pull)
    assert not drive.force[1:].any()
    assert not hinge.moment[1:].any()


KINDS: dict[str, Callable[[Any, Any], Any]] = {
    "Revolute": lambda P, Q: lf.Revolute(P, Q, name="joint"),
    "Weld": lambda P, Q: lf.Weld(P, Q, name="joint"),
    "Prismatic": lambda P, Q: lf.Prismatic(P, Q, axis=(0.6, 0.8), name="joint"),
    "PointOnLine": lambda P, Q: lf.PointOnLine(P, Q, axis=(0.6, 0.8), name="joint"),
    "Distance": lambda P, Q: lf.Distance(P, Q, name="joint"),
    "DrivenAngle": lambda P, Q: lf.DrivenAngle(P, Q, lambda t: 0.5 * t * t, name="joint"),
    "DrivenDisplacement": lambda P, Q: lf.DrivenDisplacement(P, Q, lambda t: 0.3 * t * t, (0.6, 0.8), name="joint"),
}


def along(kind: str) -> tuple[float, float]:
    """Where Q is, away from P along what the joint leaves free."""
    return {"Prismatic": (0.3, 0.4), "PointOnLine": (0.3, 0.4), "Distance": (0.3, -0.2)}.get(kind, (0.0, 0.0))


@pytest.mark.parametrize("swapped", [False, True], ids=["between bodies", "swapped"])
@pytest.mark.parametrize("kind", KINDS)
def test_newton_and_euler_for_each_body(kind: str, swapped: bool) -> None:
    """m a = F + weight and J alpha = M + r x F with the force at P, for the body of P; the opposite for that of Q."""
    masses, inertias = (2.0, 3.0), (0.3, 0.5)
    starts = [((0.1, 0.2), 0.4), ((1.0, -0.3), -0.2)]
    scene = lf.Scene(gravity=(1.0, -G))
    bodies = [
        scene.add(lf.RigidBody(mass=m, inertia=j), f"b{k}", position=place, angle=angle)
        for k, (m, j, (place, angle)) in enumerate(zip(masses, inertias, starts, strict=True))
    ]
    shift = np.array(along(kind))
    p = np.array([0.5, 0.1])  # P in the world; Q is beside it, in axes of the body of Q
    angle = starts[1 - swapped][1]
    turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
    order = (1, 0) if swapped else (0, 1)
    first, second = (bodies[k] for k in order)
    joint = KINDS[kind](local(first, starts[order[0]], p), local(second, starts[order[1]], p - turn @ shift))
    scene.join(joint)
    scene.load(lf.Force(bodies[0].at(0.1, 0.2), (5.0, 3.0)))
    scene.load(lf.Torque(bodies[1].at(0.0, 0.0), 2.0))
    result = run(scene, lf.EventDriven(rtol=1e-12), 0.02, 1e-4)
    rate = (result.u[2:] - result.u[:-2]) / 2e-4
    reaction = result.reaction("joint")
    force, moment = reaction.force[1:-1], reaction.moment[1:-1]
    place = result.point(f"b{order[0]}", tuple(np.array(inverse(starts[order[0]], p))))[1:-1]
    extra = {0: np.array([5.0, 3.0]), 1: np.zeros(2)}
    for sign, k in ((1.0, order[0]), (-1.0, order[1])):
        centre, acceleration, alpha = result.q[1:-1, 3 * k : 3 * k + 2], rate[:, 3 * k : 3 * k + 2], rate[:, 3 * k + 2]
        outside = masses[k] * np.array([1.0, -G]) + extra[k]
        assert masses[k] * acceleration == pytest.approx(sign * force + outside, abs=2e-5)
        at_load = result.point(f"b{k}", (0.1, 0.2))[1:-1] - centre
        torque = cross(at_load, extra[k] + 0.0 * at_load) + (2.0 if k == 1 else 0.0)
        turned = sign * (moment + cross(place - centre, force)) + torque
        assert inertias[k] * alpha == pytest.approx(turned, abs=2e-5)


def inverse(start: tuple[tuple[float, float], float], p: FloatArray) -> tuple[float, float]:
    """A place of the world in the frame of a body."""
    (x, y), angle = start
    dx, dy = p[0] - x, p[1] - y
    return math.cos(angle) * dx + math.sin(angle) * dy, math.cos(angle) * dy - math.sin(angle) * dx


def local(body: lf.Placed, start: tuple[tuple[float, float], float], p: FloatArray) -> Any:
    return body.at(*inverse(start, p))


def parallelogram(cranks: int, spin: float = 2.0, lengths: float = 1.0, mass: float = 1.0, g: float = 1.0) -> lf.Scene:
    """A platform on parallel cranks of 0.5 m, 1 m apart, each hinged at both ends; all but two are redundant."""
    scene = lf.Scene(gravity=(0, -g * G))
    angle = 0.6
    end = 0.5 * lengths * np.array([math.cos(angle), math.sin(angle)])
    across = spin * np.array([-end[1], end[0]])
    middle = 0.5 * (cranks - 1) * lengths
    body = lf.RigidBody(mass=5.0 * mass, inertia=1.0 * mass * lengths**2)
    place = (end[0] + middle - 0.2 * lengths, end[1] + 0.1 * lengths)
    platform = scene.add(body, "platform", position=place, velocity=across)
    body = lf.RigidBody(mass=mass, inertia=0.02 * mass * lengths**2)
    for k in range(cranks):
        foot = np.array([k * lengths, 0.0])
        start = {"position": foot + 0.5 * end, "velocity": 0.5 * across, "angular_velocity": spin}
        crank = scene.add(body, f"crank{k}", angle=angle, **start)
        scene.join(lf.Revolute(crank.at(-0.25 * lengths, 0), scene.ground.at(*foot), name=f"foot{k}"))
        top = (k * lengths - middle + 0.2 * lengths, -0.1 * lengths)
        scene.join(lf.Revolute(crank.at(0.25 * lengths, 0), platform.at(*top), name=f"head{k}"))
    return scene


def least(result: lf.Result, cranks: int, i: int) -> FloatArray:
    """Forces at feet and heads of least norm that give the accelerations at instant i, by Newton and Euler."""
    step = result.times[i + 1] - result.times[i]
    rate = (result.u[i + 1] - result.u[i - 1]) / (2.0 * step)
    q = result.q[i]
    mass = [5.0, *[1.0] * cranks]
    inertia = [1.0, *[0.02] * cranks]
    rows, right = np.zeros((3 * cranks + 3, 4 * cranks)), np.zeros(3 * cranks + 3)
    for b in range(cranks + 1):
        right[3 * b : 3 * b + 3] = [
            mass[b] * rate[3 * b],
            mass[b] * (rate[3 * b + 1] + G),
            inertia[b] * rate[3 * b + 2],
        ]
    for k in range(cranks):
        for joint, (body, name) in enumerate(((f"crank{k}", (-0.25, 0.0)), (f"crank{k}", (0.25, 0.0)))):
            r = result.point(body, name)[i]
            at = 4 * k + 2 * joint
            for b, sign in ((k + 1, 1.0), *(((0, -1.0),) if joint else ())):
                arm = r - q[3 * b : 3 * b + 2]
                rows[3 * b, at] = rows[3 * b + 1, at + 1] = sign
                rows[3 * b + 2, at : at + 2] = sign * np.array([-arm[1], arm[0]])
    assert np.linalg.matrix_rank(rows) == 3 * cranks + 3 - 1  # one motion is free
    answer: FloatArray = np.linalg.lstsq(rows, right, rcond=1e-10)[0]
    return answer.reshape(cranks, 2, 2)


@pytest.mark.parametrize("cranks", [3, 4])
def test_redundant_parallelogram(cranks: int) -> None:
    """Of all reactions with this motion the least, and marked; the motion is that of two cranks."""
    result = run(parallelogram(cranks), lf.EventDriven(rtol=1e-11), 0.1, 2e-4)
    stepped = run(parallelogram(cranks), lf.MoreauJean(1e-4), 0.1, 1e-4)
    for i in (50, 250, 450):
        exact = least(result, cranks, i)
        for k in range(cranks):
            for joint, name in enumerate((f"foot{k}", f"head{k}")):
                reaction = result.reaction(name)
                assert reaction.force[i] == pytest.approx(exact[k, joint], abs=2e-4)
                assert not reaction.unique[i]
                assert reaction.largest_force[i] == pytest.approx(np.hypot(*exact[k, joint]), abs=3e-4)
                assert stepped.reaction(name).force[2 * i] == pytest.approx(exact[k, joint], abs=0.05)
    plain = run(parallelogram(2), lf.EventDriven(rtol=1e-11), 0.1, 1e-3)
    assert plain.reaction("foot0").unique.all()


def test_moments_count_by_the_extent_of_the_largest_body() -> None:
    """A bar welded to the ground at both ends: of the three unknown moments and forces the least."""
    scene = lf.Scene(gravity=(3.0, -G))
    bar = scene.add(lf.Box(2.0, 0.1, mass=4.0), "bar", position=(0.3, 0.1))
    places = (-0.8, 1.0)
    for k, x in enumerate(places):
        scene.join(lf.Weld(bar.at(x, 0.0), scene.ground.at(0.3 + x, 0.1), name=f"weld{k}"))
    balance = np.zeros((3, 6))
    for k, x in enumerate(places):
        balance[:, 3 * k : 3 * k + 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, x, 1.0]]
    for stepper in (lf.MoreauJean(1e-3), lf.EventDriven()):
        result = run(scene, stepper, 0.01)
        assert result.compiled is not None
        units = np.array([1.0, 1.0, result.compiled.size] * 2)
        exact = units * np.linalg.lstsq(balance * units, np.array([-12.0, 4.0 * G, 0.0]), rcond=None)[0]
        for k in range(2):
            weld = result.reaction(f"weld{k}")
            assert weld.force[-1] == pytest.approx(exact[3 * k : 3 * k + 2], abs=1e-8)
            assert weld.moment[-1] == pytest.approx(exact[3 * k + 2], abs=1e-8)
            assert not weld.unique[-1]


def test_only_what_is_shared_is_marked() -> None:
    """A pendulum beside a redundant parallelogram is determined, and so is the part of a chain that hangs on it."""
    scene = parallelogram(3)
    beside = scene.add(lf.RigidBody(mass=1.0, inertia=0.1), "beside", position=(9.0, 0.0))
    scene.join(lf.Revolute(beside.at(0.5, 0.0), scene.ground.at(9.5, 0.0), name="own"))
    below = scene.add(lf.RigidBody(mass=1.0, inertia=0.1), "below", position=(-3.0, -3.0))
    scene.join(lf.Revolute(below.at(0.0, 0.5), scene.body("beside").at(-12.0, -2.5), name="hanging"))
    result = run(scene, lf.MoreauJean(1e-3), 0.01)
    assert [result.reaction(name).unique.all() for name in ("own", "hanging", "foot1")] == [True, True, False]


def test_least_reactions_in_other_units() -> None:
    """In millimetres and tonnes forces are the same numbers, and so is what is unique."""
    results = [run(parallelogram(3, *units), lf.EventDriven(), 0.05, 0.01) for units in ((2.0,), (2.0, 1e3, 1e-3, 1e3))]
    for name in ("foot0", "head1", "foot2"):
        metres, millimetres = (result.reaction(name) for result in results)
        assert millimetres.force == pytest.approx(metres.force, rel=1e-6)
        assert (millimetres.unique == metres.unique).all()


def stop(e: float) -> lf.Scene:
    """A bar of 1 m and 3 kg, hinged at its end, falls with its middle onto a stop."""
    scene = lf.Scene(gravity=(0, -G))
    start = {"velocity": (0.0, -1.0), "angular_velocity": -2.0}
    bar = scene.add(lf.RigidBody(mass=3.0, inertia=0.25), "bar", position=(0.5, 0.0), **start)
    scene.join(lf.Revolute(bar.at(-0.5, 0), scene.ground.at(0, 0), name="hinge"))
    scene.contact(bar.node(0.3, 0.0), scene.ground.half_plane((0.0, -0.1), (0.0, 1.0)), restitution=e, name="stop")
    return scene


@pytest.mark.parametrize("e", [0.0, 0.5])
def test_impulses_stand_apart(e: float) -> None:
    """An impact at 0.8 m: p = (1 + e) J omega / 0.8; the hinge takes what the change of momentum leaves over."""
    for stepper, rough in ((lf.EventDriven(), 1e-6), (lf.MoreauJean(1e-4), 2e-2), (lf.GeneralizedAlpha(1e-4), 2e-2)):
        result = run(stop(e), stepper, 0.1, 0.005)
        hinge = result.reaction("hinge")
        k = int(np.argmax(np.abs(hinge.impulse[:, 1]) > 0.1))
        assert not hinge.impulse[: k - 1].any()
        energy = 0.5 * 1.0 * 4.0 + 3.0 * G * 0.5 * 0.1 / 0.8 * np.array([0.9, 1.1])
        omega = np.sqrt(2.0 * energy)
        lever = math.sqrt(0.8**2 - 0.1**2)
        taken = (1.0 + e) * omega * (3.0 * 0.5 - 1.0 / lever)
        assert taken[0] * 0.97 < hinge.impulse[k, 1] < taken[1] * 1.03
        assert hinge.largest_force[1:].max() < 80.0  # p / h would be 1e4 times as much
        assert result.reaction("hinge").impulse[-1, 1] >= hinge.impulse[k, 1] * (1.0 - rough)


def with_balls(count: int) -> lf.Scene:
    """A redundant parallelogram, and balls that fall on a floor far away."""
    scene = parallelogram(3)
    floor = scene.ground.half_plane((0.0, -50.0), (0.0, 1.0))
    for k in range(count):
        ball = scene.add(lf.Disc(0.1, mass=1.0), f"ball{k}", position=(k, -49.85), velocity=(0.0, -1.0))
        scene.contact(ball.surface(), floor, restitution=0.8)
    return scene


def test_an_impact_elsewhere_takes_no_force_away() -> None:
    """One contact, which makes no islands, and several."""
    alone, *others = (run(with_balls(count), lf.MoreauJean(1e-3), 0.1) for count in (0, 1, 3))
    assert alone.joint_force is not None
    for other in others:
        assert other.impulse[-1, 0, 0] > 1.0
        assert np.array_equal(other.joint_force, alone.joint_force, equal_nan=True)  # type: ignore[arg-type]
        assert not np.any(other.joint_impulse)


def test_an_impact_is_told_of_the_joints_that_it_reaches() -> None:
    """A ball on a welded plank: it reaches the weld, but not what hangs on the plank; and a lever beside is struck."""
    scene = stop(0.5)
    plank = scene.add(lf.Box(1.0, 0.1, mass=1.0), "plank", position=(5.0, 0.0))
    scene.join(lf.Weld(plank.at(0.0, 0.0), scene.ground.at(5.0, 0.0), name="weld"))
    rider = scene.add(lf.RigidBody(mass=1.0, inertia=0.1), "rider", position=(4.5, -0.5))
    scene.join(lf.Revolute(rider.at(0.0, 0.5), plank.at(-0.5, 0.0), name="rider"))
    ball = scene.add(lf.Disc(0.1, mass=1.0), "ball", position=(5.2, 0.155), velocity=(0.0, -1.0))
    scene.contact(ball.surface(), plank.surface(), restitution=0.5, name="ball")
    result = run(scene, lf.MoreauJean(1e-3), 0.07)
    weld, hinge, hanging = (result.reaction(name) for name in ("weld", "hinge", "rider"))
    strikes = [np.flatnonzero(np.isnan(one.moment[1:])) for one in (weld, hinge, hanging)]
    assert [len(steps) for steps in strikes] == [1, 1, 0]
    assert strikes[0] != strikes[1]  # each has the force of the step in which only the other is struck
    assert hanging.force[1:] == pytest.approx(np.tile([0.0, G], (70, 1)), abs=1e-9)
    assert not hanging.impulse.any()
    struck = result.contact("ball").impulse[-1, 0]
    assert weld.impulse[-1, 1] == pytest.approx(struck + 2.0 * G * 1e-3, rel=1e-9)
    assert hinge.impulse[-1, 1] > 0.5


def test_a_resting_contact_is_no_impact() -> None:
    """A lever rests on a stop from the start: its hinge has a force at once, and no impulse."""
    scene = lf.Scene(gravity=(0, -G))
    bar = scene.add(lf.RigidBody(mass=3.0, inertia=0.25), "bar", position=(0.5, 0.0))
    scene.join(lf.Revolute(bar.at(-0.5, 0), scene.ground.at(0, 0), name="hinge"))
    scene.contact(bar.node(0.3, 0.0), scene.ground.half_plane((0.0, 0.0), (0.0, 1.0)), name="stop")
    for stepper in (lf.MoreauJean(1e-3), lf.EventDriven(), lf.GeneralizedAlpha(1e-3)):
        hinge = run(scene, stepper, 0.05).reaction("hinge")
        assert hinge.force[2:, 1] == pytest.approx(np.full(len(hinge.times) - 2, 3.0 * G * (1.0 - 0.5 / 0.8)), abs=1e-6)
        assert hinge.impulse == pytest.approx(np.zeros((len(hinge.times), 2)), abs=1e-12)


@pytest.mark.parametrize("scatter", [0.0, 0.02, 0.1])
@pytest.mark.parametrize("masses", [(1.0, 1.0), (1e-3, 1e3)])
def test_a_braced_frame(scatter: float, masses: tuple[float, float]) -> None:
    """26 more bars than hold it. Rounding hides some dependent rows: the forces are the least all the same.

    A mean over several steps is then that of the means of each, as hinges keep their directions.
    """
    scene = frame(5, scatter, masses)
    each, whole = (run(scene, lf.MoreauJean(1e-3), 0.01, record) for record in (1e-3, 0.01))
    assert each.joint_force is not None
    assert whole.joint_force is not None
    force = each.joint_force[1:, :, :2]
    effect = effects(each)
    null = np.linalg.svd(effect)[2][np.linalg.matrix_rank(effect, tol=1e-9 * np.abs(effect).max()) :]
    assert len(null) == 26
    for instant in force:
        assert null @ instant.ravel() == pytest.approx(np.zeros(26), abs=1e-6 * np.abs(instant).max())
    assert whole.joint_force[-1, :, :2] == pytest.approx(force.mean(axis=0), abs=1e-6 * np.abs(force).max())
    weight = -G * sum(float(m) for m in np.asarray(each.compiled.model.bodies.mass))  # type: ignore[union-attr]
    ground = [k for k, name in enumerate(each.compiled.layout.joints) if name.startswith("held")]  # type: ignore[union-attr]
    assert force[:, ground, 1].sum(axis=1) == pytest.approx(np.full(len(force), -weight), rel=1e-6)


def frame(k: int, scatter: float, masses: tuple[float, float]) -> lf.Scene:
    """k x k nodes, all next ones joined by bars, the diagonals too; two nodes are held. It cannot move."""
    rng = np.random.default_rng(0)
    nodes = {(i, j): np.array([i, j]) + scatter * rng.standard_normal(2) for i in range(k) for j in range(k)}
    ways = [(1, 0), (0, 1), (1, 1), (1, -1)]
    bars = [(n, (n[0] + i, n[1] + j)) for n in nodes for i, j in ways if (n[0] + i, n[1] + j) in nodes]
    scene = lf.Scene(gravity=(0, -G))
    first: dict[tuple[int, int], Any] = {n: scene.ground.at(*nodes[n]) for n in ((0, 0), (1, 0))}
    for b, (start, end) in enumerate(bars):
        d = nodes[end] - nodes[start]
        length, mass = float(np.hypot(*d)), masses[b % 2]
        body = lf.RigidBody(mass=mass, inertia=mass * length**2 / 12)
        bar = scene.add(body, f"bar{b}", position=0.5 * (nodes[start] + nodes[end]), angle=math.atan2(d[1], d[0]))
        for node, x in ((start, -0.5 * length), (end, 0.5 * length)):
            if node in first:
                name = f"{'held' if node in ((0, 0), (1, 0)) else 'hinge'} {b} {'end' if x > 0.0 else 'start'}"
                scene.join(lf.Revolute(bar.at(x, 0.0), first[node], name=name))
            else:
                first[node] = bar.at(x, 0.0)
    return scene


def effects(result: lf.Result) -> FloatArray:
    """What unit forces in x and y of each hinge do to the bodies: force and moment about their centres."""
    assert result.compiled is not None
    model, q = result.compiled.model, result.q[0]
    effect = np.zeros((len(q), 2 * len(model.joints.point)))
    for joint, ends in enumerate(model.joints.point):
        for point, sign in zip(ends, (1.0, -1.0), strict=True):
            b = int(model.points.body[point])
            if b >= 0:
                (x, y), angle = model.points.place[point], q[3 * b + 2]
                arm = math.cos(angle) * x - math.sin(angle) * y, math.sin(angle) * x + math.cos(angle) * y
                effect[3 * b : 3 * b + 3, 2 * joint] += sign * np.array([1.0, 0.0, -arm[1]])
                effect[3 * b : 3 * b + 3, 2 * joint + 1] += sign * np.array([0.0, 1.0, arm[0]])
    return effect
