"""Generalised-alpha after impacts on bodies whose fast modes die within a step."""

from __future__ import annotations

import pytest

import lcpflex as lf

RUBBER = {"density": 1100.0, "youngs_modulus": 2e6, "poissons_ratio": 0.45}


def falling_beam(damping: float) -> lf.Scene:
    """A soft beam falls on the floor, one end first."""
    scene = lf.Scene(gravity=(0.0, -9.81))
    body = lf.Beam(0.5, 0.02, 0.02, 1100.0, 2e6).reduce(modes=8, damping=lf.Rayleigh(0.0, damping))
    beam = scene.add(body, "beam", position=(0.0, 0.05), angle=0.1)
    scene.contact(beam.surface(), scene.ground.half_plane((0.0, 0.0), (0.0, 1.0)), friction=0.3, name="floor")
    return scene


def falling_block(damping: float) -> lf.SpatialScene:
    """A soft block falls on the floor, one edge first."""
    scene = lf.SpatialScene(gravity=(0.0, 0.0, -9.81))
    solid = lf.Solid.box((0.03, 0.024, 0.024), elements=(4, 3, 3), **RUBBER)
    body = solid.reduce(modes=4, contact="bottom", damping=lf.Rayleigh(0.0, damping))
    turned = ((0.995004165278, 0.0, 0.099833416647), (0.0, 1.0, 0.0), (-0.099833416647, 0.0, 0.995004165278))
    block = scene.add(body, name="block", position=(0.0, 0.0, 0.015), orientation=turned)
    floor = scene.ground.plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    scene.contact(block.face("bottom"), floor, friction=0.3, name="floor")
    return scene


@pytest.mark.filterwarnings("ignore::lcpflex.ModelWarning")  # few modes, a coarse mesh
@pytest.mark.parametrize("rho_inf", [0.5, 0.8, 1.0])
def test_energy_only_falls(rho_inf: float) -> None:
    """The first acceleration after an impact threw such modes farther than the impact had: energy without a source.

    h c of the fastest mode is 25 and 1200.
    """
    for damping in (0.02, 1.0):
        stepper = lf.GeneralizedAlpha(1e-3, rho_inf=rho_inf)
        energies = lf.simulate(falling_beam(damping), 0.15, stepper, progress=False).energies
        stored = energies.kinetic + energies.elastic + energies.potential
        assert (stored[1:] - stored[:-1]).max() < 1e-10 * stored[0]
        assert energies.relative_remainder < 1e-3


@pytest.mark.filterwarnings("ignore::lcpflex.ModelWarning")
@pytest.mark.parametrize("rho_inf", [0.5, 0.8])
def test_residual_modes_do_not_throw_a_block(rho_inf: float) -> None:
    """Light modes of nodes that strike, with h c of 1e5: 900 and 60 times its first energy was there before."""
    energies = lf.simulate(
        falling_block(0.002), 0.15, lf.GeneralizedAlpha(1e-3, rho_inf=rho_inf), progress=False
    ).energies
    stored = energies.kinetic + energies.elastic + energies.potential
    assert stored.max() <= stored[0] * (1.0 + 1e-12)


def test_what_is_slow_keeps_its_order() -> None:
    """A hinged beam falls, and bends, beside modes that die within all of these steps: of second order."""

    def bent(step: float) -> float:
        scene = lf.Scene(gravity=(0.0, -9.81))
        body = lf.Beam(0.5, 0.02, 0.02, 1100.0, 2e6).reduce(modes=8, damping=lf.Rayleigh(0.0, 0.1))
        beam = scene.add(body, "beam")
        scene.join(lf.Revolute(beam.point("left"), scene.ground.at(0.0, 0.0)))
        result = lf.simulate(scene, 0.1, lf.GeneralizedAlpha(step), progress=False)
        return float(result.q[-1, 3])

    exact = bent(2.5e-5)
    errors = [abs(bent(step) - exact) for step in (1e-3, 5e-4, 2.5e-4)]
    assert 3.0 < errors[0] / errors[1] < 5.0
    assert 3.0 < errors[1] / errors[2] < 5.0
