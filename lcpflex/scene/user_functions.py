"""Functions of the user that a scene holds, and whether they can be pickled: they are kept by their names."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator
from functools import partial, reduce
from types import FunctionType
from typing import TYPE_CHECKING, Any

from lcpflex import force_laws
from lcpflex.errors import ModelError
from lcpflex.scene.functions_of_time import Function

if TYPE_CHECKING:
    from lcpflex.force_laws.law import Law
    from lcpflex.scene.declared import Parts
    from lcpflex.scene.spatial.scene import SpatialParts

__all__ = ["check_names", "functions_of"]


def check_names(functions: Iterable[tuple[str, Any]]) -> None:
    """Raise ModelError for the first of the functions, each with what holds it, that another process cannot find."""
    for holder, function in functions:
        for inner in _plain(function):
            if not _is_found(inner):
                raise ModelError(
                    f"{holder}: {inner.__qualname__} of {inner.__module__} was given, expected a function at the top "
                    "of a module, to be pickled: functions are kept by their names, and this one cannot be found by it"
                )


def functions_of(parts: Parts | SpatialParts) -> Iterator[tuple[str, Any]]:
    """The functions of time and of indentation in a scene, and what to call their holders."""
    for number, load in enumerate(parts.loads, 1):
        yield from _of_load(number, load)
    for name, joint in parts.joints.items():
        yield from _of_joint(name, joint)
    for name, contact in getattr(parts, "contacts", {}).items():
        yield from _of_law(f"contact {name!r}: law", contact.law)
    for rule in getattr(parts, "rules", ()):
        yield from _of_law("contact_all: law", rule.law)
    yield from ((f"sensor {name!r}: function", getattr(one, "function", None)) for name, one in parts.sensors.items())


def _of_load(number: int, load: Any) -> Iterator[tuple[str, Any]]:
    value = getattr(load, "value", None)
    holder = f"load {number} ({type(load).__name__} on {load.P.label}): value"
    if isinstance(value, tuple):
        yield from ((f"{holder}[{k}]", part) for k, part in enumerate(value))
    else:
        yield holder, value


def _of_joint(name: str, joint: Any) -> Iterator[tuple[str, Any]]:
    for field in ("motion", "length"):
        yield f"joint {name!r} ({type(joint).__name__}): {field}", getattr(joint, field, None)


def _of_law(holder: str, law: Law | None) -> Iterator[tuple[str, Any]]:
    elastic = getattr(law, "elastic", law)
    if isinstance(elastic, force_laws.UserLaw):
        yield holder, elastic.function


def _plain(value: Any) -> Iterator[FunctionType]:
    """The Python functions that a callable stands for; none for what is pickled in ways of its own."""
    if isinstance(value, FunctionType):
        yield value
    elif isinstance(value, Function):
        yield from _plain(value.function)
    elif isinstance(value, partial):
        for part in (value.func, *value.args, *value.keywords.values()):
            yield from _plain(part)


def _is_found(function: FunctionType) -> bool:
    """Whether its module has it under its name."""
    try:
        found: Any = reduce(getattr, function.__qualname__.split("."), sys.modules[function.__module__])
    except (AttributeError, KeyError):
        return False
    return found is function
