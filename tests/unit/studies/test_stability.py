"""Stability maps: known limits of methods are found, and each way to fail has its name."""

from __future__ import annotations

import csv
import math
from pathlib import Path

import numpy as np
import pytest

import lcpflex as lf
from lcpflex import gallery
from lcpflex.force_laws.penalty import Penalty
from lcpflex.steppers.smooth.stepper import Smooth, Verlet
from lcpflex.studies import Criteria, Outcome, StabilityMap, acceleration_level, stability
from tests.scenes import disc_on_spring, floor_of


def oscillator(stiffness: float = 100.0) -> lf.Scene:
    """A mass of 1 kg on a spring, which the scheme takes explicitly."""
    return disc_on_spring(stiffness)


def moreau_jean(step: float = 1e-3) -> lf.MoreauJean:
    return lf.MoreauJean(step=step)


@pytest.fixture(scope="module")
def oscillators() -> StabilityMap:
    axes = {"step": 2.0 / math.sqrt(1e4) * np.geomspace(0.25, 4.0, 8), "stiffness": [1e2, 1e3, 1e4, 1e5]}
    return stability(oscillator, {"Moreau-Jean": moreau_jean}, axes, duration=20.0)


def test_explicit_limit_of_two_over_omega(oscillators: StabilityMap) -> None:
    """Positions at half steps make theta = 1/2 the leapfrog scheme in an explicit force: stable below h = 2/omega."""
    step, stiffness = (np.array(values) for values in oscillators.axes.values())
    beyond = step[:, None] * np.sqrt(stiffness) > 2.0
    assert beyond.any()
    assert not beyond.all()
    np.testing.assert_array_equal(oscillators.of("Moreau-Jean") == Outcome.DIVERGED, beyond)


@pytest.mark.slow
def test_painleve_boundary_lies_within_a_cell() -> None:
    axes = {"degrees": np.linspace(20.0, 85.0, 27), "friction": np.linspace(0.5, 3.0, 26)}
    found = stability(gallery.painleve_rod, {"acceleration level": acceleration_level}, axes)
    assert set(found.outcomes.ravel()) == {Outcome.SOUND, Outcome.NO_SOLUTION}
    cells = found.of("acceleration level") == Outcome.SOUND
    phi, friction = np.radians(axes["degrees"]), axes["friction"]
    exact = (1.0 + 3.0 * np.cos(phi) ** 2) / (3.0 * np.sin(phi) * np.cos(phi))
    inside = exact < friction[-1]
    assert inside.sum() > 15
    for sound, limit in zip(cells[inside], exact[inside], strict=True):
        last = friction[np.flatnonzero(sound)[-1]]
        assert sound[: np.flatnonzero(sound)[-1] + 1].all()
        assert last <= limit <= last + 0.1 + 1e-12
    assert cells[~inside].all()
    smallest = friction[np.flatnonzero((~cells).any(axis=0))[0]]
    assert 4.0 / 3.0 <= smallest <= 4.0 / 3.0 + 0.1


def test_fast_spin_turns_painleves_missing_motion_into_two() -> None:
    axes = {"spin": [0.0, 1.2], "friction": [0.5, 1.4]}
    found = stability(gallery.painleve_rod, {"acceleration level": acceleration_level}, axes)
    assert found.of("acceleration level").tolist() == [
        [Outcome.SOUND, Outcome.NO_SOLUTION],
        [Outcome.SOUND, Outcome.NOT_UNIQUE],
    ]
    assert found.messages[0, 1, 1].startswith("2 motions: ")


def test_steppers_report_paradoxes() -> None:
    axes = {"spin": [0.0, 1.2], "friction": [0.5, 1.4]}
    found = stability(gallery.painleve_rod, {"event-driven": lf.EventDriven()}, axes, duration=1e-3)
    assert found.of("event-driven").tolist() == [
        [Outcome.NO_TROUBLE, Outcome.RESOLVED],
        [Outcome.NO_TROUBLE, Outcome.RESOLVED],
    ]


def pressed_disc() -> lf.Scene:
    """The force grows so slowly that the disc stays on the floor."""
    scene = lf.Scene(gravity=(0.0, 0.0))
    disc = scene.add(lf.Disc(radius=0.1, mass=1.0), name="disc", position=(0.0, 0.1))
    scene.contact(disc.surface(), floor_of(scene), name="floor")
    scene.load(lf.Force(disc.point("center"), (0.0, lf.Table([0.0, 0.5, 1.0], [0.0, -10.0, -10.0]))))
    return scene


