"""Compiled kernels between processes: where they are read and kept, whom they are trusted from, and who compiles."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest

from lcpflex.jit import cache as kernel_cache, cache_folders
from lcpflex.jit.cache_folders import cache_folders as folders_of, is_private_file, unsafe
from lcpflex.jit.kernel_file import ENDING, KernelFile

POSIX = pytest.mark.skipif(not hasattr(os, "getuid"), reason="rights of other users are not told by such bits here")

# Asks for the friction of one law and prints it, and which kernels were compiled for it.
JOB = """
import os, signal, sys, time
from numba.core import event

compiled = []

class Count(event.Listener):
    def on_start(self, found):
        compiled.append(found.data["dispatcher"].py_func)
        if os.environ.get("STOP_AT") == compiled[-1].__name__:
            print("stopped", flush=True)
            time.sleep(600.0)
    def on_end(self, found):
        pass

event.register("numba:compile", Count())
import lcpflex as lf
if os.environ.get("FULL"):
    import errno
    import lcpflex.jit.cache as kernel_cache
    def write(*given):
        raise OSError(errno.ENOSPC, "No space left on device")
    kernel_cache.write = write
if os.environ.get("NO_LOCKS"):
    import errno, lcpflex.jit.file_lock as file_lock
    def locked(opened):
        raise OSError(errno.ENOLCK, "No locks available")
    file_lock._locked = locked
if os.environ.get("PATIENCE"):
    import lcpflex.jit.cache as kernel_cache
    kernel_cache.PATIENCE = float(os.environ["PATIENCE"])
if os.environ.get("AS"):
    import numba
    numba.njit(lambda x: x + 1.0)(2.0)  # loads modules that the other user may not be able to read
    compiled.clear()
    os.setgroups([]); os.setgid(int(os.environ["AS"])); os.setuid(int(os.environ["AS"]))
print(lf.laws.SmoothedCoulomb().force(0.5, 1.0, 0.5), flush=True)
print(sum(function.__module__.startswith("lcpflex") for function in compiled), flush=True)
"""
KERNELS = 6  # that the job needs


def started(cache: Path | str, **environment: str) -> subprocess.Popen[str]:
    """A process with the job and these folders for its kernels."""
    given = {**os.environ, "LCPFLEX_CACHE_PATH": str(cache), **environment}
    pipes: dict[str, Any] = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    return subprocess.Popen([sys.executable, "-c", JOB], env=given, **pipes)


def ended(process: subprocess.Popen[str]) -> tuple[int, str]:
    """How many kernels it compiled, and what it said; its answer is right in any case."""
    out, said = process.communicate(timeout=240)
    assert process.returncode == 0, said
    answer, count = out.split()[-2:]
    assert float(answer) == pytest.approx(-0.5)
    return int(count), said


def run(cache: Path | str, **environment: str) -> tuple[int, str]:
    """The job in a process."""
    return ended(started(cache, **environment))


@pytest.fixture(scope="module")
def filled(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the kernels of the job, whose files are not written to."""
    folder = tmp_path_factory.mktemp("filled")
    count, said = run(folder)
    assert count == KERNELS
    assert "compiling its kernels" in said
    assert "no folder" not in said
    return folder


def contents(folder: Path) -> dict[str, bytes]:
    """All files below a folder."""
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def copied(filled: Path, folder: Path) -> Path:
    """The same files in another folder."""
    for name, data in contents(filled).items():
        target = folder / name
        target.parent.mkdir(exist_ok=True, parents=True)
        target.write_bytes(data)
    return folder


def of_one_kernel(folder: Path) -> Path:
    """The file of the kernel that the job calls."""
    (found,) = (
        path
        for path in folder.iterdir()
        if (file := KernelFile.unpacked(path.read_bytes(), path.stem)) and "friction_forces" in file.symbols[0]
        if not file.needs or file.entry
    )
    return found


def test_a_filled_folder_is_read(filled: Path) -> None:
    """Nothing is compiled, said or written; no lock is left."""
    before = contents(filled)
    assert run(filled) == (0, "")
    assert contents(filled) == before
    assert not [name for name in before if not name.endswith(ENDING)]


@pytest.mark.slow
def test_all_folders_are_read_and_the_first_is_written_to(filled: Path, tmp_path: Path) -> None:
    """What one of them misses comes from the next; what all miss goes into the first."""
    part = copied(filled, tmp_path / "part")
    of_one_kernel(part).unlink()
    first = tmp_path / "first"
    assert run(os.pathsep.join(map(str, (first, part))))[0] == 1
    assert len(list(first.iterdir())) == 1
    assert run(os.pathsep.join(map(str, (first, part)))) == (0, "")


