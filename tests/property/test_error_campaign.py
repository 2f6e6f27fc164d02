"""The measured error of a run covers the truth in random scenes: see :mod:`tests.property.error_campaign`."""

from __future__ import annotations

from typing import Any

import pytest

from tests.property.error_judge import MEASURES, error_line
from tests.property.error_summary import covered, criteria, failures, ratio, summary
from tests.property.random_scenes import draw

FEW = {  # each judged, off by enough to be told, and done in two seconds
    2: (20004, 20008, 20013, 20014, 20016, 20020, 20026, 20030, 20044, 20050, 20053, 20054),
    3: (20006, 20010, 20015, 20019, 20021, 20027, 20030, 20034, 20040, 20046, 20054, 20068),
}
WHOLE = range(30000, 30300)
OFF = {"place": 0.04, "turn": 0.0, "speed": 0.05, "rms": 0.01}


def line(claim: float = 2.0, **changes: Any) -> dict[str, Any]:
    """Of a run that claims so many times its error."""
    claimed = {name: claim * value for name, value in OFF.items()}
    plain = {
        "dimension": 2,
        "seed": 1,
        "kind": "thrown",
        "stepper": "moreau",
        "outcome": "judged",
        "until": 0.3,
        "duration": 0.3,
        "horizon": 0.3,
        "parted": None,
        "extent": 1.0,
        "fastest": 1.0,
        "speed": 1.0,
        "true": OFF,
        "claimed": claimed,
        "held": {"true": OFF, "claimed": claimed},
        "apart": dict.fromkeys(MEASURES, 1e-6),
        "references": ["EventDriven", "MoreauJean"],
        "reruns": [["a quarter of the step", "MoreauJean", OFF]],
        "verdict": "Trusted",
        "cost": 6.0,
    }
    return plain | changes


def test_ratio_is_of_what_can_be_told() -> None:
    assert ratio(line(), "place") == pytest.approx(2.0)
    assert ratio(line(), "turn") is None  # nothing turns
    doubtful = {"references": ["MoreauJean", "GeneralizedAlpha"], "apart": dict.fromkeys(MEASURES, 0.02)}
    assert ratio(line(**doubtful), "place") is None
    assert ratio(line(**doubtful, true={**OFF, "place": 0.1}), "place") == pytest.approx(0.8)


def broken(lines: list[dict[str, Any]]) -> list[str]:
    """What does not hold."""
    return [one.what for one in criteria(lines) if not one.holds]


@pytest.mark.parametrize(
    ("changes", "what"),
    [
        ({}, []),
        (
            {"claim": 0.4},
            [f"{n}: E >= {t}" for n in ("place", "speed", "rms") for t in ("truth", "half the truth")]
            + ["runs called trusted, off by more than they say and 2 %"],
        ),
        ({"claim": 3.0}, [f"{name}: median of E / truth" for name in ("place", "speed", "rms")]),
        ({"parted": 0.2}, ["horizon at most 1.1 times the true one"]),
        ({"horizon": 0.1}, ["horizon at least half of it"]),
        (
            {"true": dict.fromkeys(MEASURES, 1e-7), "verdict": "NOT to be trusted"},
            ["right runs called not to be trusted"],
        ),
    ],
)
def test_criteria_tell_what_does_not_hold(changes: dict[str, Any], what: list[str]) -> None:
    lines = [line(**changes)]
    assert broken(lines) == what
    assert ("DOES NOT HOLD" in summary(lines)) == bool(what)


@pytest.mark.slow
@pytest.mark.parametrize("dimension", [2, 3])
def test_error_covers_the_truth_in_some_scenes(dimension: int) -> None:
    lines = [error_line(draw(dimension, seed)) for seed in FEW[dimension]]
    assert [one["outcome"] for one in lines] == ["judged"] * len(lines)
    assert not failures(lines)
    half, count = covered(lines, 0.5)
    assert count >= 2 * len(lines)
    assert half >= count - 1


@pytest.mark.campaign
def test_the_whole_campaign() -> None:
    lines = [error_line(draw(dimension, seed)) for dimension in (2, 3) for seed in WHOLE]
    assert not broken(lines)
