"""What tells a run from another one: versions, scene and stepper, as a checkpoint holds them and compares them."""

from __future__ import annotations

import hashlib
import re
import sys
import types
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace
from functools import cache, partial
from importlib import metadata
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from lcpflex.basics.version import VERSION
from lcpflex.model.recovery import small_enough
from lcpflex.runs.object_tree import Arrays, Unkept, freeze
from lcpflex.scene.sensors.user_function import Function
from lcpflex.scene.user_system import UserSystem

if TYPE_CHECKING:
    from lcpflex.compile.compiled_scene import CompiledScene
    from lcpflex.runs.setup import Setup, Stepper
__all__ = ["described", "difference", "functions_of", "made", "same_arrays", "stepper_node"]

ROUNDING = 1e-9  # of the largest entry: arrays of one scene, reduced twice, may differ by so much
OWN_NUMBERS = ("q", "u", "friction", "restitution", "tangential_restitution", "names", "stiffness", "damping")


def described(setup: Setup, arrays: Arrays) -> dict[str, Any]:
    """The part of the structure of a checkpoint that does not change while the run goes on."""
    scene, missing = scene_node(setup.source, arrays)
    stepper, lacks = stepper_node(setup.stepper, arrays)
    return {
        "made": made(),
        "options": freeze(setup.options, "options", arrays),
        "scene": scene,
        "stepper": stepper,
        "missing": {what: why for what, why in (("scene", missing), ("stepper", lacks)) if why},
        "stamp": {"stepper": plain(repr(setup.stepper)), "functions": functions_of(setup.source)},
    }


def made() -> dict[str, str]:
    """Versions that the bits of a run depend on; those of lcpflex first."""
    versions = {name: metadata.version(name) for name in ("numpy", "scipy", "numba")}
    python = ".".join(map(str, sys.version_info[:2]))
    return {"lcpflex": VERSION, "sources": _sources(), **versions, "python": python}


@cache
def _sources() -> str:
    """Hash of the sources of the package."""
    home = Path(__file__).resolve().parents[1]
    digest = hashlib.sha256()
    for path in sorted([*home.rglob("*.py"), *(home / "solvers").rglob("*.py")]):
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def scene_node(source: CompiledScene | UserSystem, arrays: Arrays) -> tuple[Any, str]:
    """The scene as data, but for its functions; and why it has to be given again, empty where it has not."""
    if isinstance(source, UserSystem):
        numbers = {name: getattr(source, name) for name in OWN_NUMBERS}
        return freeze(numbers, "scene", arrays), "a UserSystem is made of Python functions, which no file can hold"
    why = ""
    if source.callbacks or source.functions:
        names = ", ".join(sorted({function.name for function in (*source.callbacks, *source.functions)}))
        why = f"the scene has Python functions ({names:.80}), which no file can hold"
    laws = source.laws
    try:
        freeze(laws, "scene.laws", {})
    except Unkept:
        laws = ()
        why = why or "a force law of the scene holds a Python function, which no file can hold"
    sensors = source.sensors
    if any(isinstance(sensor, Function) for sensor in sensors):
        sensors = ()
        why = why or "a sensor of the scene is a Python function, which no file can hold"
    recovery = small_enough(source.recovery)
    kept = replace(source, callbacks=(), functions=(), materials=None, laws=laws, recovery=recovery, sensors=sensors)
    return freeze(kept, "scene", arrays), why


def stepper_node(stepper: Stepper, arrays: Arrays) -> tuple[Any, str]:
    """The stepper as data, and why it has to be given again: then null."""
    own: Arrays = {}
    try:
        node = freeze(stepper, "stepper", own)
    except Unkept as error:
        return None, f"{error}, which no file can hold"
    arrays.update(own)
    return node, ""


def functions_of(source: CompiledScene | UserSystem) -> dict[str, str]:
    """The code of the functions of a scene, as hashes, by what they are called."""
    if isinstance(source, UserSystem):
        named = {name: getattr(source, name) for name in type(source).__dataclass_fields__ if not name.startswith("_")}
        return {name: code_of(value) for name, value in named.items() if callable(value)} | _sensors(source)
    functions = (*source.callbacks, *source.functions)
    found = {f"{k}: {function.name}": code_of(function.function) for k, function in enumerate(functions)}
    laws = {f"law {k}": plain(repr(law)) for k, law in enumerate(source.laws) if law is not None}
    return found | laws | _sensors(source)


