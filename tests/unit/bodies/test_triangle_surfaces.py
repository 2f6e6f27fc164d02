"""Rigid bodies between triangles, of STL files and given: masses, what is no solid, damaged files."""

import math
import random
import struct
import warnings

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import lcpflex as lf
from lcpflex.bodies.spatial.hull import block
from lcpflex.bodies.spatial.surface import SpatialKind, surface_of
from lcpflex.errors import ModelError, ModelWarning
from tests.stl import BOX, as_binary, as_text, of_box, of_sphere, of_tube


@pytest.fixture
def stl(tmp_path):
    """Writes a file and gives its name."""

    def written(data, name="part.stl"):
        path = tmp_path / name
        path.write_bytes(data if isinstance(data, bytes) else as_text(data))
        return path

    return written


def on_arrays(triangles):
    """Vertices and triangles that share none."""
    return triangles.reshape(-1, 3), np.arange(3 * len(triangles)).reshape(-1, 3)


CUBE = of_box((1.0, 1.0, 1.0), elements=(3, 3, 3))
TURN = Rotation.from_rotvec([0.3, -0.8, 0.4]).as_matrix()


class TestMasses:
    @pytest.mark.parametrize("elements", [(1, 1, 1), (3, 4, 2)])
    @pytest.mark.parametrize("at", [(0.0, 0.0, 0.0), (70.0, -80.0, 90.0)])
    def test_a_box_is_a_cuboid(self, elements, at):
        box = lf.Cuboid(*BOX, density=1000.0)
        body = lf.Polyhedron(on_arrays(of_box(elements=elements) @ TURN.T + at), density=1000.0)
        assert body.mass == pytest.approx(30.0, rel=1e-12)
        assert body.origin == pytest.approx(np.array(at), abs=1e-12)
        assert body.second == pytest.approx(TURN @ box.second @ TURN.T, rel=1e-10, abs=1e-12)
        assert not body.moment.any()
        assert np.ptp(body.shape.vertices, axis=0) == pytest.approx(np.ptp(box.shape.vertices @ TURN.T, axis=0))
        assert surface_of(body.shape).kind is SpatialKind.POLYHEDRON  # touches as a Cuboid does
        assert len(body.shape.vertices) == 8

    def test_a_tetrahedron(self):
        corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 2, 0], [0, 0, 3]])
        faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
        body = lf.Polyhedron((corners, faces), density=5.0)
        assert body.mass == pytest.approx(5.0, rel=1e-14)
        assert body.origin == pytest.approx(corners.mean(axis=0), rel=1e-14)
        about = corners - corners.mean(axis=0)
        assert body.second == pytest.approx(5.0 * about.T @ about / 20.0, rel=1e-13)
        hull = lf.ConvexHull(corners, density=5.0)
        assert body.second == pytest.approx(hull.second, rel=1e-13)

    def test_spheres_converge_at_second_order(self):
        errors = []
        for size in (0.2, 0.1, 0.05):
            body = lf.Polyhedron(on_arrays(of_sphere(0.5, size * math.pi / 4.0)), density=1.0)
            sphere = lf.Sphere(0.5, density=1.0)
            errors.append([1.0 - body.mass / sphere.mass, 1.0 - np.trace(body.second) / np.trace(sphere.second)])
        rates = np.log2(np.array(errors)[:-1] / np.array(errors)[1:])
        assert (rates > 1.85).all()
        assert (rates < 2.15).all()

    def test_a_tube_is_no_convex_body(self):
        triangles = of_tube(0.3, 0.5, 1.0, 0.05)
        body = lf.Polyhedron(on_arrays(triangles + np.array([1.0, 2.0, 3.0])), mass=2.0)
        assert body.mass == 2.0
        assert body.origin == pytest.approx([1.0, 2.0, 3.0], rel=1e-12)
        wanted = [2.0 * 0.34 / 4.0, 2.0 * 0.34 / 4.0, 2.0 / 12.0]
        assert np.diag(body.second) == pytest.approx(wanted, rel=0.01)
        assert surface_of(body.shape).kind is SpatialKind.MESH
        assert len(body.shape.triangles) == len(triangles)

    def test_a_dent_makes_a_mesh(self):
        triangles = of_box((1.0, 1.0, 1.0), elements=(4, 4, 4)).copy()
        middle = np.abs(triangles - [0.0, 0.0, 0.5]).max(axis=2) < 1e-9
        for depth, kind in ((1e-3, SpatialKind.MESH), (2e-6, SpatialKind.MESH), (1e-8, SpatialKind.POLYHEDRON)):
            triangles[middle] = [0.0, 0.0, 0.5 - depth]
            assert surface_of(lf.Polyhedron(on_arrays(triangles), mass=1.0).shape).kind is kind

    def test_a_wrong_diagonal_makes_a_mesh(self):
        vertices = np.array([[0, 0, 0.0], [1, 0, 0.1], [1, 1, 0], [0, 1, 0.1], [0.5, 0.5, -1.0]])
        sides = [[1, 0, 4], [2, 1, 4], [3, 2, 4], [0, 3, 4]]
        assert lf.Polyhedron((vertices, [*sides, [0, 1, 3], [1, 2, 3]]), mass=1.0).shape.convex
        assert not lf.Polyhedron((vertices, [*sides, [0, 1, 2], [0, 2, 3]]), mass=1.0).shape.convex

    def test_shells_and_cavities(self):
        hole = of_box((0.5, 0.5, 0.5), at=(0.1, 0.0, 0.0))[:, ::-1]
        inside = of_box((0.2, 0.2, 0.2), at=(0.1, 0.0, 0.0))
        beside = of_box((1.0, 1.0, 1.0), at=(2.0, 0.0, 0.0))
        body = lf.Polyhedron(on_arrays(np.concatenate([hole, inside, CUBE, beside])), density=2.0)
        assert body.mass == pytest.approx(2.0 * (2.0 - 0.125 + 0.008), rel=1e-13)
        assert body.origin[0] == pytest.approx((2.0 - (0.125 - 0.008) * 0.1) / (2.0 - 0.125 + 0.008), rel=1e-13)
        assert not body.shape.convex

    @pytest.mark.parametrize("scale", [1e-6, 1e6])
    def test_other_units(self, scale):
        one = lf.Polyhedron(on_arrays(of_tube()), density=1.0)
        other = lf.Polyhedron(on_arrays(of_tube() * scale), density=1.0, length_unit="m")
        assert other.second == pytest.approx(one.second * scale**5, rel=1e-12, abs=1e-14 * scale**5)
        named = lf.Polyhedron(on_arrays(of_tube() / scale), density=1.0, length_unit=scale)
        assert named.second == pytest.approx(one.second, rel=1e-12, abs=1e-14)


