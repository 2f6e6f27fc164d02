"""Ends of open arcs are corners: they touch what corners of chains touch, and an arc is where its points are."""

from __future__ import annotations

import math

import numpy as np
import pytest

import lcpflex as lf
from tests.scenes import floor_of
from tests.unit.contact.test_contacts_of_scenes import found

DEGREES = math.pi / 180.0
R = 0.037


def arc_points(center, radius, start, extent, n=4001):
    angles = start + np.linspace(0.0, extent, n)
    return np.asarray(center) + radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)


def lowest(start, extent):
    """y of the lowest point of an arc about the origin."""
    return float(arc_points((0.0, 0.0), R, start, extent)[:, 1].min())


def horseshoe(scene, extent, hole=False, height=0.0, modes=False):
    """A body with an arc whose mouth, or else whose middle, looks down."""
    body = scene.add(lf.RigidBody(0.2, 1e-4), "c", position=(0.0, height))
    return body, body.arc((0.0, 0.0), R, 0.5 * math.pi - 0.5 * extent, extent, hole=hole)


# ---- where they are


@pytest.mark.parametrize("extent", np.array([10.0, 60.0, 120.0, 180.0, 181.0, 260.0, 350.0, 359.9, 360.0]) * DEGREES)
@pytest.mark.parametrize("against", ["half-plane", "chain", "box"])
@pytest.mark.parametrize("swapped", [False, True])
def test_an_arc_with_its_mouth_down_is_as_far_from_a_floor_as_its_lowest_points(extent, against, swapped):
    scene = lf.Scene()
    low = lowest(0.5 * math.pi - 0.5 * extent, extent)
    _, surface = horseshoe(scene, extent, height=1e-4 - low)
    if against == "half-plane":
        floor = floor_of(scene)
    elif against == "chain":
        floor = scene.ground.chain([(1.0, 0.0), (-1.0, 0.0)])
    else:
        floor = scene.add(lf.Box(2.0, 0.4, mass=1.0), position=(0.0, -0.2)).surface()
    scene.contact(*((floor, surface) if swapped else (surface, floor)))
    contacts = found(scene, margin=1.01e-4)
    assert len(contacts) == (1 if extent > 359.95 * DEGREES else 2)
    for _, normal, gap in contacts:
        np.testing.assert_allclose(normal, (0.0, 1.0), atol=1e-12)
        assert abs(gap - 1e-4) < 1e-9  # the samples of the whole circle


@pytest.mark.parametrize("beyond", [-0.3, -1e-6, 0.0, 1e-6, 0.3, 1.2])
@pytest.mark.parametrize("hole", [False, True])
@pytest.mark.parametrize("which", ["beginning", "end"])
def test_a_disc_beside_an_end_touches_the_corner_and_over_the_arc_the_arc(beyond, hole, which):
    """At the seam the gap is continuous; the corner of part of a hole is met from inside."""
    start, extent = 0.4, 2.0
    radius, apart = 0.01, 1e-5
    angle = start - beyond if which == "beginning" else start + extent + beyond
    end = start if which == "beginning" else start + extent
    reach = R - radius - apart if hole else R + radius + apart
    place = reach * np.array([math.cos(angle), math.sin(angle)])
    scene = lf.Scene()
    scene.contact(
        scene.add(lf.Disc(radius, mass=1.0), position=place).surface(),
        scene.ground.arc((0.0, 0.0), R, start, extent, hole=hole),
    )
    contacts = found(scene, margin=1.0)
    corner = R * np.array([math.cos(end), math.sin(end)])
    if beyond > 0.0:
        _, normal, gap = min(contacts, key=lambda contact: contact[2])
        assert gap == pytest.approx(math.hypot(*(place - corner)) - radius, abs=1e-14)
        np.testing.assert_allclose(normal, (place - corner) / math.hypot(*(place - corner)), atol=1e-9)
    else:
        assert min(gap for *_, gap in contacts) == pytest.approx(apart, abs=1e-14)