def test_stiff_penalty_explodes_beyond_two_over_omega_and_soft_penalty_sinks() -> None:
    def penalty(step: float, stiffness: float) -> Smooth:
        return Smooth(Penalty(stiffness=stiffness), integrator=Verlet(step))

    axes = {"step": np.geomspace(3e-4, 1e-1, 14), "stiffness": np.geomspace(3e3, 3e6, 7)}
    swings = Criteria(growth=0.3, remainder=0.3)
    found = stability(pressed_disc, {"penalty": penalty}, axes, duration=1.0, criteria=swings)
    beyond = axes["step"][:, None] * np.sqrt(axes["stiffness"]) > 2.0
    unstable = np.isin(found.of("penalty"), [Outcome.GAINING, Outcome.DIVERGED])
    np.testing.assert_array_equal(unstable, beyond)
    sinks = (10.0 / axes["stiffness"] > 1e-3 * 0.2)[None, :] & ~beyond
    np.testing.assert_array_equal(found.of("penalty") == Outcome.DRIFTING, sinks)


def test_indentation_under_a_law_of_the_scene_is_no_drift() -> None:
    """As soft as above, where it sinks: the law belongs to what is asked, not to the method."""

    def soft(stiffness: float) -> lf.Scene:
        scene = lf.Scene(gravity=(0.0, 0.0))
        disc = scene.add(lf.Disc(radius=0.1, mass=1.0), position=(0.0, 0.1))
        floor = floor_of(scene)
        scene.contact(disc.surface(), floor, name="floor", law=Penalty(stiffness=stiffness))
        scene.load(lf.Force(disc.point("center"), (0.0, lf.Table([0.0, 0.5, 1.0], [0.0, -10.0, -10.0]))))
        return scene

    methods = {"law": Smooth(integrator=Verlet(2e-4))}
    found = stability(soft, methods, {"stiffness": [3e3, 1e4]}, duration=1.0, criteria=Criteria(growth=0.3))
    assert (found.of("law") == Outcome.NO_TROUBLE).all()


def test_newtons_law_gains_energy_where_friction_and_restitution_are_large() -> None:
    axes = {"restitution": [0.0, 0.5], "friction": [0.0, 0.5]}
    found = stability(gallery.double_pendulum, {"Moreau-Jean": moreau_jean}, axes, duration=1e-3)
    cells = found.of("Moreau-Jean")
    assert cells[1, 1] is Outcome.GAINING
    assert [cells[0, 0], cells[0, 1], cells[1, 0]] == [Outcome.NO_TROUBLE] * 3
    assert "of the largest stored" in found.messages[0, 1, 1]


def one_cell(method: object, scene: object = oscillator, **more: object) -> tuple[Outcome, str]:
    found = stability(scene, {"method": method}, {"stiffness": [100.0]}, **{"duration": 0.1, **more})  # type: ignore[arg-type]
    return found.outcomes[0, 0], found.messages[0, 0]


class Failing:
    """A solver that gives up."""

    def solve(self, problem: object) -> object:
        raise lf.SolverError("not solved: gave up")


def falling(stiffness: float = 0.0) -> lf.Scene:
    return gallery.bouncing_ball(height=0.01)


def test_each_failure_has_its_name() -> None:
    stepper = lf.MoreauJean(step=1e-3)
    assert one_cell(stepper) == (Outcome.NO_TROUBLE, "")
    assert one_cell(lf.EventDriven()) == (Outcome.NO_TROUBLE, "")
    assert one_cell(stepper, check=lambda result: 1e-3) == (Outcome.SOUND, "")
    assert one_cell(stepper, check=lambda result: abs(result.q[-1, 0] - 2.0)) == (
        Outcome.WRONG,
        "the error of 0.946 is above 0.01, and nothing shows it",
    )
    assert one_cell(stepper, check=lambda result: math.nan)[0] is Outcome.WRONG
    assert one_cell(stepper, criteria=Criteria(growth=1e-9))[0] is Outcome.GAINING
    assert one_cell(stepper, criteria=Criteria(remainder=1e-9))[0] is Outcome.UNEXPLAINED
    assert one_cell(stepper, judge=lambda result: Outcome.NOT_UNIQUE)[0] is Outcome.NOT_UNIQUE
    assert one_cell(stepper, judge=lambda result: None)[0] is Outcome.NO_TROUBLE
    outcome, message = one_cell(stepper, falling, criteria=Criteria(drift=1e-6))
    assert (outcome, message[:11]) == (Outcome.DRIFTING, "penetration")
    outcome, message = one_cell(lf.MoreauJean(step=1e-3, solver=Failing()), falling)
    assert (outcome, "gave up" in message) == (Outcome.SOLVER_FAILED, True)
    outcome, message = one_cell(lambda stiffness: lf.MoreauJean(step=-stiffness))
    assert (outcome, message[:16]) == (Outcome.REFUSED, "step: -100.0 was")
    outcome, message = one_cell(lf.MoreauJean(step=1e-6), time_limit=1e-9)
    assert (outcome, "budget of 1e-09 s" in message) == (Outcome.TOO_SLOW, True)
    assert one_cell(lambda stiffness: lf.MoreauJean(step=math.exp(10.0 * stiffness)))[0] is Outcome.DIVERGED


