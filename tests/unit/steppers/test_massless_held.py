"""Held bodies under the massless boundary: what is parted, what is stored, and the exact limit of the step."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.dynamics.held_modes import part_modes
from lcpflex.dynamics.mass_matrix import null_space
from lcpflex.model.arrays import Model
from lcpflex.model.planar import N_RIGID

STRIP = lf.Beam(0.5, 0.02, 0.004, 7850.0, 2.1e11)
LAW = lf.laws.PowerLaw(1e6, 1.0)


def welded(modes: int = 6, gravity: float = 9.81) -> lf.Scene:
    scene = lf.Scene(gravity=(0.0, -gravity))
    body = scene.add(STRIP, name="strip", modes=modes, damping=0.01)
    scene.join(lf.Weld(body.point("left"), scene.ground.at(0.0, 0.0)))
    scene.contact(body.surface("bottom"), scene.ground.circle((0.45, -0.0225), 0.02), name="stop")
    return scene


@pytest.mark.parametrize("hinged", [False, True])
def test_both_parts_have_the_compliance_of_all(hinged: bool) -> None:
    """Whatever may act, the frame's own motion apart: static modes move it, and do not move joints."""
    scene = lf.Scene()
    body = scene.add(STRIP, name="strip", modes=5)
    left = body.point("left")
    scene.join((lf.Revolute if hinged else lf.Weld)(left, scene.ground.at(0.0, 0.0)))
    scene.load(lf.Spring(body.point("right"), scene.ground.at(0.5, 1.0), stiffness=1e9))
    scene.contact(body.surface("bottom"), scene.ground.circle((0.3, -0.05), 0.02))
    compiled = scene.compiled(gives_way=True)
    given, system = compiled.model, compiled.system()
    flexibility = np.zeros(len(system.q))
    flexibility[N_RIGID + 5 :] = 1.0 / given.bodies.stiffness[5:]
    parted = part_modes(system.model, flexibility, system.q)
    model, static = parted.model, parted.flexibility[N_RIGID:] > 0.0
    assert static.any()
    assert not static[5:].all()
    turn = parted.turn[0]
    assert turn is not None
    assert not turn[:N_RIGID, ~static].any()
    for p in np.flatnonzero(given.points.body == 0):
        own = slice(given.points.start[p], given.points.start[p + 1])
        before, after = (
            np.column_stack([m.points.phi[own], m.points.psi[own]]) for m in (given, model)
        )  # fmt: skip
        x, y = given.points.place[p]
        after -= turn[:N_RIGID].T @ np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-y, x, 1.0]])
        whole = before.T @ (before / given.bodies.stiffness[:, None])
        scale = np.sqrt(np.outer(np.diag(whole), np.diag(whole))) + 1e-30
        assert (np.abs(after.T @ (after / model.bodies.stiffness[:, None]) - whole) < 1e-9 * scale).all()
    held = [(left.material.place, 2 if hinged else 3), (body.point("right").material.place, 2)]
    for place, ways in held:
        p = next(k for k in range(len(given.points.body)) if np.array_equal(given.points.place[k], place))
        own = slice(model.points.start[p], model.points.start[p + 1])
        ways_of = np.column_stack([model.points.phi[own], model.points.psi[own]])[:, :ways]
        assert np.abs(ways_of[static]).max() < 1e-9 * np.abs(ways_of).max()
    q = np.linspace(-1.0, 1.0, len(system.q))
    np.testing.assert_allclose(parted.former(parted.coordinates(q)), q, rtol=0, atol=1e-9)


def struck_along_its_axis(angle: float) -> lf.Scene:
    """A ball runs at the tip of a welded strip with one mode along its axis, which is not among the lowest."""
    axis = np.array([math.cos(angle), math.sin(angle)])
    scene = lf.Scene(gravity=(0.0, 0.0))
    body = scene.add(STRIP.reduce(14), name="strip", angle=angle)
    scene.join(lf.Weld(body.point("left"), scene.ground.at(0.0, 0.0)))
    ball = scene.add(lf.Disc(0.01, mass=0.1), name="ball", position=0.5101 * axis, velocity=-axis)
    scene.contact(body.node(0.5, 0.0), ball.circle((0.0, 0.0), 0.01), name="strike")
    return scene


def along_at(model: Model, x: float) -> np.ndarray:
    """Shapes of the modes along the axis of the strip, on it."""
    p = next(p for p, place in enumerate(model.points.place) if model.points.body[p] == 0 and (place == (x, 0.0)).all())
    return model.points.phi[model.points.start[p] : model.points.start[p + 1], 0]


