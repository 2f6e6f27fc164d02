"""What detection finds in scenes of bodies: surfaces of parts of a body, arcs, thin flexible beams, random polygons."""

from __future__ import annotations

import math

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.contact.detection import contact_table, detect
from lcpflex.jit.struct import pack
from tests.scenes import floor_of

STEEL = {"density": 7800.0, "youngs_modulus": 2.1e11}


def found(scene, margin=1e-3, q=None):
    """(body of the node, normal, gap) of each contact of a scene at its start, or at q."""
    compiled = scene.compiled()
    q = compiled.q.copy() if q is None else np.array(q, dtype=float)
    table = contact_table(256, len(compiled.model.contacts.surface_body))
    n = detect(pack(compiled.model), q, margin, table)
    assert n <= 256
    return [(int(table.body[k, 0]), table.normal[k].copy(), float(table.gap[k])) for k in range(n)]


def thin_beam(modes=6):
    return lf.Beam(length=1.0, width=0.02, thickness=0.005, elements=20, **STEEL).reduce(modes=modes)


# ---- surfaces that are parts of an outline


@pytest.mark.parametrize("height", [0.1, 0.004, 0.0076])
def test_what_is_beyond_the_far_face_is_not_below_the_near_one(height):
    """The lower face of a thin beam does not feel a disc that lies above the beam."""
    scene = lf.Scene()
    beam = scene.add(thin_beam(), name="beam")
    ball = scene.add(lf.Disc(radius=0.002, mass=1.0), name="ball", position=(0.43, height))
    scene.contact(ball.surface(), beam.surface("bottom"))
    assert not found(scene, margin=1e-3)


@pytest.mark.parametrize("depth", [-1e-4, 0.0, 1e-4, 2e-3])
def test_one_face_of_a_thin_beam_is_met_from_its_own_side(depth):
    scene = lf.Scene()
    beam = scene.add(thin_beam(), name="beam")
    node = scene.add(lf.RigidBody(mass=1.0, inertia=1.0), name="node", position=(0.0, -1.0))
    scene.contact(node.node(0.0, 0.0), beam.surface("bottom"))
    q = scene.compiled().q.copy()
    q[-3:] = (0.43, -0.0025 + depth, 0.0)
    ((_, normal, gap),) = found(scene, q=q)
    np.testing.assert_allclose(normal, (0.0, -1.0), atol=1e-15)
    assert abs(gap + depth) < 1e-15


def test_a_side_of_a_triangle_is_not_felt_through_its_sharp_corner():
    """The disc rests on the upper side; near the corner it is less far above the lower side than the disc is large."""
    triangle = lf.Polygon([(0.0, 0.0), (1.0, 0.0), (0.0, 0.3)], mass=1.0)
    lower = np.array([0.3, 1.0]) / math.hypot(0.3, 1.0)
    for along in np.linspace(0.02, 0.9, 45):
        for surface, expected in (("side_0", 0), ("side_1", 1)):
            scene = lf.Scene()
            wedge = scene.add(triangle)
            place = np.array([1.0 - along, 0.3 * along]) + 0.05 * lower
            ball = scene.add(lf.Disc(radius=0.05, mass=1.0), position=place)
            scene.contact(ball.surface(), wedge.surface(surface))
            assert len(found(scene, margin=1e-6)) == expected


def test_a_box_that_stands_on_the_end_of_its_declared_bottom():
    """Fallen on its left side: the lower-left corner, which ends the chain, meets the floor sideways."""
    scene = lf.Scene()
    block = scene.add(lf.Box(width=0.2, height=0.4, mass=1.0), position=(0.0, 0.1), angle=0.5 * math.pi)
    scene.contact(block.surface("top"), floor_of(scene))
    ((_, normal, gap),) = found(scene)
    np.testing.assert_allclose(normal, (0.0, 1.0), atol=1e-15)
    assert abs(gap) < 1e-15


