"""Kernels that call others instead of taking them in: the same numbers, whatever became of the files."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from lcpflex.jit.kernel_file import ENDING, KernelFile, thin_out
from lcpflex.jit.private import why_not_thin
from tests.unit.jit.tiny_kernels import LOW, jobs, package

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="processes are started in another way")

ALL = ["held", "held", "held", "middle", "small", "top"]  # three overloads of `held`: for an int, a float, a bool


LITERALS = """
from lcpflex.jit.kernel import kernel

@kernel
def share(n, whole):
    return 1.0 * n if whole else 0.5 * n

@kernel
def calls(n):
    return share(1, True) + share(n, True) + share(6, whole=False) + share(2, n < 0)
"""


PAIRS = """
import math
from lcpflex.jit.kernel import kernel

@kernel
def farther(pair):
    total = 0.0
    for i in range(7):
        total += math.exp(math.sin(pair[0] * i)) / (pair[1] + i)
    return total

@kernel
def calls(x):
    return farther((x, 1.0))
"""


class Filled:
    """The sources, a folder with their kernels, and what they give."""

    def __init__(self, folder: Path) -> None:
        self.sources = package(folder / "sources")
        self.cache = folder / "cache"
        ((first, plain), self.said) = jobs(
            self.sources, case(self.cache), case(folder / "plain", before="private.why_not_thin = lambda: 'hidden'")
        )
        assert sorted(first["compiled"]) == sorted(plain["compiled"]) == ALL
        assert first["value"] == plain["value"]  # linked in or called: the same bits
        self.value = first["value"]
        self.files = {path.name: path.read_bytes() for path in self.cache.iterdir()}

    def copy(self, folder: Path) -> Path:
        """Another folder with the same kernels."""
        folder.mkdir()
        for name, data in self.files.items():
            (folder / name).write_bytes(data)
        return folder


@pytest.fixture(scope="module")
def filled(tmp_path_factory: pytest.TempPathFactory) -> Filled:
    """Kernels that one process has compiled."""
    return Filled(tmp_path_factory.mktemp("tiny"))


def case(cache: Path, **more: str) -> dict[str, Any]:
    """A job with this folder."""
    return {"cache": str(cache), **more}


def test_numba_is_the_one_that_thin_linking_was_written_for() -> None:
    """Fails when numba is upgraded: then its inner parts are to be looked at, and this module run."""
    assert why_not_thin() == ""


def test_files(filled: Filled) -> None:
    """One for each overload, and one for Python's call of the outermost; nothing else."""
    assert len(filled.files) == len(ALL) + 1
    assert all(name.endswith(ENDING) for name in filled.files)
    kept = [KernelFile.unpacked(data, Path(name).stem) for name, data in filled.files.items()]
    assert all(kept)
    assert sum(file is not None and file.big for file in kept) >= 4
    names = [name for file in kept if file is not None for name in file.defined if "NumbaEnv" not in name]
    assert len(names) == len(set(names)) == len(kept)  # each has one function for others


def test_a_literal_is_a_number_like_any_other(filled: Filled, tmp_path: Path) -> None:
    """A callee is compiled for the type of what it is given, not once more for each number that is written there."""
    (filled.sources / "tiny_literals.py").write_text(LITERALS)
    hidden = "private.why_not_thin = lambda: 'hidden'\n"
    before = "from lcpflex.tiny_literals import calls\n"
    runs, _ = jobs(
        filled.sources,
        case(tmp_path / "one", before=before, value="calls(2)"),
        case(tmp_path / "two", before=hidden + before, value="calls(2)"),
    )
    assert [sorted(run["compiled"]) for run in runs] == 2 * [["calls", "share"]]
    assert runs[0]["value"] == runs[1]["value"] == (1.0 + 2.0 + 3.0 + 1.0).hex()