@pytest.mark.parametrize("angle", [0.0, 0.7])
def test_contacts_along_an_axis_find_what_gives_way_there(angle: float) -> None:
    """The weld stops the foot, and the tip is free to give way by all that it has."""
    system = struck_along_its_axis(angle).compiled(gives_way=True).system()
    given = system.model
    flexibility = np.zeros(len(system.q))
    flexibility[N_RIGID + 4 : N_RIGID + 14] = 1.0 / given.bodies.stiffness[4:]
    parted = part_modes(given, flexibility, system.q)
    static = parted.flexibility[N_RIGID : N_RIGID + 14]
    whole = float(np.sum((along_at(given, 0.5) - along_at(given, 0.0)) ** 2 / given.bodies.stiffness))
    assert float(static @ along_at(parted.model, 0.5) ** 2) == pytest.approx(whole, rel=1e-9)
    assert float(static @ along_at(parted.model, 0.0) ** 2) < 1e-20 * whole
    q = np.linspace(-1.0, 1.0, len(system.q))
    np.testing.assert_allclose(parted.former(parted.coordinates(q)), q, rtol=0, atol=1e-9)


@pytest.mark.parametrize("angle", [0.0, 0.7])
def test_a_strike_along_the_axis_is_that_of_a_spring(angle: float) -> None:
    """No mass of the strip is in it: half a period of the ball on its static stiffness, and all of its speed back."""
    scene = struck_along_its_axis(angle)
    model = scene.compiled(gives_way=True).model
    give = np.sum((along_at(model, 0.5) - along_at(model, 0.0)) ** 2 / model.bodies.stiffness)
    half = math.pi * math.sqrt(0.1 * give)
    result = lf.simulate(scene, 1e-4 + 2.0 * half, lf.MasslessBoundary(), record=half / 200.0)
    touching = result.force[:, 0, 0] > 0.0
    assert np.ptp(result.times[touching]) == pytest.approx(half, rel=0.02)
    assert np.hypot(*result.velocity("ball", "center")[-1]) == pytest.approx(1.0, abs=2e-3)
    assert result.energies.relative_remainder < 2e-3
    apart = result.point("ball", "center") - result.point("strip", "right")  # of the states as they are stored
    assert np.abs(np.hypot(*apart.T)[touching] - 0.01).max() < 1e-9
    assert np.abs(result.point("strip", "left")).max() < 1e-9


def test_bodies_that_nothing_holds_keep_their_modes() -> None:
    scene = lf.Scene()
    body = scene.add(STRIP, name="strip", modes=5)
    scene.contact(body.surface("top"), scene.ground.circle((0.3, 1.0), 0.02))
    scene.load(lf.Spring(body.point("right"), scene.ground.at(0.5, 1.0), stiffness=1e-3))  # soft against any mode
    system = scene.compiled(gives_way=True).system()
    flexibility = np.where(np.arange(len(system.q)) >= N_RIGID + 5, 1e-9, 0.0)
    parted = part_modes(system.model, flexibility, system.q)
    assert parted.model is system.model
    assert parted.turn == (None,)


def test_states_are_stored_in_the_coordinates_of_the_body() -> None:
    """Energies of the stored states, by the equations of the scene, are those that the run has booked."""
    scene = welded()
    result = lf.simulate(scene, 0.03, lf.MasslessBoundary(), record=1e-4)
    touching = result.force[:, 0, 0] > 0.0
    assert touching.any()
    assert not touching.all()
    compiled = scene.compiled(gives_way=True)
    for k in range(0, len(result.times), 7):
        at = compiled.at(result.q[k], result.u[k], margin=0.0)
        in_contacts = 1e-3 if touching[k] else 1e-9  # they give way a little where the body is held
        assert 0.5 * at.q @ at.stiffness @ at.q == pytest.approx(result.energies.elastic[k], rel=in_contacts, abs=1e-12)
        assert 0.5 * at.u @ at.M @ at.u == pytest.approx(result.energies.kinetic[k], rel=1e-6, abs=1e-9)
    assert result.joint_drift.max() < 1e-12


