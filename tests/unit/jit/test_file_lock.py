"""Locks between processes."""

from __future__ import annotations

import errno
from pathlib import Path

import pytest

from lcpflex.jit.file_lock import FileLock


class TestFileLock:
    """Within one process, where the lock of one file excludes that of the same file opened again."""

    def test_one_at_a_time(self, tmp_path: Path) -> None:
        """And the file goes with the lock."""
        one, other = FileLock(tmp_path / "lock"), FileLock(tmp_path / "lock")
        told: list[float] = []
        assert one.acquire(0.0)
        assert not other.acquire(0.1, told.append)
        assert told == sorted(told)
        assert told
        one.release()
        one.release()
        assert not (tmp_path / "lock").exists()
        assert other.acquire(0.0)
        other.release()

    def test_a_file_that_was_removed_is_no_lock(self, tmp_path: Path) -> None:
        """Who has opened it before its holder removed it takes the new one instead."""
        one, other = FileLock(tmp_path / "lock"), FileLock(tmp_path / "lock")
        assert one.acquire(0.0)
        (tmp_path / "lock").unlink()
        assert other.acquire(0.0)
        assert FileLock(tmp_path / "lock").acquire(0.0) is False
        other.release()

    def test_no_folder(self, tmp_path: Path) -> None:
        """Is an error of the system."""
        with pytest.raises(OSError) as told:  # noqa: PT011
            FileLock(tmp_path / "none" / "lock").acquire(0.0)
        assert told.value.errno == errno.ENOENT
