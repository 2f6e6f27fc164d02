"""Solids and spatial beams that are reduced when their scene is compiled, for what holds, loads and touches them."""

from __future__ import annotations

import copy
import math
import pickle
import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.basics import libs
from lcpflex.bodies.reduction.interface import Interface
from lcpflex.bodies.spatial.body import SpatialBody
from lcpflex.bodies.spatial.interfaces import point_at

RHO, E, NU = 7800.0, 2e11, 0.3
LENGTH = 0.2
STEEL = {"density": RHO, "youngs_modulus": E, "poissons_ratio": NU}
ENDS = {"left": lambda x, y, z: x < 1e-9, "right": lambda x, y, z: x > LENGTH - 1e-9}


def bricks() -> lf.Solid:
    return lf.Solid.bar(LENGTH, 0.02, 0.01, elements=(8, 2, 2), **STEEL)


def tetrahedra() -> lf.Solid:
    import skfem

    lines = np.linspace(0.0, LENGTH, 7), np.linspace(-0.01, 0.01, 2), np.linspace(-0.005, 0.005, 2)
    return lf.Solid(skfem.MeshTet2.from_mesh(skfem.MeshTet.init_tensor(*lines)), sets=ENDS, **STEEL)


def matrices() -> lf.SpatialMatrices:
    parts = bricks().finite_elements()
    sets = {name: parts.sets[name].tolist() for name in ("left", "right")}
    return lf.SpatialMatrices(parts.mass, parts.stiffness, parts.places, node_sets=sets)


def beam() -> lf.SpatialBeam:
    return lf.SpatialBeam(LENGTH, 2e-4, (1.6e-9, 6.6e-9), 4.5e-9, RHO, E, NU, elements=12)


MODELS: dict[str, Callable[[], Any]] = {
    "hexahedron": bricks, "tetra10": tetrahedra, "matrices": matrices, "beam": beam,
}  # fmt: skip
SOLIDS = ("hexahedron", "tetra10")


def welded(scene: lf.SpatialScene, body: Any) -> None:
    scene.join(lf.Weld(body.point("left"), scene.ground.at(-0.1, 0.0, 0.0)))
    scene.load(lf.Force(body.point("right"), (0.0, 0.0, -1.0)))


def hinged(scene: lf.SpatialScene, body: Any) -> None:
    scene.join(lf.Revolute(body.point("left"), scene.ground.at(-0.1, 0.0, 0.0), axis=(0.0, 1.0, 0.0)))
    scene.load(lf.Force(body.point("right"), (0.0, 0.0, 1.0), follower=True))


def held_by_springs(scene: lf.SpatialScene, body: Any) -> None:
    right, above = body.point("right"), scene.ground.at(0.1, 0.0, 1.0)
    scene.load(lf.Spring(right, above, stiffness=100.0))
    scene.load(lf.TorsionSpring(body.point("left"), scene.ground.at(-0.1, 0.0, 0.0), 10.0, axis=(1.0, 0.0, 0.0)))
    scene.load(lf.Bushing(scene.ground.at(0.0, 0.0, 0.0), body.at(0.0, 0.0, 0.0), 10.0))


def guided(scene: lf.SpatialScene, body: Any) -> None:
    scene.join(lf.Ball(body.point("left"), scene.ground.at(-0.1, 0.0, 0.0)))
    scene.join(lf.Cylindrical(scene.ground.at(0.1, 0.0, 0.0), body.point("right"), axis=(1.0, 0.0, 0.0)))
    scene.load(lf.Torque(body.point("right"), (1.0, 0.0, 0.0)))


def sliding(scene: lf.SpatialScene, body: Any) -> None:
    scene.join(lf.Prismatic(body.point("right"), scene.ground.at(0.1, 0.0, 0.0), axis=(1.0, 0.0, 0.0)))
    scene.join(lf.PointOnPlane(scene.ground.at(-0.1, 0.0, 0.0), body.point("left"), axis=(0.0, 0.0, 1.0)))


