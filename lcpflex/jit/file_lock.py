"""Locks between processes that end with the process that holds them, however it ends."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from pathlib import Path

__all__ = ["FileLock"]

PAUSE = 0.02, 0.05  # between two tries [s]: the first one and the longest


class FileLock:
    """A lock of the operating system on a file at ``path``: fcntl or msvcrt.

    The system takes it back when the process ends, also by a signal: no lock is ever stale. The file is removed with
    the lock.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._file = -1

    def acquire(self, patience: float, waits: Callable[[float], None] = lambda waited: None) -> bool:
        """Wait up to ``patience`` [s] for the lock; False where another process has it for longer.

        ``waits`` is called between two tries with the time waited so far [s].

        Raises
        ------
        OSError
            Where there can be no lock: a folder that cannot be written to, a full disk, a file system without locks.
        """
        began = time.monotonic()
        pause = PAUSE[0]
        while not self._tried():
            waited = time.monotonic() - began
            if waited >= patience:
                return False
            waits(waited)
            time.sleep(min(pause, patience - waited))
            pause = min(2.0 * pause, PAUSE[1])
        return True

    def release(self) -> None:
        """Give the lock back, and remove its file."""
        if self._file < 0:
            return
        try:
            os.unlink(self._path)  # while it is held: who opened it before finds out that it is gone
        except OSError:  # open files stay on Windows
            pass
        os.close(self._file)
        self._file = -1

    def is_held(self) -> bool:
        """Whether a process has the lock now."""
        if not self._path.exists():
            return False
        free = self._tried()
        self.release()
        return not free

    def _tried(self) -> bool:
        """Whether the lock is held after one try."""
        opened = os.open(self._path, os.O_RDWR | os.O_CREAT, 0o644)
        try:
            held = _locked(opened) and _is_at(opened, self._path)
        except BaseException:
            os.close(opened)
            raise
        if held:
            self._file = opened
        else:
            os.close(opened)
        return held


def _is_at(opened: int, path: Path) -> bool:
    """Whether the open file is still the one at ``path``: it may have been removed before it was locked."""
    try:
        return os.path.samestat(os.fstat(opened), os.stat(path))
    except FileNotFoundError:
        return False


def _locked(opened: int) -> bool:
    """Lock an open file unless another process has it."""
    try:
        import fcntl
    except ImportError:
        return _locked_on_windows(opened)
    try:
        fcntl.flock(opened, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    return True


def _locked_on_windows(opened: int) -> bool:
    import msvcrt

    try:
        msvcrt.locking(opened, msvcrt.LK_NBLCK, 1)  # type: ignore[attr-defined]
    except PermissionError:  # so it says that another process has it
        return False
    return True
