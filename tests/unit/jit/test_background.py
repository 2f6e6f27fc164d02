"""A second process that compiles: the same kernels, whoever dies, and how many the demo needs."""

from __future__ import annotations

import json
import os
import pkgutil
import signal
import subprocess
import sys
import time
from importlib import import_module
from pathlib import Path
from typing import Any

import numba
import pytest

import lcpflex
from lcpflex.jit import background, manifest
from lcpflex.jit.kernel_file import ENDING, KernelFile
from lcpflex.jit.private import why_not_thin
from lcpflex.jit.struct import Packed
from lcpflex.jit.struct_type import packed_type

pytestmark = [
    pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="there are no kernels"),
    pytest.mark.skipif(not hasattr(os, "fork"), reason="processes are started in another way"),
]

# The demo's run with an empty cache: its bits, what this process compiled, and how much of the list that is.
RUN = """
import hashlib, json, sys
from lcpflex.jit import background, cache, manifest
compiled, keys = [], set()
save = cache.KernelCache.save_overload
def saved(self, sig, data):
    compiled.append((self._py_func.__qualname__, len(self._py_func.__code__.co_code)))
    keys.add(next(self._keys(sig, data.codegen)))
    print("compiled", len(compiled), *(process.pid for process in background._started), file=sys.stderr, flush=True)
    save(self, sig, data)
cache.KernelCache.save_overload = saved
import lcpflex as lf
from lcpflex import gallery
from numba.core.registry import cpu_target
case = gallery.scenes()["pendulum"]
result = lf.simulate(case.build(), case.duration, case.stepper, progress=False)
bits = hashlib.sha256(b"".join(array.tobytes() for array in (result.times, result.q, result.u, result.force)))
seconds = [process.pid for process in background._started]
codegen = cpu_target.target_context.codegen()
listed = [next(e.dispatcher()._cache._keys(e.arguments, codegen)) for e in manifest.entries_of("plane MoreauJean")]
share = sum(key in keys for key in listed) / len(listed)
print(json.dumps({"bits": bits.hexdigest(), "compiled": compiled, "listed": share, "second": seconds}))
"""
# Measured 250 kernels and 103,274 bytes, 2,300 of them for four columns of a Delassus operator at a time, 1.75 times as
# fast; another tenth is three seconds of everybody's first run, and wants a reason.
KERNELS, BYTES = 255, 105_000


def environment(cache: Path, compilers: str) -> dict[str, str]:
    """Of a process with this folder of kernels and this many compilers."""
    return {**os.environ, "LCPFLEX_CACHE_PATH": str(cache), background.VARIABLE: compilers}


def run(cache: Path, compilers: str) -> dict[str, Any]:
    """The demo's run."""
    shown = subprocess.run(
        [sys.executable, "-c", RUN], env=environment(cache, compilers), capture_output=True, text=True, check=True
    )
    found: dict[str, Any] = json.loads(shown.stdout)
    return found


def whole(cache: Path) -> bool:
    """Whether no file of a folder is damaged."""
    files = list(cache.glob("*" + ENDING))
    return bool(files) and all(KernelFile.unpacked(path.read_bytes(), path.stem) for path in files)


