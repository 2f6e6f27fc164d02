"""The spatial problems with Siconos' own tests: small ones are kept here, the others need a copy of its folder.

SICONOS_DATA is `numerics/src/FrictionContact/test/data` of <https://github.com/siconos/siconos>; where it is not set
the large ones are skipped. `pytest -m slow -s` prints the table: name, contacts, residuals, time.
"""

import os
from pathlib import Path
from time import perf_counter

import numpy as np
import pytest

from lcpflex.solvers import AlartCurnier, SpatialContactProblem, Status, load_fclib, load_siconos_contacts

KEPT = Path(__file__).parent / "siconos" / "space"
FOLDER = os.environ.get("SICONOS_DATA", "")
HARD = "RockPile_tob1.dat"  # 463 contacts, 743 of 1389 rows independent, friction 1
CONTACTS = {
    "Box_Stacks-i0122-82-5.hdf5": 82,
    "BoxesStack1-i100000-32.hdf5.dat": 52,
    "Capsules-i100-1090.dat": 276,
    "Capsules-i100-889.dat": 276,
    "Capsules-i101-404.dat": 225,
    "Capsules-i103-990.dat": 275,
    "Capsules-i122-1617.dat": 296,
    "Capsules-i125-1213.hdf5": 286,
    "Confeti-ex03-Fc3D-SBM.dat": 54,
    "Confeti-ex13-4contact-Fc3D-SBM.dat": 4,
    "Confeti-ex13-Fc3D-SBM.dat": 107,
    "FC3D_Example1.dat": 3,
    "FC3D_Example1_SBM.dat": 3,
    "FrictionContact3D_1c.dat": 1,
    "FrictionContact3D_RR_1c.dat": 1,
    "GFC3D_Example0.dat": 1,
    "GFC3D_Example00.dat": 1,
    "GFC3D_Example00_badly_scaled.dat": 1,
    "GFC3D_Example0_SBM.dat": 1,
    "GFC3D_Example1.dat": 1,
    "GFC3D_OneContact.dat": 1,
    "GFC3D_TwoRods1-condensed.dat": 3,
    "GFC3D_TwoRods1.dat": 3,
    "KaplasTower-i1061-4.hdf5.dat": 570,
    "LMGC_100_PR_PerioBox-i00361-60-03000.hdf5": 60,
    "NESpheres_10_1.dat": 9,
    "NESpheres_30_1.dat": 44,
    "OneObject-i100000-316.hdf5.dat": 25,
    "OneObject-i100000-499.hdf5.dat": 24,
    "OneObject-i1028-138.hdf5.dat": 23,
    "Rover1039.dat": 4,
    "Rover1040.dat": 5,
    "Rover1041.dat": 5,
    "Rover11035.dat": 1,
    "Rover11211.dat": 1,
    "Rover3865.dat": 5,
    "Rover4144.dat": 4,
    "Rover4396.dat": 2,
    "Rover4493.dat": 4,
    "Rover4516.dat": 4,
    "Rover4609.dat": 5,
    "Rover4613.dat": 5,
    "Rover4622.dat": 4,
    "Rover9770.dat": 5,
    "spheres-in-a-box-98-i10000-256-10.hdf5": 256,
}


def load(path):
    problem = load_fclib(path) if path.suffix == ".hdf5" else load_siconos_contacts(path)
    assert isinstance(problem, SpatialContactProblem)
    return problem


def folder():
    if not FOLDER:
        pytest.skip("SICONOS_DATA is not set: expected numerics/src/FrictionContact/test/data of Siconos")
    return Path(FOLDER)


def siconos_residual(problem, forces):
    """|r - P_K(r - rho (u + mu |u_T| n))| / |q|, rho = 1: the natural map of Siconos, in the units of the file."""
    u, r, mu = problem.velocity(forces).reshape(-1, 3), forces.reshape(-1, 3), problem.friction
    x = r - u
    x[:, 0] -= mu * np.hypot(u[:, 1], u[:, 2])
    slip = np.hypot(x[:, 1], x[:, 2])
    normal = np.where(mu * slip <= -x[:, 0], 0.0, (x[:, 0] + mu * slip) / (1.0 + mu * mu))
    shrink = mu * normal / np.maximum(slip, 1e-300)
    edge = np.column_stack([normal, x[:, 1] * shrink, x[:, 2] * shrink])
    nearest = np.where((slip <= mu * x[:, 0])[:, None], x, edge)
    return np.linalg.norm(r - nearest) / np.linalg.norm(problem.free)


@pytest.mark.parametrize("path", sorted(KEPT.glob("*.dat")), ids=lambda path: path.name)
def test_those_that_are_kept(path):
    problem = load(path)
    assert len(problem.friction) == CONTACTS[path.name]
    found = AlartCurnier().solve(problem)
    assert found.solved
    assert found.strict <= 1e-12
    assert siconos_residual(problem, found.z) <= 1e-10


@pytest.mark.slow
def test_all_but_the_hardest_within_two_minutes():
    place = folder()
    spent, missed = 0.0, []
    print()
    for name, contacts in CONTACTS.items():
        problem = load(place / name)
        assert len(problem.friction) == contacts
        began = perf_counter()
        found = AlartCurnier().solve(problem)
        seconds = perf_counter() - began
        spent += seconds
        theirs = siconos_residual(problem, found.z)
        print(
            f"{name:42s} {contacts:4d} {found.residual:8.1e} {found.strict:8.1e} {theirs:8.1e} {1e3 * seconds:9.2f} ms"
        )
        if not (found.solved and found.strict <= 1e-10):
            missed.append(name)
    print(f"{len(CONTACTS)} problems, {spent:.1f} s")
    assert missed == []
    assert spent <= 120.0


@pytest.mark.campaign
def test_the_hardest_is_told_as_it_is():
    problem = load(folder() / HARD)
    found = AlartCurnier().solve(problem)
    assert found.status in (Status.SOLVED, Status.INACCURATE)
    assert found.residual <= 1e-7
