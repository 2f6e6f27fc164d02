"""Results on disk: one npz or HDF5 file, readable by any program that reads these, never unpickled.

Every array of the result stands in the file under its dotted name: ``times``, ``q``, ``energies.kinetic``,
``contact_points.place``, ``compiled.model.bodies.mass``. All else is in the entry ``structure``, a JSON text in which

    {"array": name}                    is the array of that name in the file,
    {"tuple": [...]}                   a tuple,
    {"map": [[key, value], ...]}       a mapping,
    {"value": class, "fields": {...}}  a frozen value of lcpflex by the name of its class, such as ``Layout``,

and numbers, texts, true, false and null are themselves. The entry ``format`` holds "lcpflex result 2". Files of the
first format named the modules of the classes, too (``scene.Layout``), as they were then; they are read as well.

In HDF5 (paths that end in .h5 or .hdf5) these entries are data sets of the root, the two texts as bytes of UTF-8. Each
has a check sum, as entries of npz have, so that a damaged file is refused.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from importlib import import_module
from pathlib import Path
from typing import IO, Any

import numpy as np
import numpy.typing as npt

from lcpflex.basics.alarm import Alarm
from lcpflex.basics.archives import load_arrays, save_arrays
from lcpflex.basics.hdf5 import array_of, opened, put_array, whole_hdf5
from lcpflex.basics.whole_file import whole_file
from lcpflex.errors import ModelError, path_of, shown
from lcpflex.model.spatial import SpatialPoints, material_points
from lcpflex.results.first_format import CHANGED

__all__ = ["read", "write"]

RENAMED = {  # classes and fields, as older files name them
    "Compiled": "CompiledScene", "ContactSpots": "ContactPoints", "by_law": "compliant", "spots": "contact_points",
    "slave_start": "node_start", "slave_point": "node_point", "slave_radius": "node_radius",
    "slave_normal": "node_normal", "slave_span": "node_span", "pass_slave": "pass_node",
    "feature_reach": "feature_depth", "surface_sway": "surface_deflection",
}  # fmt: skip
GONE = ("place_error", "speed_error")  # fields of older files that results no longer have
EXPECTED = "expected a result saved by Result.save"
FORMAT = "lcpflex result 2"
READ = ("lcpflex result 1", FORMAT)
HDF5, FOR_OTHERS = (".h5", ".hdf5"), (".vtkhdf",)  # endings
SIGNATURE = b"\x89HDF\r\n\x1a\n"
_HOMES = (  # of the value classes that a file may name
    "lcpflex.results.result", "lcpflex.results.sensor", "lcpflex.results.measured_error", "lcpflex.basics.alarm",
    "lcpflex.results.run_choice",
    "lcpflex.results.contact_history", "lcpflex.results.energy_balance",
    "lcpflex.compile.compiled_scene", "lcpflex.model.arrays", "lcpflex.model.recovery", "lcpflex.model.spatial",
    "lcpflex.bodies.spatial.shapes",
)  # fmt: skip

Arrays = dict[str, npt.NDArray[Any]]


def write(value: object, path: str | os.PathLike[str]) -> Path:
    """Write a frozen value of lcpflex to ``path``, all of it or nothing.

    The file is written beside its final name and then put in its place, so that a full disk leaves an older file
    untouched and no half-written one. Raises ModelError with the path and the reason.
    """
    target, arrays = path_of("path", path), Arrays()
    structure = json.dumps(_encode(value, "", arrays))
    if target.suffix.lower() in FOR_OTHERS:
        raise ModelError(
            f"path: {str(target)!r} was given, expected the ending .npz, .h5 or .hdf5: no result is read "
            "back from a file for ParaView"
        )
    if target.suffix.lower() in HDF5:
        with whole_hdf5("path", target, f"path: {str(target)!r}: an HDF5 file needs") as file:
            for name, text in (("format", FORMAT), ("structure", structure)):
                put_array(file, name, np.frombuffer(text.encode(), dtype=np.uint8))
            for name, array in arrays.items():
                put_array(file, name, array)
        return Path(path)
    with whole_file("path", target) as part, part.open("wb") as file:
        save_arrays(file, {"format": np.array(FORMAT), "structure": np.array(structure), **arrays})
    return Path(path)


def read(path: str | os.PathLike[str]) -> Any:
    """Read back what :func:`write` wrote. Raises ModelError with the path and the reason."""
    target = path_of("path", path)
    try:
        with target.open("rb") as file:
            return _read_hdf5(target) if file.read(len(SIGNATURE)) == SIGNATURE else _read_npz(target, file)
    except ModelError:
        raise
    except OSError as error:
        words = f"cannot read {str(target)!r}: {error.strerror or error}"
        raise ModelError(f"path: {words}, {EXPECTED}") from error
    except Exception as error:  # whatever zipfile, its codecs, h5py, numpy and json stumble over
        raise ModelError(f"path: {str(target)!r} is no complete result of lcpflex ({error}), {EXPECTED}") from error


def _read_npz(target: Path, stream: IO[bytes]) -> Any:
    with load_arrays(stream) as file:
        _check_format(target, str(file["format"]) if "format" in file else None)
        return _decode(json.loads(str(file["structure"])), file)


def _read_hdf5(target: Path) -> Any:
    with opened(f"path: {str(target)!r}: an HDF5 file needs", target) as file:
        text = {name: bytes(array_of(file, name)).decode() for name in ("format", "structure") if name in file}
        _check_format(target, text.get("format"))
        return _decode(json.loads(text["structure"]), _Stored(file))


def _check_format(target: Path, found: str | None) -> None:
    if found not in READ:
        held = "no such entry" if found is None else found
        raise ModelError(f"path: {str(target)!r} has the format {shown(held)}; expected {FORMAT!r}")


class _Stored(dict[str, npt.NDArray[Any]]):
    """The arrays of an open HDF5 file by name, each read when it is asked for."""

    def __init__(self, file: Any) -> None:
        super().__init__()
        self._file = file

    def __missing__(self, name: str) -> npt.NDArray[Any]:
        return array_of(self._file, name)


def _field_names(value: object) -> tuple[str, ...] | None:
    """Names of the fields of a dataclass or NamedTuple, or None for anything else."""
    if is_dataclass(value):
        return tuple(field.name for field in fields(value))
    return getattr(value, "_fields", None)


def _encode(value: Any, path: str, arrays: Arrays) -> Any:
    if value is None or (isinstance(value, bool | int | float | str) and not isinstance(value, Alarm)):
        return value
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, np.ndarray) and not value.dtype.hasobject:
        path = next((name for name, other in arrays.items() if other is value), path)  # times of sensors of one rate
        arrays[path] = value
        return {"array": path}
    prefix = f"{path}." if path else ""
    names = _field_names(value)
    if names is not None:
        kept = {name: _encode(getattr(value, name), prefix + name, arrays) for name in names}
        return {"value": _class_name(type(value), path), "fields": kept}
    if isinstance(value, tuple | list):
        return {"tuple": [_encode(item, f"{prefix}{k}", arrays) for k, item in enumerate(value)]}
    if isinstance(value, Mapping):
        pairs = enumerate(value.items())
        return {
            "map": [[_encode(k, f"{prefix}{i}", arrays), _encode(v, f"{prefix}{i}", arrays)] for i, (k, v) in pairs]
        }
    raise ModelError(
        f"{path}: a {type(value).__name__} cannot be saved; expected numbers, texts, arrays or values of these"
    )


def _class_name(kind: type, path: str) -> str:
    if kind.__module__ not in _HOMES:
        raise ModelError(f"{path}: a {kind.__name__} cannot be saved; expected a value class of {', '.join(_HOMES)}")
    return kind.__name__


def _class(name: str) -> Any:
    """The value class of that name; ValueError for anything else."""
    for home in _HOMES:
        kind = getattr(import_module(home), name, None)
        if isinstance(kind, type) and kind.__module__ == home and (is_dataclass(kind) or hasattr(kind, "_fields")):
            return kind
    raise ValueError(f"no value class {name!r}")


def _decode(node: Any, arrays: Mapping[str, npt.NDArray[Any]]) -> Any:
    if not isinstance(node, dict):
        return node
    if "array" in node:
        array = arrays[node["array"]]
        array.setflags(write=False)
        return array
    if "tuple" in node:
        return tuple(_decode(item, arrays) for item in node["tuple"])
    if "map" in node:
        return {_decode(key, arrays): _decode(value, arrays) for key, value in node["map"]}
    present = ((key, value) for key, value in node["fields"].items() if key not in GONE)
    fields = {RENAMED.get(key, key): _decode(value, arrays) for key, value in present}
    module, _, name = node["value"].rpartition(".")
    if module not in ("", "result", "energy", "scene", "model"):
        raise ValueError(f"no value class {node['value']!r}")
    value = _class(RENAMED.get(name, name))(**CHANGED.get(node["value"], dict)(fields))
    return material_points(*value) if isinstance(value, SpatialPoints) else value  # of the type that kernels take