def _sensors(source: CompiledScene | UserSystem) -> dict[str, str]:
    """What tells the sensors of a scene from others."""
    code = {one.name: code_of(one.function) for one in source.sensors if isinstance(one, Function)}
    return {f"sensor {one.name!r}": plain(f"{one!r} {code.get(one.name, '')}") for one in source.sensors}


def code_of(function: Any) -> str:
    """A text that is the same for the same function: its code and the numbers that it holds."""
    digest = hashlib.sha256()
    _digest(function, digest, 0)
    return digest.hexdigest()[:16]


def _digest(value: Any, digest: Any, depth: int) -> None:
    """Add what is told apart of ``value``; of objects of other kinds, only their class."""
    value = getattr(value, "py_func", getattr(value, "__wrapped__", value))
    if isinstance(value, types.CodeType):
        digest.update(value.co_code + repr(value.co_names).encode())
        for constant in value.co_consts:
            _digest(constant, digest, depth + 1)
    elif isinstance(value, types.FunctionType) and depth < 8:
        cells = value.__closure__ or ()
        for part in (value.__code__, *(value.__defaults__ or ()), *cells):
            _digest(part, digest, depth + 1)
    elif isinstance(value, types.CellType):
        with suppress(ValueError):  # empty
            _digest(value.cell_contents, digest, depth)
    elif isinstance(value, partial) and depth < 8:
        for part in (value.func, *value.args, *sorted(value.keywords.items())):
            _digest(part, digest, depth + 1)
    elif isinstance(value, tuple | list) and depth < 8:
        for part in value:
            _digest(part, digest, depth + 1)
    elif isinstance(value, np.ndarray) and not value.dtype.hasobject:
        digest.update(np.ascontiguousarray(value).tobytes())
    elif value is None or isinstance(value, bool | int | float | complex | str | bytes | np.generic):
        digest.update(repr(value).encode())
    else:
        inner = getattr(value, "function", None)  # a Function of lcpflex
        if callable(inner) and depth < 8:
            _digest(inner, digest, depth + 1)
        digest.update(type(value).__qualname__.encode())


def plain(text: str) -> str:
    """A text without the addresses of objects."""
    return re.sub(r" at 0x[0-9a-fA-F]+", "", text)


def difference(ours: Any, theirs: Any, arrays: Mapping[str, Any], others: Mapping[str, Any], name: str) -> str:
    """Name of the first entry in which two nodes differ, their arrays by more than rounding; empty: in none."""
    if isinstance(ours, dict) and isinstance(theirs, dict):
        if "array" in ours and "array" in theirs:
            same = same_arrays(arrays[ours["array"]], others[theirs["array"]])
            return "" if same or name.endswith(".address") else name
        if ours.keys() != theirs.keys():
            return name
        inner = ((key, ours[key], theirs[key]) for key in ours)
    elif isinstance(ours, list) and isinstance(theirs, list):
        if len(ours) != len(theirs):
            return name
        inner = ((k, a, b) for k, (a, b) in enumerate(zip(ours, theirs, strict=True)))
    else:
        numbers = all(isinstance(one, float) for one in (ours, theirs))
        return "" if (same_arrays(np.array(ours), np.array(theirs)) if numbers else ours == theirs) else name
    for key, a, b in inner:
        called = name if key in ("fields", "tuple", "list", "map") else f"{name}.{key}"
        if found := difference(a, b, arrays, others, called):
            return found
    return ""


def same_arrays(a: Any, b: Any) -> bool:
    """Whether two arrays are the same up to rounding."""
    if a.shape != b.shape or a.dtype != b.dtype:
        return False
    if a.dtype.kind not in "fc":
        return bool((a == b).all())
    if not a.size or np.array_equal(a, b, equal_nan=True):
        return True
    largest = np.abs(a[np.isfinite(a)]).max(initial=0.0)
    return bool(np.allclose(a, b, rtol=0.0, atol=ROUNDING * largest, equal_nan=True))
