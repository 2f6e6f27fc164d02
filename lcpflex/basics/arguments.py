"""Arguments as what they have to be: arrays, whole numbers, truth values, names; or a ModelError that says what is not.

Numbers alone are checked by :func:`lcpflex.errors.in_range`. Every message shows the value cut short.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from lcpflex.basics import libs
from lcpflex.basics.names import nearest
from lcpflex.errors import ModelError, as_number, in_range, shown

__all__ = [
    "FLOAT",
    "LARGEST_TEXT",
    "SHOWN",
    "WrongFunction",
    "absent",
    "check_axes",
    "array_of",
    "called",
    "flag",
    "lines_of",
    "listed",
    "mapping_of",
    "numbers",
    "one_of",
    "optional_flag",
    "point_of",
    "positive",
    "raised",
    "sequence_of",
    "text",
    "told_by",
    "unknown",
    "whole_number",
]

FLOAT = np.dtype(np.float64)
LARGEST = 2**30  # elements of an array: 8 GiB
SCALE = 1e60  # up to which positive quantities go, and down to its inverse: products of five are numbers
LARGEST_TEXT = 2 * 10**9  # bytes of a text file that is read
SHOWN = 80  # characters of a path in a message
LISTED = 8  # names in a message


class WrongFunction(ModelError):
    """A function of the user's failed, or returned what it should not."""


def raised(name: str, error: Exception, expected: str) -> WrongFunction:
    """What to raise where a function of the user's raised that error."""
    words = f"the function raised {type(error).__name__}: {shown(str(error))}"
    return WrongFunction(f"{name}: {words}, expected {expected}")


def called(name: str, function: Callable[..., Any], expected: str, /, *args: Any) -> Any:
    """What a function of the user's returns; whatever it raises is said with its name."""
    try:
        return function(*args)
    except Exception as error:
        raise raised(name, error, expected) from error


def numbers(value: Any) -> Any:
    """``value`` as an array of floats, not copied where it is one; None for anything else.

    Texts, dates, complex numbers, truth values, objects and masked arrays are no numbers here, although numpy would
    read some of them and drop what it cannot keep. Integers beyond the range of floats make objects.
    """
    if type(value) is np.ndarray and value.dtype is FLOAT and value.size <= LARGEST:
        return value
    try:
        with np.errstate(all="ignore"):
            if isinstance(value, np.ma.MaskedArray):
                return None
            if isinstance(value, list | tuple) and any(isinstance(part, np.ma.MaskedArray) for part in value):
                return None
            array = np.asarray(value)
            if (array.dtype.kind not in "iuf" and array.size) or array.size > LARGEST:
                return None
            return np.asarray(array, dtype=np.float64)
    except Exception:  # ragged, endless, larger than the memory, or an object of the user that raises what it likes
        return None


def array_of(name: str, value: Any, shape: tuple[int, ...]) -> np.ndarray[Any, np.dtype[np.float64]]:
    """``value`` as a read-only array of finite numbers of that shape (-1: any length); raises :class:`ModelError`."""
    array = numbers(value)
    if array is None:
        raise ModelError(f"{name}: {shown(value)} was given, expected an array of numbers")
    if array.shape != shape and (
        array.ndim != len(shape) or any(n not in (-1, have) for have, n in zip(array.shape, shape, strict=True))
    ):
        lengths = ", ".join("any" if length < 0 else str(length) for length in shape)
        wanted = "(n,)" if shape == (-1,) else f"({lengths})"
        raise ModelError(f"{name}: an array of shape {array.shape} was given, expected shape {wanted}")
    finite = np.isfinite(array)
    if not finite.all():
        bad = array[~finite].flat[0]
        raise ModelError(f"{name}: an array with {bad} in it was given, expected finite numbers only")
    array = np.array(array, dtype=np.float64, order="C")
    array.setflags(write=False)
    return array


def point_of(name: str, value: Any, n: int) -> np.ndarray[Any, np.dtype[np.float64]]:
    """A contiguous copy of a point (n,), which may hold NaN and infinity; raises :class:`ModelError`."""
    given = numbers(value)
    if given is None:
        raise ModelError(f"{name} is {shown(value)}: expected {n} numbers")
    if given.shape != (n,):
        raise ModelError(f"{name} has shape {given.shape}: expected ({n},)")
    return np.array(given, order="C")


def whole_number(name: str, value: Any, low: int, high: float = math.inf, why: str = "") -> int:
    """``value`` as an int if it is a whole number in [low, high]; raises :class:`ModelError` otherwise."""
    expected = f"a whole number from {low} to {high:g}" if math.isfinite(high) else f"a whole number >= {low}"
    number = as_number(value)
    if not (math.isfinite(number) and number == math.floor(number) and low <= number <= min(high, 2.0**62)):
        raise ModelError(f"{name}: {shown(value)} was given, expected {expected}{why}")
    return int(number) if abs(number) < 2.0**53 else int(value)


