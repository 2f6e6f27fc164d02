"""A second process that compiles while the first one does, the later half of a list of kernels.

Numba compiles one kernel at a time in a process, whatever threads it has. Where another core is free, the first kernel
of a run that is missing starts a second process, which takes the list for this kind of run
(:mod:`lcpflex.jit.manifest`) from its middle on and puts what it compiles into the folder of kernels. The first
process goes on as without it, and finds there what is done, or waits for what is under way. Both make the same files,
bit for bit, and a process that dies leaves none that is not whole: the other one compiles what is missing.
"""

from __future__ import annotations

import atexit
import json
import os
import subprocess
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from threading import RLock, Thread
from typing import TYPE_CHECKING, Any

from lcpflex.jit.cache_folders import cache_folders, keeper, say_once, use_only
from lcpflex.jit.file_lock import FileLock
from lcpflex.jit.private import why_not_thin

if TYPE_CHECKING:
    from lcpflex.jit.manifest import Entry

__all__ = ["VARIABLE", "assist", "compile_all_listed", "expecting", "writing"]

VARIABLE = "LCPFLEX_COMPILERS"  # processes that compile for one: 1, or 2 whatever else the machine does
START = (
    "import json, sys; job = json.loads(sys.argv[1]); sys.path[:] = job['path']; "
    "from lcpflex.jit.background import serve; serve(job)"
)
FREE = 0.75  # of a core, by the load of the last minute: the process that asks has used part of one itself
WORTH = 0.25  # of a list must be missing: a process takes a second to begin, a list half a minute to compile
PATIENCE = 10.0  # for the end of a process that was told to end [s]

writing = RLock()  # held while a file is written: the process does not end there
_expected = ""  # the kind of run under way
_started: list[subprocess.Popen[bytes]] = []


@contextmanager
def expecting(run: str) -> Iterator[None]:
    """Within, kernels are compiled for a run of this kind: the list that a second process would take."""
    global _expected
    before, _expected = _expected, run
    for process in _started:
        if process.poll() is not None and process.stdin is not None:
            process.stdin.close()
    try:
        yield
    finally:
        _expected = before


def assist() -> None:
    """Start the second process if a run is under way, its kernels are missing, and a core is free; once."""
    global _expected
    run, _expected = _expected, ""
    if run and not _started and _may_start():
        entries = _entries(run)
        if sum(map(_is_missing, entries)) > WORTH * len(entries):
            _start(run)


def _entries(run: str, to_compile: bool = False) -> list[Entry]:
    """The list for a kind of run, for all kinds if it is empty; none where it no longer fits the code."""
    from lcpflex.jit.manifest import all_entries, entries_of, load_modules

    try:
        if to_compile:
            load_modules()
        return entries_of(run) if run else all_entries()
    except Exception:  # a file that is damaged, a class that has gone: all is compiled as without it
        return []


def compile_all_listed(bar: Callable[[list[Entry]], Iterable[Entry]]) -> None:
    """Compile the kernels of all lists that are missing, in two processes where that can be.

    ``bar``: shows how far it has come.
    """
    missing = list(filter(_is_missing, _entries("", to_compile=True)))
    second = _start("") if missing and _may_start() else None
    _compile(bar(missing))
    if second is not None:
        second.wait()  # for the last one, which it has begun


def _compile(entries: Iterable[Entry]) -> None:
    """Compile kernels that are not there by then, nor under way; entries that no longer hold are passed over."""
    for entry in entries:
        if _is_missing(entry):
            try:
                entry.dispatcher().compile(entry.arguments)
            except Exception:
                continue


def _is_missing(entry: Entry) -> bool:
    """Whether no folder has a kernel, and no process is at it; not of an entry that no longer holds."""
    try:
        return bool(entry.dispatcher()._cache.is_missing(entry.arguments))
    except Exception:  # a kernel that is gone, other versions of numba
        return False


def _may_start() -> bool:
    """Whether a second process is wanted, and has a core of its own."""
    wish = os.environ.get(VARIABLE, "").strip()
    if wish not in ("", "1", "2"):
        say_once(f"{VARIABLE} is {wish!r}, expected 1 or 2: no second process")
    is_python = Path(sys.executable or "").stem.lower().startswith(("python", "pypy"))  # not a program with one inside
    if wish not in ("", "2") or not is_python or os.name == "nt" or why_not_thin():  # on Windows it was not tried
        return False
    if wish == "2":
        return True
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    load = os.getloadavg()[0] if hasattr(os, "getloadavg") else 0.0
    return cores >= 2 and cores - load >= FREE


def _start(run: str) -> subprocess.Popen[bytes] | None:
    """A process that compiles the kernels of a kind of run, of all kinds if it is empty; None where there can be none.

    It ends by itself, and with this process.
    """
    path = [entry for entry in sys.path if isinstance(entry, str)]
    job = {"path": path, "run": run, "folders": list(map(str, cache_folders()))}
    flags = ["-" + "O" * sys.flags.optimize] if sys.flags.optimize else []
    try:
        process = subprocess.Popen(
            [sys.executable, "-P", *flags, "-c", START, json.dumps(job)],  # -P: nothing from the folder it is in
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            env={**os.environ, VARIABLE: "1"},
            start_new_session=True,  # Ctrl-C is for the first process
        )
    except (OSError, ValueError):
        return None
    if not _started:
        atexit.register(_end)
        os.register_at_fork(after_in_child=_forget)
    _started.append(process)
    say_once(f"a second process compiles on another core ({VARIABLE}=1: none)")
    return process


def _forget() -> None:
    """In a fork of this process: the pipe is not its own, and would stay open with it."""
    for process in _started:
        if process.stdin is not None:
            process.stdin.close()


def _end() -> None:
    """End the second process with this one."""
    for process in _started:
        if process.stdin is not None:
            process.stdin.close()
        try:
            process.wait(PATIENCE)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
    _started.clear()


def serve(job: dict[str, Any]) -> None:
    """What the second process does: it ends when the first one has, or when the list is done."""
    Thread(target=_watch, args=(sys.stdin.fileno(),), daemon=True).start()
    if job["folders"] != list(map(str, cache_folders())):
        use_only(Path(job["folders"][0]))
    folder = keeper()
    if folder is None:
        return
    alone = FileLock(folder / "second.lock")
    if alone.acquire(0.0):  # one is enough for all that share a folder, and a pool of processes its cores
        entries = _entries(job["run"], to_compile=True)
        middle = len(entries) // 2  # the last ones call nearly all others
        _compile([*entries[middle:], *reversed(entries[:middle])])
        alone.release()


def _watch(pipe: int) -> None:
    """Wait until the first process closes the pipe, as its end does; then end, but not within a file."""
    while os.read(pipe, 1):
        pass
    with writing:
        os._exit(0)
