"""Numbers in the words of summaries and messages."""

from __future__ import annotations

import numpy as np

__all__ = ["SHARED", "counted", "percent", "prefix_of", "with_unit"]

SHARED = "share a load in more ways than one"  # of contacts, in notes: their forces are not unique


def percent(value: float) -> str:
    """A share with three digits: 0.01234 becomes 1.23 %."""
    return f"{100.0 * value:.3g} %"


def counted(count: int, noun: str) -> str:
    """A number of things."""
    return f"{count:,} {noun}{'' if count == 1 else 's'}"


def with_unit(value: float, unit: str) -> str:
    """A number with four digits and a prefix: 0.00123 s becomes 1.23 ms."""
    size = abs(value)
    if size == 0.0 or not np.isfinite(size):
        return f"{value:g} {unit}"
    for factor, prefix in ((1e6, "M"), (1e3, "k"), (1.0, ""), (1e-3, "m"), (1e-6, "µ"), (1e-9, "n")):
        if size >= 0.9995 * factor:
            return f"{value / factor:.4g} {prefix}{unit}" if not (unit == "s" and factor > 1.0) else f"{value:,.0f} s"
    return f"{value:.1e} {unit}"


def prefix_of(largest: float) -> tuple[float, str]:
    """Factor and prefix of the unit in which the largest value reads well."""
    for factor, prefix in ((1e9, "G"), (1e6, "M"), (1e3, "k"), (1.0, ""), (1e-3, "m"), (1e-6, "µ")):
        if largest >= factor:
            return factor, prefix
    return (1e-9, "n") if largest > 0.0 else (1.0, "")
