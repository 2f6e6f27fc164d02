"""Exceptions of lcpflex; nothing else ever leaves the library on purpose.

Every message names the argument, the value that was given and what was expected.
"""

from __future__ import annotations

import math
import os
import reprlib
from pathlib import Path
from typing import Any

import numpy as np

__all__ = [
    "LONGEST",
    "LcpflexError",
    "ModelError",
    "ModelWarning",
    "SolverError",
    "StepError",
    "ToleranceError",
    "as_number",
    "in_range",
    "path_of",
    "shown",
    "writable_path",
]

LONGEST = 499  # characters of a message
SHOWN = 120  # characters of a value in a message
LONGEST_PATH = 1000  # characters of a path that is looked up; systems refuse longer ones in ways of their own

_NO_NUMBERS = (str, bytes, bytearray, memoryview, bool, np.bool_, complex, np.complexfloating, np.datetime64,
               np.timedelta64, np.ma.MaskedArray)  # fmt: skip


class LcpflexError(Exception):
    """Base of all exceptions that lcpflex raises itself. A message longer than LONGEST loses its middle."""

    def __init__(self, message: str = "") -> None:
        super().__init__(_cut(message, LONGEST))


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


class ToleranceError(LcpflexError, RuntimeError):
    """A simulation cannot be had to the tolerance that was asked for, or no independent method bears it out.

    ``result`` holds the best run made, with ``result.choice`` and, where it is known, ``result.error``; None: no run
    came to anything.
    """

    def __init__(self, message: str, result: Any = None) -> None:
        super().__init__(message)
        self.result = result


class _Short(reprlib.Repr):
    """``repr`` of a few items, a line long."""

    def __init__(self) -> None:
        super().__init__()
        self.maxlevel = 3
        self.maxstring = self.maxother = self.maxlong = SHOWN

    def repr_ndarray(self, value: Any, level: int) -> str:
        """Small arrays as they are; the others by what they are."""
        if value.size > 12 or value.dtype.kind not in "biufc":
            return f"an array of shape {value.shape}, type {value.dtype}"
        return repr(value)


def shown(value: Any) -> str:
    """``value`` for a message: as ``repr`` has it, on one line, no longer than SHOWN; of what has none, the type."""
    try:
        text = " ".join(_Short().repr(value).split())
    except Exception:  # numbers of more than 4,300 digits, and objects of a user
        text = f"a value of type {type(value).__name__}"
    return _cut(text, SHOWN)


def _cut(text: str, most: int) -> str:
    """The text, without its middle where it is longer than ``most``."""
    if len(text) <= most:
        return text
    head = (most - 5) * 3 // 5
    return f"{text[:head]} ... {text[head + 5 - most :]}"


def as_number(value: Any) -> float:
    """``value`` as a float; NaN for what is no real number, infinite for what is too large for a float.

    Texts, dates, complex numbers, truth values and masked arrays are none, although Python makes floats of some.
    """
    if type(value) is float:
        return value
    try:
        if isinstance(value, _NO_NUMBERS) or np.ndim(value):
            return math.nan
        if isinstance(value, np.ndarray) and value.dtype.kind not in "iuf":
            return math.nan
        return float(value)
    except OverflowError:
        return math.inf
    except Exception:  # whatever a user's object does when it is asked
        return math.nan


def in_range(name: str, value: Any, low: float, high: float, *, open_ends: bool = False) -> float:
    """``value`` as a float if it is a finite number in [low, high], or in (low, high) with ``open_ends``.

    Raises
    ------
    ModelError
        Naming the argument, the value and what was expected.
    """
    brackets = "()" if open_ends else "[]"
    expected = f"expected a finite number in {brackets[0]}{low:g}, {high:g}{brackets[1]}"
    number = as_number(value)
    inside = low < number < high if open_ends else low <= number <= high
    if not (math.isfinite(number) and inside):
        raise ModelError(f"{name}: {shown(value)} was given, {expected}")
    return number


def path_of(name: str, value: Any) -> Path:
    """``value`` as a path.

    Raises
    ------
    ModelError
        For what is no path, or none that a system of files could have.
    """
    expected = "expected the name of a file"
    try:
        text = os.fspath(value)
    except Exception:
        raise ModelError(f"{name}: {shown(value)} was given, {expected}") from None
    if not isinstance(text, str) or not text.strip() or "\0" in text:
        raise ModelError(f"{name}: {shown(value)} was given, {expected}")
    part = max(map(len, text.split(os.sep)))
    if len(text) > LONGEST_PATH or part > 255:
        raise ModelError(f"{name}: {shown(text)} was given, {len(text)} characters, {expected} that is shorter")
    return Path(text)


def writable_path(name: str, value: Any) -> Path:
    """``value`` as the path of a file that can be written, links followed.

    Raises
    ------
    ModelError
        For what is no path, a folder that is missing or write-protected, and what is there but no regular file.
    """
    try:
        target = path_of(name, value).resolve()
        if target.exists() and not target.is_file():
            raise ModelError(f"{name}: cannot write {shown(str(value))}: it is there and no regular file")
        if not target.parent.is_dir():
            raise ModelError(
                f"{name}: cannot write {shown(str(value))}: there is no folder {shown(str(target.parent))}"
            )
        if not os.access(target.parent, os.W_OK):
            raise ModelError(f"{name}: cannot write {shown(str(value))}: no permission in {shown(str(target.parent))}")
    except (OSError, RuntimeError, UnicodeError) as error:  # a loop of links, a name that the system cannot have
        raise ModelError(f"{name}: cannot write {shown(str(value))}: {error}") from error
    return target
