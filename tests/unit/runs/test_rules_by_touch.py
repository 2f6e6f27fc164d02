"""Results of a rule that is not listed: contacts for the pairs that touched, the numbers of a run with all pairs."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.checks.kept_depth import kept_depths
from lcpflex.contact import rule_pairs
from lcpflex.model.arrays import OPEN
from lcpflex.scene import contact_rules
from lcpflex.scene.scene import Scene
from lcpflex.solvers import load_problems
from lcpflex.steppers.run import Run
from lcpflex.steppers.system import System
from lcpflex.studies.model_order import verdict

BY_CONTACT = ("force", "impulse", "state")
STEPPERS = {
    "Moreau-Jean": lf.MoreauJean(2e-3),
    "doubled steps": lf.MoreauJean(2e-3, adaptive=lf.AdaptiveStep(rtol=1e-2)),
    "generalized alpha": lf.GeneralizedAlpha(2e-3),
}


def heap(n: int = 7, restitution: float = 0.0) -> Scene:
    """Boxes and discs of scattered sizes that fall onto a floor, some of them declared or excluded by themselves."""
    rng = np.random.default_rng(7)
    scene = lf.Scene()
    floor = scene.ground.half_plane((0.0, 0.0), (0.0, 1.0))
    scene.ground.half_plane((-0.2, 0.0), (1.0, 0.2))
    for k in range(n):
        size = rng.uniform(0.09, 0.11)
        body = lf.Box(size, size, density=100.0) if k % 3 == 0 else lf.Disc(0.5 * size, density=100.0)
        place = (0.13 * (k % 3) + 0.02 * (k // 3), 0.07 + 0.13 * (k // 3))
        scene.add(body, position=place, velocity=rng.uniform(-0.3, 0.3, 2))
    scene.contact(scene.body("body2").surface(), floor, friction=0.1, restitution=restitution, name="slippery")
    scene.contact_all(friction=0.5, restitution=restitution, exclude=[(scene.body("body1"), floor)])
    scene.contact_all(friction=0.9, restitution=restitution)
    return scene


@pytest.fixture(autouse=True)
def kept(monkeypatch: pytest.MonkeyPatch) -> None:
    """Rules of small scenes are kept, too, and there is room for two laws at first."""
    monkeypatch.setattr(contact_rules, "LISTED", 3)
    monkeypatch.setattr(rule_pairs, "FIRST_LAWS", 2)


def listed(
    scene: Scene, stepper: object, duration: float, monkeypatch: pytest.MonkeyPatch, **more: object
) -> lf.Result:
    with monkeypatch.context() as patch:
        patch.setattr(contact_rules, "LISTED", 10**9)
        return lf.simulate(scene, duration, stepper, **more)


@pytest.mark.parametrize("name", STEPPERS)
def test_numbers_are_those_of_a_run_with_all_pairs_to_the_bit(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    stepper = STEPPERS[name]
    found = lf.simulate(heap(), 0.3, stepper, record=0.02)
    expected = listed(heap(), stepper, 0.3, monkeypatch, record=0.02)
    assert 5 < len(found.contact_names) < len(expected.contact_names)
    touched = [one for one in expected.contact_names if one in found.contact_names]
    assert touched == list(found.contact_names)  # in the same order
    columns = [expected.contact_names.index(one) for one in touched]
    np.testing.assert_array_equal(found.q, expected.q)
    np.testing.assert_array_equal(found.u, expected.u)
    for field in BY_CONTACT:
        np.testing.assert_array_equal(getattr(found, field), getattr(expected, field)[:, columns])
    measured = ~np.isnan(found.gap)
    np.testing.assert_array_equal(found.gap[measured], expected.gap[:, columns][measured])
    assert (found.state[~measured] == OPEN).all()
    for field in ("record", "place", "normal", "force", "state"):
        np.testing.assert_array_equal(getattr(found.contact_points, field), getattr(expected.contact_points, field))
    of = [found.contact_names[k] for k in found.contact_points.contact]
    assert of == [expected.contact_names[k] for k in expected.contact_points.contact]
    assert found.warnings == expected.warnings
    for one in touched:
        assert found.contact(one).first_touch == expected.contact(one).first_touch
    np.testing.assert_array_equal(
        found.compiled.model.contacts.friction[: len(touched)], expected.compiled.model.contacts.friction[columns]
    )


def test_pairs_that_never_touched_have_histories_without_force(monkeypatch: pytest.MonkeyPatch) -> None:
    found = lf.simulate(heap(), 0.1, STEPPERS["Moreau-Jean"], record=0.01)
    every = listed(heap(), STEPPERS["Moreau-Jean"], 0.1, monkeypatch, record=0.01).contact_names
    others = [name for name in every if name not in found.contact_names]
    assert len(others) > 10
    for name in others:
        history = found.contact(name)
        assert history.first_touch is None
        assert (history.name, history.peak_force, history.shares) == (name, 0.0, (1.0, 0.0, 0.0))
        assert np.isinf(history.least_gap)
        assert history.force.shape == history.impulse.shape == (len(found.times), 2)
    for name in ("body1.outline/body1.outline", "body2.outline/body1.outline", "slippery2", "body2.outline/", 3):
        with pytest.raises(lf.ModelError, match="no contact"):
            found.contact(name)
    with pytest.raises(lf.ModelError, match="no contact"):  # declared under another name
        found.contact("body2.outline/ground.half_plane1")


def test_events_name_their_pairs() -> None:
    result = lf.simulate(heap(restitution=0.3), 0.25, lf.EventDriven(rtol=1e-7), record=0.01)
    assert result.complete
    named = {event.contact for event in result.events}
    assert len(named) > 5
    assert named <= set(result.contact_names)
    for name in named:
        history = result.contact(name)
        assert history.first_touch == min(event.time for event in result.events if event.contact == name)
        assert history.impulse[-1, 0] > 0.0
    total = sum(result.contact(name).impulse[-1, 0] for name in named)
    assert total == pytest.approx(result.impulse[-1, :, 0].sum())


def test_motion_between_events_is_that_of_all_pairs(monkeypatch: pytest.MonkeyPatch) -> None:
    # the error of a step is a mean over all that is integrated, impulses of all pairs among it: no equal bits
    stepper = lf.EventDriven(rtol=1e-10)
    found = lf.simulate(heap(), 0.12, stepper, record=0.04)
    expected = listed(heap(), stepper, 0.12, monkeypatch, record=0.04)
    np.testing.assert_allclose(found.q[-1], expected.q[-1], atol=1e-6)
    assert {event.contact for event in found.events} == {event.contact for event in expected.events}


def test_results_are_saved_drawn_and_told(tmp_path: Path) -> None:
    result = lf.simulate(heap(), 0.2, STEPPERS["Moreau-Jean"], record=0.02)
    again = lf.Result.load(result.save(tmp_path / "heap.npz"))
    assert again.contact_names == result.contact_names
    assert again.summary() == result.summary()
    assert "those by the rule for 9 surfaces as far as they touched" in result.summary()
    assert again.contact("body1.outline/body7.outline").first_touch is None
    result.plot()
    result.draw(0.1)
    points = result.contact_points
    parts = [points.at(k) for k in range(len(result.times))]
    assert sum(len(part.record) for part in parts) == len(points.record)
    for name in ("record", "contact", "place", "normal", "force", "state"):
        np.testing.assert_array_equal(np.concatenate([getattr(part, name) for part in parts]), getattr(points, name))


@pytest.mark.parametrize("stop", [pytest.param(2, marks=pytest.mark.slow), 5])
@pytest.mark.parametrize("name", STEPPERS)
def test_a_run_is_resumed_with_the_laws_it_had_given(name: str, stop: int, tmp_path: Path) -> None:
    stepper, path = STEPPERS[name], tmp_path / "run.npz"
    whole = lf.simulate(heap(), 0.3, stepper, record=0.02)
    advance, chunks = Run.advance, iter(range(stop))

    def interrupted(self: Run, n_steps: int) -> str:
        if next(chunks, None) is None:
            raise KeyboardInterrupt
        return advance(self, 20)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Run, "advance", interrupted)
        assert not lf.simulate(heap(), 0.3, stepper, record=0.02, checkpoint=path).complete
    rest = lf.resume(path)
    assert rest.contact_names == whole.contact_names
    for field in ("q", "u", "gap", *BY_CONTACT):
        np.testing.assert_array_equal(getattr(rest, field), getattr(whole, field))


def test_contacts_are_named_where_a_run_cannot_go_on() -> None:
    class Refusing:
        left = 60

        def solve(self, problem: object, guess: object = None) -> object:
            Refusing.left -= 1
            if Refusing.left < 0:
                raise ValueError("enough")
            return lf.Lemke().solve(problem)

    with pytest.raises(lf.StepError, match="enough") as raised:
        lf.simulate(heap(), 0.3, lf.MoreauJean(2e-3, solver=Refusing()), record=0.02)
    assert set(raised.value.contacts) <= set(raised.value.result.contact_names)
    assert raised.value.contacts


def test_problems_are_recorded_by_the_names_of_pairs(tmp_path: Path) -> None:
    problems = lf.RecordProblems(tmp_path / "problems.npz", every=1, limit=500)
    result = lf.simulate(heap(), 0.2, STEPPERS["Moreau-Jean"], record=0.02, record_problems=problems)
    kept = load_problems(problems.path)
    names = {key.rsplit("#", 1)[0] for one in kept for key in one.problem.keys}
    assert names
    assert names <= set(result.contact_names)


def row(n: int) -> Scene:
    """Discs beside each other on a floor, with no contact but those of the rule."""
    scene = lf.Scene()
    scene.ground.half_plane((0.0, 0.0), (0.0, 1.0))
    for k in range(n):
        scene.add(lf.Disc(0.05, density=1.0), position=(0.2 * k, 0.05))
    scene.contact_all(friction=0.5)
    return scene


def test_problems_are_recorded_where_all_contacts_are_those_of_a_rule(tmp_path: Path) -> None:
    for stepper in (STEPPERS["Moreau-Jean"], lf.EventDriven()):
        problems = lf.RecordProblems(tmp_path / "problems.npz", every=1)
        lf.simulate(row(4), 0.02, stepper, record=0.02, record_problems=problems)
        keys = {key.rsplit("#", 1)[0] for one in load_problems(problems.path) for key in one.problem.keys}
        assert keys == {f"body{k}.outline/ground.half_plane1" for k in range(1, 5)}


def test_admissible_motions_name_the_pairs_of_a_rule() -> None:
    """More of them than there is room for at first."""
    motions = lf.admissible_accelerations(row(5))
    assert motions.contacts == tuple(f"body{k}.outline/ground.half_plane1" for k in range(1, 6))
    assert np.abs(motions.solutions[0].acceleration).max() < 1e-9
    assert motions.solutions[0].force[:, 0] == pytest.approx(np.full(5, 9.81 * np.pi * 0.05**2))


def test_impulses_are_expected_of_a_scene_with_a_rule_alone() -> None:
    """Of a choice of modes, that none was seen is worth a word where bodies may touch."""
    for scene, expected in ((row(4), True), (lf.Scene(), False)):
        if not expected:
            scene.add(lf.Disc(0.05, density=1.0))
        search = SimpleNamespace(fidelities=SimpleNamespace(scene=scene))
        assert verdict._expected(search, "impulses") is expected  # type: ignore[arg-type]


def test_steppers_with_laws_of_their_own_have_all_pairs() -> None:
    law = lf.Penalty(stiffness=1e5)
    names = heap().compiled(indents=lambda name: True).layout.contacts
    result = lf.simulate(heap(), 0.02, lf.Smooth(laws=dict.fromkeys(names, law)), record=0.01)
    assert result.contact_names == names
    assert len(names) == 35


def test_a_rule_by_a_force_law_has_all_pairs() -> None:
    scene = lf.Scene()
    for k in range(6):
        scene.add(lf.Disc(0.05, density=1.0), position=(0.11 * k, 0.0))
    scene.contact_all(law=lf.Penalty(stiffness=1e5))
    assert len(scene.compiled().layout.contacts) == 15


def test_a_body_that_passes_through_another_is_told_with_its_name() -> None:
    scene = lf.Scene(gravity=(0.0, 0.0))
    for k in range(6):
        scene.add(lf.Disc(0.05, density=1.0), position=(0.3 * k, 0.0))
    scene.add(lf.Disc(0.05, density=1.0), name="bullet", position=(-1.0, 0.01), velocity=(37.0, 0.0))
    scene.contact_all()
    result = lf.simulate(scene, 0.05, lf.MoreauJean(1e-2), record=0.01)
    assert "passed through each other" in result.summary()
    assert "bullet.outline" in result.summary()


def test_more_points_than_a_recorder_has_room_for(monkeypatch: pytest.MonkeyPatch) -> None:
    real = System.recorder
    monkeypatch.setattr(
        System, "recorder", lambda self, table, points: real(self, table, 2 if points == 1024 else points)
    )
    result = lf.simulate(heap(), 0.2, STEPPERS["Moreau-Jean"], record=0.02)
    assert np.bincount(result.contact_points.record).max() > 2


def test_depths_of_rigid_bodies_without_springs_are_judged_without_matrices(monkeypatch: pytest.MonkeyPatch) -> None:
    def refused(*parts: object) -> None:
        raise AssertionError("a matrix of all coordinates")

    result = lf.simulate(heap(3), 0.5, lf.MoreauJean(2e-3, projection=False), record=0.02)
    sunk = (result.gap[-1] < 0.0) & (result.force[-3:, :, 0].min(axis=0) > 0.0)
    assert sunk.any()
    monkeypatch.setattr("lcpflex.checks.kept_depth.stiffness_of", refused)
    assert kept_depths(result) == ()
