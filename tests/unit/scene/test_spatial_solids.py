"""Boxes and convex hulls on the ground and as parts of bodies in space."""

from __future__ import annotations

import copy
import pickle
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

import lcpflex as lf
from lcpflex.contact.near import near
from lcpflex.jit.struct import pack

TURN = Rotation.from_rotvec([0.3, -0.5, 0.2])
TURN_ABOUT_Z = Rotation.from_euler("z", 0.3)
SIZES = (0.4, 0.3, 0.2)
SHIFT = np.array([1.0, -2.0, 0.5])
CORNERS = (np.array([[i, j, k] for i in (0, 1) for j in (0, 1) for k in (0, 1)]) - 0.5) * SIZES


def part(shape: str, placed: Any) -> Any:
    """The turned and shifted block, as box or as hull."""
    if shape == "box":
        return placed.box(SHIFT, SIZES, TURN)
    return placed.hull(np.vstack([SHIFT + TURN.apply(CORNERS), SHIFT]))


def gaps(scene: lf.SpatialScene) -> list[float]:
    compiled = scene.compile()
    table, n = near(pack(compiled.model), compiled.q.copy(), 0.5)
    return sorted(table.gap[:n].tolist())


@pytest.mark.parametrize("shape", ["box", "hull"])
@pytest.mark.parametrize("on", ["ground", "body"])
def test_a_solid_that_is_a_part_is_touched_as_a_body_of_its_shape(shape: str, on: str) -> None:
    found = []
    for whole in (True, False):
        scene = lf.SpatialScene()
        above = SHIFT + TURN.apply([0.05, -0.02, 0.16])
        other = scene.add(
            lf.Cuboid(0.1, 0.1, 0.1, mass=1.0), position=above, orientation=TURN * Rotation.from_euler("z", 0.3)
        )
        ball = scene.add(lf.Sphere(0.1, mass=1.0), position=SHIFT + TURN.apply([0.35, 0.05, 0.0]))
        if whole:
            solid = scene.add(lf.Cuboid(*SIZES, mass=1.0), position=SHIFT, orientation=TURN).surface()
        else:
            body = scene.ground if on == "ground" else scene.add(lf.SpatialRigidBody(1.0, np.full(3, 0.1)))
            solid = part(shape, body)
        for one in (other, ball):
            scene.contact(one.surface(), solid)
        found.append(gaps(scene))
    assert len(found[0]) >= 5
    np.testing.assert_allclose(found[1], found[0], rtol=0, atol=1e-15)


STEPPERS = [lf.MoreauJean(step=1e-3), lf.GeneralizedAlpha(step=1e-3), lf.EventDriven()]


@pytest.mark.parametrize("stepper", STEPPERS, ids=lambda one: type(one).__name__)
@pytest.mark.parametrize("kind", ["wide", "equal", "turned", "hull", "large"])
def test_a_box_that_is_dropped_on_a_solid_of_the_ground_comes_to_rest(kind: str, stepper: Any) -> None:
    """Its height is half of its own; under Moreau-Jean it has sunk in by at most a step of its approach."""
    scene = lf.SpatialScene()
    if kind == "hull":
        scene.ground.hull([[x, y, z] for x in (-2.0, 2.0) for y in (-3.0, 3.0) for z in (-2.0, 0.0)])
    else:
        sizes = {"equal": (0.2, 0.1, 0.06), "large": (100.0, 100.0, 100.0)}.get(kind, (0.7, 0.5, 1.0))
        scene.ground.box((0.0, 0.0, -0.5 * sizes[2]), sizes, TURN_ABOUT_Z if kind == "turned" else None)
    scene.add(lf.Cuboid(0.2, 0.1, 0.06, mass=1.0), "block", position=(0.0, 0.0, 0.04))
    scene.contact_all(friction=0.3)
    result = lf.simulate(scene, 0.15, stepper, progress=False)
    assert result.times[-1] == 0.15
    sunk = 1e-3 * np.sqrt(2.0 * 9.81 * 0.01) if isinstance(stepper, lf.MoreauJean) else 1e-9
    assert -sunk <= result.q[-1][2] - 0.03 <= 1e-9
    np.testing.assert_allclose(result.q[-1][[0, 1, 4, 5, 6]], 0.0, atol=1e-9)
    np.testing.assert_allclose(result.u[-1], 0.0, atol=1e-9)


