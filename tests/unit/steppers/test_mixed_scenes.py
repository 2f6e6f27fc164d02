"""Scenes with one contact by a continuous force law and another by complementarity."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.errors import ModelError, StepError
from lcpflex.force_laws.contact_law import ContactLaw
from lcpflex.force_laws.damping.dissipative import PermanentIndentation, Tsuji
from lcpflex.force_laws.damping.hysteresis import HysteresisDamping
from lcpflex.force_laws.elastic.hertz import Hertz
from lcpflex.force_laws.elastic.materials import Material
from lcpflex.force_laws.elastic.power_law import PowerLaw
from lcpflex.force_laws.friction.bristles import LuGre
from lcpflex.force_laws.law import Law
from lcpflex.force_laws.penalty import Penalty
from lcpflex.force_laws.user_law import UserLaw
from lcpflex.model.arrays import OPEN
from tests.rates import assert_rate
from tests.scenes import floor_of

HALF = ContactLaw(PowerLaw(2e6), HysteresisDamping(0.5))
SOFT = Penalty(stiffness=1e5, damping=0.2)
RUBBER = ContactLaw(Hertz.sphere_on_plane(0.05, Material(1e8, 0.3)), HysteresisDamping(0.5))
DURATION = 0.03


def landing(law: Law | None = HALF, mu: float = 0.3, slide: float = 1.0) -> lf.Scene:
    """A ball by ``law`` comes down on a plate, which slides on the ground by complementarity with friction."""
    scene = lf.Scene()
    plate = scene.add(lf.Box(0.4, 0.05, mass=8.0), "plate", position=(0.0, 0.025), velocity=(slide, 0.0))
    ball = scene.add(lf.Disc(0.05, mass=2.0), "ball", position=(0.05, 0.11), velocity=(0.2, -1.0))
    scene.contact(plate.surface(), floor_of(scene), friction=mu, name="floor")
    if law is not None:
        scene.contact(ball.surface(), plate.surface(), friction=0.2, name="ball", law=law)
    return scene


def apart(a: lf.Result, b: lf.Result) -> float:
    """Largest difference of the final states."""
    return max(float(np.abs(a.q[-1] - b.q[-1]).max()), float(np.abs(a.u[-1] - b.u[-1]).max()))


@pytest.fixture(scope="module")
def reference() -> lf.Result:
    """The landing, almost exact."""
    return lf.simulate(landing(), DURATION, lf.EventDriven(rtol=1e-11, atol=1e-13), record=2e-5)


def test_event_driven_keeps_its_order(reference):
    tolerances = [1e-6, 1e-7, 1e-8, 1e-9]
    runs = [lf.simulate(landing(), DURATION, lf.EventDriven(rtol=r, atol=0.1 * r)) for r in tolerances]
    errors = [apart(run, reference) for run in runs]
    assert_rate(tolerances, errors, 1.0, within=0.25)
    assert errors[-1] < 1e-6


def test_moreau_jean_is_of_order_one(reference):
    steps = [2e-4, 1e-4, 5e-5, 2.5e-5]
    errors = [apart(lf.simulate(landing(), DURATION, lf.MoreauJean(h)), reference) for h in steps]
    assert_rate(steps, errors, 1.0, within=(0.15, 0.3))


def test_adaptive_moreau_jean_follows_its_tolerance(reference):
    errors = []
    for rtol in (1e-3, 1e-5):
        control = lf.AdaptiveStep(rtol=rtol, atol=0.01 * rtol, shortest=1e-7)
        errors.append(apart(lf.simulate(landing(), DURATION, lf.MoreauJean(1e-4, adaptive=control)), reference))
    assert errors[1] < 0.3 * errors[0]


def test_stiff_penalty_in_the_place_of_complementarity_converges_to_it(reference):
    """Error of the order of 1/K, root mean square over time: the plate gives way by its load over K, and rings."""
    stiffnesses = [1e6, 1e7, 1e8]
    errors = []
    for K in stiffnesses:
        run = lf.simulate(landing(), DURATION, lf.Smooth(laws={"floor": Penalty(K, damping=0.5)}), record=1e-4)
        exact = np.stack([np.interp(run.times, reference.times, q) for q in reference.q.T], axis=1)
        errors.append(float(np.sqrt(np.mean((run.q - exact) ** 2))))
    assert_rate(stiffnesses, errors, -1.0, within=(0.2, 0.1))
    assert errors[-1] < 1e-4


def test_the_audit_is_complete(reference):
    assert reference.energies.relative_remainder < 1e-7
    assert reference.energies.friction[-1] > 0.1
    assert reference.energies.impact[-1] > 0.1
    assert not reference.warnings


@pytest.mark.parametrize(("stepper", "error"), [(lf.EventDriven(), 1e-4), (lf.MoreauJean(2e-5), 1e-3)])
def test_impulses_are_integrals_of_forces_and_records_name_the_contact(stepper, error):
    run = lf.simulate(landing(SOFT), DURATION, stepper, record=2e-5)
    ball = run.contact("ball")
    force = ball.force
    normal, tangential = (float(np.trapezoid(force[:, c], run.times)) for c in range(2))
    assert ball.impulse[-1, 0] == pytest.approx(normal, rel=error)
    assert ball.impulse[-1, 1] == pytest.approx(tangential, rel=4e-3)  # it turns within a millisecond
    touching = run.state[:, 1] != OPEN
    assert touching.sum() > 100
    np.testing.assert_array_equal(touching, run.gap[:, 1] < 0.0)
    assert np.all(force[~touching] == 0.0)
    assert run.penetration.max() < 1e-8  # of the set-valued contact alone
    of_ball = run.contact_points.contact == 1
    assert of_ball.sum() == touching.sum()
    np.testing.assert_allclose(run.contact_points.force[of_ball], force[touching])
    np.testing.assert_allclose(run.contact_points.normal[of_ball][:, 1], 1.0, atol=1e-2)


def test_friction_by_law_does_not_chatter_in_long_steps():
    """2e-5 s are 1.6 times what explicit friction of 80 N over a slip speed of 1 mm/s would bear."""
    run = lf.simulate(landing(SOFT), DURATION, lf.MoreauJean(2e-5), record=2e-5)
    friction = run.contact("ball").force[:, 1]
    pressed = np.flatnonzero(friction)
    held = friction[pressed[len(pressed) // 2] : pressed[-1]]
    assert np.abs(np.diff(held)).max() < 0.05 * np.abs(held).max()


@pytest.mark.parametrize("law", [HALF, RUBBER])
def test_exact_law_gives_its_restitution(law):
    scene = lf.Scene(gravity=(0.0, 0.0))
    ground = floor_of(scene)
    ball = scene.add(lf.Disc(0.05, mass=2.0), "ball", position=(0.0, 0.06), velocity=(0.0, -1.0))
    box = scene.add(lf.Box(0.1, 0.1, mass=1.0), "box", position=(1.0, 0.05), velocity=(0.5, 0.0))
    scene.contact(ball.surface(), ground, name="ball", law=law)
    scene.contact(box.surface(), ground, name="box", friction=0.2)
    result = lf.simulate(scene, 0.1, lf.EventDriven())
    assert result.u[-1, 1] == pytest.approx(0.5, abs=1e-6)
    rough = lf.simulate(scene, 0.1, lf.MoreauJean(1e-5))
    assert rough.u[-1, 1] == pytest.approx(0.5, abs=2e-3)


@pytest.mark.parametrize("stepper", [lf.EventDriven(max_step=1e-3), lf.MoreauJean(1e-4)])
def test_a_contact_that_never_closes_changes_nothing(stepper):
    results = []
    for law in (SOFT, None):
        scene = landing(None)
        far = scene.add(lf.Disc(0.05, mass=2.0), "far", position=(9.0, 5.0))
        if law is not None:
            scene.contact(far.surface(), scene.ground.half_plane((8.0, 0.0), (0.0, 1.0)), name="far", law=law)
        results.append(lf.simulate(scene, DURATION, stepper))
    np.testing.assert_array_equal(results[0].q, results[1].q)
    np.testing.assert_array_equal(results[0].u, results[1].u)
    np.testing.assert_array_equal(results[0].force[:, 0], results[1].force[:, 0])


@pytest.mark.parametrize(("height", "speed"), [(0.5, 10.0), (0.2, 100.0), (0.03, 0.0), (0.03, -2.0)])
def test_no_step_passes_over_a_thin_plate(height, speed):
    """Free flight is exact at any step; a plate is 2 mm thick, and gaps of more than 40 mm are not measured."""
    scene = lf.Scene()
    lower = scene.add(lf.Box(0.2, 2e-3, mass=5.0), "lower", position=(0.0, 1e-3))
    upper = scene.add(lf.Box(0.2, 2e-3, mass=1.0), "upper", position=(0.0, 2e-3 + height), velocity=(0.0, -speed))
    scene.contact(lower.surface(), floor_of(scene), name="floor")
    scene.contact(
        upper.surface(), lower.surface(), name="plate", law=ContactLaw(PowerLaw(1e11), HysteresisDamping(0.5))
    )
    meeting = math.sqrt(speed**2 + 2.0 * 9.81 * (height - 1e-3))
    flight = (meeting - speed) / 9.81
    result = lf.simulate(scene, flight + 0.01, lf.EventDriven())
    assert result.contact("plate").impulse[-1, 0] == pytest.approx(1.5 * meeting, rel=0.02)
    assert result.energies.relative_remainder < 1e-6


@pytest.mark.parametrize("law", [HALF, SOFT])
def test_adaptive_moreau_jean_steps_do_not_end_deep_in_a_contact(law):
    """Its forces are those in the middle of steps: one that ends behind the touch would store energy for nothing."""
    gained = []
    for rtol in (1e-4, 1e-6):
        scene = lf.Scene()
        ball = scene.add(lf.Disc(0.05, mass=2.0), "ball", position=(0.0, 2.05))
        scene.contact(ball.surface(), floor_of(scene), name="ball", law=law)
        control = lf.AdaptiveStep(rtol=rtol, atol=0.01 * rtol)
        result = lf.simulate(scene, 0.8, lf.MoreauJean(1e-3, adaptive=control))
        assert result.contact("ball").impulse[-1, 0] > 10.0
        gained.append(result.energies.relative_remainder)
    assert gained[0] < 1e-2
    assert gained[1] < 0.2 * gained[0]


def swinging(law: Law) -> lf.Scene:
    """A pendulum that strikes a wall by ``law``; its joint shares in the effective mass."""
    scene = lf.Scene()
    rod = scene.add(lf.Box(0.4, 0.04, mass=1.0), "rod", position=(0.2, 0.0))
    scene.join(lf.Revolute(rod.at(-0.2, 0.0), scene.ground.at(0.0, 0.0)))
    stop = scene.ground.half_plane((0.0, -0.1), (0.0, 1.0))
    scene.contact(rod.surface(), stop, friction=0.1, name="stop", law=law)
    return scene


@pytest.mark.parametrize("law", [HALF, ContactLaw(PowerLaw(1e6), Tsuji(0.3)), SOFT])
def test_without_other_contacts_it_is_what_smooth_steps_give(law):
    smooth = lf.simulate(swinging(law), 0.3, lf.Smooth(integrator=lf.ExplicitRungeKutta(rtol=1e-10, atol=1e-12)))
    assert np.abs(smooth.contact("stop").force).max() > 10.0
    mixed = lf.simulate(swinging(law), 0.3, lf.EventDriven(rtol=1e-10, atol=1e-12))
    assert apart(mixed, smooth) < 1e-6
    stepped = lf.simulate(swinging(law), 0.3, lf.MoreauJean(1e-5))
    assert apart(stepped, smooth) < 2e-2


def test_python_loads_run_the_same_steps():
    def loaded(value: object) -> lf.Scene:
        scene = landing()
        scene.load(lf.Force(scene.body("ball").at(0.0, 0.0), value))
        return scene

    for stepper in (lf.EventDriven(rtol=1e-6, atol=1e-7), lf.MoreauJean(2e-4)):
        compiled = lf.simulate(loaded((1.0, 0.0)), 0.02, stepper)
        python = lf.simulate(loaded(lambda t: (1.0, 0.0)), 0.02, stepper)
        assert compiled.contact("ball").impulse[-1, 0] > 0.1
        assert apart(compiled, python) < 1e-12


def test_explicit_force_warns_beyond_its_stability():
    stiff = Penalty(stiffness=1e8)
    result = lf.simulate(landing(stiff), 0.02, lf.MoreauJean(1e-3))
    assert any("the stiffest compliant contact" in warning for warning in result.warnings)
    assert not lf.simulate(landing(stiff), 0.02, lf.MoreauJean(1e-5)).warnings


@pytest.mark.parametrize(("frequency", "unstable"), [(0.7, False), (1.3, True)])
def test_damping_has_its_share_in_the_stability_of_a_step(frequency, unstable):
    """x^2 + 4 xi x <= 4 with x = omega h: damping of xi = 0.69 (e = 0.05) leaves 1.05 of the 2 without."""
    scene = lf.Scene()
    ball = scene.add(lf.Disc(0.05, mass=2.0), "ball", position=(0.0, 0.0501))
    law = ContactLaw(PowerLaw(2.0 * (frequency / 1e-3) ** 2, 1.0), Tsuji(0.05))
    scene.contact(ball.surface(), floor_of(scene), name="ball", law=law)
    result = lf.simulate(scene, 1.0, lf.MoreauJean(1e-3))
    assert any("the stiffest compliant contact" in warning for warning in result.warnings) is unstable
    assert bool(np.abs(result.u[-100:, 1]).max() > 1e-3) is unstable


@pytest.mark.parametrize("stepper", [lf.EventDriven(), lf.MoreauJean(1e-5)])
def test_range_of_validity_is_kept(stepper):
    elastic = replace(Hertz.sphere_on_plane(0.05, Material(1e6, 0.3)), lenient=False)
    with pytest.raises(StepError, match=r"the indentation of contact 'ball' is .* valid up to"):
        lf.simulate(landing(ContactLaw(elastic)), DURATION, stepper)
    lenient = lf.simulate(landing(ContactLaw(replace(elastic, lenient=True))), DURATION, stepper)
    assert sum("up to which its law is valid" in warning for warning in lenient.warnings) == 1


def test_own_law_is_taken():
    own = UserLaw(lambda depth, rate, speed, parameters: 1e5 * depth)
    plain = lf.simulate(landing(Penalty(1e5)), DURATION, lf.EventDriven())
    assert apart(lf.simulate(landing(ContactLaw(own)), DURATION, lf.EventDriven()), plain) < 1e-6


@pytest.mark.parametrize(
    ("law", "reason"),
    [
        (ContactLaw(PowerLaw(1e6), friction=LuGre()), "friction with states of its own"),
        (ContactLaw(PowerLaw(1e6), PermanentIndentation(0.5)), "a permanent indentation"),
    ],
)
def test_laws_with_states_are_refused_beside_complementarity(law, reason):
    for stepper in (lf.EventDriven(), lf.MoreauJean(1e-4)):
        with pytest.raises(ModelError, match=f"'ball' has {reason}.* Smooth takes it"):
            lf.simulate(landing(law), DURATION, stepper)


@pytest.mark.parametrize("stepper", [lf.GeneralizedAlpha(1e-4), lf.MasslessBoundary()])
def test_other_steppers_refuse_laws(stepper):
    with pytest.raises(
        ModelError, match=r"contact 'ball' with a force law, expected EventDriven, MoreauJean or Smooth"
    ):
        lf.simulate(landing(), DURATION, stepper)


def test_smooth_needs_a_law_for_every_contact():
    with pytest.raises(ModelError, match="contact 'floor' has no force law"):
        lf.simulate(landing(), DURATION, lf.Smooth())


def test_stability_limit_of_theta():
    """The limit that is warned of: beyond 2 / (4 theta - 1)^(1/2) the motion grows, below it does not."""
    for theta in (0.5, 0.75, 1.0):
        limit = 2.0 / math.sqrt(4.0 * theta - 1.0)
        for factor, grows in ((0.99, False), (1.02, True)):
            x = (factor * limit) ** 2
            step = np.array([[1.0 - theta * x, 1.0 - theta**2 * x], [-x, 1.0 - theta * x]])
            assert bool(np.abs(np.linalg.eigvals(step)).max() > 1.0 + 1e-9) is grows
