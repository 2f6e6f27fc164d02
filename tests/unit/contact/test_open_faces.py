"""Open faces of solids: shape functions, areas, feet, and rows of what touches between two of them."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import lcpflex as lf
from lcpflex.bodies.fem.faces import flat_facets
from lcpflex.bodies.spatial.body import SpatialPoint
from lcpflex.bodies.spatial.surface import SpatialKind, SpatialSurface
from lcpflex.compile.spatial.face_areas import AREAS, NODES, face_parts
from lcpflex.contact.near import near
from lcpflex.contact.rows import contact_rows
from lcpflex.contact.spatial.faces.shapes import is_inside, lay_bends, lay_shapes
from lcpflex.contact.spatial.pairs import contact_bias
from lcpflex.jit.kernel import FloatArray
from lcpflex.jit.struct import pack
from lcpflex.kinematics.spatial.configuration import advance
from lcpflex.scene.placed_surface import PlacedSurface
from tests.solid_meshes import EDGES, QUIET, solid

TRIANGLE = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (0.5, 0.0), (0.5, 0.5), (0.0, 0.5)]
SQUARE = [
    (-1.0, -1.0),
    (1.0, -1.0),
    (1.0, 1.0),
    (-1.0, 1.0),
    (0.0, -1.0),
    (1.0, 0.0),
    (0.0, 1.0),
    (-1.0, 0.0),
    (0.0, 0.0),
]
REFERENCE = {3: TRIANGLE, 4: SQUARE, 6: TRIANGLE, 8: SQUARE, 9: SQUARE}


def shapes(nodes: int, x: float, y: float) -> FloatArray:
    shape = np.zeros((9, 3))
    lay_shapes(nodes, x, y, shape)
    return shape[:nodes]


@pytest.mark.parametrize("nodes", REFERENCE)
def test_shape_functions_are_one_at_their_node_and_sum_to_one(nodes: int) -> None:
    at_nodes = [shapes(nodes, x, y)[:, 0] for x, y in REFERENCE[nodes][:nodes]]
    np.testing.assert_allclose(at_nodes, np.eye(nodes), atol=1e-15)
    np.testing.assert_allclose(shapes(nodes, 0.23, 0.31).sum(axis=0), [1.0, 0.0, 0.0], atol=1e-14)


@pytest.mark.parametrize("nodes", REFERENCE)
def test_derivatives_are_those_of_the_shape_functions(nodes: int) -> None:
    h, (x, y) = 1e-4, (0.23, 0.31)  # central differences are exact for quadratics, and to h^2 for their products
    differences = np.column_stack([
        shapes(nodes, x + h, y)[:, 0] - shapes(nodes, x - h, y)[:, 0],
        shapes(nodes, x, y + h)[:, 0] - shapes(nodes, x, y - h)[:, 0],
    ])  # fmt: skip
    np.testing.assert_allclose(shapes(nodes, x, y)[:, 1:], differences / (2.0 * h), atol=1e-7)


@pytest.mark.parametrize("nodes", REFERENCE)
def test_the_middle_is_inside_and_what_is_beside_is_not(nodes: int) -> None:
    assert is_inside(nodes, 0.2, 0.2, 0.0)
    assert not is_inside(nodes, 1.1, 0.2, 1e-6)
    assert is_inside(nodes, 1.0 - 0.2 * (nodes in (3, 6)) + 1e-7, 0.2, 1e-6)


def grid(
    nodes: int, n: int, size: float, bent: float = 0.0, middle: tuple[float, float] = (0.0, 0.0)
) -> SpatialSurface:
    """A square face about ``middle`` at z = 0, of n x n squares of elements, each of its points a mode of its own.

    bent: by how much inner nodes are moved along it, in elements.
    """
    fine = 2 * n + 1
    way = np.linspace(-0.5 * size, 0.5 * size, fine)
    places = np.array([(x, y, 0.0) for y in way for x in way])
    random = np.random.default_rng(nodes)
    inner = (np.abs(places[:, :2]) < 0.49 * size).all(axis=1)
    places[inner, :2] += bent * size / n * random.uniform(-0.2, 0.2, (inner.sum(), 2))
    places[:, :2] += middle
    cells = []
    for i in range(0, fine - 1, 2):
        for j in range(0, fine - 1, 2):
            a = np.array([[fine * (i + r) + j + c for c in range(3)] for r in range(3)])
            square = [a[0, 0], a[0, 2], a[2, 2], a[2, 0], a[0, 1], a[1, 2], a[2, 1], a[1, 0], a[1, 1]]
            if nodes in (4, 8, 9):
                cells.append(square[:nodes])
            else:
                cells += [
                    [a[0, 0], a[0, 2], a[2, 2], a[0, 1], a[1, 2], a[1, 1]][:nodes],
                    [a[0, 0], a[2, 2], a[2, 0], a[1, 1], a[2, 1], a[1, 0]][:nodes],
                ]
    used = np.unique(np.concatenate(cells))
    number = np.full(len(places), -1)
    number[used] = np.arange(len(used))
    own = tuple(number[np.array(cell)] for cell in cells)
    points = []
    for k, p in enumerate(used):
        phi = np.zeros((3 * len(used), 3))
        phi[3 * k : 3 * k + 3] = np.eye(3)
        points.append(SpatialPoint(places[p], phi, np.zeros_like(phi), False))
    triangles = np.vstack([cell[flat_facets(np.arange(nodes)[None])] for cell in own])
    return SpatialSurface(SpatialKind.FACE, tuple(points), triangles=triangles, cells=own)


def uniform_load(surface: SpatialSurface) -> FloatArray:
    """(N,) integrals of the shape functions over a plane face, by many points."""
    places = np.array([point.place for point in surface.points])
    total = np.zeros(len(places))
    at, weight = np.polynomial.legendre.leggauss(8)
    for cell in surface.cells:
        for x, a in zip(at, weight, strict=True):
            for y, b in zip(at, weight, strict=True):
                if len(cell) in (3, 6):  # the square folded to the triangle
                    u, v = 0.5 * (1.0 + x), 0.25 * (1.0 + y) * (1.0 - x)
                    scale = a * b * 0.125 * (1.0 - x)
                else:
                    u, v, scale = x, y, a * b
                shape = shapes(len(cell), float(u), float(v))
                e, f = shape[:, 1] @ places[cell], shape[:, 2] @ places[cell]
                total[cell] += scale * np.linalg.norm(np.cross(e, f)) * shape[:, 0]
    return total


@pytest.mark.parametrize("nodes", REFERENCE)
@pytest.mark.parametrize("bent", [0.0, 0.4])
def test_a_uniform_pressure_on_areas_is_that_on_the_elements(nodes: int, bent: float) -> None:
    surface = grid(nodes, 2, 0.3, bent)
    parts = face_parts(surface, AREAS)
    assert parts.pressed.min() > 0.0
    np.testing.assert_allclose(parts.pressed.sum(), 0.09, rtol=1e-12)
    forces = sum(area * point.phi.sum(axis=1) for area, point in zip(parts.pressed, parts.points, strict=True))
    expected = np.repeat(uniform_load(surface), 3)
    np.testing.assert_allclose(forces, expected, atol=1e-12 * expected.max())


@pytest.mark.parametrize("nodes", REFERENCE)
def test_only_nodes_of_linear_faces_make_pressures(nodes: int) -> None:
    parts = face_parts(grid(nodes, 2, 0.3), NODES)
    assert len(parts.points) == len(grid(nodes, 2, 0.3).points)
    if nodes in (3, 4):
        np.testing.assert_allclose(parts.pressed, uniform_load(grid(nodes, 2, 0.3)), rtol=1e-12)
    else:
        assert not parts.pressed.any()


def touching(
    slave: SpatialSurface, master: SpatialSurface, by: str, gap: float = 1e-5, turn: Any = None, margin: float = 1e-3
) -> tuple[Any, Any, int, Any]:
    """Model, table, count and configuration of two rigid plates that carry faces, the slave above the master."""

    def rigid(surface: SpatialSurface) -> SpatialSurface:
        still = tuple(SpatialPoint(p.place, np.zeros((0, 3)), np.zeros((0, 3)), False) for p in surface.points)
        return replace(surface, points=still)

    scene = lf.SpatialScene(gravity=(0, 0, 0))
    down = Rotation.from_euler("x", np.pi)
    first = scene.add(lf.Cuboid(0.3, 0.3, 0.3, density=1.0), orientation=(turn or Rotation.identity()) * down,
                      position=(0, 0, gap))  # fmt: skip
    second = scene.add(lf.Cuboid(0.3, 0.3, 0.3, density=1.0))
    placed = [
        PlacedSurface(one.scene, one.body, f"{one.name}.face", rigid(surface), lambda body: None)
        for one, surface in ((first, slave), (second, master))
    ]
    scene.contact(*placed, node_side=placed[0], points=by)
    compiled = scene.compile(indents=lambda name: True)
    model = pack(compiled.model)
    q = np.array(compiled.q)
    table, n = near(model, q, margin)
    return model, table, n, q


@pytest.mark.filterwarnings("ignore:.*is the coarser face:lcpflex.ModelWarning")
@pytest.mark.parametrize("by", [AREAS, NODES])
@pytest.mark.parametrize("nodes", REFERENCE)
@pytest.mark.parametrize("other", REFERENCE)
def test_plates_touch_with_their_whole_faces(nodes: int, other: int, by: str) -> None:
    model, table, n, q = touching(grid(nodes, 3, 0.3, 0.4), grid(other, 2, 0.3, 0.4), by)
    assert n == len(face_parts(grid(nodes, 3, 0.3), by).points)  # equal faces: none at the rim is lost
    np.testing.assert_allclose(table.gap[:n], 1e-5, atol=1e-16)
    np.testing.assert_allclose(table.normal[:n], [(0.0, 0.0, 1.0)] * n, atol=1e-12)
    if by == AREAS:
        np.testing.assert_allclose(table.area[:n].sum(), 0.09, rtol=1e-12)
    assert_moves_as_one(model, table, n, q)


def assert_moves_as_one(model: Any, table: Any, n: int, q: FloatArray) -> None:
    """No relative velocity of bodies that move and turn as one, but for what lies between: forces are then a pair.

    The reaction acts at the foot, the force beyond the gap g: friction has a couple g n x F, closed contacts none.
    """
    velocity, omega = np.array([0.3, -0.2, 0.7]), np.array([1.0, 2.0, -3.0])
    rows = np.zeros((3, 2, int(np.diff(model.bodies.dof).max())))
    for k in range(n):
        contact_rows(model, q, table, k, rows[0], rows[1:])
        moved = np.zeros(3)
        for side, b in enumerate(table.body[k]):
            at = model.bodies.place[b]
            u = np.zeros(rows.shape[2])
            u[:3] = velocity + np.cross(omega, q[at : at + 3])
            u[3:6] = Rotation.from_quat(q[at + 3 : at + 7], scalar_first=True).inv().apply(omega)
            moved += rows[:, side] @ u
        normal, tangent = table.normal[k], table.tangent[k]
        between = table.gap[k] * np.cross(omega, normal)
        expected = [0.0, between @ tangent, between @ np.cross(normal, tangent)]
        np.testing.assert_allclose(moved, expected, atol=1e-14)


@QUIET
@pytest.mark.parametrize("by", [AREAS, NODES])
@pytest.mark.parametrize("kind", ["tetra10", "hexahedron", "hexahedron27"])
def test_forces_between_two_deformed_solids_are_a_pair(kind: str, by: str) -> None:
    turn, scene = Rotation.from_rotvec([0.3, -0.2, 0.5]), lf.SpatialScene(gravity=(0, 0, 0))
    lower = solid(kind, (3, 2, 1), sets={"face": lambda x, y, z: z > EDGES[2] - 1e-9}).reduce(8, contact="face")
    upper = solid(kind, (2, 3, 1), sets={"face": lambda x, y, z: z < 1e-9}).reduce(8, contact="face")
    place, tilted = turn.apply([0.02, 0.01, EDGES[2] + 2e-3]), turn * Rotation.from_rotvec([0.01, 0.01, 0.4])
    a = scene.add(lower, "lower", orientation=turn)
    b = scene.add(upper, "upper", place, tilted)
    scene.contact(b.face("face"), a.face("face"), friction=0.3, points=by)
    compiled = scene.compile(indents=lambda name: True)
    model, q = pack(compiled.model), np.array(compiled.q)
    bend = 1e-5 * np.random.default_rng(1).normal(size=len(q))
    for at, end in zip(model.bodies.place, [*model.bodies.place[1:], len(q)], strict=True):
        q[at + 7 : end] = bend[at + 7 : end]
    table, n = near(model, q, 0.02)
    assert n > 5
    assert np.ptp(table.gap[:n]) > 1e-4
    assert_moves_as_one(model, table, n, q)


@pytest.mark.parametrize("by", [AREAS, NODES])
def test_what_is_beyond_the_rim_is_not_in_the_common_area(by: str) -> None:
    _, table, n, _ = touching(grid(9, 8, 0.3), grid(4, 2, 0.3, middle=(0.1125, 0.0)), by)
    if by == AREAS:
        np.testing.assert_allclose(table.area[:n].sum(), 0.3 * 0.1875, rtol=1e-12)  # the rim is between two elements
    assert 0 < n < len(face_parts(grid(9, 8, 0.3), by).points)
    np.testing.assert_allclose(table.gap[:n], 1e-5, atol=1e-16)


@pytest.mark.filterwarnings("ignore:.*is the coarser face:lcpflex.ModelWarning")
@pytest.mark.parametrize("by", [AREAS, NODES])
@pytest.mark.parametrize("nodes", REFERENCE)
def test_the_parts_of_a_face_make_one_law(nodes: int, by: str) -> None:
    """So that a law of a contact is that of the whole face, whatever its mesh."""
    _, table, n, _ = touching(grid(nodes, 3, 0.3), grid(4, 3, 0.3), by)
    np.testing.assert_allclose(table.weight[:n].sum(), 1.0, rtol=1e-12)


@pytest.mark.parametrize("nodes", REFERENCE)
def test_second_derivatives_are_those_of_the_first(nodes: int) -> None:
    h, (x, y) = 1e-4, (0.23, 0.31)
    bend = np.zeros((9, 3))
    lay_bends(nodes, x, y, bend)
    by_x = (shapes(nodes, x + h, y) - shapes(nodes, x - h, y))[:, 1:] / (2.0 * h)
    by_y = (shapes(nodes, x, y + h) - shapes(nodes, x, y - h))[:, 1:] / (2.0 * h)
    np.testing.assert_allclose(bend[:nodes], np.column_stack([by_x, by_y[:, 1]]), atol=1e-7)


def curved(nodes: int, radius: float) -> SpatialSurface:
    """One face of elements, moved onto a cylinder about x below it: quadratic faces are parabolas there."""
    flat = grid(nodes, 1, 0.2)
    places = np.array([point.place for point in flat.points])
    places[:, 2] = -0.5 * places[:, 1] ** 2 / radius
    return replace(flat, points=tuple(replace(p, place=place) for p, place in zip(flat.points, places, strict=True)))


@pytest.mark.parametrize("nodes", [6, 8, 9])
def test_the_bias_knows_the_curvature_that_a_node_slides_over(nodes: int) -> None:
    """Against second differences of gaps that are found anew at each place."""
    model, table, n, q = touching(grid(4, 2, 0.04, middle=(0.0, 0.04)), curved(nodes, 0.5), NODES, gap=2e-3, margin=0.1)
    assert n == len(grid(4, 2, 0.04).points)
    u = np.zeros(12)
    u[:6] = [0.02, 0.3, 0.01, 0.1, -0.2, 0.3]
    h = 1e-3
    gaps = []
    for step in (-h, 0.0, h):
        moved = q.copy()
        advance(model, q, u, step, moved)
        found, count = near(model, moved, 0.1)
        assert count == n
        gaps.append(found.gap[:n].copy())
    second = (gaps[2] - 2.0 * gaps[1] + gaps[0]) / h**2
    bias = [contact_bias(model, q, u, table, k)[0] for k in range(n)]
    np.testing.assert_allclose(bias, second, atol=1e-3 * np.abs(second).max())
    assert np.abs(second).min() > 0.05  # v^2/R = .18