def struck(scene: lf.SpatialScene, body: Any) -> None:
    floor = scene.ground.plane((0.0, 0.0, -1.0), (0.0, 0.0, 1.0))
    scene.contact(body.sphere("right", 0.01), floor, friction=0.3)
    scene.contact(body.node(body.at(-0.1, 0.0, 0.0)), floor)
    scene.contact(body.capsule("left", "right", 0.01), floor)
    scene.contact(body.cylinder("left", (1.0, 0.0, 0.0), 0.01, 0.02), floor)


def struck_on_its_surface(scene: lf.SpatialScene, body: Any) -> None:
    scene.contact(body.surface(), scene.ground.plane((0.0, 0.0, -1.0), (0.0, 0.0, 1.0)))


HELD = (welded, hinged, held_by_springs, guided, sliding, struck, struck_on_its_surface)


def made(model: Any, acts: Callable[..., None], **options: Any) -> lf.SpatialScene:
    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    acts(scene, scene.add(model, "b", **options))
    return scene


def flexible(scene: lf.SpatialScene) -> tuple[SpatialBody, tuple[Interface, ...]]:
    """The first body as it was reduced, and its interfaces."""
    parts = scene.parts()
    placed = parts.placed[0]
    assert placed.order is not None
    found, _ = placed.order.interfaces(placed, parts.joints, parts.loads, parts.contacts, parts.rotation)
    body = scene.reduced().parts().placed[0].source
    assert body is not None
    return body, found


def compliance(body: SpatialBody, interface: Interface) -> np.ndarray:
    """Of the forces and moments that act at an interface, balanced by inertia."""
    point = point_at(body, interface.place)
    rows = [point.phi if interface.along is None else point.phi @ np.array(interface.along)[:, None]]
    rows = [*(rows if interface.forces else []), *([point.psi] if interface.moment else [])]
    loads = np.hstack(rows)
    return np.asarray(loads.T @ (loads / body.stiffness[:, None]))


@pytest.mark.parametrize("acts", HELD, ids=lambda acts: acts.__name__)
@pytest.mark.parametrize("kind", MODELS)
def test_compliance_at_every_interface_is_that_of_the_mesh(kind: str, acts: Callable[..., None]) -> None:
    """Of what the scene made of the body, against all modes of the mesh."""
    model = MODELS[kind]()
    scene = made(model, acts, modes=6, contact_nodes=3)
    body, interfaces = flexible(scene)
    whole = model.reduce(None)
    assert interfaces
    assert body.modes - body.residual_modes == 6
    for interface in interfaces:
        exact = compliance(whole, interface)
        scale = np.sqrt(np.outer(np.diag(exact), np.diag(exact)))
        assert np.abs(compliance(body, interface) - exact).max(initial=0.0) <= 1e-6 * scale.max(initial=0.0)
    if "surface" not in acts.__name__:
        assert not scene.compiled(project=True).warnings


def linear(body: SpatialBody) -> tuple[np.ndarray, np.ndarray]:
    """Mass and stiffness of small motions, about the mass centre: six of the frame, and those of the modes."""
    frame = np.zeros((6, 6))
    frame[:3, :3], frame[3:, 3:] = body.mass * np.eye(3), body.inertia
    mass = libs.linalg.block_diag(frame, np.eye(body.modes))
    return mass, np.diag(np.concatenate([np.zeros(6), body.stiffness]))


def rows_at(body: SpatialBody, name: str) -> np.ndarray:
    """(6, 6 + n) displacement and rotation of the material at a named point."""
    point = body.points[name]
    turned = np.zeros((6, 6))
    turned[:3, :3], turned[3:, 3:] = np.eye(3), np.eye(3)
    turned[:3, 3:] = -np.cross(np.eye(3), point.place)
    return np.hstack([turned, np.vstack([point.phi.T, point.psi.T])])


