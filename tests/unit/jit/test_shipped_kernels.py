"""Kernels for other machines than the one that compiled them, and for other versions of numba's inner parts."""

from __future__ import annotations

import os
import platform
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from llvmlite import binding

from lcpflex.__main__ import main
from lcpflex.jit import private
from lcpflex.jit.keys import LEVELS, machines
from tests.unit.jit.tiny_kernels import jobs, package

HAS = {name for name, has in binding.get_host_cpu_features().items() if has}
BEST = "x86-64-v3"
ALL = ["held", "held", "held", "middle", "small", "top"]

pytestmark = [
    pytest.mark.skipif(not hasattr(os, "fork"), reason="processes are started in another way"),
    pytest.mark.skipif(platform.machine() != "x86_64", reason="kernels are shipped for x86-64"),
    pytest.mark.skipif(not LEVELS[BEST] <= HAS, reason=f"this machine cannot stand in for {BEST}"),
]


class Shipped:
    """The sources of some kernels, and folders with them for the host and for two kinds of processors."""

    def __init__(self, folder: Path) -> None:
        self.sources = package(folder / "sources")
        self.folder = {level: folder / level for level in LEVELS}
        values = set()
        for level, cache in self.folder.items():
            (run,), _ = jobs(self.sources, case(cache), NUMBA_CPU_NAME=level, NUMBA_CPU_FEATURES="")
            assert sorted(run["compiled"]) == ALL
            values.add(run["value"])
        (self.value,) = values


@pytest.fixture(scope="module")
def shipped(tmp_path_factory: pytest.TempPathFactory) -> Shipped:
    """Kernels as another machine has compiled them."""
    return Shipped(tmp_path_factory.mktemp("shipped"))


def case(cache: Path, package: Path | None = None, **more: str) -> dict[str, Any]:
    """A job with a folder, and another one that stands for that in the package."""
    own = f"import lcpflex.jit.cache_folders as c; c.SHIPPED = c.Path({str(package)!r})" if package else ""
    return {"cache": str(cache), "before": own, **more}


def without(feature: str) -> str:
    """The features of this machine but for one, as numba takes them."""
    return ",".join(f"{'+' if name in HAS and name != feature else '-'}{name}" for name in sorted(HAS | {feature}))


def test_who_runs_what() -> None:
    """A processor runs kernels of a kind if it has all features of that kind."""
    triple = "x86_64-unknown-linux-gnu"
    all_of_them = ",".join(f"+{name}" for name in sorted(LEVELS[BEST]))
    known = [(triple, level, "") for level in LEVELS]
    assert list(machines((triple, "znver9", all_of_them))) == [(triple, "znver9", all_of_them), *known]
    for name in LEVELS[BEST]:
        less = all_of_them.replace(f"+{name}", f"-{name}", 1)
        assert list(machines((triple, "znver9", less)))[1:] == known[1:]
    assert list(machines(("aarch64-unknown-linux-gnu", "apple-m1", all_of_them)))[1:] == []


def test_shipped_kernels(shipped: Shipped, tmp_path: Path) -> None:
    """They run wherever they can, from a folder that is named or from the package, which is not written to."""
    best, least = shipped.folder[BEST], shipped.folder["x86-64"]
    before = sorted(path.name for path in best.iterdir())
    runs, said = jobs(
        shipped.sources, case(best), case(least), case(tmp_path / "empty", best), case(tmp_path / "empty", least)
    )
    assert runs == [{"value": shipped.value, "compiled": []}] * 4
    assert said == ""
    assert sorted(path.name for path in best.iterdir()) == before
    assert not (tmp_path / "empty").exists() or not list((tmp_path / "empty").iterdir())


def test_a_processor_without_a_feature(shipped: Shipped, tmp_path: Path) -> None:
    """Compiles what was made with it, and runs what was not."""
    runs, _ = jobs(
        shipped.sources,
        case(tmp_path / "one", shipped.folder[BEST]),
        case(tmp_path / "other", shipped.folder["x86-64"]),
        NUMBA_CPU_FEATURES=without("avx2"),
    )
    assert [run["value"] for run in runs] == [shipped.value] * 2
    assert sorted(runs[0]["compiled"]) == ALL
    assert runs[1]["compiled"] == []


