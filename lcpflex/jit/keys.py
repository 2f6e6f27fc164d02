"""What a compiled kernel is a function of, as one hash: the name of its file on disk, and part of its symbols.

The cache of numba is keyed by the source file of a function alone, so a change in another file that a kernel calls
would go unseen. Here the key holds that file and all that it imports from the package, the machine, the versions of
what compiles, and the types of the arguments. A file with another key is never looked at.
"""

from __future__ import annotations

import hashlib
import re
import sys
import time
import types
from collections.abc import Callable, Iterable, Iterator
from functools import cache
from pathlib import Path
from typing import Any

import llvmlite
import numba
import numpy as np

__all__ = ["LEVELS", "Magic", "derived", "key_of", "machines", "source_of", "sources_of"]

Magic = tuple[str, str, str]  # triple, name and features of a processor, as numba's codegen tells them

FORMAT = 1  # one more for each change here, in the format of the files and in what is compiled
LOWERING = ("struct.py", "struct_type.py")  # what numba is told of arguments is part of every kernel
STARTED = time.time()
ADDRESS = re.compile(r"\b0x[0-9a-fA-F]+")
IMPORT = re.compile(r"^\s*from (lcpflex[\w.]*) import (\([^)]*\)|[^\n]*)", re.MULTILINE)

# Processors that kernels are shipped for, and the features that code for them needs, the better one first.
V2 = {"cx16", "popcnt", "sahf", "sse3", "sse4.1", "sse4.2", "ssse3"}
V3 = V2 | {"avx", "avx2", "bmi", "bmi2", "f16c", "fma", "lzcnt", "movbe", "xsave"}
LEVELS: dict[str, set[str]] = {"x86-64-v3": V3, "x86-64": set()}


class ChangedSourceError(Exception):
    """A source was written to after this process had imported it."""


def key_of(function: Callable[..., Any], arguments: Iterable[Any], result: Any, magic: Magic, limit: int) -> str | None:
    """The key of a function of the package for types of its arguments (and of what it returns, None if inferred).

    ``limit``: instructions of the largest callee that is linked in; -1 where all are.

    None for what is not to be kept: functions of others, closures, types that hold addresses of this process, and
    sources that have changed since they were imported.
    """
    source = source_of(function)
    names = [*map(str, arguments), str(result)]
    if source is None or any(map(ADDRESS.search, names)):
        return None
    try:
        stamp = _stamp(source), _version()
    except (OSError, ChangedSourceError):
        return None
    code = function.__code__
    place = function.__module__, function.__qualname__, code.co_firstlineno, _of_code(code)
    return derived(*_environment(), limit, *magic, stamp, *place, *names)


def derived(*parts: object) -> str:
    """A key that is a function of other words and numbers."""
    return hashlib.sha256(repr(parts).encode()).hexdigest()


def machines(magic: Magic) -> Iterator[Magic]:
    """The processors whose kernels may run on this one: itself, and those of which it has all features."""
    yield magic
    triple, _, features = magic
    present = {name[1:] for name in features.split(",") if name.startswith("+")}
    if triple.startswith("x86_64"):
        yield from ((triple, level, "") for level, needed in LEVELS.items() if needed <= present)


def _environment() -> tuple[object, ...]:
    """What every kernel depends on beside its source, its types and its machine."""
    from numba.core import config

    return (
        FORMAT,
        numba.__version__,
        llvmlite.__version__,
        np.__version__.split(".")[0],  # its rules for types
        sys.implementation.cache_tag,
        getattr(sys, "abiflags", ""),
        *(str(getattr(config, name, "")) for name in ("OPT", "BOUNDSCHECK", "LOOP_VECTORIZE", "SLP_VECTORIZE")),
        *(str(getattr(config, name, "")) for name in ("DEBUGINFO_DEFAULT", "LLVM_REFPRUNE_PASS")),
        *(_digest(Path(__file__).with_name(name)) for name in LOWERING),
    )


def source_of(function: Callable[..., Any]) -> Path | None:
    """The file of a function of the package, found by its module: ``lcpflex/solvers`` is a link. None for others."""
    package, *names = function.__module__.split(".")
    if package != "lcpflex" or not names or function.__closure__ or "<locals>" in function.__qualname__:
        return None
    for place in _places(names):
        source = place.with_suffix(".py")
        try:  # who names its module like one of the package is still none
            if source.samefile(function.__code__.co_filename):
                return source
        except OSError:
            pass
    return None


def _places(names: list[str]) -> list[Path]:
    """Where a module of the package may be."""
    return [Path(root).joinpath(*names) for root in sys.modules["lcpflex"].__path__]


@cache
def _stamp(path: Path) -> str:
    """Hash of all the sources that a kernel in the file at ``path`` can depend on."""
    return derived(*(_digest(source) for source in sorted(sources_of(path))))


def sources_of(path: Path) -> set[Path]:
    """The files that a kernel in the one at ``path`` can depend on."""
    sources: set[Path] = set()
    waiting = [path]
    while waiting:
        source = waiting.pop()
        if source not in sources:
            sources.add(source)
            waiting.extend(_imports(source))
    return sources


@cache
def _version() -> str:
    """Hash of all sources of the package with kernels or structs.

    Files of one version of the package do not meet those of another: runs that took some of their kernels from a folder
    which an earlier version had filled have ended in a crash, though each file was right by its own sources.
    """
    roots = [Path(root) for root in sys.modules["lcpflex"].__path__]
    places = sorted({*(s for root in roots for s in root.rglob("*.py")), *(s for r in roots for s in _solvers(r))})
    return derived(*(_digest(source) for source in places if b"lcpflex.jit" in source.read_bytes()))


def _solvers(root: Path) -> list[Path]:
    """Sources behind the link ``lcpflex/solvers``, which a search below ``root`` does not follow."""
    return list((root / "solvers").rglob("*.py"))


@cache
def _digest(path: Path) -> str:
    if STARTED < path.stat().st_mtime <= time.time():
        raise ChangedSourceError(str(path))
    return hashlib.sha256(path.read_bytes()).hexdigest()


@cache
def _imports(path: Path) -> tuple[Path, ...]:
    """The source files of the package that the one at ``path`` names in its imports ``from lcpflex.x import y``."""
    found = []
    for module, names in IMPORT.findall(path.read_text(encoding="utf-8")):
        for place in _places(module.split(".")[1:]):
            found += [place.with_suffix(".py"), place / "__init__.py"]
            found += [place / f"{name}.py" for name in re.findall(r"\w+", names)]
    return tuple(file for file in found if file.is_file())


def _of_code(code: types.CodeType) -> str:
    """Hash of the bytecode as this process has it."""
    constants = [_of_code(value) if isinstance(value, types.CodeType) else value for value in code.co_consts]
    plain = [sorted(map(repr, value)) if isinstance(value, frozenset) else value for value in constants]
    return derived(code.co_code, code.co_names, code.co_varnames, plain)
