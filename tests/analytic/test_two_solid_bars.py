"""Two solid bars that meet end to end: by symmetry each does what it does at a wall."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import lcpflex as lf
from tests.analytic.test_solid_bar_on_wall import SIZES, SMOOTH, bar, plateau
from tests.solid_meshes import STEEL

NARROW = 0.999  # width of one over that of the other: their rims lie beside each other by a hundredth of a millimetre
SHARES = [(1.0, 1.0), (NARROW, 1.0), (1.0, NARROW)]
MASSLESS = lf.MasslessBoundary(step=4e-7)
TURN = Rotation.from_rotvec([0.4, -0.9, 0.3])
HEXAHEDRA, TETRAHEDRA = ("hexahedron", (20, 2, 2)), ("tetra10", (10, 2, 2))


def bar_of(share: float, basis: str = "Craig-Bampton", mesh: Any = HEXAHEDRA) -> lf.SpatialBody:
    return bar(*mesh, basis, (SIZES[0], share * SIZES[1], share * SIZES[2]))


def meeting(bodies: list[lf.SpatialBody], points: str, stepper: Any, turn: Any = TURN) -> tuple[Any, Any]:
    """Velocities afterwards along the common axis and the other ones, of bars at 1 m/s towards each other."""
    scene = lf.SpatialScene(gravity=(0.0, 0.0, 0.0))
    along = turn.apply([1.0, 0.0, 0.0])
    place = (0.5 * SIZES[0] + 1e-7) * along
    turned = Rotation.from_euler("z", 180, degrees=True)
    left = scene.add(bodies[0], "left", -place, turn, velocity=along)
    right = scene.add(bodies[1], "right", place, turn * turned, velocity=-along)
    scene.contact(left.face("end"), right.face("end"), points=points, name="hit")
    wave = 2.0 * SIZES[0] * math.sqrt(STEEL["density"] / STEEL["youngs_modulus"])
    result = lf.simulate(scene, 1.3 * wave, stepper, record=0.0)
    first = result.compiled.model.bodies.dof[:2, None]  # type: ignore[union-attr]
    u = result.u[-1, first + np.arange(6)]
    after = u[:, :3] @ along
    return after, np.concatenate([u[:, :3] - np.outer(after, along), u[:, 3:]])


@pytest.mark.parametrize("points", ["areas", "nodes"])
@pytest.mark.parametrize("shares", SHARES)
@pytest.mark.parametrize(
    ("basis", "stepper"), [("Craig-Bampton", SMOOTH), ("free", MASSLESS), ("normal rows", MASSLESS)]
)
def test_bars_that_meet_leave_as_from_a_wall(
    basis: str, stepper: Any, shares: tuple[float, float], points: str
) -> None:
    """To rounding if they are equal; if not, their relative velocity changes in second order of what they differ by.

    Massless, a flat contact rings: its rebound is not the wave's, but that of the body at a wall. A node at the rim
    of a bar is beside the other one, or on it by rounding: 3e-5 rad/s at 1 m/s, and 2e-5 of the rebound if it rings.
    """
    after, aside = meeting([bar_of(share, basis) for share in shares], points, stepper)
    wall = plateau(bar_of(1.0, basis), stepper, points)[-1]
    masses = np.array(shares) ** 2
    if shares == (1.0, 1.0) and (points == "areas" or stepper is SMOOTH):
        np.testing.assert_allclose(after, [-wall, wall], rtol=1e-10)
    assert after[1] - after[0] == pytest.approx(2.0 * wall, rel=1e-4)
    assert masses @ after == pytest.approx(masses @ [1.0, -1.0], abs=1e-12)
    assert np.abs(aside).max() < 1e-4


@pytest.mark.slow
@pytest.mark.parametrize("points", ["areas", "nodes"])
@pytest.mark.parametrize("shares", SHARES)
def test_bars_of_tetrahedra(shares: tuple[float, float], points: str) -> None:
    """Their faces are cut along other diagonals, and no bar is the mirror image of the other."""
    after, aside = meeting([bar_of(share, mesh=TETRAHEDRA) for share in shares], points, SMOOTH)
    wall = plateau(bar_of(1.0, mesh=TETRAHEDRA), SMOOTH, points)[-1]
    assert after[1] - after[0] == pytest.approx(2.0 * wall, rel=0.01)
    assert np.abs(aside).max() < (1e-3 if points == "areas" else 0.05)
