"""Every public name says what it is, and what each of its arguments is."""

from __future__ import annotations

import inspect
import re
from enum import Enum
from functools import cache
from types import ModuleType
from typing import Any

import pytest

import lcpflex
from lcpflex import bodies, laws, solvers, studies

MODULES = (lcpflex, solvers, studies, laws, bodies)


@cache
def public() -> dict[str, Any]:
    """The public names by module, and the public methods and properties that their classes define."""
    found: dict[str, Any] = {}
    for module in MODULES:
        for name in module.__all__:
            value = getattr(module, name)
            if isinstance(value, ModuleType | str):
                continue
            found[f"{module.__name__}.{name}"] = value
            if inspect.isclass(value):
                own = {key: inspect.getattr_static(value, key) for key in vars(value) if not key.startswith("_")}
                found |= {f"{module.__name__}.{name}.{key}": one for key, one in own.items() if documented(one)}
    return found


def documented(member: Any) -> bool:
    """Whether a member of a class has a docstring of its own: a method or a property."""
    return isinstance(member, property | classmethod | staticmethod) or inspect.isfunction(member)


def arguments(value: Any) -> list[str]:
    """The names of what is given to a public name."""
    value = getattr(value, "__func__", value)
    if isinstance(value, property) or (inspect.isclass(value) and issubclass(value, Exception | Enum)):
        return []
    parameters = inspect.signature(value).parameters.values()
    return [one.name for one in parameters if one.name not in ("self", "cls") and one.kind is not one.VAR_KEYWORD]


def told(value: Any) -> str:
    """The docstring; of a class with the comments on its fields."""
    comments = (
        re.findall(r"^    (\w+): .*#.*$", inspect.getsource(value), re.MULTILINE) if inspect.isclass(value) else []
    )
    return " ".join([inspect.getdoc(value) or "", *comments])


@pytest.mark.parametrize("name", public())
def test_a_public_name_is_summed_up_in_a_sentence(name: str) -> None:
    summary = (inspect.getdoc(public()[name]) or "").split("\n\n")[0].strip()
    assert re.search(r"[.:]['\"`)]*$", summary), summary


@pytest.mark.parametrize("name", public())
def test_each_argument_of_a_public_name_is_in_its_docstring(name: str) -> None:
    value = public()[name]
    words = set(re.findall(r"\w+", told(value)))
    assert not [argument for argument in arguments(value) if argument not in words]


def test_the_check_sees_what_is_missing() -> None:
    def bare(mass: float, radius: float) -> None:
        """Of a mass"""

    assert arguments(bare) == ["mass", "radius"]
    assert "radius" not in told(bare)
