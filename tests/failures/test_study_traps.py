"""Scenes on which a study must not promise: what it says of them, word by word, and sound ones that keep their promise.

Each trap once made a study call wrong runs sound, or a choice of bodies good enough.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

import lcpflex as lf
from lcpflex import gallery
from lcpflex.force_laws.penalty import Penalty
from lcpflex.scene.scene import Scene
from lcpflex.steppers.smooth.stepper import Smooth, Verlet
from lcpflex.studies import Outcome, right_size, stability
from lcpflex.studies.model_order import search as fidelity_search
from lcpflex.studies.model_order.report import RightSize
from lcpflex.studies.model_order.scenes import comparable, of_scene
from lcpflex.studies.model_order.search import Search
from lcpflex.studies.model_order.verdict import contradictions
from tests.scenes import disc_on_spring, floor_of, shot_at_thin_wall
from tests.unit.studies.fidelity_scenes import sled


def moreau(step: float = 1e-3) -> lf.MoreauJean:
    return lf.MoreauJean(step=step)


def promised(found, method: str = "m") -> np.ndarray:
    return np.array([cell.success for cell in found.of(method).ravel()])


def untroubled(found, method: str = "m") -> np.ndarray:
    return promised(found, method) | (found.of(method).ravel() == Outcome.NO_TROUBLE)


# ---------------------------------------------------------------- stability: scenes that are run wrongly


def plate(speed: float = 100.0) -> Scene:
    """A disc flies at a plate that is thinner than its way in a step."""
    return shot_at_thin_wall(speed, start=-0.5)


@pytest.mark.parametrize("truth", [None, True])
def test_a_disc_that_flies_through_a_plate_is_never_sound(truth: bool | None) -> None:
    steps = [2e-4, 3.1e-4, 1e-3, 2.3e-3]
    found = stability(plate, {"m": moreau}, {"step": steps}, duration=0.01, truth=truth, progress=False)
    through = [
        lf.simulate(plate(), 0.01, moreau(step), progress=False).point("disc", "center")[-1, 0] > 0.01 for step in steps
    ]
    assert any(through)
    assert not untroubled(found)[through].any()
    assert "sound for step everywhere" not in str(found)


def pulsed() -> Scene:
    """A box on ice, pushed by up to 1 kN for 2 ms, as a function that tells nothing of itself."""

    def pulse(t: float) -> float:
        return 1e3 * max(0.0, 1.0 - abs(t - 0.051) / 1e-3)

    scene = Scene()
    box = scene.add(lf.Box(0.4, 0.2, mass=1.0), name="box", position=(0.0, 0.1))
    scene.contact(box.surface(), floor_of(scene), friction=0.0)
    scene.load(lf.Force(box.point("center"), (pulse, 0.0)))
    return scene


@pytest.mark.slow
def test_a_load_that_is_stepped_over_is_never_sound() -> None:
    steps = [5e-5, 7e-3, 4.9e-2]
    found = stability(
        pulsed, {"m": moreau}, {"step": steps}, duration=0.1, truth=lf.MoreauJean(step=2.5e-5), progress=False
    )
    moved = [lf.simulate(pulsed(), 0.1, moreau(step), progress=False).q[-1, 0] for step in steps]
    wrong = np.abs(np.array(moved) / 0.049 - 1.0) > 0.02
    assert wrong.any()
    assert not promised(found)[wrong].any()
    assert found.of("m")[0] is Outcome.SOUND


def test_a_step_too_long_is_wrong_beside_a_truth_and_at_best_unsuspected_without() -> None:
    axes = {"step": [1e-4, 0.09]}
    alone = stability(gallery.oblique_bounce, {"m": moreau}, axes, duration=0.5, progress=False)
    assert not promised(alone).any()
    assert "sound" not in str(alone).split("Note: no truth was taken")[0].replace("no sign", "")
    beside = stability(gallery.oblique_bounce, {"m": moreau}, axes, duration=0.5, truth=True, progress=False)
    assert promised(beside).tolist() == [True, False]
    assert beside.errors[0, 0] < 0.01 < beside.errors[0, 1]
    assert "Note: sound is an error below 1 %, relative to EventDriven(" in str(beside)


def test_vibrations_of_two_steps_a_period_are_not_sound() -> None:
    """The energy of the leapfrog scheme is kept below h = 2/omega; its frequency is far off."""

    def oscillator(stiffness: float = 1e4) -> Scene:
        return disc_on_spring(stiffness)

    found = stability(
        oscillator, {"m": moreau}, {"step": [2e-5, 5e-3, 1.5e-2]}, duration=1.0, truth=True, progress=False
    )
    assert promised(found).tolist() == [True, False, False]


def held(friction: float) -> Scene:
    """A block on a slope of 30 degrees: it sticks above mu = 0.577."""
    angle = math.radians(30.0)
    normal = (-math.sin(angle), math.cos(angle))
    scene = Scene()
    block = scene.add(
        lf.Box(0.2, 0.1, mass=1.0), name="block", position=(0.05 * normal[0], 0.05 * normal[1]), angle=angle
    )
    scene.contact(block.surface(), scene.ground.half_plane((0.0, 0.0), normal), friction=friction)
    return scene


def test_a_penalty_that_creeps_down_a_slope_is_not_sound() -> None:
    """Regularised friction holds nothing: the block moves for ever, and its energies balance."""
    creeping = Smooth(Penalty(stiffness=1e6, damping=1.0, slip_speed=0.05), integrator=Verlet(1e-5))
    methods = {"penalty": creeping, "m": moreau}
    found = stability(
        held, methods, {"friction": [0.6]}, duration=0.5, truth=True, outputs={"slid": slid}, progress=False
    )
    assert not promised(found, "penalty").any()


def slid(result: lf.Result) -> float:
    return float(np.hypot(*(result.q[-1, :2] - result.q[0, :2])))


def test_the_wrong_regime_of_friction_is_not_sound() -> None:
    """Seen with too little friction, a block slides where it should stick: no check of the run can know."""

    def slippery(friction: float) -> lf.Result:
        return lf.simulate(held(0.9 * friction), 0.5, lf.MoreauJean(step=1e-3), progress=False)

    axes = {"friction": [0.3, 0.6]}
    found = stability(held, {"m": slippery}, axes, duration=0.5, truth=True, progress=False)
    assert not promised(found).any()
    right = stability(held, {"m": moreau}, {"friction": [0.3]}, duration=0.5, truth=True, progress=False)
    assert promised(right).all()


def test_a_paradox_that_is_named_and_resolved_is_a_success_and_silence_is_none() -> None:
    methods = {"event-driven": lf.EventDriven(), "Moreau-Jean": lf.MoreauJean(step=1e-4)}
    axes = {"friction": [0.5, 1.4]}
    alone = stability(gallery.painleve_rod, methods, axes, duration=0.05, progress=False)
    assert alone.of("event-driven")[1] is Outcome.RESOLVED
    assert "an impact without collision" in alone.messages[0, 1]
    assert alone.of("Moreau-Jean")[1] is Outcome.NO_TROUBLE
    beside = stability(gallery.painleve_rod, methods, axes, duration=0.05, truth=True, progress=False)
    assert beside.of("event-driven").tolist() == [Outcome.SOUND, Outcome.RESOLVED]
    assert beside.of("Moreau-Jean").tolist() == [Outcome.SOUND, Outcome.SOUND]  # resolves the same in silence


def billiard(offset: float = 0.013) -> Scene:
    """A ball among round posts, elastic: after some bounces nothing is left of what was known."""
    scene = Scene(gravity=(0.0, 0.0))
    ball = scene.add(lf.Disc(0.05, mass=1.0), position=(0.0, offset), velocity=(3.0, 0.1))
    for k in range(3):
        at = 2.0 * math.pi * k / 3
        post = scene.ground.circle((0.4 * math.cos(at), 0.4 * math.sin(at)), 0.3)
        scene.contact(ball.surface(), post, restitution=1.0)
    return scene


def test_chaos_has_no_truth() -> None:
    found = stability(
        billiard, {"m": moreau}, {"step": [1e-4, 1e-5]}, duration=1.0, truth=True, truth_limit=0.5, progress=False
    )
    assert not promised(found).any()
    assert "nothing is called sound: there is no truth: " in str(found)
    assert "the nearest two, differ by" in str(found)


@pytest.mark.slow
def test_impacts_that_create_energy_are_no_truth() -> None:
    """Kane's pendulum by Newton's law: two methods agree on what cannot be."""
    axes = {"restitution": [0.5]}
    found = stability(gallery.double_pendulum, {"m": lf.EventDriven()}, axes, duration=1e-3, truth=True, progress=False)
    assert not untroubled(found).any()


def test_an_output_that_is_zero_has_no_truth() -> None:
    outputs = {"sideways": lambda result: 0.0 * float(result.q[-1, 0])}
    case = gallery.scenes()["three_balls"]
    found = stability(
        case.build, {"m": moreau}, {"step": [1e-3, 1e-2]}, duration=0.1, truth=True, outputs=outputs, progress=False
    )
    assert not promised(found).any()
    assert "'sideways' is zero, and no error can be relative to that" in str(found)


def test_a_run_that_ends_before_the_impact_says_nothing_about_contact() -> None:
    found = stability(gallery.bouncing_ball, {"m": moreau}, {"step": [1e-3]}, duration=0.05, truth=True, progress=False)
    assert "nothing touched in any run: this says nothing about contact" in str(found)


def test_a_truth_of_ones_own_is_confirmed_or_none() -> None:
    axes = {"step": [1e-4]}
    loose = stability(
        gallery.oblique_bounce, {"m": moreau}, axes, duration=0.5, truth=lf.MoreauJean(step=0.09), progress=False
    )
    assert not promised(loose).any()
    assert "there is no truth: MoreauJean(step=0.045) and MoreauJean(step=0.09), the nearest two, differ by" in str(
        loose
    )
    tight = stability(
        gallery.oblique_bounce, {"m": moreau}, axes, duration=0.5, truth=lf.MoreauJean(step=1e-5), progress=False
    )
    assert promised(tight).all()


def test_outputs_that_fail_and_methods_that_are_none_are_said() -> None:
    def broken(result: lf.Result) -> float:
        return float(result.q[-1, 99])

    axes, case = {"step": [1e-3]}, gallery.oblique_bounce
    found = stability(case, {"m": moreau}, axes, duration=0.1, truth=True, outputs=broken, progress=False)
    assert not promised(found).any()
    assert "IndexError" in str(found)
    none = stability(case, {"m": moreau}, axes, duration=0.1, truth=lambda: Outcome.SOUND, progress=False)
    assert not promised(none).any()
    assert "truth: returned" in str(none)

    def other(step: float) -> lf.Result:
        return lf.simulate(plate(), 0.01, lf.MoreauJean(step=1e-5), progress=False)

    strange = stability(gallery.three_balls, {"m": other}, axes, duration=0.1, truth=True, progress=False)
    assert strange.of("m").tolist() == [Outcome.REFUSED]
    assert "cannot be compared with the truth" in strange.messages[0, 0]


# ---------------------------------------------------------------- right_size


def wall() -> Scene:
    return gallery.elastic_bar(elements=8)


def sized(outputs=None, tolerance: float = 0.05, step: float = 1e-3, duration: float = 1.5, **more) -> RightSize:
    return right_size(
        more.pop("scene", wall), outputs, tolerance, duration=duration, stepper=lf.MoreauJean(step=step),
        progress=False, **more,
    )  # fmt: skip


@pytest.fixture(scope="module", autouse=True)
def by_counts() -> Iterator[None]:
    """What a run costs is told by its coordinates, however busy the machine is."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(fidelity_search, "SHORT", math.inf)
        yield


