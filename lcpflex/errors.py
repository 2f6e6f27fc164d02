"""Exceptions of lcpflex; nothing else ever leaves the library on purpose.

Every message names the argument, the value that was given and what was expected.
"""

from __future__ import annotations

import math
import os
from pathlib import Path
from typing import Any

__all__ = ["LcpflexError", "ModelError", "ModelWarning", "SolverError", "StepError", "in_range", "writable_path"]


class LcpflexError(Exception):
    """Base of all exceptions that lcpflex raises itself."""


class ModelError(LcpflexError, ValueError):
    """A scene, body, joint, load, contact or option that cannot be: raised before time is spent."""


class ModelWarning(UserWarning):
    """A model that can be computed but hardly means what it says, as for units that do not fit each other."""


class SolverError(LcpflexError, RuntimeError):
    """A contact problem was not solved to its tolerance.

    ``solution`` holds the best point found, with its residual and status.
    """

    def __init__(self, message: str, solution: Any = None) -> None:
        super().__init__(message)
        self.solution = solution


class StepError(LcpflexError, RuntimeError):
    """A simulation could not go on.

    ``result`` holds everything recorded up to then, marked incomplete; ``time`` [s], ``step``
    (count) and ``contacts`` (names of the active ones) say where it stopped.
    """

    def __init__(
        self,
        message: str,
        *,
        time: float = float("nan"),
        step: int = 0,
        contacts: tuple[str, ...] = (),
        result: Any = None,
    ) -> None:
        super().__init__(message)
        self.time = time
        self.step = step
        self.contacts = contacts
        self.result = result


def in_range(name: str, value: Any, low: float, high: float, *, open_ends: bool = False) -> float:
    """``value`` as a float if it is a finite number in [low, high], or in (low, high) with ``open_ends``.

    Raises
    ------
    ModelError
        Naming the argument, the value and what was expected.
    """
    brackets = "()" if open_ends else "[]"
    expected = f"expected a finite number in {brackets[0]}{low:g}, {high:g}{brackets[1]}"
    try:
        number = math.nan if isinstance(value, str | bytes) else float(value)  # "0.5" would be kept as it is
    except (TypeError, ValueError):
        raise ModelError(f"{name}: {value!r} was given, {expected}") from None
    inside = low < number < high if open_ends else low <= number <= high
    if not (math.isfinite(number) and inside):
        raise ModelError(f"{name}: {value!r} was given, {expected}")
    return number


def writable_path(name: str, value: Any) -> Path:
    """``value`` as the path of a file that can be written, links followed.

    Raises
    ------
    ModelError
        For what is no path, a folder that is missing or write-protected, and what is there but no regular file.
    """
    try:
        target = Path(value).resolve()
    except TypeError:
        raise ModelError(f"{name}: {value!r} was given, expected the name of a file") from None
    if target.exists() and not target.is_file():
        raise ModelError(f"{name}: cannot write {str(value)!r}: it is there and no regular file")
    if not target.parent.is_dir():
        raise ModelError(f"{name}: cannot write {str(value)!r}: there is no folder {str(target.parent)!r}")
    if not os.access(target.parent, os.W_OK):
        raise ModelError(f"{name}: cannot write {str(value)!r}: no permission in {str(target.parent)!r}")
    return target