def test_a_method_may_judge_the_built_scene_or_run_it_itself() -> None:
    seen = []

    def own(scene: lf.Scene, stiffness: float) -> lf.Result:
        seen.append((scene, stiffness))
        return lf.simulate(scene, 0.1, lf.MoreauJean(step=1e-3))

    methods = {"own": own, "said": lambda scene: Outcome.NO_SOLUTION if isinstance(scene, lf.Scene) else None}
    found = stability(oscillator, methods, {"stiffness": [1.0, 2.0]})
    assert found.outcomes.tolist() == [[Outcome.NO_TROUBLE] * 2, [Outcome.NO_SOLUTION] * 2]
    assert [stiffness for _, stiffness in seen] == [1.0, 2.0]


def test_cells_that_differ_in_nothing_run_once() -> None:
    made = []

    def method(step: float) -> lf.MoreauJean:
        made.append(step)
        return lf.MoreauJean(step=step)

    axes = {"step": [1e-3, 1e-2], "elasticity": [1.0, 2.0]}
    methods = {"one": method, "other": lambda elasticity=1.0: Outcome.SOUND}
    found = stability(falling, methods, axes, duration=0.01)
    assert made == axes["step"]
    assert (found.of("one") == Outcome.NO_TROUBLE).all()
    assert (found.of("other") == Outcome.SOUND).all()
    assert np.count_nonzero(found.seconds) <= 4


def test_ctrl_c_keeps_what_was_found() -> None:
    def method(stiffness: float) -> Outcome:
        if stiffness > 2.0:
            raise KeyboardInterrupt
        return Outcome.SOUND

    found = stability(oscillator, {"m": method}, {"stiffness": [1.0, 2.0, 3.0, 4.0]})
    assert found.outcomes[0].tolist() == [Outcome.SOUND] * 2 + [Outcome.NOT_RUN] * 2
    assert not found.complete


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"axes": {"stifness": [1.0]}}, r"nothing takes 'stifness'.*scene: stiffness; methods\['m'\]: step"),
        ({"axes": {}}, "axes: 0 were given; expected one or two names"),
        ({"axes": {"step": []}}, r"axes\['step'\]: no values"),
        ({"axes": {"step": [1e-3, 1e-3]}}, r"axes\['step'\]: .*expected values that differ"),
        ({"methods": {}}, "methods: none was given"),
        ({"methods": {"m": 3}}, r"methods\['m'\]: 3 was given, expected a stepper or a function"),
        ({"methods": {"m": lambda order: None}}, r"methods\['m'\] needs 'order', which no axis gives"),
        ({"methods": {"m": lf.MoreauJean(step=1e-3)}, "axes": {"stiffness": [1.0]}}, "duration: not given"),
        ({"scene": 3}, "scene: 3 was given, expected a Case or a function"),
        ({"duration": -1.0}, "duration: -1.0"),
        ({"time_limit": 0.0}, "time_limit: 0.0"),
        ({"truth_limit": 0.0}, "truth_limit: 0.0"),
        ({"truth": 3}, "truth: 3 was given, expected a stepper or a function"),
        ({"truth": True}, "duration: not given"),
        ({"truth": True, "outputs": "colour"}, "outputs: no output 'colour'"),
        ({"axes": {"stifness": [1.0]}}, r"'stifness' \(did you mean 'stiffness'\?\); expected"),
        ({"axes": {"step": range(200_000)}}, "200000 cells with 1 methods; expected at most 100000"),
    ],
)
def test_impossible_requests(arguments: dict[str, object], words: str) -> None:
    given = {"scene": oscillator, "methods": {"m": moreau_jean}, "axes": {"step": [1e-3]}, **arguments}
    with pytest.raises(lf.ModelError, match=words):
        stability(**given)  # type: ignore[arg-type]


