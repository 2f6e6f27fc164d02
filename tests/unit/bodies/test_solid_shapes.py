"""Meshes of hexahedra of simple shapes: volumes, boundaries, sizes, and what is refused."""

import itertools
import math

import numpy as np
import pytest

from lcpflex.bodies.fem.hex_mesh import boundary_quads
from lcpflex.bodies.fem.solid_shapes import ball, bar, box, cylinder, tube
from lcpflex.errors import ModelError

CORNERS = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]])
NEIGHBOURS = [(1, 3, 4), (2, 0, 5), (3, 1, 6), (0, 2, 7), (7, 5, 0), (4, 6, 1), (5, 7, 2), (6, 4, 3)]
ROUND = 0.5 * np.array([math.cos(0.3), math.sin(0.3), 0.0])
DIAGONAL = 0.5 * np.array([math.sqrt(0.5), math.sqrt(0.5), 0.0])
SKEW = 0.5 * np.array([0.36, 0.48, 0.8])
SHAPES = {
    "box": lambda near=None, s=1.0, size=0.1: box((0.3 * s, 0.6 * s, 1.0 * s), size * s, near=near),
    "bar": lambda near=None, s=1.0, size=0.1: bar(1.0 * s, 0.4 * s, 0.3 * s, size * s, near=near),
    "cylinder": lambda near=None, s=1.0, size=0.1: cylinder(0.5 * s, 1.0 * s, size * s, near=near),
    "tube": lambda near=None, s=1.0, size=0.1: tube(0.3 * s, 0.5 * s, 1.0 * s, size * s, near=near),
    "ball": lambda near=None, s=1.0, size=0.1: ball(0.5 * s, size * s, near=near),
}
PLACES = {  # of the surface
    "box": [(0.15, 0.1, 0.2), (-0.15, 0.3, 0.5), (0.0, 0.0, -0.5)],
    "bar": [(0.9, 0.0, -0.15), (0.0, 0.0, 0.0), (1.0, 0.2, 0.13)],
    "cylinder": [ROUND, DIAGONAL, (0.1, -0.05, 0.5), (0.32, 0.25, 0.5), (0.0, 0.0, -0.5), (-0.5, 0.0, 0.5)],
    "tube": [ROUND, (0.0, -0.3, 0.1), (-0.4, 0.0, 0.5), 1.0 * DIAGONAL],
    "ball": [(0.0, 0.0, -0.5), SKEW, ROUND, DIAGONAL, 0.5 * np.ones(3) / math.sqrt(3.0)],
}
CASES = [(name, place) for name, places in PLACES.items() for place in places]
FEW = [(name, place) for name, places in PLACES.items() for place in places[:2]]


def moments(mesh):
    """Volume, integral of x and of x x^T of trilinear elements, exactly."""
    points, weights = np.polynomial.legendre.leggauss(3)
    volume, first, second = 0.0, np.zeros(3), np.zeros((3, 3))
    at = mesh.places[mesh.cells]
    for (x, a), (y, b), (z, c) in itertools.product(zip(0.5 * (1 + points), 0.5 * weights, strict=True), repeat=3):
        factors = np.where(CORNERS, [x, y, z], 1.0 - np.array([x, y, z]))
        slopes = [np.where(CORNERS[:, k], 1, -1) * np.delete(factors, k, 1).prod(axis=1) for k in range(3)]
        J = np.stack([np.einsum("n,mnk->mk", slope, at) for slope in slopes], axis=1)
        dV, place = a * b * c * np.linalg.det(J), np.einsum("n,mnk->mk", factors.prod(axis=1), at)
        volume += dV.sum()
        first += dV @ place
        second += np.einsum("m,mi,mj->ij", dV, place, place)
    return volume, first, second


def scaled_jacobians(mesh):
    """(m,) the smallest determinant of unit edges at a corner of each element."""
    at = mesh.places[mesh.cells]
    found = []
    for corner, others in enumerate(NEIGHBOURS):
        arms = [at[:, other] - at[:, corner] for other in others]
        a, b, c = (arm / np.linalg.norm(arm, axis=1, keepdims=True) for arm in arms)
        found.append(np.einsum("mi,mi->m", a, np.cross(b, c)))
    return np.min(found, axis=0)


