"""By how much changes of coordinates move places: at most, and the point that they move farthest."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from lcpflex import gallery
from lcpflex.jit.kernel import FloatArray
from lcpflex.results.motion_units import Units

SCENES = ("pendulum", "double_pendulum", "two_bars", "puck", "sphere_on_plate")


def units_of(scene: Any) -> tuple[Units, int]:
    model = scene.compile().model
    ndof = int(model.bodies.dof[-1])
    return Units(model, ndof), ndof


def swinging(m: int, ndof: int) -> FloatArray:
    """Rates of m instants, of waves that come and go."""
    rng = np.random.default_rng(5)
    t = np.linspace(0.0, 300.0, m)[:, None]
    return np.asarray(rng.normal(size=ndof) * np.sin(t * rng.uniform(0.5, 9.0, ndof)) * np.sin(0.01 * t))


@pytest.mark.parametrize("name", SCENES)
def test_signs_of_modes_make_it_no_larger(name: str) -> None:
    units, ndof = units_of(gallery.scenes()[name].build())
    for u in (swinging(200, ndof), np.zeros((3, ndof)), np.ones((70, ndof)), np.zeros((0, ndof))):
        moved, turned = units.parts(u)
        assert moved.shape == turned.shape == (len(u), units.count)
        assert np.all(moved + turned <= units.of(u) * (1.0 + 1e-12))


def test_parts_are_of_the_point_that_moves_farthest() -> None:
    """A beam that moves, turns and bends: places of its ends, by their own motion."""
    scene = lf.Scene()
    beam = lf.Beam(length=1.0, width=0.02, thickness=0.02, density=7800.0, youngs_modulus=2.1e11)
    scene.add(beam, name="beam", modes=3)
    result = lf.simulate(scene, 1e-3, lf.MoreauJean(1e-3), progress=False)
    units, change = Units(result.compiled.model, result.u.shape[1]), np.zeros((1, result.u.shape[1]))
    change[0, 3:] = 1e-4
    moved, turned = units.parts(change)
    bent = [
        np.linalg.norm(result.compiled.model.points.phi[a:b].T @ change[0, 3:])
        for a, b in zip(result.compiled.model.points.start[:-1], result.compiled.model.points.start[1:], strict=True)
        if b - a == result.u.shape[1] - 3
    ]
    assert moved[0, 0] == pytest.approx(max(bent))
    assert turned[0, 0] == 0.0
    change[0, :3] = (3e-3, 4e-3, 0.1)
    moved, turned = units.parts(change)
    assert moved[0, 0] == pytest.approx(5e-3 + max(bent))
    assert turned[0, 0] == pytest.approx(0.1 * units.extent(0))


def test_what_is_not_finite_has_no_size() -> None:
    units, ndof = units_of(gallery.scenes()["pendulum"].build())
    u = swinging(50, ndof)
    u[20, 4] = np.nan
    assert np.isnan(units.of(u)).sum() == 1
    assert np.isnan(sum(units.parts(u))).sum() == 1
