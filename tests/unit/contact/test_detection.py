"""What touches what, where and in which direction; each case is one that a simpler rule gets wrong."""

from __future__ import annotations

import math

import numpy as np
import pytest

from lcpflex.bodies import surface as shapes
from lcpflex.contact.detection import detect
from lcpflex.contact.narrow_phase.feature import ARC, VERTEX, refresh

PI = math.pi
UP = (0.0, 1.0)


def chain(tools, *places, closed=True):
    return shapes.chain([tools.place(*xy) for xy in places], closed=closed)


def box(tools, width, height):
    x, y = 0.5 * width, 0.5 * height
    return chain(tools, (-x, -y), (x, -y), (x, y), (-x, y))


def disc(tools, radius):
    return shapes.circle(tools.place(0.0, 0.0), radius)


def fine_beam(tools, length=0.7, thickness=0.005, elements=40):
    """A slender outline with nodes on both faces, frame at its left end."""
    x = np.linspace(0.0, length, elements + 1)
    return chain(tools, *((a, -0.5 * thickness) for a in x), *((a, 0.5 * thickness) for a in x[::-1]))


def bending_beam(tools, nodes=21):
    """The upper face of a unit beam with one mode, y = q x (1 - x): q > 0 a bulge, q < 0 a hollow; solid below."""
    x = np.linspace(1.0, 0.0, nodes)
    return shapes.chain([tools.place(a, 0.0, np.array([[0.0, a * (1 - a)]]), np.array([1 - 2 * a])) for a in x])


# ---- corners of boxes


@pytest.mark.parametrize("dx", [-1e-13, 0.0, 1e-13])
@pytest.mark.parametrize("dy", [-1e-13, 0.0, 1e-13])
@pytest.mark.parametrize("turned", [0.0, PI / 2])
def test_a_stack_of_equal_boxes_touches_in_vertical_direction_only(tools, dx, dy, turned):
    a, b = box(tools, 1.0, 1.0), box(tools, 1.0, 1.0)
    model = tools.pair(a, b, 0, 1, (0, 0))
    found = tools.find(model, [dx, 1.0 + dy, 0, 0, 0, turned])
    assert len(found) == 4
    for contact in found:
        upward = 1.0 if contact.bodies == (0, 1) else -1.0
        np.testing.assert_allclose(contact.normal, (0.0, upward), atol=0.0 if turned == 0.0 else 1e-15)
        assert abs(contact.gap - dy) < 1e-15


@pytest.mark.parametrize("gap", [-1e-13, 0.0, 1e-13])
def test_a_row_of_equal_boxes_touches_in_horizontal_direction_only(tools, gap):
    model = tools.pair(box(tools, 1.0, 1.0), box(tools, 1.0, 1.0), 0, 1, (0, 0))
    found = tools.find(model, [1.0 + gap, 0, 0, 0, 0, 0])
    assert len(found) == 4
    assert all(contact.normal[1] == 0.0 and abs(contact.normal[0]) == 1.0 for contact in found)


@pytest.mark.parametrize("depth", [0.0, 1e-4, 1e-2])
def test_a_small_box_on_a_large_one(tools, depth):
    model = tools.pair(box(tools, 0.2, 0.2), box(tools, 1.0, 1.0), 0, 1, (0, 0))
    found = tools.find(model, [0.3, 0.6 - depth, 0, 0, 0, 0])
    assert [contact.normal for contact in found] == [UP, UP]
    np.testing.assert_allclose([contact.gap for contact in found], -depth, atol=1e-15)
    assert [contact.bodies for contact in found] == [(0, 1)] * 2


def test_a_corner_deep_below_two_faces_leaves_by_the_nearer(tools):
    model = tools.pair(box(tools, 0.2, 0.2), box(tools, 1.0, 1.0), 0, 1, (0, 0))
    tip = PI * 1.25 + 0.35  # direction of the corner, seen from the centre
    for corner, normal, gap in [((0.499, 0.45), (1.0, 0.0), -0.001), ((0.45, 0.499), UP, -0.001)]:
        x, y = np.array(corner) - 0.1 * math.sqrt(2.0) * np.array([math.cos(tip), math.sin(tip)])
        own = [c for c in tools.find(model, [x, y, 0.35, 0, 0, 0]) if c.bodies == (0, 1)]
        assert [contact.normal for contact in own] == [normal]
        assert abs(own[0].gap - gap) < 1e-12


