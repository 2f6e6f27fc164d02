"""The same method made finer: a part of its step, or of its tolerances."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import MISSING, fields, is_dataclass, replace
from typing import Any

__all__ = ["brief", "fineness", "refined", "settled"]


def fineness(stepper: Any) -> tuple[str, float] | None:
    """What makes a stepper accurate: its tolerance or its step; None if it has neither."""
    for part in ("adaptive", "", "integrator"):
        owner = getattr(stepper, part, None) if part else stepper
        for name in ("rtol", "step"):
            value = getattr(owner, name, None)
            if isinstance(value, (int, float)) and value > 0.0:
                return name, float(value)
    return None


def settled(stepper: Any, step: float) -> Any:
    """The stepper with the step [s] that it took where it was given none."""
    if is_dataclass(stepper) and not isinstance(stepper, type) and getattr(stepper, "step", step) is None:
        return replace(stepper, step=step)
    return stepper


def refined(stepper: Any, factor: float) -> Any:
    """The stepper with its step, or its tolerances, divided by ``factor``; None where it has neither."""
    found = fineness(stepper)
    if found is None or not is_dataclass(stepper) or isinstance(stepper, type):
        return None
    names = ("rtol", "atol", "shortest") if found[0] == "rtol" else ("step",)
    for part in ("adaptive", "integrator"):
        if (owner := getattr(stepper, part, None)) is not None:
            return replace(stepper, **{part: _divided(owner, names, factor)})
    return _divided(stepper, names, factor)


def _divided(owner: Any, names: Sequence[str], factor: float) -> Any:
    # what follows the scene, or rtol with it, is None
    given = {name: getattr(owner, name, None) for name in names}
    values = {name: value / factor for name, value in given.items() if value is not None}
    return replace(owner, **{name: min(value, 1.0) for name, value in values.items() if math.isfinite(value)})


def brief(thing: Any) -> str:
    """The ``repr`` of a stepper without the numbers that are as they are by default, but with its tolerance."""
    if isinstance(thing, float):
        return f"{thing:.4g}"
    if not is_dataclass(thing) or isinstance(thing, type):
        return repr(thing)
    told = []
    for one in fields(thing):
        value = getattr(thing, one.name)
        usual = one.default_factory() if one.default_factory is not MISSING else one.default
        if one.repr and (one.name == "rtol" or usual is MISSING or repr(value) != repr(usual)):
            told.append(f"{one.name}={brief(value)}")
    return f"{type(thing).__name__}({', '.join(told)})"
