"""Where methods fail: each test has two halves, a method that fails and says so, and one that gets the scene right.

``loud`` runs the first and returns what it said: the message of the error, or the warnings and doubts of the result. A
result without either is a silent one, and fails the test.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

import lcpflex as lf
from lcpflex.results.doubts import doubts

Loud = Callable[..., str]


@pytest.fixture
def loud() -> Loud:
    def run(scene: Any, duration: float, stepper: Any, **options: Any) -> str:
        try:
            result = lf.simulate(scene, duration, stepper, **options)
        except lf.LcpflexError as error:
            return f"{type(error).__name__}: {error}"
        said = "; ".join((*result.warnings, *doubts(result)))
        assert said, f"{stepper!r} says nothing"
        return said

    return run
