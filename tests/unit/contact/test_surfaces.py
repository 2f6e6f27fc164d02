"""Surfaces as flat arrays: which is the node side, outward normals, reach, bounds, refusals."""

from __future__ import annotations

import math

import numpy as np
import pytest

from lcpflex.bodies import body, surface as shapes
from lcpflex.contact.narrow_phase.feature import SEGMENT, VERTEX
from lcpflex.errors import ModelError


def square(tools, *, clockwise=False):
    places = [(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (0.0, 1.0)]
    return shapes.chain([tools.place(*xy) for xy in (places[::-1] if clockwise else places)], closed=True)


def kinds(tools):
    middle = tools.place(0.0, 0.0)
    return {
        "node": shapes.node(middle),
        "disc": shapes.node(middle, 0.1),
        "circle": shapes.circle(middle, 0.2),
        "chain": square(tools),
        "arc": shapes.arc(middle, 1.0, 0.0, 1.0),
        "hole": shapes.hole(middle, 1.0),
        "half-plane": shapes.half_plane(middle, (0, 2)),
    }


@pytest.mark.parametrize(
    ("node", "feature"),
    [
        *(("node", other) for other in ("disc", "circle", "chain", "arc", "hole", "half-plane")),
        *(("circle", other) for other in ("chain", "arc", "hole", "half-plane")),
        *(("arc", other) for other in ("chain", "hole", "half-plane")),
        *(("chain", other) for other in ("hole", "half-plane")),
    ],
)
def test_the_slave_of_a_pair_does_not_depend_on_the_order(tools, node, feature):
    made = kinds(tools)
    for order in ((0, 1), (1, 0)):
        contacts = tools.assemble((0,), [(0, made[node]), (-1, made[feature])], [(*order, 0, 0, 0)]).contacts
        assert list(zip(contacts.pass_node, contacts.pass_feature, strict=True)) == [(0, 1)]


def test_two_chains_are_slaves_of_each_other(tools):
    contacts = tools.assemble((0,), [(0, square(tools)), (-1, square(tools))], [(0, 1, 0.1, 0.2, 0.3)]).contacts
    assert list(zip(contacts.pass_node, contacts.pass_feature, strict=True)) == [(0, 1), (1, 0)]
    np.testing.assert_array_equal(contacts.pass_law, [0, 0])
    assert (contacts.friction[0], contacts.restitution[0], contacts.tangential_restitution[0]) == (0.1, 0.2, 0.3)


@pytest.mark.parametrize("a", ["hole", "half-plane"])
@pytest.mark.parametrize("b", ["hole", "half-plane"])
def test_surfaces_without_slaves_are_refused(tools, a, b):
    made = kinds(tools)
    with pytest.raises(ModelError, match="cannot touch each other"):
        tools.assemble((0,), [(0, made[a]), (-1, made[b])], [(0, 1, 0, 0, 0)])


@pytest.mark.parametrize("body", [0, -1])
def test_two_surfaces_of_one_body_are_refused(tools, body):
    with pytest.raises(ModelError, match="the same body"):
        tools.assemble((0,), [(body, square(tools)), (body, kinds(tools)["circle"])], [(0, 1, 0, 0, 0)])


def test_coinciding_nodes_are_refused(tools):
    with pytest.raises(ModelError, match="no two successive ones at the same place"):
        shapes.chain([tools.place(0, 0), tools.place(1, 0), tools.place(0, 0)], closed=False) and shapes.chain(
            [tools.place(0, 0), tools.place(1, 0), tools.place(0, 0)], closed=True
        )


def test_normals_and_reach_of_a_rectangle(tools):
    contacts = tools.assemble((0,), [(0, square(tools))]).contacts
    h = math.sqrt(0.5)
    np.testing.assert_allclose(contacts.node_normal, [(-h, -h), (h, -h), (h, h), (-h, h)])
    np.testing.assert_allclose(contacts.feature_depth[:4], 0.5, rtol=0.011)  # largest inscribed circle
    np.testing.assert_array_equal(contacts.feature_kind, [SEGMENT] * 4 + [VERTEX] * 4)
    np.testing.assert_array_equal(contacts.feature_neighbour[:4], [(3, 1), (0, 2), (1, 3), (2, 0)])
    np.testing.assert_array_equal(contacts.feature_neighbour[4:], [(3, 0), (0, 1), (1, 2), (2, 3)])


def test_a_rectangular_hole_has_no_vertices_and_holds_as_deep_as_it_is_large(tools):
    contacts = tools.assemble((0,), [(0, square(tools, clockwise=True))]).contacts
    np.testing.assert_array_equal(contacts.feature_kind, [0] * 4)
    np.testing.assert_allclose(contacts.feature_depth, 0.5 * math.hypot(2.0, 1.0))
    np.testing.assert_array_equal(contacts.feature_span, [(-math.inf, math.inf)] * 4)  # no foot leaves over a corner
    np.testing.assert_array_equal(contacts.feature_neighbour, [(3, 1), (0, 2), (1, 3), (2, 0)])


def test_bounds_hold_every_point_of_the_moving_surface(tools):
    rng = np.random.default_rng(1)
    points = [tools.place(*xy, rng.normal(size=(2, 2)), rng.normal(size=2)) for xy in rng.normal(size=(6, 2))]
    contacts = tools.assemble((2,), [(0, shapes.chain(points))]).contacts
    for modal in rng.normal(size=(20, 2)):
        deflection = np.abs(modal) @ contacts.surface_deflection[0]
        for point in points:
            apart = np.hypot(*(point.place + modal @ point.phi - contacts.surface_center[0]))
            assert apart <= contacts.surface_extent[0] + deflection + 1e-12


def test_a_half_plane_is_carried_by_the_material_at_its_point(tools):
    phi, psi = np.array([[0.1, 0.2]]), np.array([0.3])
    surface = shapes.half_plane(tools.place(1.0, 2.0, phi, psi), (3.0, 0.0))
    first, second = surface.points
    np.testing.assert_allclose(second.place - first.place, (0.0, 1.0))
    np.testing.assert_allclose(second.phi - first.phi, [(-0.3, 0.0)])  # psi J (0, 1)


def outline(*places):
    return body.Chain(tuple(body.MaterialPoint(np.array(xy), np.zeros((0, 2)), np.zeros(0)) for xy in places), True)


def test_an_open_chain_reaches_half_way_through_the_outline_of_its_body(tools):
    """The lower side of a triangle of legs 4 and 3: half the height above its beginning, middle and end."""
    side = shapes.chain([tools.place(0.0, 0.0), tools.place(4.0, 0.0)])
    bounded = shapes.on_body(side, outline((0.0, 0.0), (4.0, 0.0), (0.0, 3.0)))
    reach = tools.assemble((0,), [(0, bounded)]).contacts.feature_depth[0]
    np.testing.assert_allclose(reach, (1.5, 0.75, 0.0), atol=1e-5)
    alone = tools.assemble((0,), [(0, side)]).contacts.feature_depth[0]
    np.testing.assert_allclose(alone, 2.0)  # half the size of the chain


def test_a_hole_reaches_half_way_to_the_outline_of_its_body(tools):
    hole = shapes.hole(tools.place(1.0, 0.0), 0.5)
    square = outline((-2.0, -2.0), (2.0, -2.0), (2.0, 2.0), (-2.0, 2.0))
    assert tools.assemble((0,), [(0, shapes.on_body(hole, square))]).contacts.feature_depth[0, 1] == 0.25
    assert tools.assemble((0,), [(0, hole)]).contacts.feature_depth[0, 1] == 0.5


def test_slaves_and_features_are_all_in_a_block_that_holds_them(tools):
    angle = np.linspace(0.0, 2.0 * math.pi, 30, endpoint=False)
    ring = shapes.chain([tools.place(math.cos(a), math.sin(a)) for a in angle], closed=True)
    made = [(0, ring), *((0, shape) for shape in kinds(tools).values())]
    model = tools.assemble((0,), made)
    c = model.contacts
    starts = [c.block_start[k] for k in c.surface_block]
    np.testing.assert_array_equal(starts, c.feature_start)
    for block, (x, y, extent, _) in enumerate(c.block_circle):
        for f in range(c.block_start[block], c.block_start[block + 1]):
            for p in c.feature_point[f]:
                apart = math.hypot(*(model.points.place[p] - (x, y)))
                assert apart + max(c.feature_radius[f], 0.0) <= extent + 1e-12
