"""A part of the campaign of runs to a tolerance, and what it counts."""

from __future__ import annotations

import pytest

from tests.property.tolerance_campaign import TOLERANCES, judge, requests, summary
from tests.property.tolerance_scenes import SCENES, by_name

ANSWERED = (
    ("graze", 0.001),
    ("pulse table", 0.01),
    ("shaken plate", 0.01),
    ("skimmed law", 0.001),
    ("spinning box", 0.001),
    ("too few modes", 0.1),
    ("painleve_rod", 0.01),
)


def test_there_are_a_hundred_requests_and_ten_traps():
    assert len(list(requests())) == len(SCENES) * len(TOLERANCES) >= 100
    assert len({one.name for one in SCENES}) == len(SCENES)
    assert sum(one.kind == "modes" for one in SCENES) * len(TOLERANCES) >= 20


def test_the_summary_tells_claims_that_are_too_small():
    line = {"scene": "one", "tolerance": 0.01, "outcome": "answered", "claimed": 1e-3, "true": 5e-3, "unknown": 1e-4}
    line |= {"work": 3000.0, "cheapest": 1000.0, "seconds": 0.2, "quickest": 0.1, "modes": (2, 4), "stepper": "it"}
    told = summary(
        [line | {"verdict": "Trusted"}, {"scene": "two", "tolerance": 0.1, "outcome": "refused", "why": "no"}]
    )
    assert "1 answered, 1 refused, 0 broken" in told
    assert "above the claim in 1, above three times it in 1" in told
    assert "below: one 0.01, claimed 0.001 by it: true 0.005" in told
    assert "median 3.0" in told


@pytest.mark.slow
@pytest.mark.parametrize(("name", "tolerance"), ANSWERED)
def test_true_errors_are_within_claims(name, tolerance):
    line = judge(by_name(name), tolerance, {}, costs=False)
    assert line["outcome"] == "answered"
    assert line["claimed"] <= tolerance
    assert line["true"] <= line["claimed"] + line["unknown"]
    assert line["verdict"] == "Trusted"


@pytest.mark.slow
def test_a_pulse_that_is_not_told_is_refused():
    line = judge(by_name("pulse of state"), 0.1, {}, costs=False)
    assert line["outcome"] == "refused"
    assert "for a moment only" in line["why"]
