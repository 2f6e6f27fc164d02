"""The table of a comparison: a row a run, differences first, and a line that counts."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence

from tests.comparison.difference import ALIKE, ORDER, Outcome

__all__ = ["exit_code", "table"]

LONGEST = 600  # characters of what is said of a run
SHORT = 60  # of a run that is alike, as of a refusal

Run = tuple[str, str]


def table(outcomes: Mapping[Run, Outcome], alone: Mapping[str, Sequence[str]]) -> str:
    """All of it. alone: by the name of a checkout the scenes that the other one has not."""
    rows = sorted(outcomes.items(), key=lambda item: item[1].rank)
    head = ("scene", "stepper", "status", "")
    cells = [head, *((*run, outcome.status, _brief(outcome)) for run, outcome in rows)]
    widths = [max(len(row[k]) for row in cells) for k in range(3)]
    lines = ["  ".join([*(row[k].ljust(widths[k]) for k in range(3)), row[3]]).rstrip() for row in cells]
    lines += [f"only in {name}: {', '.join(scenes)}" for name, scenes in alone.items() if scenes]
    counts = Counter(outcome.status for outcome in outcomes.values())
    told = ", ".join(f"{counts[status]} {status}" for status in ORDER if counts[status])
    return "\n".join([*lines, f"{len(outcomes)} runs: {told or 'none'}"])


def exit_code(outcomes: Mapping[Run, Outcome]) -> int:
    """0 where all runs are alike to the last bit, else 1."""
    return 0 if all(outcome.status in ALIKE for outcome in outcomes.values()) else 1


def _brief(outcome: Outcome) -> str:
    line = " ".join(outcome.text.split())
    longest = SHORT if outcome.status in ALIKE else LONGEST
    return line if len(line) <= longest else f"{line[: longest - 4]} ..."