class TestFiles:
    @pytest.mark.parametrize(
        "data",
        [
            as_text(of_box()),
            as_text(of_box(), "d\xe9j\xe0 vu").decode().encode("latin-1"),
            as_text(of_box()).replace(b"\n", b"\r\n"),
            as_text(of_box()).replace(b"\n", b"\r"),
            as_text(of_box()).upper().replace(b"E-", b"e-"),
            as_text(of_box()[:5]) + as_text(of_box()[5:], "another one"),
        ],
        ids=["lines", "latin", "windows", "mac", "upper", "two solids"],
    )
    def test_ascii(self, stl, data):
        assert lf.Polyhedron(stl(data), density=1000.0).mass == pytest.approx(30.0, rel=1e-14)

    @pytest.mark.parametrize("header", [b"made by a test", b"solid part", b"solid part\nfacet normal 0 0 1"])
    @pytest.mark.parametrize("behind", [b"", b"\n"])
    def test_binary(self, stl, header, behind):
        body = lf.Polyhedron(str(stl(as_binary(of_box(), header) + behind)), density=1000.0)
        assert body.mass == pytest.approx(30.0, rel=1e-7)
        assert body.shape.convex

    @pytest.mark.parametrize(("unit", "factor"), [("mm", 1e-3), ("in", 0.0254), (2.0, 2.0)])
    def test_length_units(self, stl, unit, factor):
        body = lf.Polyhedron(stl(of_box(BOX / factor)), density=1000.0, length_unit=unit)
        assert body.mass == pytest.approx(30.0, rel=1e-12)
        assert np.ptp(body.shape.vertices, axis=0) == pytest.approx(BOX, rel=1e-12)

    def test_millimetres_are_suspected(self, stl):
        path = stl(of_box(1e3 * BOX))
        with pytest.warns(ModelWarning, match=r"500 m long and 145 m wide.*length_unit='mm' makes it 0\.5 m"):
            lf.Polyhedron(path, density=7800.0)
        with pytest.warns(ModelWarning, match=r"6e-08 kg/m\^3, it is .*; length_unit='m'"):
            lf.Polyhedron(path, mass=1.8)
        with pytest.warns(ModelWarning, match="density of 7800 kg/m.3, it is larger than solids of it are"):
            lf.Polyhedron(on_arrays(of_box(1e3 * BOX)), density=7800.0)
        with pytest.warns(ModelWarning, match="it is too large for its mass"):
            lf.Polyhedron(stl(of_box((50.0, 30.0, 40.0))), mass=0.2)

    @pytest.mark.parametrize(
        ("sizes", "density"), [((10.0, 15.0, 8.0), 2700.0), ((0.3, 0.5, 0.2), 30.0), ((100.0, 20.0, 0.3), 400.0)]
    )
    def test_what_is_sensible_is_left_in_peace(self, stl, sizes, density):
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            lf.Polyhedron(stl(of_box(sizes)), density=density)
            lf.Polyhedron(stl(of_box(1e3 * BOX)), density=7800.0, length_unit="m")

    def test_vertices_that_are_nearly_one(self, stl):
        rng = np.random.default_rng(4)
        with pytest.warns(ModelWarning, match="closed with vertices merged that are up to 1e-06 m apart"):
            body = lf.Polyhedron(stl(CUBE + rng.uniform(-1e-7, 1e-7, CUBE.shape)), density=1.0)
        assert body.mass == pytest.approx(1.0, rel=1e-6)
        with pytest.raises(ModelError, match="108 holes"):
            lf.Polyhedron(stl(CUBE + rng.uniform(-1e-5, 1e-5, CUBE.shape)), density=1.0)

    def test_triangles_without_three_corners(self, stl):
        point, line = CUBE[:1, [0, 0, 0]], CUBE[:1, [0, 1, 0]]
        with pytest.warns(ModelWarning, match="2 triangles with two corners at one place left out, .* triangle 0"):
            body = lf.Polyhedron(stl(np.concatenate([point, CUBE, line])), density=1.0)
        assert body.mass == pytest.approx(1.0, rel=1e-14)


