"""What a compiled kernel is a function of, as one hash: the name of its file on disk, and part of its symbols.

The cache of numba is keyed by the source file of a function alone, so a change in another file that a kernel calls
would go unseen. Here the key holds what numba compiles: the bytecode of a kernel and of all kernels that it reaches,
the values of the constants that these name, the machine, the versions of what compiles, and the types of the arguments.
A file with another key is never looked at; an edit of a kernel changes its key and those of its callers, no others.
"""

from __future__ import annotations

import hashlib
import re
import sys
import types
from collections.abc import Callable, Iterable, Iterator
from enum import EnumType
from functools import cache
from pathlib import Path
from typing import Any

import llvmlite
import numba
import numpy as np

from lcpflex.jit.leaf import Leaf, forget_choices

__all__ = ["LEVELS", "Magic", "content", "derived", "key_of", "machines"]

Magic = tuple[str, str, str]  # triple, name and features of a processor, as numba's codegen tells them

ADDRESS = re.compile(r"\b0x[0-9a-fA-F]+")
PACKAGE = __name__.partition(".")[0]
COMPILERS = __name__.rpartition(".")[0] + "."
SOURCES = sorted(
    Path(__file__).parent.glob("*.py")
)  # how kernels are compiled and linked, what numba is told of structs
COMPILER = hashlib.sha256(b"".join(path.read_bytes() for path in SOURCES)).hexdigest()  # now, before an edit

# Of a function's flags: numba clears all others to show a kernel to a profiler, and those of __future__ are no code.
KEPT_FLAGS = 0xFFFE

# Processors that kernels are shipped for, and the features that code for them needs, the better one first.
V2 = {"cx16", "popcnt", "sahf", "sse3", "sse4.1", "sse4.2", "ssse3"}
V3 = V2 | {"avx", "avx2", "bmi", "bmi2", "f16c", "fma", "lzcnt", "movbe", "xsave"}
LEVELS: dict[str, set[str]] = {"x86-64-v3": V3, "x86-64": set()}


class NotKnownError(Exception):
    """A kernel depends on something that two processes cannot compare."""


def key_of(function: Callable[..., Any], arguments: Iterable[Any], result: Any, magic: Magic, limit: int) -> str | None:
    """The key of a function of the package for types of its arguments (and of what it returns, None if inferred).

    ``limit``: instructions of the largest callee that is linked in; -1 where all are.

    None for what is not to be kept: functions of others, closures, and what holds addresses of this process.
    """
    if not _is_own(function) or "<locals>" in function.__qualname__:
        return None
    arguments = tuple(arguments)
    try:
        told = [*map(_told, arguments), str(result)]
        structs = frozenset(label for kind in arguments for label in _structs(kind))
        return derived(*_environment(), limit, *magic, content(function, structs), *told)
    except NotKnownError:
        return None


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
        COMPILER,
        numba.__version__,
        llvmlite.__version__,
        np.__version__.split(".")[0],  # its rules for types
        sys.implementation.cache_tag,
        getattr(sys, "abiflags", ""),
        *(str(getattr(config, name, "")) for name in ("OPT", "BOUNDSCHECK", "LOOP_VECTORIZE", "SLP_VECTORIZE")),
        *(str(getattr(config, name, "")) for name in ("DEBUGINFO_DEFAULT", "LLVM_REFPRUNE_PASS")),
    )


def _told(kind: Any) -> object:
    """An argument type in words; numba's name of a named tuple is without its fields."""
    if isinstance(kind, numba.types.BaseTuple):
        return _meaning(getattr(kind, "instance_class", tuple)), *map(_told, kind)
    if ADDRESS.search(str(kind)):
        raise NotKnownError(str(kind))
    return str(kind)


def _structs(kind: Any) -> Iterator[str]:
    """Names of the structs in an argument type: by them leaves choose their kernels."""
    if label := getattr(kind, "label", ""):
        yield label
        for _, part in kind.fields:
            yield from _structs(part)


