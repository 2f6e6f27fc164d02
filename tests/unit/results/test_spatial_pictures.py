"""Pictures, films and charts of spatial results."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.bodies.spatial.body import SpatialBody, SpatialPoint
from lcpflex.bodies.spatial.shapes import CapsuleShape, CylinderShape, Shape, SphereShape, SurfaceShape
from lcpflex.compile.compiled_scene import CompiledScene
from lcpflex.errors import ModelError
from lcpflex.model.arrays import frozen
from lcpflex.model.coordinates import DISTANCE
from lcpflex.results.result import Result
from lcpflex.results.spatial.camera import Look, camera_of
from lcpflex.results.spatial.facets import Facets, ellipsoid, facets_of
from lcpflex.results.spatial.floor import AXIS_COLOURS
from lcpflex.results.spatial.picture import SpatialPicture
from lcpflex.results.spatial.raster import NOBODY
from lcpflex.results.spatial.scenery import Scenery, coil
from tests import libs
from tests.unit.results.drawn import LOOK, SIDE, result_of, scene_of


def bending_bar() -> SpatialBody:
    """A square tube whose one mode bends it in z, with a point where its upper edge ends."""
    x = np.linspace(-0.5, 0.5, 21)
    section = 0.02 * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    vertices = np.array([[a, y, z] for a in x for y, z in section])
    phi = np.zeros((len(vertices), 1, 3))
    phi[:, 0, 2] = vertices[:, 0] ** 2
    quads = [
        [4 * i + j, 4 * i + (j + 1) % 4, 4 * i + 4 + (j + 1) % 4, 4 * i + 4 + j] for i in range(20) for j in range(4)
    ]
    ends = [[3, 2, 1, 0], [80, 81, 82, 83]]
    triangles = np.array([t for a, b, c, d in quads + ends for t in ((a, c, b), (a, d, c))])
    tip = SpatialPoint(vertices[83], phi[83], np.zeros((1, 3)))
    shape = SurfaceShape(vertices, triangles, phi)
    return SpatialBody(
        mass=1.0, second=np.diag([0.08, 1e-3, 1e-3]), stiffness=np.array([100.0]), points={"tip": tip}, shape=shape
    )


def volume(facets: Facets) -> float:
    a, b, c = np.moveaxis(facets.vertices[facets.triangles], 1, 0)
    return float(np.sum(a * np.cross(b, c))) / 6.0


@pytest.mark.parametrize(
    ("shape", "exact"),
    [
        (SphereShape(0.3), 4.0 / 3.0 * np.pi * 0.3**3),
        (CylinderShape(0.2, 0.7), np.pi * 0.2**2 * 0.7),
        (CapsuleShape(0.2, 0.7), np.pi * 0.2**2 * 0.7 + 4.0 / 3.0 * np.pi * 0.2**3),
        (lf.Cuboid(0.1, 0.2, 0.3, mass=1.0).shape, 0.006),
        (lf.ConvexHull([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], mass=1.0).shape, 1.0 / 6.0),
    ],
)
def test_triangles_of_shapes_look_outwards(shape: Shape, exact: float) -> None:
    """Closed, of the volume of the shape, which counter-clockwise triangles alone enclose; normals lead away."""
    facets = facets_of(shape)
    assert facets is not None
    assert facets.closed
    assert volume(facets) == pytest.approx(exact, rel=1.2e-2)
    assert volume(facets) <= exact * (1.0 + 1e-12)
    normals = facets.normals(facets.vertices)
    np.testing.assert_allclose(np.linalg.norm(normals, axis=2), 1.0, atol=1e-12)
    assert (np.sum(normals * facets.vertices[facets.triangles], axis=2) > 0.0).all()  # convex about the origin


def test_normals_are_smooth_on_a_ball_and_break_at_edges() -> None:
    ball = facets_of(SphereShape(1.0))
    assert ball is not None
    normals = ball.normals(ball.vertices)
    a_side = 2.0 * np.pi / 48  # flat triangles would be half of it off
    np.testing.assert_allclose(normals, ball.vertices[ball.triangles], atol=0.25 * a_side)
    box = facets_of(lf.Cuboid(1.0, 1.0, 1.0, mass=1.0).shape)  # type: ignore[arg-type]
    assert box is not None
    assert len(box.edges) == 12  # and no diagonals
    np.testing.assert_allclose(np.abs(box.normals(box.vertices)).max(axis=2), 1.0, atol=1e-12)


def test_an_open_surface_is_seen_from_both_sides() -> None:
    sheet = SurfaceShape(np.array([[0, 0, 0], [1, 0, 0], [0, 0, 1.0]]), np.array([[0, 1, 2]]), np.zeros((3, 0, 3)))
    facets = facets_of(sheet)
    assert facets is not None
    assert not facets.closed
    assert len(facets.edges) == 3
    body = lf.SpatialRigidBody(1.0, (1.0, 1.0, 1.0))
    for azimuth in (-90.0, 90.0):
        compiled = scene_of((replace(body, shape=sheet), (0.0, 0.0, 0.0)))
        picture = SpatialPicture(result_of(compiled), compiled, np.array([0]), LOOK._replace(view=(0.0, azimuth)))
        canvas, _ = picture.canvas(compiled.q, 100, 100)
        assert (canvas.owner == 0).sum() > 1000


def test_a_deformed_surface_is_drawn_where_its_points_are() -> None:
    """The tip of the bent bar, turned and moved: in the vertices, and the last pixel in its row."""
    compiled = scene_of((bending_bar(), (0.2, 0.0, 0.3)))
    q = np.tile(compiled.q, (2, 1))
    q[1, 3:7], q[1, 7] = (np.cos(0.1), 0.0, -np.sin(0.1), 0.0), 1.2
    result = result_of(compiled, q)
    tip = result.point("body1", "tip")[1]
    scenery = Scenery(compiled)
    np.testing.assert_allclose(scenery.vertices(q[1], scenery.drawn[0], 1.0)[83], tip, atol=1e-14)
    picture = SpatialPicture(result, compiled, np.array([1]), LOOK)
    canvas, _ = picture.canvas(q[1], 400, 400 * 2)
    pixels = 1600 / (picture.view[1] - picture.view[0])
    rows, columns = np.nonzero(canvas.owner == 0)
    highest = np.argmax(rows)
    place = np.array([columns[highest], rows[highest]]) / pixels + [picture.view[0], picture.view[2]]
    np.testing.assert_allclose(place, tip[[0, 2]], atol=3.0 / pixels)


def test_deformations_are_drawn_larger_and_the_title_says_so() -> None:
    compiled = scene_of((bending_bar(), (0.0, 0.0, 0.0)))
    q = np.tile(compiled.q, (2, 1))
    q[:, 7] = 0.01
    scenery = Scenery(compiled)
    rest, once, tenfold = (scenery.vertices(q[0], scenery.drawn[0], scale) for scale in (0.0, 1.0, 10.0))
    np.testing.assert_allclose(tenfold - rest, 10.0 * (once - rest), atol=1e-15)
    assert np.abs(once - rest).max() == pytest.approx(0.0025)
    result = result_of(compiled, q)
    assert result.draw(0.0).axes[0].get_title(loc="left") == "t = 0 s"
    title = result.draw(0.0, scale=10.0).axes[0].get_title(loc="left")
    assert title == "t = 0 s, deformation drawn 10 times as large"


@pytest.mark.parametrize(
    ("gravity", "up", "names"),
    [((0, 0, -9.81), (0, 0, 1), "xyz"), ((0, -9.81, 0), (0, 1, 0), "zxy"), ((0, 0, 9.81), (0, 0, -1), "yxz"),
     ((0, 0, 0), (0, 0, 1), "xyz"), ((1, 2, -3), (0, 0, 1), "xyz")],
)  # fmt: skip
def test_up_is_against_gravity(gravity: Any, up: Any, names: str) -> None:
    camera = camera_of((20.0, -60.0), np.array(gravity, dtype=float))
    np.testing.assert_array_equal(camera.floor[2], up)
    assert "".join("xyz"[axis] for axis in camera.axes) == names
    assert np.linalg.det(camera.floor) == pytest.approx(1.0)
    seen = np.stack([camera.right, camera.upward, camera.towards])
    np.testing.assert_allclose(seen @ seen.T, np.eye(3), atol=1e-14)
    assert np.linalg.det(seen) == pytest.approx(1.0)
    assert camera.upward @ camera.floor[2] == pytest.approx(np.cos(np.radians(20.0)))


def test_the_picture_holds_everything_and_its_floor_lies_below() -> None:
    compiled = scene_of((lf.Sphere(0.1, mass=1.0), (0.0, 0.0, 0.5)), (lf.Cuboid(0.2, 0.3, 0.1, mass=1.0), (1, 2, 0.3)))
    picture = SpatialPicture(result_of(compiled), compiled, np.array([0, 1]), LOOK._replace(view=(25.0, -50.0)))
    assert 0.0 < 0.25 - picture.floor.low[2] < 0.1
    assert (picture.floor.low[:2] <= (-0.1, -0.1)).all()
    assert (picture.floor.high[:2] >= (1.1, 2.15)).all()
    canvas, shadow = picture.canvas(compiled.q, 300, 300)
    for body in (0, 1):
        rows, columns = np.nonzero(canvas.owner == body)
        assert rows.min() > 0
        assert rows.max() < 599
        assert columns.min() > 0
        assert columns.max() < 599
    assert shadow.max() > 0.1


def test_a_body_without_a_shape_is_the_ellipsoid_of_its_inertia_with_lines_to_what_holds_it() -> None:
    """A homogeneous ellipsoid with semiaxes a, b, c has J_x = m (b^2 + c^2) / 5."""
    a, b, c, mass = 0.3, 0.2, 0.1, 2.0
    inertia = mass / 5.0 * np.array([b * b + c * c, a * a + c * c, a * a + b * b])
    body = lf.SpatialRigidBody(mass, inertia, center=(0.0, 0.0, 0.5))
    compiled = scene_of((body, (0.0, 0.0, 0.0)))
    (one,) = Scenery(compiled).drawn
    assert one.facets is not None
    np.testing.assert_allclose(one.facets.vertices.max(axis=0), [a, b, 0.5 + c], rtol=1e-3)
    np.testing.assert_allclose(one.facets.vertices.min(axis=0), [-a, -b, 0.5 - c], rtol=1e-3)
    assert volume(one.facets._replace(vertices=one.facets.vertices - [0.0, 0.0, 0.5])) > 0.0
    mirrored = ellipsoid(np.zeros(3), np.diag([1.0, 1.0, -1.0]), np.array([a, b, c]))
    assert volume(mirrored) == pytest.approx(4.0 / 3.0 * np.pi * a * b * c, rel=1.2e-2)


def linked() -> CompiledScene:
    """Two balls: one on a massless rod, one on a spring, both from the ground."""
    compiled = scene_of((lf.Sphere(0.05, mass=1.0), (0.3, 0.0, 0.0)), (lf.Sphere(0.05, mass=1.0), (-0.3, 0.0, 0.0)))
    model = compiled.model
    points = model.points._replace(
        body=frozen([0, 1, -1, -1], np.int64), place=frozen([[0.0] * 3, [0.0] * 3, [0.3, 0.0, 0.5], [-0.3, 0.0, 0.5]]),
        start=frozen([0] * 5, np.int64),
    )  # fmt: skip
    rows = np.zeros((1, 3))
    joints = model.joints._replace(
        point=frozen([[0, 2]], np.int64), row=frozen([0, 1], np.int64), kind=frozen([DISTANCE], np.int64), axis=rows,
        on_p=rows, on_q=rows, rest=frozen([0.5]), signal=frozen([-1], np.int64),
    )  # fmt: skip
    loads = model.loads._replace(
        spring_kind=frozen([DISTANCE], np.int64), spring_point=frozen([[1, 3]], np.int64), spring_axis=rows,
        spring_on_p=rows, spring_on_q=rows, spring_value=rows,
    )  # fmt: skip
    return replace(compiled, model=model._replace(points=points, joints=joints, loads=loads))


def test_rods_springs_and_their_ends_are_drawn() -> None:
    compiled = linked()
    result = result_of(compiled)
    picture = SpatialPicture(result, compiled, np.array([0]), LOOK)
    canvas, _ = picture.canvas(compiled.q, 200, 300)
    scale = 600 / (picture.view[1] - picture.view[0])
    row, column = round((0.25 - picture.view[2]) * scale), round((0.3 - picture.view[0]) * scale)
    assert canvas.owner[row, column] == 2
    np.testing.assert_array_equal(canvas.colour[row, column], 48)
    ax = result.draw(0.0, view=SIDE).axes[0]
    circles = [line.get_xydata()[0] for line in ax.lines if line.get_marker() == "o"]
    for place in ((0.3, 0.0), (0.3, 0.5), (-0.3, 0.0), (-0.3, 0.5)):
        assert min(np.linalg.norm(np.asarray(circle) - place) for circle in circles) < 1e-12
    held = [np.asarray(line.get_xydata()[0]) for line in ax.lines if line.get_marker() == 6]
    np.testing.assert_allclose(sorted(held, key=lambda place: place[0]), [(-0.3, 0.5), (0.3, 0.5)], atol=1e-12)
    wire = coil(np.zeros(3), np.array([0.0, 0.0, 1.0]), 0.1)
    np.testing.assert_array_equal(wire[[0, -1]], [[0, 0, 0], [0, 0, 1]])
    assert np.hypot(wire[2:-2, 0], wire[2:-2, 1]) == pytest.approx(0.1)


def test_frames_of_bodies_are_drawn_on_request() -> None:
    compiled = scene_of((lf.Cuboid(0.2, 0.2, 0.2, mass=1.0), (0.0, 0.0, 0.0)))
    result = result_of(compiled)
    tips = {}
    for frames in (False, True):
        picture = SpatialPicture(result, compiled, np.array([0]), Look((25.0, 30.0), frames, 1.0))
        canvas, _ = picture.canvas(compiled.q, 300, 300)
        scale = 600 / (picture.view[1] - picture.view[0])
        seen = camera_of((25.0, 30.0), np.array([0.0, 0.0, -1.0])).seen(np.array([[0.0, 0.0, 0.13], [0.0, 0.0, 0.05]]))
        columns, rows = ((seen[:, :2] - [picture.view[0], picture.view[2]]) * scale).astype(int).T
        tips[frames] = canvas.colour[rows, columns].astype(float)
    blue = 255.0 * np.array(libs.colors.to_rgb(AXIS_COLOURS[2]))
    np.testing.assert_allclose(tips[True][0], blue, atol=1.0)
    np.testing.assert_allclose(tips[True][1], 0.4 * blue + 0.6 * tips[False][1], atol=1.0)  # inside, shining through


@pytest.mark.parametrize("view", [None, (0.0, -90.0), (90.0, -90.0), (-20.0, 10.0), (35.0, 135.0)])
def test_pictures_are_readable(view: tuple[float, float] | None) -> None:
    """Nothing that is written is cut off or lies on something else written."""
    compiled = scene_of((lf.Cuboid(0.2, 0.4, 0.3, mass=1.0), (0.1, 0.0, 0.0)))
    figure = result_of(compiled).draw(0.0, view=view)
    figure.draw_without_rendering()
    ax = figure.axes[0]
    boxes = [text.get_window_extent() for text in ax.texts]
    assert len(boxes) > 6
    for k, box in enumerate(boxes):
        assert figure.bbox.x0 <= box.x0
        assert box.x1 <= figure.bbox.x1
        assert figure.bbox.y0 <= box.y0
        assert box.y1 <= figure.bbox.y1
        assert not any(box.overlaps(other) for other in boxes[:k]), ax.texts[k].get_text()


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"view": (100.0, 0.0)}, r"view\[0\]: .*100.*, expected a finite number in"),
        ({"view": (1.0, 2.0, 3.0)}, r"view: an array of shape \(3,\)"),
        ({"view": (np.nan, 2.0)}, "view: an array with nan"),
        ({"view": "top"}, "view: 'top' was given, expected an array of numbers"),
        ({"frames": "all"}, "frames: 'all' was given, expected True or False"),
        ({"scale": -1.0}, r"scale: -1\.0 was given, expected a finite number in"),
        ({"scale": np.inf}, "scale: inf was given"),
    ],
)
def test_options_that_cannot_be(options: dict[str, Any], words: str, tmp_path: Path) -> None:
    result = result_of(scene_of((lf.Sphere(0.1, mass=1.0), (0.0, 0.0, 0.0))))
    with pytest.raises(ModelError, match=words):
        result.draw(0.0, **options)
    with pytest.raises(ModelError, match=words):
        result.animate(tmp_path / "film.gif", **options)


def test_axes_of_three_dimensions_are_refused() -> None:
    result = result_of(scene_of((lf.Sphere(0.1, mass=1.0), (0.0, 0.0, 0.0))))
    with pytest.raises(ModelError, match="axes: 3-D axes were given; expected plain ones"):
        result.draw(0.0, axes=libs.Figure().add_subplot(projection="3d"))


@pytest.mark.parametrize("options", [{"view": (20.0, 30.0)}, {"frames": True}, {"scale": 2.0}])
def test_options_of_space_are_refused_in_the_plane(options: dict[str, Any], swing: Result, tmp_path: Path) -> None:
    (name,) = options
    words = f"{name}: it is for pictures of a SpatialScene, expected none with a planar result"
    with pytest.raises(ModelError, match=words):
        swing.draw(0.0, **options)
    with pytest.raises(ModelError, match=words):
        swing.animate(tmp_path / "film.gif", **options)


def test_a_picture_in_axes_of_the_users() -> None:
    figure = libs.Figure()
    ax = figure.subplots(1, 2)[1]
    result = result_of(scene_of((lf.Sphere(0.1, mass=1.0), (0.0, 0.0, 0.0))))
    assert result.draw(0.0, ax) is figure
    assert len(ax.images) == 1


def test_chart_of_one_body_has_components_and_of_many_magnitudes() -> None:
    compiled = scene_of((lf.Sphere(0.1, mass=1.0), (0.0, 0.0, 0.0)))
    result = replace(result_of(compiled), u=np.tile([1.0, 2.0, 2.0, 0.0, 3.0, 4.0], (2, 1)))
    speeds, spins, energies = result.plot().axes
    assert (speeds.get_ylabel(), spins.get_ylabel()) == ("velocity [m/s]", "angular velocity\n[rad/s]")
    assert [float(line.get_ydata()[0]) for line in speeds.lines] == [1.0, 2.0, 2.0]
    assert [float(line.get_ydata()[0]) for line in spins.lines] == [0.0, 3.0, 4.0]
    assert "energy" in energies.get_ylabel()
    many = scene_of(*((lf.Sphere(0.1, mass=1.0), (k, 0.0, 0.0)) for k in range(8)))
    u = np.tile([1.0, 2.0, 2.0, 0.0, 3.0, 4.0], 8) * np.repeat(np.arange(8.0), 6)
    figure = replace(result_of(many), u=np.tile(u, (2, 1))).plot()
    assert [float(line.get_ydata()[0]) for line in figure.axes[0].lines] == pytest.approx(3.0 * np.arange(2, 8))
    assert [float(line.get_ydata()[0]) for line in figure.axes[1].lines] == pytest.approx(5.0 * np.arange(2, 8))
    assert figure.axes[0].lines[0].get_label() == "body3"
    assert figure.axes[0].get_title(loc="left").endswith("2 bodies with smaller kinetic energies are not shown")


@pytest.mark.slow
def test_film(tmp_path: Path) -> None:
    """The camera and the floor stand still, the body moves, and nothing of it stays behind."""
    compiled = scene_of((lf.Cuboid(0.2, 0.1, 0.1, mass=1.0), (0.0, 0.0, 0.0)))
    q = np.tile(compiled.q, (21, 1))
    q[:, 0] = np.linspace(0.0, 1.0, 21)
    path = result_of(compiled, q).animate(tmp_path / "film.gif", fps=10.0, slowdown=1.0, view=(20.0, -70.0))
    frames = []
    with libs.image.open(path) as film:
        assert film.n_frames == 20  # type: ignore[attr-defined]
        for k in (0, 10, 19):
            film.seek(k)
            frames.append(np.asarray(film.convert("RGB")).astype(int))
    blue = [frame[:, :, 2] - frame[:, :, 0] > 60 for frame in frames]
    written = blue[0] & blue[1] & blue[2]  # the name of an axis
    assert written.mean() < 2e-3
    blue = [where & ~written for where in blue]
    places = [np.nonzero(where)[1].mean() / where.shape[1] for where in blue]
    assert places[0] < places[1] - 0.2 < places[2] - 0.4
    assert blue[1].sum() == pytest.approx(blue[0].sum(), rel=0.1)
    assert not (blue[0] & blue[2]).any()
    floor = slice(-60, None)  # names and numbers below
    assert (np.abs(frames[0][floor] - frames[2][floor]).max(axis=2) > 40).mean() < 2e-3


def test_axes_of_bodies_are_not_cut_off() -> None:
    compiled = scene_of((lf.Cuboid(0.2, 0.01, 0.01, mass=1.0), (0.0, 0.0, 0.0)))
    picture = SpatialPicture(result_of(compiled), compiled, np.array([0]), Look(SIDE, True, 1.0))
    tall = (picture.view[3] - picture.view[2]) / (picture.view[1] - picture.view[0])
    rows = np.nonzero(picture.canvas(compiled.q, round(300 * tall), 300)[0].owner != NOBODY)[0]
    highest = picture.view[2] + rows.max() / 600 * (picture.view[1] - picture.view[0])
    assert highest == pytest.approx(0.45 * 0.2, abs=3e-3)  # the axis z, as long as it may be in a picture of that box
    assert highest < picture.view[3]


@pytest.mark.parametrize(
    ("extents", "view"),
    [
        ((0.2, 0.2, 0.2), (22.0, -60.0)),
        ((0.2, 0.2, 0.2), (5.0, -80.0)),
        ((2000.0, 300.0, 100.0), (80.0, 10.0)),
        ((0.02, 0.05, 0.01), (22.0, -95.0)),
        ((2.0, 0.4, 2.0), (22.0, -60.0)),
    ],
)
def test_numbers_do_not_run_into_each_other(extents: tuple[float, float, float], view: tuple[float, float]) -> None:
    scene = lf.SpatialScene()
    scene.add(lf.Cuboid(*extents, mass=1.0), position=(0.0, 0.0, extents[2]))
    figure = result_of(scene.compiled()).draw(0.0, view=view)
    figure.canvas.draw()
    ax = figure.axes[0]
    boxes = [text.get_window_extent() for text in ax.texts]
    for k, box in enumerate(boxes):
        for text, other in zip(ax.texts[:k], boxes[:k], strict=False):
            assert not box.overlaps(other), (ax.texts[k].get_text(), text.get_text())
    libs.plt.close(figure)