def turned(triangles, which):
    changed = triangles.copy()
    changed[which] = changed[which][::-1]
    return changed


def with_value(value):
    changed = CUBE.copy()
    changed[3, 1, 1] = value
    return changed


REFUSED = {
    r"edge \(\d+, \d+\) and 2 more: a hole at \(-0.5, -0.3\d+, -0.3\d+\) with 3 edges, 1.138 m": CUBE[1:],
    "and 5 more: 2 holes, of which the largest is at .* with 3 edges": np.delete(CUBE, [0, 50], axis=0),
    r"same direction, so that one is turned around \(triangle 5 at 3 edges\)": turned(CUBE, 5),
    "enclose -1 m.3, expected a positive volume": CUBE[:, ::-1],
    r"3 triangles share the edge .* at \(-0.5": np.concatenate([CUBE, CUBE[:1]]),
    "4 triangles share the edge": np.concatenate([of_box((1, 1, 1)), of_box((1, 1, 1), at=(1.0, 1.0, 0.0))]),
    "12 triangles .* lies within another": np.concatenate([CUBE, of_box((0.5, 0.5, 0.5))]),
    "12 triangles at .* is turned inside out": np.concatenate([CUBE, of_box((0.5, 0.5, 0.5), (2, 0, 0))[:, ::-1]]),
    "has twice the area": np.concatenate(
        [CUBE, [[[0, 0, 0], [1, 1, 1], [2, 2, 2]], [[2, 2, 2], [1, 1, 1], [0, 0, 0]]]]
    ),
    "triangle 3 has places that are not finite": with_value(math.nan),
    "triangle 3 has places that are not": with_value(math.inf),
    r"extent \[m\]: 1e\+300": CUBE * 1e300,
    r"extent \[m\]: 0.0": CUBE * 0.0,
    "none of its triangles has three corners": np.stack([CUBE[:2, 0], CUBE[:2, 0], CUBE[2:4, 0]], axis=1),
    "0 triangles were found": b"solid x\nendsolid x\n",
    "expected an STL file: ASCII, or binary": b"",
    "has no header and it has 5 bytes": b"stuff",
    "it ends before 'endsolid'": as_text(CUBE)[:-15],
    "line 757 is 'end', expected 'endfacet'": as_text(CUBE)[:-20],
    "tells of 108 triangles and it has 5483 bytes": as_binary(CUBE)[:-1],
    "tells of 108 triangles and it has 5534 bytes": as_binary(CUBE) + bytes(50),
    "tells of 4294967295 triangles": as_binary(CUBE)[:80] + struct.pack("<I", 2**32 - 1) + as_binary(CUBE)[84:],
    "tells of 108 triangles and it has 5434 bytes": as_binary(CUBE, b"solid")[:-50],
    "line 4 is 'vertex -0,5 .*expected 'vertex' and three numbers": as_text(CUBE).replace(b"0.5", b"0,5"),
    "line 4 is .* expected 'vertex' and three numbers": as_text(CUBE).replace(b"0.5", b"0_5"),
    "line 4 is .* expected 'vertex' and": as_text(CUBE).replace(b"0.5", b""),
    "line 3 is .* expected 'outer'": as_text(CUBE).replace(b"outer", b"inner", 1),
    "line 2 is .* expected 'facet'": as_text(CUBE).replace(b"facet", "fäcet".encode(), 1),
    "line 7 is .* expected 'endloop'": as_text(CUBE).replace(b"endloop", b"vertex 0 0 0", 1),
}