@cache
def content(function: Callable[..., Any], structs: frozenset[str] = frozenset()) -> str:
    """Hash of a kernel's code and of all that it reaches: kernels, and values of other names of their modules.

    ``structs``: names of those in the arguments.

    Raises
    ------
    NotKnownError
        Where one of these cannot be told in words that hold for every process.
    """
    found: dict[Any, str] = {}
    waiting = [function]
    while waiting:
        reached = waiting.pop()
        if reached not in found:
            found[reached], called = _own(reached, structs)
            waiting += called
    return derived(found[function], *sorted(found.values()))


@cache
def _own(function: Any, structs: frozenset[str]) -> tuple[str, list[Any]]:
    """Hash of a function without what it calls, and that; of leaves, the kernels for such structs."""
    if function.__closure__:
        raise NotKnownError(f"{function.__qualname__} is a closure")
    values: dict[str, object] = {}
    called = []
    for name in sorted(_names(function.__code__)):  # of attributes, too: at worst, the hash holds what does not matter
        if name in function.__globals__:
            value = function.__globals__[name]
            kernels = value.of_kinds(structs) if isinstance(value, Leaf) else {"": value}
            chosen = [kernel for _, kernel in sorted(kernels.items())]
            reached = list(map(_source, chosen))
            if all(map(_is_own, reached)):
                called += [source for source in reached if not source.__module__.startswith(COMPILERS)]
                values[name] = [
                    (_way(kernel), source.__module__, source.__qualname__, _result(source))
                    for kernel, source in zip(chosen, reached, strict=True)
                ]
            else:
                values[name] = _meaning(value)
    place = function.__module__, function.__qualname__, function.__defaults__, function.__kwdefaults__
    return derived(*place, _of_code(function.__code__, function.__doc__), values), called


def _source(value: Any) -> Any:
    """The function that a kernel or an intrinsic was made of; any other value as it is."""
    found = getattr(value, "py_func", None)
    return getattr(value, "_defn", value) if found is None else found


def _way(kernel: Any) -> tuple[bool, bool]:
    """How callers come to a kernel: whether it is compiled late, and whether its code is copied."""
    return getattr(kernel, "late", False), getattr(kernel, "inline", False)


def _result(source: Callable[..., Any]) -> object:
    """What callers of a late kernel know of it."""
    return source.__annotations__.get("return")


def _is_own(value: Any) -> bool:
    """Whether a value is a function of the package."""
    return isinstance(value, types.FunctionType) and value.__module__.partition(".")[0] == PACKAGE


def _meaning(value: Any) -> object:
    """A value that a kernel names, in words that change with what numba makes of it."""
    if isinstance(value, types.ModuleType) and value.__name__.partition(".")[0] != PACKAGE:
        return value.__name__
    if isinstance(value, np.ndarray):
        return value.dtype.str, value.shape, value.strides, value.tobytes()
    if isinstance(value, tuple):
        return type(value).__qualname__, *map(_meaning, value)
    if isinstance(value, EnumType):
        return value.__qualname__, list(map(repr, value))
    if hasattr(value, "_fields"):
        return value.__module__, value.__qualname__, value._fields, value._field_defaults
    told = repr(value)
    if ADDRESS.search(told) or isinstance(value, types.ModuleType):
        raise NotKnownError(told)
    return type(value).__qualname__, told


def _names(code: types.CodeType) -> set[str]:
    inner = (constant for constant in code.co_consts if isinstance(constant, types.CodeType))
    return set(code.co_names).union(*map(_names, inner))


def _of_code(code: types.CodeType, doc: str | None = None) -> str:
    """Hash of the bytecode as this process has it, without lines and ``doc``."""
    constants = [_of_code(value) if isinstance(value, types.CodeType) else value for value in code.co_consts]
    plain = [sorted(map(repr, value)) if isinstance(value, frozenset) else value for value in constants]
    if doc is not None and constants[0] == doc:
        plain = plain[1:]
    names = code.co_names, code.co_varnames, code.co_freevars, code.co_cellvars
    flags = code.co_flags & KEPT_FLAGS
    return derived(code.co_code, code.co_exceptiontable, flags, code.co_argcount, names, plain)


forget_choices += [content.cache_clear, _own.cache_clear]