def test_a_block_slides_down_a_tilted_box_as_down_a_plane() -> None:
    """s = g (sin a - mu cos a) t^2 / 2."""
    angle, friction, time = 0.5, 0.2, 0.2
    down = Rotation.from_euler("y", angle)
    normal = down.apply([0.0, 0.0, 1.0])
    scene = lf.SpatialScene()
    scene.ground.box(-normal, (6.0, 4.0, 2.0), down)
    scene.add(lf.Cuboid(0.2, 0.1, 0.1, mass=1.0), position=0.05 * normal, orientation=down)
    scene.contact_all(friction=friction)
    result = lf.simulate(scene, time, lf.EventDriven(), progress=False)
    way = 0.5 * 9.81 * (np.sin(angle) - friction * np.cos(angle)) * time**2
    np.testing.assert_allclose(result.q[-1][:3], 0.05 * normal + way * down.apply([1.0, 0.0, 0.0]), atol=1e-8)


def test_parts_of_a_body_carry_it() -> None:
    """A table on two legs that are boxes and one that is a hull: it stands, and its weight is on the three."""
    scene = lf.SpatialScene()
    floor = scene.ground.plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    body = lf.SpatialRigidBody(1.0, [0.1, 0.1, 0.1], points={"leg": (0.3, 0.2, -0.2)})
    table = scene.add(body, "table", position=(0.0, 0.0, 0.4))
    legs = [table.box("leg", (0.1, 0.1, 0.4)), table.box(table.at(-0.3, 0.2, -0.2), (0.1, 0.1, 0.4))]
    legs.append(table.hull([[0.0, -0.4, -0.4], [0.1, -0.4, 0.0], [-0.1, -0.4, 0.0], [0.0, -0.5, 0.0]]))
    names = [scene.contact(leg, floor) for leg in legs]
    assert [leg.label for leg in legs] == ["table.box1", "table.box2", "table.hull1"]
    result = lf.simulate(scene, 0.05, lf.EventDriven(), progress=False)
    np.testing.assert_allclose(result.q[-1], result.q[0], rtol=0, atol=1e-9)
    forces = [float(np.sum(result.contact(name).normal_force[-1])) for name in names]
    assert sum(forces) == pytest.approx(9.81, rel=1e-9)
    assert min(forces) > 3.0


def flexible() -> lf.SpatialBody:
    return lf.SpatialBeam(1.0, 4e-4, (1.3e-8, 1.3e-8), 2.2e-8, 7800.0, 2e11, poissons_ratio=0.3, elements=4).reduce(
        modes=2
    )


@pytest.mark.parametrize(
    ("declare", "text"),
    [
        (lambda s, b: s.ground.box((0, 0), SIZES), r"center: .*expected shape \(3\)"),
        (lambda s, b: s.ground.box("center", SIZES), "center: 'ground' has no point 'center'"),
        (lambda s, b: s.ground.box((0, 0, float("nan")), SIZES), "center"),
        (lambda s, b: s.ground.box((0, 0, 0), 0.3), r"sizes: .*expected shape \(3\)"),
        (lambda s, b: s.ground.box((0, 0, 0), (0.1, 0.0, 0.2)), r"sizes\[1\]: 0"),
        (lambda s, b: s.ground.box((0, 0, 0), (0.1, 0.1, -0.2)), r"sizes\[2\]: -0.2"),
        (lambda s, b: s.ground.box((0, 0, 0), SIZES, (0, 0, 0, 1)), "orientation: four numbers"),
        (lambda s, b: s.ground.box((0, 0, 0), SIZES, 2.0 * np.eye(3)), "orientation: .*off unit vectors"),
        (lambda s, b: b.box(s.ground.at(0, 0, 0), SIZES), "center: .*expected a point of 'b'"),
        (lambda s, b: s.ground.hull([[0, 0, 0], [1, 0, 0], [0, 1, 0]]), "points: 3 were given, expected at least 4"),
        (lambda s, b: s.ground.hull([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]]), "points: they lie in one plane"),
        (lambda s, b: s.ground.hull([[0, 0], [1, 0]]), r"points: .*\(any, 3\)"),
        (lambda s, b: b.hull("box"), "points"),
        (
            lambda s, b: s.add(flexible(), "soft").box("center", SIZES),
            r"box: 'soft' is flexible \(2 modes\), expected a rig",
        ),
        (
            lambda s, b: s.add(flexible(), "soft").hull(CORNERS),
            r"hull: 'soft' is flexible \(2 modes\), expected a rigid",
        ),
    ],
)
def test_what_cannot_be_is_refused(declare: Callable[[lf.SpatialScene, Any], object], text: str) -> None:
    scene = lf.SpatialScene()
    body = scene.add(lf.Cuboid(0.1, 0.1, 0.1, mass=1.0), "b")
    with pytest.raises(lf.ModelError, match=text):
        declare(scene, body)


