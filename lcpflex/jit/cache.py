"""The cache of one kernel on disk: read from several folders, kept in one, compiled by one process at a time."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

from numba.core.caching import _Cache

from lcpflex.jit import background
from lcpflex.jit.cache_folders import PATH_VARIABLE, cache_folders, keeper, say_once
from lcpflex.jit.file_lock import FileLock
from lcpflex.jit.kernel_file import ENDING, KernelFile, read, thin_out, write
from lcpflex.jit.keys import key_of, machines

__all__ = ["KernelCache", "keep", "lost", "read_anywhere"]

PATIENCE = 600.0  # longest wait for another process that compiles the same kernel [s]
TELL = 2.0  # a wait that is told of [s]

lost: set[str] = set()  # kernels compiled in this process that could not be kept
_waits = True  # until it was in vain once
_thinned = False  # whether the folder was looked at


class KernelCache(_Cache):  # type: ignore[misc]
    """What numba asks for a kernel before it compiles it, and gives it afterwards.

    Parameters
    ----------
    function
        The kernel in Python.
    limit
        Instructions of the largest callee that is linked in; -1 where all are.
    load
        (key, context) -> the kernel as numba has it after compiling, None where it is not to be had.
    file_of
        (key, what numba has compiled) -> its file, None where it is of this process only.
    remark
        What else is said when the first kernel is compiled.
    """

    def __init__(
        self,
        function: Callable[..., Any],
        limit: int,
        load: Callable[[str, Any], Any],
        file_of: Callable[[str, Any], KernelFile | None],
        remark: str = "",
    ) -> None:
        self._py_func = function
        self._limit = limit
        self._of_key = load
        self._file_of = file_of
        self._remark = remark
        self._locks: list[FileLock | None] = []  # of the compilations under way, one in the other

    @property
    def cache_path(self) -> str | None:
        """The folder that keeps what is compiled here."""
        folder = keeper()
        return None if folder is None else str(folder)

    def enable(self) -> None:
        """It always is."""

    def disable(self) -> None:
        """It always is enabled."""

    def flush(self) -> None:
        """Nothing is read twice."""

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """The compiled kernel for argument types; None, and a lock for :meth:`leave`, where it is to be compiled."""
        keys = list(self._keys(sig, target_context.codegen()))
        loaded = self._load(keys, target_context)
        if loaded is None:
            target_context.refresh()  # a tenth of a second; files may refer to symbols that come with it
            loaded = self._load(keys, target_context)
        if loaded is None:
            background.assist()
            self._locks.append(self._lock(keys))
            loaded = self._load(keys, target_context)  # by another process in the meantime
            if loaded is None:
                _announce()
                if self._remark:
                    say_once(self._remark)
        return loaded

    def is_missing(self, arguments: tuple[Any, ...]) -> bool:
        """Whether no folder has the kernel for argument types, one can keep it, and no process is at it."""
        from numba.core.registry import cpu_target

        folder, keys = keeper(), list(self._keys(arguments, cpu_target.target_context.codegen()))
        if folder is None or not keys:
            return False
        if any((known / (key + ENDING)).exists() for key in keys for known in cache_folders()):
            return False
        return not FileLock(folder / f"{keys[0]}.lock").is_held()

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep a compiled kernel; the run goes on where that cannot be."""
        for key in self._keys(sig, data.codegen):
            file = self._file_of(key, data)
            if file is not None and not keep(file):
                lost.add(self._py_func.__qualname__)
            return

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

    def _keys(self, sig: Any, codegen: Any) -> Iterator[str]:
        """For this machine, and for those that it has all features of."""
        from numba.core.sigutils import normalize_signature

        arguments, result = normalize_signature(sig)
        for magic in machines(codegen.magic_tuple()):
            key = key_of(self._py_func, arguments, result, magic, self._limit)
            if key is not None:
                yield key

    def _load(self, keys: list[str], target_context: Any) -> Any:
        for key in keys:
            try:
                found = self._of_key(key, target_context)
            except Exception:  # types of a module that is gone since: compiled anew
                continue
            if found is not None:
                return found
        return None

    def _lock(self, keys: list[str]) -> FileLock | None:
        """The lock of this kernel between processes; None where there is none, or no more waiting."""
        global _waits
        folder = keeper()
        if folder is None or not keys or not _waits or self._locks:
            return None
        lock = FileLock(folder / f"{keys[0]}.lock")
        try:
            if lock.acquire(PATIENCE, _tell):
                return lock
        except OSError:  # no locks there: two processes may compile the same
            return None
        _waits = False
        say_once(f"another process has compiled one kernel for {PATIENCE:.0f} s, this one goes on without it")
        return None


def read_anywhere(key: str) -> KernelFile | None:
    """The file of a key from the first folder that has it."""
    return read(key, cache_folders())


def keep(file: KernelFile) -> bool:
    """Write a kernel into the folder that keeps them; False where that cannot be, which is said."""
    global _thinned
    folder = keeper()
    if folder is None:
        return False
    try:
        with background.writing:
            write(file, folder)
        if not _thinned:
            _thinned = True
            thin_out(folder)
    except OSError as error:
        say_once(f"compiled kernels are not kept in {folder}: {error}")
        return False
    return True


def _announce() -> None:
    """Say once what the first call waits for, and whether that was for ever."""
    say_once(
        "compiling its kernels for this machine (once; half a minute, "
        "`lcpflex warmup` does all of them ahead of time) ..."
    )
    if keeper() is None:
        tried = ", ".join(map(str, cache_folders())) or "none"
        say_once(
            f"no folder can keep them, every process compiles anew (tried: {tried}). Set {PATH_VARIABLE} to one "
            "that you can write to, or to one that `lcpflex warmup` has filled"
        )


def _tell(waited: float) -> None:
    if waited > TELL:
        say_once("another process compiles the same kernels: waiting for it ...")