def corners_of(scene, **kwargs):
    return [(tuple(np.round(normal, 9) + 0.0), round(gap, 12)) for _, normal, gap in found(scene, **kwargs)]


@pytest.mark.parametrize("hole", [False, True])
def test_a_board_lies_on_both_ends_of_a_gutter(hole):
    """Its chain has no corner there, so those of the gutter must touch it; a solid arc is a dome below the board."""
    scene = lf.Scene()
    board = scene.add(lf.Box(1.0, 0.02, mass=1.0), position=(0.05, 0.01))
    gutter = scene.ground.arc((0.0, 0.0), 0.2, math.pi, math.pi, hole=hole)
    scene.contact(board.surface(), gutter)
    assert corners_of(scene) == [((0.0, -1.0), 0.0)] * 2


def test_a_gutter_stands_on_its_edges():
    """Part of a hole has no side that touches a half-plane but its ends."""
    scene = lf.Scene(gravity=(0.0, -9.81))
    _, surface = horseshoe(scene, math.pi, hole=True)
    scene.contact(surface, floor_of(scene))
    assert corners_of(scene) == [((0.0, 1.0), 0.0)] * 2
    result = lf.simulate(scene, 0.05, lf.MoreauJean(step=1e-3), progress=False)
    assert abs(result.q[-1, 1]) < 1e-9
    assert not result.warnings


def test_two_arcs_touch_by_their_ends_in_both_orders():
    for swapped in (False, True):
        scene = lf.Scene()
        low = scene.add(lf.RigidBody(1.0, 1e-3)).arc((0.0, 0.0), 0.1, 0.0, math.pi)
        up = scene.add(lf.RigidBody(1.0, 1e-3), position=(0.0, 0.15)).arc(
            (0.0, 0.0), 0.05, 0.25 * math.pi, 1.5 * math.pi
        )
        scene.contact(*((up, low) if swapped else (low, up)))
        reach = 0.15 - 0.05 - 0.1  # the upper one's lowest point is in its span
        assert min(gap for *_, gap in found(scene)) == pytest.approx(reach, abs=1e-15)
        scene = lf.Scene()
        low = scene.add(lf.RigidBody(1.0, 1e-3)).arc((0.0, 0.0), 0.1, 0.0, math.pi)
        up = scene.add(lf.RigidBody(1.0, 1e-3), position=(0.0, 0.14)).arc(
            (0.0, 0.0), 0.05, -0.25 * math.pi, 1.5 * math.pi
        )
        scene.contact(*((up, low) if swapped else (low, up)))
        tip = np.array([0.05 * math.cos(0.25 * math.pi), 0.14 - 0.05 * math.sin(0.25 * math.pi)])
        assert corners_of(scene, margin=0.1)[0][1] == pytest.approx(math.hypot(*tip) - 0.1, abs=1e-11)
        assert len(found(scene, margin=0.1)) == 2


def test_ends_of_slots_and_whole_circles_are_no_corners():
    scene = lf.Scene()
    slot = scene.ground.curved_slot((0.0, 0.0), 0.1, 0.02, 0.0, 1.0)
    straight = scene.ground.straight_slot((1.0, 0.0), (1.2, 0.0), 0.02)
    surfaces = [*slot.parts, straight.first, straight.last]
    surfaces.append(scene.ground.arc((0.0, 0.0), 0.1, 1.0, 2.0 * math.pi))
    assert all(not surface.shape.ends() for surface in surfaces)
    assert len(scene.ground.arc((0.0, 0.0), 0.1, 1.0, 2.0 * math.pi - 1e-6).shape.ends()) == 2


