"""Numbers of the reference scenes: checked, so that each refusal names the parameter and not what is made of it."""

from __future__ import annotations

import functools
import inspect
import math
from collections.abc import Callable
from typing import Any, ParamSpec, TypeVar

from lcpflex.errors import in_range
from lcpflex.given import whole_number

__all__ = ["checked"]

MOST = 1_000_000  # elements, modes, bodies
P = ParamSpec("P")
R = TypeVar("R")


def checked(build: Callable[P, R]) -> Callable[P, R]:
    """The builder, whose ``float`` parameters have to be finite numbers, and ``int`` ones whole numbers >= 0."""
    signature = inspect.signature(build)
    kinds = {name: str(parameter.annotation) for name, parameter in signature.parameters.items()}

    @functools.wraps(build)
    def built(*args: P.args, **kwargs: P.kwargs) -> R:
        bound = signature.bind(*args, **kwargs)
        for name, value in bound.arguments.items():
            bound.arguments[name] = _number(name, value, kinds[name])
        return build(*bound.args, **bound.kwargs)

    return built


def _number(name: str, value: Any, kind: str) -> Any:
    if value is None and kind.endswith(" | None"):
        return None
    if kind.startswith("int"):
        return whole_number(name, value, 0, MOST)
    return in_range(name, value, -math.inf, math.inf)