def test_a_run_goes_on_from_its_own_end() -> None:
    def run(duration: float, after: lf.Result | None = None) -> lf.Result:
        scene = lf.Scene()
        body = lf.Beam(0.5, 0.02, 0.004, 7850.0, 2.1e11).reduce(12)
        given = {}
        if after is not None:
            q, u = after.q[-1], after.u[-1]
            given = {
                "position": q[:2], "angle": q[2], "modal": q[3:],
                "velocity": u[:2], "angular_velocity": u[2], "modal_velocity": u[3:],
            }  # fmt: skip
        strip = scene.add(body, name="strip", **given)
        scene.join(lf.Revolute(strip.point("left"), scene.ground.at(0.0, 0.0)))
        scene.contact(strip.surface("bottom"), scene.ground.circle((0.45, -0.5), 0.02))
        return lf.simulate(scene, duration, lf.MasslessBoundary(step=1e-6), record=1e-3, project=True)

    whole, half = run(0.02), run(0.01)
    rest = run(0.01, half)
    np.testing.assert_allclose(rest.q[-1], whole.q[-1], rtol=0, atol=1e-9)
    assert not rest.warnings or not any("static here" in text for text in rest.warnings)


def test_functions_of_the_state_see_the_body_as_it_is() -> None:
    scene = welded()
    tip = scene.body("strip").point("right")
    seen: dict[float, list[np.ndarray]] = {}

    def push(t: float, state: lf.State) -> tuple[float, float]:
        seen.setdefault(round(t, 12), []).append(state.position(tip))
        return 0.0, -1.0

    scene.load(lf.Force(tip, push))
    result = lf.simulate(scene, 2e-3, lf.MasslessBoundary(step=2e-6), record=1e-5)
    for t, place in zip(result.times[1:], result.point("strip", "right")[1:], strict=True):
        assert min(np.abs(given - place).max() for given in seen[round(float(t), 12)]) < 1e-12


def test_work_on_static_modes_is_booked() -> None:
    """A force that swings where the residual mode of a contact is, and the contact closes and opens."""
    scene = welded(gravity=0.0)
    scene.load(lf.Force(scene.body("strip").point("right"), (0.0, lf.Harmonic(4.0, 300.0))))
    result = lf.simulate(scene, 0.05, lf.MasslessBoundary(safety=0.1), record=1e-4)
    assert result.impulse[-1, 0, 0] > 0.0
    assert result.energies.relative_remainder < 2e-3


def exact_limit(scene: lf.Scene) -> float:
    """2/omega of the system with its joints held and no contact closed."""
    at = scene.compiled(gives_way=True).at(margin=0.0)
    Z = null_space(at.J)
    omega2 = np.linalg.eigvals(np.linalg.solve(Z.T @ at.M @ Z, Z.T @ at.stiffness @ Z)).real.max()
    return 2.0 / math.sqrt(omega2)


def moving(kind: str) -> lf.Scene:
    """All modes have mass: the contact gives way by itself."""
    scene = lf.Scene()
    body = scene.add(STRIP, name="strip", modes=6, angle=0.4 if kind == "slides" else 0.0)
    scene.contact(body.surface("bottom"), scene.ground.circle((0.3, -5.0), 0.02), name="stop")
    if kind == "welded":
        scene.join(lf.Weld(body.point("left"), scene.ground.at(0.0, 0.0)))
    elif kind == "slides":
        scene.join(lf.PointOnLine(body.point("left"), scene.ground.at(0.0, 0.0), (1.0, 0.0)))
    else:
        scene.join(lf.Revolute(body.point("left"), scene.ground.at(0.0, 0.0)))
        second = scene.add(STRIP, name="second", modes=4, position=(0.5, 0.0))
        scene.join(lf.Revolute(second.point("left"), body.point("right")))
        if kind == "redundant":
            scene.join(lf.PointOnLine(second.point("left"), body.point("right"), (1.0, 0.0)))
    return scene


@pytest.mark.parametrize("kind", ["welded", "slides", "chain", "redundant"])
def test_joints_are_in_the_limit_of_the_step(kind: str) -> None:
    """Modes that joints stop are several times as fast by themselves; found exactly, and stable up to it."""
    scene = moving(kind)
    limit = exact_limit(scene)
    alone = 2.0 / math.sqrt(scene.compiled(gives_way=True).model.bodies.stiffness.max())
    assert limit > (1.0 if kind == "slides" else 1.2) * alone

    def run(step: float) -> lf.Result:
        stepper = lf.MasslessBoundary(step, substeps=False, safety=1.0, compliance={"stop": LAW})
        return lf.simulate(scene, 100.0 * step, stepper)

    result = run(0.998 * limit)
    assert result.energies.relative_remainder < 0.2
    with pytest.raises(lf.StepError, match="admits") as caught:
        run(1.002 * limit)
    found = re.search(r"admits ([\d.e-]+) s", str(caught.value))
    assert found is not None
    assert float(found[1]) == pytest.approx(limit, rel=1e-4)