@pytest.mark.parametrize("shape", ["box", "hull"])
def test_a_scene_is_copied_and_pickled_with_them_and_they_are_made_again_elsewhere(shape: str) -> None:
    scene = lf.SpatialScene()
    solid = part(shape, scene.ground)
    scene.add(lf.Sphere(0.1, mass=1.0), position=SHIFT + np.array([0.1, 0.0, 0.4]))
    scene.contact_all()
    for other in (copy.deepcopy(scene), pickle.loads(pickle.dumps(scene))):
        assert gaps(other) == gaps(scene)
    again = solid.again(scene.ground)
    assert again.label == f"ground.{shape}2"
    for one, two in zip(again.shape.points, solid.shape.points, strict=True):
        np.testing.assert_array_equal(one.place, two.place)
    np.testing.assert_array_equal(again.shape.triangles, solid.shape.triangles)


@pytest.mark.parametrize("yaw", [0.0, 0.2])
@pytest.mark.parametrize("box_first", [True, False])
def test_a_box_that_tips_over_an_end_of_the_ground_slips_when_its_friction_is_used_up(
    box_first: bool, yaw: float
) -> None:
    """About the edge, d beyond its support: J theta'' = m g x, until the force m (a + g) leaves the cone of its face.

    The face of the ground is none of the contact any more, from the start on, whichever of the two comes first.
    """
    half, d, friction, g = 0.05, 0.02, 0.3, 9.81
    turn = Rotation.from_euler("z", yaw)  # of all that there is: no axis of the world is special
    scene = lf.SpatialScene()
    solid = scene.ground.box((0.0, 0.0, -1.0), (2.0, 2.0, 2.0), turn)
    place = turn.apply([1.0 + d, 0.0, half])
    body = scene.add(lf.Cuboid(0.2, 0.1, 2.0 * half, mass=1.0), position=place, orientation=turn)
    pair = (body.surface(), solid) if box_first else (solid, body.surface())
    scene.contact(*pair, friction=friction)
    result = lf.simulate(scene, 0.2, lf.EventDriven(), progress=False)

    inertia = (0.2**2 + (2.0 * half) ** 2) / 12.0 + d**2 + half**2

    def way(angle: float) -> tuple[float, float]:
        return d * np.cos(angle) + half * np.sin(angle), half * np.cos(angle) - d * np.sin(angle)

    def motion(_: float, y: Any) -> list[float]:
        return [y[1], g * way(y[0])[0] / inertia]

    def left(t: float, y: Any) -> float:
        (x, z), turning = way(y[0]), motion(t, y)[1]
        force = np.array([turning * z - y[1] ** 2 * x, -turning * x - y[1] ** 2 * z + g])
        normal = np.array([np.sin(y[0]), np.cos(y[0])])
        return float(friction * (normal @ force) - abs(normal[1] * force[0] - normal[0] * force[1]))

    left.terminal = True  # type: ignore[attr-defined]
    expected = solve_ivp(motion, (0.0, 0.2), [0.0, 0.0], events=left, rtol=1e-11, atol=1e-13).t_events[0][0]
    (slip,) = [event.time for event in result.events if event.kind == "slip"]
    assert slip == pytest.approx(expected, abs=1e-7)
