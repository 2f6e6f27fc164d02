"""Arguments that are arrays: brought to floats at the door, or refused with their name."""

from __future__ import annotations

from typing import Any

import numpy as np

from lcpflex.basics.arguments import numbers
from lcpflex.errors import ModelError, shown
from lcpflex.jit.kernel import FloatArray

__all__ = ["as_array", "check_finite", "finite_array", "nothing"]


def as_array(name: str, value: Any, dimensions: int) -> FloatArray:
    """A contiguous copy of an argument as numbers; refuses other dimensions."""
    given = numbers(value)
    if given is None:
        raise ModelError(f"{name} is {shown(value)}: expected numbers")
    try:
        array = np.array(given, order="C")
    except MemoryError:
        raise ModelError(f"{name} has shape {given.shape}: expected no more than fits into memory") from None
    if array.ndim != dimensions:
        raise ModelError(f"{name} has shape {array.shape}: expected {dimensions} dimension(s)")
    return array


def nothing(name: str, value: Any) -> FloatArray:
    """The matrix of a problem without unknowns, however its emptiness was written."""
    given = numbers(value)
    if given is None or given.size:
        raise ModelError(f"{name} is {shown(value)}: expected an empty matrix, since q is empty")
    return np.zeros((0, 0))


def check_finite(name: str, array: FloatArray) -> None:
    """Refuse NaN and infinity, saying where."""
    finite = np.isfinite(array)
    if not finite.all():
        wrong = np.argwhere(~finite)
        place = tuple(int(k) for k in wrong[0])
        raise ModelError(f"{name}[{', '.join(map(str, place))}] is {array[place]}: expected a finite number")


def finite_array(name: str, value: Any, dimensions: int) -> FloatArray:
    """A contiguous copy of an argument; refuses other dimensions and NaN or inf."""
    array = as_array(name, value, dimensions)
    check_finite(name, array)
    return array