@pytest.mark.slow
@POSIX
@pytest.mark.skipif(hasattr(os, "getuid") and os.getuid() != 0, reason="only root can be another user")
def test_another_user_reads_what_root_has_filled(filled: Path, tmp_path: Path) -> None:
    """Of a folder that it cannot write to; without one it says that nothing is kept, and what to do."""
    shared = copied(filled, Path(f"/var/cache/lcpflex-test-{os.getpid()}"))
    try:
        for path in (shared, *shared.rglob("*")):
            path.chmod(0o755 if path.is_dir() else 0o644)
        assert run(shared, AS="65534") == (0, "")
        count, said = run(f"/var/cache/lcpflex-none-{os.getpid()}", AS="65534")
        assert count == KERNELS
        assert said.count("no folder can keep them") == 1
        assert "Set LCPFLEX_CACHE_PATH to one that you can write to" in said
    finally:
        for path in sorted(shared.rglob("*"), reverse=True):
            path.unlink() if path.is_file() else path.rmdir()
        shared.rmdir()


@pytest.mark.slow
@pytest.mark.parametrize("place", ["below a file", "no name at all"])
def test_no_folder_to_keep_kernels_is_said_once(place: str, tmp_path: Path) -> None:
    """The run goes on."""
    (tmp_path / "file").write_text("")
    count, said = run(tmp_path / "file" / "cache" if place == "below a file" else os.pathsep)
    assert count == KERNELS
    assert said.count("no folder can keep them, every process compiles anew") == 1


@pytest.mark.slow
@POSIX
@pytest.mark.parametrize("open_part", ["above", "folder", "file"])
def test_what_others_can_write_to_is_not_read(filled: Path, tmp_path: Path, open_part: str) -> None:
    """It could hold any code; that is said once."""
    folder = copied(filled, tmp_path / "above" / "open")
    own = tmp_path / "own"
    path = {"above": folder.parent, "folder": folder, "file": of_one_kernel(folder)}[open_part]
    path.chmod(path.stat().st_mode | 0o022)
    count, said = run(os.pathsep.join(map(str, (own, folder))))
    assert count == (1 if open_part == "file" else KERNELS)
    assert said.count("are not read: others can write to") == 1
    assert said.count(str(path)) >= 1
    assert run(os.pathsep.join(map(str, (own, folder))))[0] == 0


@POSIX
def test_who_can_write_to_a_folder(tmp_path: Path) -> None:
    """Also those above it; a group counts as others unless it is that of the owner alone."""
    safe = tmp_path / "a" / "b"
    safe.mkdir(parents=True, mode=0o755)
    assert unsafe(safe) == ""
    assert unsafe(tmp_path / "missing") == ""
    for mode, reason in ((0o757, "others can write to"), (0o777, "others can write to"), (0o1777, "")):
        above = tmp_path / f"above{mode:o}"
        below = above / "below"
        below.mkdir(parents=True)
        above.chmod(mode)
        assert unsafe(below).startswith(reason)
        assert bool(unsafe(below)) == bool(reason)
    open_itself = tmp_path / "sticky"
    open_itself.mkdir()
    open_itself.chmod(0o1777)
    assert "others can write" in unsafe(open_itself)  # anybody could put a file there that is missing
    link = tmp_path / "link"
    link.symlink_to(tmp_path / "above777" / "below")
    assert "above777" in unsafe(link)
    loop = tmp_path / "loop"
    loop.symlink_to(loop)
    assert unsafe(loop)


@POSIX
@pytest.mark.skipif(hasattr(os, "getuid") and os.getuid() != 0, reason="only root can give a folder to another user")
def test_a_folder_of_another_user(tmp_path: Path) -> None:
    """May be read, but for one that stands where anybody could have made it."""
    of_other = tmp_path / "other"
    of_other.mkdir(mode=0o755)
    os.chown(of_other, 65534, 65534)
    assert unsafe(of_other) == ""
    planted = tmp_path / "public" / "planted"
    planted.mkdir(parents=True)
    planted.parent.chmod(0o1777)
    os.chown(planted, 65534, 65534)
    assert "belongs to another user" in unsafe(planted)
    of_group = tmp_path / "group"
    of_group.mkdir()
    os.chown(of_group, 65534, 0)
    of_group.chmod(0o775)
    assert "others can write" in unsafe(of_group)


@POSIX
def test_files_by_themselves(tmp_path: Path) -> None:
    """A link counts as what it leads to."""
    file = tmp_path / "file"
    file.write_text("")
    file.chmod(0o644)
    link = tmp_path / "link"
    link.symlink_to(file)
    assert is_private_file(str(file))
    assert is_private_file(str(link))
    assert not is_private_file(str(tmp_path / "missing"))
    other = tmp_path / "other"
    other.write_text("")
    other.chmod(0o666)
    link.unlink()
    (tmp_path / "second").symlink_to(other)
    assert not is_private_file(str(other))
    assert not is_private_file(str(tmp_path / "second"))