def dropped_beside_the_weld() -> lf.Scene:
    """Where static modes do not move; below, something is near that is never touched."""
    scene = lf.Scene()
    body = scene.add(STRIP, name="strip", modes=6)
    scene.join(lf.Weld(body.point("left"), scene.ground.at(0.0, 0.0)))
    ball = scene.add(lf.Disc(0.01, mass=0.1), name="ball", position=(0.0, 0.0121))
    scene.contact(body.surface("bottom"), scene.ground.circle((0.0, -0.022 - 1e-6), 0.02), friction=0.3, name="below")
    scene.contact(body.surface("top"), ball.circle((0.0, 0.0), 0.01), name="strike")
    return scene


def struck_where_held(by: str) -> lf.Scene:
    """The tip meets a stop where a spring pulls it, a stiff one or a soft one, or where a box hangs on it."""
    scene = lf.Scene()
    body = scene.add(STRIP, name="strip", modes=8)
    scene.join(lf.Revolute(body.point("left"), scene.ground.at(0.0, 0.0)))
    scene.contact(body.surface("bottom"), scene.ground.circle((0.5, -0.023), 0.02), name="strike")
    if by == "box":
        box = scene.add(lf.Box(0.02, 0.02, mass=0.1), "box", position=(0.5, 0.0))
        scene.join(lf.Weld(box.at(0.0, 0.0), body.point("right")))
    else:
        scene.load(lf.Spring(body.point("right"), scene.ground.at(0.5, -0.1), stiffness=float(by), length=0.09))
    return scene


@pytest.mark.parametrize("by", ["1e3", "1e4", "3e4", "box", "weld"])
def test_contacts_where_something_holds_the_body_keep_the_energy(by: str) -> None:
    """Nothing else gives way there, and what has mass strikes: without compliance, energy grew a hundredfold.

    A spring of 100 N throws the tip at the stop again and again: with steps three times as long as these, up to 2 %.
    """
    scene = dropped_beside_the_weld() if by == "weld" else struck_where_held(by)
    result = lf.simulate(scene, 0.02, lf.MasslessBoundary(safety=0.1), record=1e-5)
    history = result.contact("strike")
    assert history.impulse[-1, 0] > 0.0
    assert result.energies.relative_remainder < 0.01
    if by == "weld":
        speed = math.sqrt(2.0 * 9.81 * 1e-4)
        assert result.impulse[-1, 0, 0] == 0.0
        leaves = np.flatnonzero(history.force[:, 0] > 0.0)[-1] + 1
        assert result.velocity("ball", "center")[:, 1].max() == pytest.approx(speed, rel=0.02)
        assert leaves < len(result.times)


def hinged_solid() -> lf.SpatialScene:
    """A coarse rod on a hinge swings with a finer part of its lower side against a sphere."""
    solid = lf.Solid.box(
        (0.1, 0.02, 0.01), size=0.02, near={"contact": ((0.03, 0.0, -0.005), 2.5e-3, 6e-3, 2.0)}, density=2700.0,
        youngs_modulus=6.9e10, poissons_ratio=0.33,
    )  # fmt: skip
    rod = solid.reduce(6, contact="contact", rows="normal", interfaces=[lf.Interface("left", contact=False)])
    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    body = scene.add(rod, name="rod", angular_velocity=(0.0, 12.5, 0.0), velocity=(0.0, 0.0, -0.625))
    scene.join(lf.Revolute(body.point("left"), scene.ground.at(-0.05, 0.0, 0.0), axis=(0.0, 1.0, 0.0)))
    ball = scene.ground.sphere((0.03, 0.0, -0.005 - 2.0 - 1e-7), 2.0)
    scene.contact(body.face("contact"), ball, points="nodes", name="hit")
    return scene


@pytest.mark.parametrize("dynamic_modes", [None, 3])
def test_no_node_is_missed_where_static_modes_are_parted(dynamic_modes: int | None) -> None:
    """Nodes are looked for where the coordinates of the scheme have them: one that is not found sinks in."""
    scene = hinged_solid()
    result = lf.simulate(scene, 6e-5, lf.MasslessBoundary(step=2e-7, dynamic_modes=dynamic_modes), record=2e-7)
    assert result.contact("hit").pairs.max() > 8
    assert result.penetration.max() < 1e-12