class TestRefused:
    @pytest.mark.parametrize("message", REFUSED)
    def test_files(self, stl, message):
        with pytest.raises(ModelError, match=f"surface .*part.stl'.*{message}"):
            lf.Polyhedron(stl(REFUSED[message]), density=1.0)

    @pytest.mark.parametrize(
        ("surface", "message"),
        [
            ("missing.stl", "surface 'missing.stl': there is no such file"),
            (".", "surface '.': there is no such file"),
            (3, "surface: 3 was given, expected the name of an STL file, or vertices"),
            ((CUBE,), "expected the name of an STL file, or vertices"),
            ((CUBE, CUBE), r"surface: vertices: an array of shape \(108, 3, 3\)"),
            ((CUBE[0], [[0, 1, 3]]), "surface: triangles: vertex 3 was given"),
            ((CUBE[0], [[0, 1, 1.5]]), "surface: triangles: .* integers"),
            ((CUBE[0], [[0, 1], [1]]), "surface: triangles: .* integers"),
            ((CUBE[0], np.zeros((0, 3), int)), "surface: 0 triangles were given"),
            ((CUBE[0], [[0, 1, 2]]), "surface: only one triangle has the edge"),
            ((CUBE[0] * math.nan, [[0, 1, 2]]), "surface: vertices: an array with nan"),
        ],
    )
    def test_arguments(self, surface, message):
        with pytest.raises(ModelError, match=message):
            lf.Polyhedron(surface, density=1.0)

    def test_masses(self):
        for more, message in (
            ({}, "density, mass: None and None"),
            ({"density": 1.0, "mass": 1.0}, "exactly one"),
            ({"density": -1.0}, "density: -1.0"),
            ({"density": 1.0, "length_unit": "league"}, "length_unit: 'league'"),
        ):
            with pytest.raises(ModelError, match=message):
                lf.Polyhedron(on_arrays(CUBE), **more)

    def test_files_that_are_too_large(self, tmp_path):
        with open(tmp_path / "huge.stl", "wb") as file:
            file.truncate(10**9)
        with pytest.raises(ModelError, match="it has 1000000000 bytes, expected a file of at most"):
            lf.Polyhedron(tmp_path / "huge.stl", density=1.0)

    @pytest.mark.parametrize("kind", [as_text, as_binary])
    def test_damaged_files(self, stl, kind):
        rng, whole = random.Random(7), kind(of_box(elements=(2, 1, 1)))
        ends = {"refused": 0, "taken": 0}
        for trial in range(150):
            data = bytearray(whole)
            if trial % 3 == 0:
                del data[rng.randrange(len(data)) :]
            elif trial % 3 == 1:
                for _ in range(rng.randrange(1, 4)):
                    data[rng.randrange(len(data))] = rng.randrange(256)
            else:
                start = rng.randrange(len(data))
                data[start:start] = data[start : start + rng.randrange(1, 200)]
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                warnings.simplefilter("ignore", ModelWarning)
                try:
                    body = lf.Polyhedron(stl(bytes(data)), density=1.0)
                except ModelError as error:
                    ends["refused"] += any(word in str(error) for word in ("surface", "inertia"))
                else:
                    ends["taken"] += body.mass > 0.0
        assert sum(ends.values()) == 150, ends
        assert ends["refused"] > 75, ends


