"""What right_size chooses is within the tolerance of the full mesh, cheap and cheaply found; its estimates are honest.

Everything is checked against all rungs, which are run here. Costs are those of a fit, a + b coordinates, to the wall
times of all of them: single times of a shared machine are too noisy to compare.
"""

from __future__ import annotations

import itertools
import os
from pathlib import Path

import numpy as np
import pytest

from lcpflex.studies import right_size
from lcpflex.studies.fidelity_estimate import cost_of
from lcpflex.studies.fidelity_scenes import comparable, of_scene
from lcpflex.studies.fidelity_search import Search
from tests.studies.fidelity_scenes import QUESTIONS, random_question


class Truth:
    """The runs of all rungs, and their differences to the full mesh."""

    def __init__(self, question) -> None:
        self.ladders = of_scene(question.build)
        outputs = comparable(self.ladders, question.outputs)
        self.search = Search(
            self.ladders, outputs, question.tolerance, question.duration, lambda scene: question.stepper, 600.0
        )
        self.top = self.ladders.top
        self.search.run(self.top)
        self.search.reference = self.top

    def state(self, rungs) -> tuple[int, ...]:
        return tuple(
            [rung.name for rung in ladder].index(rungs[name])
            for name, ladder in zip(self.ladders.names, self.ladders.rungs, strict=True)
        )

    def errors(self, state) -> dict[str, float]:
        self.search.run(state)
        return {one.name: self.search.difference(state, one) for one in self.search.used()}

    def cost(self, coordinates: int) -> float:
        trials = self.search.trials
        return cost_of([(self.ladders.coordinates(s), t.wall_time) for s, t in trials.items()], coordinates)


def answered(name: str):
    question = QUESTIONS[name]
    found = right_size(
        question.build, question.outputs, question.tolerance, duration=question.duration, stepper=question.stepper,
        progress=False,
    )  # fmt: skip
    return question, found


def check(name: str) -> None:
    question, found = answered(name)
    print(f"\n{found}")
    assert found.within
    truth = Truth(question)
    chosen = truth.state(found.rungs)
    true = max(truth.errors(chosen).values())
    assert true <= question.tolerance
    assert {body for body, rung in found.rungs.items() if rung == "rigid"} >= set(question.rigid)
    size = truth.ladders.coordinates(chosen)
    smaller = [
        state
        for state in itertools.product(*(range(k + 1) for k in truth.top))
        if truth.ladders.coordinates(state) < size
    ]
    good = [s for s in smaller if max(truth.errors(s).values()) <= question.tolerance]
    best = min((truth.ladders.coordinates(s) for s in good), default=size)
    full = truth.cost(truth.ladders.coordinates(truth.top))
    spent = sum(truth.cost(run.coordinates) for run in found.runs)
    if np.isfinite(found.step_error):
        spent += 2.0 * truth.cost(size)
    print(f"{name}: true error {true:.2e} of {question.tolerance:g}, cost {truth.cost(size) / truth.cost(best):.2f} of "
          f"the cheapest, study {spent / full:.2f} runs of the full mesh")  # fmt: skip
    assert truth.cost(size) <= 1.5 * truth.cost(best)
    assert spent < 5.0 * full


def test_rigid_is_chosen_where_rigid_suffices() -> None:
    check("sled")


def test_modes_that_nothing_excites_prove_nothing() -> None:
    """The block: its first two modes change the outputs by nothing, the higher ones by half of all there is."""
    _, found = answered("block")
    two = next(run for run in found.runs if run.rungs == {"block": "2 modes"})
    rigid = next(run for run in found.runs if run.rungs == {"block": "rigid"})
    assert two.estimate == pytest.approx(rigid.estimate, rel=1e-3)
    assert rigid.estimate > 0.3
    check("block")


@pytest.mark.slow
@pytest.mark.parametrize("name", ["strip", "hung", "striker", "bar"])
def test_the_choice_is_right_and_cheap(name: str) -> None:
    check(name)


@pytest.mark.slow
def test_the_estimator_is_honest(tmp_path: Path) -> None:
    """True error over estimated one, of the scene that is returned without a run of the full mesh, on 30 scenes."""
    from matplotlib.figure import Figure

    rng = np.random.default_rng(int(os.environ.get("LCPFLEX_SEED", "20261121")))
    ratios = []
    for _ in range(30):
        question = random_question(rng)
        found = right_size(
            question.build, None, question.tolerance, duration=question.duration, stepper=question.stepper,
            verify=False, progress=False,
        )  # fmt: skip
        assert not found.full_was_run
        truth = Truth(question)
        ratios.append(max(truth.errors(truth.state(found.rungs)).values()) / max(found.errors.values()))
    print("\ntrue / estimated:", " ".join(f"{ratio:.2f}" for ratio in sorted(ratios)))
    folder = Path(os.environ.get("LCPFLEX_ARTEFACTS", tmp_path))
    figure = Figure(figsize=(6.0, 3.6), layout="constrained")
    ax = figure.subplots()
    ax.axvspan(0.2, 5.0, color="#E3F1E3")
    ax.hist(np.clip(ratios, 0.05, 20.0), bins=np.geomspace(0.05, 20.0, 25), color="#0072B2")
    ax.set(xscale="log", xlabel="true error / estimated error", ylabel="scenes")
    figure.savefig(folder / "honesty_of_the_estimator.png", dpi=120)
    print(folder / "honesty_of_the_estimator.png")
    assert np.mean([0.2 <= ratio <= 5.0 for ratio in ratios]) >= 0.9
