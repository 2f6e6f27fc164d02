"""Values that hardly any argument takes, each made anew for every call."""

from __future__ import annotations

import datetime
from collections.abc import Callable
from decimal import Decimal
from pathlib import Path
from typing import Any

import numpy as np

import lcpflex as lf

__all__ = ["FILES", "NUMBERS", "WRONG", "write_files"]


class Unshowable:
    """An object that cannot even be shown."""

    def __repr__(self) -> str:
        raise RuntimeError("no repr")

    def __float__(self) -> float:
        raise RuntimeError("no float")

    def __array__(self, *args: Any, **kwargs: Any) -> Any:
        raise RuntimeError("no array")


def _other_scene() -> Any:
    scene = lf.Scene()
    return scene.add(lf.Box(0.1, 0.2, mass=1.0), name="stranger")


def _masked(values: Any) -> Any:
    return np.ma.array(values, mask=np.ones(np.shape(values), dtype=bool))


# What is of the right type, but may be out of the range that an argument has.
NUMBERS: dict[str, Callable[[], Any]] = {
    "nan": lambda: float("nan"),
    "inf": lambda: float("inf"),
    "-inf": lambda: float("-inf"),
    "-1": lambda: -1.0,
    "zero": lambda: 0,
    "1e300": lambda: 1e300,
    "1e20": lambda: 1e20,
    "denormal": lambda: 1e-320,
    "2.5": lambda: 2.5,
    "float32": lambda: np.float32(0.5),
    "10^12": lambda: 10**12,
}

# What is of a type that almost nothing takes.
WRONG: dict[str, Callable[[], Any]] = {
    "none": lambda: None,
    "10^400": lambda: 10**400,
    "10^5000": lambda: 10**5000,
    "decimal nan": lambda: Decimal("nan"),
    "true": lambda: True,
    "complex": lambda: 1.0 + 2.0j,
    "real complex": lambda: np.complex128(1.0),
    "text": lambda: "1.0",
    "word": lambda: "ceter",
    "empty text": lambda: "",
    "long text": lambda: "x" * 5000,
    "null byte": lambda: "a\0b",
    "bytes": lambda: b"1.0",
    "datetime": lambda: datetime.datetime(2020, 1, 1),
    "numpy date": lambda: np.datetime64("2020-01-01"),
    "numpy duration": lambda: np.timedelta64(5, "s"),
    "empty list": list,
    "list of nan": lambda: [float("nan"), 1.0],
    "list of texts": lambda: ["1", "2"],
    "list of word": lambda: ["x"],
    "ragged": lambda: [[1.0], [1.0, 2.0]],
    "nested": lambda: [[[1.0, 2.0]]],
    "huge numbers": lambda: [10**400, 1],
    "three": lambda: [1.0, 2.0, 3.0],
    "array": lambda: np.arange(5.0),
    "one element": lambda: np.array([1.0]),
    "masked": lambda: _masked([1.0, 2.0]),
    "masked number": lambda: np.ma.masked,
    "masked matrix": lambda: _masked(np.eye(2)),
    "complex array": lambda: np.array([1.0 + 0j, 2.0]),
    "complex matrix": lambda: np.eye(2) * (1 + 1j),
    "object array": lambda: np.array([1.0, None], dtype=object),
    "bool array": lambda: np.array([True, False]),
    "date array": lambda: np.array(["2020-01-01", "2020-01-02"], dtype="datetime64[D]"),
    "text array": lambda: np.array(["1", "2"]),
    "record array": lambda: np.zeros(2, dtype=[("a", float), ("b", int)]),
    "endless array": lambda: np.broadcast_to(1.0, (10**6, 10**6)),
    "inf matrix": lambda: np.full((2, 2), np.inf),
    "no rows": lambda: np.zeros((0, 2)),
    "dict": lambda: {"a": 1},
    "empty dict": dict,
    "odd dict": lambda: {1: 2},
    "set": lambda: {1.0, 2.0},
    "generator": lambda: (x for x in (1.0, 2.0)),
    "long range": lambda: range(10**12),
    "function": lambda: lambda: 1.0,
    "raising function": lambda: _raising,
    "class": lambda: lf.MoreauJean,
    "object": object,
    "unshowable": Unshowable,
    "module": lambda: np,
    "stranger": _other_scene,
    "strange point": lambda: _other_scene().point("center"),
    "strange surface": lambda: _other_scene().surface(),
    "scene": lf.Scene,
    "body": lambda: lf.Disc(0.1, mass=1.0),
    "stepper": lambda: lf.MoreauJean(step=1e-3),
}


def _raising(*args: Any, **kwargs: Any) -> Any:
    raise ZeroDivisionError("in a function of the user")


FILES: dict[str, bytes] = {
    "empty": b"",
    "noise": bytes(range(256)) * 8,
    "zip header": b"PK\x03\x04" + b"\0" * 100,
    "npy header": b"\x93NUMPY\x01\x00v\x00{'descr': '<f8', 'fortran_order': False, 'shape': (1000000000000,), }"
    + b" " * 40,
    "text": b"2\n1 2\n3 x\n",
    "large size": b"99999999999\n1 2\n",
    "hdf5 header": b"\x89HDF\r\n\x1a\n" + b"\xff" * 200,
    "latin": "2\n1 2 é\n".encode("latin-1"),
}


def write_files(folder: Path) -> dict[str, Path]:
    """Damaged files, a folder in the place of one, one that is missing, and one that claims a size without end."""
    found = {}
    for name, content in FILES.items():
        found[name] = folder / f"{name.replace(' ', '_')}.bin"
        found[name].write_bytes(content)
    hollow = folder / "hollow.bin"
    with hollow.open("wb") as file:
        file.truncate(2**40)  # takes no room on the disk
    (folder / "folder.bin").mkdir()
    return {**found, "hollow": hollow, "folder": folder / "folder.bin", "missing": folder / "missing.bin"}
