"""Warnings of a run, without those that its bodies have few modes: tests of steppers choose them poor on purpose."""

from __future__ import annotations

import lcpflex as lf

OF_BODIES = ("give way", "keep more")


def of_the_run(result: lf.Result) -> tuple[str, ...]:
    """The others."""
    return tuple(text for text in result.warnings if not any(words in text for words in OF_BODIES))
