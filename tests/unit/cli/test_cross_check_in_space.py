"""``lcpflex cross-check`` of contact problems in space."""

import csv

import numpy as np
import pytest

from lcpflex.__main__ import main
from lcpflex.solvers import SpatialContactProblem, save_fclib, save_problems
from tests.cone_problems import puck

PROBLEM = puck([0.5, 0.2, -0.1, 0.0, 0.0, 2.0], feet=3)


def dat(path):
    """The problem in the text form of Siconos."""
    W = PROBLEM.dense()
    words = [3, 3, 0, *W.shape, *W.shape, *W.T.ravel(), *PROBLEM.free, *PROBLEM.friction]
    path.write_text("\n".join(repr(float(w)) if isinstance(w, np.floating) else str(w) for w in words))
    return path


def hdf5(path):
    pytest.importorskip("h5py")
    return save_fclib(path, PROBLEM)


@pytest.mark.parametrize(
    ("name", "write"),
    [("x.npz", lambda path: save_problems(path, [PROBLEM])), ("x.dat", dat), ("x.hdf5", hdf5)],
)
def test_of_any_file(tmp_path, capsys, name, write):
    path = write(tmp_path / name)
    assert main(["cross-check", str(path), "--repeats", "1"]) == 0
    said = capsys.readouterr().out
    assert "another model: friction cone of 8 facets" in said
    assert "another model: convex relaxation" in said
    assert "solvers that solved it agree in the contact velocities" in said
    assert "Lemke solves LCPs: SpatialContactProblem is no LCP" in said


def test_of_many(tmp_path, capsys):
    light = SpatialContactProblem(1e3 * PROBLEM.dense(), PROBLEM.free, PROBLEM.friction)
    path = save_problems(tmp_path / "x.npz", [PROBLEM, light], ["heavy", "light"])
    table = tmp_path / "table.csv"
    options = ["--repeats", "1", "--solver", "ConicFixedPoint", "--solver", "FacetedCone", "--csv", str(table)]
    assert main(["cross-check", str(path), *options]) == 0
    assert "2 problems: no wrong claim, and all who solved a problem agree" in capsys.readouterr().out
    rows = list(csv.DictReader(table.read_text().splitlines()))
    assert {(row["problem"], row["solver"], row["model"]) for row in rows} == {
        (problem, solver, model)
        for problem in ("heavy", "light")
        for solver, model in (("ConicFixedPoint", ""), ("FacetedCone", "friction cone of 8 facets"))
    }