def enclosed(mesh, quads):
    """Volume behind quadrilaterals, each as two triangles: of plane ones exactly."""
    a, b, c, d = np.moveaxis(mesh.places[quads], 1, 0)
    return (np.linalg.det(np.stack([a, b, c], 1)).sum() + np.linalg.det(np.stack([a, c, d], 1)).sum()) / 6.0


class TestVolumes:
    def test_blocks_are_exact(self):
        mesh, sizes = box((0.3, 0.6, 1.0), 0.09), np.array([0.3, 0.6, 1.0])
        volume, first, second = moments(mesh)
        assert volume == pytest.approx(0.18, rel=1e-13)
        assert first == pytest.approx(np.zeros(3), abs=1e-15)
        assert second == pytest.approx(0.18 / 12.0 * np.diag(sizes**2), rel=1e-12, abs=1e-15)

    def test_a_bar_begins_at_the_origin(self):
        volume, first, second = moments(bar(2.0, 0.4, 0.2, 0.1, near={"c": ((1.7, 0.2, 0.0), 0.04, 0.1)}))
        assert volume == pytest.approx(0.16, rel=1e-13)
        assert first / volume == pytest.approx([1.0, 0.0, 0.0], abs=1e-14)
        assert np.diag(second) == pytest.approx([0.16 * 4.0 / 3.0, 0.16 * 0.16 / 12.0, 0.16 * 0.04 / 12.0])

    @pytest.mark.parametrize("name", ["cylinder", "tube", "ball"])
    def test_curved_ones_converge_at_second_order(self, name):
        R, r = 0.5, 0.3
        volume, across, along = {
            "cylinder": (math.pi * R**2, math.pi * R**4 / 4.0, math.pi * R**2 / 12.0),
            "tube": (math.pi * (R**2 - r**2), math.pi * (R**4 - r**4) / 4.0, math.pi * (R**2 - r**2) / 12.0),
            "ball": (4.0 / 3.0 * math.pi * R**3, *[4.0 / 15.0 * math.pi * R**5] * 2),
        }[name]
        errors = []
        for around in (3, 6, 12):
            found, first, second = moments(SHAPES[name](size=0.5 * math.pi * R / around))
            assert first == pytest.approx(np.zeros(3), abs=1e-14)
            assert second == pytest.approx(np.diag(np.diag(second)), abs=1e-14)
            wanted = [volume, across, across, along]
            errors.append(1.0 - np.array([found, *np.diag(second)]) / wanted)
        errors = np.array(errors)
        assert (errors > 0.0).all()  # polyhedra with their corners on the shape are inside of it
        rates = np.log2(errors[:-1] / errors[1:])
        assert (rates > 1.85).all()
        assert (rates < 2.15).all()

    @pytest.mark.parametrize("size", [0.5, 0.2, 0.1, 0.05])
    @pytest.mark.parametrize(("name", "least"), [("box", 1.0), ("cylinder", 0.76), ("tube", 0.92), ("ball", 0.66)])
    def test_elements_are_well_shaped(self, name, least, size):
        assert scaled_jacobians(SHAPES[name](size=size)).min() > least - 1e-12

    @pytest.mark.parametrize("name", SHAPES)
    def test_one_size_above_the_body(self, name):
        mesh = SHAPES[name](size=50.0)
        assert len(mesh.cells) == {"box": 1, "bar": 1, "cylinder": 12, "tube": 8, "ball": 32}[name]
        assert scaled_jacobians(mesh).min() > 0.66

    def test_numbers_of_elements(self):
        mesh = bar(1.0, 0.2, 0.1, elements=(10, 3, 2))
        assert len(mesh.cells) == 60
        assert len(mesh.places) == 11 * 4 * 3
        assert len(box((1, 1, 1), elements=[1, 2, 3]).faces["left"]) == 6

    def test_sizes_that_divide_lengths(self):
        assert len(box((0.3, 0.6, 0.7), 0.1).cells) == 3 * 6 * 7
        assert len(box((0.3, 0.6, 0.7), 0.0999).cells) == 4 * 7 * 8