@pytest.fixture(scope="module")
def good() -> RightSize:
    return sized()


def test_a_sound_choice_keeps_its_promise(good: RightSize) -> None:
    assert good.within
    assert good.step_error <= 0.05
    assert good.reference_step_error <= 0.05
    assert not good.unmeasured
    assert "of the full mesh" in good.sentence()
    assert "Nothing is promised" not in str(good)


@pytest.mark.parametrize(("step", "tolerance"), [(0.03, 0.02), (2e-3, 1e-4)])
def test_no_level_is_promised_where_the_step_decides(step: float, tolerance: float) -> None:
    found = sized(tolerance=tolerance, step=step)
    assert not found.within
    assert max(found.step_error, found.reference_step_error) > tolerance or not found.proved
    assert "is needed" not in found.sentence()
    if found.proved:
        assert found.sentence().startswith("Nothing is promised: the steps leave an error of ")
        assert "at this tolerance they decide more than the bodies do" in found.sentence()


def test_the_steps_of_what_is_compared_with_count_as_well(good: RightSize) -> None:
    """A few modes may not care for the step where the full mesh does."""
    moved = replace(good, reference_step_error=0.087)
    assert not moved.within
    assert "the steps leave an error of 8.7 % with full mesh for the bar, by reruns" in moved.sentence()