def test_a_method_that_returns_nonsense_is_a_mistake_of_the_caller() -> None:
    with pytest.raises(lf.ModelError, match="returned 3; expected a stepper"):
        stability(oscillator, {"m": lambda: 3}, {"stiffness": [1.0]}, duration=1.0)


def test_criteria_are_checked() -> None:
    with pytest.raises(lf.ModelError, match=r"criteria\.drift: -1"):
        Criteria(drift=-1)


def shapes(x: float, y: float) -> Outcome:
    return Outcome.SOUND if x * y < 1.0 else Outcome.DIVERGED


@pytest.fixture(scope="module")
def hyperbola() -> StabilityMap:
    axes = {"x": [0.1, 1.0, 10.0], "y": [0.05, 0.5, 2.0, 20.0]}
    return stability(oscillator, {"product": shapes, "never": lambda: Outcome.REFUSED}, axes)


def test_words_table_and_file(hyperbola: StabilityMap, tmp_path: Path) -> None:
    assert str(hyperbola).splitlines() == [
        "product: 6 sound, 6 diverged (12 cells)",
        "  sound for x everywhere at y 0.05",
        "  sound for x up to 1 at y 0.5",
        "  sound for x up to 0.1 at y 2",
        "  sound for x nowhere at y 20",
        "never: 12 refused (12 cells)",
        "  sound for x nowhere",
    ]
    np.testing.assert_array_equal(hyperbola.largest_sound("product"), [10.0, 1.0, 0.1, np.nan])
    lines = hyperbola.table().splitlines()
    assert lines[:4] == ["**product**", "", "| y \\ x | 0.1 | 1 | 10 |", "| --- | --- | --- | --- |"]
    assert "| 0.5 | sound | sound | diverged |" in lines
    with hyperbola.csv(tmp_path / "map.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 24
    assert rows[5] | {"seconds": ""} == {
        "method": "product", "x": "1.0", "y": "0.5", "outcome": "sound", "error": "", "message": "",
        "seconds": "",
    }  # fmt: skip
    with pytest.raises(lf.ModelError, match="method: 'none' was given, expected one of 'product', 'never'"):
        hyperbola.of("none")


def test_chart_has_a_panel_a_method_and_says_each_cell(hyperbola: StabilityMap, tmp_path: Path) -> None:
    figure = hyperbola.plot(curves={"exact": ([0.1, 10.0], [10.0, 0.1])})
    panels = figure.axes
    assert [ax.get_title(loc="left") for ax in panels] == ["product", "never"]
    assert {ax.get_xscale() for ax in panels} | {ax.get_yscale() for ax in panels} == {"log"}
    letters = {tuple(np.round(text.get_position(), 9)): text.get_text() for text in panels[0].texts}
    assert letters == {(x, y): "S" if x * y < 1 else "X" for x in (0.1, 1.0, 10.0) for y in (0.05, 0.5, 2.0, 20.0)}
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    assert labels == ["S  sound", "X  diverged", "R  refused", "exact"]
    figure.savefig(tmp_path / "map.png")


def test_axes_of_names_and_single_axes_are_drawn(tmp_path: Path) -> None:
    def said(law: str) -> Outcome:
        return Outcome.SOUND if law == "Poisson" else Outcome.GAINING

    found = stability(oscillator, {"said": said}, {"law": ["Newton", "Poisson"]})
    assert found.outcomes.shape == (1, 2)
    assert "sound for law from Poisson on" in str(found)
    figure = found.plot()
    figure.savefig(tmp_path / "map.png")
    assert [text.get_text() for text in figure.axes[0].get_xticklabels()] == ["Newton", "Poisson"]
    with pytest.raises(lf.ModelError, match="'law' are no numbers"):
        found.largest_sound("said")
    with pytest.raises(lf.ModelError, match="curves"):
        found.plot(curves={"limit": ([0.0], [0.0])})


def test_a_case_gives_its_duration() -> None:
    case = gallery.scenes()["bouncing_ball"]
    found = stability(case, {"m": lambda step: lf.MoreauJean(step=step)}, {"step": [2e-5], "height": [0.1, 1.0]})
    assert found.outcomes.tolist() == [[[Outcome.NO_TROUBLE, Outcome.NO_TROUBLE]]]
