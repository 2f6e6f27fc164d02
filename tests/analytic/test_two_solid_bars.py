"""Two solid bars that meet end to end: by symmetry each does what it does at a wall."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import lcpflex as lf
from tests.analytic.test_solid_bar_on_wall import SIZES, SMOOTH, bar, plateau
from tests.solid_meshes import STEEL

NARROW = 0.999  # width of one over that of the other: their rims lie beside each other by a hundredth of a millimetre


def bar_of(share: float) -> lf.SpatialBody:
    return bar("hexahedron", (20, 2, 2), "Craig-Bampton", (SIZES[0], share * SIZES[1], share * SIZES[2]))


def meeting(shares: tuple[float, float], points: str) -> lf.Result:
    """Bars of these widths at 1 m/s towards each other; the first one to touch by its points if they are equal."""
    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    place = 0.5 * SIZES[0] + 1e-7
    left = scene.add(bar_of(shares[0]), "left", (-place, 0.0, 0.0), velocity=(1.0, 0.0, 0.0))
    turned = Rotation.from_euler("z", 180, degrees=True)
    right = scene.add(bar_of(shares[1]), "right", (place, 0.0, 0.0), turned, velocity=(-1.0, 0.0, 0.0))
    scene.contact(left.face("end"), right.face("end"), points=points, name="hit")
    wave = 2.0 * SIZES[0] * math.sqrt(STEEL["density"] / STEEL["youngs_modulus"])
    return lf.simulate(scene, 1.3 * wave, SMOOTH, record=0.0)


@pytest.mark.parametrize("points", ["areas", "nodes"])
@pytest.mark.parametrize("shares", [(1.0, 1.0), (NARROW, 1.0), (1.0, NARROW)])
def test_bars_that_meet_leave_as_from_a_wall(shares: tuple[float, float], points: str) -> None:
    """To rounding if they are equal, and to twice the difference of their masses if not; nothing turns aside.

    Nodes at the rim of the wider one are beside the narrow one, or just on it by rounding: 1e-5 rad/s at 1 m/s.
    """
    result = meeting(shares, points)
    first, second = result.compiled.model.bodies.dof[:2]
    rebound = np.array([-result.u[-1, first], result.u[-1, second]])
    wall = plateau(bar_of(1.0), SMOOTH, points)[-1]
    masses = np.array(shares) ** 2
    if shares == (1.0, 1.0):
        np.testing.assert_allclose(rebound, wall, rtol=1e-10)
    np.testing.assert_allclose(rebound, wall, rtol=4e-3)
    assert masses @ (rebound * [-1.0, 1.0]) == pytest.approx(masses @ [1.0, -1.0], abs=1e-12)
    aside = [result.u[-1, b + k] for b in (first, second) for k in range(1, 6)]
    assert np.abs(aside).max() < 1e-4
