"""Functions, steppers, axes and curves that a study is given: what they are, and what is wrong with them."""

from __future__ import annotations

import inspect
from collections.abc import Mapping
from typing import Any, TypeVar

import numpy as np

from lcpflex.basics.arguments import mapping_of, numbers, sequence_of
from lcpflex.errors import ModelError, shown

__all__ = ["check_call", "check_curves", "checked_axes", "instance_of", "is_stepper", "series_of"]

T = TypeVar("T")

MOST = 10_000  # steppers of one series
MANY = 1000  # values of an axis, of which none is compared with all others


def is_stepper(value: Any) -> bool:
    """Whether a scene can be run with it."""
    return not isinstance(value, type) and callable(getattr(value, "start", None))


def check_call(name: str, function: Any, expected: str) -> None:
    """Raise ModelError for what cannot be called with one argument."""
    if function is None:
        return
    try:
        inspect.signature(function).bind(None)
    except Exception as error:  # also what an object of the user's raises when it is shown
        if callable(function) and isinstance(error, ValueError):  # a built-in one that does not tell
            return
        raise ModelError(f"{name}: {shown(function)} was given, expected {expected}, or None") from None


def series_of(name: str, series: Any) -> tuple[Any, ...]:
    """A stepper, or a sequence of steppers, as a tuple of them."""
    expected = "a stepper, or a sequence of steppers"
    steppers = (series,) if is_stepper(series) else tuple(sequence_of(name, series, expected, MOST))
    if not steppers or not all(map(is_stepper, steppers)):
        raise ModelError(f"{name}: {shown(series)} was given, expected {expected}")
    return steppers


def instance_of(name: str, value: Any, kind: type[T]) -> T | None:
    """``value`` if it is of that kind, or None."""
    if value is not None and not isinstance(value, kind):
        raise ModelError(f"{name}: {shown(value)} was given, expected {kind.__name__}(...), or None")
    return value


def check_curves(name: str, curves: Any) -> Mapping[str, tuple[Any, Any]]:
    """Pairs (x, y) of equally many numbers by label; nothing for None."""
    checked = {}
    for label, curve in ({} if curves is None else mapping_of(name, curves)).items():
        try:
            across, up = (numbers(part) for part in curve)
        except Exception:  # no pair, or an object of the user's that raises what it likes
            across = up = None
        if across is None or up is None or across.ndim != 1 or across.shape != up.shape:
            raise ModelError(f"{name}[{shown(label)}]: {shown(curve)} was given, expected (x, y), equally many numbers")
        checked[label] = (across, up)
    return checked


def checked_axes(axes: Any, most: int) -> dict[str, tuple[Any, ...]]:
    """One or two axes, each with values that differ."""
    table: dict[str, tuple[Any, ...]] = {}
    for name, given in mapping_of("axes", axes).items():
        label = f"axes[{shown(name)}]"
        values = table[name] = tuple(sequence_of(label, given, f"a sequence of at most {most} values"))
        if not values:
            raise ModelError(f"{label}: no values were given; expected at least one")
        if len(values) <= MANY and any(_same(value, other) for i, value in enumerate(values) for other in values[:i]):
            raise ModelError(f"{label}: {shown(values)}; expected values that differ")
    if len(table) not in (1, 2):
        raise ModelError(f"axes: {len(table)} were given; expected one or two names, each with its values")
    return table


def _same(value: Any, other: Any) -> bool:
    """Whether two values are equal; objects that cannot be compared, such as arrays, are if all of them is."""
    try:
        return bool(np.all(value == other))
    except Exception:  # whatever an object of the user's does
        return value is other
