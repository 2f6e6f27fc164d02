"""Painleve's rod: which motions the acceleration level admits, and what the event-driven stepper makes of them."""

from __future__ import annotations

import math

import numpy as np
import pytest

import lcpflex as lf
from lcpflex import gallery
from lcpflex.accelerations import ContactFate, Count, admissible_accelerations


@pytest.mark.parametrize(
    ("mu", "degrees", "spin", "count", "forces"),
    [
        (0.5, 60.0, 0.0, Count.UNIQUE, [0.908694]),
        (1.4, 60.0, 0.0, Count.NONE, []),
        (1.4, 60.0, 1.2, Count.SEVERAL, [0.0, 3.598901]),
        (2.0, 30.0, 0.0, Count.UNIQUE, [1.533922]),
    ],
)
def test_statuses_of_the_rod(mu: float, degrees: float, spin: float, count: Count, forces: list[float]) -> None:
    found = admissible_accelerations(gallery.painleve_rod(mu, degrees, spin))
    assert found.count is count
    assert sorted(s.force[0, 0] for s in found.solutions) == pytest.approx(forces, abs=1e-6)
    for solution in found.solutions:
        expected = ContactFate.SEPARATES if solution.force[0, 0] == 0.0 else ContactFate.SLIDES_BACK
        assert solution.fate == (expected,)
        assert solution.force[0, 1] == pytest.approx(mu * solution.force[0, 0])  # against the slip to the left
        phi = math.radians(degrees)
        normal, tangential = solution.force[0]
        udot = [tangential, normal - 1.0, 3.0 * (math.sin(phi) * tangential - math.cos(phi) * normal)]
        assert solution.acceleration == pytest.approx(udot, abs=1e-12)


def test_both_sides_of_the_exact_boundary() -> None:
    for degrees in (30.0, 63.4349488, 80.0):
        boundary = gallery.painleve_friction(degrees)
        below = admissible_accelerations(gallery.painleve_rod(boundary * (1.0 - 1e-9), degrees))
        above = admissible_accelerations(gallery.painleve_rod(boundary * (1.0 + 1e-9), degrees))
        assert (below.count, above.count) == (Count.UNIQUE, Count.NONE)
    assert gallery.painleve_friction(math.degrees(math.atan(2.0))) == pytest.approx(4.0 / 3.0, abs=1e-14)
    assert min(gallery.painleve_friction(d) for d in np.linspace(1.0, 89.0, 9999)) >= 4.0 / 3.0


def test_redundant_supports_leave_forces_open_but_not_the_motion() -> None:
    scene = lf.Scene(gravity=(0.0, -9.81))
    shape = [(-0.2, -0.1), (0.0, -0.1), (0.2, -0.1), (0.2, 0.1), (-0.2, 0.1)]
    box = scene.add(lf.Polygon(shape, mass=1.0), name="box", position=(0.0, 0.1))
    scene.contact(box.surface(), scene.ground.half_plane((0.0, 0.0), (0.0, 1.0)), name="floor")
    found = admissible_accelerations(scene)
    assert found.count is Count.UNIQUE
    assert not found.forces_unique
    assert found.contacts == ("floor",) * 3
    for solution in found.solutions:
        assert solution.force[:, 0].sum() == pytest.approx(9.81)
        assert solution.acceleration == pytest.approx(np.zeros(3), abs=1e-12)


def test_user_system_and_joints() -> None:
    """A mass on a floor under a push below and above its friction, given by M, h, g, W."""

    def block(push: float) -> lf.UserSystem:
        return lf.UserSystem(
            q=[0.0, 0.0],
            u=[0.0, 0.0],
            mass=2.0 * np.eye(2),
            force=lambda t, q, u: np.array([push, -10.0]),
            gaps=lambda q: q[1:],
            normals=[[0.0], [1.0]],
            tangents=[[1.0], [0.0]],
            friction=0.5,
            names=("floor",),
        )

    held, pushed = (admissible_accelerations(block(push)) for push in (4.0, 7.0))
    assert held.solutions[0].fate == (ContactFate.STICKS,)
    assert held.solutions[0].force == pytest.approx(np.array([[10.0, -4.0]]))
    assert pushed.solutions[0].fate == (ContactFate.SLIDES_FORTH,)
    assert pushed.solutions[0].acceleration == pytest.approx([1.0, 0.0])
    pendulum = gallery.double_pendulum()
    with pytest.raises(lf.ModelError, match=r"approaches at 0\.134202 m/s"):
        admissible_accelerations(pendulum)


def test_what_cannot_be_is_refused() -> None:
    with pytest.raises(lf.ModelError, match="q: "):
        admissible_accelerations(gallery.painleve_rod(), q=[0.0])
    with pytest.raises(lf.ModelError, match="expected at most 16"):
        admissible_accelerations(gallery.stack(boxes=10))
