"""Rigid bodies: mass properties against closed forms, outlines with their solid on the left."""

from __future__ import annotations

import math

import numpy as np
import pytest

from lcpflex.bodies import Box, Chain, Disc, Polygon, RigidBody, Round
from lcpflex.errors import ModelError

PENTAGON = [(2.0, 1.0), (4.0, 1.5), (4.5, 3.0), (3.0, 4.0), (1.5, 2.5)]


def ring_of(outline: object) -> np.ndarray:
    assert isinstance(outline, Chain)
    return np.array([point.place for point in outline.points])


def enclosed_area(ring: np.ndarray) -> float:
    x, y = ring.T
    return 0.5 * float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))


def test_mass_properties_move_to_the_origin_of_the_frame():
    body = RigidBody(2.0, 0.3, center=(0.4, -0.2), points={"tip": (1.0, 0.0)})
    assert body.modes == 0
    assert body.moment == pytest.approx([0.8, -0.4])
    assert body.inertia == pytest.approx(0.3 + 2.0 * 0.2)
    assert set(body.points) == {"center", "tip"}
    assert body.locate(7.0, -3.0).place == pytest.approx([7.0, -3.0])
    assert body.locate(7.0, -3.0).phi.shape == (0, 2)


def test_disc():
    body = Disc(0.2, density=7800.0, thickness=0.05)
    assert body.mass == pytest.approx(7800 * 0.05 * math.pi * 0.04)
    assert body.inertia == pytest.approx(0.5 * body.mass * 0.04)
    outline = body.surfaces["outline"]
    assert isinstance(outline, Round)
    assert (outline.radius, outline.hole) == (0.2, False)
    assert Disc(0.2, mass=3.0).mass == 3.0


def test_box():
    body = Box(0.4, 0.1, density=1000.0)
    assert body.mass == pytest.approx(40.0)
    assert body.inertia == pytest.approx(40.0 * (0.16 + 0.01) / 12)
    assert body.moment == pytest.approx([0.0, 0.0])
    ring = ring_of(body.surfaces["outline"])
    assert enclosed_area(ring) == pytest.approx(0.04)
    outward = {"bottom": (0, -1), "right": (1, 0), "top": (0, 1), "left": (-1, 0)}
    for name, normal in outward.items():
        start, end = ring_of(body.surfaces[name])
        dx, dy = end - start
        assert np.array([dy, -dx]) / math.hypot(dx, dy) == pytest.approx(normal)
        assert 0.5 * (start + end) == pytest.approx(body.points[name].place)
    assert body.points["top_left"].place == pytest.approx([-0.2, 0.05])


@pytest.mark.parametrize("vertices", [PENTAGON, PENTAGON[::-1]])
def test_polygon_against_a_fine_sum(vertices):
    body = Polygon(vertices, density=3.0, thickness=0.5)
    n = 1500
    x, y = np.meshgrid(1.5 + 3.0 * (np.arange(n) + 0.5) / n, 1.0 + 3.0 * (np.arange(n) + 0.5) / n)
    inside = np.ones_like(x, dtype=bool)
    for (ax, ay), (bx, by) in zip(PENTAGON, PENTAGON[1:] + PENTAGON[:1], strict=True):
        inside &= (bx - ax) * (y - ay) - (by - ay) * (x - ax) >= 0
    cell = 1.5 * (3.0 / n) ** 2
    assert body.mass == pytest.approx(cell * inside.sum(), rel=1e-3)
    assert body.moment == pytest.approx([cell * x[inside].sum(), cell * y[inside].sum()], rel=1e-3)
    assert body.inertia == pytest.approx(cell * (x**2 + y**2)[inside].sum(), rel=1e-3)
    ring = ring_of(body.surfaces["outline"])
    assert enclosed_area(ring) == pytest.approx(body.mass / 1.5)
    for k in range(5):
        side = ring_of(body.surfaces[f"side_{k}"])
        (ax, ay), (bx, by) = side[1] - side[0], body.points["center"].place - side[0]
        assert ax * by - ay * bx > 0
        assert {tuple(at) for at in side} == {tuple(vertices[k]), tuple(vertices[(k + 1) % 5])}


def test_polygon_equals_box():
    box = Box(2.0, 3.0, density=5.0)
    polygon = Polygon([(-1, -1.5), (-1, 1.5), (1, 1.5), (1, -1.5)], density=5.0)
    assert polygon.mass == pytest.approx(box.mass, rel=1e-14)
    assert polygon.inertia == pytest.approx(box.inertia, rel=1e-14)
    assert polygon.moment == pytest.approx([0.0, 0.0], abs=1e-12)


def test_polygon_far_from_its_frame_keeps_its_digits():
    near = Polygon(PENTAGON, mass=1.0)
    far = Polygon(np.array(PENTAGON) + np.array([1e4, -2e4]), mass=1.0)
    about_near = near.inertia - near.moment @ near.moment
    about_far = far.inertia - far.moment @ far.moment
    assert about_far == pytest.approx(about_near, rel=1e-6)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: RigidBody(0.0, 1.0), r"mass: 0\.0 was given"),
        (lambda: RigidBody(-1.0, 1.0), "mass: -1"),
        (lambda: RigidBody(float("nan"), 1.0), "mass: nan"),
        (lambda: RigidBody(1.0, float("inf")), "inertia: inf"),
        (lambda: RigidBody(1.0, 1.0, center=(0.0, float("nan"))), "center: .*nan"),
        (lambda: RigidBody(1.0, 1.0, points={"tip": (0.0, 0.0, 0.0)}), "tip"),
        (lambda: RigidBody(1.0, 1.0, points=[(0.0, 0.0)]), "points: .*expected a mapping"),
        (lambda: RigidBody(1.0, 1.0, points={1: (0.0, 0.0)}), "points: .*expected a mapping"),
        (lambda: Disc(0.0, mass=1.0), "radius: 0"),
        (lambda: Disc(1.0), "density, mass"),
        (lambda: Disc(1.0, mass=1.0, density=1.0), "density, mass"),
        (lambda: Disc(1.0, density=-7.0), "density: -7"),
        (lambda: Box(-1.0, 1.0, mass=1.0), "width: -1"),
        (lambda: Box(1.0, float("nan"), mass=1.0), "height: nan"),
        (lambda: Box(1.0, 1.0, density=1.0, thickness=0.0), "thickness: 0"),
        (lambda: Box("wide", 1.0, mass=1.0), "width: 'wide'"),
        (lambda: Polygon([(0, 0), (1, 0)], mass=1.0), "at least 3"),
        (lambda: Polygon([(0, 0), (1, 0), (2, 0)], mass=1.0), "area"),
        (lambda: Polygon([(0, 0), (2, 0), (1, 0.2), (1, 2)], mass=1.0), r"\(1\.0, 0\.2\).*convex"),
        (lambda: Polygon([(0, 0), (1, 0), (1, 0), (0, 1)], mass=1.0), "coincide"),
        (lambda: Polygon([(0, 0), (1, 0), (float("nan"), 1)], mass=1.0), "vertices: .*nan"),
        (
            lambda: Polygon([(math.cos(4 * math.pi * k / 5), math.sin(4 * math.pi * k / 5)) for k in range(5)], mass=1),
            "convex",
        ),
        (lambda: Disc(1.0, mass=1.0).project(lambda x, y: (0.0, 0.0)), "distribution of mass"),
    ],
)
def test_bad_input(make, message):
    with pytest.raises(ModelError, match=message):
        make()