class TestBoundary:
    @pytest.mark.parametrize(("name", "place"), [*FEW, *((name, None) for name in SHAPES)])
    def test_faces_are_the_boundary(self, name, place):
        mesh = SHAPES[name]() if place is None else SHAPES[name]({"spot": (place, 0.04, 0.1)}, size=0.15)
        assert scaled_jacobians(mesh).min() > 0.5
        assert np.array_equal(np.unique(mesh.cells), np.arange(len(mesh.places)))
        ordered = mesh.places[np.lexsort(mesh.places.T)]
        assert np.linalg.norm(np.diff(ordered, axis=0), axis=1).min() > 1e-4  # no node twice
        quads = np.concatenate([of for face, of in mesh.faces.items() if face != "spot"])
        every = boundary_quads(mesh.cells)
        assert sorted(map(tuple, np.sort(quads, axis=1))) == sorted(map(tuple, np.sort(every, axis=1)))
        edges = np.concatenate([quads[:, [k, (k + 1) % 4]] for k in range(4)])
        there, back = edges @ [len(mesh.places), 1], edges @ [1, len(mesh.places)]
        assert len(np.unique(there)) == len(there)
        assert np.array_equal(np.sort(there), np.sort(back))
        assert enclosed(mesh, quads) == pytest.approx(moments(mesh)[0], rel=0.01)

    def test_where_they_are(self):
        mesh = box((1.0, 2.0, 3.0), 0.5)
        ends = {"left": (0, -0.5), "right": (0, 0.5), "front": (1, -1.0), "back": (1, 1.0), "bottom": (2, -1.5)}
        for name, (axis, value) in {**ends, "top": (2, 1.5)}.items():
            assert (mesh.places[mesh.faces[name], axis] == value).all()
        mesh = tube(0.3, 0.5, 1.0, 0.1)
        for name, radius in (("inner", 0.3), ("outer", 0.5)):
            nodes = mesh.places[np.unique(mesh.faces[name])]
            assert np.hypot(nodes[:, 0], nodes[:, 1]) == pytest.approx(np.full(len(nodes), radius), rel=1e-15)
        mesh = cylinder(0.5, 1.0, 0.1)
        nodes = mesh.places[np.unique(mesh.faces["side"])]
        assert np.hypot(nodes[:, 0], nodes[:, 1]) == pytest.approx(np.full(len(nodes), 0.5), rel=1e-15)
        assert (mesh.places[mesh.faces["top"], 2] == 0.5).all()
        assert (mesh.places[mesh.faces["bottom"], 2] == -0.5).all()
        mesh = ball(0.5, 0.1)
        nodes = mesh.places[np.unique(mesh.faces["surface"])]
        assert np.linalg.norm(nodes, axis=1) == pytest.approx(np.full(len(nodes), 0.5), rel=1e-15)


