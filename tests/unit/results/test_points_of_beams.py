"""Points anywhere on a beam after a run: against points that were declared, and closed forms of its line."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import lcpflex as lf
from lcpflex.errors import ModelError

LENGTH, SIDE, E, DENSITY = 0.6, 0.01, 7e10, 2700.0
SECOND = SIDE**4 / 12.0
TURN = Rotation.from_rotvec([0.4, -0.7, 0.5])
PLANAR = [(0.0, 0.0), (0.123, 0.0), (0.3, 0.0), (0.317, -0.003), (0.6, 0.002)]
SPATIAL = [(-0.3, 0.0, 0.0), (-0.177, 0.0, 0.0), (0.017, -0.003, 0.004), (0.3, 0.005, 0.0), (0.1, 0.0, 0.2)]


def spatial_beam() -> lf.SpatialBeam:
    return lf.SpatialBeam(LENGTH, SIDE**2, (SECOND, SECOND), 1.5 * SECOND, DENSITY, E, poissons_ratio=0.3, elements=7)


def swinging(space: bool, declared: bool) -> lf.Result:
    """A beam that is thrown by a force at its end, with the points as sensors."""
    if space:
        scene: Any = lf.SpatialScene()
        body = scene.add(spatial_beam().reduce(6), "beam", (1.0, 2.0, 3.0), orientation=TURN)
        scene.load(lf.Force(body.point("right"), (3.0, 20.0, -10.0)))
    else:
        scene = lf.Scene()
        body = scene.add(lf.Beam(LENGTH, SIDE, SIDE, DENSITY, E, elements=7).reduce(4), "beam", (1.0, 2.0), angle=0.3)
        scene.load(lf.Force(body.point("right"), (3.0, 20.0)))
    for place in (SPATIAL if space else PLANAR) if declared else ():
        scene.sensor(lf.sensors.Point(body.at(*place)))
    return lf.simulate(scene, 0.02, lf.MoreauJean(1e-4), record=0, progress=False)


@pytest.mark.parametrize("space", [False, True])
def test_they_are_where_declared_points_are(space: bool, tmp_path: Path) -> None:
    """At nodes, between them, and off the axis, in place and velocity, and so after a file."""
    sensed, plain = swinging(space, True), swinging(space, False)
    loaded = lf.Result.load(plain.save(tmp_path / "beam.npz"))
    for sensor, place in zip(sensed.sensors, SPATIAL if space else PLANAR, strict=True):
        for result in (plain, loaded):
            found = np.column_stack([result.point("beam", place), result.velocity("beam", place)])
            np.testing.assert_allclose(found, sensor.values, rtol=0.0, atol=1e-11)
    assert np.abs(plain.deflection("beam", (0.123, 0.0, 0.0) if space else (0.123, 0.0))).max() > 1e-4


@pytest.mark.parametrize("space", [False, True])
def test_at_any_time(space: bool) -> None:
    """A state between stored instants has the same points, that of a stored one to the bit."""
    result = swinging(space, False)
    place = (SPATIAL if space else PLANAR)[1]
    whole = result.point("beam", place), result.velocity("beam", place), result.deflection("beam", place)
    k, t = 70, float(result.times[70])
    now = result.at(t)
    for known, found in zip(
        whole, (now.point("beam", place), now.velocity("beam", place), now.deflection("beam", place)), strict=True
    ):
        np.testing.assert_array_equal(found, known[k])
    h = 1e-4
    between = result.at(t + 0.5 * h)
    middle = 0.5 * (whole[0][k] + whole[0][k + 1]) + 0.125 * h * (whole[1][k] - whole[1][k + 1])  # of Hermite's cubic
    np.testing.assert_allclose(between.point("beam", place), middle, rtol=0.0, atol=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("space", [False, True])
def test_a_cantilever_has_its_closed_form_along_all_of_it(space: bool) -> None:
    """w = F x^2 (3 L - x) / 6 E I, in space + F x / k G A and the twist M x / G I_t; slopes by points off the axis."""
    F, M = 0.5, 0.05
    frame: Any = {"interfaces": ["left", "right"], "damping": 0.9}
    if space:
        scene: Any = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
        body = scene.add(spatial_beam().reduce(4, **frame), "beam", (0.5 * LENGTH, 0.0, 0.0))
        scene.join(lf.Weld(body.point("left"), scene.ground.at(0.0, 0.0, 0.0)))
        scene.load(lf.Force(body.point("right"), (0.0, F, 0.0)))
        scene.load(lf.Torque(body.point("right"), (M, 0.0, 0.0)))
    else:
        scene = lf.Scene(gravity=(0.0, 0.0))
        planar = lf.Beam(LENGTH, SIDE, SIDE, DENSITY, E, elements=7)
        body = scene.add(planar.reduce(4, **frame), "beam")
        scene.join(lf.Weld(body.point("left"), scene.ground.at(0.0, 0.0)))
        scene.load(lf.Force(body.point("right"), (0.0, F)))
    result = lf.simulate(scene, 2.0, lf.MoreauJean(2e-4), record=2.0, progress=False)
    shift = 0.5 * LENGTH if space else 0.0
    for x in (0.05, 0.123, 0.44, 0.6):
        at = (x - shift, 0.0, 0.0) if space else (x, 0.0)
        sheared = F * x / (5.0 / 6.0 * E / 2.6 * SIDE**2) if space else 0.0
        w = F * x**2 * (3.0 * LENGTH - x) / (6.0 * E * SECOND) + sheared
        assert result.point("beam", at)[-1, 1] == pytest.approx(w, rel=2e-4)
        assert np.abs(result.velocity("beam", at)[-1]).max() < 1e-6  # it rests
        off = (x - shift, 0.5 * SIDE, 0.0) if space else (x, 0.49 * SIDE)
        slope = F * x * (2.0 * LENGTH - x) / (2.0 * E * SECOND)
        moved = result.point("beam", off)[-1] - result.point("beam", at)[-1]
        assert moved[0] == pytest.approx(-slope * off[1], rel=1e-3)
        if space:
            assert moved[2] == pytest.approx(off[1] * M * x / (E / 2.6 * 1.5 * SECOND), rel=1e-3)


def test_beside_the_beam_there_is_none() -> None:
    planar, space = swinging(False, False), swinging(True, False)
    for place in ((-0.01, 0.0), (0.61, 0.0), (0.3, 0.0051)):
        for ask in (planar.point, planar.velocity, planar.deflection, planar.at(0.01).point):
            with pytest.raises(ModelError, match="nor within a beam"):
                ask("beam", place)
    with pytest.raises(ModelError, match="nor within a beam"):
        space.deflection("beam", (0.31, 0.0, 0.0))
    assert not planar.deflection("beam", (0.3, 0.0))[0].any()
