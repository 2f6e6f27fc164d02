"""Friction that turns with its slip: Newton's method of a generalised-alpha step converges, however contacts couple."""

from __future__ import annotations

import pytest

import lcpflex as lf

STEEL = {"density": 7850.0, "youngs_modulus": 2.1e11, "poissons_ratio": 0.3}


def stacked(side: float) -> lf.SpatialScene:
    """Two blocks upon each other, which settle: nodes creep aside, and stop one by one."""
    scene = lf.SpatialScene(gravity=(0.0, 0.0, -9.81))
    block = lf.Solid.box((side, side, side), elements=(3, 3, 3), **STEEL)
    low = scene.add(block, name="low", modes=4, position=(0.0, 0.0, 0.5 * side))
    high = scene.add(block, name="high", modes=4, position=(0.0, 0.0, 1.5 * side))
    scene.contact(low.face("bottom"), scene.ground.plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0)), friction=0.3, name="floor")
    scene.contact(high.face("bottom"), low.face("top"), friction=0.3, name="between")
    return scene


@pytest.mark.filterwarnings("ignore:mesh")  # it is coarse
@pytest.mark.parametrize("side", [0.05, 0.5])
def test_passes_converge_where_contacts_push_each_other_aside(side: float) -> None:
    """Direction by direction the passes of a step in four ended with an error of a thousandth."""
    step = 1e-4 * side
    result = lf.simulate(stacked(side), 120 * step, lf.GeneralizedAlpha(step, rho_inf=0.5), progress=False)
    assert not [words for words in result.warnings if "Newton" in words]