def test_a_disc_outside_a_body_does_not_feel_its_hole():
    scene = lf.Scene()
    block = scene.add(lf.Box(width=0.25, height=0.25, mass=1.0))
    ball = scene.add(lf.Disc(radius=0.02, mass=1.0), position=(0.1451, 0.0))
    scene.contact(ball.surface(), block.hole((0.0, 0.0), 0.1))
    assert not found(scene)
    scene = lf.Scene()
    block = scene.add(lf.Box(width=0.25, height=0.25, mass=1.0))
    ball = scene.add(lf.Disc(radius=0.02, mass=1.0), position=(0.08, 0.0))
    scene.contact(ball.surface(), block.hole((0.0, 0.0), 0.1))
    ((_, normal, gap),) = found(scene)
    np.testing.assert_allclose(normal, (-1.0, 0.0), atol=1e-15)
    assert abs(gap) < 1e-15


# ---- solid arcs


@pytest.mark.parametrize("x", np.linspace(0.31, 0.37, 7))
def test_a_small_bump_meets_a_beam_between_its_nodes(x):
    scene = lf.Scene()
    beam = scene.add(thin_beam(), position=(0.0, 0.0125))
    scene.contact(beam.surface("bottom"), scene.ground.arc((x, 0.0), 0.01, start=0.0, extent=math.pi))
    ((node, normal, gap),) = found(scene)
    assert node == -1
    np.testing.assert_allclose(normal, (0.0, -1.0), atol=1e-14)
    assert abs(gap) < 1e-15


@pytest.mark.parametrize(("angle", "beyond"), [(-0.51, 0.01), (-0.49, 0), (0.0, 0), (0.99, 0), (1.01, 0.01)])
def test_a_rocker_rolls_on_its_arc_and_turns_about_its_end(angle, beyond):
    """The arc spans 1 rad to the right and 1/2 to the left of straight down, and turns with the body."""
    scene = lf.Scene()
    rocker = scene.add(lf.RigidBody(mass=1.0, inertia=1.0), position=(0.0, 0.5), angle=-angle)
    arc = rocker.arc((0.0, 0.0), 0.5, start=-0.5 * math.pi - 0.5, extent=1.5)
    scene.contact(arc, floor_of(scene))
    contacts = found(scene, margin=2.6e-5)  # the end is hardly above the floor where the arc has just left it
    assert len(contacts) == 1
    assert contacts[0][1][1] == 1.0
    assert contacts[0][2] == pytest.approx(0.5 * (1.0 - math.cos(beyond)), abs=1e-15)


# ---- chains against chains


def test_two_thin_beams_face_to_face_meet_at_all_nodes_and_nowhere_else():
    scene = lf.Scene()
    lower, upper = scene.add(thin_beam()), scene.add(thin_beam(), position=(0.31, 0.005))
    scene.contact(lower.surface(), upper.surface())
    contacts = found(scene, margin=1e-6)
    over = 14 + 14  # of the 21 nodes of each face; 0.31 / 0.05 = 6.2
    assert len(contacts) == over
    for node, normal, gap in contacts:
        np.testing.assert_allclose(normal, (0.0, 1.0 if node == 1 else -1.0), atol=1e-15)
        assert abs(gap) < 1e-15


@pytest.mark.parametrize("closed", [True, False])
def test_the_end_of_a_beam_strikes_a_wall(closed):
    scene = lf.Scene()
    beam = scene.add(thin_beam())
    wall = scene.ground.chain([(1.0, 1.0), (1.0, -1.0)])
    scene.contact(beam.surface("outline" if closed else "bottom"), wall)
    contacts = found(scene)
    assert len(contacts) == (2 if closed else 1)
    for _, normal, gap in contacts:
        np.testing.assert_allclose(normal, (-1.0, 0.0), atol=1e-15)
        assert abs(gap) < 1e-15


def test_corners_that_meet_diagonally_have_one_direction_each():
    scene = lf.Scene()
    box = lf.Box(width=1.0, height=1.0, mass=1.0)
    a, b = scene.add(box), scene.add(box, position=(3.0, 0.0))
    scene.contact(a.surface(), b.surface())
    contacts = found(scene, q=[0.0, 0.0, 0.0, 0.999, 0.998, 0.0])
    assert [node for node, _, _ in contacts] == [0, 1]
    for node, normal, gap in contacts:
        np.testing.assert_array_equal(normal, (1.0 if node == 1 else -1.0, 0.0))
        assert abs(gap + 0.001) < 1e-12
    assert not found(scene, q=[0.0, 0.0, 0.0, 1.0001, 1.0001, 0.0])


