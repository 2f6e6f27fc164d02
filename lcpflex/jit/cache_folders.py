"""Where compiled kernels are looked for and kept: several folders, in order.

All of them are read, the first one that can be written to keeps what is compiled here:

1. those of ``LCPFLEX_CACHE_PATH``, separated as those of ``PATH``; where it is set, only 6 is read beside them;
2. ``NUMBA_CACHE_DIR``;
3. ``__pycache__`` of the package, as an installation for several users or an image of a container has it;
4. a folder of the system, where there is one: ``/var/cache/lcpflex``, or ``lcpflex`` in ``%PROGRAMDATA%``;
5. the folder of caches of the user;
6. ``kernels`` in the package, where it was shipped with some: never written to.

What is read is unpickled, which can run any code. So a folder is not read that others than its owner, root and this
user can write to, or could replace.
"""

from __future__ import annotations

import os
import stat
import sys
import tempfile
from collections.abc import Iterator
from functools import cache
from pathlib import Path

__all__ = [
    "PATH_VARIABLE",
    "SHIPPED",
    "cache_folders",
    "is_private_file",
    "is_safe",
    "keeper",
    "say_once",
    "unsafe",
    "use_only",
    "writable",
]

PATH_VARIABLE = "LCPFLEX_CACHE_PATH"
PACKAGE = Path(__file__).resolve().parents[1]
SHIPPED = PACKAGE / "kernels"
OF_OTHERS = stat.S_IWGRP | stat.S_IWOTH

_said: set[str] = set()
_only: list[Path] = []


def say_once(text: str) -> None:
    """Say something on stderr, once per process."""
    if text not in _said:
        _said.add(text)
        print(f"lcpflex: {text}", file=sys.stderr, flush=True)


def cache_folders() -> list[Path]:
    """The folders that are read, in order, whether they exist or not."""
    return _only or [*_own_folders(), *([SHIPPED] if SHIPPED.is_dir() else [])]


def use_only(folder: Path) -> None:
    """Read and keep kernels in this folder alone, from now on in this process."""
    _only[:] = [folder]


def keeper() -> Path | None:
    """The first folder that can be written to and will be read; None where there is none."""
    for folder in _only or _own_folders():
        if not writable(folder):
            continue
        if not (reason := unsafe(folder)):
            return folder
        if folder.parent.name != "__pycache__":  # which is there anyway
            say_once(f"kernels are not kept in {folder}: {reason}")
    return None


def _own_folders() -> Iterator[Path]:
    """Those that kernels may be kept in."""
    named = os.environ.get(PATH_VARIABLE, "")
    if named:
        yield from (Path(name).expanduser().absolute() for name in named.split(os.pathsep) if name)
        return
    from numba.core import config
    from numba.misc.appdirs import AppDirs

    if config.CACHE_DIR:
        yield Path(config.CACHE_DIR).absolute() / "lcpflex"
    yield PACKAGE / "__pycache__" / "kernels"
    system = _of_system()
    if system.is_dir():
        yield system
    of_user = Path(AppDirs(appname="numba", appauthor=False).user_cache_dir)
    if of_user.is_absolute():  # it begins with ~ for users without a home
        yield of_user / "lcpflex"


def _of_system() -> Path:
    return Path(os.environ.get("PROGRAMDATA", "C:/ProgramData") if os.name == "nt" else "/var/cache") / "lcpflex"


@cache
def writable(folder: Path) -> bool:
    """Whether files can be made in the folder, which is made itself if need be, for nobody else to write to."""
    try:
        _make(folder)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError:
        return False
    return True


def _make(folder: Path) -> None:
    """The folder and those above it, as far as they are missing."""
    if not folder.is_dir():
        _make(folder.parent)
        try:
            folder.mkdir(mode=0o755)
        except FileExistsError:  # by another process
            pass


def is_safe(folder: Path) -> bool:
    """Whether files of the folder may be unpickled; it is said if not."""
    if reason := unsafe(folder):
        say_once(f"kernels in {folder} are not read: {reason}")
    return not reason


@cache
def unsafe(path: Path) -> str:
    """Why a file or folder may not be trusted, in words; empty if it may, or does not exist.

    Nobody but its owner, root and this user can write to it, nor to a folder above it: who can could put another one in
    its place. Folders that are open to all but where only owners rename things (sticky, as ``/tmp``) may be above it;
    what is in them belongs to root or this user.
    """
    if not hasattr(os, "getuid"):  # access is no matter of such bits
        return ""
    try:
        real = path.resolve()
        chain = [*reversed(real.parents), real]
        shared = False  # whether anybody can make things in the folder above
        for part in chain:
            found = part.stat()
            if shared and found.st_uid not in (0, os.getuid()):
                return f"{part} belongs to another user, in a folder that is open to all"
            shared = part != real and bool(found.st_mode & stat.S_ISVTX) and bool(found.st_mode & OF_OTHERS)
            if not shared and _open_to_others(found):
                return f"others can write to {part}"
    except FileNotFoundError:
        return ""
    except (OSError, RuntimeError) as error:  # not to be looked at, or links in a loop
        return str(error)
    return ""


def is_private_file(path: str) -> bool:
    """Whether nobody but its owner, root and this user can write to a file of a folder that is safe; said if not."""
    try:
        found = os.lstat(path)
    except OSError:
        return False
    if not hasattr(os, "getuid"):
        return True
    if stat.S_ISLNK(found.st_mode):
        reason = unsafe(Path(path))
    else:
        reason = f"others can write to {path}" if _open_to_others(found) else ""
    if reason:
        say_once(f"kernels in {path} are not read: {reason}")
    return not reason


def _open_to_others(found: os.stat_result) -> bool:
    """Whether others than the owner, root and this user can write."""
    if found.st_mode & stat.S_IWOTH:
        return True
    return bool(found.st_mode & stat.S_IWGRP) and not _is_private(found.st_gid, found.st_uid)


@cache
def _is_private(group: int, owner: int) -> bool:
    """Whether a group is that of this owner alone, by its name: each user has such a one on many systems."""
    try:
        import grp
        import pwd

        found, name = grp.getgrgid(group), pwd.getpwuid(owner).pw_name
    except (ImportError, KeyError):
        return False
    return found.gr_name == name and set(found.gr_mem) <= {name, "root"}