def positive(name: str, value: Any) -> float:
    """``value`` as a float > 0 that can be multiplied: a length, a mass, a modulus."""
    number = in_range(name, value, 0.0, math.inf, open_ends=True)
    return in_range(name, number, 1.0 / SCALE, SCALE)


def flag(name: str, value: Any) -> bool:
    """``value`` as a bool if it is True or False, of Python or numpy, or the number 1 or 0."""
    if isinstance(value, bool | np.bool_) or (type(value) is np.ndarray and not value.ndim and value.dtype.kind == "b"):
        return bool(value)
    number = as_number(value)
    if number not in (0.0, 1.0):
        raise ModelError(f"{name}: {shown(value)} was given, expected True or False")
    return number == 1.0


def optional_flag(name: str, value: Any) -> bool | None:
    """:func:`flag`, or None."""
    return None if value is None else flag(name, value)


def sequence_of(name: str, value: Any, expected: str, most: int = 1_000_000) -> list[Any]:
    """The items of a list, tuple or array of no more than so many; raises :class:`ModelError` for anything else.

    A set is none: its items have no order.
    """
    try:
        if not isinstance(value, str | bytes | Mapping | set | frozenset | np.ma.MaskedArray) and len(value) <= most:
            return list(value)
    except Exception:  # what has no length, and objects of a user
        pass
    raise ModelError(f"{name}: {shown(value)} was given, expected {expected}")


def told_by(name: str, function: Callable[[str], Any]) -> Callable[[str], bool]:
    """A function of the user's that tells whether, for a name; what it raises is said with its own name."""

    def told(given: str) -> bool:
        try:
            answer = function(given)
        except Exception as error:
            words = f"the function raised {type(error).__name__}: {shown(str(error))}, expected True or False"
            raise ModelError(f"{name}: {words} for {shown(given)}") from error
        return flag(f"{name}({shown(given)})", answer)

    return told


def text(name: str, value: Any, expected: str = "a text") -> str:
    """``value`` if it is a text that is not empty."""
    if not isinstance(value, str) or not value:
        raise ModelError(f"{name}: {shown(value)} was given, expected {expected}")
    return value


def mapping_of(name: str, value: Any) -> Mapping[str, Any]:
    """``value`` if it is a mapping from texts; raises :class:`ModelError` otherwise."""
    if not isinstance(value, Mapping) or not all(isinstance(key, str) and key for key in value):
        raise ModelError(f"{name}: {shown(value)} was given, expected a mapping from names (texts)")
    return value


def check_axes(axes: Any, *, needed: bool = False) -> None:
    """Raise ModelError for what is neither axes of matplotlib nor, unless they are needed, None."""
    if not (isinstance(axes, libs.Axes) or (axes is None and not needed)):
        raise ModelError(f"axes: {shown(axes)} was given, expected Axes of matplotlib{'' if needed else ', or None'}")


def lines_of(name: str, path: Path, errors: str = "strict") -> list[str]:
    """The lines of a text file; raises :class:`ModelError` for what is none, or is larger than LARGEST_TEXT."""
    where, expected = f"{name} {str(path)[-SHOWN:]!r}", f"expected a text file of at most {LARGEST_TEXT:.0e} bytes"
    try:
        if path.is_file() and path.stat().st_size > LARGEST_TEXT:
            raise ModelError(f"{where}: it has {path.stat().st_size:.3g} bytes, {expected}")
        return path.read_text(encoding="utf-8", errors=errors).splitlines()
    except (OSError, ValueError, MemoryError) as error:
        if isinstance(error, ModelError):
            raise
        raise ModelError(f"{where}: cannot be read ({str(error)[:SHOWN]}), {expected}") from error


def one_of(name: str, value: Any, known: Iterable[str]) -> str:
    """``value`` if it is one of the known names."""
    names = list(known)
    if not isinstance(value, str) or value not in names:
        raise ModelError(f"{name}: {unknown(value, names)}")
    return value


def unknown(value: Any, known: Iterable[str]) -> str:
    """``value`` was given, what is known instead, and what was meant most likely: the end of a message."""
    return f"{shown(value)} was given, {_instead(value, known)}"


def absent(value: Any, known: Iterable[str]) -> str:
    """The same for something that is not there: "no body " and this."""
    return f"{shown(value)}, {_instead(value, known)}"


def _instead(value: Any, known: Iterable[str]) -> str:
    names = list(known)
    return f"expected one of {listed(names)}{nearest(value, names)}"


def listed(names: Iterable[str]) -> str:
    """Names for a message, no more than LISTED of them."""
    every = list(names)
    if not every:
        return "(there are none)"
    more = f" and {len(every) - LISTED} more" if len(every) > LISTED else ""
    return ", ".join(shown(name) for name in every[:LISTED]) + more
