"""Triangles as ground: against planes, boxes and hulls of the same places."""

from __future__ import annotations

import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import lcpflex as lf
from lcpflex.bodies.spatial.hull import convex_hull
from lcpflex.contact.near import near
from lcpflex.errors import ModelError
from lcpflex.jit.struct import pack

UPRIGHT = Rotation.identity()
LYING = Rotation.from_euler("y", 90.0, degrees=True)
TURN = Rotation.from_rotvec([0.3, -0.5, 0.2])
SHIFT = np.array([1.0, -2.0, 0.5])
SIZES = np.array([0.4, 0.3, 0.2])
BODIES = {
    "ball": lambda size: lf.Sphere(0.05 * size, mass=1.0),
    "box": lambda size: lf.Cuboid(0.1 * size, 0.1 * size, 0.2 * size, mass=1.0),
    "capsule": lambda size: lf.Capsule(0.05 * size, 0.1 * size, mass=1.0),
}


def sheet(cells: int = 5, size: float = 1.0, turn: Rotation = UPRIGHT) -> tuple[Any, Any]:
    """A square of 1 m, split in triangles, that looks along z."""
    line = np.linspace(-0.5, 0.5, cells + 1)
    x, y = np.meshgrid(line, line, indexing="ij")
    places = np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])
    a = (np.arange(cells)[:, None] * (cells + 1) + np.arange(cells)).ravel()
    first, second = np.column_stack([a, a + cells + 1, a + cells + 2]), np.column_stack([a, a + cells + 2, a + 1])
    return turn.apply(size * places), np.concatenate([first, second])


def block(size: float = 1.0) -> tuple[Any, Any]:
    """The turned and shifted block, closed."""
    corners = np.array([[i, j, k] for i in (0, 1) for j in (0, 1) for k in (0, 1)]) - 0.5
    places = size * (SHIFT + TURN.apply(corners * SIZES))
    hull = convex_hull(places)
    return places[hull.corners], hull.triangles


def step(size: float = 1.0) -> tuple[Any, Any]:
    """Two blocks beside each other, the left one half as high: closed, and not convex."""
    flat = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [1.0, 2.0], [1.0, 1.0], [0.0, 1.0]]) - [1.0, 1.0]
    places = np.concatenate([np.insert(flat, 1, y, axis=1) for y in (-1.0, 1.0)]) * size
    caps = np.array([[0, 1, 4], [1, 2, 3], [1, 3, 4], [0, 4, 5]])
    sides = [t for k in range(6) for t in ([k, k + 6, (k + 1) % 6], [(k + 1) % 6, k + 6, (k + 1) % 6 + 6])]
    triangles = np.concatenate([caps, caps[:, ::-1] + 6, sides])
    return places, triangles


def run(ground: Any, body: str, size: float, stepper: Any, first: bool, turn: Rotation) -> lf.Result:
    """A body that falls on a ground, with a slip; lengths and gravity in units of ``size`` metres."""
    scene = lf.SpatialScene(gravity=tuple(turn.apply([0.0, 0.0, -9.81 * size])))
    placed = scene.add(
        BODIES[body](size), "body", turn.apply([-0.13 * size, 0.02 * size, 0.051 * size]), orientation=turn * LYING,
        velocity=turn.apply([0.8 * size, 0.1 * size, 0.0]),
    )  # fmt: skip
    pair = (ground(scene.ground), placed.surface())
    scene.contact(*(pair if first else pair[::-1]), friction=0.0 if body == "capsule" else 0.3, restitution=0.2)
    return lf.simulate(scene, 0.15, stepper, progress=False)