def dropped(body):
    """Where a box comes to rest, 1 mm above the ground at first, flat."""
    scene = lf.SpatialScene(gravity=(0.0, 0.0, -9.81))
    box = scene.add(body, name="box", position=(0.0, 0.0, 0.101), velocity=(0.3, 0.1, 0.0))
    scene.contact(box.surface(), scene.ground.plane((0, 0, 0), (0, 0, 1)), friction=0.4)
    return lf.simulate(scene, 0.3, lf.MoreauJean(step=1e-3))


def test_boxes_from_files_come_to_rest_as_a_cuboid_does(stl):
    cuboid = dropped(lf.Cuboid(*BOX, density=1000.0))
    hollow = np.concatenate([of_box(), of_box(0.5 * BOX)[:, ::-1]])  # touches with its triangles
    for triangles in (of_box(), of_box(elements=(2, 3, 2)), hollow):
        result = dropped(lf.Polyhedron(stl(triangles), density=1000.0))
        assert result.q[-1] == pytest.approx(cuboid.q[-1], abs=1e-9)
        assert np.abs(result.u[-1]).max() < 1e-9


@pytest.mark.parametrize("first", range(12))
@pytest.mark.parametrize(
    ("low", "high", "sense", "expected"),
    [
        ((1.0, 0.2, 0.2), (2.0, 0.8, 0.8), 1, 1.36),
        ((0.5, 0.2, 0.2), (2.0, 0.8, 0.8), 1, "crosses another one|lies within another one"),
        ((0.9, 0.9, 0.9), (2.0, 2.0, 2.0), 1, "crosses another one"),
        ((0.2, 0.2, 0.0), (0.8, 0.8, 0.8), -1, 0.712),
        ((0.2, 0.2, -0.2), (0.8, 0.8, 0.8), -1, "crosses another one"),
    ],
)
def test_two_boxes_that_touch_or_cross(first, low, high, sense, expected):
    """Whichever triangle comes first: volumes of solids that touch add, and of those that cross nothing is told."""
    corners, sides = block()
    vertices = [
        (corners + 0.5) * np.subtract(end, start) + start for start, end in ((np.zeros(3), np.ones(3)), (low, high))
    ]
    triangles = [np.roll(sides, first, axis=0), np.roll(sides[:, ::sense], first, axis=0) + 8]
    surface = np.vstack(vertices), np.vstack(triangles)
    if isinstance(expected, float):
        assert lf.Polyhedron(surface, density=1.0).mass == pytest.approx(expected, rel=1e-12)
        return
    with pytest.raises(lf.ModelError, match=expected):
        lf.Polyhedron(surface, density=1.0)
