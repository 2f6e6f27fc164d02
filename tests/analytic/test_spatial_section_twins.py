"""Section forces of a rod that touches: those of the plane and those of space are the same."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import lcpflex as lf

G = 9.81
LENGTH, AREA, DENSITY, MODULUS = 0.6, 1e-4, 2700.0, 7e10
MOMENT = 1e-15  # second moment of the section [m^4]: without rotary inertia, as in the plane
HALF = 0.5 * LENGTH
SUPPORTS = (-0.24, 0.3)
R, BALL = 0.01, 0.05  # radii of what is on the rod, and of what it falls on [m]
STEPPERS = [lf.MoreauJean(1e-3), lf.GeneralizedAlpha(1e-3), lf.EventDriven()]


def planar_twin(stepper: Any, moment: float = MOMENT, modes: int = 0) -> lf.Result:
    """A thin rod that falls on two discs and slides, in the plane."""
    thickness = np.sqrt(12.0 * moment / AREA)
    scene = lf.Scene(gravity=(0.5, -G))
    rod = lf.Beam(LENGTH, AREA / thickness, thickness, DENSITY, MODULUS, elements=10, axial=False)
    placed = scene.add(
        rod.reduce(modes, damping=0.3), "beam", position=(-HALF, 0.0), velocity=(0.3, -0.4),
        angular_velocity=-1.0,
    )  # fmt: skip
    for k, x in enumerate(SUPPORTS):
        disc = scene.ground.circle((x, -BALL - R - 1e-3), BALL)
        scene.contact(placed.node(x + HALF, 0.0, radius=R), disc, friction=0.3, name=f"contact {k}")
    return lf.simulate(scene, 0.02, stepper, record=1e-3, progress=False)


def twin_in_space(stepper: Any, first: bool, moment: float = MOMENT, modes: int = 0) -> lf.Result:
    """The same in space; it is stiff out of the plane."""
    scene = lf.SpatialScene(gravity=(0.5, -G, 0.0))
    rod = lf.SpatialBeam(
        LENGTH, AREA, (100.0 * moment, moment), 90.0 * moment, DENSITY, MODULUS, poissons_ratio=0.3, shear_factor=None,
        elements=10,
    )  # fmt: skip
    placed = scene.add(
        rod.reduce(modes, damping=0.3), "beam", velocity=(0.3, -0.4 - HALF, 0.0),
        angular_velocity=(0.0, 0.0, -1.0),
    )  # fmt: skip
    for k, x in enumerate(SUPPORTS):
        ball = scene.ground.sphere((x, -BALL - R - 1e-3, 0.0), BALL)
        pair = placed.sphere((x, 0.0, 0.0), R), ball
        scene.contact(*(pair if first else pair[::-1]), friction=0.3, name=f"contact {k}")
    return lf.simulate(scene, 0.02, stepper, record=1e-3, progress=False)


def compare(plane: lf.Result, space: lf.Result, near: float) -> None:
    """N, V and M of both, to a part of the largest contact force; and nothing out of the plane."""
    assert plane.times == pytest.approx(space.times, abs=1e-6)
    x = np.array([-0.3, -0.25, -0.1, 0.1, 0.28])
    flat, found = plane.section("beam", x + HALF), space.section("beam", x)
    scale = plane.force[..., 0].max()
    assert scale > 0.5
    for one, other in ((flat.N, found.N), (flat.V, found.V_y), (flat.M, found.M_z)):
        assert np.abs(one - other).max() < near * scale
    assert np.abs([found.V_z, found.T, found.M_y]).max() < 1e-10 * scale


@pytest.mark.parametrize("first", [True, False], ids=["rod first", "rod second"])
@pytest.mark.parametrize("stepper", STEPPERS, ids=lambda s: type(s).__name__)
def test_the_plane_tells_the_same(stepper: Any, first: bool) -> None:
    """N, V and M of a rod in the plane, and of the same in space: to rounding, or to the order of the steps.

    Frames are at the end of the one and in the middle of the other: fixed steps do not move them alike.
    """
    near = 1e-9 if isinstance(stepper, lf.EventDriven) else 1e-5
    compare(planar_twin(stepper), twin_in_space(stepper, first), near)


def test_a_flexible_rod_has_the_sections_of_the_plane() -> None:
    """With two modes of bending; what is of second order in them, and rotary inertia, is in one of both alone."""
    stepper = lf.EventDriven()
    compare(planar_twin(stepper, 1e-11, 2), twin_in_space(stepper, True, 1e-11, 2), 3e-4)
