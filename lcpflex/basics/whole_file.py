"""Files that are written beside their final name and put in its place when they are whole."""

from __future__ import annotations

import csv
import os
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from lcpflex.errors import ModelError, writable_path

__all__ = ["whole_file", "write_rows"]


@contextmanager
def whole_file(name: str, path: Any) -> Iterator[Path]:
    """A path to write to, in the folder of ``path`` and with its ending; at the end it takes the place of ``path``.

    All of it or nothing: where the disk is full, or the block raises, an older file is as it was, and no half-written
    one is left. What was written has reached the disk before it is renamed. A file that is not written at all is no
    error, and changes nothing.

    Raises
    ------
    ModelError
        For a path that cannot be written to, naming the argument ``name``, the path and the reason.
    """
    target = writable_path(name, path)
    part = target.with_name(f".{target.stem}.{os.getpid()}.part{target.suffix}")
    try:
        try:
            yield part
            if part.exists():
                _to_disk(part)
                part.replace(target)
                with suppress(OSError):  # folders cannot be opened everywhere
                    _to_disk(target.parent)
        except BaseException:
            part.unlink(missing_ok=True)
            raise
    except OSError as error:
        raise ModelError(f"{name}: cannot write {str(target)!r}: {error.strerror or error}") from error


def write_rows(path: Any, rows: Iterable[Iterable[Any]], line_end: str = "\r\n") -> Path:
    """Write rows to a CSV file, all of it or nothing. Raises ModelError where it cannot be written."""
    target = writable_path("path", path)
    with whole_file("path", target) as part, part.open("w", newline="", encoding="utf-8") as file:
        csv.writer(file, lineterminator=line_end).writerows(rows)
    return target


def _to_disk(path: Path) -> None:
    """Wait until what was written is on the disk."""
    handle = os.open(path, os.O_RDONLY if path.is_dir() else os.O_RDWR)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