def held(body: SpatialBody, rows: np.ndarray, along: int = 2) -> tuple[float, float]:
    """First angular frequency, and the sag of the right end under a unit force there, with rows (k, ...) held."""
    mass, stiffness = linear(body)
    free = libs.linalg.null_space(rows)
    M, K = free.T @ mass @ free, free.T @ stiffness @ free
    pull = rows_at(body, "right")[along] @ free
    lowest = float(libs.linalg.eigh(K, M, eigvals_only=True)[0])
    return math.sqrt(max(lowest, 0.0)), float(pull @ np.linalg.lstsq(K, pull, rcond=1e-12)[0])


@pytest.mark.parametrize("kind", SOLIDS)
def test_welded_and_hinged_solids_of_eight_free_modes(kind: str) -> None:
    """First frequency and sag of the tip as of the full mesh held there; without residual modes 5 % and more off."""
    model = MODELS[kind]()
    body, whole = flexible(made(model, welded, modes=8))[0], model.reduce(None)
    bare = model.reduce(8)
    exact = held(whole, rows_at(whole, "left"))
    found = held(body, rows_at(body, "left"))
    assert found[0] == pytest.approx(exact[0], rel=0.01)
    assert found[1] == pytest.approx(exact[1], rel=1e-3)
    assert held(bare, rows_at(bare, "left"))[1] < 0.95 * exact[1]

    def pulled(scene: lf.SpatialScene, solid: Any) -> None:
        hinged(scene, solid)
        scene.load(lf.Force(solid.point("right"), (0.0, 1.0, 0.0), follower=True))

    body = flexible(made(model, pulled, modes=8))[0]

    def pinned(one: SpatialBody) -> tuple[float, float]:
        """Beside the free turn about the hinge, which a stop at the other end holds; the sag is along the hinge."""
        rows = np.vstack([rows_at(one, "left")[[0, 1, 2, 3, 5]], rows_at(one, "right")[2:3]])
        return held(one, rows, 1)

    assert pinned(body)[0] == pytest.approx(pinned(whole)[0], rel=0.01)
    assert pinned(body)[1] == pytest.approx(pinned(whole)[1], rel=1e-3)


@pytest.mark.parametrize("kind", MODELS)
def test_the_handle_answers_until_then(kind: str) -> None:
    """Names are means of nodes, places are those of the body frame, whose origin is the mass centre."""
    scene = lf.SpatialScene()
    body = scene.add(MODELS[kind](), "b", modes=4, position=(0.0, 1.0, 0.0), damping=0.01)
    np.testing.assert_allclose(body.point("left").material.place, [-0.1, 0.0, 0.0], atol=1e-12)
    np.testing.assert_allclose(body.at(0.1, 0.0, 0.0).material.place, [0.1, 0.0, 0.0], atol=1e-12)
    assert body.surface().label == "b.surface"
    assert body.point("left").material.phi.shape == (0, 3)
    scene.join(lf.Weld(body.point("left"), scene.ground.at(-0.1, 1.0, 0.0)))
    result = lf.simulate(scene, 1e-3, lf.MoreauJean(1e-5), progress=False)
    coordinates = result.modes_of("b")
    assert coordinates.residual.tolist() == [False] * 4 + [True] * 6
    assert "4 free and 6 residual modes" in str(coordinates)
    assert result.point("b", "right")[-1, 2] < 0.0


def test_points_of_nodes_with_weights_are_the_same_after_reduction() -> None:
    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    solid = bricks()
    nodes = np.flatnonzero(solid.finite_elements().places[:, 0] > LENGTH - 1e-9).tolist()
    weights = (1.0 + np.arange(len(nodes))).tolist()
    body = scene.add(solid, "b", modes=4)
    scene.load(lf.Torque(body.at_nodes(nodes, weights), (0.0, 1.0, 0.0)))
    scene.load(lf.Force(body.at_nodes(3), (0.0, 1.0, 0.0)))
    reduced, (torque, force) = flexible(scene)
    whole = solid.reduce(None)
    assert not torque.forces
    assert not force.moment
    for interface in (torque, force):
        point, exact = point_at(reduced, interface.place), point_at(whole, interface.place)
        np.testing.assert_allclose(point.place, exact.place, atol=1e-15)
        np.testing.assert_allclose(compliance(reduced, interface), compliance(whole, interface), rtol=1e-8, atol=1e-16)
    assert reduced.residual_modes == 6