def test_what_python_packs_is_taken_apart_where_nothing_else_is_compiled(filled: Filled, tmp_path: Path) -> None:
    """A kernel that only another one called so far is kept; Python's call of it, with a tuple, is made now."""
    path = filled.sources / "tiny_pairs.py"
    path.write_text(PAIRS)
    os.utime(path, (1e9, 1e9))
    before = "from lcpflex.tiny_pairs import calls, farther\n"
    runs, _ = jobs(
        filled.sources,
        case(tmp_path / "one", before=before, value="calls(0.5)"),
        case(tmp_path / "one", before=before, value="farther((0.5, 1.0))"),
    )
    assert [sorted(run["compiled"]) for run in runs] == [["calls", "farther"], []]
    assert runs[0]["value"] == runs[1]["value"]


def test_a_filled_folder_is_enough(filled: Filled, tmp_path: Path) -> None:
    """Also for kernels that only others called so far, before and after these have."""
    inner = "lcpflex.tiny_low.held(0.3, 1) + 0 * top(0.3, 2)"
    outer = "0 * top(0.3, 2) + lcpflex.tiny_low.held(0.3, 1)"
    one, other = filled.copy(tmp_path / "one"), filled.copy(tmp_path / "other")
    (again, before, after), said = jobs(
        filled.sources, case(filled.cache), case(one, value=inner), case(other, value=outer)
    )
    assert again == {"value": filled.value, "compiled": []}
    assert before["value"] == after["value"]
    assert before["compiled"] == after["compiled"] == []
    assert said == ""
    assert sorted(path.name for path in one.iterdir()) == sorted(path.name for path in other.iterdir())
    assert len(list(one.iterdir())) == len(filled.files) + 1  # Python's call of the inner one


DAMAGES = ("cut", "flipped", "empty", "swapped", "gone")


def damaged(filled: Filled, folder: Path, name: str, damage: str) -> Path:
    """A folder with one file spoilt."""
    cache = filled.copy(folder)
    data = filled.files[name]
    middle = len(data) // 2
    other = next(data for key, data in filled.files.items() if key != name)
    flipped = data[:middle] + bytes([data[middle] ^ 1]) + data[middle + 1 :]
    path = cache / name
    path.write_bytes({"cut": data[:middle], "flipped": flipped, "empty": b"", "swapped": other}.get(damage, b""))
    if damage == "gone":
        path.unlink()
    return cache


def check_damaged(filled: Filled, folder: Path, cases: list[tuple[str, str]]) -> None:
    """Spoilt files are compiled again, and then there."""
    caches = [damaged(filled, folder / f"{n}", name, damage) for n, (name, damage) in enumerate(cases)]
    runs, _ = jobs(filled.sources, *(case(cache) for cache in caches for _ in range(2)))
    assert {run["value"] for run in runs} == {filled.value}
    assert [run["compiled"] for run in runs[1::2]] == [[]] * len(caches)


@pytest.mark.slow
def test_damaged_files(filled: Filled, tmp_path: Path) -> None:
    """One file, in each way."""
    check_damaged(filled, tmp_path, list(zip(sorted(filled.files), DAMAGES, strict=False)))


@pytest.mark.slow
def test_each_damaged_file(filled: Filled, tmp_path: Path) -> None:
    """All files, in all ways."""
    check_damaged(filled, tmp_path, [(name, damage) for name in sorted(filled.files) for damage in DAMAGES])


@pytest.mark.slow
def test_half_of_the_files(filled: Filled, tmp_path: Path) -> None:
    """Any mix of files is complete or compiled, never wrong."""
    caches = []
    for part in (0, 1):
        caches.append(filled.copy(tmp_path / str(part)))
        for name in sorted(filled.files)[part::2]:
            (caches[-1] / name).unlink()
    runs, _ = jobs(filled.sources, *(case(cache) for cache in caches for _ in range(2)))
    assert {run["value"] for run in runs} == {filled.value}
    assert runs[1]["compiled"] == runs[3]["compiled"] == []


def test_a_symbol_that_is_not_there(filled: Filled, tmp_path: Path) -> None:
    """LLVM would end the process; the kernel is compiled."""
    cache = filled.copy(tmp_path / "cache")
    for name, data in filled.files.items():
        file = KernelFile.unpacked(data, Path(name).stem)
        assert file is not None
        (cache / name).write_bytes(replace(file, outside=(*file.outside, "no_such_symbol")).packed())
    (run,), _ = jobs(filled.sources, case(cache))
    assert run["value"] == filled.value
    assert sorted(run["compiled"]) == ALL