def test_a_corner_on_a_long_beam_does_not_meet_its_far_ends(tools):
    model = tools.pair(box(tools, 0.1, 0.1), fine_beam(tools), 0, 1, (0, 0))
    for x in np.linspace(0.06, 0.64, 59):
        found = tools.find(model, [x, 0.0525 - 1e-4, 0, 0, 0, 0], margin=0.0)
        own = [contact for contact in found if contact.bodies == (0, 1)]
        assert [contact.normal for contact in own] == [UP, UP]
        np.testing.assert_allclose([contact.gap for contact in own], -1e-4, atol=1e-12)


# ---- thin beams


@pytest.mark.parametrize("depth", [-1e-5, 0.0, 1e-3])
def test_a_thin_beam_lies_on_the_floor_with_its_lower_face(tools, depth):
    model = tools.pair(fine_beam(tools), shapes.half_plane(tools.place(0, 0), UP))
    found = tools.find(model, [0, 0.0025 - depth, 0], margin=0.01)
    assert len(found) == 41
    assert {contact.normal for contact in found} == {UP}
    np.testing.assert_allclose([contact.gap for contact in found], -depth, atol=1e-15)


@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize("depth", [0.0, 1e-3, 2e-3])
def test_a_disc_on_either_side_of_a_thin_beam(tools, side, depth):
    model = tools.pair(disc(tools, 0.01), fine_beam(tools), 0, 1, (0, 0))
    for x in np.linspace(0.0, 0.7, 163):  # over nodes and between them
        (found,) = tools.find(model, [x, side * (0.0125 - depth), 0, 0, 0, 0])
        np.testing.assert_allclose(found.normal, (0.0, side), atol=1e-6)
        assert abs(found.gap + depth) < 1e-12


# ---- outside is not below


def test_a_disc_beside_a_sharp_corner_is_not_below_the_far_side(tools):
    model = tools.pair(disc(tools, 0.05), chain(tools, (0.0, 0.0), (1.0, 0.0), (0.3, 0.8)))
    assert not tools.find(model, [0.99, 0.12, 0.0])  # 0.02 m off the right side, and above the line of the lower one
    assert not tools.find(model, [0.005, 0.2, 0.0])


@pytest.mark.parametrize("pieces", [1, 7])
def test_a_disc_on_a_slope_is_not_below_the_other_slope_of_the_hill(tools, pieces):
    across = np.linspace(0.0, 1.0, pieces, endpoint=False)
    hill = [*((1.0 - a, 0.5 * a) for a in across), *((-a, 0.5 - 0.5 * a) for a in across), (-1.0, 0.0)]
    model = tools.pair(disc(tools, 0.1), chain(tools, *hill, closed=False))
    n = np.array([1.0, 2.0]) / math.sqrt(5.0)
    for a in np.linspace(0.05, 0.95, 19):
        for gap in (-1e-3, 0.0, 1e-4, 0.05):
            found = tools.find(model, np.append(np.array([a, 0.5 - 0.5 * a]) + (0.1 + gap) * n, 0.0))
            assert len(found) == (gap < 1e-3)
            for contact in found:
                np.testing.assert_allclose(contact.normal, n, atol=1e-9)
                assert abs(contact.gap - gap) < 1e-12


# ---- discs against corners


def test_a_disc_in_a_groove_rests_on_both_flanks(tools):
    groove = chain(tools, (1.0, 1.0), (0.0, 0.0), (-1.0, 1.0), closed=False)
    model = tools.pair(disc(tools, 0.1), groove)
    found = tools.find(model, [0.0, 0.1 * math.sqrt(2.0), 0.0])
    h = math.sqrt(0.5)
    np.testing.assert_allclose([contact.normal for contact in found], [(-h, h), (h, h)], atol=1e-15)
    np.testing.assert_allclose([contact.gap for contact in found], 0.0, atol=1e-15)