class TestNear:
    @pytest.mark.parametrize(("name", "place"), CASES)
    def test_sizes(self, name, place):
        finest = 0.02
        place, radius = np.asarray(place), 4.0 * finest
        mesh = SHAPES[name]({"spot": (place, finest, radius)})
        distance, longest = np.linalg.norm(mesh.places - place, axis=1), mesh.longest_edges()
        inside = (distance <= radius)[mesh.cells].any(axis=1)
        assert longest[inside].max() <= finest * (1.0 + 1e-9)
        assert longest[inside].max() >= 0.6 * finest
        assert longest.max() <= 0.1 * (1.0 + 1e-9)
        assert longest.max() >= 0.08
        nodes = np.unique(mesh.faces["spot"])
        assert distance[nodes].max() <= radius
        assert distance[nodes].min() <= 1e-12  # one is on the place
        assert distance[nodes].max() >= radius - 1.5 * finest  # up to the rim

    @pytest.mark.parametrize(("name", "place"), FEW)
    def test_neighbours_grow_slowly(self, name, place):
        mesh = SHAPES[name]({"spot": (place, 0.02, 0.05)})
        near = np.linalg.norm(mesh.places - place, axis=1)[mesh.cells].max(axis=1) < 0.2
        for behind, ahead in (([0, 3, 7, 4], [1, 2, 6, 5]), ([0, 1, 5, 4], [3, 2, 6, 7]), (range(4), range(4, 8))):
            behind, ahead = mesh.cells[near][:, list(behind)], mesh.cells[near][:, list(ahead)]
            length = np.linalg.norm(mesh.places[ahead] - mesh.places[behind], axis=2).max(axis=1)
            element = {tuple(sorted(row)): n for n, row in enumerate(ahead.tolist())}
            pairs = [(element.get(tuple(sorted(row))), n) for n, row in enumerate(behind.tolist())]
            ratios = np.array([length[n] / length[m] for m, n in pairs if m is not None])
            assert len(ratios) > 20
            assert max(ratios.max(), 1.0 / ratios.min()) < 1.42

    def test_neighbours_grow_as_they_are_told(self):
        """Beyond the radius h = .02 + ln(growth) distance, of which the steps from line to line are those."""
        counts = []
        for growth in (1.1, 1.28402541669, 2.0):
            mesh = box((8.0, 0.5, 0.5), 1.0, near={"spot": ((0.0, 0.0, 0.25), 0.02, 0.04, growth)})
            lines = np.unique(np.round(mesh.places[:, 0], 9))
            steps = np.diff(lines[lines > 0.06 - 1e-9])
            grown = steps[:-1] < 0.4  # the longest of all are 1 m
            assert (steps[1:] / steps[:-1])[grown].mean() == pytest.approx(growth, rel=0.06)
            counts.append(len(lines))
        assert counts[0] > counts[1] > counts[2]
        default = box((8.0, 0.5, 0.5), 1.0, near={"spot": ((0.0, 0.0, 0.25), 0.02, 0.04)})
        assert len(np.unique(np.round(default.places[:, 0], 9))) == counts[1]

    def test_faces_of_a_place_stay_on_its_side(self):
        mesh = box((1.0, 1.0, 0.1), 0.1, near={"spot": ((0.1, 0.2, 0.05), 0.02, 0.3)})
        assert (mesh.places[mesh.faces["spot"], 2] == 0.05).all()

    def test_several(self):
        places = {"a": ((0.5, 0.0, 0.0), 0.02), "b": ((-0.5, 0.0, 0.0), 0.03), "c": ((0.5, 0.05, 0.0), 0.02)}
        mesh = tube(0.3, 0.5, 0.4, 0.1, near={"a": places["a"], "b": places["b"]})
        assert {"a", "b"} < set(mesh.faces)
        mesh = box((1.0, 1.0, 1.0), 0.2, near=places)
        for name, (place, finest) in places.items():
            inside = (np.linalg.norm(mesh.places - place, axis=1) <= 8.0 * finest)[mesh.cells].any(axis=1)
            assert mesh.longest_edges()[inside].max() <= finest * (1.0 + 1e-9)
            assert np.linalg.norm(mesh.places[mesh.faces[name]] - place, axis=2).min() < 1e-12

    def test_a_ball_has_shells_about_one_place(self):
        place = np.array([0.0, 0.0, -0.5])
        one = ball(0.5, 0.15, near={"c": (place, 0.002, 0.006)})
        two = ball(0.5, 0.15, near={"c": (place, 0.002, 0.006), "d": (-place, 0.15)})
        assert len(one.cells) < 5000 < 10 * len(one.cells) < len(two.cells)
        for mesh in (one, two):
            inside = (np.linalg.norm(mesh.places - place, axis=1) <= 0.006)[mesh.cells].any(axis=1)
            assert mesh.longest_edges()[inside].max() <= 0.002 * (1.0 + 1e-9)
            assert mesh.longest_edges().max() <= 0.15 * (1.0 + 1e-9)
            assert scaled_jacobians(mesh).min() > 0.65
            assert moments(mesh)[0] == pytest.approx(math.pi / 6.0, rel=0.03)

    def test_a_place_beside_the_surface_is_put_onto_it(self):
        there = ball(0.5, 0.1, near={"c": ((0.0, 0.0, -0.5), 0.02)})
        beside = ball(0.5, 0.1, near={"c": ((0.0, 0.0, -0.505), 0.02)})
        assert there.places.tobytes() == beside.places.tobytes()

    @pytest.mark.parametrize("name", SHAPES)
    def test_equal_runs_are_equal(self, name):
        one, other = (SHAPES[name]({"c": (PLACES[name][0], 0.05)}) for _ in range(2))
        assert one.places.tobytes() == other.places.tobytes()
        assert one.cells.tobytes() == other.cells.tobytes()

    @pytest.mark.parametrize("scale", [1e-6, 1e6])
    @pytest.mark.parametrize("name", SHAPES)
    def test_other_units(self, name, scale):
        place = np.asarray(PLACES[name][0])
        one = SHAPES[name]({"c": (place, 0.05, 0.1)}, size=0.2)
        other = SHAPES[name]({"c": (scale * place, scale * 0.05, scale * 0.1)}, scale, 0.2)
        assert np.array_equal(one.cells, other.cells)
        assert other.places == pytest.approx(scale * one.places, rel=1e-9, abs=1e-10 * scale)
        assert np.array_equal(one.faces["c"], other.faces["c"])


