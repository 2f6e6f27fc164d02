"""Kernels that are compiled when they are first called, by compiled code as well."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import pytest

from tests.unit.jit.tiny_kernels import jobs, package

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="processes are started in another way")

SOURCE = """
from __future__ import annotations
import math
from lcpflex.jit.kernel import kernel, late_kernel

@kernel
def deep(x, data):
    for i in range(len(data)):
        data[i] += math.sin(x)

@late_kernel
def rare(x: float, data) -> None:
    deep(x, data)
    data[0] += share(x, 4)

@late_kernel
def share(x: float, n: int) -> float:
    return x / n

@late_kernel
def pair(x: float) -> tuple[bool, float]:
    return x > 1.5, 2.0 * x

@late_kernel
def wrong(x: float) -> int:
    return 0.5 * x

@kernel
def small(x, data):
    if x > 1.0:
        rare(x, data)
        above, twice = pair(x)
        return twice if above else 0.0
    return share(x, 2) if x > 0.0 else 0.0

@kernel
def top(x, data):
    if x > 2.0:
        rare(x, data)
    if x > 5.0:
        return float(wrong(x))
    return small(x, data) + 3.0 * small(0.5 * x, data) + data[0] + data[1]
"""
USE = "import numpy as np; thin.LARGEST = 400; import lcpflex.tiny_late as late_ones; from lcpflex.jit import late\n"
RARE = ["deep", "pair", "rare", "share"]


@pytest.fixture(scope="module")
def sources(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the kernels."""
    folder = package(tmp_path_factory.mktemp("late") / "sources")
    (folder / "tiny_late.py").write_text(SOURCE)
    return folder


def case(cache: Path, x: float, before: str = "", what: str = "top") -> dict[str, Any]:
    """A job: ``top`` at x, after ``before``."""
    return {"cache": str(cache), "before": USE + before, "value": f"late_ones.{what}({x}, np.ones(2))"}


def test_what_is_not_called_is_not_compiled(sources: Path, tmp_path: Path) -> None:
    """And what is called, once; the numbers are those of Python."""
    points = -1.0, 0.5, 1.5, 3.0
    runs, _ = jobs(sources, *(case(tmp_path, x) for x in points), *(case(tmp_path, x) for x in points))
    plain, _ = jobs(sources, *(case(tmp_path, x, what="top.py_func") for x in points))
    assert [run["value"] for run in runs] == 2 * [run["value"] for run in plain]
    compiled = [sorted(run["compiled"]) for run in runs]
    assert compiled == [["small", "top"], ["share"], ["deep", "pair", "rare"], [], [], [], [], []]


@pytest.mark.slow
def test_without_thin_linking(sources: Path, tmp_path: Path) -> None:
    """They are kernels as all others."""
    plain = "private.why_not_thin = lambda: 'hidden'\n"
    runs, _ = jobs(sources, case(tmp_path / "one", 3.0), {**case(tmp_path / "two", 3.0), "before": plain + USE})
    assert runs[0]["value"] == runs[1]["value"]


@pytest.mark.slow
def test_all_ahead_of_time(sources: Path, tmp_path: Path) -> None:
    """Whether what calls them was compiled in the process or before it."""
    first = "late_ones.top(-1.0, np.ones(2))\n"
    right = SOURCE.replace("-> int", "-> float")
    (sources.parent / "right").mkdir()
    (sources.parent / "right" / "tiny_late.py").write_text(right)
    (sources.parent / "right" / "tiny_high.py").write_text((sources / "tiny_high.py").read_text())
    (sources.parent / "right" / "tiny_low.py").write_text((sources / "tiny_low.py").read_text())
    one, other = tmp_path / "one", tmp_path / "other"
    everything = first + "late.compile_all()"
    runs, _ = jobs(
        sources.parent / "right",
        case(one, -1.0, everything),
        case(one, 6.0),
        case(other, -1.0),
        case(other, -1.0, everything),
        case(other, 6.0),
    )
    assert sorted(runs[0]["compiled"]) == sorted([*RARE, "small", "top", "wrong"])
    assert sorted(runs[3]["compiled"]) == sorted([*RARE, "wrong"])
    assert runs[1]["compiled"] == runs[4]["compiled"] == []