@pytest.mark.parametrize("body", BODIES)
@pytest.mark.parametrize(
    ("size", "stepper", "first", "turn"),
    [
        (1.0, lf.MoreauJean(1e-3), True, UPRIGHT),
        (1e-3, lf.MoreauJean(1e-3), False, TURN),
        (1.0, lf.GeneralizedAlpha(1e-3), False, TURN),
    ],
)
def test_a_sheet_is_the_plane_that_it_lies_in(
    body: str, size: float, stepper: Any, first: bool, turn: Rotation
) -> None:
    """Falling, sliding and rolling over flat edges: places and turns as on the plane; in millimetres as in metres.

    A capsule has no friction: both its ends share what is along it in ways that nothing determines.
    """
    up = turn.apply([0.0, 0.0, 1.0])
    found = [
        run(ground, body, size, stepper, first, turn)
        for ground in (
            lambda ground: ground.plane((0.0, 0.0, 0.0), up),
            lambda ground: ground.mesh(sheet(5, size, turn), is_open=True),
        )
    ]
    moved = np.linalg.norm(found[0].q[-1][:3] - found[0].q[0][:3]) / size
    assert moved > 0.05
    off = [np.abs(found[1].q[-1][rows] - found[0].q[-1][rows]).max() for rows in (slice(0, 3), slice(3, 7))]
    assert off[0] < 1e-8 * size
    assert off[1] < 1e-8
    assert not found[1].warnings or found[1].warnings == found[0].warnings


def gaps(scene: lf.SpatialScene) -> list[float]:
    compiled = scene.compile()
    table, n = near(pack(compiled.model), compiled.q.copy(), 0.5)
    return sorted(table.gap[:n].tolist())


@pytest.mark.parametrize("on", ["ground", "body"])
def test_a_convex_one_is_touched_as_a_box(on: str) -> None:
    found = []
    for kind in ("box", "mesh"):
        scene = lf.SpatialScene()
        held: Any = scene.ground if on == "ground" else scene.add(lf.SpatialRigidBody(1.0, np.full(3, 0.1)))
        solid = held.box(SHIFT, SIZES, TURN) if kind == "box" else held.mesh(block(1e3), "mm")
        above = SHIFT + TURN.apply([0.05, -0.02, 0.16])
        other = scene.add(lf.Cylinder(0.05, 0.1, mass=1.0), position=above, orientation=TURN)
        ball = scene.add(lf.Sphere(0.1, mass=1.0), position=SHIFT + TURN.apply([0.35, 0.05, 0.0]))
        for one in (other, ball):
            scene.contact(one.surface(), solid)
        found.append(gaps(pickle.loads(pickle.dumps(scene))))
    assert len(found[0]) >= 4
    np.testing.assert_allclose(found[1], found[0], rtol=0.0, atol=1e-14)


@pytest.mark.parametrize("body", BODIES)
def test_a_step_is_two_boxes(body: str) -> None:
    """Upon the higher part, upon the lower one, and beside the step, each alone."""
    for place, height in (((0.5, 0.0), 1.0), ((-0.5, 0.0), 0.0), ((-0.11, 0.3), 0.0)):
        scene = lf.SpatialScene()
        placed = scene.add(BODIES[body](1.0), "body", (*place, height + 0.051), orientation=LYING)
        scene.contact(placed.surface(), scene.ground.mesh(step()), friction=0.3)
        result = lf.simulate(scene, 0.05, lf.GeneralizedAlpha(1e-3), progress=False)
        assert result.q[-1][2] == pytest.approx(height + 0.05, abs=1e-9)
        assert result.penetration.max() < 1e-9


def stl(path: Path, surface: tuple[Any, Any]) -> Path:
    """An ASCII file of the triangles."""
    lines = ["solid ground"]
    for corners in surface[0][surface[1]]:
        lines += ["facet normal 0 0 0", "outer loop"]
        lines += [f"vertex {x:.17g} {y:.17g} {z:.17g}" for x, y, z in corners]
        lines += ["endloop", "endfacet"]
    path.write_text("\n".join([*lines, "endsolid ground"]))
    return path


