"""Models that a method cannot take, or takes with a word: what is asked beside what would do."""

from __future__ import annotations

import math
import re
from typing import Any

import pytest

import lcpflex as lf
from tests.run_warnings import of_the_run
from tests.scenes import disc_on_floor, floor_of


def falling_disc(gap: float = 0.01, **law: Any) -> lf.Scene:
    """A disc of 1 kg and 0.1 m above a floor."""
    return disc_on_floor(0.1 + gap, **law)


def falling_strip(modes: int = 8, **law: Any) -> lf.Scene:
    """A soft strip falls on a floor with one end."""
    scene = lf.Scene()
    strip = lf.Beam(0.5, 0.02, 0.01, density=1000.0, youngs_modulus=1e7, elements=8).reduce(modes=modes, damping=0.01)
    body = scene.add(strip, name="strip", angle=0.2, position=(0.0, 0.007))
    scene.contact(body.surface(), floor_of(scene), name="floor", **law)
    return scene


@pytest.mark.parametrize("stiffness", [1e5, 1e9])
def test_steps_too_long_for_a_law_under_moreau_jean(stiffness: float, loud: Any) -> None:
    """Explicit force of a compliant contact: the limit and the step over it are told; one within it is silent."""
    limit = 2.0 / math.sqrt(stiffness)
    scene = lf.Scene(gravity=(0.0, -1e-3 * stiffness))  # a millimetre deep at rest
    disc = scene.add(lf.Disc(0.1, mass=1.0), position=(0.0, 0.1 + 1e-4))
    law = lf.ContactLaw(lf.laws.PowerLaw(stiffness, 1.0), lf.laws.KelvinVoigt(restitution=0.5))
    scene.contact(disc.surface(), floor_of(scene), law=law)
    said = loud(scene, 60.0 * limit, lf.MoreauJean(step=1.5 * limit))
    product = re.search(r"the stiffest compliant contact has frequency times step = ([\d.]+) > 2", said)
    assert product is not None, said
    assert float(product[1]) > 3.0  # that of the spring alone: the damper adds to it
    sound = lf.simulate(scene, 60.0 * limit, lf.MoreauJean(step=0.02 * limit))
    assert not sound.warnings
    assert sound.q[-1, 1] == pytest.approx(0.1 - 1e-3, abs=2e-5)


@pytest.mark.parametrize("size", [1e-2, 1.0])
def test_a_law_beyond_its_range(size: float, loud: Any) -> None:
    """A rubber ball valid up to an indentation ends the run there, with contact, indentation and range."""
    law = lf.ContactLaw(lf.laws.Hertz.sphere_on_plane(0.05 * size, lf.laws.Material(1e6, 0.3)))
    mass = 1e3 * size**3

    def thrown(speed: float) -> lf.Scene:
        scene = lf.Scene(gravity=(0.0, 0.0))
        ball = scene.add(lf.Disc(0.05 * size, mass=mass), position=(0.0, 0.0501 * size), velocity=(0.0, -speed))
        scene.contact(ball.surface(), floor_of(scene), name="bumper", law=law)
        return scene

    said = loud(thrown(3.0), 0.1 * size, lf.Smooth(law))
    assert "StepError" in said
    assert "indentation of contact 'bumper'" in said
    assert f"valid up to {law.elastic.limit:.4g} m" in said
    sound = lf.simulate(thrown(0.01), 1.5 * size, lf.Smooth(law))
    assert not sound.warnings
    assert sound.u[-1, 1] == pytest.approx(0.01, rel=1e-3)


def test_restitution_under_a_force_law(loud: Any) -> None:
    """A coefficient that nothing uses is named; without one there is nothing to say."""
    said = loud(falling_disc(restitution=0.5), 0.06, lf.Smooth(lf.Penalty(1e4)))
    assert "the restitution of contacts floor is not used" in said
    assert not lf.simulate(falling_disc(), 0.06, lf.Smooth(lf.Penalty(1e4))).warnings
    event = lf.simulate(falling_disc(restitution=0.5), 0.06, lf.EventDriven())
    assert not event.warnings
    assert event.u[:, 1].max() == pytest.approx(0.5 * math.sqrt(2.0 * 9.81 * 0.01), rel=1e-6)


def test_massless_boundaries_reflect_nothing(loud: Any) -> None:
    """A coefficient of restitution is refused, and other steppers named; without one the strip bounces by itself."""
    said = loud(falling_strip(restitution=0.5), 0.02, lf.MasslessBoundary())
    assert "ModelError" in said
    assert "restitution" in said
    assert "MoreauJean or EventDriven" in said
    result = lf.simulate(falling_strip(), 0.05, lf.MasslessBoundary(step=1e-4))
    assert not of_the_run(result)
    assert result.impulse[-1, 0, 0] > 0.0


def test_a_massless_boundary_without_compliance(loud: Any) -> None:
    """Two rigid bodies have nothing that could give way; an elastic law of the contact has."""
    said = loud(falling_disc(gap=1e-3), 0.03, lf.MasslessBoundary(step=1e-4))
    assert "compliance" in said
    law = lf.laws.PowerLaw(1e5, 1.0)
    result = lf.simulate(falling_disc(gap=1e-3), 0.03, lf.MasslessBoundary(compliance={"floor": law}))
    assert result.complete
    assert result.impulse[-1, 0, 0] > 0.0