def test_systems_without_such_rights(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Nothing is refused there."""
    folder = tmp_path / "any"
    folder.mkdir()
    folder.chmod(0o777)
    monkeypatch.delattr(os, "getuid", raising=False)
    assert unsafe(folder) == ""
    assert is_private_file(str(folder))


def test_the_order_of_folders(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Those that are named alone; else numba's, of the package, of the system where there is one, of the user."""
    package = Path(kernel_cache.__file__).parents[1]
    one, other = tmp_path / "one", tmp_path / "other"
    monkeypatch.setenv("LCPFLEX_CACHE_PATH", os.pathsep.join(map(str, (one, "", other))))
    assert folders_of() == [one, other]
    monkeypatch.setenv("LCPFLEX_CACHE_PATH", "")
    monkeypatch.setattr("numba.core.config.CACHE_DIR", str(one))
    monkeypatch.setattr(cache_folders, "_of_system", lambda: other)
    assert folders_of()[:2] == [one / "lcpflex", package / "__pycache__" / "kernels"]
    assert other not in folders_of()
    other.mkdir()
    assert folders_of()[2] == other
    monkeypatch.setattr("numba.core.config.CACHE_DIR", "")
    assert folders_of()[0] == package / "__pycache__" / "kernels"
    assert "kernels" not in [folder.name for folder in folders_of()[1:]]
    shipped = tmp_path / "kernels"
    monkeypatch.setattr(cache_folders, "SHIPPED", shipped)
    shipped.mkdir()
    assert folders_of()[-1] == shipped
    monkeypatch.setenv("LCPFLEX_CACHE_PATH", str(one))
    assert folders_of() == [one, shipped]
    one.write_text("")  # no folder: nothing is kept, not in what was shipped either
    assert cache_folders.keeper() is None


@pytest.mark.slow
@pytest.mark.parametrize("damage", ["cut", "empty", "other bytes", "gone"])
def test_damaged_files_are_compiled_again(filled: Path, tmp_path: Path, damage: str) -> None:
    """And put right."""
    folder = copied(filled, tmp_path / "damaged")
    path = of_one_kernel(folder)
    data = path.read_bytes()
    path.write_bytes({"cut": data[: len(data) // 2], "empty": b"", "other bytes": data[::-1]}.get(damage, b""))
    if damage == "gone":
        path.unlink()
    assert run(folder)[0] == 1
    assert run(folder) == (0, "")


@pytest.mark.slow
def test_two_processes_compile_each_kernel_once(tmp_path: Path) -> None:
    """The others wait for what one of them compiles, and load it."""
    processes = [started(tmp_path) for _ in range(3)]
    counts = [ended(process)[0] for process in processes]
    assert sum(counts) == KERNELS
    assert not list(tmp_path.rglob("*.lock"))


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="processes are ended in another way")
@pytest.mark.parametrize(("stop", "left"), [("friction_forces", KERNELS), ("sticking", KERNELS - 1)])
def test_a_process_that_is_killed_leaves_its_work_to_the_next(stop: str, left: int, tmp_path: Path) -> None:
    """It takes over at once what was not finished, and loads what was."""
    first = started(tmp_path, STOP_AT=stop)
    assert first.stdout is not None
    assert first.stdout.readline() == "stopped\n"
    second = started(tmp_path)
    deadline = time.monotonic() + 240.0  # of a busy machine
    while not second_waits(second) and time.monotonic() < deadline:
        time.sleep(0.1)
    assert second.poll() is None
    first.kill()
    first.communicate()
    count, said = ended(second)
    assert count == left
    assert "another process compiles the same kernels: waiting for it" in said
    assert run(tmp_path) == (0, "")


def second_waits(process: subprocess.Popen[str]) -> bool:
    """Whether it has said that it waits; its other words are kept out of the way of ``communicate``."""
    import select

    assert process.stderr is not None
    return bool(select.select([process.stderr], [], [], 0.1)[0])


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="processes are ended in another way")
def test_patience_ends(tmp_path: Path) -> None:
    """Behind a process that hangs, the next one says so and compiles by itself, without waiting again."""
    first = started(tmp_path, STOP_AT="friction_forces")
    try:
        assert first.stdout is not None
        assert first.stdout.readline() == "stopped\n"
        count, said = run(tmp_path, PATIENCE="1.0")
    finally:
        first.kill()
        first.communicate()
    assert count == KERNELS
    assert said.count("this one goes on without it") == 1


@pytest.mark.slow
@pytest.mark.parametrize("trouble", ["NO_LOCKS", "FULL"])
def test_the_run_goes_on_without_locks_or_space(trouble: str, tmp_path: Path) -> None:
    """A full disk is told once."""
    count, said = run(tmp_path, **{trouble: "1"})
    assert count == KERNELS
    assert said.count("No space left on device") == (trouble == "FULL")
    assert run(tmp_path)[0] == (KERNELS if trouble == "FULL" else 0)
    assert not list(tmp_path.rglob("*.tmp.*"))


def test_patience_is_longer_than_any_kernel() -> None:
    """All kernels of a stepper take a minute or two on a slow machine."""
    assert kernel_cache.PATIENCE >= 300.0
