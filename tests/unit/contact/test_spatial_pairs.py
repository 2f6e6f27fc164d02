"""Contact pairs in space, between bodies that turn and deform, against differences in time.

Gaps are differentiated as they are; tangential velocities are those of places frozen in the material of both sides.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from lcpflex.contact.spatial.pairs import contact_bias, contact_point, contact_rows, gap_rate, locate
from lcpflex.contact.spatial.table import (
    EDGE_CAP,
    EDGE_EDGE,
    EDGE_FACET,
    EDGE_RIM,
    EDGE_SIDE,
    NODE_CAP,
    NODE_EDGE,
    NODE_FACET,
    NODE_POINT,
    NODE_RIM,
    NODE_SIDE,
    RIM_FACET,
    RIM_RIM,
    spatial_contact_table,
)
from lcpflex.jit.struct import pack
from lcpflex.model.spatial import SpatialPointTable
from tests.space import derivatives, model_of
from tests.spatial_pairs import Pair, pair

BODIES = [((3, 2), -1), ((0, 0), -1), ((3, 0), -1), ((0, 2), -1), ((3, 2), 0), ((3, 2), 1), ((0, 0), 0), ((0, 0), 1)]
KINDS = {
    "node on facet": (NODE_FACET, (0.0, 0.0, 0.0), 1.0),
    "ball on facet": (NODE_FACET, (0.3, 0.0, 0.0), 1.0),
    "node by edge": (NODE_EDGE, (0.0, 0.0, 0.0), 1.0),
    "ball by capsule": (NODE_EDGE, (0.3, 0.2, 0.0), 1.0),
    "ball in bore": (NODE_EDGE, (0.3, -4.0, 0.0), -1.0),
    "node by vertex": (NODE_POINT, (0.0, 0.0, 0.0), 1.0),
    "ball by ball": (NODE_POINT, (0.3, 0.2, 0.0), 1.0),
    "ball in ball": (NODE_POINT, (0.3, -4.0, 0.0), -1.0),
    "edges": (EDGE_EDGE, (0.0, 0.0, 0.0), 1.0),
    "capsules": (EDGE_EDGE, (0.3, 0.2, 0.0), -1.0),
    "disc": (RIM_FACET, (0.0, 0.0, 0.7), 1.0),
    "torus": (RIM_FACET, (0.2, 0.0, 0.7), 1.0),
    "node by side": (NODE_SIDE, (0.0, 0.0, 0.7), 1.0),
    "ball by side": (NODE_SIDE, (0.3, 0.0, 0.7), 1.0),
    "node on cap": (NODE_CAP, (0.0, 0.0, 0.7), 1.0),
    "ball under cap": (NODE_CAP, (0.3, 0.0, 0.7), -1.0),
    "node by rim": (NODE_RIM, (0.0, 0.0, 0.2), -1.0),
    "ball by rim": (NODE_RIM, (0.3, 0.0, 0.2), 1.0),
    "capsule by side": (EDGE_SIDE, (0.3, 0.0, 0.7), -1.0),
    "capsule by rim": (EDGE_RIM, (0.3, 0.0, 0.2), 1.0),
    "edge by rim": (EDGE_RIM, (0.0, 0.0, 0.7), -1.0),
    "rim by rim": (RIM_RIM, (0.0, 0.4, 0.7), 1.0),
}
STEP = 1e-3
CLOSE = {"rtol": 1e-8, "atol": 1e-8}


@pytest.fixture(params=KINDS)
def kind(request: pytest.FixtureRequest) -> tuple[int, tuple[float, float, float], float]:
    return KINDS[request.param]


def pairs(kind: tuple[int, tuple[float, float, float], float]) -> list[Pair]:
    """Of a kind, between all sorts of bodies."""
    return [
        pair(kind[0], 10 * k + seed, modes, grounded, kind[1], kind[2])
        for k, (modes, grounded) in enumerate(BODIES)
        for seed in range(2)
    ]


def acceleration(of: Pair) -> np.ndarray:
    return np.random.default_rng(5).standard_normal(len(of.moving.u))


def test_normal_rows_are_the_gradient_of_the_gap(kind):
    for of in pairs(kind):
        q, u = of.moving.q, of.moving.u
        row = of.rows(q)[0]
        for k in range(len(u)):
            of.moving.u = np.eye(len(u))[k]
            slope, _ = derivatives(lambda t, of=of: of.gap(of.moving.at(t)), STEP)
            np.testing.assert_allclose(row[k], slope, **CLOSE)
        of.at(q)
        np.testing.assert_allclose(gap_rate(of.moving.model, q, u, of.table, 0), row @ u, rtol=1e-12, atol=1e-13)


def test_normal_bias_makes_the_second_derivative_of_the_gap(kind):
    for of in pairs(kind):
        q, u, a = of.moving.q, of.moving.u, acceleration(of)
        _, second = derivatives(lambda t, of=of, a=a: of.gap(of.moving.at(t, a)), 2 * STEP)
        np.testing.assert_allclose(of.rows(q)[0] @ a + of.bias(q, u)[0], second, rtol=1e-6, atol=1e-6)


def test_rows_are_velocities_of_the_material_that_touches(kind):
    for of in pairs(kind):
        q, u = of.moving.q, of.moving.u
        between, axes, rows = of.frozen(q), of.axes(), of.rows(q)
        velocity, _ = derivatives(lambda t, of=of, between=between: between(of.moving.at(t)), STEP)
        np.testing.assert_allclose(rows @ u, axes @ velocity, **CLOSE)


def test_biases_make_the_rates_of_the_velocities(kind):
    for of in pairs(kind):
        q, u, a = of.moving.q, of.moving.u, acceleration(of)
        rate, _ = derivatives(lambda t, of=of, u=u, a=a: of.rows(of.moving.at(t, a)) @ (u + t * a), STEP)
        np.testing.assert_allclose(of.rows(q) @ a + of.bias(q, u), rate, **CLOSE)


def test_normal_and_tangents_are_orthonormal(kind):
    for of in pairs(kind):
        axes = of.axes()
        np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-14)


def test_gap_is_the_distance_between_what_touches(kind):
    for of in pairs(kind):
        q = of.moving.q
        apart = of.frozen(q)(q)
        np.testing.assert_allclose(of.axes() @ apart, [of.table.gap[0], 0.0, 0.0], atol=1e-13)
        first = of.place(q, 0) if of.table.kind[0] not in (EDGE_EDGE, EDGE_SIDE, EDGE_RIM, RIM_RIM) else None
        if first is not None:
            point = contact_point(of.moving.model, q, of.table, 0)
            np.testing.assert_allclose(point, first + of.lever(q, of.axes()[0]), atol=1e-14)


def with_point(of: Pair, body: int, at: np.ndarray) -> tuple[Any, int]:
    """The model of a pair between rigid bodies, and in it one more material point of a body, at a place."""
    points, model = SpatialPointTable(), of.moving.model
    for k in range(len(model.points.place)):
        points.add(int(model.points.body[k]), model.points.place[k], np.zeros((0, 3)), np.zeros((0, 3)))
    frame = of.moving.q[7 * body : 7 * body + 7]
    own = Rotation.from_quat(frame[3:], scalar_first=True).inv().apply(at - frame[:3])
    points.add(body, own, np.zeros((0, 3)), np.zeros((0, 3)))
    return pack(model_of((0, 0), points)), len(model.points.place)


def told(model: Any, of: Pair, table: Any) -> tuple[float, np.ndarray, np.ndarray]:
    """Gap, rows and biases of entry 0."""
    q, u = of.moving.q, of.moving.u
    locate(model, q, table, 0)
    rows = np.zeros((3, 2, 6))
    contact_rows(model, q, table, 0, rows[0], rows[1:])
    return float(table.gap[0]), rows, np.array(contact_bias(model, q, u, table, 0))


@pytest.mark.parametrize("half", [1.0, -1.0])
def test_an_edge_on_the_end_of_a_cylinder_moves_as_a_node_of_it_there(half):
    for seed in range(4):
        of = pair(EDGE_CAP, seed, (0, 0), -1, (0.0, 0.0, 2.5), (-1.0) ** seed)
        of.table.foot[0, 1] = half
        of.at(of.moving.q)
        s = of.table.foot[0, 0]
        place = (1.0 - s) * of.place(of.moving.q, 0) + s * of.place(of.moving.q, 1)
        o, x = of.place(of.moving.q, 2), of.place(of.moving.q, 3)
        a = (x - o) / np.linalg.norm(x - o)
        assert abs(np.linalg.norm(np.cross(a, place - o)) - 2.5) < 1e-12  # on the circle about the end
        model, node = with_point(of, 0, place)
        first = told(model, of, of.table)
        of.table.kind[0], of.table.point[0, :3] = NODE_CAP, [node, 2, 3]
        for one, other in zip(first, told(model, of, of.table), strict=True):
            np.testing.assert_allclose(one, other, atol=1e-12)


def test_an_axis_over_a_face_moves_as_a_ball_over_it():
    """Of cylinders that lie on a face: the axis is the edge of j, the face is one of i, or the other way."""
    for seed in range(8):
        of = pair(EDGE_EDGE, seed, (0, 0), -1, (0.0, 0.0, 0.0))
        across = np.random.default_rng(seed).uniform(-1, 1, 3)
        face = seed % 2  # of body i or j
        model, corner = with_point(of, face, across)
        of.table.kind[0], of.table.point[0, 4], of.table.radius[0, 1 - face] = EDGE_FACET, corner, 0.3
        gap, rows, bias = told(model, of, of.table)
        s, first = of.table.foot[0, 1 - face], 2 - 2 * face
        axis = (1.0 - s) * of.place(of.moving.q, first) + s * of.place(of.moving.q, first + 1)
        of.moving.model = model
        model, node = with_point(of, 1 - face, axis)
        before = of.table.normal[0].copy()
        ball = pack(spatial_contact_table(1))
        ball.kind[0], ball.radius[0, 0], ball.sense[0], ball.along[0] = NODE_FACET, 0.3, 1.0, -1
        sides = [2 * face, 2 * face + 1, corner]
        plane = sides if triangle_faces(of, sides, before, face) else [sides[1], sides[0], corner]
        ball.point[0, :4] = [node, *plane]
        ball.body[0] = [1 - face, face]
        as_ball = told(model, of, ball)
        assert abs(gap - as_ball[0]) < 1e-12
        np.testing.assert_allclose(rows[0], as_ball[1][0][::-1] if face == 0 else as_ball[1][0], atol=1e-12)
        assert abs(bias[0] - as_ball[2][0]) < 1e-11


def triangle_faces(of: Pair, points: list[int], n: np.ndarray, face: int) -> bool:
    """Whether a triangle of points, counter-clockwise, faces the other body as the normal n, from j to i, has it."""
    a, b, c = (of.place(of.moving.q, p) for p in points)
    return bool(np.cross(b - a, c - a) @ n * (1.0 if face == 1 else -1.0) > 0.0)


def test_tangent_of_spheres_changes_its_axis_only_where_that_comes_close_to_the_normal():
    of = pair(NODE_POINT, 0, (0, 0), 1, (0.3, 0.2, 0.0))
    points, q = of.moving.model.points, of.moving.q.copy()
    o, axes = points.place[1], []
    for angle in np.linspace(0.0, 4.0 * np.pi, 200):
        q[:3] = o + np.array([np.cos(angle), np.sin(angle), 0.0]) - (of.place(of.moving.q, 0) - of.moving.q[:3])
        of.at(q)
        np.testing.assert_allclose(of.axes() @ of.axes().T, np.eye(3), atol=1e-14)
        np.testing.assert_allclose(of.axes()[0], [np.cos(angle), np.sin(angle), 0.0], atol=1e-12)
        axes.append(int(of.table.along[0]))
    assert np.count_nonzero(np.diff(axes)) <= 1  # the third axis stays normal to all normals


def test_centres_that_coincide_keep_the_normal():
    for kind in (NODE_POINT, NODE_EDGE):
        of = pair(kind, 0, (0, 0), 1, (0.3, 0.2, 0.0))
        q, before = of.moving.q.copy(), of.axes()
        q[:3] += of.moving.model.points.place[1] - of.place(q, 0)
        assert of.gap(q) == pytest.approx(-0.5, abs=1e-14)
        np.testing.assert_array_equal(of.axes(), before)
        assert np.isfinite(of.rows(q)).all()
        assert np.isfinite(of.bias(q, of.moving.u)).all()


def test_parallel_edges_have_no_feet():
    of = pair(EDGE_EDGE, 0, (0, 0), 1)
    points, q, before = of.moving.model.points, of.moving.q.copy(), of.axes()
    e, f = (points.place[end + 1] - points.place[end] for end in (0, 2))
    e, f = e / np.linalg.norm(e), f / np.linalg.norm(f)
    turn = np.append(1.0 + e @ f, np.cross(e, f))
    q[3:7] = turn / np.linalg.norm(turn)
    of.at(q)
    assert np.isinf(of.table.foot[0]).all()
    np.testing.assert_array_equal(of.axes(), before)
    assert not np.isfinite(of.rows(q)[:, 3:6]).any()  # no number that looks right


def flat_disc(tilt: float) -> Pair:
    """Over the plane z = 0 of the ground, its axis tilted from z."""
    of = pair(RIM_FACET, 0, (0, 0), 1, (0.0, 0.0, 0.7))
    points, q = of.moving.model.points, of.moving.q.copy()
    of.moving.u[:] = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, *of.moving.u[6:]]
    a = points.place[1] - points.place[0]
    a /= np.linalg.norm(a)
    at = of.axes()[0]
    across = np.cross(at, [1.0, 0.0, 0.0])
    goal = np.cos(tilt) * at + np.sin(tilt) * across / np.linalg.norm(across)
    turn = np.append(1.0 + a @ goal, np.cross(a, goal))
    q[3:7] = turn / np.linalg.norm(turn)
    of.moving.q = q
    of.at(q)
    return of


@pytest.mark.parametrize("tilt", [0.0, 1e-9, 1e-5, 1e-2])
def test_height_of_a_disc_that_nearly_lies_flat(tilt):
    of = flat_disc(tilt)
    center = of.place(of.moving.q, 0) - of.place(of.moving.q, 2)
    np.testing.assert_allclose(of.table.gap[0], of.axes()[0] @ center - 0.7 * np.sin(tilt), atol=1e-15)
    assert np.isfinite(of.rows(of.moving.q)).all()
    assert np.isfinite(of.bias(of.moving.q, of.moving.u)).all()
