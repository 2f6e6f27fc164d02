"""Restitution on bodies with modes is not the rebound: the run says what it has come to."""

from __future__ import annotations

import re
from typing import Any

import pytest

import lcpflex as lf
from tests.run_warnings import of_the_run

STRIP = lf.Beam(0.5, 0.02, 0.01, density=7800.0, youngs_modulus=2.1e11)
MASS = 7800.0 * 0.5 * 0.02 * 0.01


def falling(modes: int, e: float, size: float = 1.0, at: float = 0.5) -> lf.Scene:
    """A steel strip falls flat on a round support at 1 m/s."""
    scene = lf.Scene(gravity=(0.0, 0.0))
    strip = lf.Beam(0.5 * size, 0.02 * size, 0.01 * size, density=7800.0, youngs_modulus=2.1e11).reduce(modes)
    body = scene.add(strip, position=(-0.5 * size * at, 0.0155 * size), velocity=(0.0, -1.0))
    support = scene.ground.circle((0.0, 0.0), 0.01 * size)
    scene.contact(body.node(0.5 * size * at, -0.005 * size), support, restitution=e, name="support")
    return scene


STEPPERS = [
    pytest.param(lf.MoreauJean(step=1e-6), id="moreau"),
    pytest.param(lf.EventDriven(), id="events"),
    pytest.param(lf.GeneralizedAlpha(step=1e-6), id="alpha"),
]


@pytest.mark.parametrize("stepper", STEPPERS)
@pytest.mark.parametrize(("modes", "share"), [(1, 40.0), (16, 6.9)])
@pytest.mark.parametrize("e", [0.5, 0.8])
def test_a_strip_rebounds_as_its_modes_have_it(loud: Any, stepper: Any, modes: int, share: float, e: float) -> None:
    """Impulses of 1.5 to 1.6 times m v, whatever e is, and the run says that of the one that was taken."""
    result = lf.simulate(falling(modes, e), 0.02, stepper)
    (said,) = of_the_run(result)
    assert f"restitution {e:g} acts on the mass next to it, {share:g} % of what it meets in rigid bodies" in said
    (apparent,) = re.findall(r"rigid bodies with e = ([0-9.]+)", said)
    assert float(apparent) == pytest.approx(result.impulse[-1, 0, 0] / MASS - 1.0, abs=0.006)
    assert 0.5 < float(apparent) < 0.65
    assert result.verdict.word == "Unverified"
    assert "Read its warnings" in result.summary().splitlines()[-1]


@pytest.mark.parametrize("stepper", STEPPERS)
def test_rigid_strips_and_no_restitution_say_nothing(stepper: Any) -> None:
    rigid = lf.simulate(falling(0, 0.8), 0.02, stepper)
    assert rigid.impulse[-1, 0, 0] == pytest.approx(1.8 * MASS)
    assert not of_the_run(rigid)
    assert not of_the_run(lf.simulate(falling(4, 0.0), 0.02, stepper))


def test_other_sizes_and_places_are_told_alike() -> None:
    """A strip of half a millimetre struck beside its middle."""
    result = lf.simulate(falling(4, 0.5, size=1e-3, at=0.4), 2e-5, lf.MoreauJean(step=1e-9, gap_tolerance=1e-12))
    large = lf.simulate(falling(4, 0.5, at=0.4), 2e-2, lf.MoreauJean(step=1e-6))
    shares = [re.findall(r"next to it, ([0-9.]+) %.* e = ([0-9.]+)", of_the_run(r)[-1]) for r in (result, large)]
    assert shares[0] == shares[1] != []


def test_the_end_of_a_bar_loses_its_share() -> None:
    """1 / (2 N + 1) of the energy at a closing."""
    for modes in (1, 2, 7):
        scene = lf.Scene(gravity=(0.0, 0.0))
        bar = lf.Bar(1.0, 1e-4, density=1000.0, youngs_modulus=1e9).reduce(modes)
        body = scene.add(bar, position=(1e-4, 0.0), velocity=(-1.0, 0.0))
        wall = scene.ground.half_plane((0.0, 0.0), (1.0, 0.0))
        scene.contact(body.node(0.0, 0.0), wall, restitution=0.5, name="wall")
        said = of_the_run(lf.simulate(scene, 5e-3, lf.EventDriven()))[0]
        (share,) = re.findall(r"the mass next to it, ([0-9.]+) % of", said)
        assert float(share) == pytest.approx(100.0 / (2 * modes + 1), rel=0.02)


def test_a_contact_that_never_strikes_says_nothing() -> None:
    scene = falling(4, 0.5)
    assert not of_the_run(lf.simulate(scene, 1e-4, lf.MoreauJean(step=1e-6)))


@pytest.mark.parametrize("stepper", STEPPERS)
def test_a_collision_that_is_not_over_has_no_rebound_yet(stepper: Any) -> None:
    """The run ends, or begins, with the impact: what the mass next to it is can be told, and no more."""
    scene = lf.Scene(gravity=(0.0, 0.0))
    body = scene.add(STRIP.reduce(4), position=(-0.25, 0.015), velocity=(0.0, -1.0))
    scene.contact(body.node(0.25, -0.005), scene.ground.circle((0.0, 0.0), 0.01), restitution=0.5)
    (said,) = of_the_run(lf.simulate(scene, 1e-4, stepper))
    assert "the mass next to it, 22 % of" in said
    assert "hardest collision" not in said
    (said,) = of_the_run(lf.simulate(scene, 0.02, stepper))
    assert "hardest collision" in said
