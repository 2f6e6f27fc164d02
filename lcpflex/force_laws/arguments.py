"""Numbers and arrays given to the public face of laws."""

from __future__ import annotations

from typing import Any

import numpy as np

from lcpflex.basics.arguments import numbers
from lcpflex.errors import ModelError, shown
from lcpflex.jit.kernel import FloatArray

__all__ = ["finite_numbers", "numbers_of"]


def numbers_of(name: str, given: Any) -> FloatArray:
    """``given`` as an array of floats; ModelError for what is no number and no array of numbers."""
    values = numbers(given)
    if values is None:
        raise ModelError(f"{name}: {shown(given)} was given, expected a number or an array of numbers")
    return np.asarray(values)


def finite_numbers(name: str, given: Any, least: float) -> FloatArray:
    """``numbers_of`` that are all finite and not below ``least``."""
    values = numbers_of(name, given)
    wrong = values[~((values >= least) & np.isfinite(values))]
    if wrong.size > 0:
        expected = "finite numbers" if least == -np.inf else f"finite numbers >= {least:g}"
        raise ModelError(f"{name}: {float(wrong[0])!r} was given, expected {expected}")
    return values
