"""Options of frozen dataclasses, kept as the one type that kernels are compiled for.

A kernel is compiled once for each combination of argument types. ``theta=1``, ``np.float32(0.5)`` and ``np.True_`` mean
the same as ``1.0``, ``0.5`` and ``True``, but as they are they would have every kernel that they reach compiled anew.
"""

from __future__ import annotations

from numbers import Real
from typing import Any

import numpy as np

from lcpflex.basics.arguments import flag
from lcpflex.errors import ModelError, as_number, in_range, shown

__all__ = ["at_least", "is_number", "keep_at_least", "keep_flag", "keep_number", "keep_number_or_none"]


def is_number(value: Any) -> bool:
    """Whether ``value`` is a real number, a truth value, or an array without dimensions of one."""
    if isinstance(value, np.ndarray):
        return value.ndim == 0 and value.dtype.kind in "biuf" and not isinstance(value, np.ma.MaskedArray)
    return isinstance(value, Real | np.bool_) and not isinstance(value, np.timedelta64)


def at_least(name: str, value: Any, low: float, expected: str, *, open_end: bool = False) -> float:
    """``value`` as a float if it is a number >= ``low``, or > ``low`` with ``open_end``; infinity is one.

    Raises
    ------
    ModelError
        Naming the argument, the value and what was ``expected``.
    """
    number = as_number(value)
    if not (number > low if open_end else number >= low):
        raise ModelError(f"{name}: {shown(value)} was given, expected {expected}")
    return number


def keep_number(
    owner: Any, name: str, low: float, high: float, *, open_ends: bool = False, label: str | None = None
) -> float:
    """Keep attribute ``name`` of a frozen dataclass as a float, and return it; see :func:`lcpflex.errors.in_range`.

    ``label`` is what the message calls it, its name if omitted.
    """
    number = in_range(label or name, getattr(owner, name), low, high, open_ends=open_ends)
    object.__setattr__(owner, name, number)
    return number


def keep_number_or_none(
    owner: Any, name: str, low: float, high: float, *, open_ends: bool = False, label: str | None = None
) -> None:
    """Keep attribute ``name`` of a frozen dataclass as a float, or as None; see :func:`keep_number`."""
    if getattr(owner, name) is not None:
        keep_number(owner, name, low, high, open_ends=open_ends, label=label)


def keep_at_least(owner: Any, name: str, low: float, expected: str, *, open_end: bool = False) -> None:
    """Keep attribute ``name`` of a frozen dataclass as a float; see :func:`at_least`."""
    object.__setattr__(owner, name, at_least(name, getattr(owner, name), low, expected, open_end=open_end))


def keep_flag(owner: Any, name: str, *, label: str | None = None) -> None:
    """Keep attribute ``name`` of a frozen dataclass as a bool; see :func:`lcpflex.basics.arguments.flag`."""
    object.__setattr__(owner, name, flag(label or name, getattr(owner, name)))