@pytest.mark.slow
def test_shipped_kernels_beside_own_ones(shipped: Shipped, tmp_path: Path) -> None:
    """What the package lacks is compiled here and calls what it has; an edited kernel is compiled with its callers."""
    part, own = tmp_path / "part", tmp_path / "own"
    part.mkdir()
    for path in sorted(shipped.folder[BEST].iterdir())[::2]:
        (part / path.name).write_bytes(path.read_bytes())
    runs, _ = jobs(shipped.sources, case(own, part), case(own, part))
    assert [run["value"] for run in runs] == [shipped.value] * 2
    assert runs[1]["compiled"] == []
    changed = package(tmp_path / "changed")
    low = changed / "tiny_low.py"
    low.write_text(low.read_text().replace("2.0 * x", "x"))
    os.utime(low, (1e9, 1e9))
    (run,), _ = jobs(changed, case(tmp_path / "anew", shipped.folder[BEST]))
    assert sorted(run["compiled"]) == ["middle", "small", "top"]
    assert float.fromhex(run["value"]) == pytest.approx(float.fromhex(shipped.value) - 0.3)


AGAIN = "private.why_not_thin.cache_clear()"
NAME = f"import llvmlite.binding as b; del b.ObjectFileRef.from_data; {AGAIN}"
HIDDEN = {
    "a name": NAME,
    "a version": f"numba.__version__ = '0.99.0'; {AGAIN}",
    "names of the cache, too": f"del numba.core.caching._Cache; [sys.modules.pop('lcpflex.jit.' + name) for name in "
    f"('plain', 'cache')]; {NAME}",
}


@pytest.mark.parametrize("what", ["a name", *(pytest.param(name, marks=pytest.mark.slow) for name in list(HIDDEN)[1:])])
def test_another_numba_inside(shipped: Shipped, what: str, tmp_path: Path) -> None:
    """Kernels are linked as numba does, which is said once; they are kept where the cache knows how."""
    hidden = {**case(tmp_path / "cache", shipped.folder[BEST]), "cache": str(tmp_path / "cache")}
    hidden["before"] += f"; {HIDDEN[what]}"
    runs, said = jobs(shipped.sources, hidden, hidden)
    assert [run["value"] for run in runs] == [shipped.value] * 2
    assert sorted(runs[0]["compiled"]) == ALL
    if what == "names of the cache, too":
        assert sorted(runs[1]["compiled"]) == ALL
    else:
        assert runs[1]["compiled"] == []
        assert said.count("compiling takes longer") == 1
        assert ("0.99.0 is installed" if what == "a version" else "numba has changed inside") in said


def test_what_is_asked_of_warmup(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Is refused by name before anything is compiled."""
    (tmp_path / "file").write_text("")
    for options, words in (
        (("--target", "x86-64"), ("--target", "without --into")),
        (("--target", "z80", "--into", str(tmp_path)), ("--target", "z80", BEST)),
        (("--into", str(tmp_path / "file" / "below")), ("--into", "written to")),
    ):
        assert main(["warmup", *options]) == 2
        told = capsys.readouterr().err
        assert all(word in told for word in words)


def test_no_target_for_another_numba(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Nor for a machine that would have to run what it cannot."""
    monkeypatch.setattr(private, "why_not_thin", lambda: "it is another one")
    assert main(["warmup", "--target", BEST, "--into", str(tmp_path)]) == 2
    assert "it is another one" in capsys.readouterr().err
    monkeypatch.setattr(private, "why_not_thin", lambda: "")
    monkeypatch.setattr(binding, "get_host_cpu_features", lambda: dict.fromkeys(HAS - {"avx2"}, True))
    assert main(["warmup", "--target", BEST, "--into", str(tmp_path)]) == 2
    assert "lacks avx2" in capsys.readouterr().err


@pytest.mark.slow
def test_the_whole_library_for_all_processors(tmp_path: Path) -> None:
    """A folder that `lcpflex warmup --into` has filled is whole: nothing is compiled, and nothing left to write."""
    folder = tmp_path / "kernels"
    command = [sys.executable, "-m", "lcpflex", "warmup"]
    filled = subprocess.run([*command, "--target", "x86-64", "--into", str(folder)], capture_output=True, text=True)
    assert filled.returncode == 0, filled.stderr
    names = sorted(path.name for path in folder.iterdir())
    # Of the plane, and of space with its contacts: 37.4e6 where it was measured, 8e6 of these patches and cylinders.
    assert sum(path.stat().st_size for path in folder.iterdir()) < 45e6
    empty = tmp_path / "empty"
    environment = {**os.environ, "LCPFLEX_CACHE_PATH": f"{empty}{os.pathsep}{folder}"}
    again = subprocess.run(command, env=environment, capture_output=True, text=True)
    assert again.returncode == 0, again.stderr
    assert "compiling its kernels" not in again.stderr
    assert not empty.exists() or not list(empty.iterdir())  # made for the first file
    assert sorted(path.name for path in folder.iterdir()) == names
