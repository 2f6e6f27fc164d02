"""Reactions of joints beside impacts elsewhere: only joints that an impact reaches lack a force in its step."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from lcpflex import gallery

G = 10.0
MJ, GA = lf.MoreauJean(1e-3), lf.GeneralizedAlpha(1e-3)


def plank(scene: lf.Scene, name: str, x: float, welds: int) -> lf.Body:
    """A plank of 1 kg, its top at y = 0.1, welded to the ground: redundantly by two welds."""
    body = scene.add(lf.Box(width=0.6, height=0.1, mass=1.0), name=name, position=(x, 0.05))
    for k in range(welds):
        place = 0.2 * k
        scene.join(lf.Weld(body.at(place, 0.0), scene.ground.at(x + place, 0.05), name=f"{name} weld {k}"))
    return body


def drop(scene: lf.Scene, onto: lf.Body, x: float, height: float, name: str) -> lf.Body:
    """A box of 1 kg, ``height`` above a plank."""
    box = scene.add(lf.Box(width=0.2, height=0.1, mass=1.0), name=name, position=(x, 0.15 + height))
    scene.contact(onto.surface(), box.surface(), friction=0.5, name=f"{name} contact")
    return box


def planks(welds: int, resting: int) -> lf.Scene:
    """A box falls onto one plank, others rest on a second one, and a pendulum swings."""
    scene = lf.Scene(gravity=(0.0, -G))
    drop(scene, plank(scene, "struck", 0.0, welds), 0.1, 0.01, "falling")
    below = plank(scene, "loaded", 2.0, welds)
    for k in range(resting):
        below = drop(scene, below, 2.0, 0.1 * k, f"resting {k}")
    bob = scene.add(lf.RigidBody(mass=2.0, inertia=0.1), "bob", position=(4.0, -0.5))
    scene.join(lf.Revolute(bob.at(0.0, 0.5), scene.ground.at(4.0, 0.0), name="hinge"))
    return scene


def carried(result: lf.Result, name: str, welds: int) -> Any:
    return sum(result.reaction(f"{name} weld {k}").force[:, 1] for k in range(welds))


@pytest.mark.parametrize("resting", [0, 1, 12], ids=["one contact", "dense", "large"])
@pytest.mark.parametrize("welds", [1, 2])
def test_an_impact_elsewhere_takes_no_force_away(welds: int, resting: int) -> None:
    result = lf.simulate(planks(welds, resting), 0.08, MJ, record=1e-3, progress=False)
    loaded, struck = carried(result, "loaded", welds)[1:], carried(result, "struck", welds)[1:]
    assert loaded == pytest.approx(np.full(80, (1.0 + resting) * G), rel=1e-6)
    assert result.reaction("hinge").force[1:, 1] == pytest.approx(np.full(80, 2.0 * G), rel=1e-9)
    lacking = np.isnan(struck)
    assert 1 <= lacking.sum() <= 3  # it hits the plank after 45 ms, maybe with one corner first
    assert struck[:40] == pytest.approx(np.full(40, G), rel=1e-9)
    assert struck[-5:] == pytest.approx(np.full(5, 2.0 * G), rel=1e-6)
    for k in range(welds):
        reaction = result.reaction(f"struck weld {k}")
        assert (reaction.unique == (welds == 1))[~np.isnan(reaction.force[:, 1])].all()
        assert not result.reaction(f"loaded weld {k}").impulse.any()
    assert not result.reaction("hinge").impulse.any()
    taken = sum(result.reaction(f"struck weld {k}").impulse[-1, 1] for k in range(welds))
    speed = np.sqrt(2.0 * G * 0.01)
    assert taken == pytest.approx(speed + (1.0 + 1.0) * G * lacking.sum() * 1e-3, abs=0.03)


@pytest.mark.parametrize("resting", [0, 1, 12], ids=["one contact", "dense", "large"])
def test_impulses_of_an_impact_are_those_of_its_own_joints(resting: int) -> None:
    """Generalised-alpha: forces of smooth motion everywhere, impulses where something was struck."""
    result = lf.simulate(planks(1, resting), 0.08, GA, record=1e-3, progress=False)
    assert result.reaction("struck weld 0").impulse[-1, 1] == pytest.approx(np.sqrt(2.0 * G * 0.01), abs=0.03)
    assert np.abs(result.reaction("loaded weld 0").impulse).max() < 1e-6
    assert np.abs(result.reaction("hinge").impulse).max() < 1e-6
    assert carried(result, "loaded", 1)[1:] == pytest.approx(np.full(80, (1.0 + resting) * G), rel=1e-6)


def test_an_impact_reaches_joints_through_contacts_that_press() -> None:
    """A box falls onto boxes that rest on the plank: its weld is struck through all of them."""
    scene = lf.Scene(gravity=(0.0, -G))
    below = plank(scene, "struck", 0.0, 1)
    for k in range(3):
        below = drop(scene, below, 0.0, 0.1 * k, f"resting {k}")
    drop(scene, below, 0.0, 0.31, "falling")
    weld = lf.simulate(scene, 0.08, MJ, record=1e-3, progress=False).reaction("struck weld 0")
    lacking = np.isnan(weld.force[1:, 1])
    assert 1 <= lacking.sum() <= 5
    assert weld.impulse[-1, 1] > np.sqrt(2.0 * G * 0.01)
    assert weld.force[1:41, 1] == pytest.approx(np.full(40, 4.0 * G), rel=1e-6)


def test_the_drive_of_a_silo_is_known_while_discs_slide() -> None:
    """Newton's second law of the bottom in each step; contacts that stay closed, and turn, are no impacts."""
    result = lf.simulate(gallery.silo(discs=16, columns=3), 1.7, MJ, record=1e-3, progress=False)
    drive = result.reaction("drive").force[1:, 1]
    own = [k for k, name in enumerate(result.contact_names) if "bottom" in name]
    names = result.compiled.layout.bodies  # type: ignore[union-attr]
    gained = np.diff(result.u[:, 3 * names.index("bottom") + 1]) / 1e-3
    pressed = np.diff(result.impulse[:, own, 0].sum(axis=1)) / 1e-3  # as solved for: walls may share it otherwise
    known = ~np.isnan(drive)
    assert drive[known] == pytest.approx((9.81 + gained + pressed)[known], abs=1e-6)
    sinking = result.times[1:] > 1.5
    assert known[sinking].mean() > 0.7
