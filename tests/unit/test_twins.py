"""A kernel of the plane and the one of space that goes before it are called alike.

``@in_space`` names the twin by its module and by having the same name; calls are written once, for both. So both have
parameters of the same names in the same order, with the same defaults and the same annotations. Where these differ,

    X in the plane is SpatialX in space, and either may be Any;

and what they return may further differ in the number of floats, and in that one of them has nothing to return.
"""

from __future__ import annotations

import importlib
import inspect
import pkgutil
import re
from collections.abc import Callable
from typing import Any, get_args, get_origin

import pytest

import lcpflex
from lcpflex.jit.leaf import Leaf

FLOATS = re.compile(r"tuple\[float(, float)*\]|Vector")


def twins() -> dict[str, tuple[Callable[..., Any], Callable[..., Any]]]:
    """The sources of all pairs, by the name of the planar one."""
    found = {}
    for module in pkgutil.walk_packages(lcpflex.__path__, "lcpflex."):
        if module.name.endswith("__main__"):
            continue
        for value in vars(importlib.import_module(module.name)).values():
            if isinstance(value, Leaf) and value.space:
                spatial = getattr(importlib.import_module(value.space), value.name.rpartition(".")[2])
                found[value.name] = (value.py_func, getattr(spatial, "py_func", spatial))
    return found


def is_any(annotation: str, function: Callable[..., Any]) -> bool:
    """Whether it is Any, or another name for it; those that are known to type checkers alone are not."""
    try:
        meant = eval(annotation, function.__globals__)
    except NameError:
        return False
    return meant is Any or (get_origin(meant) is None and Any in get_args(meant))


def agree(planar: str, spatial: str) -> bool:
    """Whether two annotations differ in nothing but structs of the plane and of space."""
    return re.sub(r"\bSpatial(?=[A-Z])", "", spatial) in (planar, *planar.split(" | "))


def differences(planar: Callable[..., Any], spatial: Callable[..., Any]) -> list[str]:
    """What a call that serves one of them would get wrong of the other, in words."""
    signatures = [inspect.signature(function) for function in (planar, spatial)]
    ours, theirs = (list(signature.parameters.values()) for signature in signatures)
    if [p.name for p in ours] != [p.name for p in theirs]:
        return [f"{[p.name for p in ours]} in the plane, {[p.name for p in theirs]} in space"]
    found = []
    for a, b in zip(ours, theirs, strict=True):
        if (a.kind, a.default) != (b.kind, b.default):
            found.append(f"{a} in the plane, {b} in space")
        if not (agree(a.annotation, b.annotation) or is_any(a.annotation, planar) or is_any(b.annotation, spatial)):
            found.append(f"{a} in the plane, {b} in space")
    returned = [signature.return_annotation for signature in signatures]
    if not (agree(*returned) or "NoReturn" in returned or all(FLOATS.fullmatch(text) for text in returned)):
        found.append(f"-> {returned[0]} in the plane, -> {returned[1]} in space")
    return found


def test_twins_have_the_same_signature() -> None:
    pairs = twins()
    assert len(pairs) > 80
    told = {name: words for name, pair in pairs.items() if (words := differences(*pair))}
    assert not told


def planar(model: Model, q: FloatArray, k: int = 0) -> tuple[float, float]: ...  # type: ignore  # noqa: F821


def alike(model: SpatialModel, q: FloatArray, k: int = 0) -> tuple[float, float, float]: ...  # type: ignore  # noqa: F821


def of_any(model: Any, q: FloatArray, k: int = 0) -> Vector: ...  # type: ignore  # noqa: F821


def other_order(q: FloatArray, model: SpatialModel, k: int = 0) -> Vector: ...  # type: ignore  # noqa: F821


def other_name(model: SpatialModel, p: FloatArray, k: int = 0) -> Vector: ...  # type: ignore  # noqa: F821


def other_default(model: SpatialModel, q: FloatArray, k: int = 1) -> Vector: ...  # type: ignore  # noqa: F821


def other_type(model: SpatialModel, q: IntArray, k: int = 0) -> Vector: ...  # type: ignore  # noqa: F821


def one_more(model: SpatialModel, q: FloatArray, k: int = 0, t: float = 0.0) -> Vector: ...  # type: ignore  # noqa: F821


def other_result(model: SpatialModel, q: FloatArray, k: int = 0) -> bool: ...  # type: ignore  # noqa: F821


@pytest.mark.parametrize("spatial", [alike, of_any])
def test_what_may_differ(spatial: Callable[..., Any]) -> None:
    assert not differences(planar, spatial)


@pytest.mark.parametrize(
    "spatial", [other_order, other_name, other_default, other_type, one_more, other_result], ids=lambda f: f.__name__
)
def test_mismatches_are_seen(spatial: Callable[..., Any]) -> None:
    assert differences(planar, spatial)