def test_files_tell_the_same(tmp_path: Path) -> None:
    """An STL in millimetres of an open and of a closed surface; it must be told that they are."""
    for surface, is_open in ((sheet(3, 1e3), True), (step(1e3), False)):
        path = stl(tmp_path / "ground.stl", surface)
        found = []
        for of in (path, surface):
            scene = lf.SpatialScene()
            ball = scene.add(lf.Sphere(0.05, mass=1.0), position=(0.2, 0.1, 1.051))
            scene.contact(ball.surface(), scene.ground.mesh(of, "mm", is_open=is_open))
            scene.contact(
                scene.add(lf.Sphere(0.05, mass=1.0), position=(-0.2, 0.1, 0.051)).surface(),
                scene.ground.mesh(of, "mm", is_open=is_open),
            )
            found.append(gaps(scene))
        assert found[0] == pytest.approx(found[1], abs=1e-15)
        assert len(found[0]) >= 1
        with pytest.raises(ModelError, match=r"length_unit: none was given for surface '.*ground.stl'"):
            lf.SpatialScene().ground.mesh(path, is_open=is_open)


@pytest.mark.filterwarnings("ignore::lcpflex.errors.ModelWarning")  # a coarse mesh
def test_a_solid_stands_on_a_sheet_as_on_a_box() -> None:
    """With its face, and with its whole surface."""
    solid = lf.Solid.box((0.1, 0.1, 0.2), elements=(2, 2, 4), density=7800.0, youngs_modulus=2e9, poissons_ratio=0.3)
    for whole in (False, True):
        found = []
        for kind in ("box", "sheet"):
            scene = lf.SpatialScene()
            body = scene.add(solid.reduce(2, contact="bottom", damping=0.5), "block", (0.02, 0.03, 0.1))
            held = scene.ground
            ground = held.box((0, 0, -0.5), (1, 1, 1)) if kind == "box" else held.mesh(sheet(4), is_open=True)
            scene.contact(body.surface() if whole else body.face("bottom"), ground, friction=0.3)
            found.append(lf.simulate(scene, 0.02, lf.MoreauJean(2e-4), progress=False))
        np.testing.assert_allclose(found[1].q[-1], found[0].q[-1], rtol=0.0, atol=1e-11)
        assert found[1].force[-1, 0, 0] == pytest.approx(7800.0 * 0.002 * 9.81, rel=2e-2)


def test_what_is_no_ground() -> None:
    places, triangles = sheet()
    turned = triangles.copy()
    turned[3] = turned[3][::-1]
    ground = lf.SpatialScene().ground
    for given, words in (
        (lambda: ground.mesh((places, triangles)), "is_open=True takes one with a border"),
        (lambda: ground.mesh((places, turned), is_open=True), "turned around"),
        (lambda: ground.mesh((places, np.vstack([triangles, [0, 0, 1]])[-1:]), is_open=True), "none of its triangles"),
        (lambda: ground.mesh((places, triangles), is_open=1.5), "is_open"),
        (lambda: ground.mesh((block()[0], block()[1][:, ::-1]), is_open=True), "positive volume"),
    ):
        with pytest.raises(ModelError, match=words):
            given()
    scene = lf.SpatialScene()
    beam = lf.SpatialBeam(0.6, 1e-4, (1e-9, 1e-9), 2e-9, 7800.0, 2e11, poissons_ratio=0.3).reduce(2)
    with pytest.raises(ModelError, match="mesh: 'beam' is flexible"):
        scene.add(beam, "beam").mesh(block())


def test_behind_a_sheet_all_is_solid() -> None:
    """A ball under a sheet that looks up is in it, a start that is refused; under one that looks down it is free."""
    for down in (False, True):
        scene = lf.SpatialScene()
        places, triangles = sheet()
        ball = scene.add(lf.Sphere(0.05, mass=1.0), "ball", (0.03, 0.02, -0.06))
        ground = scene.ground.mesh((places, triangles[:, ::-1] if down else triangles), is_open=True)
        scene.contact(ball.surface(), ground)
        if down:
            result = lf.simulate(scene, 0.01, lf.MoreauJean(1e-3), progress=False)
            assert not result.force.any()
            continue
        with pytest.raises(ModelError, match="penetrate"):
            lf.simulate(scene, 0.01, lf.MoreauJean(1e-3), progress=False)