def test_energy_in_modes_that_are_static(loud: Any) -> None:
    """A strip that rings in its second mode, of which one is kept dynamic: what is lost is told in joules."""
    scene = lf.Scene(gravity=(0.0, 0.0))
    strip = lf.Beam(0.5, 0.02, 0.01, density=1000.0, youngs_modulus=1e7, elements=8).reduce(modes=10)
    body = scene.add(strip, position=(0.0, 0.1), modal_velocity=[0.0, 0.1] + [0.0] * 8)
    scene.contact(body.surface(), floor_of(scene), name="floor")
    said = loud(scene, 0.01, lf.MasslessBoundary(step=1e-4, dynamic_modes=1))
    assert "0.005 J of the initial 0.005 J" in said
    assert "keep more dynamic modes" in said
    assert not of_the_run(lf.simulate(scene, 0.01, lf.MasslessBoundary(step=1e-4, dynamic_modes=3)))


def test_contacts_by_law_under_generalised_alpha(loud: Any) -> None:
    """Refused, with the steppers that take them; complementarity it takes."""
    said = loud(falling_disc(law=lf.Penalty(1e4)), 0.01, lf.GeneralizedAlpha(step=1e-3))
    assert "ModelError" in said
    assert "'floor'" in said
    assert "EventDriven, MoreauJean or Smooth" in said
    assert not lf.simulate(falling_disc(), 0.01, lf.GeneralizedAlpha(step=1e-3)).warnings


@pytest.mark.parametrize("unit", [1.0, 1e3], ids=["metres", "millimetres"])
def test_bodies_that_do_not_meet_their_joint(unit: float, loud: Any) -> None:
    """A start that violates a joint is refused with the violation; projected, or put right, it runs."""

    def pendulum(off: float) -> lf.Scene:
        scene = lf.Scene(gravity=(0.0, -9.81 * unit))
        bar = scene.add(lf.Box(1.0 * unit, 0.1 * unit, mass=1.0), position=((0.5 + off) * unit, 0.0))
        scene.join(lf.Revolute(bar.at(-0.5 * unit, 0.0), scene.ground.at(0.0, 0.0), name="hinge"))
        return scene

    said = loud(pendulum(0.01), 0.1, lf.MoreauJean(step=1e-3))
    assert "ModelError" in said
    assert "hinge" in said
    assert not lf.simulate(pendulum(0.0), 0.1, lf.MoreauJean(step=1e-3)).warnings
    projected = lf.simulate(pendulum(0.01), 0.1, lf.MoreauJean(step=1e-3), project=True)
    assert not projected.warnings
    assert projected.joint_drift.max() < 1e-4 * unit


def test_a_function_that_returns_no_number(loud: Any) -> None:
    """NaN of a user's function ends the run at its time, as what it is; a finite function does not."""

    def pushed(late: float) -> lf.Scene:
        scene = lf.Scene(gravity=(0.0, 0.0))
        disc = scene.add(lf.Disc(0.1, mass=1.0))
        scene.load(lf.Force(disc.point("center"), lambda t: (1.0 if t < 0.02 else late, 0.0)))
        return scene

    said = loud(pushed(math.nan), 0.04, lf.MoreauJean(step=1e-3))
    assert "StepError: at t = 0.02 s, after 20 steps" in said
    assert "returned (nan, 0.0) at t = 0.0205 s, expected 2 finite numbers" in said
    result = lf.simulate(pushed(2.0), 0.04, lf.MoreauJean(step=1e-3))
    assert result.u[-1, 0] == pytest.approx(0.06, rel=1e-9)


def test_laws_of_impact_that_do_not_go_together(loud: Any) -> None:
    """Poisson's law knows no tangential restitution; Newton's does."""
    scene = falling_disc(tangential_restitution=0.5, friction=0.3)
    said = loud(scene, 0.06, lf.EventDriven(impact=lf.Poisson()))
    assert "ModelError" in said
    assert "Newton()" in said
    assert not lf.simulate(scene, 0.06, lf.EventDriven()).warnings


def test_steps_that_cannot_be_controlled(loud: Any) -> None:
    """Tolerances that the shortest step cannot meet: most steps were not controlled, and the result says so."""
    scene = lf.Scene()
    bob = scene.add(lf.RigidBody(mass=1.0, inertia=0.1), position=(1.0, 0.0))
    scene.join(lf.Distance(bob.point("center"), scene.ground.at(0.0, 0.0)))
    strict = lf.AdaptiveStep(rtol=1e-12, atol=1e-14, shortest=1e-3)
    assert "as short as allowed, 0.001 s" in loud(scene, 0.3, lf.MoreauJean(step=1e-3, adaptive=strict))
    mild = lf.AdaptiveStep(rtol=1e-5, atol=1e-7)
    assert not lf.simulate(scene, 0.3, lf.MoreauJean(step=1e-3, adaptive=mild)).warnings
