"""The spatial problems with Siconos' own tests: small ones are kept here, the others need a copy of its folder.

SICONOS_DATA is `numerics/src/FrictionContact/test/data` of <https://github.com/siconos/siconos>; where it is not set
the large ones are skipped. All are named in `tests/siconos_in_space.py`, which prints the table of ACCURACY.md.
"""

import os
import time
from pathlib import Path

import pytest

import lcpflex
from lcpflex.solvers import AlartCurnier, Auto
from tests.siconos_in_space import CONTACTS, HARD, answered, load, siconos_residual

KEPT = Path(__file__).parent / "siconos" / "space"
FOLDER = os.environ.get("SICONOS_DATA", "")
SOLVED = ("SOLVED", "NOT_UNIQUE")


def folder():
    if not FOLDER:
        pytest.skip("SICONOS_DATA is not set: expected numerics/src/FrictionContact/test/data of Siconos")
    return Path(FOLDER)


@pytest.mark.parametrize("solver", [AlartCurnier(), Auto(tolerance=1e-13)], ids=lambda solver: type(solver).__name__)
@pytest.mark.parametrize("path", sorted(KEPT.glob("*.dat")), ids=lambda path: path.name)
def test_those_that_are_kept(path, solver):
    problem = load(KEPT, path.name)
    found = solver.solve(problem)
    assert found.solved
    assert found.strict <= 1e-12
    assert siconos_residual(problem, found.z) <= 1e-10


def test_the_residual_of_siconos_tells_solutions_from_others():
    problem = load(KEPT, "Rover1040.dat")
    forces = Auto(tolerance=1e-13).solve(problem).z
    assert siconos_residual(problem, forces) < 1e-12
    assert siconos_residual(problem, 1.001 * forces) > 1e-6
    assert siconos_residual(problem, 0.0 * forces) > 1e-3


def test_the_table_names_them_all():
    text = (Path(lcpflex.__file__).parent / "ACCURACY.md").read_text(encoding="utf-8")
    section = text.partition("## Contact problems in space that Siconos ships")[2].partition("\n## ")[0]
    told = [[cell.strip() for cell in line.split("|")[1:5]] for line in section.splitlines() if line.startswith("| ")]
    assert {cells[0]: cells[2] for cells in told[1:]} == {name: str(count) for name, count in CONTACTS.items()}
    assert [cells[0] for cells in told[1:] if cells[3] not in SOLVED] == []


@pytest.mark.slow
def test_the_default_solver_solves_all_but_the_hardest_within_two_minutes():
    """To 1e-10 in the measure of the library; in that of Siconos, whose rounding is up to 1e-10 there, most of them."""
    place, missed, near, began = folder(), [], 0, time.process_time()  # of computing, whoever else is at the machine
    for name in CONTACTS:
        if name != HARD:
            one = answered(load(place, name), name, Auto())
            near += one.theirs <= 1e-10 and one.strict <= 1e-10
            if not (one.status in SOLVED and one.residual <= 1e-10):
                missed.append(one)
    assert missed == []
    assert near >= 40
    assert time.process_time() - began <= 120.0


@pytest.mark.slow
def test_newtons_method_solves_them_too():
    place, missed = folder(), []
    for name in CONTACTS:
        if name != HARD:
            one = answered(load(place, name), name, AlartCurnier())
            if not (one.status in SOLVED and one.strict <= 1e-10):
                missed.append(one)
    assert missed == []


@pytest.mark.campaign
@pytest.mark.parametrize("solver", [Auto(), AlartCurnier()], ids=lambda solver: type(solver).__name__)
def test_the_hardest_is_solved(solver):
    """Proximal points drift along lines of thousands of them: put ahead on these, they arrive within a minute."""
    problem, began = load(folder(), HARD), time.process_time()
    one = answered(problem, HARD, solver)
    assert one.status == "SOLVED"
    assert one.residual <= 1e-10
    assert one.theirs <= 1e-9
    assert time.process_time() - began <= 120.0
