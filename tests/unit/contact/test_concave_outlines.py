"""Gaps of concave outlines against an independent judge: is the place in the polygon, and how far is its boundary?

The least gap of a disc is the signed distance of its centre from the boundary, less its radius. Where the nearest
point of the boundary is a hollow corner, from inside, only both sides of the corner together lead out: both are
reported, with the distances from their lines, and the least displacement that opens both is the distance from the
corner. A point outside has no contact with a corner that bulges.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.bodies import surface as shapes
from lcpflex.contact.detection import contact_table, detect
from lcpflex.jit.struct import pack
from tests import libs

FAR = math.inf


# ---- the judge


def signed_distance(corners, places):
    """Signed distances (n,) from a closed polygon, positive outside; the nearest edges, and where on them (0 to 1)."""
    a = corners
    e = np.roll(corners, -1, axis=0) - a
    d = places[:, None, :] - a
    s = np.clip((d * e).sum(axis=2) / (e * e).sum(axis=1), 0.0, 1.0)
    apart = d - s[..., None] * e
    way = np.hypot(apart[..., 0], apart[..., 1])
    nearest = way.argmin(axis=1)
    y = places[:, 1, None]
    passed = (a[:, 1] <= y) != (a[:, 1] + e[:, 1] <= y)
    with np.errstate(divide="ignore", invalid="ignore"):
        crossing = a[:, 0] + (y - a[:, 1]) / e[:, 1] * e[:, 0]
    inside = (passed & (places[:, 0, None] < crossing)).sum(axis=1) % 2 == 1
    row = np.arange(len(places))
    return np.where(inside, -1.0, 1.0) * way[row, nearest], nearest, s[row, nearest]


def lines_at(corners, v, place):
    """Signed distances of a place from the lines of the two edges that meet in corner v."""
    a, b, c = corners[v - 1], corners[v], corners[(v + 1) % len(corners)]
    return [(t[1] * (place - b)[0] - t[0] * (place - b)[1]) / math.hypot(*t) for t in (b - a, c - b)]


def hollow(corners):
    e = np.roll(corners, -1, axis=0) - corners
    f = np.roll(e, 1, axis=0)
    return f[:, 0] * e[:, 1] - f[:, 1] * e[:, 0] < 0.0


def nearest_corner(k, s, count):
    """The corner in which the boundary is nearest, or -1 if that is amid an edge."""
    return int(k) if s <= 0.0 else (int(k) + 1) % count if s >= 1.0 else -1


# ---- outlines, of the size 1


def star(rng):
    n = int(rng.integers(5, 40))
    angles = 2.0 * math.pi * (np.arange(n) + rng.uniform(-0.45, 0.45, n)) / n
    return rng.uniform(0.3, 1.0, n)[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1)


def saw(rng):
    n, depth = int(rng.integers(6, 30)), rng.uniform(0.05, 0.5)
    angles = 2.0 * math.pi * np.arange(n) / n
    return np.array([(r * math.cos(t), r * math.sin(t)) for t in angles for r in (1.0, 1.0 - depth)])


def gear(rng):
    n, depth = int(rng.integers(5, 25)), rng.uniform(0.1, 0.4)
    pitch = 2.0 * math.pi / n
    flank = ((1.0 - depth, 0.0), (1.0, 0.15), (1.0, 0.4), (1.0 - depth, rng.uniform(0.45, 0.6)))
    return np.array(
        [(r * math.cos((i + t) * pitch), r * math.sin((i + t) * pitch)) for i in range(n) for r, t in flank]
    )


def meshed_u(rng):
    """A U, with the nodes of a mesh along its straight sides."""
    w = rng.uniform(0.1, 0.3)
    corners = [(-1, -1), (1, -1), (1, 1), (1 - w, 1), (1 - w, -1 + w), (-1 + w, -1 + w), (-1 + w, 1), (-1, 1)]
    outline = np.array(corners, dtype=float)
    parts = np.arange(pieces := int(rng.integers(1, 6))) / pieces
    steps = np.roll(outline, -1, axis=0) - outline
    return (outline[:, None, :] + parts[None, :, None] * steps[:, None, :]).reshape(-1, 2)


pytestmark = pytest.mark.filterwarnings("ignore:mesh. its stiffness:lcpflex.errors.ModelWarning")  # coarse on purpose

OUTLINES = {"star": star, "saw": saw, "gear": gear, "meshed U": meshed_u}


def places_about(rng, corners, size, count):
    """Half of them anywhere, half near corners, down to 1e-5 of the size."""
    half = count // 2
    near = corners[rng.integers(0, len(corners), count - half)]
    spread = size * 10.0 ** rng.uniform(-5, -1, (count - half, 1))
    return np.vstack([rng.uniform(-1.2 * size, 1.2 * size, (half, 2)), near + rng.normal(size=near.shape) * spread])


def random_scene(rng, tools, outline):
    """A random outline on a body and a disc or a point on another, in random units, declared in either order."""
    size = 10.0 ** rng.uniform(-3, 5)
    corners = size * OUTLINES[outline](rng)
    radius = float(rng.choice([0.0, 0.005, 0.05, 0.3])) * size
    points = [tools.place(*xy) for xy in corners]
    closed = bool(rng.integers(2))
    wall = shapes.chain(points if closed else [*points, points[0]], closed=closed)
    probe = shapes.node(tools.place(0.0, 0.0), radius)
    if rng.integers(2):
        model = tools.pair(probe, wall, 0, 1, (0, 0))
    else:
        model = tools.pair(wall, probe, 1, 0, (0, 0))
    return model, corners, size, radius


def campaign(seed, tools, outline, count, places):
    """Compare detection with the judge; how many places were seen touching, inside, and at hollow corners."""
    rng = np.random.default_rng(seed)
    seen = inside = corner = 0
    for _ in range(count):
        model, corners, size, radius = random_scene(rng, tools, outline)
        table = tools.table_of(model, 512)
        margin = float(rng.choice([0.0, 0.01, 0.1])) * size
        local = places_about(rng, corners, size, places)
        way, nearest, s = signed_distance(corners, local)
        bent = hollow(corners)
        angle = rng.uniform(-10.0, 10.0)
        turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
        shift = rng.uniform(-3.0, 3.0, 2) * size
        world = local @ turn.T + shift
        q = np.array([0.0, 0.0, rng.uniform(-10.0, 10.0), *shift, angle])
        for i in range(places):
            q[:2] = world[i]
            n = detect(model, q, margin, table)
            assert n <= 512
            v = nearest_corner(nearest[i], s[i], len(corners))
            expected = way[i] - radius
            if v >= 0 and way[i] < 0.0:
                assert bent[v]
                expected = min(lines_at(corners, v, local[i])) - radius
                corner += 1
            elif v >= 0 and radius == 0.0:
                expected = FAR  # a point beside a corner that bulges
            gaps = table.gap[:n]
            if abs(expected - margin) < 1e-9 * size:
                continue
            where = f"{outline}, size {size:.3g}, radius {radius:.3g}, place {local[i].tolist()}, distance {way[i]:.6g}"
            if expected > margin:
                # beside a corner, a point may still be over something else, within the margin
                assert n == 0 or (expected == FAR and gaps.min() >= -1e-9 * size), f"phantom {gaps} at {where}"
                continue
            assert n > 0, f"lost at {where}"
            assert abs(gaps.min() - expected) < 1e-9 * size, f"gap {gaps} at {where}"
            seen += 1
            inside += way[i] < 0.0
            if way[i] < 0.0 and v < 0:
                normal = table.normal[int(gaps.argmin())] @ turn
                there, _, _ = signed_distance(corners, (local[i] - 0.5 * way[i] * normal)[None])
                assert abs(there[0] - 0.5 * way[i]) < 1e-9 * size, f"normal {normal} at {where}"
    return seen, inside, corner


@pytest.mark.parametrize("outline", OUTLINES)
def test_the_gap_is_the_distance_from_the_nearest_boundary(tools, outline):
    seen, inside, corner = campaign(1, tools, outline, 25, 80)
    assert seen > 500
    assert inside > 300
    assert corner > 20


@pytest.mark.slow
@pytest.mark.parametrize("outline", OUTLINES)
def test_the_gap_is_the_distance_for_many_places(tools, outline):
    seen, inside, corner = campaign(2, tools, outline, 100, 500)
    assert min(seen, inside, corner) > 500


@pytest.mark.slow
@pytest.mark.parametrize("outline", OUTLINES)
@pytest.mark.parametrize("part", range(5))
def test_the_gap_is_the_distance_for_a_million_places(tools, outline, part):
    seen, inside, corner = campaign(100 + part, tools, outline, 200, 250)
    assert min(seen, inside) > 10_000
    assert corner > 500  # a U has two hollow corners


def way_out(table, n, radius):
    """Distance of a disc's centre from the boundary by what detection found, < 0 inside: the least way that opens it.

    At a hollow corner that is the way which opens both of its sides.
    """
    d = table.gap[:n] + radius
    beyond = np.flatnonzero((table.s[:n] < 0.0) | (table.s[:n] > 1.0))
    if d.min() >= 0.0 or d.argmin() not in beyond:
        return d.min()
    assert len(beyond) == 2
    return -math.hypot(*np.linalg.solve(table.normal[beyond], -d[beyond]))


@pytest.mark.parametrize("outline", OUTLINES)
def test_the_way_out_has_no_jumps_along_a_path(tools, outline):
    """It changes by no more than the disc has moved, through free space, solid and hollow corners alike."""
    rng = np.random.default_rng(5)
    deepest = 0.0
    for _ in range(8):
        corners = OUTLINES[outline](rng)
        wall = shapes.chain([tools.place(*xy) for xy in corners], closed=True)
        model = tools.pair(shapes.circle(tools.place(0.0, 0.0), 0.02), wall)
        table = tools.table_of(model, 512)
        a, b = rng.uniform(-1.1, 1.1, (2, 2))
        ways = []
        for place in a + np.linspace(0.0, 1.0, 400)[:, None] * (b - a):
            n = detect(model, np.array([*place, 0.0]), 3.0, table)
            assert 0 < n <= 512
            ways.append(way_out(table, n, 0.02))
        assert np.abs(np.diff(ways)).max() <= math.hypot(*(b - a)) / 399.0 + 1e-12
        deepest = min(deepest, *ways)
    assert deepest < -0.05


@pytest.mark.parametrize(("teeth", "radius"), [(8, 5e-4), (10, 5e-4), (12, 5e-4), (12, 0.0), (40, 5e-4)])
@pytest.mark.parametrize("size", [1.0, 1e3, 1e-3])
def test_the_face_of_another_tooth_is_not_felt_across_the_wheel(tools, teeth, radius, size):
    """A saw wheel: the line of the opposite tooth passes nearer than the true face does, 90 mm from that tooth."""
    angles = 0.5 * math.pi + 2.0 * math.pi * np.arange(teeth) / teeth
    corners = np.array([(r * math.cos(t), r * math.sin(t)) for t in angles for r in (0.05, 0.04)])
    place = np.array([-0.00205617, 0.0503265])
    way, _, _ = signed_distance(corners, place[None])
    probe = shapes.node(tools.place(0.0, 0.0), radius * size)
    model = tools.pair(probe, shapes.chain([tools.place(*xy) for xy in size * corners], closed=True))
    found = tools.find(model, [*(size * place), 0.0], margin=0.01 * size)
    if radius > 0.0:
        assert abs(min(c.gap for c in found) - size * (way[0] - radius)) < 1e-12 * size
    assert all(c.gap >= size * (way[0] - radius) - 1e-12 * size for c in found)


@pytest.mark.parametrize("half_angle", [0.2, math.pi / 4, 1.0, 1.4])
@pytest.mark.parametrize("aside", [-0.9, -0.3, 0.0, 0.6, 0.99])
def test_below_a_hollow_corner_both_sides_lead_out_by_it(tools, half_angle, aside):
    """Wherever the corner is nearest, also above the line of one side: what opens both gaps moves the point to it."""
    run, rise = math.sin(half_angle), math.cos(half_angle)
    groove = shapes.chain([tools.place(*xy) for xy in ((run, rise), (0.0, 0.0), (-run, rise))])
    widest = 0.5 * math.pi - half_angle  # from straight down, half the angle of the places that are over neither side
    place = 1e-3 * np.array([math.sin(aside * widest), -math.cos(aside * widest)])
    model = tools.pair(shapes.node(tools.place(0.0, 0.0)), groove)
    found = tools.find(model, [*place, 0.0], margin=2e-3)
    assert len(found) == 2
    W, g = np.array([c.normal for c in found]), np.array([c.gap for c in found])
    np.testing.assert_allclose(W @ place, g, atol=1e-15)
    np.testing.assert_allclose(np.linalg.solve(W, -g), -place, atol=1e-13)
    assert g.min() < 0.0


def test_nodes_of_one_outline_find_the_boundary_of_another(tools):
    """Two outlines through each other: no node outside has a contact, and none inside whose nearest face it meets."""
    rng = np.random.default_rng(11)
    kinds = list(OUTLINES.values())
    met = outside = 0
    for _ in range(40):
        own, other = kinds[rng.integers(4)](rng) * rng.choice([0.3, 1.0]), kinds[rng.integers(4)](rng)
        node, master = (shapes.chain([tools.place(*c) for c in xy], closed=True) for xy in (own, other))
        model = tools.pair(node, master, 0, 1, (0, 0))
        table = tools.table_of(model, 1024)
        features = len(model.contacts.feature_kind)
        along = np.roll(own, -1, axis=0) - own
        along /= np.hypot(*along.T)[:, None]
        mean = np.stack([along[:, 1], -along[:, 0]], axis=1)
        mean += np.roll(mean, 1, axis=0)
        for _ in range(10):
            x, y, angle = *rng.uniform(-1.3, 1.3, 2), rng.uniform(0.0, 7.0)
            turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
            nodes, outward = own @ turn.T + (x, y), mean @ turn.T
            n = detect(model, np.array([x, y, angle, 0.0, 0.0, 0.0]), 0.0, table)
            way, nearest, s = signed_distance(other, nodes)
            gaps = {}
            for k in range(n):
                if table.body[k, 0] == 0:
                    gaps.setdefault(int(table.key[k]) // features, []).append(table.gap[k])
            for i in range(len(own)):
                if way[i] > 1e-9:
                    outside += 1
                    assert i not in gaps
                elif way[i] < -1e-9 and 0.0 < s[i] < 1.0:
                    edge = other[(nearest[i] + 1) % len(other)] - other[nearest[i]]
                    if outward[i, 0] * edge[1] - outward[i, 1] * edge[0] < -1e-6:
                        met += 1
                        assert abs(min(gaps[i]) - way[i]) < 1e-12
    assert met > 300
    assert outside > 1000


# ---- a mesh


def meshed_u_on_rough_ground(rng, wall_height):
    """A U of 200 mm, meshed and bending, over ground with a random node every 20 mm."""
    whole = libs.skfem.MeshQuad.init_tensor(np.linspace(-0.1, 0.1, 11), np.linspace(0.0, 0.16, 9))
    middles = whole.p[:, whole.t].mean(axis=1)
    mesh = whole.restrict(np.flatnonzero((middles[1] < 0.04) | (np.abs(middles[0]) > 0.06)))
    body = lf.Continuum(mesh, density=2700, youngs_modulus=7e8, poissons_ratio=0.33, thickness=0.02)
    scene = lf.Scene()
    u = scene.add(body.reduce(modes=6, damping=0.05), position=(0.0, 5.0))
    ground = np.stack([np.linspace(0.6, -0.6, 61), rng.uniform(0.0, wall_height, 61)], axis=1)
    scene.contact(u.surface(), scene.ground.chain(ground), friction=0.3, name="ground")
    return scene, ground


@pytest.mark.parametrize("wall_height", [0.005, 0.02])
@pytest.mark.parametrize("bent", [False, True])
def test_a_meshed_u_on_rough_ground_touches_what_is_there(wall_height, bent):
    """No node above the ground has a contact with it, and no node of the ground outside the U one with that."""
    rng = np.random.default_rng(17)
    met = [0, 0]
    for _ in range(4):
        scene, ground = meshed_u_on_rough_ground(rng, wall_height)
        compiled = scene.compiled()
        model, table = pack(compiled.model), contact_table(512, 2)
        points, contacts = compiled.model.points, compiled.model.contacts
        corners = [a for a, b in contacts.feature_point if points.body[a] >= 0 and a != b]
        for _ in range(40):
            q = compiled.q.copy()
            q[:3] = rng.uniform(-0.3, 0.3), rng.uniform(-0.05, 0.15), rng.uniform(0.0, 7.0)
            if bent:
                q[3:5] = 1e-3 * rng.normal(size=2)
            turn = np.array([[math.cos(q[2]), -math.sin(q[2])], [math.sin(q[2]), math.cos(q[2])]])
            outline = points.place[corners] + [
                q[3:] @ points.phi[points.start[p] : points.start[p + 1]] for p in corners
            ]
            n = detect(model, q, 0.0, table)
            assert n <= 512
            for k in range(n):
                p = table.node[k]
                if table.body[k, 0] >= 0:
                    met[0] += 1
                    x, y = turn @ outline[corners.index(p)] + q[:2]
                    assert y <= np.interp(x, *ground[::-1].T) + 1e-9
                else:
                    met[1] += 1
                    way, _, _ = signed_distance(outline, ((points.place[p] - q[:2]) @ turn)[None])
                    assert way[0] <= 1e-9
    assert min(met) > 300