def test_a_force_that_keeps_its_direction_in_the_body_takes_one_mode() -> None:
    for value, along in (((0.0, 3.0, 4.0), (0.0, 0.6, 0.8)), ((0.0, math.sin, 0.0), (0.0, 1.0, 0.0))):
        scene = lf.SpatialScene()
        body = scene.add(bricks(), modes=2)
        scene.load(lf.Force(body.point("right"), value, follower=True))
        reduced, (interface,) = flexible(scene)
        assert interface.along == pytest.approx(along)
        assert reduced.residual_modes == 1


def test_directions_of_joints_are_those_of_the_start() -> None:
    """A slider along x of the world, on a body that is turned by a right angle about z: along its y axis."""
    turn = libs.Rotation.from_rotvec([0.0, 0.0, math.pi / 2])
    for guides in (False, True):
        scene = lf.SpatialScene()
        body = scene.add(bricks(), modes=2, orientation=turn)
        pair = (body.point("right"), scene.ground.at(0.0, 0.1, 0.0))
        axis = (0.0, -1.0, 0.0) if guides else (1.0, 0.0, 0.0)
        scene.join(lf.Prismatic(*(pair[::-1] if guides else pair), axis=axis))
        across = [np.abs(interface.along) for interface in flexible(scene)[1]]
        assert np.abs(across).max(axis=0) == pytest.approx([1.0, 0.0, 1.0], abs=1e-12)


def test_surfaces_take_few_nodes_and_say_so() -> None:
    scene = made(bricks(), struck_on_its_surface, modes=4, contact_nodes=5)
    compiled = scene.compiled()
    assert compiled.notes == ("residual modes for 5 nodes of 'b.surface' (contact 'contact1')",)
    _, interfaces = flexible(scene)
    assert len({interface.place for interface in interfaces}) == 5
    assert flexible(made(bricks(), struck_on_its_surface, modes=4, contact_nodes=0))[0].residual_modes == 0
    without = made(bricks(), struck_on_its_surface, modes=4)
    (said,) = without.compiled().warnings
    assert "body 'b': its 4 modes give way" in said
    assert "reduce(contact=...) with the nodes that touch" in said
    assert not flexible(without)[1]  # a few nodes would make a face lean that lands flat


def test_smooth_surfaces_are_pushed_along_their_normals() -> None:
    for friction, each in ((0.0, 1), (0.3, 3)):
        scene = lf.SpatialScene()
        ball = scene.add(lf.Solid.ball(0.01, 0.005, **STEEL), "b", modes=2, contact_nodes=4)
        scene.contact(ball.surface(), scene.ground.plane((0.0, 0.0, -1.0), (0.0, 0.0, 1.0)), friction=friction)
        body, interfaces = flexible(scene)
        smooth = [interface for interface in interfaces if interface.along is not None]
        assert len(smooth) == (4 if each == 1 else 0)
        assert body.residual_modes == 4 * each


def test_a_solid_that_is_welded_by_hand_warns() -> None:
    def scene(body: Any, **options: Any) -> lf.SpatialScene:
        return made(body, welded, **options)

    solid = bricks()
    with pytest.warns(lf.ModelWarning, match=r"'b': its 8 modes give way .* % less than its mesh to a .* along \("):
        scene(solid.reduce(8)).compile()
    by_hand = solid.reduce(8, interfaces=["left", "right"])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        scene(by_hand).compile()
        scene(solid.reduce(0)).compile()
        scene(solid, modes=0).compile()


def test_equal_bodies_share_their_reduction() -> None:
    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    solid = bricks()
    for k, damping in enumerate((None, None, 0.02)):
        body = scene.add(solid, f"b{k}", modes=4, position=(0.0, float(k), 0.0), damping=damping)
        scene.join(lf.Ball(body.point("left"), scene.ground.at(-0.1, float(k), 0.0)))
    first, second, third = (placed.source for placed in scene.reduced().parts().placed)
    assert first is second
    assert first is not third
    assert third is not None
    np.testing.assert_allclose(third.damping, 0.04 * np.sqrt(third.stiffness))


