"""The cache of one kernel on disk: read from several folders, kept in one, compiled by one process at a time.

The files are numba's, an index and one file for each combination of argument types. They are marked with the content of
all sources that the kernel depends on, so that an upgrade never runs stale code.
"""

from __future__ import annotations

import os
import sys
import uuid
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from numba.core.caching import FunctionCache, IndexDataCacheFile
from numba.core.compiler import CompileResult

from lcpflex.jit.cache_folders import (
    PATH_VARIABLE,
    cache_folders,
    is_private_file,
    is_safe,
    say_once,
    unsafe,
    writable,
)
from lcpflex.jit.file_lock import FileLock

__all__ = ["KernelCache", "attach", "lost"]

PATIENCE = 600.0  # longest wait for another process that compiles the same kernel [s]
TELL = 2.0  # a wait that is told of [s]

lost: set[str] = set()  # kernels compiled in this process that could not be kept
_waits = True  # until it was in vain once


class KernelFile(IndexDataCacheFile):  # type: ignore[misc]
    """Index and data of a kernel in one folder."""

    def __init__(self, folder: Path, name: str, stamp: str) -> None:
        super().__init__(str(folder), name, stamp)
        self.folder = folder

    def found(self, key: Any) -> Any:
        """What is stored under the key; None where nothing is, or where it is not to be trusted."""
        if not os.path.exists(self._index_path) or not is_safe(self.folder) or not is_private_file(self._index_path):
            return None
        return self.load(key)

    def _load_data(self, name: str) -> Any:
        if not is_private_file(self._data_path(name)):
            return None
        return super()._load_data(name)

    @contextmanager
    def _open_for_write(self, filepath: str) -> Iterator[Any]:
        """A file of this user's alone to write to, that takes its place when it is whole."""
        whole = f"{filepath}.tmp.{uuid.uuid4().hex[:16]}"
        try:
            with os.fdopen(os.open(whole, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o644), "wb") as file:
                yield file
            os.replace(whole, filepath)
        except BaseException:
            try:
                os.unlink(whole)
            except OSError:
                pass
            raise


class KernelCache(FunctionCache):  # type: ignore[misc]
    """What numba asks for a kernel before it compiles it, and gives it afterwards.

    ``stamp`` gives the mark of its sources.
    """

    def __init__(self, function: Callable[..., Any], stamp: Callable[[], str]) -> None:
        self._py_func = function
        self._stamp = stamp
        self._files: list[KernelFile] = []
        self._locks: list[FileLock | None] = []  # of the compilations under way, one in the other
        self.enable()

    @property
    def cache_path(self) -> str | None:
        """The folder that keeps what is compiled here."""
        file = self._keeper()
        return None if file is None else str(file.folder)

    def flush(self) -> None:
        """Forget what the folder that keeps things has."""
        file = self._keeper()
        if file is not None:
            file.flush()

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """The compiled kernel for argument types; None, and a lock for :meth:`leave`, where it is to be compiled."""
        target_context.refresh()
        key = self._index_key(sig, target_context.codegen())
        loaded = self._load(key, target_context)
        if loaded is None:
            self._locks.append(self._lock())
            loaded = self._load(key, target_context)  # by another process in the meantime
            if loaded is None:
                self._announce()
        return loaded

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep a compiled kernel; the run goes on where that cannot be."""
        if data.library.has_dynamic_globals:  # addresses of this process in it
            return
        file = self._keeper()
        try:
            if file is not None:
                file.save(self._index_key(sig, data.codegen), data._reduce())
            else:
                lost.add(self._py_func.__qualname__)
        except OSError as error:
            lost.add(self._py_func.__qualname__)
            say_once(f"compiled kernels are not kept in {file.folder if file else ''}: {error}")

    def leave(self, depth: int) -> None:
        """Give back the locks of compilations that have ended, but for the first ``depth``."""
        while len(self._locks) > depth:
            lock = self._locks.pop()
            if lock is not None:
                lock.release()

    @property
    def depth(self) -> int:
        """Compilations of this kernel under way."""
        return len(self._locks)

    def _places(self) -> list[KernelFile]:
        """Its files in all folders, in the order in which they are read."""
        if not self._files:
            code = self._py_func.__code__
            source = Path(code.co_filename).absolute()
            version = f"py{sys.version_info[0]}{sys.version_info[1]}{getattr(sys, 'abiflags', '')}"
            name = f"{source.stem}.{self._py_func.__qualname__}-{code.co_firstlineno}.{version}"
            stamp = self._stamp()
            self._files = [KernelFile(folder, name, stamp) for folder in cache_folders(source)]
        return self._files

    def _load(self, key: Any, target_context: Any) -> Any:
        """From the first folder that has it."""
        for file in self._places():
            try:
                found = file.found(key)
                if found is not None:
                    return CompileResult._rebuild(target_context, *found)
            except Exception:  # damaged, or types of a module gone since: start it anew
                try:
                    file.flush()
                except OSError:
                    pass
        return None

    def _keeper(self) -> KernelFile | None:
        """Its file in the first folder that can be written to, and will be read."""
        for file in self._places():
            if not writable(file.folder):
                continue
            if not (reason := unsafe(file.folder)):
                return file
            if file.folder.name != "__pycache__":  # which is there anyway
                say_once(f"kernels are not kept in {file.folder}: {reason}")
        return None

    def _lock(self) -> FileLock | None:
        """The lock of this kernel between processes; None where there is none, or no more waiting."""
        global _waits
        file = self._keeper()
        if file is None or not _waits or self._locks:
            return None
        lock = FileLock(Path(file._index_path).with_suffix(".lock"))
        try:
            if lock.acquire(PATIENCE, _tell):
                return lock
        except OSError:  # no locks there: two processes may compile the same
            return None
        _waits = False
        say_once(f"another process has compiled one kernel for {PATIENCE:.0f} s, this one goes on without it")
        return None

    def _announce(self) -> None:
        """Say once what the first call waits for, and whether that was for ever."""
        say_once(
            "compiling its kernels for this machine (once; some tens of seconds, "
            "`lcpflex warmup` does all of them ahead of time) ..."
        )
        if self._keeper() is None:
            tried = ", ".join(str(file.folder) for file in self._places()) or "none"
            say_once(
                f"no folder can keep them, every process compiles anew (tried: {tried}). Set {PATH_VARIABLE} to one "
                "that you can write to, or to one that `lcpflex warmup` has filled"
            )


def attach(dispatcher: Any, function: Callable[..., Any], stamp: Callable[[], str]) -> None:
    """Give a kernel of numba its cache, and have locks given back however a compilation ends."""
    kept = dispatcher._cache = KernelCache(function, stamp)
    plain = dispatcher.compile

    def compiled(sig: Any) -> Any:
        depth = kept.depth
        try:
            return plain(sig)
        finally:
            kept.leave(depth)

    dispatcher.compile = compiled


def _tell(waited: float) -> None:
    if waited > TELL:
        say_once("another process compiles the same kernels: waiting for it ...")