def test_an_end_moves_with_a_flexible_body():
    """On a cantilever whose tip turns, the ends of an arc about the tip turn with it."""
    scene = lf.Scene()
    beam = scene.add(
        lf.Beam(1.0, 0.02, 0.005, 7800.0, 2.1e11, elements=10).reduce(modes=4), name="beam", position=(0, 0.3)
    )
    arc = beam.arc("right", 0.1, -0.25 * math.pi, 1.5 * math.pi)  # its mouth looks down
    scene.contact(arc, floor_of(scene))
    compiled = scene.compiled()
    q = compiled.q.copy()
    q[3:] = np.linspace(2e-3, 1e-3, len(q) - 3)
    model, points = compiled.model, compiled.model.points
    center = int(model.contacts.node_point[0])
    first, last = points.start[center], points.start[center + 1]
    turn = float(points.psi[first:last] @ q[3:])
    place = points.place[center] + q[3:] @ points.phi[first:last] + q[:2]
    low = [place[1] + 0.1 * math.sin(angle + turn) for angle in (-0.25 * math.pi, 1.25 * math.pi)]
    gaps = [gap for *_, gap in found(scene, margin=1.0, q=q)]
    assert abs(turn) > 1e-3
    assert min(gaps) == pytest.approx(min(low), abs=0.06 * turn**2)  # their lever of .1 m is carried: linear in q
    assert abs(min(low) - (place[1] - 0.1 * math.sin(0.25 * math.pi))) > turn**2  # it is turned that is told


# ---- an arc is where its points are


def sector_is_free(polygon, start, extent):
    """Whether no side of the polygon comes into the solid of an arc about the origin, the sector to its centre."""
    ends = np.roll(polygon, -1, axis=0)
    s = np.linspace(0.0, 1.0, 400)[:, None, None]
    points = (polygon + s * (ends - polygon)).reshape(-1, 2)
    angle = (np.arctan2(points[:, 1], points[:, 0]) - start) % (2.0 * math.pi)
    return not ((np.hypot(*points.T) < R + 1e-4) & (angle < extent + 0.01)).any()


def distance(points, polygon):
    """Least distance of points to the sides of a polygon, and whether it is to a corner from an end of the points."""
    ends = np.roll(polygon, -1, axis=0)
    step = ends - polygon
    apart = points[:, None] - polygon[None]
    s = np.clip((apart * step).sum(axis=2) / (step * step).sum(axis=1), 0.0, 1.0)
    away = np.hypot(*np.moveaxis(apart - s[..., None] * step, 2, 0))
    i, j = np.unravel_index(np.argmin(away), away.shape)
    return float(away[i, j]), s[i, j] in (0.0, 1.0) and i in (0, len(points) - 1)


@pytest.mark.parametrize("swapped", [False, True])
def test_an_arc_is_as_far_from_a_polygon_as_its_points(swapped):
    """Polygons of any form before the mouth, in it and beside: a side that faces the mouth is no contact behind it."""
    rng = np.random.default_rng(11)
    seen = corners = 0
    while seen < 60:
        start, extent = rng.uniform(0.0, 2.0 * math.pi), rng.uniform(0.2, 6.0)
        angles = np.sort(rng.uniform(0.0, 2.0 * math.pi, rng.integers(3, 8)))
        size = rng.uniform(0.2, 1.6, len(angles)) * R
        polygon = np.stack([np.cos(angles), np.sin(angles)], axis=1) * size[:, None]
        if np.diff(angles, append=angles[0] + 2.0 * math.pi).max() > 3.0:
            continue  # not around its own centre
        mouth = start + 0.5 * extent + math.pi
        polygon += rng.uniform(0.6, 2.5) * R * np.array([math.cos(mouth), math.sin(mouth)])
        polygon += rng.normal(size=2) * 0.3 * R
        if not sector_is_free(polygon, start, extent):
            continue
        points = arc_points((0.0, 0.0), R, start, extent)
        away, between_corners = distance(points, polygon)
        scene = lf.Scene()
        arc = scene.add(lf.RigidBody(1.0, 1e-3)).arc((0.0, 0.0), R, start, extent)
        chain = scene.add(lf.RigidBody(1.0, 1e-3)).chain(polygon, closed=True)
        scene.contact(*((chain, arc) if swapped else (arc, chain)))
        gaps = [gap for *_, gap in found(scene, margin=4.0 * R)]
        seen += 1
        corners += between_corners
        assert min(gaps, default=math.inf) >= away - 1e-7
        if not between_corners:
            assert min(gaps) == pytest.approx(away, abs=1e-6)
    assert corners < 50


