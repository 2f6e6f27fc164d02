"""Objects as named arrays and plain JSON, and back: what a checkpoint holds of a run, its scene and its stepper.

Nothing is pickled, and no function is kept. A node of the JSON is a number, a text, true, false or null, or one of

    {"array": name}                    the array of that name, read-only with "fixed": true; {"scalar": name}
    {"packed": label, "fields": {}}    a named tuple of arrays that kernels take
    {"object": class, "fields": {}}    an object of lcpflex (or an integrator of SciPy) with its attributes
    {"values": class, "fields": {}}    a named tuple
    {"tuple": []}, {"list": []}, {"set": []}, {"map": [[key, value]]}, {"hooks": []}, {"member": class, "name": name},
    {"class": name}                    one of a few classes
    {"same": name}                     what has stood under that name before: aliases stay aliases
    {"live": true}                     what is not kept, as it is where the rest is put back: functions, the scene
"""

from __future__ import annotations

import re
import types
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from enum import Enum
from importlib import import_module
from typing import Any

import numpy as np
import numpy.typing as npt

from lcpflex.jit.struct import Packed, parts_of, with_parts

__all__ = ["Arrays", "Unkept", "freeze", "thaw"]

Arrays = dict[str, npt.NDArray[Any]]

MODULES = re.compile(r"lcpflex(\.(?!_)\w+)+|scipy\.integrate\._ivp\.(radau|bdf)")  # of objects that are kept
CLASSES = {"Radau": "scipy.integrate", "BDF": "scipy.integrate"}
# of packed tuples: addresses of functions and the pulse of this process, and laws, which follow from the scene
CONSTANT = {"kinds", "parameters", "address", "beats"}
# objects that belong to the scene or to the user: they are as the scene makes them again
LIVE = {"System", "Model", "CompiledFunction", "OwnFunction", "LawRow", "Support"}
FUNCTIONS = (types.FunctionType, types.MethodType, types.BuiltinFunctionType, types.MethodWrapperType)


class Unkept(TypeError):
    """A value that is no data, such as a function, where all must be data."""


def freeze(value: Any, name: str, arrays: Arrays, known: dict[int, str] | None = None) -> Any:
    """The JSON node of ``value``, whose arrays go into ``arrays`` under names that begin with ``name``.

    known: names of what has been frozen already, by identity; what is of the scene or of the user is then left out.
    None: all must be data, and Unkept is raised for what is not.
    """
    if isinstance(value, Enum):
        return {"member": _class_name(type(value), name), "name": value.name}
    if value is None or (isinstance(value, bool | int | float | str) and not isinstance(value, np.generic)):
        return value
    if known is not None:
        if _is_live(value):
            return {"live": True}
        if id(value) in known and not isinstance(value, tuple):
            return {"same": known[id(value)]}
        known[id(value)] = name
    elif isinstance(value, FUNCTIONS) or hasattr(value, "py_func"):
        raise Unkept(f"{name} is a function")
    return _freeze_whole(value, name, arrays, known)


def _freeze_whole(value: Any, name: str, arrays: Arrays, known: dict[int, str] | None) -> Any:
    """What ``freeze`` does for all that is made of parts."""

    def part(which: object, item: Any) -> Any:
        return freeze(item, f"{name}.{which}", arrays, known)

    if isinstance(value, np.ndarray | np.generic):
        if value.dtype.hasobject:
            raise Unkept(f"{name} is an array of objects")
        arrays[name] = np.asarray(_once(value) if isinstance(value, np.ndarray) else value)
        if not isinstance(value, np.ndarray):
            return {"scalar": name}
        return {"array": name} if value.flags.writeable else {"array": name, "fixed": True}
    if isinstance(value, Packed):
        kept = {field: item for field, item in parts_of(value).items() if field not in CONSTANT}
        return {"packed": value._label, "fields": {field: part(field, item) for field, item in kept.items()}}
    if isinstance(value, tuple) and hasattr(value, "_fields"):
        return {
            "values": _class_name(type(value), name),
            "fields": {field: part(field, getattr(value, field)) for field in value._fields},
        }
    for kind, key in ((tuple, "tuple"), (list, "list")):
        if isinstance(value, kind):
            return {key: [part(k, item) for k, item in enumerate(value)]}
    if isinstance(value, set | frozenset):
        return {"set": [part(k, item) for k, item in enumerate(sorted(value))]}
    if isinstance(value, Mapping):
        if any(callable(key) for key in value):
            return {"hooks": [part(k, item) for k, item in enumerate(value.values())]}
        return {"map": [[part(f"{k}.key", key), part(k, item)] for k, (key, item) in enumerate(value.items())]}
    if isinstance(value, type):
        if CLASSES.get(value.__name__) is None:
            raise Unkept(f"{name} is the class {value.__name__}")
        return {"class": value.__name__}
    return {
        "object": _class_name(type(value), name),
        "fields": {field: part(field, getattr(value, field)) for field in _attributes(value)},
    }


def _is_live(value: Any) -> bool:
    """Whether a value is of the scene or of the user, and not of the run."""
    if isinstance(value, FUNCTIONS) or hasattr(value, "py_func") or isinstance(value, type):
        return True
    if isinstance(value, Packed):
        return value._label in LIVE
    return type(value).__name__ in LIVE or hasattr(value, "solve") or hasattr(value, "complaint")


def _attributes(value: Any) -> list[str]:
    """Names of what an object holds."""
    if hasattr(value, "__dict__"):
        return list(vars(value))
    if is_dataclass(value):
        return [field.name for field in fields(value)]
    return [name for kind in type(value).__mro__ for name in getattr(kind, "__slots__", ()) if hasattr(value, name)]