def test_a_kernel_that_does_not_compile(sources: Path, tmp_path: Path) -> None:
    """An exception that tells why, not a crash, and the next call is right."""
    failing = """
try:
    late_ones.top(6.0, np.ones(2))
except late.LcpflexError as error:
    assert isinstance(error.__cause__, TypeError) and "returns float64, not int64" in str(error), error
else:
    raise AssertionError
"""
    (run, plain), _ = jobs(sources, case(tmp_path, 3.0, failing), case(tmp_path, 3.0))
    assert run["value"] == plain["value"]


def test_ctrl_c(sources: Path, tmp_path: Path) -> None:
    """It takes effect when the kernel that was asked for is there."""
    interrupted = """
import signal
signal.signal(signal.SIGINT, signal.default_int_handler)  # jobs in the background ignore it
known, left = late._address, [2]
def broken(call):
    left[0] -= 1
    if left[0] >= 0:
        raise KeyboardInterrupt
    return known(call)
late._address = broken
data = np.ones(2)
try:
    late_ones.top(3.0, data)
    for _ in range(1000):
        __import__("time").sleep(0.01)
except KeyboardInterrupt:
    assert data[0] > 1.0
else:
    raise AssertionError
"""
    (run, plain), _ = jobs(sources, case(tmp_path, 3.0, interrupted), case(tmp_path, 3.0))
    assert run["value"] == plain["value"]


@pytest.mark.slow
def test_threads(sources: Path, tmp_path: Path) -> None:
    """That ask for the same ones at the same time, without the interpreter's lock."""
    threads = """
import threading
late_ones.top(-1.0, np.ones(2))
started, found = threading.Barrier(4), []
def work():
    started.wait()
    found.append(late_ones.top(3.0, np.ones(2)))
threads = [threading.Thread(target=work) for _ in range(4)]
[thread.start() for thread in threads]
[thread.join() for thread in threads]
assert len(set(found)) == 1, found
"""
    for cache in (tmp_path / "cache", Path("/dev/null/none")):
        (run, plain), _ = jobs(sources, case(cache, 3.0, threads), case(cache, 3.0))
        assert run["value"] == plain["value"]
        assert sorted(run["compiled"]) == sorted([*RARE, "small", "top"])


@pytest.mark.slow
def test_lost_files(sources: Path, tmp_path: Path) -> None:
    """Each of them, one at a time: the kernels are compiled again."""
    cache = tmp_path / "cache"
    (full,), _ = jobs(sources, case(cache, 3.0))
    for path in sorted(cache.iterdir()):
        path.unlink()
        runs, _ = jobs(sources, case(cache, 3.0), case(cache, 3.0))
        assert {run["value"] for run in runs} == {full["value"]}
        assert runs[1]["compiled"] == []


USER = """
import numba, numpy as np
from lcpflex.tiny_late import share, small

@numba.njit(cache=True)
def directly(x):
    return share(x, 2) + share(2.0 * x, 4)

@numba.njit(cache=True)
def through(x, data):
    return small(x, data)
"""


@pytest.mark.slow
def test_functions_of_users(sources: Path, tmp_path: Path) -> None:
    """Numba does not keep them, for a call holds in its own process only."""
    (tmp_path / "user_late.py").write_text(USER)
    before = f"sys.path.insert(0, {str(tmp_path)!r}); import user_late"
    value = "user_late.directly(0.5) + 100.0 * user_late.through(3.0, np.ones(2))"
    use = {**case(tmp_path / "cache", 3.0, before), "value": value}
    plain = {**use, "value": value.replace("(0.5)", ".py_func(0.5)").replace("(3.0", ".py_func(3.0")}
    runs, said = jobs(sources, use, use, plain, NUMBA_CACHE_DIR=str(tmp_path / "numba"))
    assert len({run["value"] for run in runs}) == 1
    assert sorted(runs[1]["compiled"]) == ["directly", "through"]
    assert said.count("Cannot cache compiled function") >= 2
