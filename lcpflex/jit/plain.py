"""Kernels linked as numba does, for versions of numba that thin linking was not written for; with the same cache."""

from __future__ import annotations

import pickle
from collections.abc import Callable
from typing import Any

from numba.core.compiler import CompileResult
from numba.core.serialize import dumps

from lcpflex.jit.cache import KernelCache, read_anywhere
from lcpflex.jit.kernel_file import KernelFile

__all__ = ["attach"]

ALL = -1  # callees are linked in


def attach(dispatcher: Any, function: Callable[..., Any], reason: str) -> None:
    """Give a kernel of numba its cache, and have locks given back however a compilation ends.

    ``reason``: why it is not linked thinly, said at the first one that is compiled.
    """
    kept = dispatcher._cache = KernelCache(function, ALL, _load, _file_of, f"{reason}: compiling takes longer")
    plain = dispatcher.compile

    def compiled(sig: Any) -> Any:
        depth = kept.depth
        try:
            return plain(sig)
        finally:
            kept.leave(depth)

    dispatcher.compile = compiled


def _load(key: str, context: Any) -> Any:
    file = read_anywhere(key)
    return None if file is None else CompileResult._rebuild(context, *pickle.loads(file.entry))


def _file_of(key: str, result: Any) -> KernelFile | None:
    if result.library.has_dynamic_globals:  # addresses of this process in it
        return None
    return KernelFile(key, False, (), {}, {}, (), (), b"", dumps(result._reduce()))