def test_steps_of_an_unknown_error_are_said(good: RightSize) -> None:
    missing = "the error of the steps is not known with bar: full mesh (about 80 s, limit 60 s)"
    unknown = replace(good, reference_step_error=math.nan, unmeasured=missing)
    assert f"But {missing}: that error adds to this." in unknown.sentence()
    assert "The error of the steps is not known with bar: full mesh" in unknown.table()


def test_a_run_that_ends_before_the_impact_promises_no_impulse() -> None:
    found = sized(duration=0.2)  # the bar needs half a second to the wall
    assert not found.within
    assert "impulses: zero in every run, of which nothing can be said" in found.sentence()
    assert sized("motion", duration=0.2).within  # of that it can be said


def test_an_output_that_is_zero_promises_nothing() -> None:
    found = sized({"sideways": lambda result: 0.0})
    assert not found.within
    assert found.sentence().startswith("Nothing can be said: sideways: zero in every run")


def test_vibrations_shorter_than_two_steps_promise_nothing() -> None:
    """A sled of steel that slides to rest: a period of .9 ms, steps of a millisecond, and half of them agrees."""
    found = right_size(sled, "motion", 0.05, duration=0.15, stepper=lf.GeneralizedAlpha(step=1e-3), progress=False)
    assert not found.within
    assert found.proved
    assert found.step_error <= 0.05
    assert "less than 2 steps of 1 ms: no run shows what it does" in found.sentence()


def test_a_note_that_richer_bodies_were_off_takes_the_promise_back() -> None:
    fidelities = of_scene(wall)
    step = lf.MoreauJean(step=1e-3)
    search = Search(fidelities, comparable(fidelities, "motion"), 0.0, 1.5, lambda scene: step, 60.0)
    for level in (0, 2, 3, fidelities.top[0]):
        search.run((level,))
    search.reference = fidelities.top
    search.tolerance = search.estimate((3,)) * 0.99
    (reason,) = contradictions(search, (2,))
    assert "by chance" in reason
    choice = replace(sized(), contradictions=(reason,))
    assert not choice.within
    assert choice.sentence().startswith("Nothing is promised: richer bodies were off by up to ")


def test_rich_bodies_that_cannot_be_trusted_take_the_promise_back() -> None:
    fidelities = of_scene(wall)
    search = Search(
        fidelities, comparable(fidelities, "motion"), 0.05, 1.5, lambda scene: lf.MoreauJean(step=1e-3), 60.0
    )
    for level in (0, 2):
        search.run((level,))
    search.reference = (2,)
    search.untrusted = True
    search.notes = ["bar: full mesh cannot be trusted: contact impulses created energy"]
    assert search.notes[0] in contradictions(search, (0,))