def test_a_disc_rolls_over_the_corners_of_a_triangle_without_a_jump(tools):
    corners = np.array([(0.0, 0.0), (1.0, 0.0), (0.3, 0.8)])
    model = tools.pair(disc(tools, 0.05), chain(tools, *corners))
    places = []
    for k in range(3):
        a, b, c = (corners[(k + i) % 3] for i in range(3))
        normals = [np.array([e[1], -e[0]]) / np.hypot(*e) for e in (b - a, c - b)]
        places += [(a + s * (b - a) + 0.05 * normals[0], normals[0]) for s in np.linspace(0.0, 1.0, 101)]
        start = math.atan2(*normals[0][::-1])
        turn = (math.atan2(*normals[1][::-1]) - start) % (2.0 * PI)
        for angle in np.linspace(start, start + turn, 101):
            n = np.array([math.cos(angle), math.sin(angle)])
            places.append((b + 0.05 * n, n))
    for center, n in places:
        (found,) = tools.find(model, [*center, 0.0])
        np.testing.assert_allclose(found.normal, n, atol=1e-7)
        assert abs(found.gap) < 1e-12


def test_the_end_of_an_open_chain_is_round_for_a_disc(tools):
    model = tools.pair(disc(tools, 0.1), chain(tools, (1.0, 0.0), (0.0, 0.0), closed=False))
    for angle in np.linspace(0.01, PI / 2 - 0.01, 20):
        n = (math.cos(angle), math.sin(angle))
        (found,) = tools.find(model, [1.0 + 0.1 * n[0], 0.1 * n[1], 0.0])
        np.testing.assert_allclose(found.normal, n, atol=1e-12)
        assert abs(found.gap) < 1e-14
    assert [contact.normal for contact in tools.find(model, [0.5, 0.1, 0.0])] == [UP]


# ---- smooth and bending chains


@pytest.mark.parametrize("bend", [0.0, 0.3, -0.3, 1e-9, -1e-9])
def test_a_disc_on_a_bending_face_has_one_contact_except_in_a_hollow(tools, bend):
    nodes = np.array([(x, bend * x * (1.0 - x)) for x in np.linspace(0.0, 1.0, 21)])
    model = tools.pair(disc(tools, 0.04), bending_beam(tools), 0, 1, (0, 1))
    for x in np.concatenate([np.linspace(0.1, 0.9, 81), nodes[3:18, 0] + 1e-10]):
        y = bend * x * (1.0 - x) + 0.041
        found = tools.find(model, [x, y, 0.0, 0.0, 0.0, 0.0, bend], margin=0.01)
        hollow = bend < -1e-3 and np.abs(nodes[:, 0] - x).min() < 0.041 * 0.05 * abs(bend) + 1e-6
        assert len(found) == 1 or (len(found) == 2 and hollow)
        assert abs(min(contact.gap for contact in found) - (distance(nodes, (x, y)) - 0.04)) < 1e-13


def distance(nodes, p):
    """From p to a polyline."""
    e = np.diff(nodes, axis=0)
    d = np.asarray(p) - nodes[:-1]
    s = np.clip((d * e).sum(axis=1) / (e * e).sum(axis=1), 0.0, 1.0)
    return np.hypot(*(d - s[:, None] * e).T).min()


@pytest.mark.parametrize("bend", [0.0, 0.3, -0.3])
def test_a_corner_below_a_bending_face_is_never_lost(tools, bend):
    wedge = chain(tools, (0.0, 0.0), (0.1, 0.3), (-0.1, 0.3))
    nodes = np.linspace(0.0, 1.0, 21)
    model = tools.pair(wedge, bending_beam(tools), 0, 1, (0, 1))
    for x in np.linspace(0.1, 0.9, 161):
        slope = bend * (1.0 - 2.0 * x)  # at nodes that of the line halfway between the two pieces
        below = 1e-4 * np.array([slope, -1.0]) / math.hypot(1.0, slope)
        x, y = np.array([x, np.interp(x, nodes, bend * nodes * (1.0 - nodes))]) + below
        own = [c for c in tools.find(model, [x, y, 0, 0, 0, 0, bend], margin=0.0) if c.bodies == (0, 1)]
        under_node = bend < 0.0 and np.abs(nodes - x).min() < 1e-4
        assert len(own) == (2 if under_node else 1)
        for contact in own:
            assert -1.0001e-4 < contact.gap < -0.99e-4


@pytest.mark.parametrize("half_angle", [0.2, PI / 4, 1.4])
def test_a_tip_below_the_bottom_of_a_groove_is_held_by_both_flanks(tools, half_angle):
    run, rise = math.sin(half_angle), math.cos(half_angle)
    groove = chain(tools, (run, rise), (0.0, 0.0), (-run, rise), closed=False)
    tip = chain(tools, (0.0, 0.0), (0.02, 0.3), (-0.02, 0.3))
    model = tools.pair(tip, groove, 0, 1, (0, 0))
    for depth in (0.0, 1e-8, 1e-3):
        own = [c for c in tools.find(model, [0.0, -depth, 0, 0, 0, 0], margin=1e-10) if c.bodies == (0, 1)]
        np.testing.assert_allclose([c.normal for c in own], [(-rise, run), (rise, run)], atol=1e-12)
        np.testing.assert_allclose([c.gap for c in own], -depth * run, atol=1e-15)