def test_damping_of_each_mode_and_of_residual_ones() -> None:
    for model in (bricks(), beam()):
        scene = made(model, welded, modes=3, damping=[0.01, 0.02, 0.03], residual_damping=0.5)
        body, _ = flexible(scene)
        ratio = body.damping / (2.0 * np.sqrt(body.stiffness))
        np.testing.assert_allclose(ratio[:3], [0.01, 0.02, 0.03])
        np.testing.assert_allclose(ratio[3:], 0.5)


def test_initial_deformation_is_that_of_the_free_modes() -> None:
    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    solid = bricks()
    body = scene.add(solid, "b", modes=2, modal=[1e-4, 0.0], modal_velocity=[0.0, 0.1], position=(1.0, 0.0, 0.0))
    scene.load(lf.Force(body.point("right"), (0.0, 0.0, 0.0)))
    compiled = scene.compiled()
    np.testing.assert_allclose(compiled.q[[0, 7, 8]], [1.0, 1e-4, 0.0])
    np.testing.assert_allclose(compiled.u[[6, 7]], [0.0, 0.1])
    assert not compiled.q[9:].any()


@pytest.mark.parametrize("kind", ["hexahedron", "beam"])
def test_copies_and_pickles_of_scenes_compile_to_the_same(kind: str) -> None:
    scene = made(MODELS[kind](), struck, modes=3)
    stiffness = scene.compiled().model.bodies.stiffness  # with a factor, which no copy has
    for other in (copy.deepcopy(scene), pickle.loads(pickle.dumps(scene))):
        np.testing.assert_allclose(other.compiled().model.bodies.stiffness, stiffness, rtol=1e-12)


def test_state_tells_the_points_of_the_scene_as_it_was_declared() -> None:
    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    body = scene.add(bricks(), "b", modes=4)
    scene.join(lf.Weld(body.point("left"), scene.ground.at(-0.1, 0.0, 0.0)))
    tip, seen = body.point("right"), []

    def pull(t: float, state: Any) -> tuple[float, float, float]:
        seen.append(float(state.position(tip)[2]))
        return 0.0, 0.0, -100.0

    scene.load(lf.Force(tip, pull))
    lf.simulate(scene, 2e-4, lf.MoreauJean(1e-5), progress=False)
    assert abs(seen[0]) < 1e-15
    assert min(seen) < -1e-8


STEPPERS = [lf.MoreauJean(2e-6), lf.GeneralizedAlpha(2e-6)]


@pytest.mark.parametrize("struck", [True, False], ids=["struck", "free"])
@pytest.mark.parametrize("stepper", STEPPERS, ids=lambda one: type(one).__name__)
def test_momenta_of_a_solid(stepper: Any, struck: bool) -> None:
    """A spinning bar that vibrates, with a ball at its end that another one strikes.

    While it touches, the angular momentum is off by the paths of the points during a step, as that of rigid bodies is.
    """
    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    rates = {"angular_velocity": (3.0, 2.0, 5.0), "velocity": (0.0, 0.0, 0.5), "modal_velocity": [0.01, 0.02, 0, 0, 0]}
    bar = scene.add(bricks(), "bar", modes=5, **rates)
    above = 0.0305 if struck else 0.1
    ball = scene.add(lf.Sphere(0.01, mass=0.05), "ball", position=(0.1, 0.0, above), velocity=(0.0, 0.0, -2.0))
    scene.contact(bar.sphere("right", 0.02), ball.surface(), friction=0.3)
    result = lf.simulate(scene, 1e-3, stepper, progress=False)
    ball_momentum, momentum = result.momentum("ball").linear, result.momentum()
    assert bool(np.abs(ball_momentum[-1] - ball_momentum[0]).max() > 0.01) is struck
    linear = struck or isinstance(stepper, lf.GeneralizedAlpha)  # which solves for its angular momentum to 2e-10
    for part in (momentum.linear, momentum.angular)[: 1 if linear else 2]:
        assert np.abs(part - part[0]).max() <= 1e-10 * np.abs(part[0]).max()


