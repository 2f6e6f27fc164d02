"""What contacts under a force law take, and how far they are indented, under every stepper that takes laws."""

from __future__ import annotations

import numpy as np
import pytest

import lcpflex as lf

STEPPERS = {
    "fixed": lf.MoreauJean(step=2e-5),
    "adaptive": lf.MoreauJean(step=1e-4, adaptive=lf.AdaptiveStep(rtol=1e-5)),
    "event-driven": lf.EventDriven(),
}
FLORES = lf.laws.HysteresisFactor.FLORES
LAWS = {
    "penalty": lf.Penalty(stiffness=1e4, damping=20.0),
    "hysteresis": lf.ContactLaw(
        lf.laws.PowerLaw(1e6, 1.5), lf.laws.HysteresisDamping(0.6, lf.laws.HysteresisFactor.FLORES)
    ),
    "spring": lf.ContactLaw(lf.laws.PowerLaw(2e4, 1.0)),
}


def dropped(in_space, law, mixed=False, friction=0.0):
    """A ball on a law, and another one, beside it, on a rigid floor."""
    if in_space:
        scene = lf.SpatialScene(gravity=(0.0, 0.0, -9.81))
        ball, floor, up = lf.Sphere(0.05, mass=1.0), scene.ground.plane((0, 0, 0), (0, 0, 1)), (0.0, 0.0, 0.06)
    else:
        scene = lf.Scene(gravity=(0.0, -9.81))
        ball, floor, up = lf.Disc(0.05, mass=1.0), scene.ground.half_plane((0, 0), (0, 1)), (0.0, 0.06)
    speed = tuple(0.3 if i == 0 else 0.0 for i in range(len(up)))
    scene.contact(scene.add(ball, position=up, velocity=speed).surface(), floor, law=law, friction=friction, name="law")
    if mixed:
        aside = (1.0, *up[1:])
        scene.contact(scene.add(ball, position=aside).surface(), floor, restitution=0.5, name="rigid")
    return scene


def run(scene, stepper, record=None):
    return lf.simulate(scene, 0.08, stepper, record=record, progress=False)


@pytest.mark.parametrize("in_space", [False, True], ids=["plane", "space"])
@pytest.mark.parametrize("law", LAWS)
def test_losses_and_indentations_are_those_of_the_smooth_run(in_space, law):
    """With friction, which stays friction. Recorded so coarsely that the touch is between two instants."""
    truth = run(dropped(in_space, LAWS[law], friction=0.2), lf.Smooth(), record=1e-4)
    depth, lost = truth.penetration.max(), truth.energies.impact[-1]
    assert depth > 1e-3
    assert (lost > 0.01) == (law != "spring")
    for stepper in STEPPERS.values():
        result = run(dropped(in_space, LAWS[law], friction=0.2), stepper, record=1e-3)
        assert result.energies.impact[-1] == pytest.approx(lost, rel=2e-3, abs=1e-6)
        assert abs(result.energies.damping).max() < 1e-12
        assert result.energies.friction[-1] == pytest.approx(truth.energies.friction[-1], rel=1e-2)
        assert result.penetration.max() == pytest.approx(depth, rel=2e-3)
        assert result.energies.relative_remainder < 1e-3
        assert "largest indentation at" not in result.summary()


@pytest.mark.parametrize("in_space", [False, True], ids=["plane", "space"])
@pytest.mark.parametrize("stepper", STEPPERS)
def test_beside_rigid_contacts_both_losses_are_counted_and_no_indentation_as_penetration(in_space, stepper):
    result = run(dropped(in_space, LAWS["penalty"], mixed=True), STEPPERS[stepper], record=1e-3)
    speed = np.sqrt(2.0 * 9.81 * 0.01)
    alone = run(dropped(in_space, LAWS["penalty"]), lf.EventDriven(), record=1e-3).energies.impact[-1]
    assert result.energies.impact[-1] == pytest.approx(alone + 0.5 * 0.75 * speed**2, rel=1e-2)
    assert result.penetration.max() < 1e-5
    assert "largest indentation at the stored instants 1.98" in result.summary()


def test_pairs_of_a_rule_that_touch_late_leave_the_account_of_losses_as_it_is():
    """Their impulses are put before it in the state of an event-driven run."""

    def scene(many):
        scene = dropped(False, LAWS["penalty"])
        for k in range(many):
            scene.add(lf.Disc(0.02, mass=0.1), position=(2.0 + 0.05 * k, 0.04 + 0.0002 * k))
        scene.contact_all(restitution=0.4)
        return scene

    few, many = (run(scene(n), lf.EventDriven(), record=1e-3).energies for n in (1, 80))
    single = run(scene(0), lf.EventDriven(), record=1e-3).energies.impact[-1]
    assert few.impact[-1] > single + 0.01 * 0.1
    assert many.relative_remainder < 1e-6
    assert few.relative_remainder < 1e-6


def test_dampers_are_no_contacts():
    """Of a spring with a damper, under a ball on a law, each has its own account."""
    results = []
    for stepper in (lf.MoreauJean(step=2e-5), lf.EventDriven(), lf.Smooth()):
        scene = dropped(False, LAWS["penalty"])
        other = scene.add(lf.Disc(0.05, mass=1.0), position=(2.0, 0.5))
        scene.load(lf.Spring(other.at(0, 0), scene.ground.at(2.0, 1.0), 10.0, damping=2.0))
        results.append(run(scene, stepper, record=1e-3).energies)
    for energies in results:
        assert energies.damping[-1] == pytest.approx(results[2].damping[-1], rel=2e-3)
        assert energies.impact[-1] == pytest.approx(results[2].impact[-1], rel=2e-3)
    assert results[2].damping[-1] > 1e-3