@pytest.fixture(scope="module")
def alone(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """The run in one process, from an empty folder."""
    return run(tmp_path_factory.mktemp("alone"), "1")


@pytest.mark.slow
def test_what_the_demo_compiles(alone: dict[str, Any]) -> None:
    """First use is bytecode: a quarter of a second for a kilobyte, and no kernel but those of this scene."""
    assert alone["second"] == []
    assert 100 < len(alone["compiled"]) <= KERNELS
    assert 40_000 < sum(size for _, size in alone["compiled"]) <= BYTES
    assert alone["listed"] > 0.9, "run tests/record_manifest.py: the list is of other kernels"


@pytest.mark.slow
def test_two_processes_give_the_same_bits(alone: dict[str, Any], tmp_path: Path) -> None:
    both = run(tmp_path, "2")
    assert both["bits"] == alone["bits"]
    assert len(both["second"]) == 1
    assert len(both["compiled"]) < len(alone["compiled"])
    assert whole(tmp_path)
    again = run(tmp_path, "2")
    assert (again["bits"], again["compiled"], again["second"]) == (alone["bits"], [], [])


@pytest.mark.slow
@pytest.mark.parametrize("victim", ["first", "second"])
def test_a_process_that_is_killed_leaves_nothing_wrong(victim: str, alone: dict[str, Any], tmp_path: Path) -> None:
    """The other one goes on, or ends; the next run is as any other."""
    with subprocess.Popen(
        [sys.executable, "-c", RUN],
        env=environment(tmp_path, "2"),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as first:
        second = started_by(first)
        if victim == "first":
            first.kill()
            wait_for_end(second)
        else:
            os.kill(second, signal.SIGKILL)
            told, _ = first.communicate()
            assert json.loads(told)["bits"] == alone["bits"]
    assert whole(tmp_path)
    assert run(tmp_path, "1")["bits"] == alone["bits"]


def started_by(first: subprocess.Popen[str]) -> int:
    """The process that a run has started, when the run has compiled thirty kernels itself."""
    assert first.stderr is not None
    for line in first.stderr:
        if line.startswith("compiled 30 "):
            return int(line.split()[2])
    raise AssertionError("it ended before")


def wait_for_end(process: int) -> None:
    """Wait until a process is gone, or only its exit code is left, which nobody may ask for."""
    state = Path(f"/proc/{process}/stat")
    while True:
        try:
            os.kill(process, 0)
            if state.exists() and state.read_text().rpartition(")")[2].split()[0] == "Z":
                return
        except (ProcessLookupError, FileNotFoundError):
            return
        time.sleep(0.05)


def test_the_second_process_ends_with_the_first(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Its pipe is closed then, however the first one ends."""
    monkeypatch.setenv("LCPFLEX_CACHE_PATH", str(tmp_path))
    started = background._start("plane MoreauJean")
    assert started is not None
    assert started.stdin is not None
    started.stdin.close()
    assert started.wait() == 0
    background._started.remove(started)


@pytest.mark.parametrize(
    ("wish", "cores", "load", "starts"),
    [("1", 8, 0.0, False), ("2", 1, 9.0, True), ("", 1, 0.0, False), ("", 2, 0.3, True), ("", 2, 1.9, False)],
)
def test_where_a_second_process_starts(
    wish: str, cores: int, load: float, starts: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where another core is free, or as one likes."""
    monkeypatch.setenv(background.VARIABLE, wish)
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: set(range(cores)), raising=False)
    monkeypatch.setattr(os, "getloadavg", lambda: (load, load, load), raising=False)
    assert background._may_start() == starts


def test_what_is_no_number_of_compilers(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    """Said, and no second process."""
    monkeypatch.setattr("lcpflex.jit.cache_folders._said", set())
    for wish in ("0", "3", "abc"):
        monkeypatch.setenv(background.VARIABLE, wish)
        assert not background._may_start()
        assert f"LCPFLEX_COMPILERS is {wish!r}, expected 1 or 2" in capsys.readouterr().err


@pytest.mark.parametrize("program", [None, "", "/usr/bin/freecad"])
def test_no_second_program(program: str | None, monkeypatch: pytest.MonkeyPatch) -> None:
    """What has a Python inside is not started once more."""
    monkeypatch.setenv(background.VARIABLE, "2")
    monkeypatch.setattr(sys, "executable", program)
    assert not background._may_start()


@pytest.mark.parametrize(
    "damage", ["no JSON", '{"runs": {"a": ["lcpflex.gone:f Gone"]}, "structs": {}, "modules": []}', "{}"]
)
def test_a_list_that_no_longer_fits(damage: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """All is compiled as without it: no error, and no second process."""
    (tmp_path / "list").write_text(damage)
    monkeypatch.setattr(manifest, "FILE", tmp_path / "list")
    monkeypatch.setenv(background.VARIABLE, "2")
    for kept in (manifest._read, manifest._types):
        kept.cache_clear()
    try:
        with background.expecting("a"):
            background.assist()
        background.compile_all_listed(list)
        assert background._started == []
    finally:
        for kept in (manifest._read, manifest._types):
            kept.cache_clear()


FORK = """
import os, sys
from lcpflex.jit import background
process = background._start("plane MoreauJean")
child = os.fork()
if child == 0:
    sys.stdin.read()  # until the parent of this one has seen the end of the second process
    os._exit(0)
process.stdin.close()
print(process.wait(30.0))
background._started.clear()
"""


@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_a_fork_does_not_hold_the_second_process(tmp_path: Path) -> None:
    """It has the pipe, too, and closes it."""
    process = subprocess.Popen(
        [sys.executable, "-W", "ignore", "-c", FORK],
        env=environment(tmp_path, "2"),
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    assert process.stdout is not None
    assert process.stdout.readline() == "0\n"
    process.communicate()


KEYS = """
import importlib, pkgutil
import lcpflex
from lcpflex.jit import keys, manifest
from numba.core.registry import cpu_target
codegen = cpu_target.target_context.codegen()

def names(entries):
    return [next(entry.dispatcher()._cache._keys(entry.arguments, codegen)) for entry in entries]

manifest.load_modules()
entries = manifest.all_entries()
one = names(entries)
for found in pkgutil.walk_packages(lcpflex.__path__, "lcpflex."):
    if not found.name.endswith("__main__"):
        importlib.import_module(found.name)
other = names(entries)
keys.content.cache_clear()
keys._own.cache_clear()
print([str(entry) for entry, a, b, c in zip(entries, one, other, names(entries)) if not a == b == c])
"""


def test_keys_do_not_depend_on_what_is_loaded() -> None:
    """Steppers give kernels to leaves when they are loaded: a key from before that would be that of another kernel."""
    ran = subprocess.run([sys.executable, "-c", KEYS], capture_output=True, text=True)
    assert ran.returncode == 0, ran.stderr
    assert ran.stdout == "[]\n"


def test_types_in_words() -> None:
    """And back: numbers, arrays, tuples, structs, and two structs of one name."""
    array, number = numba.types.Array, numba.float64
    inner = packed_type("Inner", (("n", numba.int64), ("x", array(number, 2, "C"))))
    other = packed_type("Inner", (("n", numba.int64), ("x", array(number, 2, "C", readonly=True))))
    outer = packed_type("Outer", (("a", inner), ("b", other), ("y", array(numba.int64, 1, "A", aligned=False))))
    nested = numba.types.BaseTuple.from_types([number, array(number, 2, "C"), numba.types.UniTuple(number, 2)])
    named = numba.types.NamedTuple([number, numba.int64, nested], manifest.Entry)
    pair = numba.types.BaseTuple.from_types([number, number])
    mixed = numba.types.BaseTuple.from_types([number, numba.boolean])
    types = manifest.Types({})
    words = [types.told(kind) for kind in (outer, other, pair, mixed, named, numba.boolean)]
    assert words == ["Outer", "Inner#2", "tuple(float64,float64)", "tuple(float64,bool)", "Entry", "bool"]
    assert types.structs["Entry"].endswith(" arguments:tuple(float64,float64[:,:]C,tuple(float64,float64))")
    again = manifest.Types(json.loads(json.dumps(types.structs)))
    assert [again.made(told) for told in words] == [outer, other, pair, mixed, named, numba.boolean]
    with pytest.raises(ValueError, match="complex"):
        types.told(numba.complex128)


@pytest.mark.skipif(bool(why_not_thin()), reason="numba links the kernels")
def test_listed_kernels_exist() -> None:
    """Each by its name, with types that can be made, in runs of all kinds; ``tests/record_manifest.py`` renews them."""
    entries = manifest.all_entries()
    assert len(entries) > 200
    for entry in entries:
        assert len(entry.arguments) == len(entry.dispatcher().py_func.__code__.co_varnames[: len(entry.arguments)])
        assert entry.dispatcher().py_func.__code__.co_argcount == len(entry.arguments), entry
    assert manifest.entries_of("plane MoreauJean")
    assert manifest.entries_of("space EventDriven")
    assert manifest.entries_of("none such") == []


def declared_structs() -> dict[str, set[frozenset[str]]]:
    """The fields of each struct and named tuple that a module of lcpflex declares, by its name."""
    for module in pkgutil.walk_packages(lcpflex.__path__, "lcpflex."):
        if not module.name.endswith("__main__"):
            import_module(module.name)
    found: dict[str, set[frozenset[str]]] = {}
    kinds = [Packed, tuple]
    while kinds:
        kind: Any = kinds.pop()
        kinds += type.__subclasses__(kind)
        if kind.__module__.startswith("lcpflex."):
            found.setdefault(kind.__name__, set()).add(frozenset(kind.__annotations__))
    return found


def test_listed_structs_are_as_they_are_declared() -> None:
    """A struct with a field more wants ``tests/record_manifest.py``: no kernel listed with it can be compiled."""
    declared = declared_structs()
    assert {"SpatialWorkspace", "SpatialContacts"} <= set(declared)
    stale = {}
    for name, told in manifest._types().structs.items():
        fields = frozenset(field.partition(":")[0] for field in told.split()) - {""}  # a named tuple tells its module
        kinds = declared.get(name.partition("#")[0], set())
        if fields not in kinds:
            stale[name] = [sorted(fields ^ kind) for kind in kinds]
    assert not stale, "run tests/record_manifest.py"