def test_more_modes_of_a_solid_in_a_scene() -> None:
    """What verification runs: the same scene with twice as many free modes, and the same initial deformation."""
    from lcpflex.accuracy.richer import richer

    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    body = scene.add(bricks(), "b", modes=3, damping=[0.01, 0.02, 0.03], modal=[1e-5, 0.0, 0.0])
    scene.load(lf.Spring(body.point("left"), scene.ground.at(-0.1, 0.0, 1.0), 100.0))
    more, unknown = richer(scene)
    assert not unknown
    q = more.compiled().q
    twice = more.reduced().parts().placed[0].source
    assert twice.modes - twice.residual_modes == 6
    assert q[7] == pytest.approx(1e-5, rel=1e-9)
    np.testing.assert_allclose(twice.damping[:6] / (2.0 * np.sqrt(twice.stiffness[:6])), [0.01, 0.02, *[0.03] * 4])


def test_a_run_of_a_reduced_solid_is_verified() -> None:
    scene = lf.SpatialScene()
    body = scene.add(bricks(), "b", modes=3)
    scene.join(lf.Weld(body.point("left"), scene.ground.at(-0.1, 0.0, 0.0)))
    found = lf.simulate(scene, 2e-3, lf.MoreauJean(1e-5), progress=False).verify()
    assert "modes" in str(found)


@pytest.mark.parametrize(
    ("model", "options", "said"),
    [
        (bricks, {}, "modes: none were given for Solid, expected a number of free modes"),
        (bricks, {"modes": -1}, "modes: -1 was given"),
        (bricks, {"modes": 3, "damping": [0.1, 0.1]}, "damping: an array of shape"),
        (bricks, {"modes": 3, "contact_nodes": -1}, "contact_nodes: -1 was given"),
        (bricks, {"modes": 3, "modal": [1.0]}, "modal: an array of shape"),
        (bricks, {"modes": 3, "residual_damping": -1.0}, "residual_damping: -1"),
        (bricks, {"modes": 3, "stiffening": lf.Stiffening()}, "stiffening: .* was given for Solid, which takes none"),
        (lambda: lf.Beam(1.0, 0.1, 0.1, RHO, E), {"modes": 3}, "Beam was given, .*planar ones belong into a Scene"),
        (lambda: bricks().reduce(2), {"modes": 3}, "modes: it was given for a SpatialBody, which has its modes"),
    ],
)
def test_orders_that_cannot_be(model: Callable[[], Any], options: dict[str, Any], said: str) -> None:
    scene = lf.SpatialScene()
    with pytest.raises(lf.ModelError, match=said):
        scene.add(model(), **options)
    assert not scene.parts().placed


def test_solids_do_not_belong_into_the_plane() -> None:
    for model in (bricks(), beam()):
        with pytest.raises(lf.ModelError, match="of space belong into a SpatialScene"):
            lf.Scene().add(model, modes=3)


def test_what_reduces_to_something_else_is_refused() -> None:
    class Own:
        def reduce(self, modes: int) -> Any:
            return modes

    for scene in (lf.Scene(), lf.SpatialScene()):
        with pytest.raises(lf.ModelError, match="Own was given, which is not of this kind of scene: its reduce"):
            scene.add(Own(), modes=3)  # type: ignore[arg-type]


def test_errors_of_a_reduction_name_the_body() -> None:
    scene = lf.SpatialScene()
    scene.add(bricks(), "arm", modes=5000)
    with pytest.raises(lf.ModelError, match="body 'arm': modes: 5000 was given"):
        scene.compile()
    arm = lf.SpatialScene().add(bricks(), "arm", modes=2)
    with pytest.raises(lf.ModelError, match=r"box: 'arm' is flexible \(2 modes\)"):
        arm.box((0.0, 0.0, 0.0), (0.1, 0.1, 0.1))
    with pytest.raises(lf.ModelError, match="x, y, z"):
        arm.at(0.0, 0.0, 0.5)
