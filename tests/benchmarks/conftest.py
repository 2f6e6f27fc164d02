"""What the benchmarks share: interleaved runs, ratios of their medians, and a report of them at the end.

Speeds are compared as ratios within one run of the tests, never with numbers of seconds: machines differ, and their
load changes from minute to minute.
"""

from __future__ import annotations

import statistics
from collections.abc import Callable, Iterator, Mapping
from typing import Any

import pytest

REPORT = pytest.StashKey[list[str]]()

Medians = Mapping[str, float]
Interleave = Callable[..., Medians]


@pytest.fixture
def report(request: pytest.FixtureRequest) -> Iterator[Callable[[str], None]]:
    """Adds lines to the report that ends the run."""
    lines: list[str] = []
    yield lines.append
    request.config.stash.setdefault(REPORT, []).extend(lines)


@pytest.fixture
def interleave(benchmark: Any, report: Callable[[str], None]) -> Interleave:
    """Median seconds of several contestants that run in turns, A B C A B C ...; pytest-benchmark times the first one.

    Each contestant makes its run and returns the seconds of what is compared, such as those per step.
    """

    def run(contestants: Mapping[str, Callable[[], float]], rounds: int = 7) -> Medians:
        first, *others = contestants
        seconds: dict[str, list[float]] = {name: [] for name in contestants}
        for contestant in contestants.values():
            contestant()  # compiles, fills caches

        def rest() -> None:
            for name in others:
                seconds[name].append(contestants[name]())

        benchmark.pedantic(lambda: seconds[first].append(contestants[first]()), setup=rest, rounds=rounds)
        medians = {name: statistics.median(values) for name, values in seconds.items()}
        for name, median in medians.items():
            ratio = f"{median / medians[first]:8.1f} x {first}" if name != first else ""
            report(f"{name:42s} {1e6 * median:11.2f} us {ratio}")
        benchmark.extra_info["microseconds"] = {name: 1e6 * median for name, median in medians.items()}
        return medians

    return run


def pytest_terminal_summary(terminalreporter: Any, config: pytest.Config) -> None:
    lines = config.stash.get(REPORT, [])
    if lines:
        terminalreporter.section("measured ratios")
        for line in lines:
            terminalreporter.write_line(line)
