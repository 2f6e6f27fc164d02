"""Balls pressed into solid blocks against Hertz: force, radius and pressure for a given approach.

    F = 4/3 E* R^(1/2) d^(3/2),   a = (R d)^(1/2),   p = p0 (1 - r^2 / a^2)^(1/2),   p0 = 3 F / (2 pi a^2)

A quarter of each body, eight radii of the contact wide, stands for a half space: its far faces have the displacements
of Boussinesq's, which the whole force pushes at the origin. Elements are of one size h where the contact is, and grow
from there on. The radius is that of the forces, <r^2> = 2 a^2 / 5.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.jit.kernel import FloatArray
from tests.pressed_solids import Part, Rows, graded, grid_block, meet, press, touch_ground

E, NU = 2e11, 0.3
STEEL: dict[str, Any] = {"density": 7800.0, "youngs_modulus": E, "poissons_ratio": NU}
A = 5e-4  # [m] a
WIDE, ZONE, GROWTH = 8.0, 1.3, 1.4  # [a] of a body, of what may touch at least; of elements beyond
RIGID_BALL, ELASTIC_BALL = (
    0.05,
    0.025,
)  # a/R; the second is a half space as far as .2, its slope at its sides


def hertz(modulus: float, radius: float) -> tuple[float, float]:
    """F and p0 for a contact of radius A."""
    force = 4.0 / 3.0 * modulus * A**3 / radius
    return force, 1.5 * force / (math.pi * A**2)


def boussinesq(places: FloatArray) -> FloatArray:
    """(N, 3) displacements of the half space z < 0 by a unit force on it at the origin [m/N]."""
    x, y, z = places.T
    r = np.maximum(np.linalg.norm(places, axis=1), 1e-3 * A)  # there they are not used
    stiff = 4.0 * math.pi * E / (2.0 * (1.0 + NU)) * r
    outward = (-z / r**2 - (1.0 - 2.0 * NU) / (r - z)) / stiff
    return np.column_stack([outward * x, outward * y, -(2.0 * (1.0 - NU) + (z / r) ** 2) / stiff])


def quarter(kind: str, fine: float, radius: float = math.inf) -> lf.Solid:
    """A block below z = 0 of elements with h = a/fine; with a radius the lower part of a ball above it."""
    h = A / fine
    zone = math.ceil(ZONE * fine) * h
    line = graded(h, zone, WIDE * A, GROWTH)
    depth = graded(h, h, WIDE * A, GROWTH)

    def rise(x: FloatArray, y: FloatArray) -> FloatArray:
        away = x**2 + y**2
        return np.asarray(away / (radius + np.sqrt(radius**2 - away)) if math.isfinite(radius) else 0.0 * x)

    def bent(places: FloatArray) -> FloatArray:
        x, y, z = places.T
        return np.column_stack([x, y, z + rise(x, y) * (1.0 - z / (WIDE * A))])

    def contact(x: FloatArray, y: FloatArray, z: FloatArray) -> Any:
        return (np.abs(z - rise(x, y)) < 1e-9 * A) & (np.maximum(x, y) < zone + 1e-3 * h)

    mesh = grid_block(kind, (line, line, depth if math.isfinite(radius) else -depth[::-1]), bend=bent)
    return lf.Solid(mesh, **STEEL, sets={"contact": contact})


def half_space(solid: lf.Solid, approach: float) -> Part:
    """Its far faces moved towards the other body, and as the force moves them; symmetric about x = 0 and y = 0."""
    places = solid.finite_elements().places
    ball = places[:, 2].max() > 0.5 * WIDE * A
    mirror = np.array([1.0, 1.0, -1.0 if ball else 1.0])
    held = places == 0.0
    held[:, 2] = False
    end = WIDE * A * (1.0 - 1e-9)
    far = (places[:, 0] > end) | (places[:, 1] > end) | (mirror[2] * places[:, 2] < -end)
    held[far] = True
    given = np.zeros_like(places)
    given[far, 2] = mirror[2] * approach
    pushed = np.where(far[:, None], 4.0 * mirror * boussinesq(mirror * places), 0.0)  # the whole force of four quarters
    return Part(solid, held.ravel(), given=given.ravel(), far=pushed.ravel())


class Found(NamedTuple):
    """What is found over what Hertz says."""

    force: float
    approach: float  # for the force that is found
    radius: float
    pressure: float  # rms of the errors within .8 a, over p0
    largest: float  # of these
    rim: float  # rms within a, where the slope of Hertz's pressure is infinite
    rows: Rows


def compared(rows: Rows, force: FloatArray, modulus: float, radius: float) -> Found:
    upright = force * np.abs(rows.normal[:, 2])
    wanted, p0 = hertz(modulus, radius)
    away = np.linalg.norm(rows.place[:, :2], axis=1)
    width = math.sqrt(2.5 * float(upright @ away**2) / float(upright.sum()))
    ratio = 4.0 * float(upright.sum()) / wanted
    error = np.full(len(force), np.nan)
    known = rows.area > 0.0
    error[known] = force[known] / rows.area[known] / p0 - np.sqrt(np.maximum(1.0 - (away[known] / A) ** 2, 0.0))
    inner, whole = error[away < 0.8 * A], error[away < A]
    return Found(ratio, ratio ** (-2.0 / 3.0), width / A, rms(inner), float(np.abs(inner).max()), rms(whole), rows)


def rms(error: FloatArray) -> float:
    return math.sqrt(float(np.mean(error**2)))


def rigid_ball(kind: str, fine: float, by: str) -> Found:
    """A ball of the ground pressed into a block."""
    radius = A / RIGID_BALL
    approach = A**2 / radius
    solid = quarter(kind, fine)
    rows = touch_ground(solid, lambda ground: ground.sphere((0.0, 0.0, radius - approach), radius), by, 0.3 * approach)
    return compared(rows, press(rows, [half_space(solid, 0.0)]).force, E / (1.0 - NU**2), radius)


def elastic_ball(kind: str, ball: float, block: float, by: str = "areas") -> Found:
    """A ball pressed into a block of the same material, elements of both a/ball and a/block; the finer is the slave."""
    radius = A / ELASTIC_BALL
    approach = A**2 / radius
    solids = [quarter(kind, ball, radius), quarter(kind, block)]
    rows = meet(solids[0], solids[1], by, int(block > ball), 1.5 * approach)
    parts = [half_space(solids[0], approach), half_space(solids[1], 0.0)]
    return compared(rows, press(rows, parts).force, 0.5 * E / (1.0 - NU**2), radius)


def within(found: float, part: float) -> bool:
    return abs(found - 1.0) < part


def test_a_rigid_ball_on_nodes_of_linear_hexahedra() -> None:
    """The best pressures there are."""
    found = rigid_ball("hexahedron", 5.0, "nodes")
    assert within(found.force, 0.03)
    assert within(found.approach, 0.03)
    assert within(found.radius, 0.03)
    assert found.largest < 0.03
    assert found.rim < 0.03


def test_a_rigid_ball_on_areas_of_linear_hexahedra() -> None:
    found = rigid_ball("hexahedron", 5.0, "areas")
    assert within(found.force, 0.03)
    assert within(found.radius, 0.03)
    assert found.pressure < 0.1


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "radius", "pressure"), [("hexahedron27", 0.03, 0.1), ("tetra10", 0.03, 0.15), ("hexahedron20", 0.05, 0.2)]
)
def test_a_rigid_ball_on_areas_of_quadratic_faces(kind: str, radius: float, pressure: float) -> None:
    found = rigid_ball(kind, 3.0, "areas")
    assert within(found.force, 0.03)
    assert within(found.approach, 0.03)
    assert within(found.radius, radius)
    assert found.pressure < pressure


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["hexahedron27", "tetra10"])
def test_nodes_of_quadratic_faces_have_forces_and_no_pressures(kind: str) -> None:
    found = rigid_ball(kind, 3.0, "nodes")
    assert within(found.force, 0.03)
    assert within(found.radius, 0.03)
    assert not found.rows.area.any()


@pytest.mark.parametrize(("ball", "block"), [(4.0, 5.0), pytest.param(5.0, 4.0, marks=pytest.mark.slow)])
def test_an_elastic_ball_on_a_block(ball: float, block: float) -> None:
    """Both deform, and each may be the finer one."""
    found = elastic_ball("hexahedron", ball, block)
    assert within(found.force, 0.03)
    assert within(found.approach, 0.03)
    assert within(found.radius, 0.03)
    assert found.pressure < 0.15


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "ball", "block"), [("hexahedron27", 2.0, 3.0), ("tetra10", 3.0, 2.0)])
def test_an_elastic_ball_of_quadratic_elements(kind: str, ball: float, block: float) -> None:
    found = elastic_ball(kind, ball, block)
    assert within(found.force, 0.03)
    assert within(found.approach, 0.03)
    assert within(found.radius, 0.03)
    assert found.pressure < (0.1 if kind == "hexahedron27" else 0.3)


def line_contact(fine: float, by: str, shape: str) -> tuple[float, float]:
    """A round rod of the ground on a block in plane strain: its half width over b, and the rms error of p over p0.

    b = (4 F R / (pi E*))^(1/2) with the force a length F that is found, as the approach hangs on the depth; p0 = 2 F /
    (pi b), and <x^2> = b^2 / 4.
    """
    h, radius = A / fine, A / RIGID_BALL
    zone = math.ceil(ZONE * fine) * h
    lines = graded(h, zone, WIDE * A, GROWTH), np.linspace(0.0, 2.0 * h, 3), -graded(h, h, WIDE * A, GROWTH)[::-1]
    solid = lf.Solid(
        grid_block("hexahedron", lines), **STEEL, sets={"contact": lambda x, y, z: (z == 0.0) & (x < zone + 1e-3 * h)}
    )
    x, y, z = solid.finite_elements().places.T
    end = WIDE * A * (1.0 - 1e-9)
    held = np.column_stack([x == 0.0, (y == 0.0) | (y == y.max()), np.zeros(len(x), dtype=bool)])
    held[(x > end) | (z < -end)] = True
    approach = 1.9 * A**2 / radius  # which makes b some 1.2 a
    axis = np.array([0.0, 1.0, 0.0])
    middle = np.array([0.0, 0.0, radius - approach])
    made: dict[str, Any] = {
        "cylinder": lambda ground: ground.cylinder(middle, axis, radius, 100.0 * h),
        "capsule": lambda ground: ground.capsule(middle - 50.0 * h * axis, middle + 50.0 * h * axis, radius),
    }
    rows = touch_ground(solid, made[shape], by, 0.3 * approach)
    force = press(rows, [Part(solid, held.ravel())]).force
    upright = force * np.abs(rows.normal[:, 2])
    each = 2.0 * float(upright.sum()) / (2.0 * h)
    b = math.sqrt(4.0 * each * radius * (1.0 - NU**2) / (math.pi * E))
    away = np.abs(rows.place[:, 0])
    inner = away < 0.8 * b
    error = force[inner] / rows.area[inner] * math.pi * b / (2.0 * each) - np.sqrt(1.0 - (away[inner] / b) ** 2)
    return math.sqrt(4.0 * float(upright @ away**2) / float(upright.sum())) / b, rms(error)


@pytest.mark.parametrize(
    ("by", "shape", "pressure"), [("nodes", "cylinder", 0.03), ("areas", "cylinder", 0.1), ("areas", "capsule", 0.1)]
)
def test_a_rigid_rod_on_a_block(by: str, shape: str, pressure: float) -> None:
    width, error = line_contact(5.0, by, shape)
    assert within(width, 0.03)
    assert error < pressure
