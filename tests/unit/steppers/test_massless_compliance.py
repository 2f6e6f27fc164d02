"""Massless boundary with elastic laws of contacts: closed forms of rigid bodies, flexible ones, and what is refused."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from lcpflex import gallery
from lcpflex.force_laws.elastic.cylinder_pair import CylinderPair
from lcpflex.force_laws.elastic.hertz import Hertz
from lcpflex.force_laws.elastic.line_contact import Johnson
from lcpflex.force_laws.elastic.materials import Material
from lcpflex.force_laws.elastic.power_law import PowerLaw
from lcpflex.force_laws.user_law import UserLaw
from lcpflex.gallery.mechanisms.bars import LENGTH, MODULUS
from lcpflex.gallery.mechanisms.stops import sphere_on_rod
from lcpflex.solvers.problem import Lcp, Solution
from lcpflex.steppers.massless_boundary.stepper import MasslessBoundary
from tests.chance import given, settings, st
from tests.rates import assert_rate
from tests.scenes import bar_between_walls, beam_struck_by_disc, disc_on_floor

STEEL = Material(210e9, 0.3)
RADIUS = 0.015
MASS = 4.0 / 3.0 * math.pi * RADIUS**3 * 7780.0
WALL = PowerLaw(3.768446e10)  # steel ball of this radius on a rigid wall
CONTACT_TIME = 7.828287e-5


def massless(law: Any, name: str = "floor", **others: Any) -> MasslessBoundary:
    return MasslessBoundary(compliance={name: law}, **others)


def ball(speed: float = 1.0, gap: float = 0.0, gravity: float = 0.0, friction: float = 0.0) -> lf.Scene:
    """A rigid steel ball above the floor."""
    moving = {"velocity": (0.0, -speed), "gravity": gravity}
    return disc_on_floor(RADIUS + gap, radius=RADIUS, mass=MASS, friction=friction, **moving)


# rigid bodies


def test_ball_on_a_wall() -> None:
    """Hertz: T = 2.943275 delta_max / v; what comes back is what came."""
    result = lf.simulate(ball(), 1.2 * CONTACT_TIME, massless(WALL), record=0.0)
    closed = result.times[result.force[:, 0, 0] > 0.0]
    assert result.contact("floor").peak_force == pytest.approx(5169.114, rel=1e-5)
    assert result.penetration.max() == pytest.approx(2.659720e-5, rel=1e-5)
    assert closed[-1] == pytest.approx(CONTACT_TIME, abs=2.0 * result.times[1])
    assert result.u[-1, 1] == pytest.approx(1.0, rel=1e-5)
    assert result.impulse[-1, 0, 0] == pytest.approx(2.0 * MASS, rel=1e-5)
    assert result.energies.relative_remainder < 1e-4
    assert not result.warnings


def test_energy_at_the_turn_is_in_the_law() -> None:
    result = lf.simulate(ball(), 1.2 * CONTACT_TIME, massless(WALL), record=0.0)
    law = WALL.energy(np.maximum(-result.gap[:, 0], 0.0))
    np.testing.assert_allclose(result.energies.elastic, law, rtol=1e-12, atol=1e-15)
    assert result.energies.elastic.max() == pytest.approx(0.5 * MASS, rel=1e-4)


@pytest.mark.parametrize(
    "law",
    [
        Johnson(CylinderPair.internal(0.0155, RADIUS, 0.01, STEEL)),
        Johnson(CylinderPair.external(RADIUS, 0.1, 0.01, STEEL)),
        PowerLaw(1e7, 1.0),
        PowerLaw(1e19, 3.0),
        Hertz.spheres(RADIUS, 0.05, STEEL),
    ],
    ids=["log, internal", "log, external", "linear", "cubic", "hertz"],
)
def test_every_law_turns_where_it_has_taken_the_energy(law: Any) -> None:
    speed = 0.5
    result = lf.simulate(ball(speed), 1e-3, massless(law, step=2.5e-7), record=2.5e-7)
    deepest = float(law.indentation(result.force.max()))
    assert result.penetration.max() == pytest.approx(deepest, rel=1e-6)
    assert float(law.energy(deepest)) == pytest.approx(0.5 * MASS * speed**2, rel=2e-3)
    assert result.u[-1, 1] == pytest.approx(speed, rel=1e-3)


def test_ball_let_go_at_the_touch() -> None:
    """m g delta = 2/5 K delta^(5/2): it turns at delta = (5 m g / 2 K)^(2/3), under 5/2 of its weight."""
    weight = 9.81 * MASS
    deepest = (2.5 * weight / WALL.constant) ** (2.0 / 3.0)
    result = lf.simulate(ball(0.0, gravity=9.81), 1e-3, massless(WALL), record=0.0)
    assert result.penetration.max() == pytest.approx(deepest, rel=1e-3)
    assert result.contact("floor").peak_force == pytest.approx(2.5 * weight, rel=1e-3)


def test_ball_comes_to_rest_in_its_dent() -> None:
    """delta = (m g / K)^(2/3), with the weight for the force, and 2/5 m g delta stored."""
    law = PowerLaw(1e6)
    scene = ball(0.0, gravity=9.81)
    disc = scene.body("disc")
    scene.load(lf.Spring(disc.point("center"), scene.ground.at(0.0, 1.0), stiffness=0.0, damping=40.0))
    result = lf.simulate(scene, 0.2, massless(law, step=2e-5))
    weight = 9.81 * MASS
    depth = (weight / 1e6) ** (2.0 / 3.0)
    assert result.force[-1, 0, 0] == pytest.approx(weight, rel=1e-6)
    assert -result.gap[-1, 0] == pytest.approx(depth, rel=1e-6)
    assert result.energies.elastic[-1] == pytest.approx(0.4 * weight * depth, rel=1e-6)
    assert result.energies.largest_remainder < 1e-3 * weight * depth


def test_energy_over_many_bounces() -> None:
    """Under gravity on a soft law; the period of flight is many contacts long."""
    result = lf.simulate(ball(0.0, 1e-3, 9.81), 1.0, massless(PowerLaw(1e8), step=2e-6), record=1e-3)
    bounces = 1.0 / (2.0 * math.sqrt(2e-3 / 9.81))
    stored = result.energies.stored
    assert result.impulse[-1, 0, 0] == pytest.approx(MASS * 9.81, rel=2.0 / bounces)
    assert np.abs(stored - stored[0]).max() < 2e-3 * result.energies.scale


# flexible bodies


def rod_law() -> Hertz:
    return Hertz.sphere_on_plane(RADIUS, STEEL, Material(69e9, 0.33))


def test_forces_are_those_of_the_law_to_a_billionth() -> None:
    """With the compliance of static modes in series, whose deformation makes the indentation unknown beforehand."""
    law = rod_law()
    stepper = massless(law, "ball", dynamic_modes=5)
    result = lf.simulate(sphere_on_rod(40), 2.2e-4, stepper, record=0.0)
    force = result.force[:, 0, 0]
    of_law = law.force(np.maximum(-result.gap[:, 0], 0.0))
    assert force.max() > 400.0
    np.testing.assert_allclose(force, of_law, rtol=0, atol=2e-9 * force.max())
    assert result.energies.relative_remainder < 1e-4


def test_sphere_on_rod() -> None:
    """Contact time, peak force and speeds of the reference with the same law."""
    expected = gallery.scenes()["sphere_on_rod"].reference
    result = lf.simulate(sphere_on_rod(), 2.5e-4, massless(rod_law(), "ball"), record=0.0)
    closed = result.times[result.force[:, 0, 0] > 0.0]
    assert closed[-1] - closed[0] == pytest.approx(expected["contact_time"], rel=2e-3)
    assert result.contact("ball").peak_force == pytest.approx(expected["force"], rel=1e-3)
    assert result.u[-1, 203] == pytest.approx(0.3 * expected["ball"], rel=1e-3)


def test_stiff_law_leaves_the_compliance_of_the_body() -> None:
    """As the law stiffens, impulses on the bar at all times approach those without one, by 1/K."""

    def impulse(law: PowerLaw | None) -> np.ndarray:
        scene = gallery.elastic_bar(elements=60, gap=0.1)
        name = scene.compiled().layout.contacts[0]
        given = {} if law is None else {name: law}
        stepper = MasslessBoundary(step=2e-4, dynamic_modes=30, safety=1.0, compliance=given)
        return lf.simulate(scene, 0.9, stepper, record=0.0).impulse[:, 0, 0]

    without = impulse(None)
    stiffness = 1e7 * 4.0 ** np.arange(5)  # that of the static modes is 1e4 N/m
    apart = [np.abs(impulse(PowerLaw(float(K), 1.0)) - without).max() for K in stiffness]
    assert_rate(1.0 / stiffness, apart, 1.0, within=0.1)


def test_one_contact_by_law_beside_one_without() -> None:
    law = PowerLaw(1000.0)
    result = lf.simulate(
        bar_between_walls(40, LENGTH, MODULUS, start=1.0, play=2.0), 10.0, massless(law, "left"), record=0.005
    )
    left, right = result.force[:, :, 0].T
    assert left.max() > 100.0
    assert right.max() > 100.0
    assert np.nanmin(result.gap[:, 0]) < -0.1  # the law gives way
    assert np.nanmin(result.gap[:, 1]) > -1e-9  # the wall does not
    stored = result.energies.stored
    assert np.abs(stored - stored[0]).max() < 0.01 * result.energies.scale


def test_a_slave_over_two_segments_has_one_spring() -> None:
    """At a node of the sagging beam the disc is over two segments, 0.1 mm beside it over one."""
    law = Hertz.sphere_on_plane(0.01, STEEL)
    peaks = [
        lf.simulate(beam_struck_by_disc(0.1, x, name="disc"), 3e-4, massless(law, "disc"), record=0.0)
        .contact("disc")
        .peak_force
        for x in (0.2, 0.2001)
    ]
    assert peaks[0] == pytest.approx(peaks[1], rel=5e-3)


# drivers


@dataclass(frozen=True)
class InPython:
    """Lemke behind a Python call: makes the stepper take its interpreted driver."""

    solver: lf.Lemke

    def solve(self, problem: Lcp, guess: Solution | None = None) -> Solution:
        return self.solver.solve(problem, guess)


def test_compiled_and_interpreted_drivers_agree() -> None:
    stepper = massless(rod_law(), "ball", step=1e-6, dynamic_modes=5)
    compiled = lf.simulate(sphere_on_rod(20), 1e-4, replace(stepper, solver=lf.Lemke()))
    interpreted = lf.simulate(sphere_on_rod(20), 1e-4, replace(stepper, solver=InPython(lf.Lemke())))
    assert compiled.force.max() > 100.0
    for name in ("q", "u", "force", "impulse"):
        scale = 1.0 + np.abs(getattr(compiled, name)).max()
        np.testing.assert_allclose(getattr(interpreted, name), getattr(compiled, name), rtol=0, atol=1e-10 * scale)


@dataclass(frozen=True)
class Wrong:
    """A solver whose forces are too large by a thousandth, and which does not know it."""

    def solve(self, problem: Lcp, guess: Solution | None = None) -> Solution:
        solution = lf.Lemke().solve(problem)
        return replace(solution, z=1.001 * solution.z, residual=0.0)


@pytest.mark.parametrize("substeps", [False, True])
def test_forces_that_do_not_settle_are_told(substeps: bool) -> None:
    loose = {"solver": Wrong(), "solver_tolerance": 5e-3}
    stepper = massless(rod_law(), "ball", step=1e-6, dynamic_modes=5, substeps=substeps, **loose)
    with pytest.raises(lf.StepError, match="do not settle to one part in a billion"):
        lf.simulate(sphere_on_rod(20), 1e-4, stepper)


# steps


@given(
    exponent=st.floats(1.0, 3.0),
    stiffness=st.floats(1e3, 1e8),
    speed=st.floats(1e-3, 3.0),
)
@settings(max_examples=25)
def test_automatic_steps_give_back_the_speed(exponent: float, stiffness: float, speed: float) -> None:
    """Whatever the law and the speed; ``stiffness`` is the force 1 mm deep [N]."""
    law = PowerLaw(stiffness / 1e-3**exponent, exponent)
    deepest = depth_of(law, 0.5 * MASS * speed**2)
    result = lf.simulate(ball(speed, gap=0.1 * deepest), 6.0 * deepest / speed, massless(law), record=1.0)
    assert result.force[-1, 0, 0] == 0.0
    assert result.u[-1, 1] == pytest.approx(speed, rel=2e-3)
    assert result.penetration.max() == pytest.approx(deepest, rel=2e-3)


def depth_of(law: PowerLaw, energy: float) -> float:
    n = law.exponent
    return float(((n + 1.0) * energy / law.constant) ** (1.0 / (n + 1.0)))


def test_steps_are_divided_by_the_stiffness_of_the_law() -> None:
    """A step of half the contact: divided while the law is stiff."""
    result = lf.simulate(ball(), 4e-4, massless(WALL, step=4e-5))
    assert any("divided" in warning for warning in result.warnings)
    assert result.u[-1, 1] == pytest.approx(1.0, rel=0.05)


def test_too_long_a_step_is_refused_with_the_limit() -> None:
    """h = 2/omega for the linear spring, exactly."""
    with pytest.raises(lf.StepError, match="admits") as caught:
        lf.simulate(ball(), 1e-3, massless(PowerLaw(1e9, 1.0), step=1e-4, substeps=False, safety=1.0))
    exact = 2.0 * math.sqrt(MASS / 1e9)
    assert float(str(caught.value).split("admits ")[1].split(" s")[0]) == pytest.approx(exact, rel=1e-5)


# range of validity, and what is refused


def test_leaving_the_range_of_a_law_is_an_error() -> None:
    law = Hertz(RADIUS, 115.38e9, 1e-4)
    with pytest.raises(lf.StepError, match=r"indentation of contact 'floor' is .* valid up to") as caught:
        lf.simulate(ball(), 1e-4, massless(law))
    assert caught.value.result.penetration.max() <= law.limit


def test_leaving_the_range_of_a_lenient_law_is_told() -> None:
    law = Hertz(RADIUS, 115.38e9, 1e-4, lenient=True)
    result = lf.simulate(ball(), 1e-4, massless(law))
    assert any("has reached" in w and "'floor'" in w and "valid" in w for w in result.warnings)


def own_law() -> dict[str, UserLaw]:
    return {"floor": UserLaw(lambda depth, rate, speed, p: 1e6 * depth + rate)}


@pytest.mark.parametrize(
    ("compliance", "match"),
    [
        ({"wall": WALL}, "'wall'.*floor"),
        ({"floor": 1e6}, "1000000.0.*elastic law"),
        ({"floor": PowerLaw}, "elastic law"),
        ({"floor": lf.Penalty(1e6)}, "elastic law"),
        (own_law, "elastic law.*damping"),
        (WALL, "expected a dict"),
        ({}, "no modes.*compliance"),
    ],
    ids=["unknown name", "number", "class", "penalty", "own law", "no dict", "none"],
)
def test_what_is_no_compliance_is_refused(compliance: Any, match: str) -> None:
    with pytest.raises(lf.ModelError, match=match):
        lf.simulate(ball(), 1e-5, MasslessBoundary(compliance=compliance() if callable(compliance) else compliance))


def test_friction_of_rigid_bodies_is_refused() -> None:
    with pytest.raises(lf.ModelError, match=r"no tangential compliance.*along the normal only"):
        lf.simulate(ball(friction=0.3), 1e-5, massless(WALL))


def test_other_contacts_still_need_their_compliance() -> None:
    scene = ball()
    disc = scene.body("disc")
    scene.contact(disc.surface(), scene.ground.half_plane((1.0, 0.0), (-1.0, 0.0)), name="side")
    with pytest.raises(lf.ModelError, match="no modes"):
        lf.simulate(scene, 1e-5, massless(WALL))