REFUSED = {
    "sizes: an array of shape": lambda: box((1, 2), 0.1),
    r"sizes\[1\]: 0.0": lambda: box((1, 0.0, 1), 0.1),
    "finite numbers": lambda: box((1, math.nan, 1), 0.1),
    "size: 0": lambda: box((1, 1, 1), 0),
    "size: nan": lambda: ball(1.0, math.nan),
    "size: 'x'": lambda: cylinder(1.0, 1.0, "x"),
    "size, elements: None and None": lambda: box((1, 1, 1)),
    "expected exactly one": lambda: box((1, 1, 1), 0.1, elements=(1, 1, 1)),
    "near: it was given with elements": lambda: box((1, 1, 1), elements=(1, 1, 1), near={}),
    "elements: 2 were given": lambda: bar(1, 1, 1, elements=(1, 1)),
    r"elements\[1\]: 0": lambda: bar(1, 1, 1, elements=(1, 0, 1)),
    r"elements: a mesh of 1e\+09": lambda: bar(1, 1, 1, elements=(1000, 1000, 1000)),
    r"size: a mesh of 1e\+09": lambda: box((1, 1, 1), 1e-3),
    r"size: a mesh of 1e\+40": lambda: box((1, 1, 1), 1e-40),
    "size: a mesh of": lambda: ball(1.0, 1e-3),
    "near: a mesh of": lambda: ball(1.0, 0.1, near={"c": ((0, 0, 1), 1e-5), "d": ((0, 0, -1), 1e-5)}),
    "radius: -1": lambda: ball(-1, 0.1),
    "outer: 0.5": lambda: tube(0.5, 0.5, 1.0, 0.1),
    "near: 3": lambda: ball(1.0, 0.1, near=3),
    "near: the name 'surface'": lambda: ball(1.0, 0.1, near={"surface": ((0, 0, 1), 0.05)}),
    r"near\['c'\]: 5": lambda: ball(1.0, 0.1, near={"c": 5}),
    r"near\['c'\]: .* expected a place": lambda: ball(1.0, 0.1, near={"c": ((0, 0, 1),)}),
    r"near\['c'\]: place: an array of shape": lambda: ball(1.0, 0.1, near={"c": ((0, 1), 0.05)}),
    r"near\['c'\]: place: .* 0.2 m from": lambda: ball(1.0, 0.1, near={"c": ((0, 0, 1.2), 0.05)}),
    r"near\['c'\]: place: .* 0.5 m from": lambda: box((1, 1, 1), 0.1, near={"c": ((0, 0, 0), 0.05)}),
    r"near\['c'\]: place: .* 1 m from": lambda: ball(1.0, 0.1, near={"c": ((0, 0, 0), 0.05)}),
    r"near\['c'\]: place: .* 0.3 m from": lambda: tube(0.3, 0.9, 1.0, 0.1, near={"c": ((0, 0, 0), 0.05)}),
    r"near\['c'\]: finest: 0.2": lambda: ball(1.0, 0.1, near={"c": ((0, 0, 1), 0.2)}),
    r"near\['c'\]: finest: nan": lambda: ball(1.0, 0.1, near={"c": ((0, 0, 1), math.nan)}),
    r"near\['c'\]: radius: 0.01": lambda: ball(1.0, 0.1, near={"c": ((0, 0, 1), 0.02, 0.01)}),
    r"near\['c'\]: radius: 0.05 m was given, and no face": lambda: ball(1.0, 0.1, near={"c": ((0, 0, 1), 0.05, 0.05)}),
    r"near\['c'\]: growth: 1.0 was": lambda: ball(1.0, 0.1, near={"c": ((0, 0, 1), 0.02, 0.1, 1.0)}),
    r"near\['c'\]: growth: 4.0 was": lambda: ball(1.0, 0.1, near={"c": ((0, 0, 1), 0.02, 0.1, 4.0)}),
    r"near\['c'\]: growth: 'fast' ": lambda: ball(1.0, 0.1, near={"c": ((0, 0, 1), 0.02, 0.1, "fast")}),
    r"near\['c'\]: radius: inf": lambda: ball(1.0, 0.1, near={"c": ((0, 0, 1), 0.02, math.inf)}),
}


@pytest.mark.parametrize("message", REFUSED)
def test_what_is_refused(message):
    with pytest.raises(ModelError, match=message):
        REFUSED[message]()