def test_nothing_near_is_missed_whatever_the_bending(tools):
    """A disc against a closed outline that moves, turns and deforms: the distance found is the least there is."""
    rng = np.random.default_rng(3)
    angles = np.linspace(0.0, 2.0 * PI, 24, endpoint=False)
    shape = [rng.normal(size=(2, 2)) * 0.02 for _ in angles]
    outline = shapes.chain(
        [tools.place(math.cos(a), math.sin(a), p, np.zeros(2)) for a, p in zip(angles, shape, strict=True)], closed=True
    )
    model = tools.pair(disc(tools, 0.2), outline, 0, 1, (0, 2))
    seen = 0
    for _ in range(600):
        q = np.concatenate(
            [[*rng.uniform(-2.0, 2.0, 2), 0.0], rng.uniform(-0.3, 0.3, 2), [rng.uniform(0, 7)], rng.normal(size=2)]
        )
        c, s = math.cos(q[5]), math.sin(q[5])
        local = [(math.cos(a), math.sin(a)) + q[6:] @ p for a, p in zip(angles, shape, strict=True)]
        nodes = np.array([(q[3] + c * x - s * y, q[4] + s * x + c * y) for x, y in (*local, local[0])])
        winding = np.unwrap(np.arctan2(*(nodes - q[:2]).T[::-1]))
        if abs(winding[-1] - winding[0]) > 1.0:
            continue  # the centre is inside
        gap = distance(nodes, q[:2]) - 0.2
        found = tools.find(model, q, margin=0.1)
        assert bool(found) == (gap <= 0.1)
        if found:
            seen += 1
            assert abs(min(contact.gap for contact in found) - gap) < 1e-12
    assert seen > 50


def test_a_half_plane_on_a_bending_body_is_found_far_from_where_it_turns(tools):
    base = tools.place(0.0, 0.0, np.zeros((1, 2)), np.ones(1))
    model = tools.pair(disc(tools, 0.1), shapes.half_plane(base, UP), 0, 1, (0, 1))
    tilt = 0.2  # psi q: the line is y = tilt x
    center = np.array([5.0, 5.0 * tilt]) + 0.1 * np.array([-tilt, 1.0]) / math.hypot(1.0, tilt)
    (found,) = tools.find(model, [*center, 0, 0, 0, 0, tilt])
    assert abs(found.gap) < 1e-14
    assert not tools.find(model, [center[0], center[1] + 0.01, 0, 0, 0, 0, tilt])


# ---- arcs and holes


def test_a_pin_in_a_hole(tools):
    model = tools.pair(disc(tools, 0.09), shapes.hole(tools.place(0.0, 0.0), 0.1))
    for angle in np.linspace(0.0, 2.0 * PI, 13):
        outward = np.array([math.cos(angle), math.sin(angle)])
        (found,) = tools.find(model, [*(0.0105 * outward), 0.0])
        np.testing.assert_allclose(found.normal, -outward, atol=1e-12)
        assert abs(found.gap + 5e-4) < 1e-15
    assert not tools.find(model, [0.005, 0.0, 0.0])
    assert not tools.find(model, [0.3, 0.0, 0.0])  # beside the body that has the hole
    (centred,) = tools.find(model, [0.0, 0.0, 0.0], margin=0.02)
    assert abs(centred.gap - 0.01) < 1e-15


def test_the_corners_of_a_box_in_a_hole(tools):
    model = tools.pair(box(tools, 0.6, 0.8), shapes.hole(tools.place(0.0, 0.0), 0.5))
    found = tools.find(model, [0.0, 0.0, 0.3])
    assert len(found) == 4
    np.testing.assert_allclose([contact.gap for contact in found], 0.0, atol=1e-15)


