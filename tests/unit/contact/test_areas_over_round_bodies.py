"""Gaps of areas of a flat face over round bodies: the means of the gaps of all its places, in closed form."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import lcpflex as lf
from lcpflex.bodies.spatial.surface import SpatialKind, SpatialSurface, rigid_point
from lcpflex.contact.near import near
from lcpflex.jit.kernel import FloatArray
from lcpflex.jit.struct import pack
from lcpflex.scene.placed_surface import PlacedSurface

R, WIDE = 0.4, np.array([0.06, 0.02])
GAP = 1e-4  # of the plane of the face over the body, where it is nearest


def face(nodes: int) -> tuple[SpatialSurface, Callable[[Any], FloatArray]]:
    """One face of elements, three times as long as wide, looking down; and the mean of a function over each area."""
    x, w = np.polynomial.legendre.leggauss(8)  # enough for hats times fourth powers
    x, w = 0.5 * (1.0 + x), 0.5 * w
    u, v = (one.ravel() for one in np.meshgrid(x, x))
    weight = np.outer(w, w).ravel()
    if nodes == 4:
        corners = np.array([(0, 0), (0, 1), (1, 1), (1, 0)])
        hats = np.array([(1 - u) * (1 - v), (1 - u) * v, u * v, u * (1 - v)])
        at = np.column_stack([u, v])
    else:
        corners = np.array([(0, 0), (0, 1), (1, 0)])
        weight, v = weight * (1 - u), v * (1 - u)  # the square folded to the triangle
        at, hats = np.column_stack([u, v]), np.array([1 - u - v, v, u])
    middle = corners.mean(axis=0)
    points = tuple(rigid_point(*((c - middle) * WIDE), 0.0) for c in corners)
    cells = (np.arange(nodes),)
    triangles = np.array([[0, 1, 2], [0, 2, 3]][: nodes - 2])
    places = np.column_stack([(at - middle) * WIDE, np.zeros(len(at))])

    def means(gap: Any) -> FloatArray:
        return np.asarray((hats * weight) @ gap(places) / (hats @ weight))

    return SpatialSurface(SpatialKind.FACE, points, triangles=triangles, cells=cells), means


def on_sphere(p: FloatArray) -> FloatArray:
    return np.asarray(np.linalg.norm(p, axis=1) - R)


def on_side(p: FloatArray) -> FloatArray:
    """Along x."""
    return np.asarray(np.hypot(p[:, 1], p[:, 2]) - R)


UP, ALONG = (0.0, 0.0, 1.0), (1.0, 0.0, 0.0)
LONG = 1.0
BODIES: dict[str, tuple[Callable[[Any], Any], float, Callable[[FloatArray], FloatArray]]] = {
    # what of the ground, height of the face over the origin, distance of places from it
    "sphere": (lambda g: g.sphere((0, 0, 0), R), R + GAP, on_sphere),
    "hole": (lambda g: g.hole((0, 0, 0), R), -R + GAP, lambda p: -on_sphere(p)),
    "side": (lambda g: g.cylinder((0, 0, 0), ALONG, R, LONG), R + GAP, on_side),
    "end": (lambda g: g.cylinder((0, 0, -0.5 * LONG), UP, R, LONG), GAP, lambda p: p[:, 2]),
}


def gaps_over(surface: SpatialSurface, other: Any, height: float, turn: Rotation) -> FloatArray:
    scene = lf.SpatialScene(gravity=(0, 0, 0))
    box = scene.add(lf.Cuboid(0.1, 0.1, 0.1, density=1.0), position=(0, 0, height), orientation=turn)
    placed = PlacedSurface(scene, box.body, "box.face", surface, lambda body: None)
    scene.contact(placed, other(scene), points="areas")
    compiled = scene.compile(indents=lambda name: True)
    table, n = near(pack(compiled.model), np.array(compiled.q), 0.1 * R)
    return np.asarray(table.gap[:n].copy())


def check(surface: SpatialSurface, means: Any, other: Any, height: float, distance: Any, turn: Rotation) -> None:
    found = gaps_over(surface, other, height, turn)
    expected = means(lambda places: distance(turn.apply(places) + np.array([0.0, 0.0, height])))
    farthest = max(float(np.linalg.norm(point.place)) for point in surface.points)
    np.testing.assert_allclose(found, expected, atol=farthest**4 / (8.0 * R**3))  # the next term of the distance


@pytest.mark.parametrize("nodes", [3, 4])
@pytest.mark.parametrize("yaw", [0.0, 30.0, 90.0])
@pytest.mark.parametrize("name", BODIES)
def test_an_area_has_the_mean_gap_over_a_round_body(name: str, yaw: float, nodes: int) -> None:
    """However long elements are, and however they lie to the axis."""
    other, height, distance = BODIES[name]
    check(
        *face(nodes), lambda scene: other(scene.ground), height, distance, Rotation.from_euler("z", yaw, degrees=True)
    )


@pytest.mark.parametrize("yaw", [0.0, 30.0, 90.0])
@pytest.mark.parametrize("upright", [False, True])
def test_an_area_has_the_mean_gap_over_a_capsule(upright: bool, yaw: float) -> None:
    """Over its side, and over its round end, which curves both ways."""

    def capsule(scene: lf.SpatialScene) -> Any:
        turn = Rotation.identity() if upright else Rotation.from_euler("y", 90.0, degrees=True)
        place = (0.0, 0.0, -0.5 * LONG if upright else 0.0)
        return scene.add(lf.Capsule(R, LONG, density=1.0), position=place, orientation=turn).surface()

    distance = on_sphere if upright else on_side
    check(*face(4), capsule, R + GAP, distance, Rotation.from_euler("z", yaw, degrees=True))