def _class_name(kind: type, name: str) -> str:
    if not MODULES.fullmatch(kind.__module__):
        raise Unkept(f"{name} is a {kind.__module__}.{kind.__name__}")
    return f"{kind.__module__}:{kind.__name__}"


def _class(name: str) -> type:
    """The class of that name; ValueError for any that is not of lcpflex."""
    module, _, kind = name.partition(":")
    found = getattr(import_module(module), kind, None) if MODULES.fullmatch(module) else None
    if not isinstance(found, type) or found.__module__ != module:
        raise ValueError(f"no class {name!r}")
    return found


def _once(array: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """The array without what repeats itself, as a row of one number does: its strides there are 0."""
    if not array.size or all(array.strides):
        return array
    return array[tuple(slice(None) if stride else slice(0, 1) for stride in array.strides)]


def thaw(node: Any, arrays: Mapping[str, npt.NDArray[Any]], live: Any, name: str, made: dict[str, Any]) -> Any:
    """What ``freeze`` has made ``node`` of; where ``live`` is of its kind it takes over the content, and is returned.

    made: what has been thawed already, by name. Raises ValueError, KeyError, TypeError or AttributeError where node or
    arrays are not what ``freeze`` writes, or do not fit to ``live``.
    """
    if not isinstance(node, dict):
        return node
    if "same" in node:
        return made[node["same"]]
    if "live" in node:
        return live
    result = _thaw_whole(node, arrays, live, name, made)
    made[name] = result
    return result


def _thaw_whole(
    node: dict[str, Any], arrays: Mapping[str, npt.NDArray[Any]], live: Any, name: str, made: dict[str, Any]
) -> Any:
    def part(which: object, item: Any, beside: Any = None) -> Any:
        return thaw(item, arrays, beside, f"{name}.{which}", made)

    if "scalar" in node:
        return arrays[node["scalar"]][()]
    if "array" in node:
        array = _array(arrays[node["array"]], live)
        if node.get("fixed"):
            array.setflags(write=False)  # kernels are compiled anew for what may be written
        return array
    if "packed" in node:
        return _packed(node["fields"], live, part)
    if "values" in node:
        return _class(node["values"])(**{field: part(field, item) for field, item in node["fields"].items()})
    if "tuple" in node:
        beside = live if isinstance(live, tuple) and len(live) == len(node["tuple"]) else [None] * len(node["tuple"])
        return tuple(part(k, item, beside[k]) for k, item in enumerate(node["tuple"]))
    if "list" in node:
        beside = live if isinstance(live, list) else []
        found = [part(k, item, beside[k] if k < len(beside) else None) for k, item in enumerate(node["list"])]
        if isinstance(live, list):
            live[:] = found
        return live if isinstance(live, list) else found
    if "set" in node:
        return {part(k, item) for k, item in enumerate(node["set"])}
    if "hooks" in node:
        values = list(live.values())
        if len(values) != len(node["hooks"]):
            raise ValueError(f"{name}: {len(node['hooks'])} functions, and {len(values)} now")
        for k, item in enumerate(node["hooks"]):
            part(k, item, values[k])
        return live
    if "map" in node:
        return {part(f"{k}.key", key): part(k, item) for k, (key, item) in enumerate(node["map"])}
    if "member" in node:
        return _class(node["member"])[node["name"]]  # type: ignore[index]
    if "class" in node:
        return getattr(import_module(CLASSES[node["class"]]), node["class"])
    return _object(node, live, name, made, part)


def _array(stored: npt.NDArray[Any], live: Any) -> npt.NDArray[Any]:
    """``live`` with the stored content where that fits, else the stored one."""
    if not isinstance(live, np.ndarray):
        return stored
    if live.dtype != stored.dtype or live.ndim != stored.ndim:
        raise ValueError(f"an array of {stored.dtype} {stored.shape}, where one of {live.dtype} {live.shape} is")
    if live.flags.writeable and _once(live).shape == stored.shape:
        _once(live)[...] = stored
        return live
    if not all(live.strides) and live.size:
        raise ValueError(f"an array of shape {stored.shape}, where one of shape {live.shape} is")
    return stored


def _packed(kept: dict[str, Any], live: Any, part: Any) -> Any:
    """``live`` with the content of ``kept``; another struct where one of its arrays is of another size."""
    if not isinstance(live, Packed):
        raise ValueError("a struct, where none is")
    found = {field: part(field, item, getattr(live, field)) for field, item in kept.items()}
    for field, value in found.items():
        if isinstance(value, int | float):
            setattr(live, field, value)
    if all(getattr(live, field) is value or isinstance(value, int | float) for field, value in found.items()):
        return live
    return with_parts(live, found)


def _object(node: dict[str, Any], live: Any, name: str, made: dict[str, Any], part: Any) -> Any:
    kind = _class(node["object"])
    fits = type(live) is kind
    target = live if fits else object.__new__(kind)
    made[name] = target  # its parts may hold it
    if fits and set(_attributes(live)) != set(node["fields"]):
        raise ValueError(f"{kind.__name__} holds {sorted(node['fields'])}, expected {sorted(_attributes(live))}")
    for field, item in node["fields"].items():
        if isinstance(item, dict) and "live" in item and not fits:
            raise ValueError(f"{kind.__name__}.{field} is not kept")
        object.__setattr__(target, field, part(field, item, getattr(live, field) if fits else None))
    return target