@pytest.mark.parametrize("turned", [0.0, 1.0, -4.0, 20.0])
@pytest.mark.parametrize("hole", [False, True])
def test_an_arc_turns_with_the_material_at_its_centre(tools, turned, hole):
    center = tools.place(0.0, 0.0, np.zeros((1, 2)), np.array([2.0]))
    model = tools.pair(disc(tools, 0.1), shapes.arc(center, 1.0, 0.5, 2.0, hole), 0, 1, (0, 1))
    D = 0.9 if hole else 1.1
    for angle, inside in [
        (0.49, False),
        (0.5, True),
        (0.51, True),
        (2.49, True),
        (2.5, True),
        (2.51, False),
        (4.5, False),
    ]:
        world = angle + turned + 2.0 * 0.05
        found = tools.find(model, [D * math.cos(world), D * math.sin(world), 0, 0, 0, turned, 0.05])
        end = (0.5 if angle < 1.0 else 2.5) + turned
        x, y = math.cos(end) - 0.1 * math.sin(end), math.sin(end) + 0.1 * math.cos(end)  # carried: linear in q
        gap = math.hypot(D * math.cos(world) - x, D * math.sin(world) - y) - 0.1
        corners = [contact.gap for contact in found if contact.kind == VERTEX]
        if angle in (0.5, 2.5) and corners:  # to first order in the turn the corner is on the seam
            assert len(found) == 1
            continue
        assert corners == ([] if inside or gap > 0.0 else [pytest.approx(gap, abs=1e-12)])
        found = [contact for contact in found if contact.kind == ARC]
        assert len(found) == inside
        for contact in found:
            sense = -1.0 if hole else 1.0
            np.testing.assert_allclose(contact.normal, (sense * math.cos(world), sense * math.sin(world)), atol=1e-12)


def test_discs_that_coincide_are_found(tools):
    model = tools.pair(disc(tools, 0.2), disc(tools, 0.3))
    (found,) = tools.find(model, [0.0, 0.0, 0.0])
    assert abs(found.gap + 0.5) < 1e-15
    assert math.hypot(*found.normal) == 1.0


# ---- the table


def test_keys_name_a_pair_from_call_to_call_and_the_order_is_that_of_passes(tools):
    floor = shapes.half_plane(tools.place(0, 0), UP)
    surfaces = [(0, box(tools, 1, 1)), (1, box(tools, 1, 1)), (-1, floor)]
    model = tools.assemble((0, 0), surfaces, [(2, 1, 0, 0, 0), (0, 1, 0, 0, 0), (2, 0, 0, 0, 0)])
    first = tools.find(model, [0.2, 1.5, 0, 0, 0.5, 0])
    again = tools.find(model, [0.2 + 1e-4, 1.5 + 1e-4, 0, 0, 0.5 + 1e-4, 0])
    assert [c.law for c in first] == [0, 0, 1, 1]
    assert [c.key for c in first] == [c.key for c in again]
    assert len({c.key for c in first}) == 4


def test_a_full_table_keeps_all_entries_and_a_small_one_says_how_many_it_lacks(tools):
    """The beam's upper face is within the margin, too, and is rejected after the last entry has been written."""
    model = tools.pair(fine_beam(tools), shapes.half_plane(tools.place(0, 0), UP))
    q = np.array([0.0, 0.0025, 0.0])
    exact = tools.table_of(model, 41)
    assert detect(model, q, 0.01, exact) == 41
    np.testing.assert_array_equal(np.unique(exact.node), np.arange(41))
    np.testing.assert_allclose(exact.gap, 0.0, atol=1e-15)
    for capacity in (0, 1, 40):
        assert detect(model, q, 0.01, tools.table_of(model, capacity)) == 41


def test_a_kept_feature_is_followed_past_its_end(tools):
    model = tools.pair(disc(tools, 0.1), chain(tools, (1.0, 0.0), (0.0, 0.0), closed=False))
    table = tools.table_of(model)
    assert detect(model, np.array([0.5, 0.1, 0.0]), 1e-3, table) == 1
    refresh(model, np.array([-0.5, 0.3, 0.0]), table, 0)
    assert abs(table.s[0] - 1.5) < 1e-15
    assert abs(table.gap[0] - 0.2) < 1e-15


def test_nodes_do_not_meet_surfaces_that_look_their_way(tools):
    """A box inside a wide half-plane: only the nodes that look at the floor count, however deep."""
    model = tools.pair(box(tools, 1.0, 1.0), shapes.half_plane(tools.place(0, 0), UP))
    found = tools.find(model, [0.0, -2.0, 0.0])
    np.testing.assert_allclose([contact.gap for contact in found], [-2.5, -2.5])
