"""Studies that look for what is cheap count."""

from __future__ import annotations

import math
from collections.abc import Iterator

import pytest

from lcpflex.studies.model_order import search


@pytest.fixture(scope="module", autouse=True)
def by_counts() -> Iterator[None]:
    """What a run costs is told by its coordinates: by the clock, a slow moment of the machine leads elsewhere."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(search, "SHORT", math.inf)
        yield
