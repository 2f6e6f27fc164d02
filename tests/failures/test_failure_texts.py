"""What errors and warnings of runs say: contacts by their names, causes that are in the run."""

from __future__ import annotations

from typing import Any

import pytest

import lcpflex as lf
from lcpflex import gallery
from lcpflex.dynamics.impact_laws import Poisson, Stronge
from lcpflex.runs.collected import growth_cause
from lcpflex.runs.simulate import _closed
from tests.scenes import floor_of


def ball(restitution: float, friction: float, modes: bool = False) -> lf.Scene:
    scene = lf.Scene()
    if modes:
        body = lf.Beam(0.5, 0.02, 0.01, density=7800, youngs_modulus=2.1e11).reduce(modes=4)
        thing = scene.add(body, name="strip", position=(0.0, 0.1))
    else:
        thing = scene.add(lf.Disc(0.1, mass=1.0), name="ball", position=(0.0, 0.2))
    plane = floor_of(scene)
    scene.contact(thing.surface(), plane, friction=friction, restitution=restitution, name="stop")
    return scene


@pytest.mark.parametrize(
    ("restitution", "friction", "stepper", "blamed"),
    [
        (0.5, 0.3, lf.MoreauJean(1e-3), "Newton's restitution with friction"),
        (0.5, 0.3, lf.EventDriven(), "Newton's restitution with friction"),
        (0.5, 0.3, lf.EventDriven(impact=Poisson()), "tighter tolerances"),
        (0.5, 0.3, lf.EventDriven(impact=Stronge()), "tighter tolerances"),
        (0.0, 0.3, lf.MoreauJean(1e-3), "a shorter step"),
        (0.5, 0.0, lf.GeneralizedAlpha(1e-3), "a shorter step"),
        (0.0, 0.0, lf.MoreauJean(1e-3, adaptive=lf.AdaptiveStep()), "tighter tolerances"),
        (0.0, 0.0, lf.EventDriven(), "tighter tolerances"),
    ],
)
def test_created_energy_is_blamed_on_what_is_in_the_run(
    restitution: float, friction: float, stepper: Any, blamed: str
) -> None:
    said = growth_cause(stepper, ball(restitution, friction).compiled().system())
    assert blamed in said
    assert ("Newton" in said) == ("Newton" in blamed)


def test_an_error_says_which_contacts_are_closed() -> None:
    """ "contacts none: ... of contacts 'joint1'" contradicted itself."""
    assert _closed(()) == "no contact closed"
    assert _closed(("a",)) == "contact a"
    assert _closed(("a", "b")) == "contacts a, b"
    assert _closed(tuple("abcdefghij")) == "contacts a, b, c, d, e, f, g, h and 2 more"
    bounces = gallery.bouncing_ball(height=1e-6, restitution=0.99999)
    with pytest.raises(lf.StepError, match="no contact closed: the last 1000 events, of contact '") as caught:
        lf.simulate(bounces, 2.0, lf.EventDriven(most_events=100.0))
    assert caught.value.contacts == ()


def test_massless_boundary_names_the_contact_that_it_refuses() -> None:
    with pytest.raises(lf.ModelError, match=r"restitution: contact 'stop' has 0\.5"):
        lf.simulate(ball(0.5, 0.0, modes=True), 1e-3, lf.MasslessBoundary(step=1e-6))
    scene = ball(0.0, 0.0, modes=True)
    rigid = scene.add(lf.Disc(0.1, mass=1.0), position=(3.0, 0.2))
    scene.contact(rigid.surface(), floor_of(scene), name="rigid ball")
    with pytest.raises(lf.ModelError, match="contact 'rigid ball': its bodies have no normal compliance"):
        lf.simulate(scene, 1e-3, lf.MasslessBoundary(step=1e-6))
