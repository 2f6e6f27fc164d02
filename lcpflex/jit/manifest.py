"""Kernels and argument types that a kind of run is known to compile: a list, shipped with the package.

Numba finds out what a kernel calls, and with which types, while it compiles it. Who wants to compile the second half
of a run's kernels before its first half is done must be told. The list is made by ``tests/record_manifest.py`` from
runs with an empty cache; it names the larger kernels, which bring what they call with them. An entry that no longer
holds, because a kernel or a struct has changed since, costs the time to compile what nobody needs, and nothing else.

The file is JSON. A type is ``int64``, ``float64``, ``bool``, an array as ``float64[:,:]C`` (with r where it is read
only, u where it is not aligned), a tuple as ``tuple(int64,float64)``, or the name of one of ``structs``, which has
named tuples, too: their first field has no name and tells the class. A kernel is ``module:name`` and its types;
``runs`` has them by kind of run, in the order in which they are first done; ``modules`` are those with kernels that
leaves choose from.
"""

from __future__ import annotations

import json
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

import numba

from lcpflex.jit.leaf import dispatcher_of
from lcpflex.jit.struct_type import PackedType, packed_type

__all__ = ["Entry", "Types", "all_entries", "entries_of", "load_modules"]

FILE = Path(__file__).with_name("manifest.json")
NUMBERS = {"int64": numba.types.int64, "float64": numba.types.float64, "bool": numba.types.boolean}


class Entry(NamedTuple):
    """A kernel by module and name, and the types of its arguments."""

    module: str
    name: str
    arguments: tuple[Any, ...]

    def dispatcher(self) -> Any:
        """What compiles it."""
        return dispatcher_of(self.module, self.name)


class Types:
    """Types in words and back.

    Attributes
    ----------
    structs
        Structs in words, by the name that the list has for them: fields and their types, ``name:type``.
    """

    def __init__(self, structs: dict[str, str]) -> None:
        self.structs = structs
        self._names: dict[Any, str] = {}  # of types that were told
        self._made: dict[str, Any] = {}

    def told(self, kind: Any) -> str:
        """A type in words; ``structs`` learns new ones.

        Raises
        ------
        ValueError
            For a type that the list has no words for.
        """
        if isinstance(kind, PackedType):
            return self._named(kind, kind.label, list(kind.fields), "")
        if isinstance(kind, numba.types.BaseNamedTuple):
            made = kind.instance_class
            fields = list(zip(kind.fields, kind, strict=True))
            return self._named(kind, made.__name__, fields, f"{made.__module__}:{made.__qualname__}")
        if isinstance(kind, numba.types.Array):
            marks = ("" if kind.mutable else "r") + ("" if kind.aligned else "u")
            return f"{self.told(kind.dtype)}[{','.join(':' * kind.ndim)}]{kind.layout}{marks}"
        if isinstance(kind, numba.types.BaseTuple):
            return f"tuple({','.join(map(self.told, kind))})"
        if str(kind) not in NUMBERS:
            raise ValueError(str(kind))
        return str(kind)

    def _named(self, kind: Any, label: str, fields: list[tuple[str, Any]], home: str) -> str:
        if kind not in self._names:
            parts = [f":{home}"] * bool(home) + [f"{name}:{self.told(part)}" for name, part in fields]
            same = sum(known.partition("#")[0] == label for known in self.structs)
            self._names[kind] = label if same == 0 else f"{label}#{same + 1}"
            self.structs[self._names[kind]] = " ".join(parts)
        return self._names[kind]

    def made(self, words: str) -> Any:
        """The type that was told so."""
        if words not in self._made:
            self._made[words] = self._make(words)
        return self._made[words]

    def _make(self, words: str) -> Any:
        if words in NUMBERS:
            return NUMBERS[words]
        if words.startswith("tuple("):
            return numba.types.BaseTuple.from_types([self.made(part) for part in _split(words[6:-1])])
        if words.endswith(("C", "F", "A", "r", "u")) and "]" in words:
            number, _, shape = words.partition("[")
            axes, _, marks = shape.partition("]")
            return numba.types.Array(
                NUMBERS[number], axes.count(":"), marks[0], readonly="r" in marks, aligned="u" not in marks
            )
        fields = [(name, part) for name, _, part in (told.partition(":") for told in self.structs[words].split())]
        if fields and not fields[0][0]:
            module, _, name = fields[0][1].partition(":")
            kinds = [self.made(part) for _, part in fields[1:]]
            return numba.types.BaseTuple.from_types(kinds, getattr(import_module(module), name))
        return packed_type(words.partition("#")[0], tuple((name, self.made(part)) for name, part in fields))


def _split(words: str) -> list[str]:
    """The parts of a tuple, which may be tuples."""
    parts, depth = [""], 0
    for letter in words:
        depth += (letter in "([") - (letter in ")]")
        if letter == "," and depth == 0:
            parts.append("")
        else:
            parts[-1] += letter
    return parts


@cache
def _read() -> dict[str, Any]:
    return json.loads(FILE.read_text()) if FILE.is_file() else {"runs": {}, "structs": {}, "modules": []}


@cache
def _types() -> Types:
    return Types(_read()["structs"])


def load_modules() -> None:
    """Load the modules with kernels that leaves choose from (:mod:`lcpflex.jit.leaf`), which else choose others."""
    for module in _read()["modules"]:
        import_module(module)


def entries_of(run: str) -> list[Entry]:
    """The kernels of a kind of run, in the order in which they are first done; none for one that is not listed."""
    return [_entry(words) for words in _read()["runs"].get(run, ())]


def all_entries() -> list[Entry]:
    """Those of all kinds, each once."""
    return [_entry(words) for words in dict.fromkeys(words for run in _read()["runs"].values() for words in run)]


def _entry(words: str) -> Entry:
    place, *kinds = words.split()
    module, _, name = place.partition(":")
    return Entry(module, name, tuple(map(_types().made, kinds)))
