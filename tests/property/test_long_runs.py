"""Memory of long runs: a step allocates nothing that stays."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

import lcpflex as lf
from lcpflex import gallery

STATUS = Path("/proc/self/statm")
MEGABYTE = 2**20
WARM = 4000  # steps until the heap lies


def resident() -> int:
    """Bytes of memory that this process has now."""
    return int(STATUS.read_text(encoding="ascii").split()[1]) * os.sysconf("SC_PAGE_SIZE")


@pytest.mark.skipif(not STATUS.exists(), reason="needs the memory of a process as Linux tells it")
@pytest.mark.parametrize(
    "steps",
    [pytest.param(100_000, marks=pytest.mark.slow), pytest.param(1_000_000, marks=pytest.mark.campaign)],
)
def test_a_heap_at_rest_needs_no_more_memory_after_a_million_steps(steps: int) -> None:
    """Half a megabyte is allowed for pages that come by chance: half a byte a step of the million."""
    case = gallery.scenes()["heap"]
    run = lf.MoreauJean(step=1e-3).start(case.build().compiled().system(), 1e5, 1e5)  # type: ignore[attr-defined]
    assert not run.advance(WARM)
    before = resident()
    for _ in range(10):
        assert not run.advance(steps // 10)
    assert run.steps == WARM + steps
    assert resident() - before <= 0.5 * MEGABYTE
