"""Impacts: created energy, Painleve's paradoxes, chatter, impacts at the same time and in the same event."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from lcpflex import gallery
from lcpflex.dynamics.impact_laws import Newton, Poisson, Stronge
from lcpflex.studies.stability_maps.admissible_accelerations import Count, admissible_accelerations
from tests.scenes import floor_of


@pytest.mark.parametrize(
    "stepper", [lf.EventDriven(), lf.MoreauJean(step=1e-6), lf.GeneralizedAlpha(step=1e-6)], ids=repr
)
def test_newtons_restitution_with_friction(stepper: Any, loud: Any) -> None:
    """Kane's double pendulum: + 59 % of energy under Newton's law, in every scheme that uses it."""
    said = loud(gallery.double_pendulum(), 1e-3, stepper)
    assert "created energy" in said
    refused = loud(gallery.double_pendulum(), 1e-3, stepper, energy_growth=lf.EnergyGrowth.ERROR)
    assert "StepError" in refused
    for law, kept in ((Poisson(), 0.5449), (Stronge(), None)):
        result = lf.simulate(gallery.double_pendulum(), 1e-3, lf.EventDriven(impact=law), record=1e-3)
        share = result.energies.kinetic[1] / result.energies.kinetic[0]
        assert share < 1.0
        if kept is not None:
            assert share == pytest.approx(kept, abs=1e-4)
        assert not result.warnings


def test_painleves_paradoxes(loud: Any) -> None:
    """No contact force exists, or two motions: the state says so, and so does the run, which goes on by an impact."""
    assert admissible_accelerations(gallery.painleve_rod(1.4, 60.0, 0.0)).count is Count.NONE
    assert admissible_accelerations(gallery.painleve_rod(1.4, 60.0, 1.2)).count is Count.SEVERAL
    assert "impact without collision" in loud(gallery.painleve_rod(1.4, 60.0, 0.0), 1e-3, lf.EventDriven())
    assert "several" in loud(gallery.painleve_rod(1.4, 60.0, 1.2), 1e-3, lf.EventDriven())
    # after the impact without collision the end sticks or leaves; time stepping, at impulse level anyhow, comes to it
    exact = lf.simulate(gallery.painleve_rod(1.4, 60.0, 0.0), 1e-3, lf.EventDriven(), record=1e-3)
    stepped = lf.simulate(gallery.painleve_rod(1.4, 60.0, 0.0), 1e-3, lf.MoreauJean(step=1e-6), record=1e-3)
    assert stepped.u[-1] == pytest.approx(exact.u[-1], abs=5e-3)
    assert exact.energies.stored[-1] < exact.energies.stored[0]
    assert exact.energies.relative_remainder < 1e-9
    sound = lf.simulate(gallery.painleve_rod(0.5, 60.0, 0.0), 1e-3, lf.EventDriven())
    assert not sound.warnings


def rattling_ball(clearance: float = 1e-6) -> lf.Scene:
    """A ball between floor and ceiling, elastic: at 1 m/s it strikes 1 / (2 ``clearance``) times a second each."""
    scene = lf.Scene(gravity=(0.0, 0.0))
    ball = scene.add(
        lf.Disc(radius=0.1, mass=1.0), name="ball", position=(0.0, 0.1 + 0.5 * clearance), velocity=(0.0, 1.0)
    )
    for name, y, up in (("floor", 0.0, 1.0), ("ceiling", 0.2 + clearance, -1.0)):
        plane = scene.ground.half_plane((0.0, y), (0.0, up))
        scene.contact(ball.surface(), plane, restitution=1.0, name=name)
    return scene


def test_chatter(loud: Any) -> None:
    """Half a million impacts a second: event location gives up, and names the scheme that does not care."""
    said = loud(rattling_ball(), 0.1, lf.EventDriven())
    assert "StepError" in said
    assert "MoreauJean" in said
    for stepper in (lf.MoreauJean(step=1e-3), lf.GeneralizedAlpha(step=1e-3)):
        result = lf.simulate(rattling_ball(), 0.1, stepper)
        assert np.abs(result.q[:, 1] - 0.1).max() < 2e-3
        assert np.abs(result.u[:, 1]).max() <= 1.0 + 1e-9
    fine = lf.simulate(rattling_ball(), 1e-4, lf.MoreauJean(step=1e-8))
    assert np.abs(np.abs(fine.u[:, 1]) - 1.0).max() < 1e-9


def struck_from_both_sides() -> lf.Scene:
    """A ball at rest between two that arrive at 1 m/s at the same time; e = 1/2."""
    scene = lf.Scene(gravity=(0.0, 0.0))
    middle = scene.add(lf.Disc(radius=0.1, mass=1.0), name="middle")
    for name, x in (("left", -0.3), ("right", 0.3)):
        ball = scene.add(lf.Disc(radius=0.1, mass=1.0), name=name, position=(x, 0.0), velocity=(-x / 0.3, 0.0))
        scene.contact(ball.surface(), middle.surface(), restitution=0.5, name=name)
    return scene


def test_simultaneous_impacts(loud: Any) -> None:
    """One after the other, the mirror symmetry of the scene is lost, and the result says so; at once, it is kept."""
    said = loud(struck_from_both_sides(), 0.2, lf.EventDriven(impact=Newton(sequential=True)))
    assert "order of impacts was arbitrary" in said
    for stepper in (lf.EventDriven(), lf.EventDriven(impact=Poisson()), lf.MoreauJean(step=1e-4)):
        result = lf.simulate(struck_from_both_sides(), 0.2, stepper)
        assert result.u[-1, 0::3] == pytest.approx([0.0, -0.5, 0.5], abs=1e-9)
        assert not result.warnings


def coincidence() -> lf.Scene:
    """A block's slip stops at the very time at which a ball beside it strikes the floor."""
    stop = 1.0 / (0.3 * 9.81)
    scene = lf.Scene(gravity=(0.0, -9.81))
    floor = floor_of(scene)
    block = scene.add(lf.Box(width=0.4, height=0.2, mass=1.0), name="block", position=(0.0, 0.1), velocity=(1.0, 0.0))
    scene.contact(block.surface(), floor, friction=0.3, name="under block")
    height = 0.5 * 9.81 * stop**2
    ball = scene.add(lf.Disc(radius=0.1, mass=1.0), name="ball", position=(5.0, 0.1 + height))
    scene.contact(ball.surface(), floor, restitution=0.5, name="under ball")
    return scene


def test_coincident_events(loud: Any) -> None:
    """Both happen. A force law has no restitution to offer at any of them, and says so."""
    stop, rest = 1.0 / (0.3 * 9.81), 0.6 - 1.0 / (0.3 * 9.81)
    assert "restitution" in loud(coincidence(), 0.6, lf.Smooth(lf.Penalty(1e5)))
    bounced = 0.1 + 0.5 * 9.81 * stop * rest - 0.5 * 9.81 * rest**2
    for stepper, error in (
        (lf.EventDriven(), 1e-9),
        (lf.MoreauJean(step=1e-4), 2e-4),
        (lf.GeneralizedAlpha(1e-4), 2e-4),
    ):
        result = lf.simulate(coincidence(), 0.6, stepper)
        assert result.q[-1, 0] == pytest.approx(0.5 * stop, abs=error)
        assert result.q[-1, 4] == pytest.approx(bounced, abs=error)
        assert not result.warnings
