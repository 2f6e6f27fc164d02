"""What a study of work and precision refuses, and what is left of it after Ctrl-C."""

from __future__ import annotations

import math

import numpy as np
import pytest

import lcpflex as lf
from lcpflex import gallery
from lcpflex.errors import ModelError
from lcpflex.studies import work_precision

MOREAU_JEAN = [lf.MoreauJean(step=h) for h in (1e-2, 3e-3, 1e-3)]


@pytest.mark.parametrize(
    ("argument", "value"),
    [
        ("methods", {}),
        ("methods", {"a": []}),
        ("methods", {"a": [lf.MoreauJean]}),
        ("reference", 3.0),
        ("reference", {"no output": 3.0}),
        ("outputs", {}),
        ("outputs", ["no output"]),
        ("outputs", {"a": 3.0}),
        ("duration", -1.0),
        ("repeats", -1),
        ("limit", 0.0),
        ("instants", 1),
        ("energy_growth", True),
        ("scenes", []),
        ("scenes", gallery.block_on_incline()),  # without a duration
        ("colour", "red"),
        ("colour", ["red"]),
    ],
)
def test_wrong_arguments_are_refused(argument: str, value) -> None:
    arguments = {"scenes": gallery.scenes()["incline"], "methods": {"a": [lf.MoreauJean(step=0.1)]}, "repeats": 0}
    with pytest.raises(ModelError):
        work_precision(**{**arguments, argument: value})


def interrupting(count: int):
    """A function that Ctrl-C meets when it is called the ``count``-th time."""
    calls = []

    def output(result) -> float:
        calls.append(result)
        if len(calls) == count:
            raise KeyboardInterrupt
        return float(result.u[-1, 0])

    return output


@pytest.mark.parametrize("reference", [{"last": 1.0}, None])
def test_ctrl_c_keeps_what_was_measured(reference) -> None:
    work = work_precision(
        [gallery.scenes()["stick_slip"], gallery.scenes()["incline"]],
        {"a": MOREAU_JEAN, "b": MOREAU_JEAN[:2]}, reference,
        outputs={"last": interrupting(3)}, repeats=0,
    )  # fmt: skip
    assert not work.complete
    assert len(work.studies) == 1
    assert [point.told for point in work.points] == ["MoreauJean(step=0.01)", "MoreauJean(step=0.003)"]
    assert work.of().notes == ("a: MoreauJean(step=0.001) left out: interrupted", "b: not run, interrupted")
    assert "b: not run, interrupted" in work.table()


def test_ctrl_c_while_the_reference_is_refined_keeps_all_runs() -> None:
    work = work_precision(
        gallery.scenes()["stick_slip"], {"a": MOREAU_JEAN}, outputs={"last": interrupting(4)}, repeats=0
    )
    assert not work.complete
    assert work.of().reference.source == "a, MoreauJean(step=0.001)"
    assert len(work.points) == 3


def test_ctrl_c_before_anything_can_be_compared_ends_the_study() -> None:
    with pytest.raises(KeyboardInterrupt):
        work_precision(gallery.scenes()["stick_slip"], {"a": MOREAU_JEAN}, outputs={"last": interrupting(2)}, repeats=0)


def cramped(result) -> float:
    return 1.0 / (result.steps > 500) if result.steps != 1000 else math.nan


def test_outputs_that_cannot_be_had_are_failures_of_their_runs_only() -> None:
    methods = {"a": [lf.MoreauJean(step=gallery.scenes()["stick_slip"].duration / n) for n in (100, 1000, 3000)]}
    work = work_precision(gallery.scenes()["stick_slip"], methods, {"x": 1.0}, outputs={"x": cramped}, repeats=0)
    assert [point.failure for point in work.points] == [
        "outputs['x'] raised ZeroDivisionError: float division by zero",
        "outputs['x'] is not finite",
        "",
    ]
    with pytest.raises(ModelError, match=r"no method has two sound runs.*a: outputs\['x'\] raised ZeroDivisionError"):
        work_precision(gallery.scenes()["stick_slip"], methods, outputs={"x": cramped}, repeats=0)


@pytest.mark.parametrize("wrong", [math.nan, "text", lambda times: np.full(len(times), math.nan), lambda times: 1.0])
def test_impossible_references_are_refused_before_time_is_spent(wrong) -> None:
    def never(result) -> float:
        raise AssertionError

    with pytest.raises(ModelError, match=r"reference\['x'\]"):
        work_precision(
            gallery.scenes()["incline"], {"a": [lf.MoreauJean(step=0.1)]}, {"x": wrong}, outputs={"x": never}
        )


def needs_friction(friction) -> lf.Scene:
    return gallery.block_on_incline(friction=friction + "")  # a mistake within the function


def test_mistakes_within_a_builder_are_not_told_as_missing_parameters() -> None:
    with pytest.raises(ModelError, match=r"cannot be called with \{\}: missing a required argument: 'friction'"):
        work_precision(needs_friction, duration=0.1)
    with pytest.raises(ModelError, match=r"the function raised TypeError: .*unsupported operand"):
        work_precision(needs_friction, duration=0.1, friction=[0.3])