# ---- against brute force


def distance(corners, p):
    """From p to the boundary of a polygon, and whether p is inside."""
    ends = np.roll(corners, -1, axis=0)
    e, d = ends - corners, p - corners
    s = np.clip((d * e).sum(axis=1) / (e * e).sum(axis=1), 0.0, 1.0)
    inside = bool((e[:, 0] * d[:, 1] - e[:, 1] * d[:, 0] > 0.0).all())
    return np.hypot(*(d - s[:, None] * e).T).min(), inside


def test_the_gap_of_a_disc_is_its_distance_from_a_random_polygon():
    """Outside and inside, whatever the polygon: one contact, with the signed distance, in the direction it grows."""
    rng = np.random.default_rng(7)
    seen = 0
    for _ in range(25):
        angles = np.sort(rng.uniform(0.0, 2.0 * math.pi, rng.integers(3, 9)))
        if np.diff(angles, append=angles[0] + 2.0 * math.pi).max() > 0.9 * math.pi:
            continue
        corners = np.stack([rng.uniform(0.3, 3.0) * np.cos(angles), np.sin(angles)], axis=1)
        scene = lf.Scene()
        polygon = scene.add(lf.Polygon(corners, mass=1.0), angle=0.7, position=(0.2, 0.1))
        ball = scene.add(lf.Disc(radius=0.1, mass=1.0), position=(50.0, 0.0))
        scene.contact(ball.surface(), polygon.surface())
        compiled = scene.compiled()
        model, table = pack(compiled.model), contact_table(64, 2)
        turn = np.array([[math.cos(0.7), -math.sin(0.7)], [math.sin(0.7), math.cos(0.7)]])
        placed = corners @ turn.T + (0.2, 0.1)
        for _ in range(200):
            q = compiled.q.copy()
            q[3:5] = rng.uniform(placed.min(axis=0) - 0.3, placed.max(axis=0) + 0.3)
            way, inside = distance(placed, q[3:5])
            gap = (-way if inside else way) - 0.1
            n = detect(model, q, 0.05, table)
            assert n == (gap <= 0.05)
            if n:
                seen += 1
                assert abs(table.gap[0] - gap) < 1e-12
                step = 1e-6 * table.normal[0]
                there, beyond = distance(placed, q[3:5] + step)
                assert abs((-there if beyond else there) - (gap + 0.1) - 1e-6) < 1e-9
    assert seen > 1000


def test_the_same_contacts_in_the_same_order_every_time():
    scene = lf.Scene()
    box = lf.Box(width=0.2, height=0.1, mass=1.0)
    for k in range(9):
        scene.add(box, position=(0.2 * (k % 3), 0.05 + 0.1 * (k // 3)))
    floor_of(scene)
    scene.contact_all()
    compiled = scene.compiled()
    tables = [contact_table(400, 10) for _ in range(2)]
    counts = [detect(pack(compiled.model), compiled.q.copy(), 1e-3, table) for table in tables]
    assert counts[0] == counts[1] > 40
    for name in ("key", "law", "gap", "normal", "s"):
        np.testing.assert_array_equal(getattr(tables[0], name), getattr(tables[1], name))
    assert np.all(np.diff(tables[0].law[: counts[0]]) >= 0)
    assert detect(pack(compiled.model), compiled.q.copy(), 1e-3, contact_table(10, 10)) >= counts[0]


def test_compiled_and_plain_detection_agree():
    scene = lf.Scene()
    lower, upper = scene.add(thin_beam(2)), scene.add(thin_beam(2), position=(0.31, 0.005))
    scene.contact(lower.surface("top"), upper.surface("bottom"))
    compiled = scene.compiled()
    model = pack(compiled.model)
    tables = [contact_table(64, 2) for _ in range(2)]
    assert detect(model, compiled.q.copy(), 1e-6, tables[0]) == detect.py_func(
        model, compiled.q.copy(), 1e-6, tables[1]
    )
    np.testing.assert_array_equal(tables[0].key, tables[1].key)
    np.testing.assert_allclose(tables[0].gap, tables[1].gap, atol=1e-15)
