"""A file is written as a whole or not at all: a disk that is full leaves what was there, and nothing half."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import lcpflex as lf
from lcpflex.basics.whole_file import whole_file
from lcpflex.cli.reading import save_figure
from lcpflex.solvers.benchmark.fclib import save_fclib
from lcpflex.solvers.benchmark.files import save_problems
from tests.full_disk import full_disk
from tests.scenes import disc_on_floor

SMALL = 1000  # bytes


@pytest.fixture(scope="module")
def result() -> lf.Result:
    return lf.simulate(disc_on_floor(0.11, (1.0, 0.0), friction=0.3), 0.1, lf.MoreauJean(1e-3))


def problems(path: Path) -> None:
    random = np.random.default_rng(1)
    save_problems(path, [lf.solvers.Lcp(np.eye(20), random.standard_normal(20)) for _ in range(9)])


HDF5 = (".h5", ".hdf5", ".vtkhdf")
WRITERS: dict[str, Callable[[lf.Result, Path], Any]] = {
    "film.gif": lambda result, path: result.animate(path),
    "result.npz": lambda result, path: result.save(path),
    "result.h5": lambda result, path: result.save(path),
    "scene.vtkhdf": lambda result, path: result.to_vtkhdf(path),
    "problem.hdf5": lambda result, path: save_fclib(
        path, lf.solvers.ContactProblem(np.eye(18), np.ones(18), [0.3] * 9)
    ),
    "problems.npz": lambda result, path: problems(path),
    "figure.png": lambda result, path: save_figure(result.plot(), path),
}


@pytest.mark.parametrize(
    "name", [pytest.param(one, marks=pytest.mark.slow) if one == "film.gif" else one for one in WRITERS]
)
def test_a_full_disk_leaves_nothing_half(name: str, result: lf.Result, tmp_path: Path) -> None:
    if name.endswith(HDF5):
        pytest.importorskip("h5py")
    path = tmp_path / name
    for before in (None, b"older"):
        if before is not None:
            path.write_bytes(before)
        with full_disk(SMALL), pytest.raises(lf.ModelError, match=r"^path: cannot write"):
            WRITERS[name](result, path)
        assert [entry.name for entry in tmp_path.iterdir()] == ([] if before is None else [name])
        assert before is None or path.read_bytes() == before
    WRITERS[name](result, path)
    assert path.stat().st_size > 1000
    assert {entry.name for entry in tmp_path.iterdir()} - {"scene_contacts.vtkhdf"} == {name}


def test_what_breaks_off_leaves_nothing_half(tmp_path: Path) -> None:
    path = tmp_path / "numbers.txt"

    def broken_off(error: type[BaseException]) -> None:
        with whole_file("path", path) as part:
            part.write_text("half")
            raise error

    for error in (ValueError, KeyboardInterrupt):
        with pytest.raises(error):
            broken_off(error)
        assert not list(tmp_path.iterdir())
    with whole_file("path", path) as part:
        assert part.parent == tmp_path
        assert part.suffix == ".txt"
        part.write_text("whole")
    assert path.read_text() == "whole"
    with pytest.raises(lf.ModelError, match=r"^output: .*no folder"), whole_file("output", tmp_path / "a" / "b.txt"):
        pass
