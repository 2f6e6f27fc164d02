"""Numbers of the reference scenes: checked, so that each refusal names the parameter and not what is made of it."""

from __future__ import annotations

import functools
import inspect
import math
from collections.abc import Callable
from typing import Any, ParamSpec, TypeVar

from lcpflex.basics.arguments import flag, whole_number
from lcpflex.errors import ModelError, in_range, shown

__all__ = ["checked"]

MOST = 1_000_000  # elements, modes, bodies
P = ParamSpec("P")
R = TypeVar("R")


def checked(build: Callable[P, R]) -> Callable[P, R]:
    """The builder; ``float`` parameters have to be finite numbers, ``int`` whole ones >= 0, ``bool`` True or False."""
    signature = inspect.signature(build)
    kinds = {name: str(parameter.annotation) for name, parameter in signature.parameters.items()}

    @functools.wraps(build)
    def built(*args: P.args, **kwargs: P.kwargs) -> R:
        bound = signature.bind(*args, **kwargs)
        for name, value in bound.arguments.items():
            bound.arguments[name] = _number(name, value, kinds[name])
        try:
            return build(*bound.args, **bound.kwargs)
        except (ValueError, ArithmeticError) as error:
            # what is made of the parameters has other names
            expected = "" if isinstance(error, ModelError) else ", expected numbers of which a scene can be made"
            raise ModelError(f"{build.__name__}({_told(bound.arguments)}): {error}{expected}") from error

    return built


def _told(given: dict[str, Any]) -> str:
    return ", ".join(f"{name}={shown(value)}" for name, value in given.items())


def _number(name: str, value: Any, kind: str) -> Any:
    if value is None and kind.endswith(" | None"):
        return None
    if kind == "bool":
        return flag(name, value)
    if kind.startswith("int"):
        return whole_number(name, value, 0, MOST)
    return in_range(name, value, -math.inf, math.inf)