def test_edits(filled: Filled, tmp_path: Path) -> None:
    """A callee that was edited is compiled anew with all its callers, and nothing else."""
    for number, (old, new, compiled, more) in enumerate(
        (
            ("2.0 * x", "3.0 * x", ["middle", "small", "top"], 0.3),
            ("(1.0 + k + i)", "(1.0 + k + i)  # the same", [], 0.0),
        )
    ):
        changed = package(tmp_path / f"changed {number}")
        low = changed / "tiny_low.py"
        low.write_text(LOW.replace(old, new))
        os.utime(low, (1e9, 1e9))
        (run,), _ = jobs(changed, case(filled.copy(tmp_path / f"cache {number}")))
        assert sorted(run["compiled"]) == compiled
        assert float.fromhex(run["value"]) == pytest.approx(float.fromhex(filled.value) + more, rel=1e-15)


def test_edits_after_the_import(filled: Filled, tmp_path: Path) -> None:
    """What a process has imported runs in it, and is not mixed up with what was written later."""
    edited = package(tmp_path / "edited")
    path = str(edited / "tiny_low.py")
    late = f"import lcpflex.tiny_high; open({path!r}, 'w').write({LOW.replace('2.0 * x', '3.0 * x')!r})"
    (before, after), _ = jobs(edited, case(tmp_path / "cache", before=late), case(tmp_path / "cache"))
    assert before["value"] == filled.value
    assert float.fromhex(after["value"]) == pytest.approx(float.fromhex(filled.value) + 0.3, rel=1e-15)
    assert sorted(after["compiled"]) == ["middle", "small", "top"]


SHARED = """
import math
from lcpflex.jit.kernel import kernel

@kernel
def shared(x, data):
    total = 0.0
    kind = data[0]
    if kind == 0:
        total += math.exp(x) + math.sin(x) / (1.0 + math.cos(x) ** 2)
    elif kind == 1:
        total += math.log(1.0 + x * x) + math.sqrt(2.0 + math.tanh(x))
    else:
        total += math.atan(x) * math.sinh(x) - math.cosh(x) + math.erf(x)
    for i in range(5):
        total += math.sin(total * i) * math.exp(-total) / (1.0 + math.cos(i + total) ** 2)
    return total

@kernel
def twice(x, data):
    return shared(x, data) + shared(2.0 * x, data)

@kernel
def caller(x, data):
    return twice(x, data) - twice(3.0 * x, data) + twice(x - 1.0, data)
"""


@pytest.mark.slow
def test_a_kernel_that_callers_have_a_copy_of(filled: Filled, tmp_path: Path) -> None:
    """What LLVM has made of the copy, some arguments gone, is never called in place of the kernel."""
    (filled.sources / "tiny_shared.py").write_text(SHARED)
    names = "import numpy as np; thin.LARGEST = 400; from lcpflex.tiny_shared import shared, caller; x = np.ones(3)"
    first, last = "shared(0.3, x) + 0 * caller(0.3, x)", "0 * caller(0.3, x) + shared(0.3, x)"
    values = "shared.py_func(0.3, x)", first, last, first, last
    caches = [tmp_path / name for name in ("none", "one", "other", "other", "one")]
    runs, _ = jobs(filled.sources, *(case(c, before=names, value=v) for c, v in zip(caches, values, strict=True)))
    assert len({run["value"] for run in runs[1:]}) == 1
    assert float.fromhex(runs[1]["value"]) == pytest.approx(float.fromhex(runs[0]["value"]), rel=1e-14)
    files = [KernelFile.unpacked(path.read_bytes(), path.stem) for path in caches[1].iterdir()]
    known = {name for file in files if file is not None for name in file.symbols}
    assert len(files) == len(known) == 5
    for file in files:
        assert file is not None
        assert {name for name in known if name.encode() in file.code} == {*file.symbols, *file.needs}


USER = """
import numba
from lcpflex.tiny_high import top
from lcpflex.tiny_low import small

@numba.njit(cache=True)
def outer(x, n):
    return top(x, n)

@numba.njit(cache=True)
def of_small(x):
    return small(x)
"""


