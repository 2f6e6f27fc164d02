"""Contact pairs in space, between bodies that turn and deform, against differences in time.

Gaps are differentiated as they are; tangential velocities are those of places frozen in the material of both sides.
"""

from __future__ import annotations

import numpy as np
import pytest

from lcpflex.contact.spatial.pairs import contact_point, gap_rate
from lcpflex.contact.spatial.table import EDGE_EDGE, NODE_EDGE, NODE_FACET, NODE_POINT, RIM_FACET
from tests.space import derivatives
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
        first = of.place(q, 0) if of.table.kind[0] != EDGE_EDGE else None
        if first is not None:
            point = contact_point(of.moving.model, q, of.table, 0)
            np.testing.assert_allclose(point, first + of.lever(q, of.axes()[0]), atol=1e-14)