# ---- runs


def steppers():
    return [
        lf.MoreauJean(step=1e-4),
        lf.GeneralizedAlpha(step=1e-4),
        lf.EventDriven(),
        lf.MoreauJean(step=1e-4, adaptive=lf.AdaptiveStep(rtol=1e-4)),
    ]


@pytest.mark.parametrize("stepper", steppers(), ids=lambda s: type(s).__name__ + str(getattr(s, "adaptive", "")))
def test_a_horseshoe_falls_on_its_ends_and_stays(stepper):
    scene = lf.Scene(gravity=(0.0, -9.81))
    extent = 260.0 * DEGREES
    _, surface = horseshoe(scene, extent, height=0.033)
    scene.contact(surface, floor_of(scene), friction=0.3)
    result = lf.simulate(scene, 0.15, stepper, progress=False)
    assert result.q[-1, 1] == pytest.approx(-lowest(0.5 * math.pi - 0.5 * extent, extent), abs=2e-6)
    assert np.abs(result.u[-1]).max() < 1e-6


def test_a_rocker_that_tips_over_the_end_of_its_arc_turns_about_the_corner():
    """As on a chain of many nodes. Its energy is kept: the step from the arc to the corner is smooth."""
    angles = []
    for kind in ("arc", "chain"):
        scene = lf.Scene(gravity=(0.0, -9.81))
        body = scene.add(lf.RigidBody(1.0, 2e-3), "r", position=(0.0, 0.1), angular_velocity=-4.0, velocity=(0.4, 0.0))
        start, extent = -0.5 * math.pi - 0.3, 0.6
        if kind == "arc":
            surface = body.arc((0.0, 0.0), 0.1, start, extent)
        else:
            surface = body.chain(arc_points((0.0, 0.0), 0.1, start, extent, 200))
        scene.contact(surface, floor_of(scene), friction=0.9)
        result = lf.simulate(scene, 0.25, lf.MoreauJean(step=1e-4), progress=False)
        assert result.energies.relative_remainder < 1e-2
        angles.append(float(result.q[-1, 2]))
    assert angles[0] < -0.5
    assert angles[0] == pytest.approx(angles[1], abs=5e-3)


def test_a_corner_turns_in_the_mouth_of_an_arc():
    """A wheel's notch before the mouth of a crank's arc, and the crank turned: nothing touches, nothing is refused."""
    corners = [(0.00683, 0.01397), (0.03178, 0.03893), (-0.04233, 0.02382), (-0.02382, -0.04233), (0.03178, -0.03893)]
    for scale in (1.0, 1000.0):
        scene = lf.Scene(gravity=(0, 0))
        crank = scene.add(lf.RigidBody(0.2, 1e-4 * scale**2), "crank", angle=math.radians(-17.1))
        wheel = scene.add(
            lf.RigidBody(0.3, 2e-4 * scale**2),
            "wheel",
            position=(0.05 * scale * math.sqrt(2), 0),
            angle=math.radians(-12.2),
        )
        arc = crank.arc((0, 0), R * scale, math.radians(50), math.radians(260))
        scene.contact(arc, wheel.chain(scale * np.array(corners), closed=True), name="lock")
        assert min((gap for *_, gap in found(scene, margin=0.02 * scale)), default=math.inf) > 1e-3 * scale
        result = lf.simulate(scene, 1e-3, lf.MoreauJean(step=1e-4), progress=False)
        assert np.abs(result.u).max() == 0.0