@pytest.mark.slow
def test_functions_of_users_that_call_kernels(filled: Filled, tmp_path: Path) -> None:
    """Numba keeps those that have all code in them, and compiles the others in each process."""
    (tmp_path / "user_tool.py").write_text(USER)
    use = case(
        filled.cache,
        before=f"sys.path.insert(0, {str(tmp_path)!r}); import user_tool",
        value="user_tool.outer(0.3, 2) + 0 * user_tool.of_small(0.3)",
    )
    runs, said = jobs(filled.sources, use, use, NUMBA_CACHE_DIR=str(tmp_path / "numba"))
    assert [run["value"] for run in runs] == [filled.value] * 2
    assert runs[0]["compiled"] == ["outer", "of_small"]
    assert runs[1]["compiled"] == ["outer"]
    assert 'Cannot cache compiled function "outer"' in said


THREADS = """
import threading, lcpflex.tiny_high
started, found = threading.Barrier(4), []
def work():
    started.wait()
    found.append(lcpflex.tiny_high.top(0.3, 2))
threads = [threading.Thread(target=work) for _ in range(4)]
[thread.start() for thread in threads]
[thread.join() for thread in threads]
assert len(set(found)) == 1
"""
RELOADED = """
import importlib, lcpflex.tiny_low, lcpflex.tiny_high
lcpflex.tiny_high.top(0.3, 2)
compiled.clear()
importlib.reload(lcpflex.tiny_low)
importlib.reload(lcpflex.tiny_high)
"""


@pytest.mark.slow
def test_threads_and_modules_that_are_loaded_again(filled: Filled, tmp_path: Path) -> None:
    """Each kernel is compiled once, whether a folder keeps it or not."""
    for cache in (tmp_path / "cache", Path("/dev/null/none")):
        (threads, reloaded), _ = jobs(filled.sources, case(cache, before=THREADS), case(cache, before=RELOADED))
        assert threads["value"] == reloaded["value"] == filled.value
        assert sorted(threads["compiled"]) == ALL
        assert reloaded["compiled"] == []


INTERRUPTED = """
import gc
import lcpflex.tiny_high, lcpflex.jit.thin_dispatcher as dispatcher
from lcpflex.jit import loading, thin
from lcpflex.jit.cache import KernelCache
plain, left = {place}, [{count}]
def broken(*given, **named):
    left[0] -= 1
    if left[0] == 0:
        raise KeyboardInterrupt
    return plain(*given, **named)
{place} = broken
try:
    lcpflex.tiny_high.top(0.3, 2)
except KeyboardInterrupt:
    pass
assert gc.isenabled()
"""
PLACES = (
    "thin.ThinLibrary._optimize_final_module",
    "thin.ThinLibrary._finalize_final_module",
    "dispatcher.ThinDispatcher.add_overload",
    "dispatcher._python_face",
    "loading.file_of",
    "KernelCache.save_overload",
)


@pytest.mark.slow
@pytest.mark.parametrize("cache", ["cache", "/dev/null/none"])
def test_interrupted(filled: Filled, cache: str, tmp_path: Path) -> None:
    """Whatever Ctrl-C has left in the engine, the next call is right."""
    interrupted = [INTERRUPTED.format(place=place, count=count) for place in PLACES for count in (1, 2, 4, 6)]
    cases = [case(tmp_path / f"{n}" / cache, before=before) for n, before in enumerate(interrupted)]
    runs, _ = jobs(filled.sources, *cases)
    assert {run["value"] for run in runs} == {filled.value}


def test_folders_do_not_grow_without_end(tmp_path: Path) -> None:
    """The oldest files go first, others stay."""
    for n in range(10):
        path = tmp_path / f"{n}{ENDING}"
        path.write_bytes(b"x" * 100)
        os.utime(path, (1e9 + n, 1e9 + n))
    (tmp_path / "else").write_bytes(b"x" * 1000)
    thin_out(tmp_path, 1000)
    assert len(list(tmp_path.iterdir())) == 11
    thin_out(tmp_path, 900)
    assert sorted(path.name for path in tmp_path.iterdir()) == [*(f"{n}{ENDING}" for n in range(6, 10)), "else"]
