"""Flexible bodies in space whose meshes are their surfaces: rigid contacts of deforming facets."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

import lcpflex as lf
from tests.solids import block

EDGE = 0.1


@cache
def soft_cube() -> lf.SpatialBody:
    """A cube of rubber with 8 modes, its centre at the origin and its mesh as its surface."""
    made = block((EDGE, EDGE, EDGE), (2, 2, 2), "hex1", density=1000.0, youngs_modulus=2e6)
    places = made["coordinates"] - 0.5 * EDGE
    triangles: list[Any] = []
    for axis in range(3):
        for side in (-1.0, 1.0):
            on = np.flatnonzero(np.isclose(places[:, axis], side * 0.5 * EDGE))
            flat = np.delete(places[on], axis, axis=1)
            for x in (-0.5 * EDGE, 0.0):
                for y in (-0.5 * EDGE, 0.0):
                    half = 0.5 * EDGE
                    cell = [
                        on[np.argmin(np.abs(flat - p).sum(axis=1))]
                        for p in ((x, y), (x + half, y), (x + half, y + half), (x, y + half))
                    ]
                    for corners in ((cell[0], cell[1], cell[2]), (cell[0], cell[2], cell[3])):
                        a, b, c = places[list(corners)]
                        outside = np.cross(b - a, c - a)[axis] * side > 0.0
                        triangles.append(corners if outside else corners[::-1])
    assert len(triangles) == 48
    assert ConvexHull(places).volume == pytest.approx(EDGE**3)
    return lf.SpatialMatrices(**{**made, "coordinates": places}, triangles=np.array(triangles)).reduce(modes=8)


def momenta(scene: lf.SpatialScene, result: lf.Result, count: int) -> Any:
    """Linear momentum of all bodies at all instants; modes of free bodies have none."""
    mass = soft_cube().mass
    size = result.u.shape[1] // count
    return mass * sum(result.u[:, b * size : b * size + 3] for b in range(count))


@pytest.mark.slow
@pytest.mark.parametrize("friction", [0.0, 0.4])
def test_a_soft_cube_falls_on_a_plane(friction: float) -> None:
    scene = lf.SpatialScene()
    turn = Rotation.from_rotvec([0.3, -0.4, 0.2])
    cube = scene.add(soft_cube(), "cube", (0.0, 0.0, 0.1), turn, (0.5, 0.2, -1.0), (3.0, -2.0, 5.0))
    scene.contact(cube.surface(), scene.ground.plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0)), friction=friction, name="floor")
    result = lf.simulate(scene, 0.1, lf.MoreauJean(2e-5))
    mass = soft_cube().mass
    impulse = result.contact("floor").impulse
    assert impulse[-1, 0] > 0.5 * mass
    change = momenta(scene, result, 1) - momenta(scene, result, 1)[0]
    change[:, 2] += mass * 9.81 * result.times
    pushed = impulse[:, 1:] + impulse[:, :1] * [0.0, 0.0, 1.0]
    np.testing.assert_allclose(change, pushed, atol=1e-9)
    assert result.energies.relative_remainder < 2e-3
    # how much of the loss is that of friction is no sign of right or wrong: normal impulses drive slip, too
    along = np.linalg.norm(impulse[-1, 1:])
    assert along > 0.1 if friction else along == 0.0
    assert np.abs(result.u[-1, 6:]).max() > 1e-3  # it rings


@pytest.mark.slow
def test_two_soft_cubes_meet() -> None:
    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    one = scene.add(soft_cube(), "one", (0.0, 0.0, 0.0), angular_velocity=(1.0, 0.0, 2.0), velocity=(0.5, 0.0, 0.0))
    turn = Rotation.from_rotvec([0.3, -0.4, 0.2])
    two = scene.add(soft_cube(), "two", (0.15, 0.02, 0.01), turn, (-1.0, 0.1, 0.0), (2.0, 1.0, -3.0))
    scene.contact(one.surface(), two.surface(), friction=0.3, name="pair")
    result = lf.simulate(scene, 0.06, lf.MoreauJean(2e-5))
    total = momenta(scene, result, 2)
    assert result.contact("pair").impulse[-1, 0] > 0.1
    np.testing.assert_allclose(total, np.broadcast_to(total[0], total.shape), atol=1e-12)
    assert result.energies.relative_remainder < 2e-3
