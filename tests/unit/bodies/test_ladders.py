"""Fidelity levels lead from the rigid body to the full mesh, all of them the same body."""

from __future__ import annotations

import numpy as np
import pytest

import lcpflex as lf

STEEL = {"density": 7800.0, "youngs_modulus": 2.1e11}
BEAM = lf.Beam(length=0.5, width=0.02, thickness=0.01, elements=10, **STEEL)
BAR = lf.Bar(length=0.5, area=1e-4, elements=12, **STEEL)


@pytest.mark.parametrize(
    ("body", "names"),
    [
        (BEAM.reduce(5), ["rigid", "1 mode", "2 modes", "4 modes", "8 modes", "16 modes", "full mesh"]),
        (BAR.reduce(), ["rigid", "1 mode", "2 modes", "4 modes", "8 modes", "full mesh"]),  # 12 modes
        (BAR.reduce(3, damping=[0.1, 0.2, 0.3]), ["rigid", "1 mode", "2 modes", "3 modes"]),
    ],
)
def test_rungs(body: lf.Body, names: list[str]) -> None:
    levels = body.fidelity_levels()
    assert [level.name for level in levels] == names
    for level in levels:
        made = level.make()
        assert made.modes == level.modes
        assert (made.mass, made.inertia) == (body.mass, body.inertia)
        shared = min(level.modes, body.modes)
        np.testing.assert_allclose(made.stiffness[:shared], body.stiffness[:shared], rtol=1e-9)
        np.testing.assert_allclose(made.damping[:shared], body.damping[:shared], rtol=1e-9)
        assert [one.name for one in made.fidelity_levels()][:3] == names[:3]


def test_the_top_has_all_modes_and_the_damping_that_was_given() -> None:
    top = BEAM.reduce(2, damping=0.05).fidelity_levels()[-1].make()
    assert top.modes == 30
    np.testing.assert_allclose(top.damping, 0.1 * top.frequencies())


def test_a_rigid_body_that_was_made_so_has_no_levels() -> None:
    assert lf.Box(1.0, 1.0, mass=1.0).fidelity_levels is None
