"""A run to a tolerance: what it chooses, what bears it out, what it refuses."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.errors import ModelError, ToleranceError
from lcpflex.results.run_choice import RunChoice

BEAM = lf.Beam(length=0.5, width=0.02, thickness=0.01, density=7800.0, youngs_modulus=2.1e11, elements=12)

WALLS = (
    ((-1.5, 0.0), (1.0, 0.0)),
    ((1.0, 0.0), (-1.0, 0.0)),
    ((0.0, -0.6), (0.0, 1.0)),
    ((0.0, 1.2), (0.0, -1.0)),
)


def ball(restitution: float = 0.5, **options) -> lf.Scene:
    """A disc that falls on the ground and slides."""
    scene = lf.Scene(gravity=(0.0, -9.81))
    disc = scene.add(lf.Disc(radius=0.1, mass=1.0), "ball", (0.0, 0.3), velocity=(0.5, 0.0))
    ground = scene.ground.half_plane((0.0, 0.0), (0.0, 1.0))
    scene.contact(disc.surface(), ground, restitution=restitution, name="floor", **options)
    return scene


def struck_beam(modes: int = 8) -> lf.Scene:
    """A beam on a hinge that falls on a ball."""
    scene = lf.Scene(gravity=(0.0, -9.81))
    arm = scene.add(BEAM, "arm", (0.0, 0.3), modes=modes)
    scene.join(lf.Revolute(arm.point("left"), scene.ground.at(0.0, 0.3), name="hinge"))
    scene.contact(arm.surface("bottom"), scene.ground.circle((0.4, 0.25), 0.02), friction=0.2, name="stop")
    return scene


def height(result) -> np.ndarray:
    """Of the ball."""
    return result.point("ball", (0.0, 0.0))[:, 1]


def truth(result):
    """How high the ball is: a parabola between impacts at sqrt(2 h / g) and behind."""
    t, g, e, h = result.times, 9.81, 0.5, 0.2
    hit, up = math.sqrt(2.0 * h / g), e * math.sqrt(2.0 * g * h)
    second = hit + 2.0 * up / g
    late = t > second
    found = 0.1 + h - 0.5 * g * t**2
    found = np.where(t > hit, 0.1 + up * (t - hit) - 0.5 * g * (t - hit) ** 2, found)
    return np.where(late, 0.1 + e * up * (t - second) - 0.5 * g * (t - second) ** 2, found)


class TestARun:
    @pytest.fixture(scope="class")
    @classmethod
    def result(cls):
        return lf.simulate(ball(), 0.5, tolerance=0.01, progress=False)

    def test_is_within_what_it_claims(self, result):
        assert result.complete
        claimed = result.choice.claimed
        assert 0.0 < claimed <= 0.01
        assert np.abs(height(result) - truth(result)).max() <= claimed * result.error.extent

    def test_has_its_error(self, result):
        assert result.error.whole
        assert max(result.error.place_share, result.error.turn_share) <= result.choice.claimed * (1.0 + 1e-9)

    def test_says_what_was_tried(self, result):
        choice = result.choice
        chosen = choice.trials[choice.chosen - 1]
        assert chosen.stepper.startswith("EventDriven")
        assert (chosen.steps, chosen.events) == (result.steps, len(result.events))
        assert {one.stepper.partition("(")[0] for one in choice.trials} == {"EventDriven", "GeneralizedAlpha"}
        assert "GeneralizedAlpha" in choice.confirmed
        assert choice.work == sum(one.work for one in choice.trials) > 0.0
        lines = str(choice).splitlines()
        assert len([line for line in lines if line.endswith("returned")]) == 1
        assert any("0.01 asked for" in line for line in lines)

    def test_is_chosen_alike_each_time(self, result):
        again = lf.simulate(ball(), 0.5, tolerance=0.01, progress=False)
        assert again.choice == result.choice
        np.testing.assert_array_equal(again.q, result.q)

    def test_goes_to_a_file_and_back(self, result, tmp_path):
        loaded = lf.Result.load(result.save(tmp_path / "run.npz"))
        assert isinstance(loaded.choice, RunChoice)
        assert str(loaded.choice) == str(result.choice)
        assert loaded.choice.trials == result.choice.trials

    def test_costs_more_where_less_is_allowed(self, result):
        tight = lf.simulate(ball(), 0.5, tolerance=1e-4, progress=False)
        assert tight.choice.claimed <= 1e-4
        assert tight.choice.work > result.choice.work
        assert np.abs(height(tight) - truth(tight)).max() <= tight.choice.claimed * tight.error.extent


class TestWhatIsAskedBeside:
    def test_records_are_kept(self):
        result = lf.simulate(ball(), 0.5, tolerance=0.1, record=0.1, progress=False)
        assert len(np.unique(result.times)) < 30  # six instants, and both sides of events
        assert {0.1, 0.2, 0.5} <= set(np.round(result.times, 9))
        assert result.choice.claimed <= 0.1

    def test_goes_on_from_a_result(self):
        before = lf.simulate(ball(), 0.1, lf.EventDriven(), progress=False)
        result = lf.simulate(ball(), 0.2, tolerance=0.01, initial=before, progress=False)
        np.testing.assert_array_equal(result.q[0], before.q[-1])
        assert any("began" in note for note in result.notes)

    def test_outputs_are_what_the_tolerance_is_of(self):
        result = lf.simulate(
            ball(), 0.5, tolerance=0.01, outputs={"height": height, "end": lambda one: height(one)[-1]}, progress=False
        )
        assert set(result.choice.outputs) == {"height", "end"}
        assert max(result.choice.outputs.values()) <= result.choice.claimed <= 0.01
        off = abs(height(result)[-1] - truth(result)[-1]) / abs(truth(result)[-1])
        assert off <= result.choice.outputs["end"] + 1e-12

    def test_names_of_standard_outputs_are_taken(self):
        result = lf.simulate(ball(), 0.5, tolerance=0.05, outputs="impulses", progress=False)
        assert "impulses" in result.choice.measure

    def test_outputs_that_are_nothing_are_refused(self):
        scene = lf.Scene(gravity=(0.0, -9.81))
        scene.add(lf.Disc(radius=0.1, mass=1.0), "ball", (0.0, 0.3))
        with pytest.raises(ModelError, match="'impulses' are 0 throughout"):
            lf.simulate(scene, 0.1, tolerance=0.05, outputs="impulses", progress=False)

    def test_a_touch_that_one_run_misses_is_no_agreement(self):
        """Steps of a thousandth fly by a stop that is met by 1e-9 of a metre."""
        scene = lf.Scene(gravity=(0.0, 0.0))
        disc = scene.add(lf.Disc(radius=0.1, mass=1.0), "disc", (-0.5, 0.2 - 1e-9), velocity=(1.0, 0.0))
        scene.contact(disc.surface(), scene.ground.circle((0.0, 0.0), 0.1), restitution=1.0)
        with pytest.raises(ToleranceError):
            lf.simulate(scene, 1.0, tolerance=0.01, outputs="impulses", progress=False)

    def test_rest_is_gone_on_from(self):
        scene = ball()
        rest = lf.equilibrium(scene)
        result = lf.simulate(ball(), 0.1, tolerance=0.01, initial=rest, progress=False)
        np.testing.assert_allclose(result.q[-1], rest.q, atol=1e-9)

    def test_a_method_that_is_given_is_kept(self):
        result = lf.simulate(ball(), 0.5, "moreau-jean", tolerance=0.05, progress=False)
        assert result.stepper.startswith("MoreauJean")
        assert np.abs(height(result) - truth(result)).max() <= result.choice.claimed * result.error.extent
        own = lf.simulate(ball(), 0.5, lf.EventDriven(gap_tolerance=1e-9), tolerance=0.05, progress=False)
        assert "gap_tolerance=1e-09" in own.stepper

    @pytest.mark.parametrize(
        ("arguments", "words"),
        [
            ({"tolerance": 0.0}, "tolerance: 0.0 was given"),
            ({"tolerance": 0.7}, "tolerance: 0.7 was given"),
            ({"tolerance": "small"}, "tolerance: 'small' was given"),
            ({"checkpoint": "run.npz"}, "checkpoint: 'run.npz' was given with a tolerance"),
            ({"budget": 5.0}, "budget: 5.0 was given with a tolerance"),
            ({"outputs": "height"}, "outputs: no output 'height'"),
            ({"stepper": lf.Smooth(lf.Penalty(1e5))}, "stepper: Smooth"),
            ({"stepper": lf.MasslessBoundary()}, "stepper: MasslessBoundary"),
            ({"stepper": lf.EventDriven(impact=lf.Poisson())}, "other impact laws"),
            ({"verify": "never"}, "verify: 'never' was given"),
        ],
    )
    def test_other_arguments_are_refused(self, arguments, words):
        with pytest.raises(ModelError) as caught:
            lf.simulate(ball(), 0.5, **{"tolerance": 0.01, "progress": False, **arguments})
        assert words in str(caught.value)

    def test_outputs_without_a_tolerance_are_refused(self):
        with pytest.raises(ModelError, match="without a tolerance"):
            lf.simulate(ball(), 0.5, outputs="motion")


class TestFidelity:
    def test_no_more_modes_than_needed(self):
        result = lf.simulate(struck_beam(8), 0.25, tolerance=0.1, progress=False)
        choice = result.choice
        assert result.error.modes == pytest.approx(choice.modes * result.error.extent)
        assert choice.modes <= choice.claimed <= 0.1
        assert choice.trials[choice.chosen - 1].modes == 4
        assert choice.modes_tried == (2, 4)

    def test_more_where_too_few_were_given(self):
        """A thin beam on a hinge, shaken at its end near its third mode."""
        found = {}
        for tolerance in (0.1, 0.02):
            scene = lf.Scene(gravity=(0.0, 0.0))
            arm = scene.add(replace(BEAM, thickness=0.001), "arm", (0.0, 0.3), modes=1)
            scene.join(lf.Revolute(arm.point("left"), scene.ground.at(0.0, 0.3), name="hinge"))
            scene.load(lf.Force(arm.point("right"), (0.0, lf.Harmonic(5.0, 400.0))))
            choice = lf.simulate(scene, 0.1, tolerance=tolerance, progress=False).choice
            assert 0.0 < choice.modes < choice.claimed <= tolerance
            found[tolerance] = choice.trials[choice.chosen - 1].modes
        assert found == {0.1: 2, 0.02: 4}

    def test_bodies_by_hand_stay_as_they_are(self):
        scene = lf.Scene()
        free = BEAM.reduce(3)
        scene.add(replace(free, reduction=None), "free", (0.0, 0.0), velocity=(1.0, 0.0))
        choice = lf.simulate(scene, 0.01, tolerance=0.01, progress=False).choice
        assert choice.modes is None
        assert any("'free'" in note for note in choice.notes)


class TestTraps:
    def test_a_graze_by_two_micrometres(self):
        """Steps of a two-thousandth of the run are off by half of the turn: event-driven ones are not."""
        scene = lf.Scene(gravity=(0.0, 0.0))
        disc = scene.add(lf.Disc(radius=0.1, mass=1.0), "disc", (-0.5, 0.2 - 2e-6), velocity=(1.0, 0.0))
        scene.contact(disc.surface(), scene.ground.circle((0.0, 0.0), 0.1), restitution=1.0)
        result = lf.simulate(scene, 1.0, tolerance=0.001, progress=False)
        turned = math.pi - 2.0 * math.asin((0.2 - 2e-6) / 0.2)  # the angle by which a sphere turns what passes it
        np.testing.assert_allclose(math.atan2(result.u[-1, 1], result.u[-1, 0]), turned, rtol=1e-6)
        assert result.choice.claimed <= 0.001

    def test_a_pulse_in_a_function_of_state_is_seen_before(self):
        scene = ball()
        body = scene.parts().placed[0]
        scene.load(lf.Force(body.at(0.0, 0.0), (lambda t, state: 1e4 * (0.3 < t < 0.30003), 0.0)))
        with pytest.raises(ToleranceError, match="for a moment only"):
            lf.simulate(scene, 1.0, tolerance=0.01, progress=False)

    def test_chaos_is_refused_with_the_time_up_to_which_runs_agree(self):
        scene = lf.Scene(gravity=(0.0, 0.0))
        discs = [
            scene.add(lf.Disc(radius=0.1, mass=1.0), f"d{k}{j}", (0.3 * k, 0.3 * j)) for k in range(3) for j in range(3)
        ]
        cue = scene.add(lf.Disc(radius=0.1, mass=1.0), "cue", (-1.0, 0.33), velocity=(3.0, 0.0))
        for k, one in enumerate([*discs, cue]):
            for wall, normal in WALLS:
                scene.contact(one.surface(), scene.ground.half_plane(wall, normal), restitution=1.0)
            for other in [*discs, cue][:k]:
                scene.contact(one.surface(), other.surface(), restitution=1.0)
        with pytest.raises(ToleranceError, match="agree within it up to t = ") as caught:
            lf.simulate(scene, 6.0, tolerance=0.01, progress=False)
        assert caught.value.result.choice.trials
        assert not caught.value.result.error.whole
